"""The adapter of the original's real robot: an ESP32 between the pins of a Blue Pill and the P2OS line of a Pioneer.

Start at `adapter.py`. Source of its behaviour: pioneer_2DX-Interface, code-esp32_d1, and its library p2os-arduino.
"""

from __future__ import annotations

from targets.parts.p2os_adapter.adapter import P2osAdapter
from targets.parts.p2os_adapter.events import (
    AdapterEvent,
    AdapterHeld,
    AdapterStarted,
    BytesDropped,
    CodesRead,
    ConnectionPin,
    DistanceBits,
    EncoderWords,
    RobotConnected,
    RobotConnectFailed,
    RobotLeft,
    RobotLost,
    SafeStopped,
    SpeedSent,
)
from targets.parts.p2os_adapter.settings import P2osAdapterSettings
from targets.parts.p2os_adapter.velocity import Velocity, velocity_of_codes, wire_speeds

__all__ = [
    "AdapterEvent",
    "AdapterHeld",
    "AdapterStarted",
    "BytesDropped",
    "CodesRead",
    "ConnectionPin",
    "DistanceBits",
    "EncoderWords",
    "P2osAdapter",
    "P2osAdapterSettings",
    "RobotConnectFailed",
    "RobotConnected",
    "RobotLeft",
    "RobotLost",
    "SafeStopped",
    "SpeedSent",
    "Velocity",
    "velocity_of_codes",
    "wire_speeds",
]
