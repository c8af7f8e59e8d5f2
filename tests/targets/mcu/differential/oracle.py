"""Runs images on Unicorn, as an oracle: a bare Cortex-M3 or M7, its calls of the debugger answered here.

Unicorn descends from QEMU 5; what both have wrong neither tells. What it alone has wrong stands in `KNOWN`.
"""

from __future__ import annotations

import functools
import importlib.metadata
import itertools
import random
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from targets.mcu.cortexm.kinds import CORTEX_M3, CORTEX_M7
from tests.targets.mcu.differential import m7
from tests.targets.mcu.differential.groups import M3, M7
from tests.targets.mcu.differential.image import CASES, FLASH, RAM, STACK_TOP, Case, Image, image_of, make_image
from tests.targets.mcu.differential.report import differences

KINDS = {"M3": (M3, CORTEX_M3), "M7": (M7, CORTEX_M7)}

_FLASH_SIZE, _RAM_SIZE, _PPB_SIZE = 0x1_0000, 0x1_0000, 0x1_0000
_PPB = 0xE000_0000
_SYS_OPEN, _SYS_WRITE, _SYS_EXIT = 0x01, 0x05, 0x18
_BREAKPOINT = 7
_INSTRUCTIONS_MAX = 10_000_000
_LONGEST_PIECE = 60


@functools.cache
def version() -> str:
    """Return Unicorn's version, or nothing if it is not installed."""
    try:
        return importlib.metadata.version("unicorn")
    except importlib.metadata.PackageNotFoundError:
        return ""


class Core:
    """A bare core of Unicorn with flash at 0, RAM at 0x20000000, and memory instead of the system control space.

    Args:
        model: ``M3`` or ``M7``.
        image: what is in flash.
    """

    def __init__(self, model: str, image: bytes) -> None:
        import unicorn
        from unicorn import arm_const

        # Not UC_MODE_MCLASS, which would make a Cortex-M33 of it.
        self.uc: Any = unicorn.Uc(unicorn.UC_ARCH_ARM, unicorn.UC_MODE_THUMB)
        self.uc.ctl_set_cpu_model(getattr(arm_const, f"UC_CPU_ARM_CORTEX_{model}"))
        self.uc.mem_map(FLASH, _FLASH_SIZE, unicorn.UC_PROT_READ | unicorn.UC_PROT_EXEC)
        self.uc.mem_write(FLASH, image.ljust(_FLASH_SIZE, b"\xff"))
        self.uc.mem_map(RAM, _RAM_SIZE)
        self.uc.mem_map(_PPB, _PPB_SIZE)
        self.uc.hook_add(unicorn.UC_HOOK_INTR, self._on_exception)
        self._r0, self._r1 = arm_const.UC_ARM_REG_R0, arm_const.UC_ARM_REG_R1
        self._sp, self._pc = arm_const.UC_ARM_REG_SP, arm_const.UC_ARM_REG_PC
        self._exception = 0
        self._output = bytearray()

    def output(self, start: int) -> bytes:
        """Run an image to its end; return what it wrote."""
        uc = self.uc
        uc.reg_write(self._sp, STACK_TOP)
        while True:
            start = self.run(start)
            operation = uc.reg_read(self._r0)
            if operation == _SYS_EXIT:
                return bytes(self._output)
            if operation == _SYS_WRITE:
                block = uc.reg_read(self._r1)
                self._output += uc.mem_read(self._word(block + 4), self._word(block + 8))
            uc.reg_write(self._r0, 1 if operation == _SYS_OPEN else 0)
            start += 2

    def run(self, start: int) -> int:
        """Run from an address to the next BKPT; return its address."""
        self._exception = 0
        self.uc.emu_start(start | 1, 0, count=_INSTRUCTIONS_MAX)
        end: int = self.uc.reg_read(self._pc)
        assert self._exception == _BREAKPOINT, f"exception {self._exception} at 0x{end:08X}"
        return end

    def _on_exception(self, uc: Any, number: int, _data: object) -> None:
        self._exception = number
        uc.emu_stop()

    def _word(self, address: int) -> int:
        return int.from_bytes(self.uc.mem_read(address, 4), "little")


