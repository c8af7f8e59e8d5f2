"""Links: how bytes get from one end to the other, inside the bench and to the outside world."""

from hilbench.links.memory import MemoryLink, MemoryPort
from hilbench.links.port import Line, LinkCounters, Port
from hilbench.links.pty import PtyDoor
from hilbench.links.reconnecting import ReconnectingPort
from hilbench.links.rfc2217 import Rfc2217Door
from hilbench.links.serial_target import (
    DEFAULT_BAUD,
    LineSettings,
    SerialTarget,
    is_serial_target,
    parse_serial_target,
)
from hilbench.links.serialport import SerialPort
from hilbench.links.tcp import TcpDoor

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
