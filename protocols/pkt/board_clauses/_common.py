"""What entries of the rover's catalogue have in common: their suite, and sets of profiles."""

from __future__ import annotations

SUITE = "pkt-board"

ALL = ("documented", "term-doc", "g0", "g2")
DOCUMENTED = ("documented",)
TERM = ("term-doc",)
SHIPPED = ("g0", "g2")
G2_ALONE = ("g2",)
LEN = ("documented", "g0", "g2")
V2 = ("documented", "g2")

BY_REPORT = ("server", "motion reports")
"""What it takes to judge the motors by what the rover itself says of them."""
