"""One end of a line with frames between flags: a machine that takes sound frames, and a reader that finds them."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterable
from typing import Protocol, TypeVar

from protocols.common.connection import MachineConnection
from protocols.common.flagged import COUNTER_OF_DROP, Dropped, Frame, FrameReader
from protocols.state_machine import ActionT, EventT, LineCounters, StateMachine, StateT, TimerT, TriggerT

__all__ = ["FlaggedConnection", "FlaggedMachine", "FramesCounters"]


class FramesCounters(LineCounters, Protocol):
    """What is counted of such frames, beside the reasons of `COUNTER_OF_DROP`."""

    bytes_in: int
    frames_in: int


FramesCountersT = TypeVar("FramesCountersT", bound=FramesCounters)


class FlaggedMachine(StateMachine[StateT, TriggerT, ActionT, TimerT, EventT, FramesCountersT]):
    """A machine that is given frames."""

    DROPS = COUNTER_OF_DROP

    @abstractmethod
    def take_frame(self, frame: Frame) -> None:
        """Handles a sound frame."""


class FlaggedConnection(MachineConnection[StateT, TriggerT, ActionT, TimerT, EventT, FramesCountersT]):
    """See the module."""

    _reader: FrameReader
    _machine: FlaggedMachine[StateT, TriggerT, ActionT, TimerT, EventT, FramesCountersT]

    @property
    def held(self) -> int:
        """Bytes of an unfinished frame or of noise that are kept; bounded."""
        return self._reader.held

    def receive(self, data: bytes, now_ns: int) -> list[EventT]:
        """Takes bytes that came in at `now_ns`; raises nothing whatever they are."""
        self._run_due(now_ns)
        self._machine.counters.bytes_in += len(data)
        self._take(self._reader.receive(data))
        return self._machine.fetch()

    def next_deadline_ns(self) -> int | None:
        """When `advance` has something to do, in ns of bench time; None if nothing is waited for."""
        return self._machine.next_deadline_ns()

    def _take(self, found: Iterable[Frame | Dropped]) -> None:
        for item in found:
            if isinstance(item, Dropped):
                self._machine.drop(item)
            else:
                self._machine.counters.frames_in += 1
                self._machine.take_frame(item)

    def _run_due(self, now_ns: int) -> int:
        """See `MachineConnection`."""
        machine = self._machine
        now_ns = max(now_ns, machine.now_ns)
        while (deadline_ns := machine.next_deadline_ns()) is not None and deadline_ns <= now_ns:
            machine.now_ns = deadline_ns
            machine.expire_next()
        machine.now_ns = now_ns
        return now_ns
