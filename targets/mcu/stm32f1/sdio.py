"""SDIO with no card in its slot: commands are sent, none is answered, no data comes or goes (RM0008 section 22).

A command without a response ends with CMDSENT, one with a response with CTIMEOUT, 64 clocks of the card after it
(section 22.3.1). With WAITINT or WAITPEND, or while the card has no clock, nothing ends. The data path and its FIFO are
absent.
"""

from __future__ import annotations

from dataclasses import replace

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.stm32.absent import registers
from targets.mcu.timebase import Event

__all__ = ["Sdio"]

POWER, CLKCR, ARG, CMD, STA, ICR, MASK = 0x00, 0x04, 0x08, 0x0C, 0x34, 0x38, 0x3C
_ON = 3
CLKEN, BYPASS = 1 << 8, 1 << 10
RESPONSE, WAITINT, WAITPEND, CPSMEN = 1 << 6, 1 << 8, 1 << 9, 1 << 10
CTIMEOUT, CMDSENT, CMDACT = 1 << 2, 1 << 7, 1 << 11
STATIC = 0x00C0_07FF
COMMAND_BITS, TIMEOUT_CLOCKS = 48, 64
_NO_CARD = "no card is in the slot: commands are sent, and not answered"
_NO_DATA = "SDIO moves no data: no card answers"
_MODELLED = (POWER, CLKCR, ARG, CMD, STA, ICR, MASK)
_WRITABLE = {POWER: 0x3, CLKCR: 0x7FFF, CMD: 0x7FFF, STA: 0, ICR: STATIC, MASK: 0x00FF_FFFF}


def _declared(register: Register) -> Register:
    if register.offset not in _MODELLED:
        return replace(register, fidelity=Fidelity.ABSENT, note=_NO_DATA)
    writable = _WRITABLE.get(register.offset, register.writable)
    return replace(register, writable=writable, fidelity=Fidelity.PARTLY, note=_NO_CARD)


class Sdio(Peripheral):
    """The interface of SD cards; see the module.

    Args:
        base: address of POWER.
        services: what the chip offers. Used: interrupt 49.
    """

    REGISTERS = tuple(
        _declared(register)
        for register in registers(
            "POWER CLKCR ARG CMD RESPCMD: RESP1: RESP2: RESP3: RESP4: DTIMER DLEN DCTRL DCOUNT: STA ICR MASK "
            "@48 FIFOCNT: @80 FIFO"
        )
    )

    def __init__(self, base: int, services: Services) -> None:
        super().__init__("SDIO", base, services)
        self._irq = services.irq(49)
        self._end: Event | None = None

    def reset(self) -> None:
        """Go to the state after reset."""
        self._cancel()
        super().reset()
        self._irq.set(False)

    def write_CMD(self, value: int) -> None:
        """Send a command."""
        self[CMD] = value
        self._cancel()
        if not value & CPSMEN or self[POWER] != _ON or not self[CLKCR] & CLKEN:
            return
        self.note("unmodelled", "CMD", _NO_CARD)
        self[STA] |= CMDACT
        if value & (WAITINT | WAITPEND):
            return
        clocks, flag = COMMAND_BITS, CMDSENT
        if value & RESPONSE:
            clocks, flag = COMMAND_BITS + TIMEOUT_CLOCKS, CTIMEOUT
        divider = 1 if self[CLKCR] & BYPASS else (self[CLKCR] & 0xFF) + 2
        self._end = self.time.after(clocks * divider, lambda: self._ended(flag))

    def write_STA(self, value: int) -> None:
        """Read-only."""

    def read_ICR(self) -> int:
        """Write-only."""
        return 0

    def write_ICR(self, value: int) -> None:
        """Clear static flags."""
        self[STA] &= ~(value & STATIC)
        self._update()

    def write_MASK(self, value: int) -> None:
        """Choose what interrupts."""
        self[MASK] = value
        self._update()

    def _ended(self, flag: int) -> None:
        self._end = None
        self[STA] = self[STA] & ~CMDACT | flag
        self._update()

    def _cancel(self) -> None:
        self.time.cancel(self._end)
        self._end = None
        self[STA] &= ~CMDACT

    def _update(self) -> None:
        self._irq.set(bool(self[STA] & self[MASK]))
