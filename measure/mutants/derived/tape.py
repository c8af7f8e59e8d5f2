"""What a right peer and the checker say to each other in each case, and the mutants that follow from it."""

from __future__ import annotations

import contextlib
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any
from unittest.mock import patch

from hilbench.clock import Scheduler
from hilbench.judging.provider import CaseInfo
from hilbench.judging.verdicts import Verdict
from hilbench.links import Port
from hilbench.terminal.options import CheckOptions
from measure.mutants.derived.fields import Place, Reading
from measure.mutants.derived.mutant import EVERY, Acting, Fault, Group, Mutant, changed, faults_of
from measure.mutants.derived.relay import Relay
from measure.mutants.derived.subjects import Subject, opened
from measure.mutants.wire import Way
from protocols.common.items import Item, Kind
from protocols.state_machine import StateMachine

__all__ = ["CaseTape", "Tape", "derive", "recorded", "touched"]

_LOOKED_AT = 4
"""Frames of one message and length whose fields are looked for; what one of them does not show, others may."""


@dataclass(slots=True)
class CaseTape:
    """What happened in a case.

    Attributes:
        said: what the peer said, in order, each with its time.
        heard: what the checker said, by the piece.
        timers: what was started, as machine and timer.
        edges: what was taken, as machine and edge; whether it leads elsewhere, and whether it does something.
    """

    said: list[tuple[int, Sequence[Item]]] = field(default_factory=list)
    heard: list[tuple[int, Sequence[Item]]] = field(default_factory=list)
    timers: set[tuple[str, str]] = field(default_factory=set)
    edges: dict[tuple[str, str], tuple[bool, bool]] = field(default_factory=dict)

    def of(self, way: Way) -> list[tuple[int, Sequence[Item]]]:
        """What went in a direction."""
        return self.said if way is Way.OUT else self.heard


@dataclass(slots=True)
class Tape:
    """What happened in a run against the right peer.

    Attributes:
        cases: by their ids, in order.
        verdicts: of these cases.
    """

    cases: dict[str, CaseTape] = field(default_factory=dict)
    verdicts: dict[str, Verdict] = field(default_factory=dict)


def recorded(subject: Subject, *, at_port: bool, by_hand: bool = False, seed: int = 0) -> Tape:
    """Run the suites of a subject against it as it is meant to be; `by_hand`, those that need somebody beside it."""
    from hilbench.check.runner import run_suites

    tape = Tape()
    now = CaseTape()
    readings = {way: subject.reading(way) for way in Way}

    def relay(scheduler: Scheduler, port: Port) -> Port:
        if isinstance(port, Relay) or subject.line not in port.name:
            return port

        def tell_said(items: Sequence[Item]) -> None:
            now.said.append((scheduler.now_ns, items))

        def tell_heard(items: Sequence[Item]) -> None:
            now.heard.append((scheduler.now_ns, items))

        return Relay(scheduler, port, readings[Way.OUT], readings[Way.IN], tell_said=tell_said, tell_heard=tell_heard)

    with opened(subject, relay, at_port=at_port, by_hand=by_hand) as provider, _watching(lambda: now):
        open_case = provider.open_case

        @contextlib.contextmanager
        def noted(case: CaseInfo) -> Iterator[Any]:
            nonlocal now
            now = tape.cases[case.id] = CaseTape()
            with open_case(case) as bench:
                yield bench

        provider.open_case = noted  # type: ignore[method-assign]
        options = CheckOptions(
            bench=subject.bench,
            suites=subject.suites,
            select=subject.selects(subject.by_hand if by_hand else ""),
            seed=seed,
        )
        report = run_suites(options, provider)
    tape.verdicts = {case.id: case.verdict for case in report.cases}
    return tape


@contextlib.contextmanager
def _watching(now: Any) -> Iterator[None]:
    """Note which timers are started and which edges are taken."""
    start, fire = StateMachine.start, StateMachine.fire

    def noted_start(machine: Any, timer: Any, after_s: float | None, **more: Any) -> None:
        if after_s is not None:
            now().timers.add((machine_of(machine), timer.name))
        start(machine, timer, after_s, **more)

    def noted_fire(machine: Any, trigger: Any) -> None:
        edge = machine.table.get((machine.state, trigger))
        if edge is not None:
            what = edge.next_state is not machine.state, bool(edge.actions)
            now().edges[machine_of(machine), edge_of(machine.state, trigger)] = what
        fire(machine, trigger)

    with patch.object(StateMachine, "start", noted_start), patch.object(StateMachine, "fire", noted_fire):
        yield


def machine_of(machine: Any) -> str:
    """What a machine is called: as its states are."""
    return type(machine.state).__name__


def edge_of(state: Any, trigger: Any) -> str:
    """What an edge is called."""
    return f"{state.name}/{trigger.name}"


# --- the mutants


def derive(subject: Subject, tape: Tape) -> list[Mutant]:
    """Return every mutant that follows from what was said, sorted by id."""
    made: list[Mutant] = []
    for way in Way:
        messages = {name: _fields(sized, subject.reading(way)) for name, sized in _frames(tape, way).items()}
        if messages:
            made += _of_checksum(way, subject.reading(way))
            made += _of_envelope(way, messages)
        for message, fields in messages.items():
            made += [Mutant(fault=fault, way=way, message=message) for fault in faults_of(Group.MESSAGE, way)]
            made += [
                mutant
                for mutant in _of_fields(way, message, fields, _shared(messages))
                if way is Way.IN or not _is_right(mutant, subject.record.fixed.get(message))
            ]
    found = {mutant.id: mutant for mutant in (*made, *_of_machine(subject, tape))}
    return [found[id_] for id_ in sorted(found)]


