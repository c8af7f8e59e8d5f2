"""Where panes are: columns of panes, each with its share of the room, in one or several bands, one below the other.

There is an arrangement for each kind of bench; somebody may make another of it.
"""

from __future__ import annotations

import itertools
from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace

from hilbench.plugins.dashboard import Dashboard

__all__ = ["LEAST_COLUMNS", "LEAST_ROWS", "Arrangement", "Box", "Column", "arrangement_of"]

LEAST_COLUMNS = 20
LEAST_ROWS = 3
"""The least that is left of a pane: a title, a line, a border."""
_ALL = Dashboard(kind="").narrow
_BANDS = (8.0, 5.0)
"""Of a wide screen: the columns above, and the band below, where frames have the width that they need (choice)."""


@dataclass(frozen=True, slots=True)
class Box:
    """A place on the screen, in cells."""

    x: int
    y: int
    width: int
    height: int


@dataclass(frozen=True, slots=True)
class Column:
    """Panes one below the other.

    Attributes:
        share: how wide it is, beside the shares of the others.
        panes: names and how high each is, as above.
        band: the number of the band it is in, from above.
    """

    share: float
    panes: tuple[tuple[str, float], ...]
    band: int = 0

    @property
    def names(self) -> tuple[str, ...]:
        """The panes, from above."""
        return tuple(name for name, _ in self.panes)

    def of(self, shown: Collection[str]) -> tuple[tuple[str, float], ...]:
        """Return those that are to be seen."""
        return tuple((name, share) for name, share in self.panes if name in shown)


@dataclass(frozen=True, slots=True)
class Arrangement:
    """Where panes are.

    Attributes:
        columns: in each band from the left. Where there is not room for all panes, the first come first.
        hidden: the panes that are not to be seen.
        bands: how high each is, beside the shares of the others.
    """

    columns: tuple[Column, ...]
    hidden: frozenset[str] = frozenset()
    bands: tuple[float, ...] = (1.0,)

    @property
    def names(self) -> tuple[str, ...]:
        """All panes, column by column."""
        return tuple(name for column in self.columns for name in column.names)

    def boxes(self, shown: Collection[str], width: int, height: int) -> dict[str, Box]:
        """Return where the panes are that are to be seen, in a room of so many cells."""
        seen = self._seen_bands(shown)
        boxes, top = {}, 0
        for band, room in zip(seen, _shared([self.bands[band] for band in seen], height), strict=True):
            columns = [column for column in self.columns if column.band == band and column.of(shown)]
            x = 0
            for column, wide in zip(columns, _shared([one.share for one in columns], width), strict=True):
                y, panes = top, column.of(shown)
                for (name, _), high in zip(panes, _shared([share for _, share in panes], room), strict=True):
                    boxes[name] = Box(x, y, wide, high)
                    y += high
                x += wide
            top += room
        return boxes

    def _seen_bands(self, shown: Collection[str]) -> list[int]:
        """Return the bands in which something is to be seen, from above."""
        return sorted({column.band for column in self.columns if column.of(shown)})

    def resized(self, shown: Collection[str], width: int, height: int, name: str, *, dx: int, dy: int) -> Arrangement:
        """Return it with the right border of a pane's column, and the lower border of a pane, moved by cells.

        Where there is nothing to the right of it or below, the other border is moved the other way: it grows all the
        same. The lower border of a column is that of its band. A pane keeps its least size; nothing happens to one that
        is not to be seen.
        """
        at = next((number for number, column in enumerate(self.columns) if name in column.names), None)
        if at is None or name not in shown:
            return self
        columns, band = list(self.columns), self.columns[at].band
        seen = [number for number, column in enumerate(columns) if column.band == band and column.of(shown)]
        wide = _moved([columns[number].share for number in seen], width, seen.index(at), dx, LEAST_COLUMNS)
        for number, share in zip(seen, wide, strict=True):
            columns[number] = replace(columns[number], share=share)
        names, bands = [one for one, _ in columns[at].of(shown)], self._seen_bands(shown)
        if len(bands) > 1 and name == names[-1] and (band != bands[-1] or len(names) == 1):
            high = _moved([self.bands[one] for one in bands], height, bands.index(band), dy, 2 * LEAST_ROWS)
            shares = dict(enumerate(self.bands)) | dict(zip(bands, high, strict=True))
            return replace(self, columns=tuple(columns), bands=tuple(shares.values()))
        boxes = self.boxes(shown, width, height)
        room = sum(boxes[one].height for one in names)
        high = _moved([share for _, share in columns[at].of(shown)], room, names.index(name), dy, LEAST_ROWS)
        of = dict(columns[at].panes) | dict(zip(names, high, strict=True))
        columns[at] = replace(columns[at], panes=tuple((one, of[one]) for one in columns[at].names))
        return replace(self, columns=tuple(columns))

    def toggled(self, name: str) -> Arrangement:
        """Return it with a pane hidden, or to be seen again."""
        return replace(self, hidden=self.hidden ^ {name})

    def moved(self, name: str, *, columns: int = 0, places: int = 0) -> Arrangement:
        """Return it with a pane so many columns to the right, or so many places down in its column."""
        at = next((number for number, column in enumerate(self.columns) if name in column.names), None)
        if at is None:
            return self
        share = dict(self.columns[at].panes)[name]
        to = max(0, min(len(self.columns) - 1, at + columns))
        place = self.columns[at].names.index(name) + places
        made = [replace(one, panes=tuple(pane for pane in one.panes if pane[0] != name)) for one in self.columns]
        panes = list(made[to].panes)
        panes.insert(max(0, min(len(panes), place)), (name, share))
        made[to] = replace(made[to], panes=tuple(panes))
        return replace(self, columns=tuple(made))

    def seen(self, available: Collection[str], most: int) -> list[str]:
        """Return the panes to be seen of those that have something to show: the first so many that are not hidden."""
        return [name for name in self.names if name in available and name not in self.hidden][:most]


