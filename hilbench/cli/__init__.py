"""The command line: finds the command, runs it, and turns what goes wrong into one line and an exit code.

A command is a module in `hilbench.commands` with ``SUMMARY``, ``parser()`` and ``run(arguments)``. Only the one that is
asked for is imported, and nothing heavy before it is known what to do: ``hilbench --help`` is there at once. A command
that opens what must be closed calls `hilbench.terminal.interruption.raise_once` before it does.
"""

from __future__ import annotations

import contextlib
import importlib
import io
import os
import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from hilbench import __version__
from hilbench.errors import HilbenchError, InternalError, UnavailableError, UsageError
from hilbench.exit_codes import ExitCode
from hilbench.files.built_in import built_in_benches
from hilbench.terminal import interruption

if TYPE_CHECKING:
    import argparse

COMMANDS = {
    "demo": "show in two minutes what hilbench does: a demo in the dashboard",
    "check": "run conformance suites on a target and report clause by clause",
    "campaign": "run one check with many seeds, images, faults or settings, and compare the results",
    "shrink": "reduce the faults and stimuli of a bench to those that a failing clause needs",
    "run": "run firmware on emulated boards, in virtual time",
    "decode": "show the bytes of a line as frames",
    "protocols": "list the installed protocols, with those of plug-ins",
    "export": "write a journal as MCAP, pcapng, VCD or CSV",
    "report": "make an HTML page from stored check runs, to read or to compare them",
    "render": "draw the world of a recording at one moment: obstacles, vehicle and path",
    "diff": "compare two recordings, by pins or event by event",
    "proxy": "sit between a client and a board: watch, record, inject faults",
    "serve": "offer a virtual target on a pty or a TCP port, in real time",
    "init": "write a bench file and a test for firmware of your own",
    "attach": "return to a bench that still runs after you left the dashboard",
    "replay": "view a recording in the dashboard, or replay it to a target",
    "doctor": "check this installation, measure the timing of a port, list what is modelled of a chip",
    "ports": "list serial ports: device, board, who uses it, and problems",
    "udev": "print or install udev rules: access to boards and adapters, stable names",
    "validate": "check a bench file for mistakes",
    "completion": "print a script that lets a shell complete commands, options and names",
}

_OF_DASHBOARD = frozenset({"--journal", "--scene", "--seed", "--target", "--web", "--web-host"})
"""Options of the dashboard, which need no bench before them."""
_OWN = frozenset({"live"})
"""Commands that hilbench itself gives to processes of its own."""

_LOOKS_FOR_ITSELF = frozenset({"doctor"})
"""Commands that tell of packages in the place of ours in their own way."""

_HELP = """\
usage: hilbench [BENCH]             the dashboard: a bench, live
       hilbench COMMAND [options]

A hardware-in-the-loop bench for serial protocol stacks.

commands:
{commands}

options:
  -h, --help  show this help; 'hilbench COMMAND --help' shows that of a command
  --version   show the version

examples:
  hilbench pioneer
  hilbench check pioneer
  hilbench check --target serial:/dev/ttyUSB0@9600 --suite p2os-server
  hilbench serve pioneer --pty ./p2
  hilbench run bluepill:firmware.elf --for 10s --follow
  hilbench init --board bluepill --image firmware.elf

exit codes:
    0  all checks passed
    1  the target violates a clause; the firmware crashed, or ended with a status other than 0
    2  wrong usage or bench file, nothing selected
    3  bench or target not available, or output that could not be written
    4  inconclusive
    5  defect in hilbench
  130  interrupted; what was recorded is complete and readable"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Args:
        argv: the words after ``hilbench``; those of the process by default.

    Returns:
        The exit code.
    """
    interruption.end_at_once()
    _prepare_streams()
    code = _answered(list(sys.argv[1:] if argv is None else argv))
    return _flushed(code)


def _answered(words: list[str]) -> int:
    try:
        return int(_dispatch(words))
    except KeyboardInterrupt:
        return _end("interrupted", ExitCode.INTERRUPTED)
    except InternalError as error:
        return _defect(error)
    except HilbenchError as error:
        return _end(str(error), error.exit_code)
    except BrokenPipeError:
        return ExitCode.OK
    except SystemExit as done:
        return done.code if isinstance(done.code, int) else ExitCode.OK
    except Exception as error:  # noqa: BLE001 - the last line of defence: whatever it is, it is ours
        return _defect(error)


def _dispatch(words: list[str]) -> int:
    if not words or words[0].partition("=")[0] in _OF_DASHBOARD or _is_bench(words[0]):
        return _run("dashboard", words)
    first = words[0]
    if first in {"-h", "--help", "help"}:
        _say(_HELP.format(commands="\n".join(f"  {name:<11}{what}" for name, what in COMMANDS.items())))
        return ExitCode.OK
    if first == "--version":
        _say(f"hilbench {__version__}")
        return ExitCode.OK
    if first not in COMMANDS and first not in _OWN:
        raise _unknown_command(first)
    return _run(first, words[1:])


