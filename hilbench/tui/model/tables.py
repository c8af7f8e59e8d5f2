"""The tables that devices of a bench have to show, with the rate of each row and what came last there, over time."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hilbench.tui.model.frames import Field
from hilbench.tui.model.quantities import quantity_of
from hilbench.tui.model.rates import Counted

__all__ = ["RowModel", "TableModel", "TablesModel"]

Event = Mapping[str, Any]
_KEPT = 3000
"""Points of a row: five minutes at the rate of the reports."""


@dataclass(slots=True)
class RowModel:
    """A row.

    Attributes:
        key: what it is about.
        cells: what stands in it.
        counted: how much has come, and how fast; None where nothing comes.
        fields: what came last; empty where that is not known, and `words` say why.
        words: see `fields`.
        ns: when that was reported, in ns of bench time; None before anything came.
    """

    key: str
    cells: Sequence[str] = ()
    counted: Counted | None = None
    fields: Sequence[Field] = ()
    words: str = ""
    ns: int | None = None
    _came: Sequence[Any] = ()
    _points: deque[tuple[int, tuple[Field, ...]]] = field(default_factory=lambda: deque(maxlen=_KEPT))

    def take(self, ns: int, reported: Sequence[Any]) -> None:
        """Take what was reported; what was reported before and is only repeated is no new value."""
        self.cells, *came = reported
        count, last = came
        if count is not None:
            self.counted = self.counted or Counted()
            self.counted.take(count, ns)
        self.words = last if isinstance(last, str) else ""
        if not last or came == self._came:
            return
        self.ns, self._came = ns, came
        fields = () if self.words else tuple(Field(name, quantity_of(name, {}), one) for name, one in last.items())
        self.fields = fields
        self._points.append((ns, tuple(one for one in fields if _is_number(one.value))))

    def per_s(self, now_ns: int) -> float | None:
        """Return how much comes in a second of bench time, lately; None where nothing comes."""
        return None if self.counted is None else self.counted.per_s(now_ns)

    def series(self, name: str) -> list[tuple[int, float]]:
        """Return the values of a field that is a number, with their times in ns."""
        return [(ns, one.numbers[0]) for ns, fields in self._points for one in fields if one.name == name]


@dataclass(slots=True)
class TableModel:
    """A table.

    Attributes:
        source: whose it is.
        name: what is in it.
        columns: what they are called.
        rows: by what they are about, as they were reported first.
    """

    source: str
    name: str
    columns: Sequence[str] = ()
    rows: dict[str, RowModel] = field(default_factory=dict)


class TablesModel:
    """All tables of a bench.

    Attributes:
        tables: those that there are, by source and name.
    """

    def __init__(self) -> None:
        self.tables: dict[tuple[str, str], TableModel] = {}

    @property
    def shown(self) -> list[TableModel]:
        """The tables that have rows."""
        return [table for table in self.tables.values() if table.rows]

    @property
    def rows(self) -> Iterator[tuple[TableModel, RowModel]]:
        """All rows."""
        return ((table, row) for table in self.tables.values() for row in table.rows.values())

    def take(self, event: Event) -> None:
        """Take what was reported of a table."""
        table = self.tables.setdefault((event["source"], event["table"]), TableModel(event["source"], event["table"]))
        table.columns = event["columns"]
        reported = event["rows"]
        for key in [*table.rows] if event["whole"] else event["gone"]:
            if key not in reported:
                table.rows.pop(key, None)
        for key, row in reported.items():
            table.rows.setdefault(key, RowModel(key)).take(event["ns"], row)

    def signal_of(self, table: TableModel, row: RowModel, name: str) -> str:
        """Return what a field of a row is called as a figure."""
        of = f"{table.source} " if len({source for source, _ in self.tables}) > 1 else ""
        return f"{of}{row.key} {name}"

    def field(self, signal: str) -> tuple[RowModel, Field] | None:
        """Return the field of a row that is a figure of this name; None if there is no such."""
        for table, row in self.rows:
            for one in row.fields:
                if self.signal_of(table, row, one.name) == signal:
                    return row, one
        return None


def _is_number(value: object) -> bool:
    return isinstance(value, int | float)
