"""A state machine as it was reported: where it is, how often it took which edge, its timers and its counters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from hilbench.tui.model.rates import Counted

__all__ = ["MachineModel", "TimerModel", "is_change"]

Event = Mapping[str, Any]

_REPORTED_NS = 200_000_000
"""Twice as long as it takes a bench to tell of its timers again (hilbench.bench.state_reporter.REPORT_EVERY_NS)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TimerModel:
    """A timer.

    Attributes:
        deadline_ns: when it runs out, as reported last; None while it does not run.
        span_ns: how long it was set for.
        margin_ns: what was left when it was set anew the last time; None before.
        worst_ns: the least that was ever left; None before.
        rest: whether nothing is wrong when it runs out.
    """

    deadline_ns: int | None
    span_ns: int
    margin_ns: int | None
    worst_ns: int | None
    rest: bool = False

    @property
    def is_fast(self) -> bool:
        """Whether it comes and goes faster than it is reported: then its latest margin says more than what is left."""
        return 0 < self.span_ns < _REPORTED_NS and self.margin_ns is not None

    def left_ns(self, now_ns: int) -> int | None:
        """Return what is left of it, or was left when it was met last if it is a fast one; None while it is stopped."""
        overdue = self.deadline_ns is not None and now_ns - self.deadline_ns > _REPORTED_NS
        if self.is_fast and not overdue:
            return self.margin_ns
        return None if self.deadline_ns is None else max(0, self.deadline_ns - now_ns)


@dataclass(slots=True)
class MachineModel:
    """A state machine.

    Attributes:
        name: whose it is.
        table: as the header of the journal has it; empty if it does not.
        state: where it is; empty before that was reported.
        since_ns: bench time at which it came there.
        came_from: the state before; empty before a change was seen.
        trigger: why it came there.
        visits: how often each edge was taken, by state and trigger.
        timers: by name.
        misses: deadlines missed in a row: how many now, how many may be, how many at most so far.
        counters: by name.
    """

    name: str
    table: Event = field(default_factory=dict)
    state: str = ""
    since_ns: int = 0
    came_from: str = ""
    trigger: str = ""
    visits: dict[tuple[str, str], int] = field(default_factory=dict)
    timers: dict[str, TimerModel] = field(default_factory=dict)
    misses: dict[str, tuple[int, int, int]] = field(default_factory=dict)
    counters: dict[str, Counted] = field(default_factory=dict)

    def take(self, event: Event) -> None:
        """Take what a bench reports of it."""
        ns = event["ns"]
        if "state" in event and event["state"] != self.state:
            self.state, self.since_ns = event["state"], event.get("since_ns", ns)
            self.came_from, self.trigger = "", ""
        for state, trigger, count in event.get("visits", ()):
            self.visits[state, trigger] = count
        for name, about in event.get("timers", {}).items():
            self.timers[name] = TimerModel(**about)
        for name, (now, most, worst) in event.get("misses", {}).items():
            self.misses[name] = now, most, worst
        for name, value in event.get("counters", {}).items():
            self.counters.setdefault(name, Counted()).take(value, ns)

    def change(self, event: Event) -> None:
        """Take a change of state that it reported itself, at its exact time."""
        change = event["value"]
        self.came_from, self.state, self.trigger = change["old"], change["new"], change["trigger"]
        self.since_ns = event["ns"]

    def is_meant(self, event: Event) -> bool:
        """Say whether a change of state is this machine's; an end of several lines has several machines."""
        states = self.table.get("states")
        return event["source"] == self.source and (not states or event["value"]["new"] in states)

    @property
    def source(self) -> str:
        """Who reports its changes."""
        return str(self.table.get("source", self.name))

    @property
    def title(self) -> str:
        """Whose it is, and how that is known where nobody looks inside."""
        seen = self.table.get("seen", "")
        return f"{self.name}, {seen}" if seen else self.name

    @property
    def states(self) -> list[str]:
        """The states in the order of its table; without one, the present state alone."""
        return list(self.table.get("states", {})) or ([self.state] if self.state else [])

    def entries(self, state: str) -> int:
        """Return how often a state was come to, from itself too."""
        return sum(
            self.visits.get((before, trigger), 0)
            for before, trigger, after in self.table.get("edges", ())
            if after == state
        )


def is_change(value: Event) -> bool:
    """Say whether the fields of an event say that a machine is in another state."""
    return value.keys() >= {"old", "new", "trigger"}
