"""How many random examples a test draws: a fixed share of them in the gate, all of them in the longer runs."""

from __future__ import annotations

import os

__all__ = ["examples"]

_ALL = any(os.environ.get(name) for name in ("HILBENCH_EXHAUSTIVE", "HILBENCH_SEARCH"))


def examples(*, in_the_gate: int, in_all: int) -> int:
    """Return the number for `settings(max_examples=...)`."""
    return in_all if _ALL else in_the_gate
