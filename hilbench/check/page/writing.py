"""Writes the page: the template is ``page.html.j2``.

The page loads nothing, and no script runs in it but ``page.js``: its policy names that by its digest.
"""

from __future__ import annotations

import base64
import hashlib
from collections.abc import Sequence
from pathlib import Path

from hilbench.check.page.rendering import rendered
from hilbench.check.page.runs import Cell, Row, Run

__all__ = ["html_page"]

LARGEST_SCREEN = 400_000
_MISSING = Cell(word="")


def html_page(runs: Sequence[Run], title: str = "hilbench check", screens: Path | None = None) -> str:
    """Return the page of one run or several.

    Args:
        runs: from the left to the right; of several it shows what differs.
        title: of the page.
        screens: the folder in which pictures of the dashboard lie; None to leave all out, as what lies elsewhere.
    """
    script = Path(__file__).with_name("page.js").read_text(encoding="utf-8")
    values = {
        "title": title,
        "runs": runs,
        "rows": [_row(row, runs) for row in _rows(runs)],
        "words": sorted({cell.word for run in runs for cell in run.cells.values() if cell.word}),
        "script": script,
        "script_digest": base64.b64encode(hashlib.sha256(script.encode()).digest()).decode(),
    }
    return rendered("hilbench.check.page", {"picture": _picture, "screen": lambda name: _screen(name, screens)}, values)


def _rows(runs: Sequence[Run]) -> list[Row]:
    """Return the rows of all runs, each once: those of the first, then what others have besides."""
    return list({row.id: row for run in runs for row in run.rows}.values())


def _row(row: Row, runs: Sequence[Run]) -> tuple[Row, list[tuple[Run, Cell]], bool]:
    """Return a row with what each run says of it, and whether that differs."""
    pairs = [(run, run.cells.get(row.id, _MISSING)) for run in runs]
    return row, pairs, len({cell.word for _, cell in pairs}) > 1


def _picture(svg: str) -> str:
    """Return a picture as an address: so it cannot run anything, whatever it says."""
    return f"data:image/svg+xml;base64,{base64.b64encode(svg.encode(errors='replace')).decode()}"


def _screen(name: str, folder: Path | None) -> str:
    """Return the picture in a file as an address; empty if it is none, is large, or lies elsewhere.

    A report names the file, and may come from somebody else.
    """
    if folder is None:
        return ""
    try:
        file = Path(name).resolve()
        if not file.is_relative_to(folder.resolve()) or file.suffix != ".svg" or not file.is_file():
            return ""
        with file.open(encoding="utf-8") as opened:
            text = opened.read(LARGEST_SCREEN + 1)
    except (OSError, ValueError):
        return ""
    return _picture(text) if len(text) <= LARGEST_SCREEN and "<svg" in text[:500] else ""
