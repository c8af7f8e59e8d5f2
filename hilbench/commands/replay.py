"""``hilbench replay``."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench.cli.protocol_flags import add_plugins, use_plugins
from hilbench.errors import UsageError
from hilbench.exit_codes import ExitCode
from hilbench.terminal import arguments, interruption
from hilbench.terminal.parser import Parser, typed

if TYPE_CHECKING:
    from hilbench.plugins.protocol import ProtocolPlugin
    from hilbench.terminal.options import CheckOptions

_EXAMPLES = """
hilbench replay session.jsonl                           look at it in the dashboard
hilbench replay session.pcapng                          or at another recording: pcapng, MCAP, CSV
hilbench replay session.jsonl --into pioneer            play it to a fresh virtual robot, in virtual time
hilbench replay check.jsonl --case p2os-server/move_goes_its_way --into serial:/dev/ttyUSB0@9600 --journal again.jsonl
"""

_NOTES = """
In the dashboard: p plays; left and right go a second back and on, with shift ten; , and . go event by event; e and E
find the next error and the one before; a click on the line of time goes there.
--into sends the host's bytes again, at the same times: in virtual time to a bench, a fresh one for each case, and in
real time to a port. It compares the frames that come back with those of the recording, but not their times: use
'hilbench diff --events' for these. A real robot hardly ever answers the same, as its position and battery differ.
Exit code with --into 0: the target has answered the same; 1: it has not; 2: wrong usage; 3: not available; 130:
interrupted.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    summary = "View a recording in the dashboard, at any moment, or replay it to a target."
    made = Parser("hilbench replay", summary, _EXAMPLES, _NOTES)
    add = made.add_argument
    add("journal", metavar="JOURNAL", help="the file")
    add("--into", metavar="BENCH|TARGET",
        help="play it to this: a bench, serial:PORT@BAUD, pty:PATH, any pyserial URL")  # fmt: skip
    add("--case", metavar="ID", default="", help="with --into: only this case of a journal of 'hilbench check'")
    add("--journal", metavar="FILE", dest="new_journal", type=typed(arguments.output_file),
        help="with --into: write the journal of what happens now")  # fmt: skip
    add("--seed", metavar="N", type=typed(arguments.seed), help="with --into: seed (default: that of the recording)")
    add("--json", action="store_true", help="with --into: print how it went as JSON")
    add_plugins(made)
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command.

    Raises:
        UsageError: the file is no recording; this is no terminal; nothing that can be played.
        UnavailableError: the file cannot be read; the target is not there.
    """
    use_plugins(parsed.plugin)
    if parsed.into is not None:
        return _into(parsed)
    for option, value in (("--case", parsed.case), ("--journal", parsed.new_journal), ("--json", parsed.json)):
        if value:
            raise UsageError("is for playing to a target", where=option, hint="say to which with --into")
    return _look(Path(parsed.journal))


def _look(path: Path) -> int:
    from hilbench.commands.dashboard import require_terminal, theme

    require_terminal("'hilbench decode' does without")
    from hilbench.recordings.piecewise import open_pieces
    from hilbench.tui.app import Dashboard
    from hilbench.tui.memory import Memory, state_file
    from hilbench.tui.model.replay import Replay
    from hilbench.tui.recorded import RecordedBench

    replay = Replay(open_pieces(path))
    Dashboard(RecordedBench(path), replay, memory=Memory(state_file()), theme=theme()).run()
    return ExitCode.OK


def _into(parsed: argparse.Namespace) -> int:
    from dataclasses import replace

    from hilbench.benchfile.inputs import plugin_files
    from hilbench.check.bench_provider import make_provider
    from hilbench.files import check_writable, refuse_overwriting
    from hilbench.files.names import json_text
    from hilbench.plugins.discovery import PLUGINS
    from hilbench.recordings.frames import spoken
    from hilbench.recordings.layout import laid_out, of_case
    from hilbench.recordings.reading import read_recording
    from hilbench.recordings.remarks import remarks_on
    from hilbench.recordings.replaying import replay_into
    from hilbench.terminal.console import Console

    path = Path(parsed.journal)
    outputs = [("--journal", parsed.new_journal)]
    refuse_overwriting(outputs, [("the recording", path), *plugin_files()])
    if parsed.new_journal is not None:
        check_writable(parsed.new_journal, "--journal")
    recording = of_case(read_recording(path), parsed.case, str(path))
    if parsed.seed is not None:
        recording = replace(recording, header={**recording.header, "seed": parsed.seed})
    at_port = _is_port(parsed.into)
    protocol = spoken(laid_out(recording.events), lambda one: bool(one.replay_bench) or not at_port)
    if protocol is None or (at_port and not protocol.replay_bench):
        wrong = "no protocol is known that makes frames of its bytes"
        wrong = wrong if protocol is None else f"{protocol.name} is spoken there, and its record names no replay_bench"
        names = ", ".join(one.name for one in PLUGINS.all() if one.replay_bench or not at_port)
        hint = f"that can be played: {names}"
        if protocol is not None:
            hint = f"--into BENCH plays it to a model of its own; at a port {hint}"
        raise UsageError(wrong, where=str(path), hint=hint)
    interruption.raise_once()
    provider = make_provider(_options(parsed, protocol))
    console = Console()
    for remark in remarks_on(recording.header, recording.problem, "played"):
        console.narrate(f"{path}: {remark}")
    reported = []
    try:
        for one in replay_into(recording, provider, protocol, str(path)):
            reported.append(one)
            if not parsed.json:
                console.data(_line(one.case, one.sent, one.recorded, one.answered))
                if not one.equal:
                    console.data(f"  first different: frame {one.number}")
                    console.data(f"  recorded  {one.before or '-'}\n  now       {one.now or '-'}")
    finally:
        provider.close()
    different = sum(not one.equal for one in reported)
    if parsed.json:
        from msgspec import to_builtins

        console.data(json_text({"format": 1, "equal": not different, "cases": to_builtins(reported)}))
    console.narrate("the target has answered the same" if not different else "the target has answered differently")
    return ExitCode.VIOLATION if different else ExitCode.OK


def _is_port(target: str) -> bool:
    """Say whether it is a port that is played to, and not a bench."""
    return ":" in target


def _line(case: str, sent: int, recorded: int, answered: int) -> str:
    name = f"{case}: " if case else ""
    return f"{name}{sent} bytes sent, {answered} frames answered, {recorded} recorded"


def _options(parsed: argparse.Namespace, protocol: ProtocolPlugin) -> CheckOptions:
    from hilbench.terminal.options import CheckOptions, TargetChoice

    spec = parsed.into.removeprefix("pty:")
    spec = f"serial:{spec}" if spec != parsed.into else spec
    at_port = _is_port(spec)
    return CheckOptions(
        bench=protocol.replay_bench if at_port else spec,
        targets=(TargetChoice(spec=spec),) if at_port else (),
        journal=parsed.new_journal,
        seed=parsed.seed or 0,
    )
