"""``hilbench campaign``."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench.exit_codes import ExitCode
from hilbench.terminal import arguments, interruption
from hilbench.terminal.parser import Parser, typed

if TYPE_CHECKING:
    from hilbench.campaign.campaign_file import Campaign
    from hilbench.campaign.point import Outcome, Point
    from hilbench.campaign.results import Results
    from hilbench.terminal.console import Console

_EXAMPLES = """
hilbench campaign faults.toml                          all points, on all processors; results in faults.sqlite
hilbench campaign faults.toml --list                   list the points as commands; run nothing
hilbench campaign faults.toml --html faults.html       the results as a page
hilbench campaign faults.toml --json -                 the same as data
hilbench campaign faults.toml --scheduler tcp://10.0.0.5:8786    on many hosts
"""

_NOTES = """
FILE says which check runs at which points: seeds, benches, and factors such as firmware images, faults and settings
(docs/campaigns.md). A point that has a result is not run again, so an interrupted campaign continues where it stopped.
A point counts as new if its bench, its firmware, its suite or hilbench has changed.
A campaign measures, so a point that fails is a result, not an error. Exit code 0: each point has a result; 2: wrong
usage, file or bench; 3, 5: some points could not be run and have no verdict; 130: interrupted, results are kept.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench campaign", "Run one check at many points, and compare the results.", _EXAMPLES, _NOTES)
    add = made.add_argument
    add("file", metavar="FILE", type=Path, help="campaign file, such as faults.toml")
    add("--results", metavar="FILE", type=Path, help="SQLite file of the results (default: beside FILE, as .sqlite)")
    add("--jobs", metavar="N", type=typed(arguments.jobs), default=0,
        help="processes that run points (default: auto, as many as there are processors)")  # fmt: skip
    add("--scheduler", metavar="ADDRESS", default="",
        help="run the points on the workers of this Dask scheduler, such as tcp://10.0.0.5:8786")  # fmt: skip
    add("--list", action="store_true", help="print the points as commands, and run nothing")
    add("--html", metavar="FILE", type=typed(arguments.output_file), help="write the results as one HTML page")
    add("--json", metavar="FILE", help="write the results as JSON; - is standard output")
    made.add_plain()
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command, and return the exit code."""
    from hilbench.campaign.campaign_file import read_campaign
    from hilbench.campaign.digests import inputs_of_point
    from hilbench.campaign.point import command_of, key_of
    from hilbench.campaign.results import Results
    from hilbench.files import check_writable, refuse_overwriting
    from hilbench.terminal.console import Console

    console = Console()
    campaign = read_campaign(parsed.file)
    if parsed.list:
        console.data("\n".join(command_of(point) for point in campaign.points))
        return ExitCode.OK
    path = parsed.results or parsed.file.with_suffix(".sqlite")
    json = None if parsed.json in {None, "-"} else Path(parsed.json)
    outputs = [("--html", parsed.html), ("--json", json), ("--results", path)]
    for option, file in outputs:
        if file is not None:
            check_writable(file, option)
    refuse_overwriting(outputs, [("the campaign file", parsed.file)])
    placed = [(key_of(point, inputs_of_point(point)), point) for point in campaign.points]
    with Results(path) as results:
        interruption.raise_once()
        try:
            _run(dict(placed), results, parsed, console)
        except KeyboardInterrupt:
            _show(campaign, placed, results, parsed, console)
            raise
        return _show(campaign, placed, results, parsed, console)


def _run(keys: Mapping[str, Point], results: Results, parsed: argparse.Namespace, console: Console) -> None:
    from hilbench.campaign.progress import shown

    known = results.known(keys)
    missing = {key: point for key, point in keys.items() if key not in known}
    if known:
        console.narrate(f"{len(known)} of {len(keys)} points have a result already")
    with shown(console, len(missing)) as show:
        for number, (key, outcome) in enumerate(_outcomes(missing, parsed)):
            if not (parsed.scheduler and number):  # workers have the files as they were when the first was given out
                _check_unchanged(key, missing[key])
            results.enter(key, missing[key], outcome)
            show(outcome)


def _check_unchanged(key: str, point: Point) -> None:
    """Require that what a point is made of is what it was: its result would be kept as that of other files.

    Raises:
        UnavailableError: it has changed.
    """
    from hilbench.campaign.digests import inputs_of_point
    from hilbench.campaign.point import key_of
    from hilbench.errors import UnavailableError

    if key_of(point, inputs_of_point(point)) != key:
        hint = "what was run before is kept: the same command goes on with what it is now"
        raise UnavailableError("its files have changed while points were run", where=point.bench, hint=hint)


def _outcomes(points: Mapping[str, Point], parsed: argparse.Namespace) -> Iterator[tuple[str, Outcome]]:
    if not points:
        return iter(())
    if parsed.scheduler:
        from hilbench.campaign.hosts import run_there

        return run_there(points, parsed.scheduler)
    from hilbench.campaign.processes import run_here

    return run_here(points, min(parsed.jobs or arguments.jobs("auto"), len(points)))


def _show(
    campaign: Campaign,
    placed: Sequence[tuple[str, Point]],
    results: Results,
    parsed: argparse.Namespace,
    console: Console,
) -> int:
    import msgspec

    from hilbench.campaign.point import command_of
    from hilbench.campaign.statistics import statistics
    from hilbench.campaign.summary import lines_of
    from hilbench.exit_codes import worst
    from hilbench.files import write_atomically

    # Two levels may come to the same point, which is run once then, and counts for both.
    known = results.known(dict(placed), errors=True)
    pairs = [(point, known[key]) for key, point in placed if key in known]
    found = statistics(pairs, campaign.factors, len(placed))
    data = msgspec.json.format(msgspec.json.encode(found)).decode()
    if parsed.html is not None:
        from hilbench.campaign.page import html_page

        write_atomically(parsed.html, html_page(found, pairs, campaign.path.name))
    if parsed.json == "-":
        console.data(data)
    else:
        if parsed.json is not None:
            write_atomically(Path(parsed.json), f"{data}\n")
        console.data("\n".join(lines_of(found)))
    for point, outcome in pairs:
        if outcome.verdict == "error":
            console.narrate(f"hilbench: {outcome.cause}; as: {command_of(point)}")
            break
    return worst([ExitCode(outcome.exit_code) for _, outcome in pairs if outcome.verdict == "error"])
