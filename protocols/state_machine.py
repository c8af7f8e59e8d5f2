"""What every role of every protocol here is: a state, a table, timers, and the events that come out.

A table maps (state, trigger) to an edge, the next state and the actions. What the states, triggers, actions and timers
are is the business of a protocol, and so is what the actions do: it derives a class from `StateMachine`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from collections.abc import Collection, Mapping
from enum import Enum
from types import MappingProxyType
from typing import Any, ClassVar, Generic, Protocol, TypeVar, cast

from protocols.common.events import FrameDropped, StateChanged, Transmit

__all__ = ["AnyDropped", "Edge", "LineCounters", "StateMachine", "earliest"]

_NS_PER_S = 1_000_000_000

StateT = TypeVar("StateT", bound=Enum)
TriggerT = TypeVar("TriggerT", bound=Enum)
ActionT = TypeVar("ActionT")
TimerT = TypeVar("TimerT")
EventT = TypeVar("EventT")
CountersT = TypeVar("CountersT", bound="LineCounters")
_State_co = TypeVar("_State_co", covariant=True)
_Action_co = TypeVar("_Action_co", covariant=True)


def earliest(one_ns: int | None, other_ns: int | None) -> int | None:
    """The earlier of two times, of which each may be None for never; asked for with each byte."""
    if one_ns is None or (other_ns is not None and other_ns < one_ns):
        return other_ns
    return one_ns


class Edge(Protocol[_State_co, _Action_co]):
    """What an entry of a table says."""

    @property
    def next_state(self) -> _State_co:
        """The state that follows."""

    @property
    def actions(self) -> tuple[_Action_co, ...]:
        """What is done then, in this order."""


class LineCounters(Protocol):
    """What is counted in every protocol."""

    bytes_out: int
    frames_out: int
    ignored: int


class AnyDropped(Protocol):
    """Bytes that are no frame."""

    @property
    def reason(self) -> Enum:
        """Why they are none."""

    @property
    def data(self) -> bytes:
        """The bytes."""


class StateMachine(ABC, Generic[StateT, TriggerT, ActionT, TimerT, EventT, CountersT]):
    """One end of the line: takes the edges of its table, runs its timers, keeps its events.

    Args:
        table: the edges by state and trigger; a pair that is absent changes nothing.
        state: where it begins.
        counters: where it counts.
        timer_states: the states in which each timer runs; leaving these states ends it.
        step_timers: the timers that end with every change of state.

    Attributes:
        DROPS: which counter counts the bytes that are dropped for a reason.
        state: where it is.
        now_ns: the latest bench time it was told, in ns.
        counters: what it has seen.
        visits: how often each edge of the table was taken.
        events: what has happened and was not fetched yet.
    """

    DROPS: ClassVar[Mapping[Any, str]] = MappingProxyType({})

    def __init__(
        self,
        table: Mapping[tuple[StateT, TriggerT], Edge[StateT, ActionT]],
        state: StateT,
        counters: CountersT,
        *,
        timer_states: Mapping[TimerT, Collection[StateT]],
        step_timers: Collection[TimerT] = (),
    ) -> None:
        self.table = table
        self.state = state
        self.now_ns = 0
        self.counters = counters
        self.visits: Counter[tuple[StateT, TriggerT]] = Counter()
        self.events: list[EventT] = []
        self._timers: dict[TimerT, int] = {}
        self._timer_states = timer_states
        self._step_timers = step_timers

    @abstractmethod
    def trigger_of(self, timer: TimerT) -> TriggerT:
        """The trigger of a timer that has run out."""

    @abstractmethod
    def act(self, action: ActionT, trigger: TriggerT) -> None:
        """Carries out one action of an edge."""

    def state_changed(self, old: StateT, trigger: TriggerT) -> EventT | None:
        """The event that says that `state` is another one than before; None where nobody is told."""
        return cast("EventT", StateChanged(old=old, new=self.state, trigger=trigger))

    def to_transmit(self, frame: bytes) -> EventT:
        """The event that wants a frame on the line."""
        return cast("EventT", Transmit(data=frame))

    def drop(self, dropped: AnyDropped) -> None:
        """Reports and counts bytes that did not become a message."""
        name = self.DROPS[dropped.reason]
        setattr(self.counters, name, getattr(self.counters, name) + 1)
        self.events.append(cast("EventT", FrameDropped(reason=dropped.reason, data=dropped.data)))

    def has_edge(self, trigger: TriggerT) -> bool:
        """The table has an edge from here for this trigger."""
        return (self.state, trigger) in self.table

    def fire(self, trigger: TriggerT) -> None:
        """Takes the edge for this trigger, if there is one."""
        edge = self.table.get((self.state, trigger))
        if edge is None:
            self.counters.ignored += 1
            return
        old = self.state
        self.visits[old, trigger] += 1
        self.state = edge.next_state
        if self.state is not old:
            self._leave_timers()
            changed = self.state_changed(old, trigger)
            if changed is not None:
                self.events.append(changed)
        for action in edge.actions:
            self.act(action, trigger)

    def transmit(self, frame: bytes) -> None:
        """Wants a frame on the line."""
        self.count_out(frame)
        self.events.append(self.to_transmit(frame))

    def count_out(self, frame: bytes) -> None:
        """Counts a frame that goes out."""
        self.counters.frames_out += 1
        self.counters.bytes_out += len(frame)

    def start(self, timer: TimerT, after_s: float | None, *, since_ns: int = 0) -> None:
        """Starts a timer from now, or from `since_ns` if that is later, or ends it where the time is None."""
        if after_s is None:
            self._timers.pop(timer, None)
        elif self.state in self._timer_states[timer]:
            self._timers[timer] = max(self.now_ns, since_ns) + max(1, round(after_s * _NS_PER_S))

    def next_deadline_ns(self) -> int | None:
        """When the next timer runs out, in ns of bench time."""
        return min(self._timers.values()) if self._timers else None

    @property
    def deadlines(self) -> Mapping[TimerT, int]:
        """When each of the timers that run now will run out, in ns of bench time."""
        return MappingProxyType(self._timers)

    def expire_next(self) -> None:
        """Lets the earliest timer run out."""
        timer = min(self._timers, key=self._timers.__getitem__)
        del self._timers[timer]
        self.fire(self.trigger_of(timer))

    def fetch(self) -> list[EventT]:
        """The events since the last call."""
        events, self.events = self.events, []
        return events

    def _leave_timers(self) -> None:
        """Ends the timers that do not run in the new state."""
        for timer in tuple(self._timers):
            if timer in self._step_timers or self.state not in self._timer_states[timer]:
                del self._timers[timer]
