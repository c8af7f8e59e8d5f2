"""What is checked through the doors: which bench, which suite, which of its lines leads out."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

__all__ = ["BENCHES", "DOORS", "Served"]

DOORS = ("memory", "pty", "tcp", "rfc2217", "proxy")


@dataclass(frozen=True, slots=True, kw_only=True)
class Served:
    """A bench and a suite.

    Attributes:
        bench: as ``hilbench serve`` and ``check`` take it.
        suite: the suite.
        baud: rate of its lines, bit/s.
        lines: what is served, by the name of the checker's line; empty for the only one.
    """

    bench: str
    suite: str
    baud: int
    lines: Mapping[str, str] = field(default_factory=lambda: {"": ""})


BENCHES = (
    Served(bench="rover", suite="pkt-board", baud=115_200, lines={"": "brain.usart3"}),
    Served(
        bench="vehicle",
        suite="vehicle-board",
        baud=921_600,
        lines={"simulator": "brain.usart2", "stack": "brain.usart3"},
    ),
    Served(bench="rover-model", suite="pkt-board", baud=115_200),
    Served(bench="pioneer", suite="p2os-server", baud=9600),
)
"""The other suites look at pins, wheels or the world, which no line leads to: they run in memory alone."""
