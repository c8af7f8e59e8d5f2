"""What a P2OS server must do: every conformance case that a robot, or what takes its place, can be asked.

The cases judge what the line says and ask for nothing that the clause does not; S54 and S56 also need a world that can
be looked at. A docstring tells the trick of a stimulus, and the floor that a robot needs which is driven by it; where
the case is not about contacts or echoes the wheels may be jacked up instead.
"""

from __future__ import annotations

ORDER = (
    "handshake",
    "framing",
    "sips",
    "velocities",
    "positions",
    "stopping",
    "session",
    "requests",
    "settings",
    "commands",
    "wraps",
    "surroundings",
    "families",
    "sequences",
)
