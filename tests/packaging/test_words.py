"""What users read has the field's words: pages that people write, help texts, docstrings of the API, and messages.

Names of files, options and keys stay what they are. Pages that are made from the code have the words of the code, but
for the reference of commands and files.
docs/glossary.md explains the words that are ours.
"""

from __future__ import annotations

import ast
import importlib
import importlib.util
import inspect
import re
from pathlib import Path

import pytest

from hilbench.cli import _HELP, COMMANDS
from tests.each import each

ROOT = Path(__file__).parents[2]
INSTEAD = {
    r"doors?": "endpoint, port",
    r"spoil\w*": "inject a fault, damage",
    r"told": "reported, notified, sent",
    r"whoever": "a client that, anybody who",
    r"anew": "again, restart",
    r"turned away": "refused",
    r"held against": "compared with",
    r"dried up": "stopped",
    r"in good order": "cleanly",
    r"leaves? \w+ away": "leave out",
}
IN_SUITES = {r"behind": "after", r"handed on": "forwarded", r"is due": "required", r"nobody (?:said|sent)": "not sent"}
"""Words that are looked for in what a failing case says, beside `INSTEAD`."""
IN_DOCSTRINGS = {
    r"otherwise than|(?:told|said) otherwise": "different from, by default",
    r"held against": "compared with",
    r"is called like": "has the name of",
    r"beside that": "in addition",
    r"where nobody": "by default, if none",
    r"who (?:checks|speaks|stands|holds|drives)": "the checker, the client, the driver",
    r"makes no sense while": "needs",
    r"likewise": "the same, as above",
}
"""Words that are looked for in the docstrings that the site shows, beside `INSTEAD`."""
INSTEAD_ON_PAGES = {r"(?:is|are|was|were) said": "reported", r"aright": "correctly", r"reckon\w*": "compute, expect"}
"""Words that are looked for where people write pages, beside `INSTEAD`."""
MADE = "Made from the code", "Made by"
OWN = {"docs/glossary.md", "CONTRIBUTING.md", "docs/testing.md", "docs/gate-proof.md"}
"""The pages that explain the words, and those that list names and reasons of tests."""
NAMES = re.compile(r"^ *```.*?^ *```|`[^`\n]*`|(?<=\])\([^)\n]*\)|[\w/-]+\.md", re.DOTALL | re.MULTILINE)
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").rglob("*.md")]
DOCSTRING = re.compile(r'""".*?"""', re.DOTALL)
FILLED_IN = re.compile(r"\{[^{}]*\}")
STRING = re.compile(r'"([^"\n]*)"')
PACKAGES = ("hilbench", "protocols", "targets", "worlds")
SUITES = ROOT / "hilbench" / "suites"
"""Their figures have names, which reports and recordings have as keys."""
OUTCOMES = {"Violation", "Untimely", "Inconclusive", "NotApplicable"}
SHOWN = re.compile(r"^::: (\S+)\n((?:    .*\n)*)", re.MULTILINE)
MEMBERS = re.compile(r"members: \[(.*?)\]")
"""How a page of docs/python shows a module or a class, and which of its members."""


def written():
    """Return what people write, without the names in it: file and text."""
    for page in PAGES:
        name, text = page.relative_to(ROOT).as_posix(), page.read_text(encoding="utf-8")
        made = any(made in text[:200] for made in MADE)
        if name not in OWN and (not made or page.parent.name == "reference"):
            yield name, NAMES.sub("", text)


def helped():
    """Return what commands say of themselves: command and text."""
    yield "hilbench", _HELP
    for name in ("dashboard", *COMMANDS):
        yield name, importlib.import_module(f"hilbench.commands.{name}").parser().format_help()


def sources():
    """Return the files of the packages whose texts people get to read."""
    files = (file for package in PACKAGES for file in sorted((ROOT / package).rglob("*.py")))
    return [file for file in files if SUITES not in file.parents]


def messages(pattern):
    """Return the strings of several words in the code that match, without docstrings and what is filled in."""
    for file in sources():
        text = FILLED_IN.sub("", DOCSTRING.sub("", file.read_text(encoding="utf-8")))
        found = [string for string in STRING.findall(text) if " " in string.strip() and pattern.search(string)]
        if found:
            yield file.relative_to(ROOT).as_posix(), found


