"""What users read has the field's words: pages that people write, help texts, and messages.

Names of files, options and keys stay what they are. Pages that are made from the code have the words of the code.
docs/glossary.md explains the words that are ours.
"""

from __future__ import annotations

import importlib
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


def written():
    """Return what people write, without the names in it: file and text."""
    for page in PAGES:
        name, text = page.relative_to(ROOT).as_posix(), page.read_text(encoding="utf-8")
        if name not in OWN and not any(made in text[:200] for made in MADE):
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


@each(
    "text",
    ["A door.", "It was spoilt.", "He was told so.", "Begin anew.", "Whoever comes is turned away.", "It is reckoned."],
)
def test_a_word_is_found_in_a_sentence(text):
    assert any_of({**INSTEAD, **INSTEAD_ON_PAGES}).search(text)


def test_there_is_text_to_be_read(texts):
    assert sum(len(text.split()) for _, text in texts) > 30_000
    assert len(texts) > len(COMMANDS) + 40
    assert len(sources()) > 500
