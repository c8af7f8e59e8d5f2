"""``hilbench shrink``."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from hilbench.errors import UsageError
from hilbench.exit_codes import ExitCode
from hilbench.terminal import arguments, interruption
from hilbench.terminal.parser import Parser, typed

if TYPE_CHECKING:
    from hilbench.campaign.point import Point
    from hilbench.campaign.shrinking import Entries, Shrinker
    from hilbench.terminal.console import Console

_EXAMPLES = """
hilbench shrink noisy.toml -k S36                     which faults does the failure of S36 need?
hilbench shrink noisy.toml -k S36 --seed 7 --write small.toml
hilbench shrink pioneer --set 'faults=[...]' -k S36   same arguments as a failing 'hilbench check'
"""

_NOTES = """
It removes faults and stimuli, half of them at a time, as long as the same clause still fails (without --clause: the
first that fails). Each entry that remains is needed: without it the clause does not fail. Then it reduces counts and
durations. The arguments are those of 'hilbench check': take a line that a campaign or a report prints, and replace
'check' by 'shrink'.
Exit code 0: reduced, or nothing could be left out; 2: wrong usage, or nothing fails; 3, 5: as 'hilbench check'.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser(
        "hilbench shrink",
        "Reduce the faults and stimuli of a bench to those that a failing clause needs.",
        _EXAMPLES,
        _NOTES,
    )
    add = made.add_argument
    add("bench", metavar="BENCH", help="built-in bench or bench file")
    add("--suite", metavar="S", action="append", default=[], help="as that of 'hilbench check'")
    add("-k", dest="select", metavar="EXPR", default="", help="as that of 'hilbench check'")
    add("--set", metavar="KEY=VALUE", dest="changes", action="append", default=[], type=typed(_written),
        help="as that of 'hilbench check'")  # fmt: skip
    add("--seed", metavar="N", type=typed(arguments.seed), default=0, help="seed of the run (default: 0)")
    add("--clause", metavar="ID", default="", help="the clause that must still fail (default: the first that fails)")
    add("--write", metavar="FILE", type=typed(arguments.output_file), help="write the reduced bench as a bench file")
    made.add_plain()
    return made


def _written(text: str) -> str:
    """Read ``KEY=VALUE``, and leave it as it is."""
    from hilbench.strict.changes import parse_change

    return parse_change(text).text


def run(parsed: argparse.Namespace) -> int:
    """Run the command, and return the exit code."""
    from hilbench.campaign.point import Point
    from hilbench.campaign.shrinking import SHRUNK, Shrinker
    from hilbench.files import check_writable, refuse_overwriting
    from hilbench.terminal.console import Console

    console = Console()
    if parsed.write is not None:
        check_writable(parsed.write, "--write")
        refuse_overwriting([("--write", parsed.write)], [("the bench file", Path(parsed.bench))])
    point = Point(
        bench=parsed.bench,
        seed=parsed.seed,
        changes=tuple(parsed.changes),
        suites=tuple(parsed.suite),
        select=parsed.select,
    )
    path, data = _data(point)
    entries = {key: data[key] for key in SHRUNK if isinstance(data.get(key), list) and data[key]}
    if not entries:
        hint = "it takes a bench with [[faults]] or stimuli, or --set 'faults=[...]'"
        raise UsageError("has no faults and no stimuli to leave out", where=parsed.bench, hint=hint)
    interruption.raise_once()
    clause = _failing(point, parsed.clause)
    shrinker = Shrinker(_fails(point, clause, entries))
    with console.progress() as show:
        shrinker.fails = _shown(shrinker, show, clause)
        left = shrinker.shrink(entries)
    small = _with(point, left)
    _report(small, clause, shrinker.runs, entries, left, console)
    if parsed.write is not None:
        _write(data | left, path, parsed.write)
    return ExitCode.OK


