"""Tells people where two runs of an image differ."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

from tests.targets.mcu.differential.image import BLOCK, RESULT_SIZE, Case, Image

_DISASSEMBLER = "arm-none-eabi-objdump"
_SHOWN_MAX = 3


def differences(image: Image, seed: int, expected: bytes, actual: bytes) -> str:
    """Return what differs between the outputs of two runs, sequence by sequence; empty if nothing does."""
    if expected == actual:
        return ""
    for name, output in (("expected", expected), ("actual", actual)):
        if len(output) != image.output_size:
            return f"{name}: {len(output)} bytes of {image.output_size}"
        if address := image.exception(output):
            return f"{name}: an exception at 0x{address:08X}, in {_case_at(image, address, seed)}"
    wrong = [place for place in range(len(image.cases)) if image.result(expected, place) != image.result(actual, place)]
    told = [_tell(image, place, seed, expected, actual) for place in wrong[:_SHOWN_MAX]]
    more = [f"... and {len(wrong) - _SHOWN_MAX} more sequences"] if len(wrong) > _SHOWN_MAX else []
    return "\n\n".join([*told, *more]) or "the block of the last sequence"


def differences_in_block(image: Image, expected: bytes, actual: bytes) -> list[str]:
    """Return the words of the block that differ after the last sequence of the image."""
    theirs, ours = image.block(expected), image.block(actual)
    return [
        f"0x{BLOCK + at:08X}: 0x{_word(theirs, at):08X} expected, 0x{_word(ours, at):08X} actual"
        for at in range(0, len(theirs), 4)
        if _word(theirs, at) != _word(ours, at)
    ]


def listing(case: Case) -> str:
    """Return the code of a sequence: disassembled if there is a disassembler, as hex otherwise."""
    code = b"".join(half.to_bytes(2, "little") for half in case.halves)
    if shutil.which(_DISASSEMBLER) is None:
        return " ".join(f"{half:04x}" for half in case.halves)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "code.bin"
        path.write_bytes(code)
        options = ["-D", "-b", "binary", "-m", "arm", "-M", "force-thumb", f"--adjust-vma={case.body}"]
        text = subprocess.run([_DISASSEMBLER, *options, path], capture_output=True, text=True, check=True).stdout
    return "\n".join(line for line in text.splitlines() if line.startswith(" "))


def _tell(image: Image, place: int, seed: int, expected: bytes, actual: bytes) -> str:
    case = image.cases[place]
    lines = [_name(image, case, seed), listing(case)]
    lines.append("begins with " + " ".join(f"{name}={value:08x}" for name, value in case.record.items()))
    results = zip(case.names, image.result(expected, place), image.result(actual, place), strict=True)
    lines += [f"{name}: 0x{one:08X} expected, 0x{two:08X} actual" for name, one, two in results if one != two]
    return "\n".join(lines)


def _case_at(image: Image, address: int, seed: int) -> str:
    case = next((case for case in image.cases if case.body <= address < case.end), None)
    return f"{_name(image, case, seed)}\n{listing(case)}" if case else "no sequence"


def _name(image: Image, case: Case, seed: int) -> str:
    core = " m7" if image.result_size != RESULT_SIZE else ""
    return f"sequence {case.number}: python -m tests.targets.mcu.differential {seed} {case.number}{core}"


def _word(data: bytes, at: int) -> int:
    return int.from_bytes(data[at : at + 4], "little")
