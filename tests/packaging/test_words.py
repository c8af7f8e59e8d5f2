"""Pages that people write use the field's words; docs/glossary.md explains those that are ours.

Names of files, options and keys stay what they are. Pages that are made from the code have the words of the code.
"""

from __future__ import annotations

import re
from pathlib import Path

from tests.each import each

ROOT = Path(__file__).parents[2]
INSTEAD = {r"doors?": "endpoint, port", r"spoil\w*": "inject a fault, damage"}
MADE = "Made from the code", "Made by"
OWN = {"docs/glossary.md", "CONTRIBUTING.md", "docs/testing.md", "docs/gate-proof.md"}
"""The pages that explain the words, and those that list names and reasons of tests."""
NAMES = re.compile(r"^ *```.*?^ *```|`[^`\n]*`|(?<=\])\([^)\n]*\)|[\w/-]+\.md", re.DOTALL | re.MULTILINE)
PAGES = [*ROOT.glob("*.md"), *(ROOT / "docs").rglob("*.md"), *(ROOT / "examples").rglob("*.md")]


def written():
    """Return what people write, without the names in it: file and text."""
    for page in PAGES:
        name, text = page.relative_to(ROOT).as_posix(), page.read_text(encoding="utf-8")
        if name not in OWN and not any(made in text[:200] for made in MADE):
            yield name, NAMES.sub("", text)


@each("word, instead", INSTEAD.items())
def test_a_word_of_our_own_is_not_used_where_the_field_has_one(word, instead):
    pattern = re.compile(rf"\b{word}\b", re.IGNORECASE)
    found = {name: pattern.findall(text) for name, text in written() if pattern.search(text)}
    assert not found, f"say {instead}"


def test_there_is_text_to_be_read():
    assert sum(len(text.split()) for _, text in written()) > 40_000
