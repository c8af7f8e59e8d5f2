"""The place of a stream in a DMA controller: where its registers are, flags and interrupt (RM0410 section 8.5)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from targets.mcu.services import IrqLine
from targets.mcu.stm32.dma_requests import Request
from targets.mcu.stm32.dma_stream import Stream

__all__ = ["Slot"]

CR, NDTR, PAR, M0AR, M1AR, FCR = range(0x10, 0x28, 4)
"""Offsets of the registers of stream 0; those of the next are `STREAM_SIZE` further on."""
STREAM_SIZE = 0x18

FEIF, DMEIF, TEIF, HTIF, TCIF = (1 << bit for bit in (0, 2, 3, 4, 5))
ENABLES = 0x1E  # DMEIE, TEIE, HTIE, TCIE of CR: each one bit below its flag
FEIE = 1 << 7  # of FCR


class Controller(Protocol):
    """What a slot needs of its controller."""

    def __getitem__(self, offset: int) -> int:
        """Return the value kept for the register at `offset`."""

    def look(self, slot: Slot) -> None:
        """See what the stream wants."""

    def close(self, slot: Slot) -> None:
        """End a stream that is enabled."""

    def fail(self, slot: Slot) -> None:
        """End a stream with an error."""


class Slot:
    """The place of a stream.

    Attributes:
        number: 0 to 7.
        base: offset of its CR.
        flags: as in LISR for stream 0.
        reload: NDTR as it was written last.
        selected: the requests that it listens to since it was enabled last.
        stream: what runs; None while it is disabled, or has nothing to do.
        in_access: an access of it is being made: what it wants then is asked after that.
    """

    def __init__(self, number: int, controller: Controller, irq: IrqLine) -> None:
        self.number = number
        self.base = CR + STREAM_SIZE * number
        self.flags = 0
        self.reload = 0
        self.selected: Sequence[Request] = ()
        self.stream: Stream | None = None
        self.in_access = False
        self._controller = controller
        self._irq = irq
        self._irq_level = False

    @property
    def control(self) -> int:
        """CR."""
        return self._controller[self.base]

    @property
    def fcr(self) -> int:
        """FCR, without FS."""
        return self._controller[self.base + FCR - CR]

    def clear(self) -> None:
        """Go to the state after reset."""
        self.flags = 0
        self.reload = 0
        self.stream = None
        self.drive_irq()

    def request_changed(self) -> None:
        """See `dma_requests.Listener`."""
        # Most requests change because of the access that serves them.
        if self.stream is not None and not self.in_access:
            self._controller.look(self)

    def request_ended(self) -> None:
        """See `dma_requests.Listener`."""
        if self.stream is not None and self.stream.setting.by_peripheral:
            self._controller.close(self)

    def look(self) -> None:
        """See what the stream wants, if it still runs."""
        self._controller.look(self)

    def fail_access(self) -> None:
        """An access of the stream has failed."""
        self._controller.fail(self)

    def flag(self, flags: int) -> None:
        """Set flags."""
        self.flags |= flags
        self.drive_irq()

    def drive_irq(self) -> None:
        """Drive the interrupt from flags and enables."""
        level = bool(self.flags & (self.control & ENABLES) << 1 or (self.flags & FEIF and self.fcr & FEIE))
        if level is not self._irq_level:
            self._irq_level = level
            self._irq.set(level)
