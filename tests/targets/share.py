"""What the gate has of random examples and of matrices: a fixed share. The longer runs have all of them."""

from __future__ import annotations

import itertools
import os
from collections.abc import Sequence

import pytest

__all__ = ["examples", "matrix"]

_ALL = any(os.environ.get(name) for name in ("HILBENCH_EXHAUSTIVE", "HILBENCH_SEARCH"))
_REST = pytest.mark.exhaustive("each value with each other one; the gate has each value")


def examples(*, in_the_gate: int, in_all: int) -> int:
    """Return the number for `settings(max_examples=...)`."""
    return in_all if _ALL else in_the_gate


def matrix(*axes: Sequence[object]) -> list[object]:
    """Return every combination as parameters. The gate has as many as there are values on the longest axis."""
    few = [tuple(step % len(axis) for axis in axes) for step in range(max(map(len, axes)))]
    return [
        pytest.param(
            *(axis[place] for axis, place in zip(axes, places, strict=True)), marks=() if places in few else _REST
        )
        for places in itertools.product(*(range(len(axis)) for axis in axes))
    ]