def said_by_cases():
    """Return the strings in what failing cases say: file and text."""
    for file in sorted(SUITES.rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            match node:
                case ast.Assert(msg=ast.expr() as said):
                    pass
                case ast.Call(func=ast.Name(id=name), args=[said, *_]) if name in OUTCOMES:
                    pass
                case _:
                    continue
            for one in ast.walk(said):
                if isinstance(one, ast.Constant) and isinstance(one.value, str):
                    yield file.relative_to(ROOT).as_posix(), one.value


def found_at(name):
    """Return what has a dotted name."""
    parts = name.split(".")
    module = next(".".join(parts[:end]) for end in range(len(parts), 0, -1) if is_module(".".join(parts[:end])))
    found = importlib.import_module(module)
    for part in parts[module.count(".") + 1 :]:
        found = getattr(found, part)
    return found


def is_module(name):
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:
        return False


def docstrings_of(name, found, members):
    """Return the docstrings that the site shows of a module, a class or a function, without names: place and text."""
    if inspect.isclass(found):
        functions = {one: getattr(of, "fget", None) or getattr(of, "__func__", of) for one, of in vars(found).items()}
        names = members or [one for one in functions if not one.startswith("_")]
        below = {one: functions[one] for one in names if inspect.isfunction(functions.get(one))}
    else:
        below = {one: getattr(found, one) for one in members} if inspect.ismodule(found) else {}
    yield name, NAMES.sub("", inspect.getdoc(found) or "")
    for one, of in below.items():
        yield from docstrings_of(f"{name}.{one}", of, ())


@pytest.fixture(scope="module")
def documented():
    """The docstrings that the pages of docs/python show."""
    shown = [entry for page in (ROOT / "docs" / "python").glob("*.md") for entry in SHOWN.findall(page.read_text())]
    found = []
    for name, options in shown:
        members = MEMBERS.search(options)
        found += docstrings_of(name, found_at(name), members[1].split(", ") if members else ())
    return found


@pytest.fixture(scope="module")
def texts():
    """Pages and help texts: place and text."""
    return [*written(), *helped()]


def any_of(words):
    return re.compile(rf"\b(?:{'|'.join(words)})\b", re.IGNORECASE)


def test_pages_and_help_have_the_words_of_the_field(texts):
    pattern = any_of({**INSTEAD, **INSTEAD_ON_PAGES})
    assert {name: pattern.findall(text) for name, text in texts if pattern.search(text)} == {}


def test_messages_have_the_words_of_the_field():
    assert dict(messages(any_of(INSTEAD))) == {}


def test_what_a_failing_case_says_has_the_words_of_the_field():
    pattern = any_of({**INSTEAD, **IN_SUITES})
    assert [(file, text) for file, text in said_by_cases() if pattern.search(text)] == []


def test_docstrings_of_the_api_have_the_words_of_the_field(documented):
    pattern = any_of({**INSTEAD, **IN_DOCSTRINGS})
    assert {name: pattern.findall(text) for name, text in documented if pattern.search(text)} == {}


@each(
    "text",
    [
        "A door.",
        "It was spoilt.",
        "He was told so.",
        "Begin anew.",
        "Whoever comes is turned away.",
        "It is reckoned.",
        "A rover, unless told otherwise.",
        "It came behind it.",
    ],
)
def test_a_word_is_found_in_a_sentence(text):
    assert any_of({**INSTEAD, **INSTEAD_ON_PAGES, **IN_DOCSTRINGS, **IN_SUITES}).search(text)


def test_there_is_text_to_be_read(texts):
    assert sum(len(text.split()) for _, text in texts) > 30_000
    assert len(texts) > len(COMMANDS) + 40
    assert len(sources()) > 500
    assert sum(len(text.split()) for _, text in said_by_cases()) > 2000


def test_there_are_docstrings_to_be_read(documented):
    assert sum(len(text.split()) for _, text in documented) > 7000
    assert {"hilbench.plugins.system.System.rig", "targets.parts.part.Part.feed"} <= dict(documented).keys()
