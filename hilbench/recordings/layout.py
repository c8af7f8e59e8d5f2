"""The events of a journal on one line of time.

In a journal of ``hilbench check`` bench time begins again with each case. Other formats have one time for the whole
file: there each case begins where the one before it ended.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from hilbench.errors import UsageError
from hilbench.journal import Recording
from hilbench.journal.lines import encoded
from hilbench.nearest import did_you_mean

__all__ = ["BYTE_KINDS", "Event", "data_of", "json_bytes", "laid_out", "of_case", "without"]

Event = Mapping[str, Any]

BYTE_KINDS = frozenset({"tx", "rx", "dropped"})
"""Kinds of events whose ``data`` are bytes that passed a line; ``dropped`` were received, and made no frame."""

_SHOWN_CASES = 12


def laid_out(events: Iterable[Event]) -> Iterator[tuple[int, Event]]:
    """Yield each event with its time in the file, in ns from its beginning; the times never fall."""
    base_ns = last_ns = 0
    for event in events:
        ns = event["ns"] if type(event.get("ns")) is int else 0
        if event["kind"] == "case" and base_ns + ns < last_ns:
            base_ns = last_ns - ns
        last_ns = max(last_ns, base_ns + ns)
        yield last_ns, event


def data_of(event: Event) -> bytes | None:
    """Return the bytes that an event says have passed a line; None if it is about something else."""
    data = event.get("data")
    if event["kind"] not in BYTE_KINDS or not isinstance(data, str):
        return None
    try:
        return bytes.fromhex(data)
    except ValueError:
        return None


def of_case(recording: Recording, case: str, where: str) -> Recording:
    """Return what a recording has of one case, with the world that was made for it before it began.

    Args:
        recording: all of it.
        case: the id of the case; empty for everything.
        where: its name, for messages.

    Raises:
        UsageError: it has no such case.
    """
    if not case:
        return recording
    begins = {event["case"]: at for at, event in enumerate(recording.events) if event["kind"] == "case"}
    if case not in begins:
        hint = did_you_mean(case, list(begins)[:_SHOWN_CASES], "cases") if begins else "it has no cases"
        raise UsageError(f"has no case '{case}'", where=where, hint=hint)
    events = recording.events
    begin = _world_before(events, begins[case])
    ends = (at + 1 for at in range(begin, len(events)) if events[at]["kind"] == "case-end")
    return replace(recording, events=events[begin : next(ends, len(events))])


def _world_before(events: Sequence[Event], begin: int) -> int:
    """Return where the world of a case is described: before the case, if it is since the one before has ended."""
    at = begin
    while at and events[at - 1]["kind"] != "case-end":
        at -= 1
        if events[at]["kind"] == "scene":
            return at
        if events[at]["kind"] == "case":
            break
    return begin


def without(event: Event, *names: str) -> dict[str, Any]:
    """Return the fields of an event that are not among the names."""
    return {name: value for name, value in event.items() if name not in names}


def json_bytes(value: object) -> bytes:
    """Return plain data as JSON in UTF-8, on one line; what is no UTF-8 in its texts is escaped."""
    return encoded(value).removesuffix(b"\n")