def _frames(tape: Tape, way: Way) -> dict[str, dict[int, list[bytes]]]:
    """The different frames of each message, by their lengths."""
    found: dict[str, dict[int, dict[bytes, None]]] = defaultdict(lambda: defaultdict(dict))
    for case in tape.cases.values():
        for _, items in case.of(way):
            for item in items:
                if item.kind is Kind.FRAME:
                    found[item.name][len(item.raw)][item.raw] = None
    return {name: {length: [*raws] for length, raws in sized.items()} for name, sized in found.items()}


@dataclass(frozen=True, slots=True)
class _Field:
    """A field of a message: where it and the one behind it stand, by the frame's length, and whether it ever varied."""

    places: dict[int, tuple[Place, ...]] = field(default_factory=dict)
    pairs: dict[int, tuple[Place, ...]] = field(default_factory=dict)
    values: set[bytes] = field(default_factory=set)

    @property
    def place(self) -> Place:
        """In the frames of one of the lengths."""
        return next(iter(self.places.values()))[0]


def _fields(sized: dict[int, list[bytes]], reading: Reading) -> dict[str, _Field]:
    found: dict[str, _Field] = defaultdict(_Field)
    for length, frames in sized.items():
        places = reading.places(frames[:: max(1, len(frames) // _LOOKED_AT)][:_LOOKED_AT])
        for place, behind in zip(places, [*places[1:], None], strict=True):
            one = found[place.name]
            one.places[length] = (place,)
            one.values.update(place.of(raw) for raw in frames)
            if behind is not None and _are_alike(place, behind):
                one.pairs[length] = (place, behind)
    return found


def _are_alike(place: Place, behind: Place) -> bool:
    are_numbers = place.number is not None and behind.number is not None
    return are_numbers and (behind.start, behind.size) == (place.stop, place.size)


def _shared(messages: dict[str, dict[str, _Field]]) -> frozenset[str]:
    """What stands around every message and is no number: it is one matter, not one for each message."""
    names = [{name for name, one in fields.items() if one.place.number is None} for fields in messages.values()]
    return frozenset(set.intersection(*names)) if len(names) > 1 else frozenset()


def _of_checksum(way: Way, reading: Reading) -> Iterator[Mutant]:
    if reading.checksum is not None:
        for fault in faults_of(Group.CHECKSUM, way):
            yield Mutant(fault=fault, way=way, message=EVERY)


def _of_envelope(way: Way, messages: dict[str, dict[str, _Field]]) -> Iterator[Mutant]:
    for name in _shared(messages):
        places = {length: at for fields in messages.values() for length, at in fields[name].places.items()}
        yield Mutant(fault=Fault.PLUS, way=way, message=EVERY, name=name, places=places)


def _of_fields(way: Way, message: str, fields: dict[str, _Field], shared: frozenset[str]) -> Iterator[Mutant]:
    for name, one in fields.items():
        if name in shared:
            continue
        for fault in faults_of(Group.FIELD, way):
            places = one.pairs if fault is Fault.NEIGHBOUR else one.places
            if places and _makes_sense(fault, one):
                yield Mutant(fault=fault, way=way, message=message, name=name, places=places)


def _is_right(mutant: Mutant, raw: bytes | None) -> bool:
    """The specification gives the frame, and the fault leaves it as it is."""
    places = None if raw is None else mutant.places.get(len(raw))
    if raw is None or places is None:
        return False
    data = places[0].of(raw)
    return changed(mutant.fault, raw, places, data, data) == raw


def _makes_sense(fault: Fault, one: _Field) -> bool:
    number = one.place.number
    if fault is Fault.SIGN:
        return number is not None and (number.signed or number.real)
    if fault is Fault.ORDER:
        return number is not None and one.place.size > 1
    if fault is Fault.MINUS:
        return number is not None
    if fault in (Fault.STUCK, Fault.STALE):
        return number is not None or len(one.values) > 1
    return True


def _of_machine(subject: Subject, tape: Tape) -> Iterator[Mutant]:
    timers = {one for case in tape.cases.values() for one in case.timers if subject.has(one[0])}
    for machine, name in sorted(timers):
        for fault in faults_of(Group.TIMER, Way.OUT):
            yield Mutant(fault=fault, way=Way.OUT, message=machine, name=name)
    edges = {one: what for case in tape.cases.values() for one, what in case.edges.items() if subject.has(one[0])}
    for (machine, name), (leads, acts) in sorted(edges.items()):
        for fault in faults_of(Group.EDGE, Way.OUT):
            if (leads or fault is not Fault.STAYS) and (acts or fault is not Fault.IDLE):
                yield Mutant(fault=fault, way=Way.OUT, message=machine, name=name)


def touched(subject: Subject, mutant: Mutant, tape: Tape) -> list[str]:
    """Return the cases in which a mutant does something that the right peer does not, as far as the tape tells."""
    group = mutant.fault.group
    if group in (Group.TIMER, Group.EDGE):
        what = "timers" if group is Group.TIMER else "edges"
        return [id_ for id_, case in tape.cases.items() if (mutant.message, mutant.name) in getattr(case, what)]
    reading = subject.reading(mutant.way)
    return [id_ for id_, case in tape.cases.items() if _differs(Acting(mutant, reading), case.of(mutant.way))]


def _differs(acting: Acting, pieces: Sequence[tuple[int, Sequence[Item]]]) -> bool:
    for now_ns, items in pieces:
        said = b"".join(item.raw for item in items)
        made = acting.take(items, now_ns)
        if any(piece.late_s for piece in made) or b"".join(piece.data for piece in made) != said:
            return True
    return False
