"""What a person, a CI system and a program get to see of a run."""

from __future__ import annotations

from pathlib import Path

import msgspec

from hilbench.check.report import ci, junit, matrix
from hilbench.check.report.schema import report_json
from hilbench.check.results import Report
from hilbench.check.screens import make_folder
from hilbench.errors import HilbenchError, UnavailableError
from hilbench.exit_codes import ExitCode, worst
from hilbench.files import Named, check_writable, refuse_overwriting, write_atomically
from hilbench.terminal.console import Console
from hilbench.terminal.options import CheckOptions


def check_outputs(options: CheckOptions) -> None:
    """Make sure that the files asked for can be written, and are not what is read.

    Raises:
        UsageError: one cannot, or is.
    """
    for option, path in options.outputs():
        if path is not None:
            check_writable(path, option)
    if options.screens is not None:
        make_folder(options.screens)
    suites: list[Named] = [(f"--suite {suite}", Path(suite)) for suite in options.suites]
    bench = None if options.bench is None else Path(options.bench)
    refuse_overwriting(options.outputs(), [*suites, ("the bench file", bench)])


def write_report(report: Report, options: CheckOptions, console: Console, lost: HilbenchError | None = None) -> int:
    """Write the files that were asked for, and print the matrix.

    The matrix goes to standard error when the JSON report takes standard output. It comes last, and also when a file
    could not be written: the exit code in it is that of the process.

    Args:
        report: what to tell.
        options: where to.
        console: for what is printed.
        lost: what could not be written already.

    Returns:
        The exit code.

    Raises:
        UnavailableError: the standard output cannot be written.
    """
    for write in (_write_junit, _write_json, _write_code_quality, _write_html):
        try:
            write(report if lost is None else _without_files(report), options)
        except UnavailableError as error:
            lost = lost or error
    if lost is not None:
        report = _without_files(report)
    _print(report, options, console)
    if lost is not None:
        console.narrate(f"hilbench: {lost}")
    return report.exit_code


def _without_files(report: Report) -> Report:
    """Return the report of a run of which a file could not be written; what outranks that, an interruption, stays."""
    code = worst([ExitCode(report.exit_code), ExitCode.UNAVAILABLE])
    if code == report.exit_code:
        return report
    return msgspec.structs.replace(report, exit_code=int(code), exit_meaning="a file could not be written")


def _print(report: Report, options: CheckOptions, console: Console) -> None:
    if options.json == "-":
        console.data(report_json(report))
        console.narrate(matrix.render(report, colours=False, width=None, quiet=options.quiet))
    else:
        width = console.width if console.terminal else None
        console.data(matrix.render(report, colours=console.colours, width=width, quiet=options.quiet))


def _write_json(report: Report, options: CheckOptions) -> None:
    if options.json not in {None, "-"}:
        write_atomically(Path(str(options.json)), f"{report_json(report)}\n")


def _write_junit(report: Report, options: CheckOptions) -> None:
    if options.junit is not None:
        write_atomically(options.junit, junit.junit_xml(report))


def _write_code_quality(report: Report, options: CheckOptions) -> None:
    if options.code_quality is not None:
        write_atomically(options.code_quality, ci.code_quality(report, options))


def _write_html(report: Report, options: CheckOptions) -> None:
    if options.html is None:
        return
    from hilbench.check.page import html_page, run_of_report
    from hilbench.recordings.reading import read_recording

    recording = read_recording(options.journal) if options.journal is not None else None
    name = str(report.bench.get("bench", "run"))
    write_atomically(options.html, html_page([run_of_report(report, name, recording)], screens=options.screens))
