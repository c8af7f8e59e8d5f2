"""What a connection reports, in the order in which it happened.

`Transmit` carries the bytes that the machine itself wants on the line; they stand among the other events, so that the
order of replies and reports is the true one. Do not subclass these.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass

from protocols.common.events import FrameDropped, StateChanged, Transmit
from protocols.pkt.codes import ErrorCode, ReportId
from protocols.pkt.commands import Command
from protocols.pkt.reports import Report

__all__ = [
    "CommandReceived",
    "CommandRefused",
    "Event",
    "FrameDropped",
    "LossReason",
    "MotorsMustStop",
    "ReportDue",
    "ReportReceived",
    "RoverFound",
    "RoverLost",
    "StateChanged",
    "Transmit",
]


class LossReason(enum.Enum):
    """Why a host lost its rover."""

    SILENCE = "no report for too long"
    LINE_DOWN = "the line went down"

    def __str__(self) -> str:
        return self.value


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandReceived:
    """Server: a command to be carried out now; never REQUEST_TMY, which the machine answers."""

    command: Command


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandRefused:
    """Server: a sound frame that asks for nothing that could be done; it counts as accepted all the same.

    Attributes:
        payload: what the frame carried.
        error: unknown opcode, or too few parameters.
    """

    payload: bytes
    error: ErrorCode


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorsMustStop:
    """Server: the host is silent for too long. The motors stay at rest until they are commanded again."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportDue:
    """Server: the program should send this report now; the machine sends the general one by itself."""

    report: ReportId


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportReceived:
    """Client: a report, of an unknown id too."""

    report: Report


@dataclass(frozen=True, slots=True, kw_only=True)
class RoverFound:
    """Client: the first report after `connect`, or after the rover was lost."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RoverLost:
    """Client: no report comes; the machine goes on asking."""

    reason: LossReason


Event = (
    Transmit
    | StateChanged
    | FrameDropped
    | CommandReceived
    | CommandRefused
    | MotorsMustStop
    | ReportDue
    | ReportReceived
    | RoverFound
    | RoverLost
)
