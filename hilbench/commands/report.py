"""``hilbench report``."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench.errors import UnavailableError, UsageError
from hilbench.exit_codes import ExitCode
from hilbench.terminal import arguments
from hilbench.terminal.parser import Parser, typed

if TYPE_CHECKING:
    from hilbench.check.page import Run
    from hilbench.check.results import Report

_EXAMPLES = """
hilbench check rover --json old.json --journal old.jsonl        then again with the new firmware
hilbench report old.json old.jsonl new.json new.jsonl --html report.html
hilbench report run.jsonl > report.html
"""

_NOTES = """
RUN is a report of 'hilbench check --json', or a recording of 'hilbench check --journal'. A recording after a
report adds the last moments of its cases: frames with their fields, pins, the position of the vehicle. A recording
alone has verdicts by case. Several reports are columns, from left to right; 'changed' shows what differs.
The page needs no network and loads nothing.
Exit code 0: written; 2: wrong usage; 3: a file cannot be read or written.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench report", "Make one HTML page from stored check runs.", _EXAMPLES, _NOTES)
    made.add_argument("runs", metavar="RUN", nargs="+", type=Path, help="reports as JSON, recordings of the same runs")
    made.add_argument("--html", metavar="FILE", type=typed(arguments.output_file), help="default: standard output")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Write the page, and return the exit code."""
    from hilbench.check.page import html_page
    from hilbench.files import check_writable, refuse_overwriting, write_atomically
    from hilbench.terminal.console import Console

    if parsed.html is not None:
        check_writable(parsed.html, "--html")
        refuse_overwriting([("--html", parsed.html)], [(str(file), file) for file in parsed.runs])
    page = html_page(_runs(parsed.runs), screens=Path.cwd())
    if parsed.html is not None:
        write_atomically(parsed.html, page)
    else:
        Console().data(page)
    return ExitCode.OK


def _runs(files: Sequence[Path]) -> list[Run]:
    """Return the runs in some files: a recording belongs to the report before it.

    Raises:
        UnavailableError: a file cannot be read, or is neither.
    """
    from hilbench.check.page import run_of_journal, run_of_report
    from hilbench.recordings.reading import parse_recording

    found: list[Run] = []
    waiting: tuple[str, Report] | None = None
    for file in files:
        data = _read(file)
        report = _report_in(data, file)
        if report is not None:
            found += [run_of_report(waiting[1], waiting[0])] if waiting else []
            waiting = file.stem, report
        elif waiting is not None:
            found.append(run_of_report(waiting[1], waiting[0], parse_recording(data, str(file))))
            waiting = None
        else:
            found.append(run_of_journal(parse_recording(data, str(file)), file.stem))
    return found + ([run_of_report(waiting[1], waiting[0])] if waiting else [])


def _read(file: Path) -> bytes:
    try:
        return file.read_bytes()
    except OSError as error:
        raise UnavailableError(f"cannot be read: {error.strerror or error}", where=str(file)) from error


def _report_in(data: bytes, file: Path) -> Report | None:
    """Return the report that a file holds; None if it holds something else.

    Raises:
        UsageError: it is a damaged report, or one of a format of another version.
    """
    import msgspec

    from hilbench.check.results import FORMAT, Report

    if not data.lstrip().startswith(b"{") or b'"format"' not in data[:200] or data.startswith(b'{"kind":"journal"'):
        return None
    try:
        report = msgspec.json.decode(data, type=Report)
    except msgspec.MsgspecError as error:
        raise UsageError(f"is no report of 'hilbench check --json': {error}", where=str(file)) from error
    if report.format != FORMAT:
        raise UsageError(f"is a report of the format {report.format}, not {FORMAT}", where=str(file))
    return report
