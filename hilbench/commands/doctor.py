"""``hilbench doctor``."""

from __future__ import annotations

import argparse

from hilbench.parser import Parser

_EXAMPLES = """
hilbench doctor                            versions, boards, chips, benches, suites
hilbench doctor --fidelity                 what is modelled of the STM32F103C8, register by register
hilbench doctor --fidelity STM32F103RB --json
hilbench doctor --fidelity nucleo-h753zi    of the chip on a board
"""

_DEFAULT_CHIP = "STM32F103C8"


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench doctor", "Say what is installed, and what the models of a chip do and do not.", _EXAMPLES)
    add = made.add_argument
    add("--fidelity", metavar="CHIP", nargs="?", const=_DEFAULT_CHIP,
        help=f"each register of a chip, or of that on a board: modelled or not (default: {_DEFAULT_CHIP})")  # fmt: skip
    add("--json", action="store_true", help="print JSON")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command; see `hilbench.installation` and `hilbench.mcu.ledger`."""
    from hilbench.console import Console
    from hilbench.exit_codes import ExitCode
    from hilbench.names import json_text

    console = Console()
    if parsed.fidelity is None:
        from hilbench import installation

        console.data(json_text(installation.as_data()) if parsed.json else installation.as_text())
        console.narrate("what is modelled of a chip: hilbench doctor --fidelity CHIP")
        return ExitCode.OK

    from hilbench.mcu.ledger import as_data, as_text, ledger_of

    chip, ledger = parsed.fidelity, ledger_of(parsed.fidelity)
    console.data(json_text(as_data(chip, ledger)) if parsed.json else as_text(chip, ledger))
    return ExitCode.OK
