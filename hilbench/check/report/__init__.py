"""What a person, a CI system and a program get to see of a run."""

from __future__ import annotations

from pathlib import Path

from hilbench.check.report import junit, matrix
from hilbench.check.report.schema import report_json
from hilbench.check.results import Report
from hilbench.console import Console
from hilbench.files import write_atomically
from hilbench.options import CheckOptions


def write_report(report: Report, options: CheckOptions, console: Console) -> None:
    """Write the files that were asked for, then print the matrix.

    The matrix goes to standard error when the JSON report takes standard output.

    Raises:
        UsageError: a file cannot be written.
    """
    if options.junit is not None:
        write_atomically(options.junit, junit.junit_xml(report))
    if options.json is None:
        console.data(matrix.render(report, colours=console.colours, width=console.width if console.terminal else None))
        return
    if options.json == "-":
        console.data(report_json(report))
        console.narrate(matrix.render(report, colours=False, width=None))
    else:
        write_atomically(Path(options.json), f"{report_json(report)}\n")
        console.data(matrix.render(report, colours=console.colours, width=console.width if console.terminal else None))
