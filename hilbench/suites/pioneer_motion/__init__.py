"""Does the robot do in the world what the protocol says? Each case drives it over the line and judges what it did.

The commands are those of P2OS; the truth is the world's own pose and velocity, at every step of the physics; what is
required follows from formulas and from the exact geometry of the scene. So a wrong scale, a swapped sign or a late
watchdog shows even where the robot's own reports are consistent with themselves.

Only a virtual robot has a truth to look at. Each case begins with a fresh one in the middle of its scene.
"""

from __future__ import annotations

ORDER = ("straight_on", "turning", "limits", "stopping", "odometry", "contacts", "echoes", "uphill")
