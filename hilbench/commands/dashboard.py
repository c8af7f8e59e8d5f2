"""``hilbench`` without a command: the dashboard."""

from __future__ import annotations

import argparse
import contextlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench.errors import UnavailableError, UsageError
from hilbench.exit_codes import ExitCode
from hilbench.files import check_writable
from hilbench.files.built_in import built_in_benches
from hilbench.nearest import did_you_mean
from hilbench.terminal import arguments, interruption
from hilbench.terminal.options import DEFAULT_BENCH
from hilbench.terminal.parser import Parser, typed

if TYPE_CHECKING:
    from hilbench.tui.bench_process import BenchProcess

DEFAULT_FILE = Path("hilbench.toml")
_WORDS = 56
_NICE = 10
"""A tenth of the share that a bench gets where they compete (Linux, sched(7); choice)."""
_LOOPBACK = "127.0.0.1"
_HIGHEST_PORT = 65_535

_EXAMPLES = """
hilbench                         ./hilbench.toml if there is one, else the virtual Pioneer
hilbench pioneer --scene room-with-boxes
hilbench rover                   a built-in bench, a bench file, or BOARD:IMAGE
hilbench rover --target serial:/dev/ttyACM0@115200      a real one; nothing is sent to it until you drive
hilbench vehicle --target simulator=serial:/dev/ttyUSB0 --target stack=serial:/dev/ttyACM0
hilbench my-bench.toml --seed 7 --journal session.jsonl
hilbench rover --web             in a browser; prints the address, with a secret token
"""

_NOTES = """
The bench runs in a process of its own. q stops it or detaches from it; 'hilbench attach' returns to it. ? explains
the screen.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench", "Open the dashboard: watch a bench live, drive it, run checks on it.", _EXAMPLES, _NOTES)
    made.add_argument("what", metavar="TARGET|BENCH", nargs="?", help="as of 'hilbench serve'")
    made.add_argument("--target", metavar="[NAME=]T", action="append", default=[], type=typed(_target),
        help="use this as the target: serial:/dev/ttyUSB0@9600, or a pyserial URL; NAME: for which line")  # fmt: skip
    made.add_argument(
        "--scene", metavar="S", help="scene to stand in: a built-in name or a file, as of 'hilbench serve'"
    )
    made.add_argument("--seed", metavar="N", type=typed(arguments.seed), default=0, help="seed of the run (default: 0)")
    made.add_argument("--journal", metavar="FILE", type=typed(arguments.output_file), help="keep the journal there")
    made.add_argument("--web", metavar="PORT", nargs="?", const=0, type=typed(_port),
        help="show it in a browser, from this TCP port (default: a free one)")  # fmt: skip
    made.add_argument(
        "--web-host", metavar="ADDRESS", help="the address to serve it at (default: 127.0.0.1, this machine)"
    )
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command: start the bench, then show it.

    Raises:
        UsageError: there is no such bench, or its file is wrong; this is no terminal.
        UnavailableError: there is no place for the bench; of the browser's view, what serves it is missing.
    """
    if parsed.web is not None:
        _require_web()
    elif parsed.web_host is not None:
        raise UsageError("goes with --web", where="--web-host", hint="try 'hilbench --web'")
    else:
        require_terminal("try 'hilbench check' or 'hilbench --help'")
    if parsed.journal is not None:
        check_writable(parsed.journal, "--journal")
    theme()
    if not parsed.what and not parsed.target:
        from hilbench.benchfile.chosen import chosen_bench

        parsed.what = chosen_bench()
    from hilbench.tui.bench_process import BenchProcess

    name = parsed.what or ("" if DEFAULT_FILE.is_file() else DEFAULT_BENCH)
    if name not in built_in_benches() or parsed.scene is not None or parsed.target:
        name = _bench_named(parsed)
    # The bench starts while this process loads what draws it.
    words = [word for word in (parsed.what,) if word]
    words += [word for target in parsed.target for word in ("--target", target)]
    words += ["--scene", parsed.scene] if parsed.scene is not None else []
    words += ["--seed", str(parsed.seed)]
    words += ["--journal", str(parsed.journal.absolute())] if parsed.journal is not None else []
    if parsed.web is None:
        return show(BenchProcess.start(words, name=name))
    from hilbench.tui.web import serve_web

    interruption.raise_once()
    with contextlib.suppress(KeyboardInterrupt):
        serve_web(lambda: BenchProcess.start(words, name=name), parsed.web_host or _LOOPBACK, parsed.web)
    return ExitCode.OK


