"""``hilbench doctor``."""

from __future__ import annotations

import argparse

from hilbench.errors import UsageError
from hilbench.parser import Parser

_EXAMPLES = """
hilbench doctor --fidelity                 what is modelled of the STM32F103C8, register by register
hilbench doctor --fidelity STM32F103RB --json
"""

_DEFAULT_CHIP = "STM32F103C8"


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench doctor", "Say what the models of a chip do and do not.", _EXAMPLES)
    add = made.add_argument
    add("--fidelity", metavar="CHIP", nargs="?", const=_DEFAULT_CHIP,
        help=f"each register of a chip, or of that on a board: modelled or not (default: {_DEFAULT_CHIP})")  # fmt: skip
    add("--json", action="store_true", help="print JSON")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command; see `hilbench.mcu.ledger`."""
    if parsed.fidelity is None:
        raise UsageError(
            "looking for what is wrong with a machine is not available in this version of hilbench",
            where="doctor",
            hint="there is 'hilbench doctor --fidelity'",
        )

    import json

    from hilbench.console import Console
    from hilbench.exit_codes import ExitCode
    from hilbench.mcu.ledger import as_data, as_text, ledger_of

    chip, ledger = parsed.fidelity, ledger_of(parsed.fidelity)
    Console().data(json.dumps(as_data(chip, ledger), indent=2) if parsed.json else as_text(chip, ledger))
    return ExitCode.OK
