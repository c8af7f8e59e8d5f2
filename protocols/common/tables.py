"""What stands on a bench, as tables that a dashboard shows: rows with a rate, and with what came last."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

__all__ = ["LooksAtTables", "Row", "Table", "Value"]

Value = bool | int | float | str


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A row of a table.

    Attributes:
        cells: what stands in it, a text for each column.
        count: how much has come so far; shown by its rate, in a second of bench time. None where nothing comes.
        last: what came last, by the names of its fields, of which numbers can be plotted; or in words. A name may end
            with a unit, as that of a frame's field.
    """

    cells: Sequence[str] = ()
    count: int | None = None
    last: Mapping[str, Value] | str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class Table:
    """A table.

    Attributes:
        columns: what they are called, the most important first: where there is little room, the last are left out.
        rows: by what they are about.
    """

    columns: Sequence[str] = ()
    rows: Mapping[str, Row] = field(default_factory=dict)


LooksAtTables = Callable[[], Mapping[str, Table]]
"""Returns tables by what is in them, such as ``topics``: always the same ones, though some may be empty."""
