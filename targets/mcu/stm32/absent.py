"""Peripherals of which only the registers are there: the base of them, and bxCAN, which several families have.

They keep what is written where silicon keeps it, say at the first touch that nothing works, and answer so that drivers
which only wait for a mode to change do not hang.
"""

from __future__ import annotations

import functools
from collections.abc import Iterable
from dataclasses import replace
from typing import ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register

__all__ = ["Absent", "Can", "registers"]


def registers(text: str) -> tuple[Register, ...]:
    """Return registers from their names in order, a word each: ``CR SR=2 @20 DR ISR:``.

    ``=`` gives the reset value in hexadecimal, ``@`` the offset of the next one, ``:`` at the end says read-only.
    """
    found, offset = [], 0
    for word in text.split():
        if word.startswith("@"):
            offset = int(word[1:], 16)
            continue
        name, _, reset = word.removesuffix(":").partition("=")
        writable = 0 if word.endswith(":") else 0xFFFF_FFFF
        found.append(Register(name, offset, int(reset or "0", 16), writable))
        offset += 4
    return tuple(found)


class Absent(Peripheral):
    """A peripheral of which only the registers are there."""

    MISSING: ClassVar[str] = ""

    def registers_of(self) -> Iterable[Register]:
        """Return the registers, all of them marked absent."""
        return self._marked(self.name)

    @classmethod
    @functools.cache
    def _marked(cls, name: str) -> tuple[Register, ...]:
        missing = cls._missing(name)
        return tuple(replace(one, fidelity=Fidelity.ABSENT, note=one.note or missing) for one in cls.REGISTERS)

    @classmethod
    def _missing(cls, name: str) -> str:
        return f"{name} is not modelled: {cls.MISSING}"

    def _note_nothing(self, offset: int, _text: str) -> None:
        """Not every register is listed (one set for each endpoint of USB), so nothing is said of what silicon has."""
        self.note("unmodelled", f"0x{offset:02X}", self._missing(self.name))

    def read(self, offset: int) -> int:
        """Return what was written last, and say that nothing works."""
        if offset in self._readers:
            self._note_absent(offset)
        return super().read(offset)


class Can(Absent):
    """bxCAN on a bus without anybody else: modes change at once, a message stays in its mailbox until it is aborted."""

    MISSING = "nothing is sent, nothing arrives; modes change at once"
    REGISTERS = (
        Register("MCR", 0x00, 0x0001_0002, 0x0001_80FF),
        Register("MSR", 0x04, 0x0000_0C02, 0x1C),
        Register("TSR", 0x08, 0x1C00_0000, 0x008F_8F8F),
        Register("RF0R", 0x0C, 0, 0),
        Register("RF1R", 0x10, 0, 0),
        Register("IER", 0x14, 0, 0x0003_8F7F),
        Register("ESR", 0x18, 0, 0x70),
        Register("BTR", 0x1C, 0x0123_0000, 0xC37F_03FF),
        *(
            Register(f"T{name}{box}R", 0x180 + 0x10 * box + offset, 0, writable)
            for box in range(3)
            for name, offset, writable in (
                ("I", 0, 0xFFFF_FFFF),
                ("DT", 4, 0xFFFF_010F),
                ("DL", 8, 0xFFFF_FFFF),
                ("DH", 12, 0xFFFF_FFFF),
            )
        ),
        *(
            Register(f"R{name}{fifo}R", 0x1B0 + 0x10 * fifo + offset, 0, 0)
            for fifo in range(2)
            for name, offset in (("I", 0), ("DT", 4), ("DL", 8), ("DH", 12))
        ),
        Register("FMR", 0x200, 0x2A1C_0E01, 1),
        Register("FM1R", 0x204, 0, 0x3FFF),
        Register("FS1R", 0x20C, 0, 0x3FFF),
        Register("FFA1R", 0x214, 0, 0x3FFF),
        Register("FA1R", 0x21C, 0, 0x3FFF),
        *(
            Register(f"F{bank}R{half}", 0x240 + 8 * bank + 4 * (half - 1), 0, 0xFFFF_FFFF)
            for bank in range(14)
            for half in (1, 2)
        ),
    )
    MCR, MSR, TSR = 0x00, 0x04, 0x08
    INRQ, SLEEP, RESET = 1 << 0, 1 << 1, 1 << 15
    ACKNOWLEDGED = 0x3  # INAK and SLAK

    def write_MCR(self, value: int) -> None:
        """INAK and SLAK follow INRQ and SLEEP; RESET leads to sleep mode."""
        if value & self.RESET:
            self.reset()
            return
        self[self.MCR] = value
        acknowledged = 1 if value & self.INRQ and not value & self.SLEEP else value & self.SLEEP
        self[self.MSR] = (self[self.MSR] & ~self.ACKNOWLEDGED) | acknowledged

    def write_MSR(self, value: int) -> None:
        """The flags of the interrupts never rise."""

    def write_TSR(self, value: int) -> None:
        """RQCP is cleared by 1; ABRQ empties a mailbox that waits."""
        for box in range(3):
            flags = value >> 8 * box
            if flags & 1:
                self[self.TSR] &= ~(0xF << 8 * box)
            if flags & 0x80 and self[0x180 + 0x10 * box] & 1:
                self[0x180 + 0x10 * box] &= ~1
                self[self.TSR] |= 1 << 26 + box | 1 << 8 * box

    def write_TI0R(self, value: int) -> None:
        """Mailbox 0."""
        self._request(0, value)

    def write_TI1R(self, value: int) -> None:
        """Mailbox 1."""
        self._request(1, value)

    def write_TI2R(self, value: int) -> None:
        """Mailbox 2."""
        self._request(2, value)

    def _request(self, box: int, value: int) -> None:
        """TXRQ: the message waits, for nobody on the bus acknowledges it."""
        self[0x180 + 0x10 * box] = value
        if value & 1:
            self[self.TSR] &= ~(1 << 26 + box | 0xF << 8 * box)
