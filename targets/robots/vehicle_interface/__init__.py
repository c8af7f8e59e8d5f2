"""A behavioural model of the vehicle-interface board: simulator on one line, driving stack on the other, a joystick.

Bytes and bench time in, bytes out. What the board promises or gets wrong is data: a profile, and defects put into it.
"""

from __future__ import annotations
