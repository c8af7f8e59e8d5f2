"""The pages of docs/reference: the command line from its parsers, the bench file from its JSON Schema."""

from __future__ import annotations

import argparse
import importlib
import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from hilbench.cli import _HELP as HELP
from hilbench.cli import COMMANDS
from hilbench.terminal.parser import Parser

Table = Callable[[Sequence[str], Iterable[Sequence[str]]], str]
Schema = Mapping[str, Any]

DATA = Path(__file__).parents[1] / "hilbench" / "data"
QUOTED = re.compile(r"'(hilbench [^']*)'")
FILES = ("bench", "board")
GROUPS = {
    "See a bench live": ("dashboard", "demo", "attach", "replay"),
    "Check": ("check", "campaign", "shrink", "report"),
    "Run and serve": ("run", "serve", "proxy", "init"),
    "Recordings and bytes": ("decode", "export", "render", "diff"),
    "This machine": ("doctor", "ports", "udev", "validate", "protocols", "completion"),
}
LIMITS = {"minimum": "from", "exclusiveMinimum": "above", "maximum": "to", "exclusiveMaximum": "below"}
BENCH_TABLES = {
    "BenchModel": "The top of the file",
    "TargetEntry": "`[targets.NAME]`",
    "StrapsEntry": "`straps` of a target",
    "PartEntry": "`[parts.NAME]`",
    "BusPinsEntry": "A bus at two pins",
    "World": "`[world]`",
    "LinkEntry": "`[[links]]`",
    "WireEntry": "`[[wires]]`",
    "FaultEntry": "`[[faults]]`",
    "PortEntry": "`[port]`",
}


def command_line_page(table: Table) -> str:
    """Every command with its arguments, options and examples."""
    missing = {"dashboard", *COMMANDS} ^ {name for names in GROUPS.values() for name in names}
    if missing:
        message = f"GROUPS and the commands differ: {', '.join(sorted(missing))}"
        raise ValueError(message)
    codes = re.findall(r"^ +(\d+)  (.*)$", HELP.partition("exit codes:")[2], re.MULTILINE)
    return (
        "# Command line\n\n"
        "This page shows what `hilbench COMMAND --help` shows. Names of commands and options, formats of output and "
        "exit codes are part of the interface.\n\n"
        + "\n".join(_group(title, names, table) for title, names in GROUPS.items())
        + "\n## Exit codes\n\n"
        + table(("Code", "Meaning"), codes)
        + "\nWhere several apply, the first of 130, 5, 3, 2, 1, 4, 0 is returned.\n"
    )


def _group(title: str, names: Sequence[str], table: Table) -> str:
    return f"## {title}\n\n" + "\n".join(_command(name, table) for name in names)


def _command(name: str, table: Table) -> str:
    parser: Parser = importlib.import_module(f"hilbench.commands.{name}").parser()
    rows = [(_written(action), _help(parser, action)) for action in parser._actions if _is_shown(action)]
    examples, _, notes = (parser.epilog or "").partition("\n\n")
    shown = "\n".join(line.strip() for line in examples.splitlines()[1:])
    return (
        f"### {parser.prog}\n\n{parser.description}\n\n"
        + (table(("Argument or option", "Meaning"), rows) if rows else "")
        + f"\n```text\n{shown}\n```\n"
        + (f"\n{_prose(notes)}\n" if notes else "")
    )


def _prose(notes: str) -> str:
    """Return notes as paragraphs, which end where a line ends with a full stop; as they are if they are laid out."""
    if "\n  " in notes:
        return f"```text\n{notes}\n```"
    return _as_code(notes.replace(".\n", ".\n\n"))


def _as_code(text: str) -> str:
    return QUOTED.sub(r"`\1`", text)


def _is_shown(action: argparse.Action) -> bool:
    return action.help is not argparse.SUPPRESS and "--help" not in action.option_strings


