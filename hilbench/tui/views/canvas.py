"""A canvas of Braille dots in terminal cells: two columns and four rows of dots in each cell."""

from __future__ import annotations

import math
from itertools import groupby
from operator import itemgetter

from rich.text import Span, Text

__all__ = ["Canvas"]

_DOTS = ((0x01, 0x08), (0x02, 0x10), (0x04, 0x20), (0x40, 0x80))
_BLANK = 0x2800


class Canvas:
    """Dots in a box of cells; the origin is at the upper left, y goes down.

    Args:
        columns: cells across.
        rows: cells down.
    """

    def __init__(self, columns: int, rows: int) -> None:
        self.columns, self.rows = max(1, columns), max(1, rows)
        self.width, self.height = 2 * self.columns, 4 * self.rows
        self._bits = [0] * (self.columns * self.rows)
        self._styles = [""] * (self.columns * self.rows)
        self._letters: dict[int, str] = {}

    def dot(self, x: float, y: float, style: str = "") -> None:
        """Set a dot; outside of the box nothing happens. The last style of a cell is the cell's."""
        column, row = int(x // 2), int(y // 4)
        if 0 <= column < self.columns and 0 <= row < self.rows:
            cell = row * self.columns + column
            self._bits[cell] |= _DOTS[int(y) % 4][int(x) % 2]
            if style:
                self._styles[cell] = style

    def line(self, begin: tuple[float, float], end: tuple[float, float], style: str = "", every: int = 1) -> None:
        """Set the dots between two places, or each so many of them."""
        (x0, y0), (x1, y1) = begin, end
        steps = min(4 * (self.width + self.height), max(1, math.ceil(max(abs(x1 - x0), abs(y1 - y0)))))
        for step in range(0, steps + 1, every):
            self.dot(x0 + (x1 - x0) * step / steps, y0 + (y1 - y0) * step / steps, style)

    def column(self, x: int, begin: float, end: float, style: str = "") -> None:
        """Set the dots of a column between two heights."""
        top, bottom = max(0, int(min(begin, end))), min(self.height - 1, int(max(begin, end)))
        if 0 <= x < self.width:
            for row in range(top // 4, bottom // 4 + 1):
                cell = row * self.columns + x // 2
                for dot in range(max(0, top - 4 * row), min(3, bottom - 4 * row) + 1):
                    self._bits[cell] |= _DOTS[dot][x % 2]
                self._styles[cell] = style or self._styles[cell]

    def letter(self, x: float, y: float, letter: str, style: str = "") -> None:
        """Put a letter into the cell of a place, over its dots."""
        column, row = int(x // 2), int(y // 4)
        if 0 <= column < self.columns and 0 <= row < self.rows:
            self._letters[row * self.columns + column] = letter
            self._styles[row * self.columns + column] = style

    def lines(self) -> list[Text]:
        """Return the rows."""
        marks = [chr(_BLANK + bits) if bits else " " for bits in self._bits]
        for cell, letter in self._letters.items():
            marks[cell] = letter
        return [self._line(marks, row * self.columns) for row in range(self.rows)]

    def _line(self, marks: list[str], begin: int) -> Text:
        """Return a row; cells of one style side by side are one piece."""
        end = begin + self.columns
        text = Text("".join(marks[begin:end]))
        if any(self._styles[begin:end]):
            cells = enumerate(self._styles[begin:end])
            for style, run in groupby(cells, key=itemgetter(1)):
                if style:
                    places = [place for place, _ in run]
                    text.spans.append(Span(places[0], places[-1] + 1, style))
        return text
