"""A screen as SVG whose letters stand in their cells, also where a viewer stretches no text.

A run of letters has its length in `textLength`, which librsvg and others pass over, as they do spaces before it.
Letters of another font than the rest, dots and blocks above all, would then end up where something else stands.
"""

from __future__ import annotations

import html
import re

from rich.cells import cell_len

__all__ = ["in_cells"]

_RUN = re.compile(r'(<text class="[^"]*" x=")([\d.]+)(" y="[\d.]+" textLength=")([\d.]+)("[^>]*>)([^<]*)(</text>)')
_PIECE = re.compile(r"(?:&#160;)+|(?:&[#\w]+;|[!-%'-~])+|.", re.DOTALL)
"""Spaces, letters of ASCII that begin with none, or one other letter; spaces are ``&#160;``."""


def in_cells(svg: str) -> str:
    """Return a screen in which each letter that is not ASCII has its own place."""
    return _RUN.sub(_split, svg)


def _split(run: re.Match[str]) -> str:
    head, x, middle, length, tail, text, end = run.groups()
    cell = float(length) / max(1, cell_len(html.unescape(text)))
    found, at = [], 0
    for piece in _PIECE.findall(text):
        letters = html.unescape(piece)
        cells = cell_len(letters)
        if letters.strip():
            found.append(f"{head}{float(x) + at * cell:g}{middle}{cells * cell:g}{tail}{piece}{end}")
        at += cells
    return "".join(found)
