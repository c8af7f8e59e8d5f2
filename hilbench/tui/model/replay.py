"""A recording and a place in it; the model there is made of all events before it."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping, Sequence
from typing import Any

from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.log import line_of

__all__ = ["Replay"]

Event = Mapping[str, Any]
NS_PER_S = 1_000_000_000


class Replay:
    """See the module.

    Args:
        header: the first line of the journal.
        events: the others, in order.

    Attributes:
        model: what is known at the place.
        playing: whether time goes on by itself.
        marks: where something happened, in the order of time: ``!`` an error, ``m`` a mark, ``c`` a verdict.
    """

    def __init__(self, header: Event, events: Sequence[Event]) -> None:
        self.playing = False
        self._header = header
        self._events = [event for event in events if isinstance(event.get("ns"), int)]
        self._times: list[int] = []
        for event in self._events:  # an event that is told late belongs where it stands
            self._times.append(max(event["ns"], self._times[-1] if self._times else 0))
        sorts = [_sort(event) for event in self._events]
        self._errors = [at for at, sort in enumerate(sorts) if sort == "!"]
        self.marks = [(ns, sort) for ns, sort in zip(self._times, sorts, strict=True) if sort]
        self._at = 0
        self._now_ns = 0
        self.model = BenchModel(header)
        self.go_to(self.length_ns)

    @property
    def length_ns(self) -> int:
        """The bench time of the last event."""
        return self._times[-1] if self._times else 0

    @property
    def now_ns(self) -> int:
        """The bench time of the place."""
        return self._now_ns

    def go_to(self, ns: int) -> None:
        """Go to a bench time: everything up to it has happened."""
        self._now_ns = max(0, min(ns, self.length_ns))
        self._place(bisect_right(self._times, self._now_ns))

    def go_by(self, span_ns: int) -> None:
        """Go on, or back."""
        self.go_to(self._now_ns + span_ns)

    def step(self, events: int) -> None:
        """Go on by so many events, or back."""
        self._place(max(0, min(len(self._events), self._at + events)))
        self._now_ns = self._times[self._at - 1] if self._at else 0

    def to_error(self, way: int) -> bool:
        """Go behind the next event that tells of something bad, or of the one before; say whether there was one."""
        found = [at for at in self._errors if (at >= self._at if way > 0 else at + 1 < self._at)]
        if found:
            self.step((found[0] if way > 0 else found[-1]) + 1 - self._at)
        return bool(found)

    def play(self, elapsed_s: float) -> None:
        """Let time go on, if it does; at the end it stops."""
        if self.playing:
            self.go_by(round(elapsed_s * NS_PER_S))
            self.playing = self._now_ns < self.length_ns

    def _place(self, at: int) -> None:
        if at < self._at:
            self.model, self._at = BenchModel(self._header), 0
        self.model.take(self._events[self._at : at])
        self._at = at


def _sort(event: Event) -> str:
    """Return the mark of an event on the line of time; empty for most of them."""
    try:
        found = line_of(event)
        if (found is not None and found[1]) or event.get("verdict") in {"fail", "error"}:
            return "!"
        if event["kind"] == "action":
            return "m" if event["do"] == "mark" else ""
    except (KeyError, ValueError, TypeError, AttributeError):
        return ""
    return "c" if event["kind"] == "verdict" else ""
