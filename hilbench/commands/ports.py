"""``hilbench ports``."""

from __future__ import annotations

import argparse

from hilbench.terminal.parser import Parser

_EXAMPLES = """
hilbench ports
hilbench ports --json
hilbench check --target serial:serial=0668FF303430 --suite pkt-board
hilbench check --target serial:usb=0403:6001@9600 --suite p2os-server
"""

_NOTES = """
A port is chosen by its path (serial:/dev/ttyUSB0@115200) or by what is plugged into it: serial=NUMBER,
usb=VENDOR:PRODUCT, location=BUS-PORT.PORT, interface=NUMBER, several of them joined by commas.
No port is opened here: that may reset a board.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    summary = "Serial ports: what is plugged in, which board it probably is, who has it, and whether you may use it."
    made = Parser("hilbench ports", summary, _EXAMPLES, _NOTES)
    made.add_argument("--json", action="store_true", help="print JSON")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command; see `hilbench.ports.states`."""
    from hilbench.exit_codes import ExitCode
    from hilbench.files.host import this_host
    from hilbench.files.names import json_text
    from hilbench.ports.listing import list_ports
    from hilbench.ports.states import as_data, as_text, port_states
    from hilbench.terminal.console import Console

    console = Console()
    states = port_states(this_host(), list_ports())
    if parsed.json:
        console.data(json_text(as_data(states)))
    elif states:
        console.data(as_text(states))
    else:
        console.narrate("there is no serial port here; plug a board in, or in a container pass it with --device")
    return ExitCode.OK
