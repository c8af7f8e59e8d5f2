"""``hilbench check``."""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hilbench.cli.journal_options import add_journal, check_journal
from hilbench.cli.protocol_flags import add_plugins, use_plugins
from hilbench.terminal import arguments, interruption
from hilbench.terminal.options import THROUGH, CheckOptions
from hilbench.terminal.parser import Parser, typed

if TYPE_CHECKING:
    from hilbench.judging.provider import BenchProvider
    from hilbench.strict.changes import Change

_EXAMPLES = """
hilbench check                                   the bench in ./hilbench.toml, or else the virtual Pioneer
hilbench check pioneer --suite p2os-server -k 'S36 or watchdog'
hilbench check --target serial:/dev/ttyUSB0@9600 --suite p2os-server --junit report.xml
hilbench check rover -k 'P24D or P29D'             an emulated rover, each case on the image of its own profile
hilbench check vehicle --jobs auto                 on all processors: the same verdicts and the same run hash, sooner
hilbench check --suite pkt-board --target serial:/dev/ttyACM0@115200
hilbench check --suite pkt-board --target serial:serial=0668FF303430   chosen by USB serial number; see hilbench ports
hilbench check vehicle-model --target simulator=serial:/dev/ttyUSB0 --target stack=serial:/dev/ttyACM0
hilbench check rover --target serial:/dev/ttyACM0@115200 --operator    asks you to do what needs a hand on it
hilbench check rover --through rfc2217             whole suites through an endpoint of that kind, in virtual time
hilbench check pioneer --set world.scene=corridor -k M05     in another scene
hilbench check rover --last-failed -x              what did not pass last time, until one fails again
hilbench check --list --json -
"""

