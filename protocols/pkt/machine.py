"""What both roles share: a state, a table, timers, counters, and the events that come out."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections import Counter
from dataclasses import dataclass

from protocols.pkt.events import Event, FrameDropped, StateChanged, Transmit
from protocols.pkt.framing import Dropped, DropReason, Frame
from protocols.pkt.states import TIMER_STATES, Action, State, Table, Timer, Trigger

__all__ = ["Counters", "Machine"]

_NS_PER_S = 1_000_000_000


@dataclass(slots=True, kw_only=True)
class Counters:
    """What a connection has seen, since it was made; unlike the rover's own counters these do not wrap.

    Attributes:
        bytes_in: bytes received.
        bytes_out: bytes sent or handed out to be sent.
        frames_in: sound frames received, readable or not.
        frames_out: frames sent.
        noise: runs of bytes without a sync word.
        bad_syncs: broken sync words.
        bad_lengths: lengths out of range, frames without a newline within the limit.
        bad_crcs: frames whose CRC is wrong.
        bad_terminators: frames with another byte than a newline behind the CRC.
        timed_out: unfinished frames given up.
        bad_bodies: client: sound frames whose payload makes no sense.
        polls_of_eleven: server: looks that threw their eleven bytes away.
        overruns: server: looks before which bytes had found the receive buffer full.
        refused: server: sound frames that could not be carried out.
        ignored: triggers that the state has no edge for.
        silences: times that the other end was silent for too long.
        requests: client: REQUEST_TMY sent by itself.
    """

    bytes_in: int = 0
    bytes_out: int = 0
    frames_in: int = 0
    frames_out: int = 0
    noise: int = 0
    bad_syncs: int = 0
    bad_lengths: int = 0
    bad_crcs: int = 0
    bad_terminators: int = 0
    timed_out: int = 0
    bad_bodies: int = 0
    polls_of_eleven: int = 0
    overruns: int = 0
    refused: int = 0
    ignored: int = 0
    silences: int = 0
    requests: int = 0


_COUNTER_OF_DROP = {
    DropReason.NOISE: "noise",
    DropReason.BAD_SYNC: "bad_syncs",
    DropReason.BAD_LENGTH: "bad_lengths",
    DropReason.BAD_CRC: "bad_crcs",
    DropReason.BAD_TERMINATOR: "bad_terminators",
    DropReason.TIMED_OUT: "timed_out",
    DropReason.BAD_BODY: "bad_bodies",
    DropReason.POLL_OF_ELEVEN: "polls_of_eleven",
    DropReason.OVERRUN: "overruns",
}


class Machine(ABC):
    """One end of the line: turns frames and timers into triggers, and carries out what the table says.

    Attributes:
        state: where it is.
        now_ns: the latest bench time it was told, in ns.
        counters: what it has seen.
        visits: how often each edge of the table was taken.
        events: what has happened and was not fetched yet.
    """

    def __init__(self, table: Table, state: State) -> None:
        self.table = table
        self.state = state
        self.now_ns = 0
        self.counters = Counters()
        self.visits: Counter[tuple[State, Trigger]] = Counter()
        self.events: list[Event] = []
        self._timers: dict[Timer, int] = {}

    @abstractmethod
    def take_frame(self, frame: Frame) -> None:
        """Handles a sound frame."""

    @abstractmethod
    def trigger_of(self, timer: Timer) -> Trigger:
        """The trigger of a timer that has run out."""

    @abstractmethod
    def act(self, action: Action, trigger: Trigger) -> None:
        """Carries out one action of an edge."""

    def has_edge(self, trigger: Trigger) -> bool:
        """The table has an edge from here for this trigger."""
        return (self.state, trigger) in self.table

    def fire(self, trigger: Trigger) -> None:
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
            self.events.append(StateChanged(old=old, new=self.state, trigger=trigger))
        for action in edge.actions:
            self.act(action, trigger)

    def drop(self, dropped: Dropped) -> None:
        """Reports and counts bytes that did not become a message."""
        name = _COUNTER_OF_DROP[dropped.reason]
        setattr(self.counters, name, getattr(self.counters, name) + 1)
        self.events.append(FrameDropped(reason=dropped.reason, data=dropped.data))

    def transmit(self, frame: bytes) -> None:
        """Wants a frame on the line."""
        self.count_out(frame)
        self.events.append(Transmit(data=frame))

    def count_out(self, frame: bytes) -> None:
        """Counts a frame that goes out."""
        self.counters.frames_out += 1
        self.counters.bytes_out += len(frame)

    def start(self, timer: Timer, after_s: float | None, *, since_ns: int = 0) -> None:
        """Starts a timer from now, or from `since_ns` if that is later, or ends it where the time is None."""
        if after_s is None:
            self._timers.pop(timer, None)
        elif self.state in TIMER_STATES[timer]:
            self._timers[timer] = max(self.now_ns, since_ns) + max(1, round(after_s * _NS_PER_S))

    def next_deadline_ns(self) -> int | None:
        """When the next timer runs out, in ns of bench time."""
        return min(self._timers.values(), default=None)

    def expire_next(self) -> None:
        """Lets the earliest timer run out."""
        timer = min(self._timers, key=self._timers.__getitem__)
        del self._timers[timer]
        self.fire(self.trigger_of(timer))

    def fetch(self) -> list[Event]:
        """The events since the last call."""
        events, self.events = self.events, []
        return events

    def _leave_timers(self) -> None:
        """Ends the timers that do not run in the new state."""
        for timer in tuple(self._timers):
            if self.state not in TIMER_STATES[timer]:
                del self._timers[timer]
