"""What somebody wants to know of a program while it runs: where it stops, which ways it goes, which registers it uses.

None of it changes what the program does, or when; what is not asked for costs nothing (``core/src/hooks.h``). What is
told does not depend on how a run is cut, or on which loops are passed over: a loop with something to tell is executed.
"""

from __future__ import annotations

import ctypes
import enum
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from targets.mcu.core.library import structure

__all__ = ["MOST_BREAKPOINTS", "MOST_WATCHPOINTS", "Hit", "HitKind", "Hooks", "RegisterAccess", "Watchpoint"]

MOST_BREAKPOINTS, MOST_WATCHPOINTS = 256, 64

_READ, _WRITE = 1, 2
_SMALLEST_MAP, _LARGEST_MAP = 1 << 8, 1 << 24
_WORD = 1 << 32


class HitKind(enum.IntEnum):
    """What a run has stopped for."""

    READ = _READ
    WRITE = _WRITE
    BREAKPOINT = 4


@dataclass(frozen=True, slots=True)
class Hit:
    """Where a run stopped: before an instruction, which has changed nothing.

    Attributes:
        kind: what for.
        pc: address of the instruction.
        address: of the access, of several words the first that is watched; of a breakpoint, its own.
        size: of the access, in bytes: 1, 2 or 4; 0 for a breakpoint.
        value: what is about to be written, or stands in the memory that is about to be read; None for a breakpoint,
            and for a register that is about to be read.
    """

    kind: HitKind
    pc: int
    address: int
    size: int = 0
    value: int | None = None


@dataclass(frozen=True, slots=True)
class Watchpoint:
    """Bytes of memory, or of registers, that are watched.

    Only what instructions access counts: not what DMA moves, nor frames of exceptions, nor the fetch of instructions.
    The address is the one that the instruction uses: an access by the bit-band alias of a word is none to the word.

    Attributes:
        address: of the first.
        size: how many, at most 2**32 - 1.
        reads: stop before they are read.
        writes: stop before they are written.
    """

    address: int
    size: int = 4
    reads: bool = False
    writes: bool = True

    def __post_init__(self) -> None:
        """Raise ValueError for what no access could hit."""
        there = 0 <= self.address < _WORD and 0 < self.size <= min(_WORD - self.address, _WORD - 1)
        if not (there and (self.reads or self.writes)):
            raise ValueError(f"{self}: no bytes of the address space, or neither reads nor writes")


@dataclass(frozen=True, slots=True)
class RegisterAccess:
    """An access of an instruction to a register, of the chip or of the core.

    Attributes:
        cycle: the HCLK cycle at which the instruction began.
        pc: address of the instruction.
        address: of the register, as accessed (bit-band aliases as they are).
        size: in bytes: 1, 2 or 4.
        value: what was read or written.
        writes: whether it was a write.
    """

    cycle: int
    pc: int
    address: int
    size: int
    value: int
    writes: bool


