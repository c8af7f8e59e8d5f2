"""What a person, a CI system and a program get to see of a run."""

from __future__ import annotations

from pathlib import Path

from hilbench.check.report import junit, matrix
from hilbench.check.report.schema import report_json
from hilbench.check.results import Report
from hilbench.console import Console
from hilbench.errors import UsageError
from hilbench.files import check_writable, write_atomically
from hilbench.options import CheckOptions


def check_outputs(options: CheckOptions) -> None:
    """Make sure that the files asked for can be written.

    Raises:
        UsageError: one cannot.
    """
    json = None if options.json in {None, "-"} else Path(str(options.json))
    taken = {Path(suite).resolve(): f"--suite {suite}" for suite in options.suites}
    if options.bench is not None:
        taken[Path(options.bench).resolve()] = "the bench file"
    for option, path in (("--junit", options.junit), ("--json", json), ("--journal", options.journal)):
        if path is None:
            continue
        check_writable(path, option)
        if path.resolve() in taken and not path.is_char_device():
            raise UsageError(f"would overwrite {taken[path.resolve()]}", where=f"{option} {path}")
        taken[path.resolve()] = option


def write_report(report: Report, options: CheckOptions, console: Console) -> None:
    """Print the matrix and write the files that were asked for.

    The matrix goes to standard error when the JSON report takes standard output.

    Raises:
        UnavailableError: a file cannot be written.
    """
    if options.json == "-":
        console.data(report_json(report))
        console.narrate(matrix.render(report, colours=False, width=None))
    else:
        width = console.width if console.terminal else None
        console.data(matrix.render(report, colours=console.colours, width=width))
    if options.json not in {None, "-"}:
        write_atomically(Path(str(options.json)), f"{report_json(report)}\n")
    if options.junit is not None:
        write_atomically(options.junit, junit.junit_xml(report))
