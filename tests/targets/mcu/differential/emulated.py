"""Runs an image in our machine, in one go or cut into pieces."""

from __future__ import annotations

import itertools
from collections.abc import Iterable
from pathlib import Path

from targets.boards import built_in_board
from targets.mcu.engine.api import Reg
from targets.mcu.image import Image, Segment
from targets.mcu.machine import Machine
from targets.mcu.symbols import NO_SYMBOLS
from tests.targets.mcu.differential.image import BETWEEN_INSTRUCTIONS, STACK_TOP
from tests.targets.mcu.differential.image import Image as SequenceImage

_FLASH = 0x0800_0000
_LIMIT_NS = 1_000_000_000
_STEPS_MAX = 100_000


def make_machine(image: bytes, timing: str = "flat") -> tuple[Machine, bytearray]:
    """Return a machine with the image in its flash, and what it will have written to its console."""
    firmware = Image(
        path=Path("sequences.bin"),
        format="bin",
        digest="0" * 64,
        segments=(Segment(_FLASH, image),),
        table=_FLASH,
        stack_pointer=STACK_TOP,
        reset_vector=int.from_bytes(image[4:8], "little"),
        flash_bytes=len(image),
        ram_bytes=0,
        symbols=NO_SYMBOLS,
        notes=(),
    )
    machine, output = Machine(built_in_board("bluepill"), firmware, timing=timing), bytearray()
    machine.on_console = lambda text, _channel: output.extend(text)
    return machine, output


def output_of(image: bytes) -> bytes:
    """Run it in one go; return what it wrote."""
    return run(*make_machine(image))


def run(machine: Machine, output: bytearray) -> bytes:
    """Run a machine to the end of its program."""
    machine.run_to(_LIMIT_NS)
    assert machine.ended is not None, "the program does not end"
    assert machine.ended.kind == "exit", machine.ended
    return bytes(output)


def run_in_steps(machine: Machine, output: bytearray, image: SequenceImage) -> bytes:
    """Run it instruction by instruction, but for most of what lies between two sequences."""
    ends = {case.end for case in image.cases[:-1]}
    get = machine.engine.get
    # an instruction takes a cycle at least, so this cannot go too far
    return run_cut(machine, output, (BETWEEN_INSTRUCTIONS if get(Reg.PC) in ends else 1 for _ in itertools.count()))


def run_cut(machine: Machine, output: bytearray, cycles: Iterable[int]) -> bytes:
    """Run it in pieces of so many cycles each."""
    for piece in itertools.islice(cycles, _STEPS_MAX):
        machine.run_to(machine.time.ns(machine.cycle + piece))
        if machine.ended is not None:
            return run(machine, output)
    raise AssertionError("the program does not end")