class Hooks:
    """Breakpoints, watchpoints, a map of edges and a log of accesses of one core.

    Args:
        library: the core in C.
        core: of that library; it lasts as long as this does.
    """

    def __init__(self, library: Any, core: ctypes.c_void_p) -> None:
        self._library = library
        self._core = core
        self._hit: Any = structure("hil_hit").from_address(library.hil_hit_of(core))
        self._breakpoints: frozenset[int] = frozenset()
        self._watchpoints: tuple[Watchpoint, ...] = ()
        self._map: Any = None
        self._log: Any = None

    # --- stops

    @property
    def breakpoints(self) -> frozenset[int]:
        """Addresses of instructions before which a run stops, at most 256; bit 0 is no part of them.

        The instruction must be about to be executed: one that an IT block passes over is not. It is executed when the
        next run begins with it.

        Raises:
            ValueError: when set to too many, or to what is no address of 32 bits.
        """
        return self._breakpoints

    @breakpoints.setter
    def breakpoints(self, addresses: Iterable[int]) -> None:
        wanted = frozenset(address & ~1 for address in addresses)
        if not all(0 <= address < _WORD for address in wanted):
            raise ValueError("a breakpoint is an address of 32 bits")
        numbers = (ctypes.c_uint32 * len(wanted))(*sorted(wanted))
        if not self._library.hil_set_breakpoints(self._core, numbers, len(wanted)):
            raise ValueError(f"{len(wanted)} breakpoints are too many: at most {MOST_BREAKPOINTS}")
        self._breakpoints = wanted

    @property
    def watchpoints(self) -> tuple[Watchpoint, ...]:
        """What is watched, at most 64; a run stops before the instruction that accesses it, once for each.

        Raises:
            ValueError: when set to too many.
        """
        return self._watchpoints

    @watchpoints.setter
    def watchpoints(self, watchpoints: Iterable[Watchpoint]) -> None:
        wanted = tuple(watchpoints)
        numbers = [
            number for one in wanted for number in (one.address, one.size, one.reads * _READ | one.writes * _WRITE)
        ]
        words = (ctypes.c_uint32 * len(numbers))(*numbers)
        if not self._library.hil_set_watchpoints(self._core, words, len(wanted)):
            raise ValueError(f"{len(wanted)} watchpoints are too many: at most {MOST_WATCHPOINTS}")
        self._watchpoints = wanted

    @property
    def hit(self) -> Hit | None:
        """Where the last run stopped; None if it ended for another reason."""
        hit = self._hit
        if not hit.kind:
            return None
        return Hit(HitKind(hit.kind), hit.pc, hit.address, hit.size, hit.value if hit.known else None)

    @property
    def in_block(self) -> bool:
        """True if the last run stopped within an IT block: nothing may happen before the rest of it is executed."""
        return bool(self._hit.in_block)

    # --- what is written down

    def map_edges(self, size: int) -> memoryview:
        """Count from now on how often the program goes from one place to the other; return the map, to be looked at.

        An edge leads from an instruction that may branch, whether it does or not, to the one executed after it;
        exceptions, returns from them and resets make none. It is counted in the byte at
        ``(h(from) >> 1 ^ h(to)) % size`` with ``h(a) = (a // 2 * 2654435761) % 2**32 >> 8``, as fuzzers do, up to 255.
        Several edges may share a byte. A map that was there before is counted in no more.

        Args:
            size: bytes of the map, a power of two from 256 to 2**24.

        Raises:
            ValueError: the size is another.
        """
        if size & (size - 1) or not _SMALLEST_MAP <= size <= _LARGEST_MAP:
            raise ValueError(f"a map of {size} bytes: a power of two from {_SMALLEST_MAP} to {_LARGEST_MAP} is needed")
        counts = (ctypes.c_uint8 * size)()
        self._library.hil_map_edges(self._core, counts, size)
        self._map = counts
        return memoryview(counts).cast("B").toreadonly()

    def stop_mapping(self) -> None:
        """Count no more edges."""
        self._library.hil_map_edges(self._core, None, 0)
        self._map = None

    def log_accesses(self, most: int) -> None:
        """Write down from now on which registers are accessed by instructions, the first `most`; see `accesses`.

        A read is left out if the last access to that register was the same: by the same instruction, of the same size,
        with the same value, and not longer ago than eight accesses that were written down. Accesses that fault are
        left out.

        Args:
            most: how many are kept, of 32 bytes each; with 0 nothing is written down any more.
        """
        self._log = (structure("hil_access") * most)() if most else None
        self._library.hil_log_accesses(self._core, self._log, most)

    @property
    def accesses(self) -> list[RegisterAccess]:
        """What was written down, in order."""
        count = self._library.hil_accesses_logged(self._core)
        return [
            RegisterAccess(one.cycle, one.pc, one.address, one.size, one.value, bool(one.writes))
            for one in (self._log[:count] if count else ())
        ]
