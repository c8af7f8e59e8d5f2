"""Counts which instructions an image really executes."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from targets.mcu.cortexm.kinds import CORTEX_M3, CORTEX_M7, CoreKind
from targets.mcu.engine.api import Reg
from targets.mcu.engine.core_engine import CoreEngine
from tests.targets.mcu.differential import m7
from tests.targets.mcu.differential.encodings import is_wide
from tests.targets.mcu.differential.image import FLASH, Image

_Z, _C, _N, _V = 30, 29, 31, 28
_IT_BITS = 0x0600_FC00


def executed(image: Image, kind: CoreKind = CORTEX_M3) -> Counter[tuple[int, int]]:
    """Return how often each instruction of the sequences was executed, by its halves; the second of 16 bits is 0.

    What an IT passes over was not executed.
    """
    run = m7.Run(image.data, kind=kind)
    bodies = {address for case in image.cases for address in range(case.body, case.end, 2)}
    counts: Counter[int] = Counter()
    run.output(_one_by_one(run.engine, image.data, bodies, counts))
    return _by_instruction(image, counts)


def executed_on_m7(image: Image) -> Counter[tuple[int, int]]:
    """Return the same of an image for a Cortex-M7."""
    return executed(image, CORTEX_M7)


def _one_by_one(engine: CoreEngine, code: bytes, bodies: set[int], counts: Counter[int]) -> Iterator[int]:
    """Count each instruction before it is executed; those of an IT block as if it had one, so that a run ends there."""
    while True:
        at = engine.get(Reg.PC)
        counts[at] += at in bodies
        first, _ = _instruction(code, at - FLASH)
        if first >> 8 == 0xBF and first & 0xF:
            yield from _block(engine, code, first & 0xFF, counts)
        else:
            yield 1


def _block(engine: CoreEngine, code: bytes, it: int, counts: Counter[int]) -> Iterator[int]:
    engine.set(Reg.PC, engine.get(Reg.PC) + 2)
    while it & 0xF:
        at, xpsr = engine.get(Reg.PC), engine.get(Reg.XPSR)
        if _holds(it >> 4, xpsr):
            counts[at] += 1
            engine.set(Reg.XPSR, xpsr & ~_IT_BITS | (it & 0xF0 | 8) << 8)
            yield 1
        else:
            engine.set(Reg.PC, at + (4 if is_wide(_instruction(code, at - FLASH)[0]) else 2))
        it = it & 0xE0 | it << 1 & 0x1F if it & 7 else 0


def _holds(condition: int, xpsr: int) -> bool:
    """Return ConditionHolds (DDI0403 section A7.3.1)."""
    n, z, c, v = (bool(xpsr >> bit & 1) for bit in (_N, _Z, _C, _V))
    result = (z, c, n, v, c and not z, n == v, n == v and not z, True)[condition >> 1]
    return result != (condition & 1 and condition != 0xF)


def _by_instruction(image: Image, visits: Counter[int]) -> Counter[tuple[int, int]]:
    counts: Counter[tuple[int, int]] = Counter()
    for address, count in visits.items():
        if count:
            counts[_instruction(image.data, address - FLASH)] += count
    return counts


def _instruction(data: bytes, at: int) -> tuple[int, int]:
    first = int.from_bytes(data[at : at + 2], "little")
    return first, int.from_bytes(data[at + 2 : at + 4], "little") if is_wide(first) else 0
