"""``hilbench decode``."""

from __future__ import annotations

import argparse

from hilbench.cli.protocol_flags import ProtocolParser
from hilbench.errors import UnavailableError
from hilbench.exit_codes import ExitCode
from hilbench.terminal.parser import Parser

_EXAMPLES = """
hilbench decode pkt capture.bin                      bytes as they stood on the line
xxd capture.bin | hilbench decode pkt -              or as a hex dump of any kind
echo 50 4B 54 21 01 00 E1 F0 0A | hilbench decode pkt
hilbench decode pkt check.jsonl --stream 'rover tx'  what the rover sent, from a journal
hilbench decode p2os session.pcapng                  a capture: pcapng, MCAP, or a table of 'hilbench export'
hilbench decode pkt --framing term --schema v1 --json < /dev/ttyACM0
hilbench decode p2os robot.bin --from target
"""

_NOTES = """
Each line has the offset of the first byte in its stream, then the name and fields of the frame. A line with !! has
bytes that are not a valid frame, with the reason; decoding continues with the next frame. Endless input is decoded as
it arrives.
Exit code 0: every byte belongs to a valid frame; 1: some do not; 2: wrong usage; 3: the input cannot be read, or the
output cannot be written; 130: interrupted.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = ProtocolParser("hilbench decode", "Show the bytes of a line as frames.", _EXAMPLES, _NOTES)
    add = made.add_argument
    add("protocol", metavar="PROTOCOL", help="the protocol; 'hilbench protocols' lists them")
    add("file", metavar="FILE", nargs="?", default="-", help="the file to read; - is standard input (the default)")
    add("--input", metavar="FORM", choices=("auto", "raw", "hex", "journal", "capture"), default="auto",
        help="bytes, hex dump, journal, or capture: pcapng, MCAP, CSV (default: auto, by how it begins)")  # fmt: skip
    add("--stream", metavar="NAME", action="append", default=[],
        help="only this stream of a journal or a capture, such as 'rover tx' (repeatable)")  # fmt: skip
    add("--from", dest="speaker", metavar="END", choices=("host", "target"),
        help="who sends, if the protocol needs it: host or target (default: target, or as a journal says)")  # fmt: skip
    add("--json", action="store_true", help="print JSON, an object a line")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Decode, print, and return the exit code."""
    import os

    from hilbench.decode.run import Totals, decode
    from hilbench.decode.sources import read_chunks
    from hilbench.terminal.console import Console

    console, totals = Console(), Totals()
    where = "standard input" if parsed.file == "-" else parsed.file
    try:
        descriptor = 0 if parsed.file == "-" else os.open(parsed.file, os.O_RDONLY)
    except OSError as error:
        raise UnavailableError(f"cannot be read: {error.strerror}", where=where) from error
    chunks = read_chunks(descriptor, where, parsed.input, lambda remark: console.narrate(f"{where}: {remark}"))
    for lines in decode(
        chunks,
        parsed.protocol,
        parsed.options,
        streams=frozenset(parsed.stream),
        speaker=parsed.speaker or "",
        as_json=parsed.json,
        totals=totals,
    ):
        console.data(lines)
        if console.reader_gone:
            break
    console.narrate(str(totals))
    return ExitCode.OK if totals.clean else ExitCode.VIOLATION
