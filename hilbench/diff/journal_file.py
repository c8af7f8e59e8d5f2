"""Reads a journal as a capture: edges of pins, words of parts, bytes of lines, resets and the firmware's end.

A word that a part publishes again and again counts when it changes.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from hilbench.diff.capture import Capture, Track, Value
from hilbench.errors import UnavailableError, UsageError
from hilbench.journal import Journal, Recording
from hilbench.mcu.pin_log import WINDOW_NS
from hilbench.nearest import did_you_mean
from hilbench.recordings.event_form import wrong_with
from hilbench.recordings.remarks import remarks_on

__all__ = ["read_journal"]

_BYTES = frozenset({"tx", "rx", "console"})
"""Kinds of events that carry bytes of a line."""
_WORDS = ("code", "word")
_MARKS = {"reset": "reason", "end": "reason"}
_SHOWN_CASES = 12

Event = Mapping[str, Any]


def read_journal(path: Path, case: str = "") -> Capture:
    """Read a journal of ``hilbench run``, ``serve`` or ``check``.

    Args:
        path: the file.
        case: the id of the case that is meant, if the journal has any.

    Raises:
        UnavailableError: it cannot be read, or an event is damaged; the line is named.
        UsageError: it has cases and none is chosen, or none of that id.
    """
    try:
        recording = Journal.read(path)
    except UsageError as error:
        raise UnavailableError(error.message, where=error.where) from error
    if not recording.header:
        raise UnavailableError(f"no journal can be read from it: {recording.problem}", where=str(path))
    _check(path, recording)
    case, begin_ns, end_ns, events = _chosen(path, recording, case)
    gathered = _Gathered(begin_ns)
    for event in events:
        gathered.take(event)
    return Capture(
        label=f"{path} {case}".rstrip(),
        kind=f"journal of {recording.header.get('bench', 'a bench')}",
        tracks=gathered.tracks(),
        end_ns=end_ns - begin_ns,
        boards=frozenset(recording.header.get("images", {}) or gathered.boards),
        floats=True,
        case=case,
        complete=recording.ended and recording.problem is None,
        remarks=tuple(remarks_on(recording.header, recording.problem, "compared")),
    )


def _check(path: Path, recording: Recording) -> None:
    if not isinstance(recording.header.get("images", {}), dict):
        raise UnavailableError("'images' is no table of boards", where=f"{path}:1")
    for number, event in enumerate(recording.events, 2):  # an event is a line, and the first line is the header
        if wrong := wrong_with(event):
            raise UnavailableError(wrong, where=f"{path}:{number}")


def _chosen(path: Path, recording: Recording, case: str) -> tuple[str, int, int, Iterable[Event]]:
    """Return case, begin, end and events of the case, or of a journal without cases as a whole."""
    events = recording.events
    begins = {event["case"]: at for at, event in enumerate(events) if event["kind"] == "case"}
    if not begins:
        return "", 0, max((event["ns"] for event in events), default=0), events
    if not case:
        names = ", ".join(list(begins)[:_SHOWN_CASES]) + (", ..." if len(begins) > _SHOWN_CASES else "")
        raise UsageError("has a bench for each case", where=str(path), hint=f"choose one with --case: {names}")
    if case not in begins:
        raise UsageError(f"has no case '{case}'", where=str(path), hint=did_you_mean(case, begins, "cases"))
    begin = begins[case]
    end = next((at for at in range(begin, len(events)) if events[at]["kind"] == "case-end"), len(events) - 1)
    return case, events[begin]["ns"], events[end]["ns"], events[begin + 1 : end]


class _Gathered:
    """The signals of a journal, while it is read."""

    def __init__(self, begin_ns: int) -> None:
        self._begin_ns = begin_ns
        self._happened: dict[str, list[tuple[int, Value]]] = {}
        self._summarised: dict[str, int] = {}
        self._without_frames: set[str] = set()
        self.boards: set[str] = set()

    def take(self, event: Event) -> None:
        """Take one event."""
        kind, source, ns = event["kind"], event["source"], event["ns"] - self._begin_ns
        if kind == "pin":
            self.boards.add(source.partition(".")[0])
            self._add(source, ns, event["level"])
        elif kind == "frames":
            self._without_frames.add(f"{source}.{event['pin']}")
        elif kind == "pwm":
            self._summary(source, ns, event)
        elif kind in _BYTES:
            self._bytes(f"{source} {kind}", event.get("from_ns", event["ns"]) - self._begin_ns, event.get("data", ""))
        elif kind in _MARKS:
            self._add(f"{source} {kind}", ns, str(event.get(_MARKS[kind], "")))
        elif kind == "event" and isinstance(event.get("value"), dict):
            self._word(source, event["value"], ns)

    def tracks(self) -> dict[str, Track]:
        """Return the signals."""
        return {name: self._track(name) for name in sorted({*self._happened, *self._summarised, *self._without_frames})}

    def _track(self, name: str) -> Track:
        happened = sorted(self._happened.get(name, []), key=lambda pair: pair[0])
        return Track(
            name=name,
            times_ns=[ns for ns, _ in happened],
            values=[value for _, value in happened],
            levels=" " not in name,
            without_frames=name in self._without_frames,
            summarised_from_ns=self._summarised.get(name),
        )

    def _add(self, name: str, ns: int, value: Value) -> None:
        self._happened.setdefault(name, []).append((ns, value))

    def _summary(self, source: str, ns: int, event: Event) -> None:
        self._summarised.setdefault(source, ns - WINDOW_NS)
        period = f"period {event['period_ns']} ns, high {event['high_ns']} ns, " if "period_ns" in event else ""
        self._add(f"{source} pwm", ns, f"{period}{event['edges']} edges in {event['in_ns']} ns")

    def _bytes(self, name: str, ns: int, data: str) -> None:
        for at in range(0, len(data), 2):
            self._add(name, ns, data[at : at + 2])

    def _word(self, source: str, value: Mapping[str, Any], ns: int) -> None:
        word = next((value[name] for name in _WORDS if isinstance(value.get(name), int)), None)
        if word is None:
            return
        name = f"{source} word"
        before = self._happened.get(name)
        if not before or before[-1][1] != word:
            self._add(name, value.get("at_ns", ns + self._begin_ns) - self._begin_ns, word)
