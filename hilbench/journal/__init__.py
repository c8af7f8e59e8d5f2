"""The journal: what happened on the bench, one JSON object a line, and the hash two equal runs share.

The first line is the header. Every other line is an event: `ns` (bench time), `kind`, `source`, and its own fields.
Lines are collected and written with one call per bench step, so a killed process loses its last step at most, and what
is there can be read.

A case's hash is made of the events between `begin_case` and `end_case`. What belongs to the host and not to the bench
stays out of it by name: kinds and fields that begin with `host` (host_path, host_pid, host_lateness_ns, host_time), the
fields `cause` and `text`, which are prose, and the kinds `scene` and `margins`, for those who draw: what stands there
and matters, and what timers do, the other events show. Floats enter it in millionths: a micrometre, a microradian.
Equality of hashes is promised for one platform and one set of dependencies.
"""

from __future__ import annotations

import dataclasses
import enum
import hashlib
import platform
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import msgspec

import hilbench
from hilbench.errors import InternalError, UnavailableError, UsageError
from hilbench.files.names import escaped_all
from hilbench.journal.journal_file import JournalFile

FORMAT = 1
KEEP_EVENTS = 2000
_FLUSH_BYTES = 256 * 1024
_SHARE_OF_SCENE = 4
"""A scene that takes more than this part of a part of a journal is not said anew (choice)."""
PROSE_FIELDS = frozenset({"cause", "text"})
"""Fields that are for people, and no part of what is the same in two equal runs."""
SCENE = "scene"
"""The kind of what stands around a vehicle; each part of a journal says it anew."""
MARGINS = "margins"
"""The kind of how much time timers had left; see `hilbench.bench.margins`."""
_MILLIONTHS = 1_000_000

_encoder = msgspec.json.Encoder()
_canonical_encoder = msgspec.json.Encoder(order="deterministic")


def metres(length_m: float) -> int:
    """Return a length in whole micrometres, as world fields of events carry it.

    Raises:
        ValueError: it is not a number, or infinite.
    """
    return _whole_millionths(length_m)


def radians(angle_rad: float) -> int:
    """Return an angle in whole microradians, as world fields of events carry it.

    Raises:
        ValueError: it is not a number, or infinite.
    """
    return _whole_millionths(angle_rad)


def is_hashed(kind: str) -> bool:
    """Return whether events of this kind are part of what is the same in two equal runs."""
    return kind not in {SCENE, MARGINS} and not kind.startswith("host")


def run_hash(case_hashes: Mapping[str, str]) -> str:
    """Return the hash of a run, made of its cases' hashes in the order of their ids."""
    digest = hashlib.sha256()
    for case_id in sorted(case_hashes):
        digest.update(_encoded(_canonical_encoder, [case_id, case_hashes[case_id]]))
    return digest.hexdigest()


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
        self.header = _versions() | {key: _plain(value) for key, value in (header or {}).items()}
        self.recent: deque[Mapping[str, Any]] = deque(maxlen=keep)
        self.on_event: Callable[[Mapping[str, Any]], None] | None = None
        self._part = 0
        self._pending: list[bytes] = []
        self._pending_bytes = 0
        self._case: str | None = None
        self._case_start_ns = 0
        self._digest = hashlib.sha256()
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
            event[name] = _plain(value)
        self.recent.append(event)
        if self.on_event is not None:
            self.on_event(event)
        if self._case is not None and is_hashed(kind):
            self._add_to_hash(event)
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
        self._pending.append(_encoded(_encoder, {"ns": at_ns, "kind": "host-end", "source": "journal"}))
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
        self._case_start_ns = at_ns
        self._digest = hashlib.sha256()

    def end_case(self, at_ns: int = 0) -> str:
        """End the case and return its hash, 64 hexadecimal digits."""
        if self._case is None:
            raise InternalError("a case ends that has not begun", where="journal")
        case_id, self._case = self._case, None
        digest = self._digest.hexdigest()
        self.record("case-end", "journal", at_ns, case=case_id, hash=digest)
        self.flush_step()
        return digest

    def _add_to_hash(self, event: Mapping[str, Any]) -> None:
        canonical = {
            name: _canonical(value)
            for name, value in event.items()
            if name not in PROSE_FIELDS and not name.startswith("host")
        }
        canonical["ns"] -= self._case_start_ns
        self._digest.update(_encoded(_canonical_encoder, canonical))

    # --- the file

    def _queue(self, event: Mapping[str, Any]) -> None:
        line = _encoded(_encoder, event)
        if event["kind"] == SCENE:
            self._scene = line
        self._pending.append(line)
        self._pending_bytes += len(line)
        if self._pending_bytes >= _FLUSH_BYTES:
            self.flush_step()

    def _write_header(self, file: JournalFile) -> None:
        file.write(_encoded(_encoder, {"kind": "journal", "part": self._part} | self.header))

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
            event = _decoded(line)
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
    return f'"kind":"{kind}"'.encode() in line and (_decoded(line) or {}).get("kind") == kind


def _about(event: Mapping[str, Any]) -> dict[str, Any]:
    return {name: value for name, value in event.items() if name not in {"kind", "source", "ns"}}


def _versions() -> dict[str, Any]:
    return {
        "format": FORMAT,
        "hilbench": hilbench.__version__,
        "python": platform.python_version(),
        "platform": f"{platform.system()} {platform.machine()}",
    }


def _whole_millionths(value: float) -> int:
    try:
        return round(value * _MILLIONTHS)
    except OverflowError as error:
        raise ValueError(f"not a finite number: {value}") from error


def _plain(value: object) -> Any:
    """Return a value as what JSON has: bytes as hex, members by name, dataclasses as objects."""
    if value is None or type(value) in (int, str, bool, float):
        return value
    if isinstance(value, enum.Enum):
        return value.name
    if isinstance(value, bytes | bytearray | memoryview):
        return value.hex()
    if isinstance(value, Mapping):
        return {str(_plain(key)): _plain(item) for key, item in value.items()}
    if isinstance(value, set | frozenset):
        return sorted((_plain(item) for item in value), key=str)
    if isinstance(value, Iterable) and not isinstance(value, str):
        return [_plain(item) for item in value]
    if dataclasses.is_dataclass(value):
        return {field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    return _plain_scalar(value)


def _plain_scalar(value: object) -> int | float | str:
    """Return subclasses of the built-in scalars, such as numpy's float64, as these; anything else as its text."""
    if isinstance(value, int):
        return int(value)
    return float(value) if isinstance(value, float) else str(value)


def _canonical(value: Any) -> Any:
    if isinstance(value, float):
        try:
            return round(value * _MILLIONTHS)
        except (OverflowError, ValueError):
            return str(value)
    if isinstance(value, dict):
        return {name: _canonical(item) for name, item in value.items() if not name.startswith("host")}
    return [_canonical(item) for item in value] if isinstance(value, list) else value


def _encoded(encoder: msgspec.json.Encoder, value: object) -> bytes:
    """Return a line of JSON; names that are not UTF-8 are rare, and cost only those who have them."""
    try:
        return encoder.encode(value) + b"\n"
    except UnicodeEncodeError:
        return encoder.encode(escaped_all(value)) + b"\n"


def _decoded(line: bytes) -> dict[str, Any] | None:
    """Return what a line says; None of one that is damaged, and be it with brackets without end."""
    try:
        return msgspec.json.decode(line, type=dict[str, Any])
    except (msgspec.DecodeError, UnicodeDecodeError, RecursionError):
        return None
