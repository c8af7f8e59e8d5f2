"""Reports to the journal what the tables of a bench say: the rows that have changed, now and then all of them."""

from __future__ import annotations

from hilbench.bench import Bench
from protocols.common.tables import Row, Table

__all__ = ["ReportedTables"]


class ReportedTables:
    """See the module.

    Args:
        bench: whose tables are reported.
    """

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self._reported: dict[tuple[str, str], Table] = {}

    def report(self, *, whole: bool) -> None:
        """Report what has changed, or everything."""
        for source, look in self._bench.tables.items():
            for name, table in look().items():
                before = self._reported.get((source, name), Table())
                self._reported[source, name] = table
                if whole:
                    self._record(source, name, table, Table(), whole=True)
                elif table != before:
                    self._record(source, name, table, before, whole=False)

    def _record(self, source: str, name: str, table: Table, before: Table, *, whole: bool) -> None:
        self._bench.record(
            "table",
            source,
            table=name,
            whole=whole,
            columns=[*table.columns],
            rows={key: _plain(row) for key, row in table.rows.items() if row != before.rows.get(key)},
            gone=[key for key in before.rows if key not in table.rows],
        )


def _plain(row: Row) -> list[object]:
    return [[*row.cells], row.count, row.last if isinstance(row.last, str) else dict(row.last)]
