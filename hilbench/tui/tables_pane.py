"""The pane of the tables that devices of a bench have to show; what came last in a row can be plotted."""

from __future__ import annotations

from collections.abc import Sequence

from rich.text import Text

from hilbench.tui.fields_pane import FieldsPane
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.frames import Field
from hilbench.tui.model.tables import RowModel, TableModel
from hilbench.tui.views.tables import row_at, tables_view
from hilbench.tui.views.words import seconds

__all__ = ["TablesPane"]

Thing = tuple[TableModel, RowModel]


class TablesPane(FieldsPane):
    """See the module; a row is known by source and name of its table, and what it is about."""

    def __init__(self) -> None:
        super().__init__("tables")

    def things(self) -> list[Thing]:
        """See `FieldsPane`."""
        return [] if self.model is None else list(self.model.tables.rows)

    def name_of(self, thing: Thing) -> object:
        """See `FieldsPane`."""
        table, row = thing
        return table.source, table.name, row.key

    def fields_of(self, thing: Thing) -> Sequence[Field]:
        """See `FieldsPane`."""
        return thing[1].fields

    def signal_of(self, thing: Thing, field: str) -> str:
        """See `FieldsPane`."""
        assert self.model is not None
        return self.model.tables.signal_of(*thing, field)

    def title_of(self, thing: Thing, now_ns: int) -> tuple[str, str]:
        """See `FieldsPane`."""
        table, row = thing
        said = [f"{name} {cell}" for name, cell in zip(table.columns, row.cells, strict=False)]
        if row.counted is not None:
            said.append(f"{row.counted.value}x, {row.counted.per_s(now_ns):.1f}/s")
        if row.ns is not None:
            said.append(f"last at {seconds(row.ns)}")
        return row.key, ", ".join([*said, *[row.words] * bool(row.words)])

    def listed(self, model: BenchModel, width: int, height: int) -> list[Text]:
        """See `FieldsPane`."""
        return tables_view(model.tables.shown, width, height, model.ns, chosen=self.chosen)

    def name_at(self, row: int) -> object:
        """See `FieldsPane`."""
        return None if self.model is None else row_at(self.model.tables.shown, self.size.height, self.chosen, row)
