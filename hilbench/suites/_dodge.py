"""Writes down how a program finds its way: contacts, way, clearance, and its states, as wires or commands show them."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from hilbench.check import Inconclusive, Violation, at_most, record_measure
from hilbench.clock import NS_PER_MS, NS_PER_S
from hilbench.mcu.board_case import BoardBench
from hilbench.suites._bluepill import DISTANCES, LEFT_MOTOR, RIGHT_MOTOR, signed
from hilbench.suites._clearance import Clearance
from protocols.p2os import CommandNumber

__all__ = ["BACK", "FORWARD", "STAND", "TURN", "Drive", "Hit", "Sessions", "Spell", "longest_overlap_s"]

FORWARD, TURN, BACK, STAND = "forward", "turn", "back", "stand"

LEAST_WAY_M = 5.0
LONGEST_MANOEUVRE_S = 60.0
LONGEST_BLIND_S = 0.05
AHEAD = (3, 4, 5, 6)
"""The distance sensors that look ahead: 30 degrees to either side."""

FLOOR = "floor"
NEAR_M = 0.4
LONGEST_NEAR_S = 0.5
IN_THE_WAY_M = 1.0
"""A program that keeps away turns farther off than `NEAR_M`; what stays farther than this was never in its way."""

_SETTLED_NS = NS_PER_MS
"""Wires that belong together change one after the other: what does not last so long is no code."""

_COMMANDS_NS = 50 * NS_PER_MS
"""As above, of two commands on a line of 9600 bit/s, with the packets of the robot's own watchdog between them."""

_LOOKS_HZ = 10
_KEPT_HITS = 5


class Hit(NamedTuple):
    """A contact with something else than the floor."""

    at_s: float
    part: str
    other: str


class Spell(NamedTuple):
    """A time in which the motion that is asked for is one and the same."""

    start_ns: int
    end_ns: int
    asked: tuple[int, int]
    motion: str

    @property
    def length_s(self) -> float:
        """How long it lasts."""
        return (self.end_ns - self.start_ns) / NS_PER_S