def _written(action: argparse.Action) -> str:
    """Return how an argument is written: `-k, --select EXPR`."""
    value = action.metavar or ("{" + ",".join(map(str, action.choices)) + "}" if action.choices else "")
    if action.nargs == 0:
        value = ""
    value = " ".join(value) if isinstance(value, tuple) else value
    value = f"[{value}]" if action.nargs == "?" and value else f"{value} ..." if action.nargs in {"*", "+"} else value
    return f"`{' '.join(word for word in (', '.join(action.option_strings), value) if word)}`"


def _help(parser: Parser, action: argparse.Action) -> str:
    return _as_code(parser._get_formatter()._expand_help(action)) if action.help else ""


def bench_file_page(table: Table) -> str:
    """Every key of bench files and board files."""
    bench, board = (json.loads((DATA / f"{name}.schema.json").read_text(encoding="utf-8")) for name in FILES)
    return (
        "# Bench file and board file\n\n"
        "A bench file is TOML: which targets there are, how they are joined, and what goes wrong. An unknown key is "
        "refused, with its line and the nearest key. `hilbench validate FILE` checks one. For completion in an editor, "
        "use the schemas `hilbench/data/bench.schema.json` and `hilbench/data/board.schema.json`. Paths in a bench "
        "file are relative to its folder.\n\n"
        "```toml\n"
        "version = 1\n\n"
        "[targets.brain]\n"
        'board = "bluepill"\n'
        'firmware = "firmware.elf"\n'
        "```\n\n"
        + "".join(_object(title, bench["$defs"][name], table) for name, title in BENCH_TABLES.items())
        + "## Settings of models\n\n"
        "`[targets.NAME.settings]` changes settings of a model. The Pioneer's are in "
        "[what the virtual Pioneer is](../fidelity.md), with their sources.\n\n"
        + "".join(_object(title, bench["$defs"][name], table, "###") for title, name in _settings(bench))
        + "## Board files\n\n"
        'A board file describes a board of your own; `board = "./panel.toml"` names it.\n\n'
        + "".join(_object(f"`{name}`", one, table, "###") for name, one in board["$defs"].items())
    )


def _settings(bench: Schema) -> Iterator[tuple[str, str]]:
    """Yield model and schema of the settings of each model but the Pioneer's, which have a page."""
    target = bench["$defs"]["TargetEntry"]["properties"]
    models = target["model"]["anyOf"][0]["enum"]
    for model, one in zip(models, target["settings"]["anyOf"], strict=False):
        if model != "pioneer-2dx":
            yield f'`model = "{model}"`', one["$ref"].rpartition("/")[2]


def _object(title: str, schema: Schema, table: Table, mark: str = "##") -> str:
    rows = [
        (f"`{key}`", _kind(one), _default(key, one, schema), str(one.get("description", "")).replace("``", "`"))
        for key, one in schema["properties"].items()
    ]
    text = str(schema.get("description", "")).replace("``", "`")
    return f"{mark} {title}\n\n{text}\n\n" + table(("Key", "Value", "Default", "Meaning"), rows) + "\n"


def _kind(one: Schema) -> str:
    if "enum" in one:
        return ", ".join(f"`{json.dumps(value)}`" for value in one["enum"])
    if "anyOf" in one:
        return " or ".join(dict.fromkeys(_kind(each) for each in one["anyOf"]))
    kind = str(one.get("type", "table"))
    words = {"object": "table", "array": "list", "string": "text", "boolean": "true or false", "null": "nothing"}
    limits = [f"{sign} {one[key]:.15g}" for key, sign in LIMITS.items() if key in one]
    return " ".join([words.get(kind, kind), *limits])


def _default(key: str, one: Schema, schema: Schema) -> str:
    if key in schema.get("required", ()):
        return "required"
    value = one.get("default")
    return "" if value in (None, {}, [], "") or isinstance(value, dict) else f"`{json.dumps(value)}`"
