"""``hilbench udev``."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from hilbench.terminal.parser import Parser

if TYPE_CHECKING:
    from hilbench.files.host import Host
    from hilbench.terminal.console import Console

_EXAMPLES = """
hilbench udev                                  print the rules
hilbench udev --explain                        what they do, and what they make of the ports here
hilbench udev --check                          are they installed, and right
sudo "$(command -v hilbench)" udev --install   into /etc/udev/rules.d, and have udev read them
hilbench udev --install --directory DIR        into another folder
hilbench udev | sudo tee /etc/udev/rules.d/70-hilbench.rules
"""

_NOTES = """
--check ends with exit code 0 if the rules are installed as this hilbench has them and nothing is wrong in them, else 3.
"""


def parser() -> Parser:
    """Return the parser of this command."""
    summary = "Rules for udev: access to boards and adapters, names that stay, ModemManager and brltty kept off."
    made = Parser("hilbench udev", summary, _EXAMPLES, _NOTES)
    what = made.add_mutually_exclusive_group()
    what.add_argument("--check", action="store_true", help="check whether they are installed and correct")
    what.add_argument("--explain", action="store_true", help="explain what each part does, and why")
    what.add_argument("--install", action="store_true", help="install them, and have udev read them")
    made.add_argument("--directory", metavar="DIR", help="for --install and --check (default: /etc/udev/rules.d)")
    made.add_argument("--group", metavar="GROUP",
        help="group that gets the ports (default: as installed, else the group of serial ports here)")  # fmt: skip
    made.add_argument("--json", action="store_true", help="print JSON, with --check and --explain")
    return made


def run(parsed: argparse.Namespace) -> int:
    """Run the command; see `hilbench.udev.installing`."""
    from hilbench.errors import UsageError
    from hilbench.exit_codes import ExitCode
    from hilbench.files.host import this_host
    from hilbench.terminal.console import Console
    from hilbench.udev.installing import install_by, port_group, rules_text

    if parsed.directory is not None and not (parsed.install or parsed.check):
        raise UsageError("goes with --install and --check", where="--directory")
    if parsed.json and not (parsed.check or parsed.explain):
        raise UsageError("goes with --check and --explain", where="--json")
    host, console = this_host(), Console()
    text = rules_text(parsed.group or port_group(host))
    if parsed.install:
        return _install(console, host, parsed.group, parsed.directory)
    if parsed.check:
        return _check(console, host, parsed)
    if parsed.explain:
        _explain(console, text, as_json=parsed.json)
    else:
        console.data(text.removesuffix("\n"))
        console.narrate(f"what they do: hilbench udev --explain; to install them: {install_by(host, parsed.group)}")
    return ExitCode.OK


def _install(console: Console, host: Host, asked_for: str | None, directory: str | None) -> int:
    from hilbench.exit_codes import ExitCode
    from hilbench.files.paths import absolute_path
    from hilbench.udev.installing import (
        RULES_FOLDER,
        RULES_NAME,
        group_to_install,
        install_rules,
        port_group,
        reload_rules,
        rules_text,
        verify_rules,
    )

    folder = absolute_path(directory) if directory is not None else host.path(RULES_FOLDER)
    group = asked_for or group_to_install(host, str(folder) if directory is not None else None)
    print_by = "hilbench udev" + (f" --group {group}" if group != port_group(host) else "")
    kept = install_rules(folder, rules_text(group), print_by)
    console.narrate(f"written: {folder / RULES_NAME}")
    if asked_for is None and group != port_group(host):
        console.narrate(f"the ports stay with the group {group}; --group names another")
    if kept is not None:
        console.narrate(f"the file that was there is now {kept}")
    console.narrate(verify_rules(host, folder / RULES_NAME).what)
    if directory is None:
        console.narrate(reload_rules(host))
    else:
        console.narrate(f"udev reads {RULES_FOLDER}; nothing was reloaded")
    return ExitCode.OK


def _check(console: Console, host: Host, parsed: argparse.Namespace) -> int:
    from hilbench.exit_codes import ExitCode
    from hilbench.files.names import json_text
    from hilbench.files.paths import absolute_path
    from hilbench.udev.installing import check_rules

    where = str(absolute_path(parsed.directory)) if parsed.directory is not None else None
    found = check_rules(host, parsed.group, where)
    if parsed.json:
        console.data(json_text(found.as_data()))
    else:
        console.data(found.as_text())
    return ExitCode.OK if found.right else ExitCode.UNAVAILABLE


def _explain(console: Console, text: str, *, as_json: bool) -> None:
    from hilbench.doctor.rules_explained import as_data, as_text
    from hilbench.files.names import json_text
    from hilbench.ports.listing import list_ports

    ports = list_ports()
    console.data(json_text(as_data(text, ports)) if as_json else as_text(text, ports))
