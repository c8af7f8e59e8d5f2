"""What a connection reports, in the order in which it happened.

`Transmit` carries the bytes that are to be written to the simulator's line; it stands among the other events, so that
the order is the true one. Do not subclass these.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

from protocols.carla.frames import CommandFrame, Mode, StatusFrame
from protocols.carla.messages import AckermannCommand, ManualCommand
from protocols.carla.states import ModeTrigger
from protocols.common.events import FrameDropped

__all__ = [
    "AgentChanged",
    "CommandRefused",
    "Commanded",
    "DeadlineMissed",
    "Event",
    "FrameDropped",
    "LampChanged",
    "LineDead",
    "LinkSilent",
    "ModeAnswered",
    "ModeChanged",
    "ModeReported",
    "PressIgnored",
    "Refusal",
    "StatusReceived",
    "StatusReported",
    "Transmit",
    "Waited",
]


class Refusal(enum.Enum):
    """Why something was not done."""

    NOT_FINITE = "a NaN or an infinity"
    IMPLAUSIBLE = "beyond what can be meant"
    NO_AGENT = "the driving stack is not there"
    TOO_EARLY = "too soon after the press before, or after the start"
    EMERGENCY = "not in EMERGENCY"
    UNKNOWN_MODE = "neither 1 nor 4"

    def __str__(self) -> str:
        return self.value


class Waited(enum.Enum):
    """What did not come in time."""

    COMMAND = "a command of the driving stack"
    STATUS = "a status of the simulator"


@dataclass(frozen=True, slots=True, kw_only=True)
class Transmit:
    """Bytes to be written to the simulator's line now, one whole frame.

    Attributes:
        data: 30 bytes from a board, 22 from a simulator.
        frame: what they say; None for a buffer that nobody has filled.
    """

    data: bytes
    frame: CommandFrame | StatusFrame | None


@dataclass(frozen=True, slots=True, kw_only=True)
class ModeChanged:
    """Board: its mode is another one from now on."""

    old: Mode
    new: Mode
    trigger: ModeTrigger


@dataclass(frozen=True, slots=True, kw_only=True)
class LampChanged:
    """Board: the block of another mode begins: AUTOWARE lights amber LD2, MANUAL green LD1, EMERGENCY red LD3."""

    mode: Mode


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusReceived:
    """Board: a status came in and will be the one that is known."""

    status: StatusFrame


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusReported:
    """Board: to the driving stack, velocity and steering report.

    Attributes:
        status: what they say.
        fresh: it came since the report before; otherwise it is an old one again.
    """

    status: StatusFrame
    fresh: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class ModeReported:
    """Board: to the driving stack, control-mode report; the values are those of ControlModeReport."""

    mode: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ModeAnswered:
    """Board: to the driving stack, the answer to a control-mode request.

    Attributes:
        mode: that was asked for.
        success: what the answer says.
        reason: why not; None with success.
    """

    mode: int
    success: bool
    reason: Refusal | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class DeadlineMissed:
    """Board: something did not come in time.

    Attributes:
        what: what.
        misses: how many times in a row now.
    """

    what: Waited
    misses: int


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandRefused:
    """Board: a command of the driving stack that is not handed on."""

    reason: Refusal


@dataclass(frozen=True, slots=True, kw_only=True)
class PressIgnored:
    """Board: a press of the joystick that does nothing."""

    reason: Refusal


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentChanged:
    """Board: the driving stack is there, or is there no more."""

    online: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class LineDead:
    """Board: reception has ended until reset."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Commanded:
    """Simulator: a command for the car.

    Attributes:
        command: an `AckermannCommand` for the modes 1 and 0, a `ManualCommand` for 4.
        mode: of the frame.
        frame: as it came; None where the line was silent for too long and this is our own stop.
    """

    command: AckermannCommand | ManualCommand
    mode: int
    frame: CommandFrame | None


@dataclass(frozen=True, slots=True, kw_only=True)
class LinkSilent:
    """Simulator: no sound command for too long; a `Commanded` that stops the car follows."""


Event = (
    Transmit
    | FrameDropped
    | ModeChanged
    | LampChanged
    | StatusReceived
    | StatusReported
    | ModeReported
    | ModeAnswered
    | DeadlineMissed
    | CommandRefused
    | PressIgnored
    | AgentChanged
    | LineDead
    | Commanded
    | LinkSilent
)
