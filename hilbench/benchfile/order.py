"""In which order parts act within a step: who gives before who takes.

What a part takes late (`targets.parts.Quantity.late`) is that of the step before, so it asks for no order: this is
where the circles of a circuit are cut.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hilbench.benchfile.bench_file import PartPlan
from targets.parts import Part

__all__ = ["CircleError", "late_quantities", "order_of"]

Kinds = Mapping[str, type[Part]]


class CircleError(Exception):
    """Parts that wait for each other within one step: each for the next one, the last for the first."""

    def __init__(self, names: Sequence[str]) -> None:
        super().__init__(" -> ".join(names))
        self.names = names


def late_quantities(kind: type[Part]) -> frozenset[str]:
    """Return the quantities that a kind of part takes one step late."""
    return frozenset(quantity.name for quantity in kind.QUANTITIES if quantity.late)


def order_of(plans: Mapping[str, PartPlan], kinds: Kinds) -> tuple[str, ...]:
    """Return the parts in an order in which each comes after those that it takes something from.

    Apart from that the order is that of the bench file.

    Args:
        plans: the parts by name.
        kinds: the class of each.

    Raises:
        CircleError: there is none.
    """
    ordered: dict[str, None] = {}
    for name in plans:
        _visit(name, plans, kinds, ordered, [])
    return tuple(ordered)


def _visit(name: str, plans: Mapping[str, PartPlan], kinds: Kinds, ordered: dict[str, None], way: list[str]) -> None:
    if name in ordered:
        return
    if name in way:
        raise CircleError(way[way.index(name) :])
    late = late_quantities(kinds[name])
    for quantity, end in plans[name].sources.items():
        if quantity not in late:
            _visit(end.part, plans, kinds, ordered, [*way, name])
    ordered[name] = None
