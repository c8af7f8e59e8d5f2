"""What the robot tells the bench's journal, besides the events of its protocol connection."""

from __future__ import annotations

import enum
from dataclasses import dataclass

from protocols.p2os import Command, Event


class Refusal(enum.Enum):
    """Why a known command had no effect."""

    MOTORS_OFF = "motors are off"
    EMERGENCY = "emergency stop waits for a velocity command"
    BAD_ARGUMENT = "argument out of range"
    NOT_FITTED = "the accessory is not fitted"


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandObeyed:
    """A command took effect."""

    command: Command


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandIgnored:
    """A known command had no effect, as on the real robot."""

    command: Command
    reason: Refusal


@dataclass(frozen=True, slots=True, kw_only=True)
class NotModelled:
    """A command this model does not know; it only fed the watchdog. Told once per number."""

    command: int


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorsEnabled:
    """The motors were switched."""

    enabled: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Stalled:
    """Power of a wheel was cut because it did not turn."""

    left: bool
    right: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class StallCleared:
    """Power came back to both wheels."""


@dataclass(frozen=True, slots=True, kw_only=True)
class BumpStopped:
    """BUMPSTALL stopped the robot; masks with bit 0 = segment 1."""

    front: int
    rear: int


@dataclass(frozen=True, slots=True, kw_only=True)
class HostBaudChanged:
    """The robot's own UART rate changed, bit/s."""

    baud: int
    reverted: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class SipSkipped:
    """A SIP was left out because the line had not caught up. Told once per session.

    Attributes:
        waiting: bytes that were still waiting for the line.
    """

    waiting: int


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputWithdrawn:
    """The session ended with packets waiting for the line; those that had not begun to leave were dropped, in bytes."""

    count: int


RobotEvent = (
    CommandObeyed
    | CommandIgnored
    | NotModelled
    | MotorsEnabled
    | Stalled
    | StallCleared
    | BumpStopped
    | HostBaudChanged
    | SipSkipped
    | OutputWithdrawn
    | Event
)
