"""Groups of instructions: IT blocks, branches over code, tables, loops, calls, exclusive pairs; and whole bodies.

Only what is well formed is made: every branch goes to an instruction of the sequence, every loop ends.
"""

from __future__ import annotations

import itertools
import random
from dataclasses import dataclass, replace

from tests.targets.mcu.differential import arithmetic, dsp, floats, memory, system
from tests.targets.mcu.differential.branches import (
    branch,
    branch_if,
    branch_if_wide,
    branch_if_zero,
    branch_link,
    branch_wide,
)
from tests.targets.mcu.differential.sequence import BLOCK_SIZE, LR, SP, Sequence, Span

_AL = 14


class _Pick:
    """Chooses by weight."""

    def __init__(self, weighted) -> None:
        self._atoms = [atom for _weight, atom in weighted]
        self._sums = list(itertools.accumulate(weight for weight, _atom in weighted))

    def __call__(self, s: Sequence):
        return s.rng.choices(self._atoms, cum_weights=self._sums)[0]


def simple(s: Sequence) -> None:
    """Append one instruction that does not branch."""
    pick = s.core.compute if s.pure else s.core.simple
    while not (atom := pick(s))(s):
        pass
    s.made[atom.__name__] += 1


def plain(s: Sequence, count: int) -> None:
    """Append instructions and IT blocks."""
    for _ in range(count):
        if s.chance(0.15):
            it_block(s)
        else:
            simple(s)


# --- conditional execution


def it_block(s: Sequence) -> None:
    """IT with one to four instructions, the last of which may be a branch."""
    condition, length = s.between(0, _AL), s.between(1, 4)
    mask = 8 >> (length - 1)
    for place in range(length - 1):
        bit = condition & 1 ^ (0 if condition == _AL else s.bits(1))
        mask |= bit << (3 - place)
    s.emit(0xBF00 | condition << 4 | mask)
    s.made[f"it {condition} {length}"] += 1
    s.in_it = True
    for _ in range(length - 1):
        _conditionally(s, simple)
    if s.chance(0.1):
        _conditionally(s, _branch_over)
    else:
        _conditionally(s, simple)
    s.in_it = False


def _conditionally(s: Sequence, append) -> None:
    without = s.fork()
    append(s)
    s.join(without)


def _branch_over(s: Sequence) -> None:
    """A branch that ends an IT block, and what it skips."""
    s.made["it branch"] += 1
    place, wide = s.here, s.bits(1)
    s.emit(*[0] * (1 + wide))
    s.in_it = False
    for _ in range(s.between(1, 3)):
        simple(s)
    _patch(s, place, branch_wide(s.here - place) if wide else branch(s.here - place))


# --- branches


def skip(s: Sequence) -> None:
    """A conditional branch over some instructions."""
    kind, condition, register = s.between(0, 4), s.between(0, 13), s.source(low=True)
    place = s.here
    s.emit(*[0] * (1 + (kind in (1, 3))))
    without = s.fork()
    plain(s, s.between(1, 4))
    distance = s.here - place
    code = (
        lambda: branch_if(condition, distance),
        lambda: branch_if_wide(condition, distance),
        lambda: branch(distance),
        lambda: branch_wide(distance),
        lambda: branch_if_zero(register, s.bits(1), distance),
    )[kind]()
    s.made[f"skip {kind}"] += 1
    s.join(without)
    _patch(s, place, code)


