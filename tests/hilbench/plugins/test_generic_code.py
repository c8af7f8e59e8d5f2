"""Generic code names no protocol and no system: what is peculiar to one stands in its folder and its suites."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import hilbench

ROOT = Path(hilbench.__file__).parent
NAMES = re.compile(
    r"p2os|\bsip\b|sonar|pioneer|pkt|rover|carla|autoware|xrce|bluepill|vehicle[-_ ](interface|model)|car[-_]host"
    r"|hilbench\.systems(\.| import)",
    re.IGNORECASE,
)
THEIR_OWN = ("systems", "suites")
HELP = {Path("cli/__init__.py"), *(path.relative_to(ROOT) for path in (ROOT / "commands").glob("*.py"))}
"""Their examples and the help of their options show how a command is used, with names that are there."""
DEFAULTS = {Path("terminal/options.py"): {"pioneer", "rover"}, Path("benchfile/bench_model.py"): {"pioneer-2dx"}}
"""What is meant where nobody names a bench, a demo, or a vehicle."""


def help_texts(tree):
    """Yield the constants in examples, in the help of options, and in what a parser is called with."""
    for node in ast.walk(tree):
        match node:
            case ast.Assign(targets=[ast.Name(id="_EXAMPLES" | "_HELP")]) | ast.keyword(arg="help"):
                yield from ast.walk(node.value)
            case ast.Call(func=ast.Name(id="Parser")):
                yield from ast.walk(node)


def names_of(place, tree):
    """Yield the line and the words of what names a system, or imports from the folder of one."""
    allowed = {id(node) for node in help_texts(tree)} if place in HELP else set()
    for node in ast.walk(tree):
        match node:
            case ast.Constant(value=str(words)) if id(node) not in allowed and words not in DEFAULTS.get(place, ()):
                pass
            case ast.Name(id=words) | ast.Attribute(attr=words) | ast.arg(arg=words) | ast.keyword(arg=str(words)):
                pass
            case ast.FunctionDef(name=words) | ast.AsyncFunctionDef(name=words) | ast.ClassDef(name=words):
                pass
            case ast.Import() | ast.ImportFrom():
                words = ast.unparse(node)
            case _:
                continue
        if NAMES.search(words):
            yield node.lineno, words.strip()


def test_no_module_names_a_system():
    found = [
        f"{place}:{line}: {words[:60]}"
        for path in sorted(ROOT.rglob("*.py"))
        if (place := path.relative_to(ROOT)).parts[0] not in THEIR_OWN
        for line, words in names_of(place, ast.parse(path.read_text(encoding="utf-8")))
    ]
    assert found == []
