"""``hilbench doctor``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from hilbench.terminal.parser import Parser

if TYPE_CHECKING:
    from hilbench.terminal.console import Console

_EXAMPLES = """
hilbench doctor                            is everything installed and set up?
hilbench doctor --port serial:/dev/ttyUSB0@9600    what is wrong with a port?
hilbench doctor --calibrate /dev/ttyUSB0@115200    how exact is a port? join TX and RX first
hilbench doctor --fidelity                 what is modelled of the STM32F103C8, register by register
hilbench doctor --fidelity STM32F103RB --json
hilbench doctor --fidelity nucleo-h753zi    of the chip on a board
"""

_NOTES = """
exit codes:
    0  nothing is broken; a warning is something that could be better, or is not needed now
    3  something does not work, and the line below it says what to do; with --calibrate: nothing came back

--calibrate sends some kilobytes of printable characters to whatever is attached. Something must send them back: a plug
that joins TX and RX, or firmware that echoes. Do not point it at a robot.
"""

_DEFAULT_CHIP = "STM32F103C8"


def parser() -> Parser:
    """Return the parser of this command."""
    summary = (
        "Say what is wrong here and what to do about it, how exact a port is, what the models of a chip do and do not."
    )
    made = Parser("hilbench doctor", summary, _EXAMPLES, _NOTES)
    what = made.add_mutually_exclusive_group()
    what.add_argument(
        "--port", metavar="TARGET", help="also check this port; written as for --target of hilbench check"
    )
    what.add_argument("--calibrate", metavar="PORT",
        help="measure round trip, jitter and pacing of a port, and keep them for the verdicts")  # fmt: skip
    what.add_argument("--fidelity", metavar="CHIP", nargs="?", const=_DEFAULT_CHIP,
        help=f"each register of a chip, or of that on a board: modelled or not (default: {_DEFAULT_CHIP})")  # fmt: skip
    made.add_argument("--json", action="store_true", help="print JSON")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command; see `hilbench.doctor` and `hilbench.mcu.ledger`."""
    from hilbench.cli.siblings import check_siblings
    from hilbench.terminal.console import Console

    console = Console()
    if parsed.fidelity is None and parsed.calibrate is None:
        return _examine(console, parsed.port, as_json=parsed.json)
    check_siblings()
    if parsed.calibrate is not None:
        return _calibrate(console, parsed.calibrate, as_json=parsed.json)
    return _fidelity(console, parsed.fidelity, as_json=parsed.json)


def _examine(console: Console, target: str | None, *, as_json: bool) -> int:
    from hilbench.doctor.facts import this_machine
    from hilbench.doctor.report import as_data, as_text, findings_of, is_fit
    from hilbench.exit_codes import ExitCode
    from hilbench.files.names import json_text

    facts = this_machine()
    findings = findings_of(facts, target)
    # What is installed is not known where our packages are not our own.
    ours = facts.intruder is None
    if ours:
        from hilbench.doctor import installation
    if as_json:
        console.data(json_text(as_data(findings) | (installation.as_data() if ours else {})))
    else:
        console.data(as_text(findings))
        if ours:
            console.data(f"\n{installation.as_text()}")
        console.narrate("what is modelled of a chip: hilbench doctor --fidelity CHIP")
    return ExitCode.OK if is_fit(findings) else ExitCode.UNAVAILABLE


def _calibrate(console: Console, text: str, *, as_json: bool) -> int:
    from hilbench.doctor.calibrate import calibrate
    from hilbench.doctor.calibrated import as_data, as_text
    from hilbench.exit_codes import ExitCode
    from hilbench.files.names import json_text
    from hilbench.terminal import interruption

    interruption.raise_once()
    done = calibrate(text)
    console.data(json_text(as_data(done)) if as_json else as_text(done))
    return ExitCode.OK


def _fidelity(console: Console, chip: str, *, as_json: bool) -> int:
    from hilbench.exit_codes import ExitCode
    from hilbench.files.names import json_text
    from hilbench.mcu.ledger import as_data, as_text, ledger_of

    ledger = ledger_of(chip)
    console.data(json_text(as_data(chip, ledger)) if as_json else as_text(chip, ledger))
    return ExitCode.OK
