"""Writes down what happens on a bench of emulated boards: what parts tell, edges of pins, and how the vehicle moves.

Times of the vehicle are those of its world, which is a step ahead of the bench where parts drive it
(`hilbench.bench.world_runner`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import partial
from typing import Any, Generic, NamedTuple, TypeVar

from hilbench.clock import NS_PER_S
from hilbench.mcu.board_case import BoardBench
from hilbench.suites._truth import Sample, sample
from worlds.vehicles.pioneer_2dx import LEFT, RIGHT

__all__ = ["PinEdge", "Reported", "Watch", "WheelAngles"]

EventT = TypeVar("EventT")


class PinEdge(NamedTuple):
    """A change of a pin's level; None is a pin that floats."""

    at_ns: int
    pin: str
    level: bool | None


class Reported(NamedTuple, Generic[EventT]):
    """What a part reported, and when."""

    at_ns: int
    part: str
    event: EventT


class WheelAngles(NamedTuple):
    """How far the wheels have turned, rad, unwrapped."""

    at_ns: int
    left_rad: float
    right_rad: float


class Watch:
    """See the module. It begins when it is made, and ends with the bench.

    Args:
        bench: what is watched.
        pins: whose edges are written down.

    Attributes:
        edges: of these pins, in order.
        samples: the vehicle after each step of the physics.
        angles: its wheels, as above.
        sent: what parts have put on their lines: time and bytes.
    """

    def __init__(self, bench: BoardBench, pins: Iterable[str] = ()) -> None:
        self.edges: list[PinEdge] = []
        self.samples: list[Sample] = []
        self.angles: list[WheelAngles] = []
        self.sent: list[tuple[int, bytes]] = []
        self._bench = bench
        self._reported: list[Reported[Any]] = []
        bench.emulated.surroundings.parts.taps.append(self._take)
        for pin in pins:
            bench.board.pin(pin).on_edge(partial(self._edge, pin))
        bench.runner.after.append(self._step)
        journal = bench.bench.journal
        self._before = journal.on_event
        journal.on_event = self._record

    def reported(self, kind: type[EventT], part: str = "", since_ns: int = 0) -> list[Reported[EventT]]:
        """Return what parts reported of one kind; of one part, if it is named."""
        return [
            one
            for one in self._reported
            if isinstance(one.event, kind) and part in {"", one.part} and one.at_ns >= since_ns
        ]

    def edges_of(self, pins: Iterable[str], since_ns: int = 0) -> list[PinEdge]:
        """Return the edges of some of the pins."""
        wanted = {*pins}
        return [edge for edge in self.edges if edge.pin in wanted and edge.at_ns >= since_ns]

    def span(self, from_s: float, to_s: float) -> list[Sample]:
        """Return the samples of a span of bench time."""
        return [one for one in self.samples if from_s * NS_PER_S <= one.at_ns <= to_s * NS_PER_S]

    def since(self, since_ns: int) -> list[Sample]:
        """Return the samples from a bench time on."""
        return [one for one in self.samples if one.at_ns >= since_ns]

    def next_step(self) -> None:
        """Let time pass until just after the next step of the physics."""
        seen = len(self.samples)
        self._bench.board.run_until(lambda: len(self.samples) > seen, 1.0)

    def angles_at(self, at_ns: int) -> WheelAngles:
        """Return the wheels at a time, taken to turn evenly between two steps."""
        after = next(place for place, angles in enumerate(self.angles) if angles.at_ns >= at_ns)
        if after == 0:
            return self.angles[0]
        one, other = self.angles[after - 1], self.angles[after]
        share = (at_ns - one.at_ns) / (other.at_ns - one.at_ns)
        return WheelAngles(
            at_ns,
            one.left_rad + (other.left_rad - one.left_rad) * share,
            one.right_rad + (other.right_rad - one.right_rad) * share,
        )

    def _take(self, part: str, event: object) -> None:
        self._reported.append(Reported(self._bench.bench.now_ns, part, event))

    def _edge(self, pin: str, _cycle: int, ns: int, level: bool | None) -> None:
        self.edges.append(PinEdge(ns, pin, level))

    def _step(self, now_ns: int, next_ns: int) -> None:
        world, at_ns = self._bench.world, next_ns if self._bench.runner.ahead else now_ns
        self.samples.append(sample(world, at_ns, self.samples[-1].heading_deg if self.samples else 0.0))
        self.angles.append(WheelAngles(at_ns, world.joint(LEFT).angle_rad, world.joint(RIGHT).angle_rad))

    def _record(self, event: Mapping[str, Any]) -> None:
        if self._before is not None:
            self._before(event)
        if event["kind"] == "tx" and event["source"] in self._bench.parts:
            self.sent.append((event["ns"], bytes.fromhex(event["data"])))
