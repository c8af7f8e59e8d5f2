"""Chooses which defects are put into which modules.

The choice depends on the seed alone, not on an order: each module and each defect has a number of its own, drawn from
the seed and its name, and those with the highest are taken. A few lines more or less in the product change little.
"""

from __future__ import annotations

import hashlib
import math
from collections import Counter, defaultdict
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass

from measure.gate_proof.defects import Defect

LEAST = 40
"""Of each package at least so many, so that a small one says something too."""
PER_MODULE = 4


@dataclass(frozen=True, slots=True)
class Module:
    """A module of the product.

    Attributes:
        path: within the tree.
        source: its text.
        defects: those that can be put into lines which tests run.
    """

    path: str
    source: bytes
    defects: Sequence[Defect]

    @property
    def package(self) -> str:
        """The package it is in."""
        return self.path.partition("/")[0]


def draw(seed: int, name: str, weight: float) -> float:
    """Return a number for something to be drawn: the higher, the sooner; of weight 2, twice as often as of weight 1."""
    digest = hashlib.sha256(f"{seed} {name}".encode()).digest()
    return math.log((int.from_bytes(digest[:8], "big") + 1) / 2**64) / weight


def shares(sizes: Mapping[str, int], count: int) -> dict[str, int]:
    """Share a number among packages by their size, with at least `LEAST` for each."""
    least = min(LEAST, count // max(len(sizes), 1))
    rest, left = dict(sizes), count
    while small := {package for package, size in rest.items() if size * left < least * sum(rest.values())}:
        left -= least * len(small)
        rest = {package: size for package, size in rest.items() if package not in small}
    whole = sum(rest.values())
    return {package: round(left * rest[package] / whole) if package in rest else least for package in sizes}


def choose(modules: Collection[Module], seed: int, count: int) -> list[Defect]:
    """Choose defects.

    Args:
        modules: all that there are.
        seed: what the choice is drawn from.
        count: how many defects in all, about.

    Returns:
        The defects, in the order of packages and modules.
    """
    by_package: dict[str, list[Module]] = defaultdict(list)
    for module in modules:
        if module.defects:
            by_package[module.package].append(module)
    sizes = {package: sum(len(one.defects) for one in found) for package, found in sorted(by_package.items())}
    chosen = []
    for package, wanted in shares(sizes, count).items():
        drawn = sorted(by_package[package], key=lambda one: draw(seed, one.path, len(one.defects)), reverse=True)
        found: list[Defect] = []
        for module in drawn:
            found += _of_module(module, seed, min(PER_MODULE, wanted - len(found)))
        chosen += sorted(found, key=lambda one: (one.path, one.start))
    return chosen


def _of_module(module: Module, seed: int, count: int) -> list[Defect]:
    """Choose defects of a module: of different kinds rather than of the commonest, and no two in a line."""
    kinds = Counter(defect.kind for defect in module.defects)
    drawn = sorted(module.defects, key=lambda one: draw(seed, one.id, 1 / math.sqrt(kinds[one.kind])), reverse=True)
    return list(_first(drawn, count, lambda one: one.matters(module.source)))


def _first(drawn: Sequence[Defect], count: int, fits: Callable[[Defect], bool]) -> Iterator[Defect]:
    lines: set[int] = set()
    for defect in drawn:
        if count <= 0:
            return
        if lines.isdisjoint(defect.lines) and fits(defect):
            lines.update(defect.lines)
            count -= 1
            yield defect
