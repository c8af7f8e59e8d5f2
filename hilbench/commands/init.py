"""``hilbench init``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench.cli.protocol_flags import add_plugins, use_plugins
from hilbench.errors import UsageError
from hilbench.terminal import arguments, interruption
from hilbench.terminal.parser import Parser, typed

if TYPE_CHECKING:
    from hilbench.files.new_files import Written

_EXAMPLES = """
hilbench init --board bluepill --image build/firmware.elf
hilbench init --board ./my-board.toml --image firmware.hex --dir tests
hilbench init --protocol p2os                           for the robot that is plugged in
hilbench init --protocol pkt --port /dev/ttyACM0        or at this port
hilbench init --protocol my_bus                         a package for a protocol of your own
"""

_NOTES = """
For firmware on an emulated board it writes hilbench.toml, test_firmware.py and conftest.py. Then: 'pytest' runs the
test, 'hilbench run --follow' shows what the firmware does, 'hilbench serve hilbench.toml' puts its serial ports on
ptys.
For a board at a serial port it writes test_board.py, and a pytest.ini that says which board: by its USB identity, so
that it is found again under another name. It opens no port and overwrites no file.
For a protocol that is not there yet it writes a package with a small one that works: frames, both roles as models, five
rules with a suite, a bench, tests (docs/plugins.md).
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser(
        "hilbench init",
        "Write a first test, for firmware of your own or a board that is plugged in; or a package for a protocol.",
        _EXAMPLES,
        _NOTES,
    )
    add = made.add_argument
    add("--board", metavar="BOARD",
        help="built-in board (bluepill, nucleo-f103rb, nucleo-f767zi, nucleo-h753zi, stm32vldiscovery), "
        "or a file of yours (.toml)")  # fmt: skip
    add("--chip", metavar="PART", help="another chip on the board, such as STM32F103CB")
    add("--image", metavar="IMAGE", type=Path, help="what would be flashed: ELF, Intel HEX or raw binary")
    add("--protocol", metavar="PROTOCOL",
        help="for a board at a serial port: what it speaks ('hilbench protocols' lists them); or the name of a "
        "new one, for a package")  # fmt: skip
    add("--port", metavar="PORT", default="",
        help="with --protocol: its path, or serial=NUMBER, usb=VENDOR:PRODUCT, or a target of 'hilbench ports' "
        "(default: the only one)")  # fmt: skip
    add("--baud", metavar="B", type=typed(arguments.baud),
        help="with --protocol: its rate (default: that of --port, or the usual one)")  # fmt: skip
    add("--dir", metavar="DIR", default=Path(), type=Path, help="where to write (default: the working folder)")
    add_plugins(made)
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command; see `hilbench.mcu.init.init` and `hilbench.doctor.first_test.init_port`.

    Raises:
        UsageError: it is not said for what, or for both.
    """
    from hilbench.exit_codes import ExitCode
    from hilbench.terminal.console import Console

    console = Console()
    _check(parsed)
    interruption.raise_once()
    if parsed.protocol is not None:
        use_plugins(parsed.plugin)
        written, then = _of_protocol(parsed)
    else:
        from hilbench.mcu.init import init

        written = init(parsed.board, parsed.image, parsed.dir, parsed.chip)
        then = "pytest; hilbench run --follow --for 1s; hilbench serve hilbench.toml"
    for file in written.files:
        console.data(f"wrote {file}")
    for note in written.notes:
        console.narrate(f"note: {note}")
    there = "" if parsed.dir == Path() else f"cd {parsed.dir}; "
    console.narrate(f"try: {there}{then}")
    return ExitCode.OK


def _of_protocol(parsed: argparse.Namespace) -> tuple[Written, str]:
    """Write a first test where the protocol is there, and a package for it where it is not."""
    from hilbench.nearest import nearest
    from hilbench.plugins.discovery import PLUGINS

    name, known = parsed.protocol, PLUGINS.names()
    if name in known or parsed.port or parsed.baud is not None:
        from hilbench.doctor.first_test import init_port

        return init_port(PLUGINS.get(name, "--protocol"), parsed.port, parsed.baud, parsed.dir), "pytest"
    if (near := nearest(name, known)) is not None:
        hint = f"did you mean '{near}'? A package for a new one needs a name that is less like it"
        raise UsageError(f"no protocol '{name}'", where="--protocol", hint=hint)
    from hilbench.plugins.new_package import new_package

    return new_package(name, parsed.dir), f"cd {name}; pip install -e .; hilbench check {name}.toml"


def _check(parsed: argparse.Namespace) -> None:
    of_port = {"--port": parsed.port, "--baud": parsed.baud}
    of_board = {"--board": parsed.board, "--image": parsed.image}
    if parsed.protocol is not None:
        for option, value in (*of_board.items(), ("--chip", parsed.chip)):
            if value is not None:
                raise UsageError("is for an emulated board", where=option, hint="leave out it or --protocol")
        return
    for option, value in of_port.items():
        if value:
            raise UsageError("is for a board at a port", where=option, hint="say what it speaks with --protocol")
    missing = ", ".join(option for option, value in of_board.items() if value is None)
    if missing:
        what = f"{missing} is missing" if missing in of_board else f"{missing} are missing"
        raise UsageError(what, where="init", hint="see 'hilbench init --help'")
