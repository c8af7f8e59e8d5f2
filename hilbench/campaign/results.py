"""The results of campaigns, in a file of SQLite: each point once, whole or not at all."""

from __future__ import annotations

import contextlib
import sqlite3
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Self

import msgspec

from hilbench.campaign.point import Outcome, Point
from hilbench.errors import UnavailableError, UsageError

__all__ = ["Results"]

FORMAT = "hilbench-campaign/1"

_ELSEWHERE = "give another --results"

_TABLES = """
CREATE TABLE about (name TEXT PRIMARY KEY, value TEXT NOT NULL);
CREATE TABLE points (
  key TEXT PRIMARY KEY, bench TEXT NOT NULL, seed INTEGER NOT NULL, point TEXT NOT NULL, verdict TEXT NOT NULL,
  exit_code INTEGER NOT NULL, cause TEXT NOT NULL, run_hash TEXT NOT NULL, bench_time_s REAL NOT NULL,
  host TEXT NOT NULL, outcome TEXT NOT NULL);
CREATE TABLE levels (key TEXT NOT NULL REFERENCES points, factor TEXT NOT NULL, level, PRIMARY KEY (key, factor));
CREATE TABLE clauses (
  key TEXT NOT NULL REFERENCES points, clause TEXT NOT NULL, verdict TEXT NOT NULL, cause TEXT NOT NULL,
  PRIMARY KEY (key, clause));
CREATE TABLE figures (
  key TEXT NOT NULL REFERENCES points, clause TEXT NOT NULL, case_id TEXT NOT NULL, name TEXT NOT NULL,
  value REAL NOT NULL, unit TEXT NOT NULL, low REAL, high REAL);
CREATE INDEX figures_by_key ON figures (key);
"""
_OF_A_POINT = ("figures", "clauses", "levels", "points")


class Results:
    """A file of results; a context that closes it.

    Args:
        path: of the file; it is made if there is none.

    Raises:
        UsageError: it is no such file.
        UnavailableError: it cannot be read or written.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        with self._told():
            self._base = sqlite3.connect(path, isolation_level=None)
            try:
                self._open()
            except BaseException:
                self._base.close()
                raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._base.close()

    def known(self, keys: Iterable[str], *, errors: bool = False) -> dict[str, Outcome]:
        """Return what came of some points, by their keys.

        Args:
            keys: of the points.
            errors: those too that could not be run; they are worth another try.
        """
        found = {}
        with self._told():
            for key in keys:
                row = self._base.execute("SELECT outcome FROM points WHERE key = ?", (key,)).fetchone()
                if row is not None:
                    found[key] = msgspec.json.decode(row[0], type=Outcome)
        return {key: outcome for key, outcome in found.items() if errors or outcome.verdict != "error"}

    def enter(self, key: str, point: Point, outcome: Outcome, host: str = "") -> None:
        """Enter what came of a point, in the place of what was known of it.

        Raises:
            UnavailableError: it cannot be written.
        """
        with self._told(), self._whole():
            for table in _OF_A_POINT:
                self._base.execute(f"DELETE FROM {table} WHERE key = ?", (key,))  # noqa: S608 - names of ours
            about = msgspec.json.encode(point).decode()
            self._insert("points", [(
                key, point.bench, point.seed, about, outcome.verdict, outcome.exit_code, outcome.cause,
                outcome.run_hash, outcome.bench_time_s, host, msgspec.json.encode(outcome).decode(),
            )])  # fmt: skip
            self._insert("levels", [(key, name, level) for name, level in point.levels.items()])
            self._insert("clauses", [(key, one.id, one.verdict, one.cause) for one in outcome.clauses])
            self._insert("figures", [
                (key, one.clause, one.case, one.name, one.value, one.unit, one.low, one.high)
                for one in outcome.figures
            ])  # fmt: skip

    def _insert(self, table: str, rows: Iterable[tuple[object, ...]]) -> None:
        for row in rows:
            places = ", ".join("?" * len(row))
            self._base.execute(f"INSERT INTO {table} VALUES ({places})", row)  # noqa: S608 - names of ours

    def _open(self) -> None:
        self._base.execute("PRAGMA busy_timeout = 10000")
        with self._whole():
            tables = {name for (name,) in self._base.execute("SELECT name FROM sqlite_master WHERE type = 'table'")}
            if not tables:
                for statement in _TABLES.split(";"):
                    self._base.execute(statement)
                self._base.execute("INSERT INTO about VALUES ('format', ?)", (FORMAT,))
            elif "about" not in tables:
                raise UsageError("holds tables of something else", where=str(self._path), hint=_ELSEWHERE)
            else:
                row = self._base.execute("SELECT value FROM about WHERE name = 'format'").fetchone()
                if row is None or row[0] != FORMAT:
                    raise UsageError(f"is not of the format {FORMAT}", where=str(self._path), hint=_ELSEWHERE)

    @contextlib.contextmanager
    def _whole(self) -> Iterator[None]:
        """Do everything within or nothing: what is killed in the middle leaves what was there before."""
        self._base.execute("BEGIN IMMEDIATE")
        try:
            yield
        except BaseException:
            self._base.execute("ROLLBACK")
            raise
        self._base.execute("COMMIT")

    @contextlib.contextmanager
    def _told(self) -> Iterator[None]:
        """Say in one line what SQLite cannot do."""
        try:
            yield
        except sqlite3.DatabaseError as error:
            if "not a database" in str(error):
                raise UsageError("is no file of results", where=str(self._path), hint=_ELSEWHERE) from None
            raise UnavailableError(f"the results: {error}", where=str(self._path)) from None
