"""What DMA1 and DMA2 of the STM32H7 reach: all that the CPU does but its tightly coupled memories.

ITCM and DTCM hang on the core itself; of all bus masters only the MDMA has a way to them (RM0433 section 2.1.4, table
of the interconnection). An access there is a bus error, so the stream stops with TEIF. What the data cache of the core
may hold is noted, for here it holds nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from targets.mcu.errors import BusFault
from targets.mcu.services import BusMaster

__all__ = ["BARRED", "DmaReach"]

_ITCM_END = 0x0001_0000
_DTCM, _DTCM_END = 0x2000_0000, 0x2002_0000

BARRED = ((0, _ITCM_END), (_DTCM, _DTCM_END - _DTCM))
"""Address and size of the tightly coupled memories."""


class DmaReach:
    """The bus as a DMA controller of domain D2 has it; see `BusMaster`.

    Args:
        bus: the bus as the CPU has it.
        note: notes something about an access: kind, where, text.
        cached: says whether what the program stores at an address may stay in its data cache, and what it loads come
            from there.
    """

    def __init__(self, bus: BusMaster, note: Callable[[str, str, str], None], *, cached: Callable[[int], bool]) -> None:
        self._bus = bus
        self._note = note
        self._cached = cached

    def read(self, address: int, size: int) -> int:
        """Read 1, 2 or 4 bytes. Raises `BusFault`."""
        self._check(address)
        return self._bus.read(address, size)

    def write(self, address: int, size: int, value: int) -> None:
        """Write 1, 2 or 4 bytes. Raises `BusFault`."""
        self._check(address)
        self._bus.write(address, size, value)

    def read_words(self, address: int, count: int) -> list[int]:
        """Read words from a multiple of 4 on. Raises `BusFault`."""
        self._check(address)
        return self._bus.read_words(address, count)

    def write_words(self, address: int, words: Sequence[int]) -> None:
        """Write words from a multiple of 4 on, up to the first that cannot be written. Raises `BusFault`."""
        self._check(address)
        self._bus.write_words(address, words)

    def _check(self, address: int) -> None:
        if address < _ITCM_END or _DTCM <= address < _DTCM_END:
            memory = "ITCM" if address < _ITCM_END else "DTCM"
            text = f"DMA1 and DMA2 do not reach it (0x{address:08X}): the stream stops with a transfer error"
            self._note("misuse", memory, text)
            raise BusFault(address)
        if self._cached(address):
            text = (
                f"the data cache is on and may hold what DMA uses (0x{address:08X}), and nothing was ever cleaned or "
                "invalidated: here program and DMA see the same, on silicon they may not"
            )
            self._note("assumed", "CCR.DC", text)
