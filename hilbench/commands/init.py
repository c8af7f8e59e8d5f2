"""``hilbench init``."""

from __future__ import annotations

import argparse
from pathlib import Path

from hilbench import interruption
from hilbench.parser import Parser

_EXAMPLES = """
hilbench init --board bluepill --image build/firmware.elf
hilbench init --board ./my-board.toml --image firmware.hex --dir tests
"""

_NOTES = """
Writes hilbench.toml, test_firmware.py and conftest.py, and overwrites nothing. Then: 'pytest' runs the test,
'hilbench run --follow' shows what the firmware does, 'hilbench serve hilbench.toml' puts its serial ports on ptys.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench init", "Write a bench file and a test for firmware of your own.", _EXAMPLES, _NOTES)
    add = made.add_argument
    add(
        "--board",
        metavar="BOARD",
        required=True,
        help="built-in board (bluepill, nucleo-f767zi, nucleo-h753zi), or a file of yours (.toml)",
    )
    add(
        "--image", metavar="IMAGE", required=True, type=Path, help="what would be flashed: ELF, Intel HEX or raw binary"
    )
    add("--dir", metavar="DIR", default=Path(), type=Path, help="where to write (default: the working folder)")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command; see `hilbench.mcu.init.init`."""
    from hilbench.console import Console
    from hilbench.exit_codes import ExitCode
    from hilbench.mcu.init import init

    console = Console()
    interruption.raise_once()
    written = init(parsed.board, parsed.image, parsed.dir)
    for file in written.files:
        console.data(f"wrote {file}")
    for note in written.notes:
        console.narrate(f"note: {note}")
    there = "" if parsed.dir == Path() else f"cd {parsed.dir}; "
    console.narrate(f"try: {there}pytest; hilbench run --follow --for 1s; hilbench serve hilbench.toml")
    return ExitCode.OK
