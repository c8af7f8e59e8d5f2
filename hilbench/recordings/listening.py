"""A recording as somebody hears it who listens at the line: frames of both ends in order of time, case by case.

Where several ends of one line were recorded, one of them is listened to, that of the checker if it is there: its times
are those that the cases of a live run judge by.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from hilbench.clock import NS_PER_S
from hilbench.journal import Recording
from hilbench.plugins.discovery import PLUGINS
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.recordings.chunks import speaker_of
from hilbench.recordings.frames import FRAME_NS, framed
from hilbench.recordings.layout import Event, data_of
from protocols.common.items import Item, Kind

__all__ = ["ASSUMED_UNCERTAINTY_S", "HOST", "TARGET", "Heard", "Stretch", "Talk", "stretches", "talks"]

HOST, TARGET = "host", "target"

ASSUMED_UNCERTAINTY_S = 0.002
"""How far off times may be where the recording does not say (assumed: the least that a live run in real time takes)."""

_CHECKERS = {"checker": TARGET}
"""The ends that hilbench itself holds in a case, and who is under test then; a system names its own beside them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Heard:
    """A frame, or bytes that are none.

    Attributes:
        ns: when its last byte was there, in ns.
        by: who sent it: `HOST` or `TARGET`.
        item: what it is.
    """

    ns: int
    by: str
    item: Item

    @property
    def sound(self) -> bool:
        """Whether it is a sound frame, readable or not."""
        return self.item.kind is not Kind.DROPPED


@dataclass(frozen=True, kw_only=True)
class Stretch:
    """A case, or a recording without cases; it may be long, so that no question takes a walk through it.

    Attributes:
        case: the id of the case; empty without.
        heard: what passed the line, in order of time, without what the beginning and the end have left of a frame.
        begin_ns: from when on it was listened, in ns.
        end_ns: until when.
        from_start: whether nothing was said before, as in a case; else it may begin in the middle of a session.
        under_test: who may be judged; in a case of `check` only one of the two, for the other may err on purpose.
        uncertainty_s: how far off times may be.
        disturbed_ns: when something happened that is nobody's fault, in order: a fault of the line's, or it was cut.
    """

    case: str
    heard: tuple[Heard, ...]
    begin_ns: int
    end_ns: int
    from_start: bool
    under_test: frozenset[str]
    uncertainty_s: float
    disturbed_ns: tuple[int, ...] = ()

    def by(self, end: str) -> Sequence[Heard]:
        """Return what an end sent."""
        return self._by[end]

    def between(self, begin_ns: int, end_ns: int) -> Sequence[Heard]:
        """Return what passed the line from one time to another, both included."""
        return self.heard[bisect_left(self._heard_ns, begin_ns) : bisect_right(self._heard_ns, end_ns)]

    def around(self, ns: int, count: int) -> Sequence[Heard]:
        """Return so many that passed the line up to a time, and as many behind it."""
        behind = bisect_right(self._heard_ns, ns)
        return self.heard[max(0, behind - count) : behind + count]

    def quiet(self, begin_ns: int, end_ns: int) -> bool:
        """Say whether it was listened to all of this time, and nothing disturbed the line in it."""
        inside = self.begin_ns <= begin_ns and end_ns <= self.end_ns
        disturbed = bisect_left(self.disturbed_ns, begin_ns) < bisect_right(self.disturbed_ns, end_ns)
        return inside and not disturbed

    @cached_property
    def _by(self) -> Mapping[str, Sequence[Heard]]:
        return {end: tuple(one for one in self.heard if one.by == end) for end in (HOST, TARGET)}

    @cached_property
    def _heard_ns(self) -> Sequence[int]:
        return tuple(one.ns for one in self.heard)

    def at(self, ns: int) -> str:
        """Return where in the recording that is, for a person."""
        return f"{self.case or 'the recording'} at {ns / NS_PER_S:.4f} s"


@dataclass(frozen=True, slots=True, kw_only=True)
class Talk:
    """The bytes of one case, or of a recording without cases, as they passed the line.

    Attributes:
        case: the id of the case; empty without.
        begin_ns: from when on it was listened, in ns.
        end_ns: until when.
        said: time, who sent them, and the bytes, in order.
    """

    case: str
    begin_ns: int
    end_ns: int
    said: tuple[tuple[int, str, bytes], ...]

    def of(self, end: str) -> bytes:
        """Return all that an end sent."""
        return b"".join(data for _, by, data in self.said if by == end)


def talks(recording: Recording) -> list[Talk]:
    """Return the bytes of both ends, case by case; a case without any is left out."""
    return [made for part in _parts(recording.events) if (made := _talk(part)) is not None]


def _talk(part: _Part) -> Talk | None:
    ends = _ends(part)
    timed = [(int(event["ns"]), event) for event in part.events if type(event.get("ns")) is int]
    if not ends or not timed:
        return None
    said = []
    for ns, event in timed:
        data = data_of(event)
        by = ends.get((str(event.get("source", "")), _way(event)))
        if data is not None and by is not None:
            said.append((ns - _early_ns(event), by, data))
    # Bytes that were collected had begun to come before the event that tells of them.
    begin_ns = min([timed[0][0], *(ns for ns, _, _ in said)])
    return Talk(case=part.case, begin_ns=begin_ns, end_ns=_end_ns(timed), said=tuple(said))


@dataclass(slots=True)
class _Part:
    case: str
    events: list[Event] = field(default_factory=list)


