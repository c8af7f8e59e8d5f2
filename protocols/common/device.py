"""A small device around a state table: bytes in, bytes out, timers, and what there is to be seen of it.

For one end of a protocol that has no more to it than frames, a table and timers. It derives a class, says what a frame
does (`take`) and what an action does (`act`), and is put on a line as it is.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

from protocols.common.decoding import Reader
from protocols.state_machine import StateMachine

__all__ = ["Counters", "Step", "Table", "TableDevice", "Timers"]


@dataclass(frozen=True, slots=True)
class Step:
    """What an entry of a table says.

    Attributes:
        next_state: the state that follows.
        actions: what is done then, in this order.
    """

    next_state: Enum
    actions: tuple[Enum, ...] = ()


Table = Mapping[tuple[Enum, Enum], Step]
"""The steps by state and trigger; a pair that is absent changes nothing."""
Timers = Mapping[Enum, tuple[Enum, Collection[Enum]]]
"""What each timer triggers when it runs out, and the states in which it runs."""


@dataclass(slots=True, kw_only=True)
class Counters:
    """What a device has seen since it was made.

    Attributes:
        bytes_in: bytes received.
        bytes_out: bytes sent.
        frames_in: sound frames received.
        frames_out: frames sent.
        dropped: runs of bytes that are no frame.
        ignored: triggers that the state has no edge for.
    """

    bytes_in: int = 0
    bytes_out: int = 0
    frames_in: int = 0
    frames_out: int = 0
    dropped: int = 0
    ignored: int = 0


class TableDevice(StateMachine[Enum, Enum, Enum, Enum, object, Counters]):
    """See the module.

    Args:
        reader: finds the frames in what comes.
        rejected: its class of bytes that are no frame.
        table: the edges by state and trigger.
        state: where it begins.
        timers: what each timer triggers when it runs out, and the states in which it runs.
    """

    def __init__(
        self,
        reader: Reader[Any],
        rejected: type[Any],
        table: Table,
        state: Enum,
        timers: Timers,
    ) -> None:
        running = {timer: states for timer, (_, states) in timers.items()}
        super().__init__(table, state, Counters(), timer_states=running)
        self._reader = reader
        self._rejected = rejected
        self._triggers = {timer: trigger for timer, (trigger, _) in timers.items()}

    @abstractmethod
    def take(self, frame: Any) -> None:
        """Do what a sound frame asks for: `fire` a trigger, `transmit` an answer."""

    def act(self, action: Enum, trigger: Enum) -> None:
        """Carry out one action of a step; a table without actions needs nothing here."""

    @property
    def observed(self) -> TableDevice:
        """What a dashboard looks at: state, table, timers, counters."""
        return self

    def receive(self, data: bytes, now_ns: int) -> bytes:
        """Take bytes off the line; return what to put on it."""
        self._expire(now_ns)
        self.counters.bytes_in += len(data)
        for found in self._reader.receive(data, self.now_ns):
            if isinstance(found, self._rejected):
                self.counters.dropped += 1
            else:
                self.counters.frames_in += 1
                self.take(found)
        return self._sent()

    def advance(self, now_ns: int) -> bytes:
        """Do what is due; return what to put on the line."""
        self._expire(now_ns)
        return self._sent()

    def line_down(self, now_ns: int) -> bytes:
        """Take note that the line was hung up: an unfinished frame is forgotten."""
        self._expire(now_ns)
        self._reader.reset()
        return self._sent()

    def take_events(self) -> list[object]:
        """Return what happened since the last call."""
        return self.fetch()

    def trigger_of(self, timer: Enum) -> Enum:
        """The trigger of a timer that has run out."""
        return self._triggers[timer]

    def to_transmit(self, frame: bytes) -> object:
        """A frame for the line: the bytes themselves."""
        return frame

    def _expire(self, now_ns: int) -> None:
        """Let each timer run out at its time; what a device has to do at other times is not among them."""
        while (due_ns := super().next_deadline_ns()) is not None and due_ns <= now_ns:
            self.now_ns = due_ns
            self.expire_next()
        self.now_ns = max(self.now_ns, now_ns)

    def _sent(self) -> bytes:
        """Return what is for the line; other events stay."""
        events = self.fetch()
        self.events = [event for event in events if not isinstance(event, bytes)]
        return b"".join(event for event in events if isinstance(event, bytes))