def _run(name: str, words: list[str]) -> int:
    command = importlib.import_module(f"hilbench.commands.{name}")
    arguments = command.parser().parse_words(words)

    if name not in _LOOKS_FOR_ITSELF:
        from hilbench.cli.siblings import check_siblings

        check_siblings()
    _choose_plain(arguments)
    try:
        return int(command.run(arguments))
    finally:
        _report_plugins()


def _choose_plain(arguments: argparse.Namespace) -> None:
    """Print as into a file where the command has an option for that, and it or the settings say so."""
    from hilbench.terminal.console import Console

    if "plain" in arguments:
        from hilbench.terminal.settings import settings

        Console.plain = arguments.plain or settings().plain
    else:
        Console.plain = False


def _report_plugins() -> None:
    """Say of each plug-in that was looked at and cannot be used why that is: one line."""
    discovery = sys.modules.get("hilbench.plugins.discovery")
    for line in discovery.PLUGINS.lines_of_broken() if discovery is not None else ():
        _end(f"note: {line}", ExitCode.OK)


def _is_bench(word: str) -> bool:
    """Say whether a word that stands where a command does is a bench; a command of that name comes first."""
    if word.startswith("-") or word in COMMANDS or word in _OWN or word == "help":
        return False
    return word.endswith(".toml") or ":" in word or word in built_in_benches() or _is_of_plugin(word)


def _is_of_plugin(word: str) -> bool:
    """Say whether a bench of an installed system may have this name; none of its code is run to say so."""
    from hilbench.plugins.discovery import PLUGINS

    return PLUGINS.systems.is_of_stranger(word)


def _say(text: str) -> None:
    from hilbench.terminal.console import Console

    Console().data(text)


def _unknown_command(word: str) -> UsageError:
    from hilbench.nearest import did_you_mean, nearest

    if word.startswith("-"):
        known = ["--help", "--version", *sorted(_OF_DASHBOARD)]
        return UsageError(f"unknown option '{word}'", hint=did_you_mean(word, known, "options"))
    from hilbench.plugins.discovery import PLUGINS

    if word in PLUGINS.names():
        hint = "name a command, or a bench file whose target speaks it (docs/plugins.md)"
        return UsageError(f"'{word}' is a protocol", hint=hint)
    benches = [*built_in_benches(), *PLUGINS.systems.bench_names()]
    near = nearest(word, [*COMMANDS, *benches])
    return UsageError(f"unknown command '{word}'", hint=did_you_mean(word, [near] if near else COMMANDS, "commands"))


def _end(line: str, code: ExitCode) -> ExitCode:
    with contextlib.suppress(OSError, ValueError, AttributeError):
        print(f"hilbench: {line}", file=sys.stderr)
    return code


def _defect(error: BaseException) -> ExitCode:
    import tempfile
    import traceback

    what = " ".join(f"{type(error).__name__}: {error}".split())
    place = _place_in_plugin(error)
    try:
        descriptor, path = tempfile.mkstemp(prefix="hilbench-defect-", suffix=".txt")
        with os.fdopen(descriptor, "w", encoding="utf-8") as file:
            traceback.print_exception(error, file=file)
    except OSError:
        path = "no file: it could not be written"
    if place:
        return _end(f"{place}: {what} (traceback in {path})", ExitCode.USAGE)
    return _end(f"defect in hilbench: {what} (traceback in {path})", ExitCode.DEFECT)


def _place_in_plugin(error: BaseException) -> str:
    """Return file and line of a plug-in whose error it is; empty where it is ours."""
    discovery = sys.modules.get("hilbench.plugins.discovery")
    if discovery is None:
        return ""
    from hilbench.plugins.blame import place_of

    return place_of(error, discovery.PLUGINS.brought)


def _prepare_streams() -> None:
    """Let every name be printed, and what is closed of 0, 1 and 2 be taken, so that no file or port of ours gets it.

    What takes the place of a closed stream cannot be written to either: what is printed there is known to be lost.
    """
    for descriptor in (0, 1, 2):
        try:
            os.fstat(descriptor)
        except OSError:
            os.open(os.devnull, os.O_RDONLY)
    if sys.stdout is None:
        sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115 - a descriptor
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")


def _flushed(code: int) -> int:
    from hilbench.terminal.console import flush_data, flush_narration

    try:
        flush_data()
    except UnavailableError as error:
        said = _end(str(error), error.exit_code)
        return code if code in {ExitCode.INTERRUPTED, ExitCode.DEFECT} else said
    finally:
        flush_narration()
    return code