class Drive:
    """See the module. It begins when it is made, and ends with the bench.

    Args:
        bench: what is watched.
        commands: whether the program asks by commands to the robot, and not by motor codes.

    Attributes:
        hits: the first contacts with anything but the floor.
        contacts: steps of the physics at which there was one.
        way_m: how far the vehicle has driven.
        clearance: how near it came to anything.
        least_ahead_m: how near anything was before the discs that look ahead.
        resets: of the board.
    """

    def __init__(self, bench: BoardBench, *, commands: bool = False) -> None:
        self.hits: list[Hit] = []
        self.contacts = 0
        self.way_m = 0.0
        self.clearance = Clearance(bench.world.vehicle, bench.world.scene)
        self._bench = bench
        self._begin_ns = bench.bench.now_ns
        self._near: list[tuple[int, bool]] = []
        self.least_ahead_m = math.inf
        self.resets = 0
        self._asked = _Commands(self._begin_ns) if commands else _Wires(bench, self._begin_ns)
        self._high = {number: _Level(bench, DISTANCES[number - 1]) for number in AHEAD}
        self._look_every = max(1, bench.world.step_hz // _LOOKS_HZ)
        self._position = bench.world.pose().position_m
        bench.runner.after.append(self._step)
        journal = bench.bench.journal
        self._heard_before = journal.on_event
        journal.on_event = self._take

    # --- what happened

    def spells(self) -> list[Spell]:
        """Return what was asked for, one after the other, up to now."""
        return self._asked.spells(self._bench.bench.now_ns)

    def high(self, sensor: int) -> list[tuple[int, int]]:
        """Return when a distance wire was high: begin and end, in ns."""
        return _spans(self._high[sensor].edges, self._bench.bench.now_ns)

    def near(self) -> list[tuple[int, int]]:
        """Return when something was near before the discs that look ahead."""
        return _spans(self._near, self._bench.bench.now_ns)

    def sees(self) -> bool:
        """Return whether a distance wire that looks ahead was high."""
        return any(self.high(sensor) for sensor in AHEAD)

    # --- what is required

    def require_no_contact(self) -> None:
        """Require G13, and put the figures of the drive down."""
        spells = self.spells()
        record_measure("way driven", self.way_m, "m", low=LEAST_WAY_M)
        record_measure("least clearance", min(self.clearance.least_m, 99.0), "m")
        record_measure("changes of state", len(spells) - 1, "")
        for motion in (FORWARD, TURN, BACK):
            record_measure(f"spells of {motion}", sum(spell.motion == motion for spell in spells), "")
        self.require_untouched("G13")

    def require_untouched(self, clause: str) -> None:
        """Require for a clause that nothing but the floor was touched."""
        if self.hits:
            raise Violation(f"{_text(self.hits[0])} is touched", list(map(_text, self.hits)), clause=clause)

    def require_way(self) -> None:
        """Require D01; the figure is with those of G13."""
        if self.way_m < LEAST_WAY_M:
            raise Violation(f"{self.way_m:.2f} m driven, at least {LEAST_WAY_M:g} m required", clause="D01")

    def require_ends(self, longest_s: float = LONGEST_MANOEUVRE_S) -> None:
        """Require D02: a turn was made and left, and no manoeuvre took too long."""
        spells = self.spells()
        long = max((one for one in spells if one.motion in {TURN, BACK}), key=lambda one: one.length_s, default=None)
        if long is None:
            raise Violation("no turn in all this time", [*map(_spell, spells)], clause="D02")
        at_most(long.length_s, longest_s, unit="s", what=f"longest {long.motion}, codes {long.asked}", clause="D02")
        if not any(one.motion == TURN for one in spells[:-1]):
            raise Violation("no turn is ever left", [*map(_spell, spells)], clause="D02")

    def require_sight(self) -> None:
        """Require D03, sensor by sensor."""
        if not self.sees():
            raise Inconclusive("none of DD3 to DD6 goes high in all this time", clause="D03")
        spells = self.spells()
        for sensor in AHEAD:
            blind_s = longest_overlap_s(self.high(sensor), spells)
            what = f"longest time that DD{sensor} is high and both codes forward"
            at_most(blind_s, LONGEST_BLIND_S, unit="s", what=what, clause="D03")

    def require_sight_over_p2os(self) -> None:
        """Require D06."""
        if self.least_ahead_m > IN_THE_WAY_M:
            raise Inconclusive(f"nothing is nearer than {IN_THE_WAY_M} m ahead in all this time", clause="D06")
        blind_s = longest_overlap_s(self.near(), self.spells())
        what = f"longest time that something is nearer than {NEAR_M} m ahead and the robot told to drive on"
        at_most(blind_s, LONGEST_NEAR_S, unit="s", what=what, clause="D06")

    def require_alive(self) -> None:
        """Require D04."""
        end = self._bench.emulated.end
        if end is not None:
            raise Violation(f"the program does not run on: {end}", clause="D04")
        if self.resets:
            raise Violation(f"the board is reset {self.resets} times", clause="D04")

    # --- watching

    def _step(self, now_ns: int, _next_ns: int) -> None:
        world = self._bench.world
        pose = world.pose()
        before, self._position = self._position, pose.position_m
        self.way_m += math.hypot(self._position[0] - before[0], self._position[1] - before[1])
        touched = [contact for contact in world.contacts() if contact.other != FLOOR]
        self.contacts += bool(touched)
        for contact in touched[: _KEPT_HITS - len(self.hits)]:
            self.hits.append(Hit((now_ns - self._begin_ns) / NS_PER_S, contact.part, contact.other))
        if world.step_index % self._look_every == 0:
            self.clearance.look(pose)
            ahead_m = min(self._bench.body.ray_ranges_m([sensor - 1 for sensor in AHEAD]))
            self._near.append((now_ns, ahead_m < NEAR_M))
            self.least_ahead_m = min(self.least_ahead_m, ahead_m)

    def _take(self, event: Mapping[str, Any]) -> None:
        if self._heard_before is not None:
            self._heard_before(event)
        if event["kind"] == "reset" and event["ns"] > self._begin_ns:
            self.resets += 1
        if isinstance(self._asked, _Commands):
            self._asked.take(event)


class Sessions:
    """Counts the sessions that the robot opens, from now on.

    Args:
        bench: what is watched.

    Attributes:
        opened: so far.
    """

    def __init__(self, bench: BoardBench) -> None:
        self.opened = 0
        journal = bench.bench.journal
        self._heard_before = journal.on_event
        journal.on_event = self._take

    def _take(self, event: Mapping[str, Any]) -> None:
        if self._heard_before is not None:
            self._heard_before(event)
        self.opened += event.get("name") == "SessionOpened"


class _Wires:
    """The codes on the motor wires; a wire that floats reads low."""

    def __init__(self, bench: BoardBench, begin_ns: int) -> None:
        self._levels = {pin: bench.board.pin(pin).level is True for pin in (*LEFT_MOTOR, *RIGHT_MOTOR)}
        self._asked = [(begin_ns, self._codes())]
        for pin in self._levels:
            bench.board.pin(pin).on_edge(partial(self._edge, pin))

    def spells(self, now_ns: int) -> list[Spell]:
        return _spells(self._asked, now_ns, _SETTLED_NS, _motion_of_codes)

    def _edge(self, pin: str, _cycle: int, ns: int, level: bool | None) -> None:
        self._levels[pin] = level is True
        self._asked.append((ns, self._codes()))

    def _codes(self) -> tuple[int, int]:
        left, right = (
            sum(self._levels[pin] << bit for bit, pin in enumerate(pins)) for pins in (LEFT_MOTOR, RIGHT_MOTOR)
        )
        return signed(left), signed(right)


class _Commands:
    """The speed and the rate of turn that the robot has been commanded, in mm/s and deg/s."""

    def __init__(self, begin_ns: int) -> None:
        self._speed = self._turn = 0
        self._asked = [(begin_ns, (0, 0))]

    def spells(self, now_ns: int) -> list[Spell]:
        return _spells(self._asked, now_ns, _COMMANDS_NS, _motion_of_speeds)

    def take(self, event: Mapping[str, Any]) -> None:
        if event.get("name") != "CommandObeyed":
            return
        command = event["value"]["command"]
        if command["number"] == CommandNumber.VEL:
            self._speed = command["argument"]
        elif command["number"] == CommandNumber.RVEL:
            self._turn = command["argument"]
        self._asked.append((event["ns"], (self._speed, self._turn)))


class _Level:
    """When a wire was high."""

    def __init__(self, bench: BoardBench, pin: str) -> None:
        self.edges = [(bench.bench.now_ns, bench.board.pin(pin).level is True)]
        bench.board.pin(pin).on_edge(lambda _cycle, ns, level: self.edges.append((ns, level is True)))


def longest_overlap_s(spans: Sequence[tuple[int, int]], spells: Sequence[Spell]) -> float:
    """Return the longest time within one of the spans in which forward is asked for, in seconds."""
    forward = [spell for spell in spells if spell.motion == FORWARD]
    overlaps = (min(end, spell.end_ns) - max(start, spell.start_ns) for start, end in spans for spell in forward)
    return max(0, max(overlaps, default=0)) / NS_PER_S


def _spans(edges: Sequence[tuple[int, bool]], now_ns: int) -> list[tuple[int, int]]:
    spans, since_ns = [], None
    for ns, high in [*edges, (now_ns, False)]:
        if high and since_ns is None:
            since_ns = ns
        elif not high and since_ns is not None:
            spans.append((since_ns, ns))
            since_ns = None
    return spans


def _spells(
    asked: Sequence[tuple[int, tuple[int, int]]],
    now_ns: int,
    settled_ns: int,
    motion: Callable[[tuple[int, int]], str],
) -> list[Spell]:
    """Return the spells of what lasted; one that is the same as the one before it goes on."""
    spells: list[Spell] = []
    for start_ns, end_ns, codes in _lasting(asked, now_ns):
        if spells and spells[-1].asked == codes:
            spells[-1] = spells[-1]._replace(end_ns=end_ns)
        elif end_ns - start_ns >= settled_ns:
            spells.append(Spell(start_ns, end_ns, codes, motion(codes)))
    return spells


def _lasting(asked: Sequence[tuple[int, tuple[int, int]]], now_ns: int) -> Iterator[tuple[int, int, tuple[int, int]]]:
    changes = [one for at, one in enumerate(asked) if at == 0 or one[1] != asked[at - 1][1]]
    ends = [ns for ns, _ in changes[1:]]
    for (start_ns, codes), end_ns in zip(changes, [*ends, max(now_ns, changes[-1][0])], strict=True):
        yield start_ns, end_ns, codes


def _motion_of_codes(codes: tuple[int, int]) -> str:
    left, right = codes
    if left > 0 and right > 0:
        return FORWARD
    if left < 0 and right < 0:
        return BACK
    return TURN if left != right else STAND


def _motion_of_speeds(asked: tuple[int, int]) -> str:
    speed, turn = asked
    if speed:
        return FORWARD if speed > 0 else BACK
    return TURN if turn else STAND


def _text(hit: Hit) -> str:
    return f"{hit.other}, by {hit.part}, after {hit.at_s:.3f} s"


def _spell(spell: Spell) -> str:
    return f"{spell.start_ns / NS_PER_S:10.3f} s  {spell.motion} {spell.asked} for {spell.length_s:.3f} s"
