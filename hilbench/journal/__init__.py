"""The journal: what happened on the bench, one JSON object a line.

The first line is the header. Every other line is an event: `ns` (bench time), `kind`, `source`, and its own fields.
Lines are collected and written with one call per bench step, so a killed process loses its last step at most, and what
is there can be read.

A case's hash is made of the events between `begin_case` and `end_case` (`run_hash`).
"""

from __future__ import annotations

import platform
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import hilbench
from hilbench.errors import InternalError, UnavailableError, UsageError
from hilbench.journal.journal_file import JournalFile
from hilbench.journal.lines import decoded, encoded, plain
from hilbench.journal.run_hash import SCENE, CaseHash, millionths

FORMAT = 1
KEEP_EVENTS = 2000
_FLUSH_BYTES = 256 * 1024
_SHARE_OF_SCENE = 4
"""A scene that takes more than this part of a part of a journal is not said anew (choice)."""


def metres(length_m: float) -> int:
    """Return a length in whole micrometres, as world fields of events carry it.

    Raises:
        ValueError: it is not a number, or infinite.
    """
    return millionths(length_m)


def radians(angle_rad: float) -> int:
    """Return an angle in whole microradians, as world fields of events carry it.

    Raises:
        ValueError: it is not a number, or infinite.
    """
    return millionths(angle_rad)


@dataclass(frozen=True, slots=True, kw_only=True)
class Recording:
    """A journal as read back.

    Attributes:
        header: The first line; empty if even that was cut.
        events: The events up to the cut, in order.
        problem: What ended the reading before the end of the file, in one line; None if nothing did.
        ended: Whether the journal was closed in good order. A recording without a problem that has not ended is that
            of a process that was killed, or is still running.
    """

    header: Mapping[str, Any]
    events: tuple[Mapping[str, Any], ...]
    problem: str | None
    ended: bool


