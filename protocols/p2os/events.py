"""What a connection reports, in the order in which it happened.

`Transmit` carries the bytes that the machine itself wants on the line; they stand among the other events, so that the
order of replies and reports is the true one. Do not subclass these.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

from protocols.common.events import FrameDropped, StateChanged, Transmit
from protocols.p2os.commands import Command
from protocols.p2os.packets import ConfigPacket, Identification, ServerPacket
from protocols.p2os.robots import RobotParameters

__all__ = [
    "BaudWanted",
    "CloseReason",
    "CommandReceived",
    "ConnectFailed",
    "Connected",
    "ConnectionLost",
    "Disconnected",
    "Event",
    "FailReason",
    "FrameDropped",
    "LossReason",
    "PacketReceived",
    "SessionClosed",
    "SessionOpened",
    "StateChanged",
    "Transmit",
    "UnknownRobot",
    "WatchdogExpired",
    "WatchdogRevived",
]


class _Reason(enum.Enum):
    """A reason that prints as its text."""

    def __str__(self) -> str:
        return str(self.value)


class CloseReason(_Reason):
    """Why a server's session ended."""

    CLOSED = "the client sent CLOSE"
    LINE_DOWN = "the line went down"


class FailReason(_Reason):
    """Why a client could not connect."""

    NO_ANSWER = "no answer"
    WRONG_ANSWERS = "answers in the wrong order"
    BROKEN_IDENTIFICATION = "the identification cannot be read"
    UNKNOWN_ROBOT = "unknown robot"
    OLD_SESSION = "an old session would not close"
    NO_SIP = "OPEN brought no SIP"
    LINE_DOWN = "the line went down"


class LossReason(_Reason):
    """Why a client lost its session."""

    NO_SIP = "no SIP for too long"
    NOT_OPEN = "the robot is back in the handshake"
    CONTROLLER_RESET = "the controller was reset"
    LINE_DOWN = "the line went down"


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandReceived:
    """Server: a command in the session, also PULSE and ones without a name; never CLOSE."""

    command: Command


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionOpened:
    """Server: the client sent OPEN. SIPs begin, sonar begin, motors are off."""


@dataclass(frozen=True, slots=True, kw_only=True)
class SessionClosed:
    """Server: the session is over. Motors and sonar off, SIPs stop."""

    reason: CloseReason


@dataclass(frozen=True, slots=True, kw_only=True)
class WatchdogExpired:
    """Server: nothing came for too long. The robot must stop; the session stays open and SIPs go on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class WatchdogRevived:
    """Server: the first packet after that. The robot resumes what it was asked to do."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Connected:
    """Client: in session.

    Attributes:
        identification: what the robot said.
        parameters: the robot's parameter table, or that of the robot fallen back on.
        config: its configuration; None if it was not asked for or did not come in time.
    """

    identification: Identification
    parameters: RobotParameters
    config: ConfigPacket | None


@dataclass(frozen=True, slots=True, kw_only=True)
class UnknownRobot:
    """Client: there is no table for the robot's subclass; `fallback` is taken, or None and it is refused."""

    identification: Identification
    fallback: RobotParameters | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ConnectFailed:
    """Client: no session came about."""

    reason: FailReason


@dataclass(frozen=True, slots=True, kw_only=True)
class ConnectionLost:
    """Client: the session is gone."""

    reason: LossReason


@dataclass(frozen=True, slots=True, kw_only=True)
class PacketReceived:
    """Client: a packet of the session; SIPs may come before `Connected`, while the configuration is awaited."""

    packet: ServerPacket


@dataclass(frozen=True, slots=True, kw_only=True)
class BaudWanted:
    """Client: the line must change to this rate, in bit/s, before what follows is transmitted."""

    baud: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Disconnected:
    """Client: the session, or the attempt, was ended by the user. The port can be closed."""


Event = (
    Transmit
    | StateChanged
    | FrameDropped
    | CommandReceived
    | SessionOpened
    | SessionClosed
    | WatchdogExpired
    | WatchdogRevived
    | Connected
    | UnknownRobot
    | ConnectFailed
    | ConnectionLost
    | PacketReceived
    | BaudWanted
    | Disconnected
)
