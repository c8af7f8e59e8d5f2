"""The options of all commands that write a journal."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from hilbench.errors import UsageError
from hilbench.terminal import arguments
from hilbench.terminal.parser import typed

if TYPE_CHECKING:
    from hilbench.terminal.parser import Parser

__all__ = ["add_journal", "check_journal"]


def add_journal(parser: Parser) -> None:
    """Add ``--journal`` and ``--journal-max``."""
    parser.add_argument(
        "--journal", metavar="FILE", type=typed(arguments.output_file), help="write the journal of the run"
    )
    parser.add_argument(
        "--journal-max",
        metavar="SIZE",
        type=typed(arguments.journal_bytes),
        help="with --journal: its largest size, such as 50MB; older parts are dropped, FILE.1 is the previous part",
    )


def check_journal(parsed: argparse.Namespace) -> None:
    """Make sure that a limit has something to limit.

    Raises:
        UsageError: ``--journal-max`` without ``--journal``, or for what cannot be begun anew.
    """
    from hilbench.journal.journal_file import limited_name

    if parsed.journal_max is not None and parsed.journal is None:
        raise UsageError("there is no journal to limit", where="--journal-max", hint="give --journal FILE, too")
    if parsed.journal_max is not None and limited_name(parsed.journal) is None:
        hint = "name a file, or leave out --journal-max"
        raise UsageError("is no file on a disk that can become FILE.1", where=f"--journal {parsed.journal}", hint=hint)
