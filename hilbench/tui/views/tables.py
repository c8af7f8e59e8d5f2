"""The tables of a bench, one below the other: what stands in each row, its rate, and what came last."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from rich.text import Text

from hilbench.tui.model.tables import RowModel, TableModel
from hilbench.tui.views.words import DIM, HEAD, LIT, fit, tail

__all__ = ["row_at", "tables_view"]

_RATE = 8
_MOST_LAST = 24
"""Cells that are kept for what came last, before a column is shown (choice)."""
_MOST_KEY = 40


def tables_view(
    tables: Sequence[TableModel], width: int, height: int, now_ns: int, *, chosen: object = None
) -> list[Text]:
    """Return a row a line, below the heads of their tables.

    Args:
        tables: those that have rows.
        width: cells in a line.
        height: lines there are.
        now_ns: bench time.
        chosen: source, table and key of the row that is pointed at.
    """
    if not tables:
        return [fit(Text("nothing is there yet", DIM), width)]
    lines = list(_lines(tables, width, now_ns, chosen))
    begin = _begin(tables, height, chosen)
    return lines[begin : begin + height]


def row_at(tables: Sequence[TableModel], height: int, chosen: object, line: int) -> tuple[str, str, str] | None:
    """Return the row that stands in a line of the view, by source, table and key; None in the head of a table."""
    names = _names(tables)
    at = _begin(tables, height, chosen) + line
    return names[at] if 0 <= at < len(names) else None


def _names(tables: Sequence[TableModel]) -> list[tuple[str, str, str] | None]:
    names: list[tuple[str, str, str] | None] = []
    for table in tables:
        names += [None, *((table.source, table.name, key) for key in table.rows)]
    return names


def _begin(tables: Sequence[TableModel], height: int, chosen: object) -> int:
    names = _names(tables)
    at = next((number for number, name in enumerate(names) if name is not None and name == chosen), 0)
    return max(0, min(at - height // 2, len(names) - height))


def _lines(tables: Sequence[TableModel], width: int, now_ns: int, chosen: object) -> Iterator[Text]:
    several = len({table.source for table in tables}) > 1
    names = [f"{table.source} {table.name}" if several else table.name for table in tables]
    keys = [key for table in tables for key in table.rows]
    breadth = min(max(map(len, (*names, *keys))), _MOST_KEY, max(8, width // 3))
    rated = any(row.counted is not None for table in tables for row in table.rows.values())
    for name, table in zip(names, tables, strict=True):
        rows = list(table.rows.values())
        last = min(_MOST_LAST, max(_last(row).cell_len for row in rows))
        columns = _columns(table, rows, width - 2 - breadth - _RATE * rated - (last + 2) * bool(last))
        head = Text.assemble((f"  {tail(name, breadth):<{breadth}}", HEAD), (f"{'per s':>{_RATE}}" * rated, DIM))
        for number, wide, right in columns:
            head.append(f"  {table.columns[number]:{'>' if right else '<'}{wide}}", DIM)
        head.append("  last" * bool(last), DIM)
        yield fit(head, width)
        for row in rows:
            points = chosen == (table.source, table.name, row.key)
            yield _row(row, breadth, columns, width, now_ns, rated=rated, points=points)


def _columns(table: TableModel, rows: Sequence[RowModel], room: int) -> list[tuple[int, int, bool]]:
    """Return the columns that there is room for: number, breadth, whether they stand to the right, as figures do."""
    found = []
    for number, name in enumerate(table.columns):
        cells = [row.cells[number] for row in rows if number < len(row.cells)]
        wide = max(map(len, (name, *cells)))
        room -= wide + 2
        if room < 0:
            break
        found.append((number, wide, all(cell.isdigit() for cell in cells)))
    return found


def _row(
    row: RowModel, breadth: int, columns: Sequence[tuple[int, int, bool]], width: int, now_ns: int, *,
    rated: bool, points: bool,
) -> Text:  # fmt: skip
    per_s = row.per_s(now_ns)
    rate = "" if per_s is None else f"{per_s:.1f}"
    text = Text.assemble(("▸ " if points else "  ", HEAD), (f"{tail(row.key, breadth):<{breadth}}", HEAD))
    text.append(f"{rate:>{_RATE}}" * rated)
    for number, wide, right in columns:
        cell = row.cells[number] if number < len(row.cells) else ""
        text.append(f"  {cell:{'>' if right else '<'}{wide}}")
    text.append("  ")
    text.append_text(_last(row))
    text = fit(text, width)
    return Text(f"{text.plain:<{width}}", LIT) if points else text


def _last(row: RowModel) -> Text:
    if row.words:
        return Text(row.words, DIM)
    text = Text()
    for one in row.fields:
        text.append(f"{one.quantity.label} ", DIM)
        text.append(one.text)
        text.append(f" {one.quantity.unit}  " if one.quantity.unit else "  ", DIM)
    text.rstrip()
    return text
