"""``hilbench demo``."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from typing import TYPE_CHECKING

from hilbench.cli.protocol_flags import add_plugins, use_plugins
from hilbench.errors import UnavailableError, UsageError
from hilbench.exit_codes import ExitCode
from hilbench.terminal.options import DEFAULT_DEMO
from hilbench.terminal.parser import Parser

if TYPE_CHECKING:
    from hilbench.plugins.demo import Demo, LiveBench
    from hilbench.tui.bench_process import BenchProcess

_EXAMPLES = """
hilbench demo
hilbench demo rover                the demo of a system, by name
"""

_NOTES = """
space pauses, n shows the next scene, q ends it. Nothing is faked: benches run live, in real time; checks run in
virtual time; the figures in the captions are measured. The exit code is 0 if everything was as the captions say, and 4
if something was not.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    summary = "Show in two minutes what hilbench does: a demo that plays by itself in the dashboard."
    made = Parser("hilbench demo", summary, _EXAMPLES, _NOTES)
    made.add_argument("system", metavar="SYSTEM", nargs="?", default=DEFAULT_DEMO,
        help=f"the system whose demo is played (default: {DEFAULT_DEMO})")  # fmt: skip
    add_plugins(made)
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command.

    Raises:
        UsageError: there is no such demo; this is no terminal.
        UnavailableError: a bench is not available.
    """
    from hilbench.commands.dashboard import require_terminal, theme

    require_terminal("start it in a terminal window")
    use_plugins(parsed.plugin)
    demo = _demo_of(parsed.system)
    chosen = theme()
    from hilbench.tui.bench_process import BenchProcess

    def start(bench: LiveBench) -> BenchProcess:
        words = [bench.bench, *(word for change in bench.changes for word in ("--set", change))]
        return BenchProcess.start(words, name=parsed.system)

    return _played(demo, start, chosen)


def _demo_of(name: str) -> Demo:
    """Return the demo of a system, for the physics that is installed."""
    from hilbench.plugins.discovery import PLUGINS
    from worlds import default_physics, physics_is_there

    PLUGINS.systems.get(name, "demo")
    demos = PLUGINS.systems.demos(physics=physics_is_there(default_physics()))
    if name not in demos:
        raise UsageError(f"the system '{name}' brings no demo", hint=f"these do: {', '.join(demos)}")
    return demos[name]


def _played(demo: Demo, start: Callable[[LiveBench], BenchProcess], theme: str) -> ExitCode:
    """Play a demo; then print how to continue, or what was not as the script says."""
    from hilbench.commands.dashboard import ahead_of_us, give_way
    from hilbench.terminal.console import Console

    process = start(demo.opening)
    with_our_share = ahead_of_us()
    give_way()
    try:
        from hilbench.tui.demo import DemoDashboard

        shown = DemoDashboard(demo, process, lambda bench: with_our_share(lambda: start(bench)), theme=theme)
        shown.run()
    except BaseException:
        process.stop()
        raise
    shown.process.stop()
    if shown.problem:
        raise UnavailableError(shown.problem, where="hilbench demo")
    for line in shown.playing.broken:
        Console().narrate(f"hilbench: demo: {line}")
    # 1 is Textual's own, whose traceback stands on the terminal.
    code = next((one for one in ExitCode if one == shown.return_code != 1), ExitCode.DEFECT)
    if code is ExitCode.OK and demo.after:
        Console().data(demo.after.strip("\n"))
    return code