def _bench_named(parsed: argparse.Namespace) -> str:
    """Return the name of the bench; what is wrong in a file or with a target is said here, not on the dashboard."""
    from hilbench.commands.live import in_scene
    from hilbench.mcu.command_line import open_target

    bench_file = in_scene(open_target(parsed.what), parsed.scene)
    if parsed.target:
        from hilbench.live.attached import ports_asked

        ports_asked(bench_file, [arguments.target_choice(target) for target in parsed.target])
    return bench_file.name


def show(process: BenchProcess) -> ExitCode:
    """Show a bench until the person leaves it."""
    start = ahead_of_us()
    give_way()
    try:
        from hilbench.tui.app import Dashboard
        from hilbench.tui.bench_process import BenchProcess
        from hilbench.tui.memory import Memory, state_file

        def open_bench(name: str) -> BenchProcess:
            return start(lambda: BenchProcess.start([name], name=name))

        memory = Memory(state_file())
        dashboard = Dashboard(process, benches=_benches(), open_bench=open_bench, memory=memory, theme=theme())
        dashboard.run()
    except BaseException:
        process.stop()
        raise
    last = dashboard.process
    if _in_browser() and isinstance(last, BenchProcess) and last is not process and not last.detached:
        last.stop()  # a page that is closed is not asked
    if dashboard.return_code:  # its traceback stands on the terminal
        dashboard.process.stop()
        return ExitCode.DEFECT
    return last.never_began if isinstance(last, BenchProcess) else ExitCode.OK


def theme() -> str:
    """Return the theme of the settings; empty if they name none.

    Raises:
        UsageError: there is no such theme, or the settings are wrong.
    """
    from hilbench.terminal.settings import settings, settings_file

    chosen = settings().theme
    if not chosen:
        return ""
    from textual.theme import BUILTIN_THEMES

    if chosen not in BUILTIN_THEMES:
        hint = did_you_mean(chosen, BUILTIN_THEMES, "themes")
        raise UsageError(f"no theme '{chosen}'", where=str(settings_file()), hint=hint)
    return chosen


def ahead_of_us() -> Callable[[Callable[[], BenchProcess]], BenchProcess]:
    """Return what starts benches with the share of the processor that this process has now.

    On Linux each thread has its own niceness, and what it starts inherits that (setpriority(2)): a thread is kept from
    before we give way, for nobody gets a lower niceness back.
    """
    from concurrent.futures import ThreadPoolExecutor

    kept = ThreadPoolExecutor(1)
    kept.submit(int).result()  # it has a thread from the first task on
    return lambda start: kept.submit(start).result()


def give_way() -> None:
    """Let a bench that has begun go before what draws it, where there is not processor enough for both."""
    os.nice(_NICE)


def require_terminal(hint: str) -> None:
    """Make sure that there is somebody to show anything to.

    Raises:
        UsageError: there is not.
    """
    if _in_browser():
        return
    if not all(os.isatty(descriptor) for descriptor in (0, 1, 2)):
        raise UsageError("the dashboard needs a terminal, and this is none", hint=hint)
    if os.environ.get("TERM") in {None, "", "dumb"}:
        raise UsageError("the dashboard needs a terminal that can place its cursor (TERM)", hint=hint)


def _in_browser() -> bool:
    """Say whether what is shown goes to a page of `hilbench.tui.web`, and not to a terminal."""
    return os.environ.get("TEXTUAL_DRIVER") == "textual.drivers.web_driver:WebDriver"


def _require_web() -> None:
    import importlib.util

    if importlib.util.find_spec("textual_serve") is None:
        hint = "pip install 'hilbench[web]'"
        raise UnavailableError(
            "the package that shows the dashboard in a browser is not installed", where="--web", hint=hint
        )


def _port(text: str) -> int:
    if not text.isascii() or not text.isdigit() or int(text) > _HIGHEST_PORT:
        raise ValueError(f"'{text}' is no TCP port; write the bench first: hilbench BENCH --web PORT")
    return int(text)


def _target(text: str) -> str:
    arguments.target_choice(text)
    return text


def _benches() -> list[tuple[str, str]]:
    """Return the benches there are, each with the first words of its file."""
    files = list(built_in_benches().items())
    if DEFAULT_FILE.is_file():
        files.insert(0, (f"./{DEFAULT_FILE}", DEFAULT_FILE))
    return [(name, _first_words(file)) for name, file in files]


def _first_words(file: Path) -> str:
    try:
        first = file.read_text(errors="replace").partition("\n")[0]
    except OSError:
        return ""
    words = first.removeprefix("#").strip() if first.startswith("#") else ""
    return words if len(words) <= _WORDS else f"{words[: _WORDS - 1]}…"