_NOTES = """
-k takes words joined by and, or, not and parentheses. The id of a clause selects that clause. Any other word selects
the cases with that text in their name, their suite, or the id or title of their clauses.
Precedence of exit codes: 130, 5, 3, 2, 1, 4, 0.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser(
        "hilbench check", "Run conformance suites on a target and report clause by clause.", _EXAMPLES, _NOTES
    )
    add = made.add_argument
    add(
        "bench",
        metavar="BENCH",
        nargs="?",
        help="built-in bench or bench file (default: ./hilbench.toml, else pioneer)",
    )
    add("--target", metavar="[NAME=]T", action="append", default=[], type=typed(arguments.target_choice),
        help="what to check instead of the bench file's target: pioneer, serial:PORT[@BAUD], any pyserial URL, by "
        "LINE=... where the checker has several lines; for a client under test listen:pty:PATH, listen:tcp:PORT or "
        "exec:COMMAND, with {pty} or {port}, and {report} if it tells what it understood; for a recording "
        "capture:FILE")  # fmt: skip
    add("--set", metavar="KEY=VALUE", dest="changes", action="append", default=[], type=typed(_change),
        help="replace a value of the bench file, as in world.scene=corridor or "
        "faults.0.probability=0.01")  # fmt: skip
    add("--suite", metavar="S", action="append", default=[],
        help="shipped suite, or a .py file or folder of your own (default: all shipped suites)")  # fmt: skip
    add("-k", dest="select", metavar="EXPR", default="", help="run only what matches")
    add("--list", action="store_true", help="list the cases with their bench time, and run nothing")
    add("--seed", metavar="N", type=typed(arguments.seed), default=0, help="seed of the run (default: 0)")
    add(
        "--strict",
        action="store_true",
        help="a failing 'should' counts like a 'must'; a 'must' that this bench cannot show is inconclusive",
    )
    add("--timeout-scale", metavar="X", type=typed(arguments.timeout_scale), default=1.0,
        help="wait X times longer for a slow target or host; the limits of clauses stay (default: 1)")  # fmt: skip
    add("--html", metavar="FILE", type=typed(arguments.output_file),
        help="write the whole run as one HTML page, with the last moments of each case that fails")  # fmt: skip
    add("--junit", metavar="FILE", type=typed(arguments.output_file), help="write JUnit XML")
    add("--json", metavar="FILE", help="write the report, or with --list the list, as JSON; - is standard output")
    add_journal(made)
    add("--jobs", metavar="N", type=typed(arguments.jobs), default=1,
        help="run cases of a virtual target in N processes, or in as many as there are processors: auto")  # fmt: skip
    add("--through", choices=THROUGH, default="",
        help="pass each byte of the checker's lines through such an endpoint, in virtual time")  # fmt: skip
    add("-x", dest="max_failures", action="store_const", const=1, default=0, help="stop at the first case that fails")
    add("--maxfail", dest="max_failures", metavar="N", type=typed(arguments.count),
        help="stop when N cases have failed")  # fmt: skip
    add("--last-failed", action="store_true",
        help="run only what did not pass last time on this bench and target; all, if it never ran")  # fmt: skip
    add("--rerun-inconclusive", metavar="N", type=typed(arguments.count), default=0,
        help="run an inconclusive case up to N more times, on a target in real time; never a failing one")  # fmt: skip
    add("--operator", action="store_true",
        help="ask at the terminal for actions and observations on a target at a port")  # fmt: skip
    add("--operator-hook", metavar="CMD", type=typed(arguments.command), default=(),
        help="run CMD for these requests, before or instead of --operator; as arguments and JSON")  # fmt: skip
    add("-q", "--quiet", action="store_true", help="print only the clauses that do not pass, and the last line")
    add("--ci", choices=("auto", "github", "gitlab", "none"), default="auto",
        help="show the result as that CI system does (default: the one that runs this)")  # fmt: skip
    add("--code-quality", metavar="FILE", type=typed(arguments.output_file),
        help="write the clauses that do not pass as a Code Quality report for GitLab")  # fmt: skip
    add("--screens", metavar="DIR", type=typed(arguments.output_file),
        help="save the dashboard's screen at the failure of each failing case: DIR/CASE.svg")  # fmt: skip
    add_plugins(made)
    made.add_plain()
    return made


def _change(text: str) -> Change:
    """Read ``KEY=VALUE``; what reads it is not loaded for ``--help``."""
    from hilbench.strict.changes import parse_change

    return parse_change(text)


def run(parsed: argparse.Namespace) -> int:
    """Run the command; see `hilbench.check.runner.run_check`."""
    from hilbench.check.runner import run_check
    from hilbench.files.names import escaped

    check_journal(parsed)
    use_plugins(parsed.plugin)
    options = CheckOptions(
        bench=_bench_of(parsed),
        targets=tuple(parsed.target),
        suites=tuple(parsed.suite),
        select=escaped(parsed.select),
        seed=parsed.seed,
        strict=parsed.strict,
        timeout_scale=parsed.timeout_scale,
        junit=parsed.junit,
        json=parsed.json,
        journal=parsed.journal,
        journal_max=parsed.journal_max,
        through=parsed.through,
        screens=parsed.screens,
        list_only=parsed.list,
        jobs=parsed.jobs,
        plugins=tuple(parsed.plugin),
        changes=tuple(parsed.changes),
        max_failures=parsed.max_failures,
        last_failed=parsed.last_failed,
        rerun_inconclusive=parsed.rerun_inconclusive,
        quiet=parsed.quiet,
        ci=parsed.ci,
        html=parsed.html,
        code_quality=parsed.code_quality,
        operator=parsed.operator,
        operator_hook=parsed.operator_hook,
    )
    return run_check(options, _provider_of, draw=_draw)


def _bench_of(parsed: argparse.Namespace) -> str | None:
    """Return the bench that is named, or the one of the settings where nothing is."""
    named: str | None = parsed.bench
    if named is not None or parsed.target or parsed.suite:
        return named
    from hilbench.benchfile.chosen import chosen_bench

    return chosen_bench()


def _provider_of(options: CheckOptions) -> BenchProvider:
    from hilbench.check.bench_provider import make_provider

    provider = make_provider(options)
    interruption.raise_once()
    return provider


def _draw(header: Mapping[str, Any], events: Sequence[Mapping[str, Any]], said: str) -> str:
    """Draw the screen of the dashboard; what draws it is loaded when the first case has failed, and not before."""
    from hilbench.tui.picture import draw

    return draw(header, events, said)
