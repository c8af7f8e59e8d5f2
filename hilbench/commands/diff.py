"""``hilbench diff``."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from hilbench.errors import UsageError
from hilbench.exit_codes import ExitCode
from hilbench.terminal import arguments
from hilbench.terminal.parser import Parser, typed

_SHOWN = 4
_EXAMPLES = """
hilbench diff pins.jsonl adapter.jsonl --pins 'brain.PB[567]' --order-only
hilbench diff run.jsonl analyser.csv --map D0=brain.PB7 --map D1=brain.PB6 --tolerance 1ms
hilbench diff check.jsonl check.jsonl --case bluepill-pins/A --case bluepill-pins/B --json
hilbench diff yesterday.jsonl today.jsonl --events               the first event that differs, case by case
hilbench diff run.jsonl replayed.jsonl --events --only 'checker rx' --tolerance 5ms
"""

_NOTES = """
A recording is a journal (of run, serve or check), waveforms (.vcd), or a table as logic analysers export it (.csv: a
column of times, 'Time [s]' or in ms, us, ns or ps, then one for each pin). Both are laid over each other at the first
change they have in common, and compared until the first of them ends. If the other one has changes after that, they are
different, unless that end is the one of a journal that was closed, or --common or --until asks for no more. In a
capture that does not show it, a wire that floats counts as low.
With --events all that happened is compared, not what the pins did: events of recordings in any format that
'hilbench export' has, case by case, the n-th of a source and kind in A with the n-th in B.
Exit code 0: equal, up to the tolerance; 1: different; 2: wrong usage, or nothing to compare; 3: a file cannot be read.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench diff", "Compare two recordings: their pins, or all their events.", _EXAMPLES, _NOTES)
    add = made.add_argument
    add("a", metavar="A", help="journal, VCD or CSV")
    add("b", metavar="B", help="journal, VCD or CSV")
    add("--case", metavar="ID", action="append", default=[],
        help="case of a journal of 'hilbench check'; twice for one of A and one of B")  # fmt: skip
    add("--map", metavar="NAME=NET", action="append", default=[], type=typed(_named),
        help="a column or variable of a capture is this pin, such as D0=brain.PB7 (repeatable)")  # fmt: skip
    add("--pins", metavar="GLOB", action="append", default=[],
        help="compare these signals only, such as 'PB*' (repeatable)")  # fmt: skip
    add("--order-only", action="store_true", help="compare the order of the changes, not their times")
    add("--tolerance", metavar="TIME", type=typed(arguments.duration_ns), default=0,
        help="how far times may differ, such as 10ms (default: 0)")  # fmt: skip
    add("--until", metavar="TIME", type=typed(arguments.duration_ns),
        help="compare only this long from the first common change, such as 10s")  # fmt: skip
    add("--common", action="store_true", help="compare only the time that both cover")
    add("--events", action="store_true", help="compare events, not pins: the first one that is not the same")
    add("--only", metavar="GLOB", action="append", default=[],
        help="with --events: these only, 'SOURCE KIND', such as 'checker rx' or '* verdict' (repeatable)")  # fmt: skip
    add("--json", action="store_true", help="print the comparison as JSON")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Compare, print, and return the exit code."""
    if parsed.events:
        return _events(parsed)
    if parsed.only:
        raise UsageError("is about events", where="--only", hint="give --events, too; for pins it is --pins")

    from hilbench.diff.compare import Options, compare, span
    from hilbench.diff.files import check_mapping, named, read_capture
    from hilbench.terminal.console import Console

    mapping = dict(parsed.map)
    if len(mapping) != len(parsed.map):
        raise UsageError("names a column twice", where="--map")
    a_case, b_case = _cases(parsed.case)
    a, b = read_capture(Path(parsed.a), a_case), read_capture(Path(parsed.b), b_case)
    for case in {a_case, b_case} - {a.case, b.case}:
        raise UsageError("is no case of these recordings: they have none", where=f"--case {case}")
    check_mapping(mapping, a, b)
    a = named(a, b, mapping)
    b = named(b, a, mapping)
    options = Options(
        pins=tuple(parsed.pins),
        order_only=parsed.order_only,
        tolerance_ns=parsed.tolerance,
        until_ns=parsed.until,
        common=parsed.common,
    )
    comparison = compare(a, b, options)
    if comparison.empty:
        about = f"no change of any signal is in both recordings, which were compared for {span(comparison.span_ns)}"
        apart = [f"{name}: {why}" for name, why in comparison.left_out.items()]
        raise UsageError(f"nothing to compare: {about}", hint="; ".join(apart[:_SHOWN]))
    if parsed.json:
        from hilbench.diff.report import as_data
        from hilbench.files.names import json_text

        Console().data(json_text(as_data(comparison)))
    else:
        from hilbench.diff.report import as_text

        Console().data(as_text(comparison))
    return ExitCode.OK if comparison.first is None else ExitCode.VIOLATION


def _events(parsed: argparse.Namespace) -> int:
    from hilbench.diff.events import EventOptions, as_data, as_text, compare_events
    from hilbench.files.names import json_text
    from hilbench.recordings.reading import read_recording
    from hilbench.terminal.console import Console

    of_pins = {"--map": parsed.map, "--pins": parsed.pins, "--until": parsed.until, "--common": parsed.common}
    for option, value in of_pins.items():
        if value:
            raise UsageError("is about pins", where=option, hint="leave out it or --events")
    if len(parsed.case) > 1:
        raise UsageError("with --events it is the same case in both", where="--case")
    a, b = read_recording(Path(parsed.a)), read_recording(Path(parsed.b))
    options = EventOptions(
        only=tuple(parsed.only),
        case="".join(parsed.case),
        order_only=parsed.order_only,
        tolerance_ns=parsed.tolerance,
    )
    found = compare_events(a, b, options)
    if not any(case.a or case.b for case in found.cases):
        raise UsageError("nothing to compare: no such event is in either", where="--events")
    if parsed.json:
        Console().data(json_text(as_data(found, parsed.a, parsed.b)))
    else:
        Console().data(as_text(found, parsed.a, parsed.b))
    return ExitCode.OK if found.equal else ExitCode.VIOLATION


def _named(text: str) -> tuple[str, str]:
    name, _, net = text.rpartition("=")
    if not name or not net:
        raise ValueError(f"'{text}' is not NAME=NET, such as D0=brain.PB7")
    return name, net


def _cases(chosen: Sequence[str]) -> tuple[str, str]:
    """Return the cases of A and of B; one alone is meant for whichever has cases."""
    if len(chosen) > 2:
        raise UsageError("more than two cases for two recordings", where="--case")
    return (chosen[0], chosen[-1]) if chosen else ("", "")
