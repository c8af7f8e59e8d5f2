"""Reduces what a bench does to a target until nothing more can be left out and the same clause still fails.

The faults on the lines and the stimuli of a bench are halved, and halves of halves left out, by delta debugging
(A. Zeller, R. Hildebrandt, Simplifying and Isolating Failure-Inducing Input, IEEE TSE 28, 2002). What is left is
1-minimal: without any single one of its entries the clause does not fail. Then counts and durations are halved.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

__all__ = ["SHRUNK", "Entries", "Shrinker"]

SHRUNK = ("faults", "stimuli")
"""The lists of a bench file that are reduced."""

_HALVED = {"count": 1, "duration_s": 0.001}
"""Figures of an entry that are made smaller, and where that ends."""

Entries = Mapping[str, Sequence[Any]]
"""By the key of the bench file."""

_One = tuple[str, int]


@dataclass(slots=True)
class Shrinker:
    """Reduces entries.

    Attributes:
        fails: runs the check with some entries, and says whether the clause fails.
        runs: how often that was called; what was tried before is not tried again.
    """

    fails: Callable[[Entries], bool]
    runs: int = 0

    def shrink(self, entries: Entries) -> dict[str, list[Any]]:
        """Return the fewest entries that still fail, in their order; those given must fail."""
        found = {key: list(of) for key, of in entries.items()}
        places = [(key, index) for key, of in found.items() for index in range(len(of))]
        kept = self._fewest(found, places)
        fewest = _only(found, kept)
        for key, of in fewest.items():
            for index, entry in enumerate(of):
                if isinstance(entry, dict):
                    self._halve(fewest, key, index)
        return fewest

    def _fewest(self, found: Entries, places: list[_One]) -> list[_One]:
        """Return a 1-minimal part of the places (the algorithm *ddmin* of the paper)."""
        parts = 2
        if self._fails(_only(found, [])):
            return []
        while len(places) > 1:
            for rest, is_part in _candidates(places, parts):
                if self._fails(_only(found, rest)):
                    parts = 2 if is_part else max(parts - 1, 2)
                    places = rest
                    break
            else:
                if parts >= len(places):
                    break
                parts = min(2 * parts, len(places))
        return places

    def _halve(self, found: dict[str, list[Any]], key: str, index: int) -> None:
        for name, least in _HALVED.items():
            while (value := found[key][index].get(name, least)) > least:
                smaller = max(value // 2 if isinstance(least, int) else round(value / 2, 6), least)
                before = found[key][index]
                found[key][index] = before | {name: smaller}
                if not self._fails(found):
                    found[key][index] = before
                    break

    def _fails(self, entries: Entries) -> bool:
        self.runs += 1
        return self.fails(entries)


def _candidates(places: Sequence[_One], parts: int) -> Iterator[tuple[list[_One], bool]]:
    """Yield each of so many parts of the places, and then what is left without it; and say which of both it is."""
    edges = [len(places) * number // parts for number in range(parts + 1)]
    bounds = list(itertools.pairwise(edges))
    yield from (([*places[low:high]], True) for low, high in bounds)
    if parts > 2:  # of two parts each is what is left without the other
        yield from (([*places[:low], *places[high:]], False) for low, high in bounds)


def _only(found: Entries, kept: Sequence[_One]) -> dict[str, list[Any]]:
    return {key: [entry for index, entry in enumerate(of) if (key, index) in kept] for key, of in found.items()}
