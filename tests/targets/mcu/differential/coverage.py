"""Counts which instructions an image really executes."""

from __future__ import annotations

from collections import Counter

import unicorn

from tests.targets.mcu.differential.emulated import make_machine, run
from tests.targets.mcu.differential.encodings import is_wide
from tests.targets.mcu.differential.image import FLASH, Image


def executed(image: Image) -> Counter[tuple[int, int]]:
    """Return how often each instruction of the sequences was executed, by its halves; the second of 16 bits is 0.

    What an IT passes over was not executed.
    """
    machine, output = make_machine(image.data)
    visits: Counter[int] = Counter()

    def visit(_core: object, address: int, _size: int, _data: object) -> None:
        visits[address] += 1

    for case in image.cases:
        machine.engine._uc.hook_add(unicorn.UC_HOOK_CODE, visit, begin=case.body, end=case.end - 1)
    run(machine, output)
    counts: Counter[tuple[int, int]] = Counter()
    for address, count in visits.items():
        counts[_instruction(image.data, address - FLASH)] += count
    return counts


def _instruction(data: bytes, at: int) -> tuple[int, int]:
    first = int.from_bytes(data[at : at + 2], "little")
    return first, int.from_bytes(data[at + 2 : at + 4], "little") if is_wide(first) else 0
