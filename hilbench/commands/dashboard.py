"""``hilbench`` without a command: the dashboard."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench import arguments
from hilbench.errors import UnavailableError
from hilbench.exit_codes import ExitCode
from hilbench.parser import Parser, typed

if TYPE_CHECKING:
    from hilbench.tui.bench_process import BenchProcess

_EXAMPLES = """
hilbench                         ./hilbench.toml if there is one, else the virtual Pioneer
hilbench rover                   a built-in bench, a bench file, or BOARD:IMAGE
hilbench my-bench.toml --seed 7 --journal session.jsonl
"""

_NOTES = """
The bench runs in a process of its own: q stops it or detaches from it, 'hilbench attach' returns. ? explains the
screen.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench", "Open a bench, see it live and act on it.", _EXAMPLES, _NOTES)
    made.add_argument("what", metavar="TARGET|BENCH", nargs="?", help="as of 'hilbench serve'")
    made.add_argument("--seed", metavar="N", type=typed(arguments.seed), default=0, help="seed of the run (default: 0)")
    made.add_argument("--journal", metavar="FILE", type=typed(arguments.output_file), help="keep the journal there")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command: start the bench, then show it.

    Raises:
        UsageError: there is no such bench, or its file is wrong.
        UnavailableError: this is no terminal, or there is no place for the bench.
    """
    require_terminal("'hilbench check' and 'hilbench serve' do without")
    from hilbench.config import open_bench
    from hilbench.mcu.command_line import open_target
    from hilbench.tui.bench_process import BenchProcess

    name = (open_target(parsed.what) if parsed.what is not None else open_bench()).name
    # The bench starts while this process loads what draws it.
    process = BenchProcess.start(parsed.what, name=name, seed=parsed.seed, journal=parsed.journal)
    return show(process)


def show(process: BenchProcess) -> int:
    """Show a bench until the person leaves it."""
    try:
        from hilbench.tui.app import Dashboard
        from hilbench.tui.bench_process import BenchProcess

        def open_bench(name: str) -> BenchProcess:
            return BenchProcess.start(name, name=name)

        Dashboard(process, benches=_benches(), open_bench=open_bench).run()
    except BaseException:
        process.stop()
        raise
    return ExitCode.OK


def require_terminal(hint: str) -> None:
    """Make sure that there is somebody to show anything to.

    Raises:
        UnavailableError: there is not.
    """
    import os

    if not all(os.isatty(descriptor) for descriptor in (0, 1, 2)):
        raise UnavailableError("this is no terminal", where="the dashboard", hint=hint)
    if os.environ.get("TERM") in {None, "", "dumb"}:
        raise UnavailableError("the terminal cannot place its cursor (TERM)", where="the dashboard", hint=hint)


def _benches() -> list[tuple[str, str]]:
    """Return the benches there are, each with the first words of its file."""
    from hilbench.config import BUILT_IN_FOLDER, DEFAULT_FILE, built_in_benches

    files = [(name, BUILT_IN_FOLDER / f"{name}.toml") for name in built_in_benches()]
    if DEFAULT_FILE.is_file():
        files.insert(0, (f"./{DEFAULT_FILE}", DEFAULT_FILE))
    return [(name, _first_words(file)) for name, file in files]


def _first_words(file: Path) -> str:
    try:
        first = file.read_text(errors="replace").partition("\n")[0]
    except OSError:
        return ""
    words = first.removeprefix("#").strip() if first.startswith("#") else ""
    return words if len(words) <= 56 else f"{words[:55]}…"
