"""A widget of lines of text that draws only those that have changed.

Textual makes a widget's text into rows, splits it by its styles and blends its colours anew with each refresh. Here a
line becomes cells at once, with styles that were blended once, and only where it differs from what stands there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

from rich.segment import Segment
from rich.style import Style
from rich.text import Span, Text
from textual.geometry import Region
from textual.strip import Strip
from textual.style import Style as BlendedStyle
from textual.widget import Widget

__all__ = ["Lines", "pieces"]

Styles = tuple[str | Style, ...]


class Lines(Widget):
    """See the module. Who derives from it says in `lines_for` what is to be seen now.

    Text in it cannot be marked with the mouse: that would need the place of each piece in its style.

    Args:
        css_id: its name in the style sheet.
    """

    ALLOW_SELECT = False

    def __init__(self, css_id: str) -> None:
        super().__init__(id=css_id)
        self._rows: Sequence[Text] = ()
        self._stale = True
        self._blended: dict[Styles, Style] = {}

    def lines_for(self, width: int, height: int) -> Sequence[Text]:
        """Return what is to be seen in so many cells."""
        raise AssertionError(f"{self} has no lines for {width} by {height}")

    def look(self) -> None:
        """See whether lines have changed, and have those drawn."""
        if self._stale:  # all of them will be drawn, and asked for then
            self.refresh()
            return
        before, self._rows = self._rows, self._lines_now()
        width, height = self.content_size
        rows = [row for row in range(height) if not _same(_row(before, row), _row(self._rows, row))]
        if rows:
            super().refresh(*(Region(0, first, width, count) for first, count in _runs(rows)))

    def refresh(self, *regions: Region, **more: Any) -> Any:
        """Have some of it drawn again, or all of it."""
        if not regions:
            self._stale = True
        return super().refresh(*regions, **more)

    def render_line(self, y: int) -> Strip:
        """Return a row."""
        if self._stale:
            self._rows = self._lines_now()
            self._blended.clear()
            self._stale = False
        line = _row(self._rows, y)
        return Strip.blank(self.content_size.width, self._blend(())) if line is None else self._cells(line)

    def notify_style_update(self) -> None:
        """Blend colours anew: the theme or the focus is another one."""
        self._stale = True
        super().notify_style_update()

    def _lines_now(self) -> Sequence[Text]:
        width, height = self.content_size
        return self.lines_for(width, height) if width > 0 and height > 0 else ()

    def _cells(self, line: Text) -> Strip:
        return Strip([Segment(text, self._blend(styles)) for text, styles in pieces(line)], line.cell_len)

    def _blend(self, styles: Styles) -> Style:
        """Return styles, one over the other, as they look on the ground of this widget."""
        found = self._blended.get(styles)
        if found is None:
            get, ansi = self.app.console.get_style, self.app.ansi_theme
            blended = sum((BlendedStyle.from_rich_style(get(style), ansi) for style in styles), self.visual_style)
            found = self._blended[styles] = blended.rich_style
        return found


def pieces(line: Text) -> Iterator[tuple[str, Styles]]:
    """Return a line in pieces of one style each, with the styles that lie one over the other there."""
    plain, ground = line.plain, (line.style,) if line.style else ()
    spans = [span for span in line.spans if span.start < span.end]
    if any(one.end > other.start for one, other in pairwise(spans)):
        yield from _layered(plain, ground, spans)
        return
    at = 0
    for start, end, style in spans:
        if at < start:
            yield plain[at:start], ground
        yield plain[start:end], (*ground, style) if style else ground
        at = end
    if at < len(plain):
        yield plain[at:], ground


def _layered(plain: str, ground: Styles, spans: Sequence[Span]) -> Iterator[tuple[str, Styles]]:
    """As `pieces`, where spans lie one over the other."""
    cuts = sorted({0, len(plain), *(place for span in spans for place in span[:2])})
    for start, end in pairwise(cuts):
        over = tuple(span.style for span in spans if span.start <= start and end <= span.end and span.style)
        yield plain[start:end], (*ground, *over)


def _row(lines: Sequence[Text], row: int) -> Text | None:
    return lines[row] if row < len(lines) else None


def _same(one: Text | None, other: Text | None) -> bool:
    if one is None or other is None:
        return one is other
    return one.plain == other.plain and one.style == other.style and one.spans == other.spans


def _runs(rows: Sequence[int]) -> Iterator[tuple[int, int]]:
    """Return rows as runs: the first of each, and how many they are."""
    first = before = rows[0]
    for row in rows[1:]:
        if row != before + 1:
            yield first, before + 1 - first
            first = row
        before = row
    yield first, before + 1 - first
