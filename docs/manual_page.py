"""The manual page ``hilbench.1``: the command line from its parsers, in the man macros (man(7)).

The wheel installs it below ``share/man``, where `man` looks for the commands of an environment.
"""

from __future__ import annotations

import argparse
import importlib
import re

from hilbench.cli import _HELP as HELP
from hilbench.cli import COMMANDS
from hilbench.terminal.parser import Parser

_HEAD = """\
.TH HILBENCH 1
.SH NAME
hilbench \\- run firmware without a board, and check serial protocols rule by rule
.SH SYNOPSIS
.nf
hilbench [BENCH]
hilbench COMMAND [options]
.fi
.SH DESCRIPTION
hilbench runs STM32 firmware on an emulated chip. It checks the serial protocol of a robot or a board on a virtual
robot, on an emulated board, or at a serial port. Without a command it opens the dashboard of a bench.
"""
_FILES = {
    "./hilbench.toml": "the bench file that is meant where none is named",
    "$XDG_CONFIG_HOME/hilbench/settings.toml": "settings: bench, plain, theme; below ~/.config by default",
    "$XDG_STATE_HOME/hilbench": "what the dashboard remembers, calibrations of ports; below ~/.local/state by default",
}
_ENVIRONMENT = {
    "NO_COLOR": "no colours on a terminal, if it is set",
    "XDG_CONFIG_HOME, XDG_STATE_HOME, XDG_CACHE_HOME, XDG_RUNTIME_DIR": "where files of yours are",
}


def manual_page() -> str:
    """Return the page."""
    codes = dict(re.findall(r"^ +(\d+)  (.*)$", HELP.partition("exit codes:")[2], re.MULTILINE))
    names = ["dashboard", *COMMANDS]
    return (
        _HEAD
        + ".SH COMMANDS\n"
        + "".join(_command(importlib.import_module(f"hilbench.commands.{name}").parser()) for name in names)
        + _section("EXIT STATUS", codes)
        + _section("ENVIRONMENT", _ENVIRONMENT)
        + _section("FILES", _FILES)
    )


def _section(title: str, rows: dict[str, str]) -> str:
    return f".SH {title}\n" + "".join(f".TP\n.B {_safe(name)}\n{_safe(text)}\n" for name, text in rows.items())


def _command(parser: Parser) -> str:
    examples, _, notes = (parser.epilog or "").partition("\n\n")
    return (
        f'.SS "{_safe(parser.prog)}"\n{_safe(str(parser.description))}\n'
        + "".join(_argument(parser, action) for action in parser.arguments if action.help is not argparse.SUPPRESS)
        + f".PP\nExamples:\n.PP\n.nf\n{_lines(examples.partition(chr(10))[2])}.fi\n"
        + (f".PP\n.nf\n{_lines(notes)}.fi\n" if "\n  " in notes else f".PP\n{_lines(notes)}" if notes else "")
    )


def _argument(parser: Parser, action: argparse.Action) -> str:
    written = ", ".join(action.option_strings)
    value = action.metavar or ("{" + ",".join(map(str, action.choices)) + "}" if action.choices else action.dest)
    if action.nargs != 0:
        written = f"{written} {value}".strip()
    return f".TP\n.B {_safe(written)}\n{_safe(parser._get_formatter()._expand_help(action))}\n"


def _lines(text: str) -> str:
    return "".join(f"{_safe(line)}\n" for line in text.splitlines())


def _safe(text: str) -> str:
    """Return text as roff reads it: no line of it is a request, a hyphen is one that can be copied."""
    escaped = text.replace("\\", "\\e").replace("-", "\\-")
    return f"\\&{escaped}" if escaped[:1] in {".", "'"} else escaped
