"""The site of the documentation: each page has its place, links hit headings, and it is built without a network."""

from __future__ import annotations

import importlib.util
import json
import os
import re
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"
PAGES = sorted(DOCS.rglob("*.md"))
PLACE = re.compile(r"^ +- (?:[^:\n]+: )?(\S+\.md)$", re.MULTILINE)
FENCED = re.compile(r"^ *```.*?^ *```", re.DOTALL | re.MULTILINE)
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)
LINK = re.compile(r"\]\(([^):\s]*?\.md)?#([^)\s]+)\)")
FOREIGN = re.compile(r"""<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)=["']?(?:https?:)?//[^>]*>""")
FROM_ELSEWHERE = re.compile(rb"""(?:@import|url\()\s*["']?(?:https?:)?//""")


def test_each_page_has_one_place_in_the_navigation():
    places = Counter(PLACE.findall((ROOT / "docs" / "site" / "mkdocs.yml").read_text(encoding="utf-8")))
    assert places == Counter(page.relative_to(DOCS).as_posix() for page in PAGES)


def anchors_of(page):
    """Return what its headings are called in the site and on GitHub, as far as both call them the same."""
    text = FENCED.sub("", page.read_text(encoding="utf-8"))
    words = [re.sub(r"[^\w\s-]", "", heading).strip().lower() for heading in HEADING.findall(text)]
    return {word.replace(" ", "-") for word in words} & {re.sub(r"[-\s]+", "-", word) for word in words}


def test_links_hit_headings():
    for page in [*PAGES, *ROOT.glob("*.md")]:
        for file, anchor in LINK.findall(FENCED.sub("", page.read_text(encoding="utf-8"))):
            assert anchor in anchors_of(page.parent / file if file else page), f"{page}: {file}#{anchor}"


def test_the_readme_is_short_and_its_figures_are_those_of_the_mutants():
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert text.count("\n") <= 120
    data = json.loads((DOCS / "mutants.json").read_text(encoding="utf-8"))
    verdicts = [item for one in data["mutants"].values() for item in one["verdicts"].items()]
    found = {clause for clause, verdict in verdicts if verdict == "fail" and clause in data["clauses"]}
    assert re.search(r"(\d+) mutants of", text)[1] == str(len(data["mutants"]))
    assert re.search(r"All (\d+) clauses", text)[1] == str(len(data["clauses"])) == str(len(found))


@pytest.mark.exhaustive("builds the site; the gate holds pages, navigation and links against each other")
@pytest.mark.skipif(importlib.util.find_spec("mkdocs") is None, reason="the extra 'docs' is not installed")
def test_the_site_is_built_strictly_and_loads_nothing_from_elsewhere(tmp_path):
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(tmp_path / "site")]
    command += ["--config-file", str(DOCS / "site" / "mkdocs.yml")]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
    built = [*(tmp_path / "site").rglob("*.html")]
    assert len(built) > len(PAGES)
    for page in built:
        assert FOREIGN.findall(page.read_text(encoding="utf-8")) == [], page
    for style in (tmp_path / "site").rglob("*.css"):
        assert not FROM_ELSEWHERE.search(style.read_bytes()), style
