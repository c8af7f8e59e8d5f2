"""A behavioural model of the P2OS controller of a Pioneer 2-DX and its relatives.

Bytes and bench time in, bytes out; the body is anything with the few methods of `Chassis`.
"""

from __future__ import annotations

from targets.robots.pioneer.chassis import Chassis
from targets.robots.pioneer.events import (
    BumpStopped,
    CommandIgnored,
    CommandObeyed,
    HostBaudChanged,
    MotorsEnabled,
    NotModelled,
    OutputWithdrawn,
    Refusal,
    RobotEvent,
    SipSkipped,
    StallCleared,
    Stalled,
)
from targets.robots.pioneer.ledger import LEDGER, Fidelity, LedgerEntry
from targets.robots.pioneer.output import HostLine
from targets.robots.pioneer.robot import PioneerRobot, server_options
from targets.robots.pioneer.settings import Described, RobotSettings, describe, settings_for

__all__ = [
    "LEDGER",
    "BumpStopped",
    "Chassis",
    "CommandIgnored",
    "CommandObeyed",
    "Described",
    "Fidelity",
    "HostBaudChanged",
    "HostLine",
    "LedgerEntry",
    "MotorsEnabled",
    "NotModelled",
    "OutputWithdrawn",
    "PioneerRobot",
    "Refusal",
    "RobotEvent",
    "RobotSettings",
    "SipSkipped",
    "StallCleared",
    "Stalled",
    "describe",
    "server_options",
    "settings_for",
]
