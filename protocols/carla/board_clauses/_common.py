"""What entries of the board's catalogue have in common: their suite, sets of profiles, sets of what they need."""

from __future__ import annotations

SUITE = "vehicle-board"

ALL = ("hardened", "v0", "v1")
HARDENED = ("hardened",)
SHIPPED = ("v0", "v1")
NOT_V1 = ("hardened", "v0")
V0_ALONE = ("v0",)
V1_ALONE = ("v1",)

STACK = ("board", "stack")
STICK = ("board", "stack", "joystick")
