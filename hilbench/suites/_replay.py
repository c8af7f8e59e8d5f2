"""What came in and went out on the pins of a board, and how to give the same to another."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import NamedTuple

from hilbench.check import Violation, record_measure
from hilbench.clock import NS_PER_S
from hilbench.mcu.board_case import BoardBench
from hilbench.suites._bluepill import CONNECT, DISTANCES, LEFT_ENCODER, MOTORS, RESET, RIGHT_ENCODER

__all__ = ["INPUTS", "OUTPUTS", "Edge", "Inputs", "Outputs"]

INPUTS = (*DISTANCES, *LEFT_ENCODER, *RIGHT_ENCODER)
OUTPUTS = (*MOTORS, CONNECT, RESET, "PA0", "PA9", "PA11", "PA12")
"""Motor words, the lines to the adapter, lamps, and USART1."""


class Edge(NamedTuple):
    """A change of a level; None is a pin that floats."""

    cycle: int
    ns: int
    pin: str
    level: bool | None

    def __str__(self) -> str:
        level = "z" if self.level is None else int(self.level)
        return f"{self.pin} -> {level} at {self.ns / NS_PER_S:.9f} s, cycle {self.cycle}"


class _Edges:
    """The edges of some pins, from now on."""

    def __init__(self, bench: BoardBench, pins: Iterable[str]) -> None:
        self.edges: list[Edge] = []
        for pin in pins:
            bench.board.pin(pin).on_edge(partial(self._take, pin))

    def _take(self, pin: str, cycle: int, ns: int, level: bool | None) -> None:
        self.edges.append(Edge(cycle, ns, pin, level))


class Inputs(_Edges):
    """What comes in on the distance and encoder pins of a board whose power has just come on.

    Args:
        bench: what is written down.
    """

    def __init__(self, bench: BoardBench) -> None:
        self._first = {pin: bench.board.pin(pin).level for pin in INPUTS}
        super().__init__(bench, INPUTS)

    def give(self, other: BoardBench) -> None:
        """Give the same to another board whose power has just come on, each edge at its own time."""
        machine = other.emulated.machines[other.board.name]
        for name, level in self._first.items():
            if level is not None:
                other.board.pin(name).drive(level)
        for edge in self.edges:
            if edge.level is not None:
                machine.at_ns(edge.ns, partial(other.board.pin(edge.pin).drive, edge.level))


class Outputs(_Edges):
    """What goes out on all other pins of the robot's connector, the lamps and the serial line.

    Args:
        bench: what is written down.
    """

    def __init__(self, bench: BoardBench) -> None:
        super().__init__(bench, OUTPUTS)

    def require_same(self, other: Outputs) -> None:
        """Require the same edges, to the cycle, up to where the shorter of both ends.

        Raises:
            Violation: they part; the first difference is named.
        """
        count = min(len(self.edges), len(other.edges))
        record_measure("edges of outputs that are compared", count, "")
        for one, two in zip(self.edges, other.edges, strict=False):
            if one != two:
                raise Violation(f"{one} on wheels, {two} alone")
        if len(self.edges) != len(other.edges):
            longer, where = (self, "alone") if len(self.edges) > count else (other, "on wheels")
            raise Violation(f"{longer.edges[count]} is missing {where}")
