"""A random sequence of Thumb-2 instructions under construction: its code, and what is known of registers on the way.

Any value may be in most registers. A few are *pointers*: what they hold is known within bounds, relative to a block of
memory, so that every access can be kept inside the block. Where paths meet, both sides' bounds are joined. A pointer
that is overwritten is an ordinary register from there on.

An atom is a function that appends one instruction (or a few, outside of IT blocks) to a sequence and returns whether it
could. Encodings are those of DDI0403 chapter A7; what is UNPREDICTABLE there is never made.
"""

from __future__ import annotations

import random
from collections import Counter
from dataclasses import dataclass, replace

SP, LR, PC = 13, 14, 15
BLOCK_SIZE = 256
INDEX_MAX = 7

_INTERESTING = [0, 0, 1, 2, 0x7F, 0x80, 0xFF, 0x7FFF, 0x8000, 0xFFFF, 0x7FFF_FFFF, 0x8000_0000, 0x8000_0001]
_INTERESTING += [0xFFFF_FFFF, 0xFFFF_FFFE, 0x5555_5555, 0xFFFF_8000, 0xFFFF_FF80]


@dataclass(frozen=True, slots=True)
class Span:
    """Where a pointer points: from `low` to `high`, counted from the start of the block; `aligned` to words."""

    low: int
    high: int
    aligned: bool = True

    def moved(self, by: int) -> Span:
        return Span(self.low + by, self.high + by, self.aligned and by % 4 == 0)

    def joined(self, other: Span) -> Span:
        return Span(min(self.low, other.low), max(self.high, other.high), self.aligned and other.aligned)

    @property
    def on_stack(self) -> bool:
        """Whether a stack pointer may be there."""
        return self.aligned and self.low >= 0 and self.high <= BLOCK_SIZE


@dataclass(frozen=True, slots=True)
class Known:
    """What is known of the registers at a point of the code.

    Attributes:
        pointers: by register number.
        index: a register that holds 0 to INDEX_MAX, if there is one.
        kept: registers that may not be written at all.
        frozen: no pointer may move or be overwritten, nor the index: the code may be executed again.
    """

    pointers: dict[int, Span]
    index: int | None = None
    kept: frozenset[int] = frozenset()
    frozen: bool = False

    def joined(self, other: Known) -> Known:
        shared = self.pointers.keys() & other.pointers.keys()
        return Known(
            {register: self.pointers[register].joined(other.pointers[register]) for register in sorted(shared)},
            self.index if self.index == other.index else None,
            self.kept | other.kept,
            self.frozen or other.frozen,
        )