def output_of(image: bytes, model: str) -> bytes:
    """Run an image on Unicorn's core of that model; return what it wrote."""
    return Core(model, image).output(int.from_bytes(image[4:8], "little") & ~1)


# --- what Unicorn has wrong


def _has_isb(halves: tuple[int, ...]) -> bool:
    return (0xF3BF, 0x8F6F) in itertools.pairwise(halves)


def _writes_process_stack(halves: tuple[int, ...]) -> bool:
    return any(first >> 4 == 0xF38 and second == 0x8809 for first, second in itertools.pairwise(halves))


def _has_fixed_to_single(halves: tuple[int, ...]) -> bool:
    return any(first & 0xFFBE == 0xEEBA and second & 0x0FD0 == 0x0AC0 for first, second in itertools.pairwise(halves))


@dataclass(frozen=True, slots=True)
class Known:
    """An error of Unicorn 2.1.4.

    Attributes:
        text: what it does, and the manual's sentence against it (DDI0403E.e).
        may_be_in: whether a sequence, by its halves, may meet it.
    """

    text: str
    may_be_in: Callable[[tuple[int, ...]], bool]


KNOWN = {
    "isb": Known(
        "what follows an ISB in an IT block is executed whatever its condition; section A7.3.2: ITSTATE holds the "
        "condition of each instruction of the block, and nothing in ISB (A7.7.38) changes it",
        _has_isb,
    ),
    "stack": Known(
        "MSR PSP keeps bits 1 and 0; section B5.2.3: SP_process = R[n]<31:2>:'00'",
        _writes_process_stack,
    ),
    "fixed": Known(
        "VCVT of fixed point to a single rounds as FPSCR says; section A7.7.228: round_nearest is TRUE for it",
        _has_fixed_to_single,
    ),
}


# --- comparison


@dataclass(frozen=True, slots=True)
class Compared:
    """What came of an image.

    Attributes:
        sequences: that were compared.
        problems: differences that nothing known explains, to be shown.
        excused: how many sequences differ by a known error of Unicorn, by its name.
    """

    sequences: int
    problems: list[str] = field(default_factory=list)
    excused: dict[str, int] = field(default_factory=dict)


def compare(model: str, seed: int, first: int) -> Compared:
    """Run `CASES` sequences of the series from number `first` on both; ours whole and cut at random."""
    core, kind = KINDS[model]
    image = make_image(seed, range(first, first + CASES), core)
    whole = m7.Run(image.data, kind=kind).output()
    cut = m7.Run(image.data, kind=kind).output(_pieces(random.Random(f"{seed}: cut {first}")))
    compared = Compared(len(image.cases))
    if whole != cut:
        compared.problems.append("whole and cut: " + differences(image, seed, whole, cut))
    theirs = output_of(image.data, model)
    if whole == theirs:
        return compared
    if image.exception(theirs) or image.exception(whole):
        compared.problems.append(differences(image, seed, theirs, whole))
        return compared
    for place, case in enumerate(image.cases):
        if image.result(theirs, place) != image.result(whole, place):
            _judge(compared, model, seed, case)
    return compared


def _judge(compared: Compared, model: str, seed: int, case: Case) -> None:
    """A sequence that differs, too, where it runs alone is a problem, unless it meets a known error."""
    core, kind = KINDS[model]
    for name, known in KNOWN.items():
        if known.may_be_in(case.halves):
            compared.excused[name] = compared.excused.get(name, 0) + 1
            return
    alone: Image = image_of(seed, case.number, core)
    told = differences(alone, seed, output_of(alone.data, model), m7.Run(alone.data, kind=kind).output())
    if told:
        compared.problems.append(told)
    else:
        compared.excused["follows"] = compared.excused.get("follows", 0) + 1


def _pieces(rng: random.Random) -> Iterator[int]:
    """Pieces of few instructions and of many: cuts come next to IT blocks, and there may be many of them."""
    while True:
        yield rng.randint(1, _LONGEST_PIECE if rng.random() < 0.1 else 4)
