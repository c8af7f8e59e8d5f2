"""Links: how bytes get from one end to the other, inside the bench and to the outside world."""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING, Any

from hilbench.links.memory import MemoryLink, MemoryPort
from hilbench.links.port import Line, LinkCounters, Port
from hilbench.links.pty import PtyDoor
from hilbench.links.rfc2217 import Rfc2217Door
from hilbench.links.serial_target import (
    DEFAULT_BAUD,
    LineSettings,
    SerialTarget,
    is_serial_target,
    parse_serial_target,
)
from hilbench.links.tcp import TcpDoor

if TYPE_CHECKING:
    from hilbench.links.reconnecting import ReconnectingPort
    from hilbench.links.serialport import SerialPort

__all__ = [
    "DEFAULT_BAUD",
    "Line",
    "LineSettings",
    "LinkCounters",
    "MemoryLink",
    "MemoryPort",
    "Port",
    "PtyDoor",
    "ReconnectingPort",
    "Rfc2217Door",
    "SerialPort",
    "SerialTarget",
    "TcpDoor",
    "is_serial_target",
    "parse_serial_target",
]

_WITH_PYSERIAL = {"ReconnectingPort": "hilbench.links.reconnecting", "SerialPort": "hilbench.links.serialport"}
"""Imported when they are asked for: who only reads a bench file needs no pyserial."""


def __getattr__(name: str) -> Any:
    if name in _WITH_PYSERIAL:
        return getattr(importlib.import_module(_WITH_PYSERIAL[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
