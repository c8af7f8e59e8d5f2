"""The bus matrix as firmware sees it: memory, registers by kilobyte, bit-band, and what happens where nothing is.

Lanes. On APB a half-word or byte is repeated over the whole word on its way to the register (RM0008 section 3.1: the
bridge duplicates it), so a peripheral sees words only. On AHB and on the private peripheral bus the other lanes keep
their value; registers there that must not be read on the way say how they take a part (`write_part`).

Bit-band (Cortex-M3 TRM section 4.2): a word in the alias is one bit of the first megabyte of SRAM or peripherals;
a write reads, changes and writes the word or byte behind it.
"""

from __future__ import annotations

import functools
import struct
from collections.abc import Callable, Sequence
from typing import Protocol, cast, runtime_checkable

from targets.mcu.engine.api import Access
from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Notes
from targets.mcu.registers import Count, Peripheral

__all__ = ["ALIAS_SIZE", "BIT_BAND", "Bus", "TakesParts"]

_WORD = 0xFFFF_FFFF
_PAGE_BITS = 10
_CORE = 0xE000_0000
_REPEAT = {1: 0x0101_0101, 2: 0x0001_0001, 4: 1}
_MASK = {1: 0xFF, 2: 0xFFFF, 4: _WORD}

BIT_BAND = {0x2200_0000: 0x2000_0000, 0x4200_0000: 0x4000_0000}
"""Base of each bit-band alias region, and of the megabyte whose bits it shows."""
ALIAS_SIZE = 0x0200_0000


@runtime_checkable
class TakesParts(Protocol):
    """A peripheral that tells bytes and half-words from words, as the private peripheral bus and ITM do."""

    def read_part(self, offset: int, size: int) -> int:
        """Read 1 or 2 bytes at `offset`."""

    def write_part(self, offset: int, size: int, value: int) -> None:
        """Write 1 or 2 bytes at `offset`."""


@functools.cache
def _takes_parts(kind: type) -> bool:
    """Say whether peripherals of a class tell parts of words; cached: of a protocol that is slow to find out."""
    return issubclass(kind, TakesParts)


