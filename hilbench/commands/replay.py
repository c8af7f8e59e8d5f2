"""``hilbench replay``."""

from __future__ import annotations

import argparse
from pathlib import Path

from hilbench.commands.dashboard import require_terminal
from hilbench.parser import Parser

_EXAMPLES = """
hilbench replay session.jsonl      of 'hilbench --journal', or of any other command that writes a journal
"""

_NOTES = """
p plays; left and right go a second back and on, with shift ten; , and . go event by event; e finds the next error,
E the one before. A click on the line of time goes there.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench replay", "Look at a journal in the dashboard, at any moment of it.", _EXAMPLES, _NOTES)
    made.add_argument("journal", metavar="JOURNAL", help="the file")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command.

    Raises:
        UsageError: the file is no journal; this is no terminal.
        UnavailableError: the file cannot be read.
    """
    require_terminal("'hilbench decode' does without")
    from hilbench.journal import Journal
    from hilbench.tui.app import Dashboard
    from hilbench.tui.memory import Memory, state_file
    from hilbench.tui.model.replay import Replay
    from hilbench.tui.recorded import RecordedBench

    recording = Journal.read(parsed.journal)
    process = RecordedBench(Path(parsed.journal), recording.problem)
    Dashboard(process, Replay(recording.header, recording.events), memory=Memory(state_file())).run()
    return 0
