"""A peripheral as firmware sees it: a block of 32-bit registers, declared as data.

A peripheral subclasses `Peripheral`, lists its `REGISTERS`, and, where a register does more than keep what was written,
defines ``read_NAME(self) -> int`` or ``write_NAME(self, value)``. A write method gets the value already masked by
`writable`, merged with the bits that cannot be written, and stores it itself with ``self[offset] = value``.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import Any, ClassVar, Protocol

from targets.mcu.fidelity import Fidelity
from targets.mcu.services import Services

__all__ = ["Count", "Peripheral", "Register"]

WORD = 0xFFFF_FFFF


@dataclass(frozen=True, slots=True)
class Register:
    """One 32-bit register.

    Attributes:
        name: as in the reference manual, without the peripheral: ``CR1``.
        offset: from the base of the peripheral, a multiple of 4.
        reset: value after reset.
        writable: bits that a write changes; the others keep their value.
        ignored: bits of these that silicon obeys and the model only remembers: the first write of 1 is noted.
        live: the value changes with time without any event of the chip, as a counter's does. A loop that polls it is
            passed over only if `Peripheral.count` says how. A status register must not need this: what sets its flags
            is an event.
        fidelity: how far it is modelled.
        note: what to know before trusting it, for the ledger.
    """

    name: str
    offset: int
    reset: int = 0
    writable: int = WORD
    ignored: int = 0
    live: bool = False
    fidelity: Fidelity = Fidelity.MODELLED
    note: str = field(default="", kw_only=True)


@dataclass(frozen=True, slots=True)
class Count:
    """How a register counts, from now until something else happens to it.

    Attributes:
        value: at cycle `origin`.
        origin: a cycle, not after now.
        divider: HCLK cycles per step.
        until: the first cycle at which this may not hold any more; an event of the chip may come before.
        down: it counts down.
    """

    value: int
    origin: int
    divider: int
    until: int
    down: bool = False

    def at(self, cycle: Any) -> Any:
        """Return the register at a cycle, or a vector of it."""
        steps = (cycle - self.origin) // self.divider
        return (self.value - steps if self.down else self.value + steps) & WORD


class Values(Protocol):
    """What is kept for registers, by offset."""

    def __getitem__(self, offset: int, /) -> int: ...

    def __setitem__(self, offset: int, value: int, /) -> None: ...


@functools.cache
def _accessors(kind: type) -> tuple[frozenset[str], frozenset[str]]:
    """Return which registers a class of peripherals reads, and writes, by a method of its own."""
    names = dir(kind)
    reads = frozenset(name.removeprefix("read_") for name in names if name.startswith("read_"))
    return reads, frozenset(name.removeprefix("write_") for name in names if name.startswith("write_"))


class Peripheral:
    """Registers at an address.

    Args:
        name: as in the reference manual: ``USART1``.
        base: address of its first register.
        services: what the chip offers.

    Attributes:
        REGISTERS: what it has.
        size: bytes it takes on the bus; whole kilobytes.
        clocked: False while the clock gate is shut. The bus then reads zero and drops writes, and notes it.
        in_c: the part of it that is in C and answers the CPU without coming here; see `CoreEngine.attach`.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = ()
    size: ClassVar[int] = 0x400
    in_c: Any = None

    def __init__(self, name: str, base: int, services: Services) -> None:
        self.name = name
        self.base = base
        self.services = services
        self.time = services.time
        self.clocked = True
        self.registers = {register.offset: register for register in self.registers_of()}
        self._values: Values = {offset: register.reset for offset, register in self.registers.items()}
        self._readers: dict[int, Callable[[], int]] = {}
        self._writers: dict[int, Callable[[int], None]] = {}
        self._absent = {offset for offset, register in self.registers.items() if register.fidelity is Fidelity.ABSENT}
        kind: type = type(self)
        reads, writes = _accessors(kind)
        for offset, register in self.registers.items():
            if register.name in reads:
                self._readers[offset] = getattr(self, f"read_{register.name}")
            if register.name in writes:
                self._writers[offset] = getattr(self, f"write_{register.name}")

    def registers_of(self) -> Iterable[Register]:
        """Return the registers this instance has; those of the class unless it differs by instance."""
        return self.REGISTERS

    # --- what a subclass uses

    def __getitem__(self, offset: int) -> int:
        """Return the value kept for the register at `offset`, without side effect."""
        return self._values[offset]

    def __setitem__(self, offset: int, value: int) -> None:
        """Keep `value` for the register at `offset`, without side effect."""
        self._values[offset] = value

    def note(self, kind: str, where: str, text: str) -> None:
        """Note something about a register or bit of this peripheral; see `fidelity.Note`."""
        self.services.notes.add(kind, f"{self.name}_{where}", text)

    # --- what the chip calls

    def reset(self) -> None:
        """Go to the state after reset. A subclass also cancels its events and drops its lines."""
        for offset, register in self.registers.items():
            self._values[offset] = register.reset

    def before_clock_change(self) -> None:
        """Bring everything up to the present cycle: the rate of the peripheral's clock is about to change."""

    def after_clock_change(self) -> None:
        """Enter the events anew that depend on the rate of the peripheral's clock."""

    # --- what the bus calls; whole words only

    def read(self, offset: int) -> int:
        """Read the word at `offset`, with its side effects."""
        reader = self._readers.get(offset)
        if reader is not None:
            return reader()
        if offset not in self.registers:
            self._note_nothing(offset, "a read of an address without a register gives 0")
            return 0
        if offset in self._absent:
            self._note_absent(offset)
        return self._values[offset]

    def write(self, offset: int, value: int) -> None:
        """Write the word at `offset`, with its effects."""
        register = self.registers.get(offset)
        if register is None:
            self._note_nothing(offset, "a write to an address without a register has no effect")
            return
        if register.ignored & value:
            self._note_ignored(register, value & register.ignored)
        if offset in self._absent:
            self._note_absent(offset)
        value = (value & register.writable) | (self._values[offset] & ~register.writable)
        writer = self._writers.get(offset)
        if writer is not None:
            writer(value)
        else:
            self._values[offset] = value

    def is_live(self, offset: int) -> bool:
        """Say whether the register changes with time alone."""
        register = self.registers.get(offset)
        return register is not None and register.live

    def changing(self, offset: int) -> int:
        """Return the bits of the register that change with time alone."""
        return WORD if self.is_live(offset) else 0

    def count(self, _offset: int) -> Count | None:
        """Return how the register counts from now on, if it is live and a read has no effect; None: nobody knows."""
        return None

    def _note_ignored(self, register: Register, bits: int) -> None:
        why = register.note or "is remembered without effect"
        self.note("unmodelled", f"{register.name}", f"bits 0x{bits:X}: {why}")

    def _note_nothing(self, offset: int, text: str) -> None:
        self.note("reserved", f"0x{offset:02X}", text)

    def _note_absent(self, offset: int) -> None:
        register = self.registers[offset]
        self.note("unmodelled", register.name, register.note or f"{self.name} is not modelled: the value is only kept")