class Bus:
    """Memory and peripherals by address.

    Attributes:
        on_code_store: called with address, size and value when somebody but the CPU stores into read-only memory.
        writes: how many register writes there have been, and
        block_writes: of them to blocks beside the core, whose own registers begin at 0xE0000000.
        trace: while it is a list, every read of a register adds (address, value, whether it changes with time alone).
    """

    def __init__(self, notes: Notes) -> None:
        self._notes = notes
        self._memory: dict[int, tuple[int, int, bytearray, bool]] = {}  # by kilobyte
        self._part_takers: dict[int, TakesParts] = {}
        self._pages: dict[int, Peripheral] = {}
        self._ahb: set[str] = set()
        self._quiet: list[tuple[int, int, Callable[[int], bool] | None]] = []
        self.on_code_store: Callable[[int, int, int], None] = lambda _address, _size, _value: None
        self.writes = 0
        self.block_writes = 0
        self.trace: list[tuple[int, int, bool]] | None = None

    # --- what there is

    def add_memory(self, base: int, data: bytearray, *, writable: bool) -> None:
        """Put memory at `base`; stores into read-only memory go to `on_code_store`."""
        place = base, base + len(data), data, writable
        for page in range(base >> _PAGE_BITS, (base + len(data) - 1 >> _PAGE_BITS) + 1):
            self._memory.setdefault(page, place)

    def add(self, peripheral: Peripheral, *, ahb: bool = False) -> None:
        """Put a peripheral at its base; `ahb`: narrow writes leave the other lanes alone."""
        if ahb:
            self._ahb.add(peripheral.name)
        pages = range(peripheral.base >> _PAGE_BITS, (peripheral.base + peripheral.size - 1 >> _PAGE_BITS) + 1)
        self._pages.update(dict.fromkeys(pages, peripheral))
        kind: type = type(peripheral)
        if _takes_parts(kind):
            self._part_takers.update(dict.fromkeys(pages, cast("TakesParts", peripheral)))

    def add_quiet(self, base: int, size: int, answers: Callable[[int], bool] | None = None) -> None:
        """Let addresses without a peripheral read zero there, as behind a bridge, instead of faulting.

        Where `answers` is given, it says for which addresses, and notes what is to be said of them.
        """
        self._quiet.append((base, base + size, answers))

    # --- masters other than the CPU's own loads and stores: DMA, exception stacking, bit-band

    def read(self, address: int, size: int) -> int:
        """Read 1, 2 or 4 bytes.

        Raises:
            BusFault: nothing is there.
        """
        place = self._memory.get(address >> _PAGE_BITS)
        if place is not None:
            start, end, data, _ = place
            if start <= address and address + size <= end:
                return int.from_bytes(data[address - start : address - start + size], "little")
        return self.read_register(address, size)

    def write(self, address: int, size: int, value: int) -> None:
        """Write 1, 2 or 4 bytes.

        Raises:
            BusFault: nothing is there.
        """
        place = self._memory.get(address >> _PAGE_BITS)
        if place is not None:
            start, end, data, writable = place
            if start <= address and address + size <= end:
                if writable:
                    data[address - start : address - start + size] = (value & _MASK[size]).to_bytes(size, "little")
                else:
                    self.on_code_store(address, size, value)
                return
        self.write_register(address, size, value)

    def read_words(self, address: int, count: int) -> list[int]:
        """Read words from a multiple of 4 on.

        Raises:
            BusFault: nothing is there.
        """
        place = self._memory.get(address >> _PAGE_BITS)
        if place is not None and place[0] <= address and address + 4 * count <= place[1]:
            return list(struct.unpack_from(f"<{count}I", place[2], address - place[0]))
        return [self.read(address + 4 * index & _WORD, 4) for index in range(count)]

    def write_words(self, address: int, words: Sequence[int]) -> None:
        """Write words from a multiple of 4 on.

        Raises:
            BusFault: nothing is there; the words before are written.
        """
        place = self._memory.get(address >> _PAGE_BITS)
        if place is not None and place[3] and place[0] <= address and address + 4 * len(words) <= place[1]:
            struct.pack_into(f"<{len(words)}I", place[2], address - place[0], *words)
            return
        for index, word in enumerate(words):
            self.write(address + 4 * index & _WORD, 4, word)

    # --- registers

    def window(self, base: int) -> Access:
        """Return the registers from `base` on as the CPU accesses them."""
        pages = self._pages

        def read(offset: int, size: int) -> int:
            address = base + offset
            if size == 4 and self.trace is None:
                peripheral = pages.get(address >> _PAGE_BITS)
                if peripheral is not None and peripheral.clocked:
                    return peripheral.read(address - peripheral.base & ~3)
            return self.read_register(address, size)

        def write(offset: int, size: int, value: int) -> None:
            address = base + offset
            peripheral = pages.get(address >> _PAGE_BITS)
            if size != 4 or peripheral is None or not peripheral.clocked:
                self.write_register(address, size, value)
                return
            self._count_write(address)
            peripheral.write(address - peripheral.base & ~3, value)

        return Access(read, write, lambda offset: self.is_live(base + offset))

    def is_live(self, address: int) -> bool:
        """Say whether the word at an address changes with time alone."""
        peripheral = self._pages.get(address >> _PAGE_BITS)
        return peripheral is not None and peripheral.clocked and peripheral.is_live(address - peripheral.base & ~3)

    def changing(self, address: int) -> int:
        """Return the bits that change with time alone, of the word at an address."""
        peripheral = self._pages.get(address >> _PAGE_BITS)
        return 0 if peripheral is None else peripheral.changing(address - peripheral.base & ~3)

    def count(self, address: int) -> Count | None:
        """Return how the word at an address counts from now on; None: nobody knows."""
        peripheral = self._pages.get(address >> _PAGE_BITS)
        return None if peripheral is None else peripheral.count(address - peripheral.base & ~3)

    def read_register(self, address: int, size: int) -> int:
        """Read 1, 2 or 4 bytes of a register, with its side effects.

        Raises:
            BusFault: nothing is there.
        """
        peripheral = self._pages.get(address >> _PAGE_BITS)
        if peripheral is None:
            return self._read_nothing(address)
        if not peripheral.clocked:
            self._notes.add("clock-off", peripheral.name, "a read while its clock is off gives 0")
            return 0
        offset = address - peripheral.base
        word = offset & ~3
        if size == 4:
            value = peripheral.read(word)
        elif (taker := self._part_takers.get(address >> _PAGE_BITS)) is not None:
            value = taker.read_part(offset, size)
        else:
            value = peripheral.read(word) >> 8 * (offset & 3) & _MASK[size]
        if self.trace is not None:
            self.trace.append((address, value, peripheral.is_live(word)))
        return value

    def write_register(self, address: int, size: int, value: int) -> None:
        """Write 1, 2 or 4 bytes of a register, with its effects.

        Raises:
            BusFault: nothing is there.
        """
        peripheral = self._pages.get(address >> _PAGE_BITS)
        self._count_write(address)
        if peripheral is None:
            self._write_nothing(address)
            return
        if not peripheral.clocked:
            self._notes.add("clock-off", peripheral.name, "a write while its clock is off is lost")
            return
        offset = address - peripheral.base
        if size == 4:
            peripheral.write(offset & ~3, value & _WORD)
        elif (taker := self._part_takers.get(address >> _PAGE_BITS)) is not None:
            taker.write_part(offset, size, value & _MASK[size])
        elif peripheral.name in self._ahb:
            shift = 8 * (offset & 3)
            kept = peripheral[offset & ~3] if offset & ~3 in peripheral.registers else 0
            peripheral.write(offset & ~3, kept & ~(_MASK[size] << shift) & _WORD | (value & _MASK[size]) << shift)
        else:
            peripheral.write(offset & ~3, (value & _MASK[size]) * _REPEAT[size])

    def _count_write(self, address: int) -> None:
        self.writes += 1
        self.block_writes += address < _CORE

    def _read_nothing(self, address: int) -> int:
        self._note_nothing(address, "a read where there is no peripheral gives 0")
        return 0

    def _write_nothing(self, address: int) -> None:
        self._note_nothing(address, "a write where there is no peripheral is lost")

    def _note_nothing(self, address: int, text: str) -> None:
        for start, end, answers in self._quiet:
            if start <= address < end and (answers is None or answers(address)):
                if answers is None:
                    self._notes.add("reserved", f"0x{address & ~0x3FF:08X}", text)
                return
        raise BusFault(address)

    # --- bit-band

    def read_bit(self, base: int, offset: int) -> int:
        """Read the word at `offset` of the alias region, which stands for a bit from `base` on."""
        address, bit = base + (offset >> 5 & ~3), offset >> 2 & 31
        return self.read(address, 4) >> bit & 1

    def write_bit(self, base: int, offset: int, value: int) -> None:
        """Write bit 0 of `value` to the bit for which the word at `offset` of the alias region stands."""
        address, bit = base + (offset >> 5 & ~3), offset >> 2 & 31
        word = self.read(address, 4)
        self.write(address, 4, word & ~(1 << bit) & _WORD | (value & 1) << bit)
