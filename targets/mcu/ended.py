"""How a run of an emulated microcontroller comes to its end by itself, told for people."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

__all__ = ["EndKind", "Ended"]

EndKind = Literal["exit", "lockup", "fault-loop", "reset-loop", "no-boot", "stop"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Ended:
    """Why nothing more will happen.

    Attributes:
        kind: ``exit`` (the program ended itself by semihosting), ``lockup`` (the core stopped for good), ``fault-loop``
            (a fault handler waits or sleeps for ever, and no watchdog runs), ``reset-loop`` (the same reset over and
            over), ``no-boot`` (the boot straps choose memory in which there is no program), ``stop`` (somebody wants to
            look, `Machine.stop_at`).
        status: exit status of the program, for ``exit``; 0 for ``stop``; otherwise 1.
        cause: one line for people.
        pc: address of the instruction.
        place: function and source line, as far as the image tells; empty otherwise.
        cycle: HCLK cycle.
        ns: bench time in nanoseconds.
    """

    kind: EndKind
    status: int
    cause: str
    pc: int
    place: str
    cycle: int
    ns: int
