"""Two recordings event by event, case by case: the n-th of a source and kind in one belongs to the n-th in the other.

What belongs to the host and not to the bench is left out, as it is of a run's hash: kinds and fields that begin with
``host``, and prose. So are the marks of cases, whose hashes say nothing more.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from typing import Any

from hilbench.clock import NS_PER_S
from hilbench.diff.compare import span
from hilbench.journal import Recording
from hilbench.journal.run_hash import PROSE_FIELDS, is_hashed
from hilbench.recordings.remarks import remarks_on

__all__ = ["CaseDiff", "Divergence", "EventDiff", "EventOptions", "as_data", "as_text", "compare_events"]

Event = Mapping[str, Any]
FORMAT = 1
BEFORE = 3
_SHOWN_CASES = 20


@dataclass(frozen=True, slots=True, kw_only=True)
class EventOptions:
    """What is compared.

    Attributes:
        only: patterns of ``SOURCE KIND``, such as ``checker rx`` or ``* verdict``; empty for everything.
        case: this case alone; empty for all.
        order_only: the order in each stream, not the times.
        tolerance_ns: how far times may be apart.
    """

    only: tuple[str, ...] = ()
    case: str = ""
    order_only: bool = False
    tolerance_ns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Divergence:
    """The first event that is not the same in both.

    Attributes:
        stream: source and kind.
        number: which one of this stream, from 1.
        ns: when, from the beginning of the case, in the one that has it earlier.
        a: the event in A; None if A has no more.
        b: the same in B.
        what: what is different, in words.
        before: what happened in A just before, up to three events.
    """

    stream: str
    number: int
    ns: int
    a: Event | None
    b: Event | None
    what: str
    before: tuple[Event, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class CaseDiff:
    """One case in both.

    Attributes:
        case: its id; empty in a recording without cases.
        a: how many events A has; None if it has no such case.
        b: as above.
        first: the first that is not the same; None if all are.
        verdicts: what was said of it in A and in B; empty without.
    """

    case: str
    a: int | None
    b: int | None
    first: Divergence | None = None
    verdicts: tuple[str, str] = ("", "")

    @property
    def equal(self) -> bool:
        """Whether both have it, and the same events in it."""
        return self.first is None and None not in {self.a, self.b}


@dataclass(frozen=True, slots=True, kw_only=True)
class EventDiff:
    """The comparison.

    Attributes:
        cases: each case of A, then those of B alone.
        options: what was compared.
        remarks: what a person must know: where a recording was cut, or that its beginning is elsewhere.
    """

    cases: tuple[CaseDiff, ...]
    options: EventOptions
    remarks: tuple[str, ...]

    @property
    def equal(self) -> bool:
        """Whether all cases are."""
        return all(case.equal for case in self.cases)


def compare_events(a: Recording, b: Recording, options: EventOptions) -> EventDiff:
    """Compare two recordings."""
    in_a, in_b = _by_case(a, options), _by_case(b, options)
    names = list(dict.fromkeys([*in_a, *in_b]))
    cases = tuple(_case(name, in_a.get(name), in_b.get(name), options) for name in names)
    remarks = tuple(
        f"{side}: {remark}"
        for side, recording in (("A", a), ("B", b))
        for remark in remarks_on(recording.header, recording.problem, "compared")
    )
    return EventDiff(cases=cases, options=options, remarks=remarks)


def _by_case(recording: Recording, options: EventOptions) -> dict[str, list[Event]]:
    """Return the events of each case, with their times from its beginning."""
    cases: dict[str, list[Event]] = {}
    name, begin_ns = "", 0
    for event in recording.events:
        kind = str(event["kind"])
        if kind == "case":
            name, begin_ns = str(event.get("case", "")), int(event["ns"])
            if options.case in {"", name}:
                cases[name] = []
        elif kind == "case-end":
            name = ""
        elif is_hashed(kind) and options.case in {"", name} and _wanted(event, options.only):
            cases.setdefault(name, []).append({**event, "ns": int(event.get("ns", 0)) - (begin_ns if name else 0)})
    return cases


def _wanted(event: Event, only: Sequence[str]) -> bool:
    return not only or any(fnmatchcase(_stream(event), pattern) for pattern in only)


def _stream(event: Event) -> str:
    return f"{event.get('source', '')} {event['kind']}"


def _case(name: str, a: list[Event] | None, b: list[Event] | None, options: EventOptions) -> CaseDiff:
    if a is None or b is None:
        return CaseDiff(case=name, a=None if a is None else len(a), b=None if b is None else len(b))
    first = min(_divergences(a, b, options), key=lambda one: one.ns, default=None)
    return CaseDiff(case=name, a=len(a), b=len(b), first=first, verdicts=(_verdict(a), _verdict(b)))


def _divergences(a: list[Event], b: list[Event], options: EventOptions) -> Iterator[Divergence]:
    """Yield the first divergence of each stream."""
    streams_a, streams_b = _streams(a), _streams(b)
    for stream in {**streams_a, **streams_b}:
        mine, other = streams_a.get(stream, []), streams_b.get(stream, [])
        for number in range(max(len(mine), len(other))):
            one = mine[number] if number < len(mine) else None
            two = other[number] if number < len(other) else None
            what = _difference(one, two, options)
            if what:
                ns = min(event["ns"] for event in (one, two) if event is not None)
                before = tuple(event for event in a if event["ns"] <= ns and event is not one)[-BEFORE:]
                yield Divergence(stream=stream, number=number + 1, ns=ns, a=one, b=two, what=what, before=before)
                break


def _streams(events: list[Event]) -> dict[str, list[Event]]:
    streams: dict[str, list[Event]] = {}
    for event in events:
        streams.setdefault(_stream(event), []).append(event)
    return streams


def _difference(a: Event | None, b: Event | None, options: EventOptions) -> str:
    """Say what is different; nothing if all is the same."""
    if a is None or b is None:
        return f"{'A' if a is None else 'B'} has no more of these"
    fields = [name for name in {**a, **b} if name != "ns" and _counts(name) and a.get(name) != b.get(name)]
    if fields:
        return f"another {', '.join(sorted(fields))}"
    late_ns = b["ns"] - a["ns"]
    if not options.order_only and abs(late_ns) > options.tolerance_ns:
        return f"B is {span(abs(late_ns))} {'later' if late_ns > 0 else 'earlier'}"
    return ""


def _counts(name: str) -> bool:
    return name not in PROSE_FIELDS and not name.startswith("host")


def _verdict(events: list[Event]) -> str:
    return next((str(event.get("verdict", "")) for event in reversed(events) if event["kind"] == "verdict"), "")


# --- telling


def as_text(found: EventDiff, a: str, b: str) -> str:
    """Return it as lines; `a` and `b` are what the recordings are called."""
    return "\n".join(_lines(found, a, b))


def _lines(found: EventDiff, a: str, b: str) -> Iterator[str]:
    yield f"A  {a}"
    yield f"B  {b}"
    yield from found.remarks
    different = [case for case in found.cases if not case.equal]
    for case in different[:_SHOWN_CASES]:
        yield ""
        yield from _case_lines(case)
    if len(different) > _SHOWN_CASES:
        yield f"and {len(different) - _SHOWN_CASES} more cases that differ"
    yield ""
    count = sum(case.a or 0 for case in found.cases)
    if not different:
        yield f"equal: {count} events" + (f" in {len(found.cases)} cases" if _has_cases(found) else "")
    elif _has_cases(found):
        yield f"different: {len(different)} of {len(found.cases)} cases"
    else:
        yield "different"


def _has_cases(found: EventDiff) -> bool:
    return any(case.case for case in found.cases)


def _case_lines(case: CaseDiff) -> Iterator[str]:
    name = case.case or "the recording"
    if case.a is None or case.b is None:
        yield f"{name}: only in {'B' if case.a is None else 'A'}"
        return
    verdicts = "" if case.verdicts[0] == case.verdicts[1] else f", {case.verdicts[0]} in A and {case.verdicts[1]} in B"
    yield f"{name}: {case.a} events in A, {case.b} in B{verdicts}"
    first = case.first
    assert first is not None
    yield f"  first different: {first.stream}, number {first.number}: {first.what}"
    for event in first.before:
        yield f"    {_shown(event)}"
    yield f"  A {_shown(first.a)}"
    yield f"  B {_shown(first.b)}"


def _shown(event: Event | None) -> str:
    if event is None:
        return "-"
    rest = " ".join(f"{name}={value}" for name, value in event.items() if name not in {"ns", "kind", "source"})
    return f"{event['ns'] / NS_PER_S:.9f} s  {_stream(event)}  {rest}".rstrip()


def as_data(found: EventDiff, a: str, b: str) -> dict[str, object]:
    """Return it as plain data."""
    return {
        "format": FORMAT,
        "a": a,
        "b": b,
        "equal": found.equal,
        "remarks": list(found.remarks),
        "cases": [_case_data(case) for case in found.cases],
    }


def _case_data(case: CaseDiff) -> dict[str, object]:
    first = case.first
    return {
        "case": case.case,
        "a": case.a,
        "b": case.b,
        "equal": case.equal,
        "verdicts": list(case.verdicts),
        "first": None
        if first is None
        else {
            "stream": first.stream,
            "number": first.number,
            "ns": first.ns,
            "what": first.what,
            "a": first.a,
            "b": first.b,
        },
    }