class Journal:
    """An append-only record of one bench.

    Args:
        path: The file to write; None keeps the events in memory only. An older journal there is overwritten, any other
            file is refused.
        header: What the first line says beside the versions: seed, digests of images and bench file, timing model.
        keep: How many of the latest events stay in memory, as evidence.
        max_bytes: What the journal may take on disk; when half of it is full, the file is renamed to PATH.1 (and an
            older PATH.1 forgotten). None for no limit; devices and pipes have none.
        after: The journal that this one takes the place of; what it keeps in memory is recorded here first.

    Attributes:
        on_event: Called with each event as it is recorded; None while nobody listens.

    Raises:
        UsageError: the path, or PATH.1 where it is needed, holds something else.
        UnavailableError: the file cannot be written, or another program writes it.
    """

    def __init__(
        self,
        path: Path | str | None = None,
        header: Mapping[str, object] | None = None,
        *,
        keep: int = KEEP_EVENTS,
        max_bytes: int | None = None,
        after: Journal | None = None,
    ) -> None:
        self.path = None if path is None else Path(path)
        self.header = _versions() | {key: plain(value) for key, value in (header or {}).items()}
        self.recent: deque[Mapping[str, Any]] = deque(maxlen=keep)
        self.on_event: Callable[[Mapping[str, Any]], None] | None = None
        self._part = 0
        self._pending: list[bytes] = []
        self._pending_bytes = 0
        self._case: str | None = None
        self._hash = CaseHash(0)
        self._file = None if self.path is None else JournalFile(self.path, max_bytes)
        self._scene = b""
        if self._file is not None:
            self._write_header(self._file)
        for event in after.recent if after is not None else ():
            self.record(event["kind"], event["source"], event["ns"], **_about(event))

    # --- recording

    def record(self, kind: str, source: str, at_ns: int, **fields: object) -> None:
        """Record an event.

        Args:
            kind: What sort of event: tx, rx, state, fault, verdict, ...
            source: Which part of the bench it is about.
            at_ns: Bench time in ns.
            **fields: What it says. Bytes are written as hex, enumeration members by name, dataclasses as objects.
        """
        event: dict[str, Any] = {"ns": at_ns, "kind": kind, "source": source}
        for name, value in fields.items():
            event[name] = plain(value)
        self.recent.append(event)
        if self.on_event is not None:
            self.on_event(event)
        if self._case is not None:
            self._hash.add(event)
        if self._file is not None:
            self._queue(event)

    def record_value(self, kind: str, source: str, at_ns: int, value: object) -> None:
        """Record an event that exists as an object: `name` is its class, `value` its fields."""
        self.record(kind, source, at_ns, name=type(value).__name__, value=value)

    def append(self, lines: bytes) -> None:
        """Add whole lines of another journal with the same header, such as those of a case, to the file.

        Raises:
            UnavailableError: they cannot be written.
        """
        for line in lines.splitlines(keepends=True):
            if _is_of(SCENE, line):
                self._scene = line
            elif _is_of("case", line):
                self._scene = b""
            self._pending.append(line)
            self._pending_bytes += len(line)
            if self._pending_bytes >= _FLUSH_BYTES:
                self.flush_step()
        self.flush_step()

    def flush_step(self) -> None:
        """Write what was recorded since the last call, in one piece. Called by the bench after each of its steps."""
        if not self._pending or self._file is None:
            return
        self._write_pending(self._file)
        if self._file.full:
            self._file.begin_anew()
            self._part += 1
            self._write_header(self._file)
            if len(self._scene) <= self._file.room_bytes // _SHARE_OF_SCENE:
                self._file.write(self._scene)

    def close(self, at_ns: int = 0) -> None:
        """Write what is left and an end mark, and close the file; a second call does nothing."""
        if self._file is None:
            return
        file, self._file = self._file, None
        self._pending.append(encoded({"ns": at_ns, "kind": "host-end", "source": "journal"}))
        try:
            self._write_pending(file)
        finally:
            file.close()

    # --- cases

    def begin_case(self, case_id: str, at_ns: int = 0) -> None:
        """Begin the hash of a case at bench time `at_ns`; times enter the hash relative to it."""
        if self._case is not None:
            raise InternalError(f"case {case_id} begins inside case {self._case}", where="journal")
        self.record("case", "journal", at_ns, case=case_id)
        self._case, self._scene = case_id, b""
        self._hash = CaseHash(at_ns)

    def end_case(self, at_ns: int = 0) -> str:
        """End the case and return its hash, 64 hexadecimal digits."""
        if self._case is None:
            raise InternalError("a case ends that has not begun", where="journal")
        case_id, self._case = self._case, None
        digest = self._hash.hexdigest()
        self.record("case-end", "journal", at_ns, case=case_id, hash=digest)
        self.flush_step()
        return digest

    # --- the file

    def _queue(self, event: Mapping[str, Any]) -> None:
        line = encoded(event)
        if event["kind"] == SCENE:
            self._scene = line
        self._pending.append(line)
        self._pending_bytes += len(line)
        if self._pending_bytes >= _FLUSH_BYTES:
            self.flush_step()

    def _write_header(self, file: JournalFile) -> None:
        file.write(encoded({"kind": "journal", "part": self._part} | self.header))

    def _write_pending(self, file: JournalFile) -> None:
        data = b"".join(self._pending)
        self._pending.clear()
        self._pending_bytes = 0
        file.write(data)

    # --- reading

    @staticmethod
    def read(path: Path | str) -> Recording:
        """Read a journal up to its end, or to the line where it was cut.

        Raises:
            UsageError: the file is not a journal.
            UnavailableError: the file cannot be read.
        """
        try:
            data = Path(path).read_bytes()
        except OSError as error:
            reason = error.strerror or str(error)
            raise UnavailableError(f"cannot be read: {reason}", where=str(path)) from error
        try:
            return Journal.parse(data)
        except UsageError as error:
            raise UsageError(error.message, where=str(path)) from error

    @staticmethod
    def parse(data: bytes) -> Recording:
        """Read the bytes of a journal up to their end, or to the line where they were cut.

        Raises:
            UsageError: they are no journal.
        """
        lines = data.split(b"\n")
        cut = lines.pop()
        events: list[Mapping[str, Any]] = []
        problem = f"cut in line {len(lines) + 1}" if cut else None
        for number, line in enumerate(lines, 1):
            event = decoded(line)
            if event is None or "kind" not in event:
                problem = f"line {number} cannot be read"
                break
            events.append(event)
        header = events.pop(0) if events else {}
        if header.get("kind") != "journal" and lines:
            raise UsageError("is not a hilbench journal")
        if not lines and problem is None:
            problem = "the file is empty"
        ended = bool(events) and events[-1]["kind"] == "host-end"
        return Recording(header=header, events=tuple(events), problem=problem, ended=ended)


def _is_of(kind: str, line: bytes) -> bool:
    """Say whether an event as it is written is of a kind."""
    return f'"kind":"{kind}"'.encode() in line and (decoded(line) or {}).get("kind") == kind


def _about(event: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in event.items() if name not in {"kind", "source", "ns"}}


def _versions() -> dict[str, Any]:
    return {
        "format": FORMAT,
        "hilbench": hilbench.__version__,
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
    }