def stretches(recording: Recording, protocol: ProtocolPlugin) -> list[Stretch]:
    """Return what was heard, case by case.

    Args:
        recording: what was recorded.
        protocol: what is spoken.
    """
    parts = list(_parts(recording.events))
    of_checks = any(part.case for part in parts)
    return [made for part in parts if (made := _stretch(part, protocol, of_checks=of_checks)) is not None]


def _parts(events: Sequence[Event]) -> Iterator[_Part]:
    part = _Part("")
    for event in events:
        if event["kind"] == "case":
            yield part
            part = _Part(str(event.get("case", "")))
        if event["kind"] != "host-end":
            part.events.append(event)
    yield part


def _stretch(part: _Part, protocol: ProtocolPlugin, *, of_checks: bool) -> Stretch | None:
    ends = _ends(part)
    if not ends:
        return None
    timed = [(int(event["ns"]), event) for event in part.events if type(event.get("ns")) is int]
    chosen = [(ns, event) for ns, event in timed if data_of(event) is None or (event["source"], _way(event)) in ends]
    begin_ns, from_start = timed[0][0], bool(part.case)
    items = (one for one in framed(chosen, protocol) if not one.cut)
    heard = [Heard(ns=one.ns, by=ends[one.source, one.kind], item=one.item) for one in items]
    heard.sort(key=lambda one: one.ns)
    if not from_start:
        heard = [*_without_tails(heard, _begun(chosen, ends, begin_ns), protocol.longest_frame)]
    sources = {source for source, _ in ends}
    checker = next((source for source in _checkers() if of_checks and source in sources), "")
    return Stretch(
        case=part.case,
        heard=tuple(heard),
        begin_ns=begin_ns,
        end_ns=_end_ns(timed),
        from_start=from_start,
        under_test=_under_test(frozenset(ends.values()), checker),
        uncertainty_s=_uncertainty_s(part),
        disturbed_ns=tuple(sorted(ns for ns, event in timed if _disturbs(event))),
    )


def _begun(chosen: list[tuple[int, Event]], ends: Mapping[tuple[str, str], str], begin_ns: int) -> set[str]:
    """Return who spoke as soon as the recording began, and so perhaps before."""
    first_ns: dict[str, int] = {}
    for ns, event in chosen:
        if data_of(event) is not None:
            first_ns.setdefault(ends[event["source"], _way(event)], ns)
    return {end for end, ns in first_ns.items() if ns - begin_ns <= FRAME_NS}


def _without_tails(heard: list[Heard], begun: set[str], longest_frame: int) -> Iterator[Heard]:
    """Leave out what may be the end of a frame: bytes before the first sound one of an end, no more than one has."""
    room = dict.fromkeys(begun, longest_frame)
    for one in heard:
        room[one.by] = -1 if one.sound else room.get(one.by, -1) - len(one.item.raw)
        if room[one.by] < 0:
            yield one


def _end_ns(timed: list[tuple[int, Event]]) -> int:
    """Return when the last thing happened: a part may say that it starts, at 0, before the next case begins."""
    return max(ns for ns, _ in timed)


def _checkers() -> Mapping[str, str]:
    return {**_CHECKERS, **PLUGINS.systems.checkers()}


def _under_test(recorded: frozenset[str], checker: str) -> frozenset[str]:
    """Return who may be judged; nobody if only one of them was recorded: what the other one said is not known."""
    if len(recorded) < 2:
        return frozenset()
    return frozenset({_checkers()[checker]}) if checker else recorded


def _early_ns(event: Event) -> int:
    begin_ns = event.get("from_ns")
    return int(event["ns"]) - begin_ns if type(begin_ns) is int else 0


def _way(event: Event) -> str:
    return "tx" if event["kind"] == "tx" else "rx"


def _disturbs(event: Event) -> bool:
    return event["kind"] in {"fault", "baud"} or (event["kind"] == "line" and not event.get("up", True))


def _uncertainty_s(part: _Part) -> float:
    said = [event.get("uncertainty_s") for event in part.events if event["kind"] == "host-lateness"]
    known = [float(value) for value in said if isinstance(value, int | float)]
    assumed = 0.0 if part.case else ASSUMED_UNCERTAINTY_S
    collected_ns = max(map(_early_ns, part.events), default=0)
    return max(known, default=assumed) + collected_ns / 2 / NS_PER_S


def _ends(part: _Part) -> dict[tuple[str, str], str]:
    """Return who sends in each stream that is listened to, by source and way."""
    weight: dict[tuple[str, str], int] = {}
    for event in part.events:
        data = data_of(event)
        if data is not None:
            key = (str(event["source"]), _way(event))
            weight[key] = weight.get(key, 0) + len(data)
    both = {source for source, _ in weight if {(source, "tx"), (source, "rx")} <= weight.keys()}
    if both:
        one = min(both, key=lambda source: (_rank(source), -weight[source, "tx"] - weight[source, "rx"]))
        sender = speaker_of(one) or HOST
        return {(one, "tx"): sender, (one, "rx"): TARGET if sender == HOST else HOST}
    senders: dict[str, str] = {}
    for source, way in sorted(weight, key=lambda key: (_rank(key[0]), -weight[key])):
        if way == "tx":
            senders.setdefault(speaker_of(source) or HOST, source)
    return {(source, "tx"): end for end, source in senders.items()}


_FIRST = ("checker", "server", "client")
"""Ends of a line that are listened to before others: those of hilbench in a case, and the two of its proxy."""


def _rank(source: str) -> int:
    return _FIRST.index(source) if source in _FIRST else len(_FIRST)