class Sequence:
    """The code so far and what is known at its end.

    Args:
        rng: every choice comes from it.
        pointers: the registers that point into the block at the start.
        kept: registers that are never written.
        core: which instructions there are: what `groups` made of it.

    Attributes:
        halves: the code.
        known: what is known at the end of it.
        in_it: the next instruction stands in an IT block.
        pure: the next instructions may not store.
        made: how often each atom was used.
    """

    def __init__(self, rng: random.Random, pointers: dict[int, Span], kept: frozenset[int], core) -> None:
        self.rng = rng
        self.core = core
        self.halves: list[int] = []
        self.known = Known(pointers, kept=kept)
        self.in_it = False
        self.pure = False
        self.made: Counter[str] = Counter()

    # --- code

    def emit(self, *halves: int) -> bool:
        self.halves += halves
        return True

    @property
    def here(self) -> int:
        """The offset of the next instruction, in bytes; the first one is aligned to words."""
        return 2 * len(self.halves)

    # --- chance

    def chance(self, probability: float) -> bool:
        return self.rng.random() < probability

    def bits(self, count: int) -> int:
        return self.rng.getrandbits(count)

    def one_of(self, *choices):
        return choices[int(self.rng.random() * len(choices))]

    def between(self, low: int, high: int) -> int:
        """Return a number from `low` to `high`, both included."""
        return low + int(self.rng.random() * (high - low + 1))

    # --- registers

    def source(self, *, low: bool = False, sp: bool = False) -> int:
        """Return a register to read; R0-R7 if `low`; SP among them if `sp`."""
        if low:
            return self.bits(3)
        register = self.bits(4)
        if register == PC or (register == SP and not sp):
            return self.bits(3)
        return register

    def target(self, *, low: bool = False, without: tuple[int, ...] = ()) -> int:
        """Return a register to write, other than `without`; what was known of it is forgotten."""
        known = self.known
        barred = {SP, *known.kept, *without}
        if known.frozen or len(known.pointers) < 4 or not self.chance(0.1):
            barred |= known.pointers.keys()
        if known.frozen and known.index is not None:
            barred.add(known.index)
        register = self.one_of(*(r for r in range(8 if low else PC) if r not in barred))
        self.forget(register)
        return register

    def forget(self, register: int) -> None:
        """The register is overwritten."""
        known = self.known
        if register in known.pointers:
            pointers = {r: span for r, span in known.pointers.items() if r != register}
            self.known = replace(known, pointers=pointers)
        elif register == known.index:
            self.known = replace(known, index=None)

    def point(self, register: int, span: Span) -> None:
        """The pointer points there from now on."""
        self.known = replace(self.known, pointers=self.known.pointers | {register: span})

    def may_move(self, register: int) -> bool:
        """Say whether the pointer may be changed here."""
        return not self.known.frozen and register not in self.known.kept

    def know_index(self, register: int) -> None:
        """The register holds 0 to INDEX_MAX from now on."""
        self.known = replace(self.known, index=register)

    def place(
        self,
        size: int,
        reach: range,
        *,
        aligned: int = 1,
        low: bool = False,
        sp: bool = True,
        moves: bool = False,
    ) -> tuple[int, int] | None:
        """Return a pointer and an offset such that `size` bytes there lie in the block, or None.

        Args:
            size: bytes accessed.
            reach: offsets that the encoding has.
            aligned: to how many bytes the address must be aligned.
            low: only R0-R7.
            sp: SP may be the pointer.
            moves: the pointer is written back.
        """
        pointers = [r for r in self.known.pointers if (r < 8 or not low) and (sp or r != SP)]
        self.rng.shuffle(pointers)
        for register in pointers:
            offset = self.offset(register, size, reach, aligned=aligned, moves=moves)
            if offset is not None:
                return register, offset
        return None

    def offset(self, pointer: int, size: int, reach: range, *, aligned: int = 1, moves: bool = False) -> int | None:
        """Return an offset such that `size` bytes at that pointer lie in the block, or None; see `place`."""
        span = self.known.pointers[pointer]
        if (aligned > 1 and not span.aligned) or (moves and not self.may_move(pointer)):
            return None
        first = _ceil(max(reach.start, -span.low), reach.step)
        last = min(reach.stop - 1, BLOCK_SIZE - size - span.high) // reach.step
        if first > last:
            return None
        offset = self.between(first, last) * reach.step
        return offset if offset % aligned == 0 else None

    # --- paths

    def fork(self) -> Known:
        """Return what is known here, for a path that does not execute what comes next."""
        return self.known

    def join(self, other: Known) -> None:
        """Another path, on which `other` is known, comes here."""
        self.known = self.known.joined(other)


def interesting(rng: random.Random) -> int:
    """Return a value of 32 bits that is often at an edge."""
    kind = int(rng.random() * 8)
    if kind < 3:
        return rng.getrandbits(32)
    if kind == 3:
        return rng.getrandbits(6)  # amounts to shift by
    if kind == 4:
        return -rng.getrandbits(8) & 0xFFFF_FFFF
    if kind == 5:
        return 1 << rng.getrandbits(5)
    if kind == 6:
        return (1 << rng.getrandbits(5)) - 1
    return _INTERESTING[int(rng.random() * len(_INTERESTING))]


def _ceil(value: int, step: int) -> int:
    return -(-value // step)
