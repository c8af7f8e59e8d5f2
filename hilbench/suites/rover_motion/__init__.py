"""Does a rover do what it is told, and does it say what it does?

Throttles and set points to wheels, wheels to the ground, and what tachometers, inertial sensor and GPS receiver say of
it, against the truth of the world. Each case runs the program on an emulated board with the parts of the bench `rover`
around it, power just on. What a wheel should do is reckoned by the figures of its parts (`_rover_law`).
"""

from __future__ import annotations

ORDER = ("throttles", "set_points", "tachometers", "on_the_floor", "inertial_sensor", "positions", "what_breaks")