def table(s: Sequence) -> None:
    """TBB or TBH, its table right behind it, at PC or at a register."""
    halves, other = s.bits(1), s.source()
    bits = s.between(1, 2 + halves)
    ways = 1 << bits
    index = s.target(low=True)
    s.emit(0xF3C0 | other, index << 8 | bits - 1)  # UBFX
    base = 15
    if s.chance(0.4):
        base = s.target(without=(index,))
        lead = s.here + 4  # of the branch; the table comes 4 bytes later
        s.emit(0xF20F, base << 8 | (lead + 4 - (s.here + 4 & ~3)))  # ADR
    origin = s.here + 4
    s.emit(0xE8D0 | base, 0xF000 | halves << 4 | index)
    place = len(s.halves)
    s.emit(*[0] * (ways if halves else ways // 2))
    offsets, exits, ends = [], [], []
    before = s.fork()
    for _way in range(ways):
        offsets.append((s.here - origin) // 2)
        s.known = before
        plain(s, s.between(1, 2))
        exits.append(s.here)
        s.emit(0, 0)
        ends.append(s.known)
    for end in ends:
        s.join(end)
    for at in exits:
        _patch(s, at, branch_wide(s.here - at))
    entries = offsets if halves else [low | high << 8 for low, high in zip(offsets[::2], offsets[1::2], strict=True)]
    s.halves[place : place + len(entries)] = entries
    s.made["tbh" if halves else "tbb"] += 1


def loop(s: Sequence) -> None:
    """A few passes over some instructions."""
    before, passes, narrow = s.known, s.between(1, 4), s.chance(0.5)
    counter = s.target(low=narrow)
    s.emit(*((0x2000 | counter << 8 | passes,) if narrow else (0xF04F, counter << 8 | passes)))
    outside = s.known
    s.known = replace(s.known, kept=s.known.kept | {counter}, frozen=True)
    start = s.here
    plain(s, s.between(1, 4))
    s.emit(*((0x3800 | counter << 8 | 1,) if narrow else (0xF1B0 | counter, counter << 8 | 1)))  # SUBS
    back = start - s.here
    s.emit(*(branch_if(1, back) if narrow else branch_if_wide(1, back)))
    s.known = replace(s.known, kept=before.kept, frozen=outside.frozen)
    s.made["loop"] += 1


def jump(s: Sequence) -> None:
    """Over some instructions by BX, MOV or ADD to PC."""
    kind, register = s.between(0, 2), s.target()
    lead = s.here
    s.emit(0, 0)
    s.emit((0x4700, 0x4687, 0x4487)[kind] | register << 3)
    after, without = s.here, s.fork()
    plain(s, s.between(1, 3))
    s.join(without)
    if kind == 2:  # mov.w register, #distance from the PC that ADD sees
        _patch(s, lead, (0xF04F, register << 8 | s.here - (after + 2)))
    else:  # addw register, pc, #distance
        _patch(s, lead, (0xF20F, register << 8 | s.here + (kind == 0) - (lead + 4 & ~3)))
    s.made[f"jump {kind}"] += 1


def call(s: Sequence) -> None:
    """A function behind a branch, called with BL or BLX, that returns in one of the ways there are."""
    stacked = s.chance(0.6) and s.offset(SP, 12, range(-12, -11)) is not None
    s.forget(LR)
    _call_instruction(s)
    around = s.here
    s.emit(0, 0)
    saved = s.target(low=True)
    if stacked:
        s.emit(0xB500 | 1 << saved)  # push {saved, lr}
        s.point(SP, s.known.pointers[SP].moved(-8))
    kept = s.known.kept
    s.known = replace(s.known, kept=kept | {SP if stacked else LR})
    s.pure = stacked  # a store could hit the return address
    plain(s, s.between(1, 3))
    s.pure = False
    if not stacked and s.chance(0.3):
        s.emit(0xBF08 | s.between(0, 13) << 4, 0x4770)  # it; bx lr
        without = s.fork()
        simple(s)
        s.join(without)
    s.known = replace(s.known, kept=kept)
    _return(s, saved, stacked=stacked)
    _patch(s, around, branch_wide(s.here - around))


def _call_instruction(s: Sequence) -> None:
    """Call what is behind a wide branch that follows."""
    if s.chance(0.5):
        s.made["bl"] += 1
        s.emit(*branch_link(8))
        return
    s.made["blx"] += 1
    register = s.target(without=(LR,))
    distance = 4 + 2 + 4 + 1  # of the ADR, the BLX and the branch; and the bit of Thumb
    pc = s.here + 4 & ~3
    s.emit(0xF20F, register << 8 | s.here + distance - pc)
    s.emit(0x4780 | register << 3)


def _return(s: Sequence, saved: int, *, stacked: bool) -> None:
    if not stacked:
        s.made["bx lr"] += 1
        s.emit(0x4770)
        return
    kind = s.between(0, 2)
    s.made[f"return {kind}"] += 1
    s.forget(saved)
    if kind == 0:
        s.emit(0xBD00 | 1 << saved)  # pop {saved, pc}
    elif kind == 1:
        s.emit(0xE8BD, 0x8000 | 1 << saved)  # the same, wide
    else:
        s.emit(0xBC00 | 1 << saved, 0xF85D, 0xFB04)  # pop {saved}; ldr pc, [sp], #4
    s.point(SP, s.known.pointers[SP].moved(8))


# --- exclusive pairs


def exclusive(s: Sequence) -> None:
    """LDREX and STREX of one size at one address, computation between them; perhaps CLREX, perhaps STREX again."""
    size = s.one_of(1, 2, 4)
    reach = range(0, 1021, 4) if size == 4 else range(1)
    if (where := s.place(size, reach, aligned=size, sp=False)) is None:
        return
    base, offset = where
    kept = s.known.kept
    s.known = replace(s.known, kept=kept | {base})
    s.emit(*_load_exclusive(s, size, base, offset))
    s.pure = True
    plain(s, s.between(0, 3))
    s.pure = False
    if s.chance(0.15):
        system.clear_exclusive(s)
    for _ in range(s.one_of(1, 1, 2)):
        source = s.source()
        status = s.target(without=(base, source))
        s.emit(*_store_exclusive(size, base, offset, source, status))
    s.known = replace(s.known, kept=kept)
    s.made[f"exclusive {size}"] += 1


def _load_exclusive(s: Sequence, size: int, base: int, offset: int) -> tuple[int, int]:
    target = s.target()
    if size == 4:
        return 0xE850 | base, target << 12 | 0xF00 | offset // 4
    return 0xE8D0 | base, target << 12 | (0xF4F if size == 1 else 0xF5F)


def _store_exclusive(size: int, base: int, offset: int, source: int, status: int) -> tuple[int, int]:
    if size == 4:
        return 0xE840 | base, source << 12 | status << 8 | offset // 4
    return 0xE8C0 | base, source << 12 | (0xF40 if size == 1 else 0xF50) | status


def _patch(s: Sequence, at: int, code: tuple[int, ...]) -> None:
    s.halves[at // 2 : at // 2 + len(code)] = code


# --- whole bodies

_GROUP = _Pick(((30, it_block), (6, skip), (3, table), (3, loop), (2, jump), (4, call), (4, exclusive)))


@dataclass(frozen=True, slots=True)
class Core:
    """What sequences are made of for a core.

    Attributes:
        simple: chooses an instruction that does not branch.
        compute: chooses one that does not store either.
        floats: the core has floating point.
    """

    simple: _Pick
    compute: _Pick
    floats: bool


_V7M = (*arithmetic.ATOMS, *memory.ATOMS, *system.ATOMS)
M3 = Core(_Pick(_V7M), _Pick(arithmetic.ATOMS), floats=False)
M7 = Core(
    _Pick((*_V7M, *dsp.ATOMS, *floats.ATOMS)),
    _Pick((*arithmetic.ATOMS, *dsp.ATOMS, *floats.COMPUTING)),
    floats=True,
)


def body(rng: random.Random, core: Core = M3) -> tuple[Sequence, dict[int, Span], int]:
    """Return a sequence, where its pointers point at the start, and the register that it never writes."""
    registers = list(range(13))
    rng.shuffle(registers)
    untouched = registers.pop()
    low = [r for r in registers if r < 8][:2]
    high = [r for r in registers if r >= 8][:2]
    pointers = {register: _somewhere(rng) for register in low + high}
    pointers[SP] = Span(*[4 * rng.randint(20, 44)] * 2)
    s = Sequence(rng, dict(pointers), frozenset({untouched}), core)
    for _ in range(s.between(5, 12)):
        if s.chance(0.35):
            _GROUP(s)(s)
        else:
            simple(s)
    return s, pointers, untouched


def _somewhere(rng: random.Random) -> Span:
    """Return where a pointer points at first: mostly into the block, sometimes below it or above."""
    kind = rng.random()
    if kind < 0.15:
        at = rng.randint(-3800, -1)
    elif kind < 0.25:
        at = rng.randint(BLOCK_SIZE, 1200)
    else:
        at = rng.randint(0, BLOCK_SIZE - 1)
    if rng.random() < 0.8:
        at &= ~3
    return Span(at, at, at % 4 == 0)
