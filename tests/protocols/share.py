"""What the gate tries of a randomised set. `make exhaustive` tries all of it, and so does `make search`."""

from __future__ import annotations

import os

import pytest
from hypothesis import settings

_ALL = bool(os.environ.get("HILBENCH_EXHAUSTIVE") or os.environ.get("HILBENCH_SEARCH"))


def examples(count):
    """Return how many of so many drawn examples are tried: a third in the gate, the same ones every time."""
    return count if _ALL else -(-count // 3)


# For a property that sets nothing else.
drawn = settings(max_examples=examples(100))


def seeds(count, in_gate):
    """Return the seeds of so many stories as parameters, the first of them in the gate."""
    rest = pytest.mark.exhaustive(f"the gate has the first {in_gate} of {count} seeds")
    return [*range(in_gate), *(pytest.param(seed, marks=rest) for seed in range(in_gate, count))]
