"""What tests ran, in a file of SQLite: each process of pytest writes one, and all of them are put together."""

from __future__ import annotations

import sqlite3
from collections.abc import Iterable, Mapping
from pathlib import Path

COLLECTING = "collecting"
Arcs = Mapping[str, Iterable[tuple[int, int]]]
"""The branches that ran in each file, as lines from and to; a line below zero enters or leaves a function."""
_SCHEMA = """
CREATE TABLE context (id INTEGER PRIMARY KEY, name TEXT UNIQUE);
CREATE TABLE file (id INTEGER PRIMARY KEY, path TEXT UNIQUE);
CREATE TABLE ran (context INTEGER, file INTEGER, lines BLOB);
CREATE TABLE shares (test INTEGER, fixture INTEGER);
CREATE TABLE test (context INTEGER PRIMARY KEY, cpu_s REAL, wall_s REAL, outcome TEXT);
CREATE TABLE arc (file INTEGER, start INTEGER, stop INTEGER, UNIQUE (file, start, stop));
"""
_INSERT = {
    "context": "INSERT INTO context (name) VALUES (?)",
    "file": "INSERT INTO file (path) VALUES (?)",
}


def lines_of(arcs: Iterable[tuple[int, int]]) -> bytes:
    """Return lines as bits, the least significant first."""
    bits = 0
    for line in {line for arc in arcs for line in arc if line > 0}:
        bits |= 1 << line
    return bits.to_bytes((bits.bit_length() + 7) // 8, "little")


class Part:
    """What one process has recorded.

    Args:
        path: where it is written.
    """

    def __init__(self, path: Path) -> None:
        self._store = sqlite3.connect(path, isolation_level=None)
        self._store.executescript(f"PRAGMA journal_mode = OFF; PRAGMA synchronous = OFF; {_SCHEMA}")
        self._arcs: dict[str, set[tuple[int, int]]] = {}
        self._ids: dict[tuple[str, str], int] = {}

    def _id(self, table: str, name: str) -> int:
        if (table, name) not in self._ids:
            made = self._store.execute(_INSERT[table], (name,)).lastrowid
            assert made is not None
            self._ids[table, name] = made
        return self._ids[table, name]

    def context(self, name: str) -> int:
        """Return a context's number, which it gets when it is first asked for."""
        return self._id("context", name)

    def file(self, path: str) -> int:
        """Return a file's number, which it gets when it is first asked for."""
        return self._id("file", path)

    def ran(self, context: str, arcs: Arcs) -> None:
        """Note what ran in a context."""
        rows = [(self.context(context), self.file(path), lines_of(pairs)) for path, pairs in arcs.items()]
        self._store.executemany("INSERT INTO ran VALUES (?, ?, ?)", rows)
        for path, pairs in arcs.items():
            self._arcs.setdefault(path, set()).update(pairs)

    def ended(self, test: str, took: tuple[float, float], outcome: str, fixtures: Iterable[str]) -> None:
        """Note that a test has ended after some processor and wall time, and what it shares with others."""
        number = self.context(test)
        self._store.execute("INSERT OR REPLACE INTO test VALUES (?, ?, ?, ?)", (number, *took, outcome))
        shares = [(number, self.context(fixture)) for fixture in fixtures]
        self._store.executemany("INSERT INTO shares VALUES (?, ?)", shares)

    def take_in(self, other: Path) -> None:
        """Add what another process has written."""
        self._store.execute("ATTACH ? AS other", (str(other),))
        contexts = {number: self.context(name) for number, name in self._store.execute("SELECT * FROM other.context")}
        files = dict(self._store.execute("SELECT * FROM other.file"))
        ran = [
            (contexts[context], self.file(files[file]), lines)
            for context, file, lines in self._store.execute("SELECT * FROM other.ran")
        ]
        tests = [(contexts[row[0]], *row[1:]) for row in self._store.execute("SELECT * FROM other.test")]
        shares = [(contexts[a], contexts[b]) for a, b in self._store.execute("SELECT * FROM other.shares")]
        for file, start, stop in self._store.execute("SELECT * FROM other.arc"):
            self._arcs.setdefault(files[file], set()).add((start, stop))
        self._store.execute("DETACH other")
        self._store.executemany("INSERT INTO ran VALUES (?, ?, ?)", ran)
        self._store.executemany("INSERT OR REPLACE INTO test VALUES (?, ?, ?, ?)", tests)
        self._store.executemany("INSERT INTO shares VALUES (?, ?)", shares)

    def close(self) -> None:
        """Write the branches, and make what is looked for quick to find."""
        rows = [(self.file(path), *arc) for path, arcs in self._arcs.items() for arc in arcs]
        self._store.executemany("INSERT INTO arc VALUES (?, ?, ?)", rows)
        self._store.execute("CREATE INDEX by_file ON ran (file)")
        self._store.close()