def _data(point: Point) -> tuple[Path, dict[str, Any]]:
    """Return the bench file of a point, and what stands in it, with the point's changes.

    Raises:
        UsageError: it is wrong.
    """
    from hilbench.benchfile.reader import open_bench
    from hilbench.strict.changes import parse_change
    from hilbench.strict.toml_file import TomlFile

    changes = tuple(map(parse_change, point.changes))
    path = open_bench(point.bench, changes=changes).path
    assert path is not None  # a bench that has a name stands in a file
    return path, TomlFile(path, "bench file", changes=changes).data


def _failing(point: Point, wanted: str) -> str:
    """Return the clause that fails with all that the bench does."""
    from hilbench.campaign.point import run_point

    outcome = run_point(point)
    if outcome.verdict == "error":
        raise UsageError(f"cannot be run: {outcome.cause}", where=point.bench)
    failing = [clause.id for clause in outcome.clauses if clause.verdict == "fail"]
    if wanted and wanted not in failing:
        hint = f"these do: {', '.join(failing)}" if failing else "none does"
        raise UsageError(f"{wanted} does not fail here", where="--clause", hint=hint)
    if not failing:
        raise UsageError("no clause fails, so there is nothing to reduce", where=point.bench)
    return wanted or failing[0]


def _fails(point: Point, clause: str, entries: Entries) -> Callable[[Entries], bool]:
    """Return what says whether a clause fails: of its own cases alone, if they fail without those before them."""
    import msgspec

    from hilbench.campaign.point import run_point

    narrow = msgspec.structs.replace(point, select=f"({point.select}) and {clause}" if point.select else clause)

    def fails(those: Entries, of: Point = narrow) -> bool:
        outcome = run_point(_with(of, those))
        return any(one.id == clause and one.verdict == "fail" for one in outcome.clauses)

    return fails if fails(entries) else lambda those: fails(those, point)


def _with(point: Point, entries: Entries) -> Point:
    import msgspec

    from hilbench.strict.changes import change_text, parse_change

    kept = tuple(text for text in point.changes if parse_change(text).path[0] not in entries)
    put = tuple(change_text(key, list(of)) for key, of in entries.items())
    return msgspec.structs.replace(point, changes=kept + put)


def _shown(shrinker: Shrinker, show: Callable[[str], None], clause: str) -> Callable[[Entries], bool]:
    fails = shrinker.fails

    def shown(entries: Entries) -> bool:
        show(f"{clause}: run {shrinker.runs}, with {sum(map(len, entries.values()))} entries")
        return fails(entries)

    return shown


def _report(point: Point, clause: str, runs: int, before: Entries, left: Entries, console: Console) -> None:
    from hilbench.campaign.point import command_of
    from hilbench.files.names import escaped, printable
    from hilbench.strict.changes import toml_value

    many, few = (sum(map(len, entries.values())) for entries in (before, left))
    said = f"with {few} of {many} entries" if few else f"without any of the {many} entries"
    entries = [f"  {toml_value(entry)}" for of in left.values() for entry in of]
    lines = [f"{clause} fails {said}; {runs} runs", *entries, command_of(point)]
    console.data("\n".join(printable(escaped(line)) for line in lines))


def _write(data: dict[str, Any], bench: Path, file: Path) -> None:
    """Write the reduced bench, unless it is none at that place: what is there already is left alone then.

    Raises:
        UsageError: its paths lead nowhere from there.
    """
    import tempfile

    from hilbench.benchfile.reader import read_bench
    from hilbench.errors import HilbenchError
    from hilbench.files import write_atomically
    from hilbench.strict.toml_writer import toml_text

    text = toml_text(data)
    try:
        if file.is_file() or not file.exists():
            with tempfile.NamedTemporaryFile("w", encoding="utf-8", dir=file.parent, suffix=".toml") as beside:
                beside.write(text)
                beside.flush()
                read_bench(Path(beside.name))
    except HilbenchError as error:
        message, hint = f"no bench there: {error.message}", f"its paths are relative to {bench.parent}"
        raise UsageError(
            message, where=f"--write {file}", hint=f"{hint}: write it there, or take the command"
        ) from None
    write_atomically(file, text)
