"""What both roles share: counters, and the events of this protocol around the common state machine."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

from protocols.p2os.events import Event
from protocols.p2os.framing import Dropped, DropReason, Frame
from protocols.p2os.states import TIMER_STATES, Action, State, Table, Timer, Trigger
from protocols.state_machine import StateMachine

__all__ = ["Counters", "Machine"]


@dataclass(slots=True, kw_only=True)
class Counters:
    """What a connection has seen, since it was made.

    Attributes:
        bytes_in: bytes received.
        bytes_out: bytes sent or handed out to be sent.
        frames_in: sound frames received, readable or not.
        frames_out: frames sent.
        noise: runs of bytes without a header.
        bad_counts: headers whose count is out of range.
        bad_checksums: frames whose checksum is wrong.
        timed_out: unfinished frames given up.
        bad_bodies: sound frames whose body makes no sense.
        ignored: frames, timers and line drops that the state has no edge for.
        watchdog_expiries: server: how often the watchdog ran out.
        keepalives: client: PULSEs sent to keep the session alive.
        restarts: client: restarts of the handshake after a wrong answer.
    """

    bytes_in: int = 0
    bytes_out: int = 0
    frames_in: int = 0
    frames_out: int = 0
    noise: int = 0
    bad_counts: int = 0
    bad_checksums: int = 0
    timed_out: int = 0
    bad_bodies: int = 0
    ignored: int = 0
    watchdog_expiries: int = 0
    keepalives: int = 0
    restarts: int = 0


_COUNTER_OF_DROP = {
    DropReason.NOISE: "noise",
    DropReason.BAD_COUNT: "bad_counts",
    DropReason.BAD_CHECKSUM: "bad_checksums",
    DropReason.TIMED_OUT: "timed_out",
    DropReason.BAD_BODY: "bad_bodies",
}


class Machine(StateMachine[State, Trigger, Action, Timer, Event, Counters]):
    """One end of the line: turns frames and timers into triggers, and carries out what the table says."""

    DROPS = _COUNTER_OF_DROP

    def __init__(self, table: Table, state: State) -> None:
        super().__init__(table, state, Counters(), timer_states=TIMER_STATES, step_timers=(Timer.STEP,))

    @abstractmethod
    def take_frame(self, frame: Frame) -> None:
        """Handles a sound frame."""

    def drop_body(self, frame: Frame) -> None:
        """Reports and counts a sound frame whose body makes no sense."""
        self.drop(Dropped(reason=DropReason.BAD_BODY, data=frame.raw))
