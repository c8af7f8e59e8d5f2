"""Counts which instructions an image really executes."""

from __future__ import annotations

from collections import Counter

from targets.mcu.engine.unicorn_engine import UnicornEngine
from tests.targets.mcu.differential import m7
from tests.targets.mcu.differential.emulated import make_machine, run
from tests.targets.mcu.differential.encodings import is_wide
from tests.targets.mcu.differential.image import FLASH, Image


def executed(image: Image) -> Counter[tuple[int, int]]:
    """Return how often each instruction of the sequences was executed, by its halves; the second of 16 bits is 0.

    What an IT passes over was not executed.
    """
    machine, output = make_machine(image.data)
    visits = _count_visits(machine.engine, image)
    run(machine, output)
    return _by_instruction(image, visits)


def executed_on_m7(image: Image) -> Counter[tuple[int, int]]:
    """Return the same of an image for a Cortex-M7."""
    machine = m7.Run(image.data)
    visits = _count_visits(machine.engine, image)
    machine.output()
    return _by_instruction(image, visits)


def _count_visits(engine: UnicornEngine, image: Image) -> Counter[int]:
    """Have the visits of each instruction of the sequences counted, by address."""
    import unicorn

    visits: Counter[int] = Counter()

    def visit(_core: object, address: int, _size: int, _data: object) -> None:
        visits[address] += 1

    for case in image.cases:
        engine._uc.hook_add(unicorn.UC_HOOK_CODE, visit, begin=case.body, end=case.end - 1)
    return visits


def _by_instruction(image: Image, visits: Counter[int]) -> Counter[tuple[int, int]]:
    counts: Counter[tuple[int, int]] = Counter()
    for address, count in visits.items():
        counts[_instruction(image.data, address - FLASH)] += count
    return counts


def _instruction(data: bytes, at: int) -> tuple[int, int]:
    first = int.from_bytes(data[at : at + 2], "little")
    return first, int.from_bytes(data[at + 2 : at + 4], "little") if is_wide(first) else 0
