"""``hilbench export``."""

from __future__ import annotations

import argparse
from pathlib import Path

from hilbench.cli.protocol_flags import ProtocolParser
from hilbench.errors import UsageError
from hilbench.exit_codes import ExitCode
from hilbench.terminal import arguments
from hilbench.terminal.parser import Parser, typed

_EXAMPLES = """
hilbench export run.jsonl --mcap run.mcap                   for Foxglove
hilbench export check.jsonl --pcapng check.pcapng           for Wireshark
hilbench export run.jsonl --vcd pins.vcd --csv events.csv   for GTKWave or PulseView, and for a spreadsheet
hilbench export board.jsonl --mcap board.mcap --types /opt/ros/jazzy/share     topics with types of your own
hilbench export check.jsonl --case p2os-server/sync0_is_echoed --mcap one.mcap
"""

_NOTES = """
JOURNAL may be any recording that hilbench reads: a journal (--journal), pcapng, MCAP, or a table of --csv. A
truncated one is exported as far as it goes. FILE may be a pipe or /dev/stdout. Cases, each with a bench time of its
own, follow each other. docs/recordings.md says what each format contains.
Exit code 0: written; 2: wrong usage, or nothing to write; 3: a file cannot be read or written.
"""

_FORMATS = ("mcap", "ros2", "pcapng", "vcd", "csv")


def parser() -> Parser:
    """Return the parser of this command."""
    made = ProtocolParser("hilbench export", "Write a journal in the formats of other programs.", _EXAMPLES, _NOTES)
    add = made.add_argument
    add("journal", metavar="JOURNAL", type=Path, help="the recording")
    add("--mcap", metavar="FILE", type=typed(arguments.output_file),
        help="everything, with decoded frames, topics of ROS 2, poses and a log: Foxglove")  # fmt: skip
    add("--ros2", metavar="FILE", type=typed(arguments.output_file),
        help="the topics of ROS 2 alone, as MCAP for 'ros2 bag'")  # fmt: skip
    add("--pcapng", metavar="FILE", type=typed(arguments.output_file),
        help="the bytes of the lines, and what happened as comments: Wireshark")  # fmt: skip
    add("--vcd", metavar="FILE", type=typed(arguments.output_file), help="the pins as waveforms: GTKWave, PulseView")
    add("--csv", metavar="FILE", type=typed(arguments.output_file), help="everything, a line for each event")
    add("--case", metavar="ID", default="", help="only this case of a journal of 'hilbench check'")
    add("--protocol", metavar="PROTOCOL",
        help="the protocol for the frames of --mcap (default: the one that fits most bytes)")  # fmt: skip
    add("--types", metavar="FOLDER", type=typed(arguments.folder), action="append", default=[],
        help="where definitions of ROS 2 stand, for --mcap and --ros2: PACKAGE/msg/NAME.msg in it")  # fmt: skip
    add("--json", action="store_true", help="print what was written as JSON")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Write, say what was written, and return the exit code."""
    from hilbench.benchfile.inputs import plugin_files
    from hilbench.files import check_writable, is_standard_output, refuse_overwriting
    from hilbench.files.names import json_text
    from hilbench.recordings.export import export
    from hilbench.recordings.layout import of_case
    from hilbench.recordings.reading import read_recording
    from hilbench.recordings.remarks import remarks_on
    from hilbench.terminal.console import Console

    outputs = {name: getattr(parsed, name) for name in _FORMATS if getattr(parsed, name) is not None}
    if not outputs:
        raise UsageError("says no format", where="export", hint="one of --mcap, --ros2, --pcapng, --vcd and --csv")
    refuse_overwriting(
        ((f"--{name}", path) for name, path in outputs.items()), [("the recording", parsed.journal), *plugin_files()]
    )
    for name, path in outputs.items():
        check_writable(path, f"--{name}")
    taken = next((name for name, path in outputs.items() if is_standard_output(path)), None)
    if taken is not None and parsed.json:
        raise UsageError(f"--{taken} is written to the standard output", where="--json", hint="name a file")
    console, where = Console(), str(parsed.journal)
    recording = of_case(read_recording(parsed.journal), parsed.case, where)
    written = export(recording, outputs, parsed.protocol, where, parsed.types)
    for remark in remarks_on(recording.header, recording.problem, "written"):
        console.narrate(f"{where}: {remark}")
    if parsed.json:
        files = [{"file": str(one.path), "events": one.events, "remark": one.remark} for one in written]
        console.data(json_text({"format": 1, "complete": recording.problem is None, "files": files}))
    else:
        for one in written:
            remark = f" ({one.remark})" if one.remark else ""
            tell = console.data if taken is None else console.narrate
            tell(f"wrote {one.path}: {one.events} events{remark}")
    return ExitCode.OK
