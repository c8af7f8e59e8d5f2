"""What a model does not do, it says: the static ledger of registers, and what a run touched of what is missing.

Every register of a chip is declared with how far it is modelled. While firmware runs, the first touch of anything that
is not modelled is noted once, with the place in the program and the bench time.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from dataclasses import dataclass

__all__ = ["Fidelity", "Note", "Notes"]


class Fidelity(enum.Enum):
    """How far a register or a feature is modelled."""

    MODELLED = "modelled"
    PARTLY = "partly"
    ABSENT = "absent"


@dataclass(frozen=True, slots=True, kw_only=True)
class Note:
    """Something that firmware did and a user should know of.

    Attributes:
        kind: ``unmodelled`` (the model lacks it), ``clock-off``, ``misuse`` (silicon would not do what was meant),
            ``reserved`` (no such register), ``assumed`` (the model chose what the manual leaves open), ``image`` (what
            is odd about it).
        where: peripheral, register and bits: ``USART1_CR3.SCEN``.
        text: what was done and what comes of it.
        pc: address of the instruction, or None outside the program.
        cycle: HCLK cycle.
        ns: bench time in nanoseconds.
    """

    kind: str
    where: str
    text: str
    pc: int | None
    cycle: int
    ns: int


class Notes:
    """Collects notes, one for each (kind, where).

    Args:
        now: present (cycle, ns).
        pc: address of the instruction in flight, or None.

    Attributes:
        all: the notes so far, in order.
        on_note: called with every new note.
    """

    def __init__(self, now: Callable[[], tuple[int, int]], pc: Callable[[], int | None]) -> None:
        self.all: list[Note] = []
        self.on_note: Callable[[Note], None] = lambda _note: None
        self._seen: set[tuple[str, str]] = set()
        self._now = now
        self._pc = pc

    def pc(self) -> int | None:
        """Return the address of the instruction in flight; None outside the program."""
        return self._pc()

    def add(self, kind: str, where: str, text: str, *, pc: int | None = None) -> None:
        """Note something, if it is the first of its kind and place; `pc` where an earlier instruction did it."""
        if (kind, where) in self._seen:
            return
        self._seen.add((kind, where))
        cycle, ns = self._now()
        note = Note(kind=kind, where=where, text=text, pc=self._pc() if pc is None else pc, cycle=cycle, ns=ns)
        self.all.append(note)
        self.on_note(note)