def _shared(shares: Sequence[float], whole: int) -> list[int]:
    """Return a whole in parts as large as their shares, each rounded so that the sum is the whole."""
    total = sum(shares) or 1.0
    ends, reached = [0], 0.0
    for share in shares:
        reached += share
        ends.append(round(whole * reached / total))
    return [end - begin for begin, end in itertools.pairwise(ends)]


def _moved(shares: Sequence[float], whole: int, at: int, by: int, least: int) -> list[float]:
    """Return shares of a whole, one of them larger by so many cells at the cost of its neighbour."""
    cells = _shared(shares, whole)
    other = at + 1 if at + 1 < len(cells) else at - 1
    if other < 0 or not by:
        return list(shares)
    by = max(min(0, least - cells[at]), min(by, max(0, cells[other] - least)))
    cells[at] += by
    cells[other] -= by
    total = sum(shares)
    return [total * cell / max(1, whole) for cell in cells]


def arrangement_of(dashboard: Dashboard, *, wide: bool) -> Arrangement:
    """Return where the panes are as long as nobody moves them; those that it does not name come last.

    Args:
        dashboard: says where they are.
        wide: whether there is room for many columns; else the first pane stands above the second, which has all of the
            width, and the others beside the first, as many as there is room for.
    """
    return _wide(dashboard) if wide else _narrow(dashboard)


def _wide(dashboard: Dashboard) -> Arrangement:
    named: set[str] = set()
    columns: list[Column] = []
    for band, those in enumerate((dashboard.wide, dashboard.below)):
        for share, panes in those:
            fresh = tuple(pane for pane in panes if pane[0] in _ALL and pane[0] not in named)
            columns += [Column(share, fresh, band)] if fresh else []
            named |= {name for name, _ in fresh}
    rest = tuple((name, 1.0) for name in _ALL if name not in named)
    return Arrangement((*columns, *((Column(1, rest),) if rest else ())), bands=_BANDS)


def _narrow(dashboard: Dashboard) -> Arrangement:
    first, second, *others = [name for name in dict.fromkeys((*dashboard.narrow, *_ALL)) if name in _ALL]
    beside = tuple((name, 1.0) for name in others)
    columns = (Column(5, ((first, 1.0),)), Column(1, ((second, 1.0),), 1), Column(4, beside))
    return Arrangement(columns, bands=(1.0, 1.0))
