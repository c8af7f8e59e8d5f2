"""What both roles share: counters, and the events of this protocol around the common state machine."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

from protocols.pkt.events import Event
from protocols.pkt.framing import DropReason, Frame
from protocols.pkt.states import TIMER_STATES, Action, State, Table, Timer, Trigger
from protocols.state_machine import StateMachine

__all__ = ["Counters", "Machine"]


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


class Machine(StateMachine[State, Trigger, Action, Timer, Event, Counters]):
    """One end of the line: turns frames and timers into triggers, and carries out what the table says."""

    DROPS = _COUNTER_OF_DROP

    def __init__(self, table: Table, state: State) -> None:
        super().__init__(table, state, Counters(), timer_states=TIMER_STATES)

    @abstractmethod
    def take_frame(self, frame: Frame) -> None:
        """Handles a sound frame."""
