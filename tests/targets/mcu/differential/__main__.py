"""Runs one sequence alone, in QEMU and in our machine: ``python -m tests.targets.mcu.differential SEED NUMBER [m7]``"""

from __future__ import annotations

import itertools
import sys

from tests.targets.mcu.differential import m7, qemu
from tests.targets.mcu.differential.emulated import make_machine, output_of, run_in_steps
from tests.targets.mcu.differential.groups import M3, M7
from tests.targets.mcu.differential.image import CASES, image_of
from tests.targets.mcu.differential.report import differences, differences_in_block, listing


def main(seed: int, number: int, core: str = "m3") -> int:
    image = image_of(seed, number, M7 if core == "m7" else M3)
    sys.stdout.write(listing(image.cases[number % CASES]) + "\n")
    if core == "m7":
        ours, cut = m7.Run(image.data).output(), m7.Run(image.data).output(itertools.repeat(1))
    else:
        ours, cut = output_of(image.data), run_in_steps(*make_machine(image.data), image)
    board = "mps2-an500" if core == "m7" else "mps2-an385"
    theirs = None if qemu.missing() else qemu.output_of(image.data, board)
    status = 0
    for name, expected, actual in (("QEMU and ours", theirs, ours), ("ours and ours in steps", ours, cut)):
        if expected is None:
            sys.stdout.write(f"{name}: {qemu.PROGRAM} is not installed\n")
            continue
        different = differences(image, seed, expected, actual)
        status |= bool(different)
        block = differences_in_block(image, expected, actual)
        sys.stdout.write("\n".join([f"{name}: {'different' if different else 'the same'}", different, *block]) + "\n")
    return status


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]), int(sys.argv[2]), *sys.argv[3:]))
