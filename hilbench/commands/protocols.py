"""``hilbench protocols``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING, Any

from hilbench.cli.protocol_flags import add_plugins
from hilbench.exit_codes import ExitCode
from hilbench.terminal.parser import Parser

if TYPE_CHECKING:
    from hilbench.plugins.protocol import ProtocolPlugin

_EXAMPLES = """
hilbench protocols                     all, with where each comes from
hilbench protocols pkt                 one of them: options, clauses, commands
hilbench protocols --plugin ./tiny.py  with one of your own
"""

_NOTES = """
A protocol of your own is a package with an entry point in the group hilbench.protocols, or a file (docs/plugins.md).
Exit code 0: all of them can be used; 2: no protocol of that name, or the one you named cannot be used.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    made = Parser("hilbench protocols", "List the installed protocols.", _EXAMPLES, _NOTES)
    made.add_argument("name", metavar="NAME", nargs="?", help="show only this one, with all details")
    made.add_argument("--json", action="store_true", help="print JSON")
    add_plugins(made)
    return made


def run(parsed: argparse.Namespace) -> ExitCode:
    """Print what there is."""
    from hilbench.cli.protocol_flags import use_plugins
    from hilbench.files.names import json_text
    from hilbench.plugins.discovery import PLUGINS
    from hilbench.terminal.console import Console

    use_plugins(parsed.plugin)
    found = [PLUGINS.get(parsed.name, "NAME")] if parsed.name else [*PLUGINS.all()]
    abouts = []
    for one in found:
        try:
            abouts.append(_about(one, PLUGINS.origin(one.name)))
        except Exception as error:  # noqa: BLE001 - whatever the code of a plug-in raises: the others are there
            PLUGINS.fails(one.name, error)
    console = Console()
    if parsed.json:
        console.data(json_text({"format": 1, "protocols": abouts}))
    elif parsed.name:
        console.data("\n".join(_lines(abouts[0])))
    else:
        width = max((len(about["name"]) for about in abouts), default=0)
        for about in abouts:
            console.data(f"{about['name']:<{width}}  {about['title']}: {about['summary']} ({about['from']})")
    return ExitCode.OK


def _about(protocol: ProtocolPlugin, origin: str) -> dict[str, Any]:
    from hilbench.check.catalogue import clauses_of
    from hilbench.cli.protocol_flags import flags_of

    uses = {
        "check": protocol.device is not None,
        "serve": protocol.device is not None,
        "the dashboard": protocol.device is not None,
        "check --target capture:": protocol.recorded is not None,
        "replay --into PORT": bool(protocol.replay_bench),
        "init --protocol": protocol.first_test is not None,
    }
    return {
        "name": protocol.name,
        "title": protocol.title,
        "summary": protocol.summary,
        "from": origin,
        "baud": protocol.baud,
        "flags": {flag: str(settings["help"]) for flag, settings in flags_of(protocol).items()},
        "clauses": len(clauses_of(protocol)),
        "uses": ["decode", "proxy", "export", *(use for use, there in uses.items() if there)],
    }


def _lines(about: dict[str, Any]) -> list[str]:
    flags = [f"  {flag}  {what}" for flag, what in about["flags"].items()]
    return [
        f"{about['name']}: {about['title']}, {about['summary']}",
        f"from     {about['from']}",
        f"line     {about['baud']} bit/s, usually",
        f"clauses  {about['clauses']}",
        f"for      {', '.join(about['uses'])}",
        *(["flags of decode, proxy and export:", *flags] if flags else []),
    ]
