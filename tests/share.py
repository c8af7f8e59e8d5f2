"""What the gate has of random examples, seeds and matrices: a fixed share. The longer runs have all of them."""

from __future__ import annotations

import itertools
import os
from collections.abc import Sequence

import pytest

__all__ = ["ALL", "examples", "few", "matrix", "seeds"]

ALL = any(os.environ.get(name) for name in ("HILBENCH_EXHAUSTIVE", "HILBENCH_SEARCH"))
_REST = pytest.mark.exhaustive("each value with each other one; the gate has each value")


def examples(count: int) -> int:
    """Return how many of so many drawn examples are tried: an eighth in the gate, the same ones every time."""
    return count if ALL else -(-count // 8)


def seeds(count: int, in_gate: int) -> list[object]:
    """Return the seeds of so many stories as parameters, the first of them in the gate."""
    rest = pytest.mark.exhaustive(f"the gate has the first {in_gate} of {count} seeds")
    return [*range(in_gate), *(pytest.param(seed, marks=rest) for seed in range(in_gate, count))]


def few(rows: Sequence[object], in_gate: int, reason: str) -> list[object]:
    """Return rows as parameters, so many of them in the gate, spread evenly over all, and say why not the others.

    Args:
        rows: one or several parameters each.
        in_gate: how many rows the gate has.
        reason: of leaving out the rest.
    """
    chosen = {place * len(rows) // in_gate for place in range(in_gate)}
    rest = pytest.mark.exhaustive(reason)
    return [
        row if number in chosen else pytest.param(*(row if isinstance(row, tuple) else (row,)), marks=rest)
        for number, row in enumerate(rows)
    ]


def matrix(*axes: Sequence[object]) -> list[object]:
    """Return every combination as parameters. The gate has as many as there are values on the longest axis."""
    few = [tuple(step % len(axis) for axis in axes) for step in range(max(map(len, axes)))]
    return [
        pytest.param(
            *(axis[place] for axis, place in zip(axes, places, strict=True)), marks=() if places in few else _REST
        )
        for places in itertools.product(*(range(len(axis)) for axis in axes))
    ]
