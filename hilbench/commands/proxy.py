"""``hilbench proxy``."""

from __future__ import annotations

import argparse
from pathlib import Path

from hilbench.cli.journal_options import add_journal, check_journal
from hilbench.cli.protocol_flags import ProtocolParser
from hilbench.exit_codes import ExitCode
from hilbench.terminal import arguments, interruption
from hilbench.terminal.options import Clients
from hilbench.terminal.parser import Parser, typed

_EXAMPLES = """
hilbench proxy pty:./board serial:/dev/ttyACM0@115200              your program opens ./board instead
hilbench proxy tcp:8101 serial:/dev/ttyUSB0 --protocol p2os --journal session.jsonl
hilbench proxy pty:./rover rover-model --faults faults.toml --seed 7
hilbench proxy pty:./u1 bluepill:firmware.elf --protocol pkt
hilbench proxy serial:/dev/ttyUSB0@9600 rfc2217://192.168.1.20:4000@9600
"""

_NOTES = """
A is the client's side, B the board's. Each is an endpoint (pty:PATH, tcp:[HOST:]PORT, rfc2217:[HOST:]PORT), a serial
port or pyserial URL, or a virtual target. Without faults every byte passes unchanged. The file of --faults has
[[faults]] tables as a bench file does, each with towards = "a" or "b". Ctrl-C ends it, with exit code 0.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = ProtocolParser(
        "hilbench proxy", "Stand between a client and a board: look, record, inject faults.", _EXAMPLES, _NOTES
    )
    add = made.add_argument
    add("a", metavar="A", help="where the client is")
    add("b", metavar="B", help="where the board is")
    add("--clients", choices=[each.value for each in Clients], default=Clients.ALL,
        help="who is served if several clients connect: all, the newest, the first (default: all)")  # fmt: skip
    add("--faults", metavar="FILE", type=Path, help="faults to inject on the way (docs/faults.md)")
    add("--seed", metavar="N", type=typed(arguments.seed), default=0, help="seed of the random faults (default: 0)")
    add("--protocol", metavar="P", help="print what passes as frames of this protocol")
    add("--json", action="store_true", help="print frames as JSON, an object a line")
    add_journal(made)
    return made


def run(parsed: argparse.Namespace) -> ExitCode:
    """Stand in between until told to stop."""
    from hilbench.benchfile.inputs import lines_of, plugin_files
    from hilbench.files import refuse_overwriting, refuse_writing_into
    from hilbench.serving.proxy import ProxyOptions, proxy
    from hilbench.terminal.console import Console

    check_journal(parsed)
    options = ProxyOptions(
        a=parsed.a,
        b=parsed.b,
        clients=Clients(parsed.clients),
        faults=parsed.faults,
        seed=parsed.seed,
        journal=parsed.journal,
        journal_max=parsed.journal_max,
        protocol=parsed.protocol,
        reading=parsed.options,
    )
    outputs = [("--journal", options.journal)]
    refuse_overwriting(outputs, [("--faults", options.faults), *plugin_files()])
    refuse_writing_into(outputs, lines_of((options.a, options.b)))
    console = Console()
    interruption.raise_once()
    if parsed.protocol is None:
        return proxy(options, console.mention)

    from hilbench.decode.live import LiveDecoder

    decoder = LiveDecoder(parsed.protocol, parsed.options, console, as_json=parsed.json)
    try:
        code = proxy(options, console.mention, decoder.take)
    finally:
        decoder.close()
    skipped = f"; {decoder.skipped} bytes not shown" if decoder.skipped else ""
    unread = "; the last lines found no reader" if decoder.unread else ""
    console.mention(f"{decoder.totals}{skipped}{unread}")
    return code
