"""``hilbench attach``."""

from __future__ import annotations

import argparse

from hilbench.cli.protocol_flags import add_plugins, use_plugins
from hilbench.errors import UnavailableError, UsageError
from hilbench.nearest import did_you_mean
from hilbench.terminal.parser import Parser

_EXAMPLES = """
hilbench attach               the latest bench that was left running
hilbench attach --list
hilbench attach pioneer-x3k9a2b1
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench attach", "Come back to a bench that was left running.", _EXAMPLES)
    made.add_argument("name", metavar="NAME", nargs="?", help="which one, as --list shows it; the latest by default")
    made.add_argument("--list", action="store_true", help="say which there are")
    add_plugins(made)
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command.

    Raises:
        UsageError: no bench of that name runs; this is no terminal.
        UnavailableError: none runs at all.
    """
    from hilbench.live.folders import sessions
    from hilbench.terminal.console import Console

    use_plugins(parsed.plugin)
    found = list(sessions())
    if parsed.list:
        for session in found:
            Console().data(f"{session.name}  bench {session.describe().get('bench', '?')}")
        return 0
    if not found:
        raise UnavailableError("no bench was left running", where="hilbench attach", hint="'hilbench' opens one")
    names = [session.name for session in found]
    if parsed.name is not None and parsed.name not in names:
        raise UsageError(f"no bench '{parsed.name}' runs", hint=did_you_mean(parsed.name, names, "they are"))
    from hilbench.commands.dashboard import require_terminal, show

    require_terminal("'hilbench attach --list' does without")
    from hilbench.tui.bench_process import BenchProcess

    return show(BenchProcess(found[names.index(parsed.name)] if parsed.name else found[0]))
