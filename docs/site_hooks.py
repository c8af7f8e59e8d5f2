"""What the site makes of pages: diagrams become pictures, links to files that are no pages name the file.

The search finds what says how to do something before what shows that it was measured.
"""

from __future__ import annotations

import html
import re
from pathlib import Path
from typing import Any

import mmdr

ROOT = Path(__file__).parents[1]
DIAGRAM = re.compile(r"^```mermaid\n(.*?)^```$", re.DOTALL | re.MULTILINE)
BAR = r"\|"
ESCAPED_BAR = re.compile(r"`([^`\n]*\\\|[^`\n]*)`")
BOOST = {"Tutorials": 2, "How-to": 2, "Explanation": 1.5, "Evidence": 0.3}
"""How much a section's pages weigh in the search; the others 1 (choice)."""
LINK = re.compile(r"(?<!!)\[(?P<text>[^\]]+)\]\((?P<target>[^):#\s]+)\)")


def on_page_markdown(markdown: str, *, page: Any, **_others: Any) -> str:
    """Return the page as mkdocs builds it."""
    if page.ancestors:
        page.meta["search"] = {"boost": BOOST.get(page.ancestors[-1].title, 1)}
    folder = Path(page.file.abs_src_path).parent
    return _with_pictures(_with_bars(_with_names_of_files(markdown, folder)))


def _with_bars(markdown: str) -> str:
    r"""Write a bar in the code of a table's cell, ``\|``, so that it is read as GitHub reads it."""

    def read(code: re.Match[str]) -> str:
        return f"<code>{html.escape(code[1].replace(BAR, '|')).replace('|', '&#124;')}</code>"

    return ESCAPED_BAR.sub(read, markdown)


def _with_pictures(markdown: str) -> str:
    """Draw each diagram now: a reader's browser would have to load a script for that."""

    def drawn(diagram: re.Match[str]) -> str:
        return f'<div class="diagram">{" ".join(mmdr.render(diagram[1]).svg().split())}</div>'

    return DIAGRAM.sub(drawn, markdown)


def _with_names_of_files(markdown: str, folder: Path) -> str:
    def named(link: re.Match[str]) -> str:
        file = (folder / link["target"]).resolve()
        if file.is_relative_to(ROOT / "docs") or not file.is_relative_to(ROOT):
            return link[0]
        name = file.relative_to(ROOT).as_posix()
        return f"`{name}`" if link["text"].strip("`") == name else f"{link['text']} (`{name}`)"

    return LINK.sub(named, markdown)
