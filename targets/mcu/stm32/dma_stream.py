"""One stream of a DMA controller with FIFOs: what it wants to do, and does, at its two ports (RM0410 section 8.3).

Data comes in at one port and goes out at the other, through a FIFO of four words. Which port is which depends on the
direction; NDTR counts items at the peripheral port. `Stream.wants_peripheral` and `Stream.wants_memory` say that an
access can be made, `access_peripheral` and `access_memory` make it.

Choices where the manual is silent:

* At the end of a round in circular or double-buffer mode, the next one begins when the FIFO is empty.
* HTIF is set when what has arrived at the destination is at least half of NDTR items, rounded up.
* Bytes that are left over because NDTR times PSIZE is no multiple of MSIZE are written with zeros after them, and read
  with what follows them in memory, which is dropped.
* A request that finds no room in the FIFO, or nothing in it, waits: no overrun or underrun is ever flagged (FEIF).
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

from targets.mcu.services import BusMaster

__all__ = ["Direction", "Setting", "Stream"]

DMEIF, HTIF = 1 << 2, 1 << 4

_FIFO_BYTES = 16
_SIZES = (1, 2, 4, 4)
_BEATS = (1, 4, 8, 16)
_DMDIS = 1 << 2


class Direction(enum.IntEnum):
    """CR.DIR."""

    TO_MEMORY = 0
    TO_PERIPHERAL = 1
    MEMORY_TO_MEMORY = 2


@dataclass(frozen=True, slots=True)
class Setting:
    """What CR and FCR say while the stream is enabled, with what hardware forces.

    Attributes:
        direction: of the data.
        fifo: False in direct mode.
        threshold: bytes in the FIFO at which the memory port goes on.
        peripheral_size: bytes of an item,
        peripheral_beats: how many of them a request moves,
        peripheral_step: and how far the address goes on for each.
        memory_size, memory_beats, memory_step: likewise at the memory port.
        circular: begin anew at the end; also in double-buffer mode.
        double: two buffers take turns.
        by_peripheral: the peripheral says when the end has come.
    """

    direction: Direction
    fifo: bool
    threshold: int
    peripheral_size: int
    peripheral_beats: int
    peripheral_step: int
    memory_size: int
    memory_beats: int
    memory_step: int
    circular: bool
    double: bool
    by_peripheral: bool

    @classmethod
    def of(cls, control: int, fcr: int) -> Setting:
        """Read the registers."""
        direction = Direction(control >> 6 & 3) if control >> 6 & 3 < 3 else Direction.MEMORY_TO_MEMORY
        between = direction is Direction.MEMORY_TO_MEMORY
        fifo = bool(fcr & _DMDIS) or between
        size = _SIZES[control >> 11 & 3]
        memory_size = _SIZES[control >> 13 & 3] if fifo else size
        beats, memory_beats = (_BEATS[control >> 21 & 3], _BEATS[control >> 23 & 3]) if fifo else (1, 1)
        increment = 4 if control >> 15 & 1 and beats == 1 else size
        double = bool(control >> 18 & 1) and not between
        return cls(
            direction=direction,
            fifo=fifo,
            threshold=4 * ((fcr & 3) + 1),
            peripheral_size=size,
            peripheral_beats=beats,
            peripheral_step=increment if control >> 9 & 1 else 0,
            memory_size=memory_size,
            memory_beats=memory_beats,
            memory_step=memory_size if control >> 10 & 1 else 0,
            circular=(bool(control >> 8 & 1) or double) and not between,
            double=double,
            by_peripheral=bool(control >> 5 & 1) and not between,
        )

    @property
    def burst_fits(self) -> bool:
        """Whether the memory bursts fit the threshold and the FIFO (RM0410 table 30)."""
        burst = self.memory_size * self.memory_beats
        if self.peripheral_size * self.peripheral_beats > _FIFO_BYTES:
            return False
        return self.memory_beats == 1 or (burst <= self.threshold and self.threshold % burst == 0)


class Stream:
    """A stream while it is enabled; the controller makes the accesses happen in time.

    Args:
        bus: what it reads and writes.
        setting: how.
        count: NDTR as written.
        peripheral: PAR.
        memory: M0AR or M1AR.

    Attributes:
        setting: as given.
        incoming: whether data comes in at the peripheral port.
        left: items that are still to pass the peripheral port: what NDTR shows.
        closing: it was disabled, and only empties its FIFO.
        flags: what has happened since the caller last took it.
    """

    def __init__(self, bus: BusMaster, setting: Setting, *, count: int, peripheral: int, memory: int) -> None:
        self.setting = setting
        self.incoming = setting.direction is not Direction.TO_PERIPHERAL
        self._between = setting.direction is Direction.MEMORY_TO_MEMORY
        self.closing = False
        self.flags = 0
        self._bus = bus
        self._count = 0xFFFF if setting.by_peripheral else count
        self._half = (self._count + 1) // 2 * setting.peripheral_size
        self._fifo = bytearray()
        self._moves = False  # the memory port has begun to empty or to fill the FIFO
        self.restart(peripheral, memory)

    def restart(self, peripheral: int, memory: int) -> None:
        """Begin a round at these addresses."""
        setting = self.setting
        self.left = self._count
        self._peripheral = peripheral & -setting.peripheral_size
        self._memory = memory & -setting.memory_size
        self._arrived = 0
        self._to_fetch = self._count * setting.peripheral_size
        self._fifo.clear()
        self._moves = setting.direction is Direction.TO_PERIPHERAL

    @property
    def level(self) -> int:
        """Bytes in the FIFO."""
        return len(self._fifo)

    @property
    def done(self) -> bool:
        """Whether a round is over, or the stream was disabled and has nothing left to store."""
        if self.closing or not self.left:
            return not self.incoming or not self._fifo
        return False

    # --- the peripheral port

    def wants_peripheral(self, asked: bool) -> bool:
        """Say whether an access of the peripheral port can be made, if a peripheral asks; memory need not."""
        if not (asked or self._between) or not self.left or self.closing:
            return False
        needed = self._peripheral_beats() * self.setting.peripheral_size
        return len(self._fifo) + needed <= _FIFO_BYTES if self.incoming else len(self._fifo) >= needed

    def _peripheral_beats(self) -> int:
        beats = self.setting.peripheral_beats
        return beats if self.left >= beats else 1

    @property
    def ends_with_next(self) -> bool:
        """Whether the next access of the peripheral port is the last one of the round."""
        return self.left <= self._peripheral_beats()

    def access_peripheral(self) -> int:
        """Make the access, and return how many beats it had. Raises `BusFault`."""
        setting, fifo = self.setting, self._fifo
        size = setting.peripheral_size
        if self.incoming and not setting.fifo and fifo and not setting.memory_step:
            self.flags |= DMEIF
        beats = self._peripheral_beats()
        for _ in range(beats):
            if self.incoming:
                fifo += self._bus.read(self._peripheral, size).to_bytes(size, "little")
            else:
                value = int.from_bytes(fifo[:size], "little")
                del fifo[:size]
                self._bus.write(self._peripheral, size, value)
                self._arrive(size)
            self._peripheral = self._peripheral + setting.peripheral_step & 0xFFFF_FFFF
            self.left -= 1
        if setting.fifo:
            self._watch_threshold()
        return beats

    @property
    def plain(self) -> bool:
        """Whether the next item goes through direct mode and sets no flag on its way, at neither port."""
        setting, size = self.setting, self.setting.peripheral_size
        if setting.fifo or self.left < 2 or self.closing or self._arrived < self._half <= self._arrived + size:
            return False
        return not self._fifo if self.incoming else len(self._fifo) == size and self._to_fetch > 0

    # --- the memory port

    def wants_memory(self) -> bool:
        """Say whether an access of the memory port can be made."""
        setting = self.setting
        if self.incoming:
            if self.closing or not self.left or not setting.fifo:
                return bool(self._fifo)
            return self._moves and len(self._fifo) >= setting.memory_size * setting.memory_beats
        if self.closing or self._to_fetch <= 0:
            return False
        if not setting.fifo:
            return not self._fifo
        return self._moves and self.level + setting.memory_size * setting.memory_beats <= _FIFO_BYTES

    def access_memory(self) -> int:
        """Make the access, and return how many beats it had. Raises `BusFault`."""
        setting, fifo = self.setting, self._fifo
        size = setting.memory_size
        available = len(fifo) if self.incoming else self._to_fetch
        beats = setting.memory_beats if available >= size * setting.memory_beats else 1
        for _ in range(beats):
            if self.incoming:
                stored = fifo[:size]
                del fifo[:size]
                self._bus.write(self._memory, size, int.from_bytes(stored, "little"))
                self._arrive(len(stored))
            else:
                fetched = self._bus.read(self._memory, size).to_bytes(size, "little")[: self._to_fetch]
                fifo += fetched
                self._to_fetch -= len(fetched)
            self._memory = self._memory + setting.memory_step & 0xFFFF_FFFF
        if setting.fifo:
            self._watch_threshold()
        return beats

    def _watch_threshold(self) -> None:
        """Begin to empty the FIFO at the threshold, or to fill it, and go on until no more access fits."""
        setting = self.setting
        burst = setting.memory_size * setting.memory_beats
        if self.incoming:
            self._moves = self.level >= setting.threshold or (self._moves and self.level >= burst)
        else:
            self._moves = self.level <= setting.threshold or (self._moves and self.level + burst <= _FIFO_BYTES)

    def _arrive(self, size: int) -> None:
        before, self._arrived = self._arrived, self._arrived + size
        if before < self._half <= self._arrived:
            self.flags |= HTIF
