"""Parts: what is soldered between a board and the world, or between a board and a robot. See `part.py`.

Kinds that come with hilbench, by the name that a bench file uses. They are imported when they are asked for.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from types import MappingProxyType

from targets.parts.part import (
    AnalogOutput,
    Control,
    DigitalInput,
    DigitalOutput,
    Direction,
    Part,
    Picture,
    Ports,
    Quantity,
    Terminal,
)

__all__ = [
    "PARTS",
    "ROUTINE",
    "AnalogOutput",
    "Control",
    "DigitalInput",
    "DigitalOutput",
    "Direction",
    "Part",
    "Picture",
    "Ports",
    "Quantity",
    "Terminal",
    "part_class",
]

PARTS: Mapping[str, str] = MappingProxyType(
    {
        "at24c02": "targets.parts.at24c02:At24c02",
        "battery": "targets.parts.battery:Battery",
        "dc-motor": "targets.parts.dc_motor:DcMotor",
        "distance-switch": "targets.parts.distance_switch:DistanceSwitch",
        "encoder-3bit": "targets.parts.encoder_3bit:Encoder3Bit",
        "gamepad": "targets.parts.gamepad:Gamepad",
        "joystick": "targets.parts.joystick:Joystick",
        "l298n": "targets.parts.l298n:L298n",
        "motor-code": "targets.parts.motor_code:MotorCode",
        "mpu6050": "targets.parts.mpu6050:Mpu6050",
        "mpu9250": "targets.parts.mpu9250:Mpu9250",
        "neo6m": "targets.parts.neo6m:Neo6m",
        "p2os-adapter": "targets.parts.p2os_adapter:P2osAdapter",
        "ssd1306": "targets.parts.ssd1306:Ssd1306",
        "tachometer-disc": "targets.parts.tachometer_disc:TachometerDisc",
        "w25q": "targets.parts.w25q:W25q",
    }
)
"""Module and class of each kind."""

ROUTINE = frozenset({"EncoderMoved", "EncoderWords", "JoystickMoved", "MotorWord"})
"""Names of events that a part reports all the time; no line of a log."""


def part_class(kind: str) -> type[Part]:
    """Return the class of a kind of part.

    Raises:
        KeyError: there is no such kind.
    """
    module, _, name = PARTS[kind].partition(":")
    found: type[Part] = getattr(import_module(module), name)
    return found
