"""The two frames of the simulator's line: status to the board, commands from it.

Both begin with ``#`` and end with ``$``; between them each field stands behind its letter, floats as IEEE-754 binary32,
little-endian. There is no length, checksum, escape or number: the letters are all that tells a damaged frame.
Sources: LMA-FEM-UNICAMP/carla_serial_bridge, src/carla_serial_bridge_node.cpp `send_to_microautoware` and
`timer_callback`; LMA-FEM-UNICAMP/microAutoware, src/HIL, `vGetStringFromControlAction`, `HAL_UART_RxCpltCallback`.
"""

from __future__ import annotations

import enum
import math
import struct
from dataclasses import dataclass, fields
from functools import cached_property
from typing import Any, TypeVar

from protocols.carla.errors import LocalProtocolError, RemoteProtocolError

__all__ = [
    "BAUD",
    "COMMAND_BYTES",
    "COMMAND_LAYOUT",
    "END",
    "START",
    "STATUS_BYTES",
    "STATUS_LAYOUT",
    "CommandFrame",
    "Field",
    "Layout",
    "Mode",
    "StatusFrame",
    "decode_command",
    "decode_status",
    "encode_command",
    "encode_status",
    "finite",
]

START = 0x23
"""``#``"""
END = 0x24
"""``$``"""
BAUD = 921_600
"""Bits per second of the line, 8N1 (both ends: main.c, serial_com.hpp)."""

_FLOAT_BYTES = 4


class Mode(enum.IntEnum):
    """The mode byte; the values are those of Autoware's ControlModeReport, where 0 is NO_COMMAND."""

    EMERGENCY = 0
    AUTOWARE = 1
    MANUAL = 4


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusFrame:
    """What the simulator says of the car, 22 bytes on the line.

    Attributes:
        lon_speed_m_s: A, forwards.
        lat_speed_m_s: B, in the sign of Autoware's VelocityReport as the bridge fills it, see `units.py`.
        heading_rate_rad_s: C, as above.
        steering_rad: D, the tyre's angle, positive to the left.
    """

    lon_speed_m_s: float = 0.0
    lat_speed_m_s: float = 0.0
    heading_rate_rad_s: float = 0.0
    steering_rad: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandFrame:
    """What the board commands, 29 bytes and a NUL on the line. What the fields mean hangs on the mode.

    In `Mode.AUTOWARE` they have the units below; in `Mode.MANUAL` steering is -1..1, speed the throttle 0..1,
    acceleration the brake 0..1 and the others are 0; in `Mode.EMERGENCY` all are 0. See `AckermannCommand` and
    `ManualCommand`.

    Attributes:
        steering: S, the tyre's angle x 1.2, rad, positive to the left.
        steering_rate: W, its rate x 1.2, rad/s.
        speed: V, m/s.
        acceleration: A, m/s^2.
        jerk: J, m/s^3.
        mode: M, one byte, see `Mode`; others are possible.
    """

    steering: float = 0.0
    steering_rate: float = 0.0
    speed: float = 0.0
    acceleration: float = 0.0
    jerk: float = 0.0
    mode: int = Mode.EMERGENCY


@dataclass(frozen=True, slots=True, kw_only=True)
class Field:
    """One field of a frame: its letter, the attribute it is in, its bytes."""

    tag: int
    name: str
    size: int = _FLOAT_BYTES


@dataclass(frozen=True, kw_only=True)
class Layout:
    """The fields of a frame in their order.

    Attributes:
        fields: as they stand behind each other.
        padding: what is sent behind ``$``, and may be missing.
    """

    fields: tuple[Field, ...]
    padding: bytes = b""

    @cached_property
    def length(self) -> int:
        """Bytes from ``#`` to ``$``."""
        return 2 + sum(1 + field.size for field in self.fields)

    @cached_property
    def letters(self) -> dict[int, int]:
        """What must stand where in a whole frame: offset to byte."""
        found, at = {0: START}, 1
        for field in self.fields:
            found[at] = field.tag
            at += 1 + field.size
        return found | {at: END}

    @cached_property
    def packing(self) -> struct.Struct:
        """The whole frame without its padding."""
        return struct.Struct(
            "<c" + "".join("cf" if field.size == _FLOAT_BYTES else "cB" for field in self.fields) + "c"
        )

    def encode(self, message: StatusFrame | CommandFrame) -> bytes:
        """The bytes of a message, padding and all.

        Raises:
            LocalProtocolError: a value does not fit its field.
        """
        values: list[bytes | float] = [bytes((START,))]
        for field in self.fields:
            values += [bytes((field.tag,)), getattr(message, field.name)]
        try:
            return self.packing.pack(*values, bytes((END,))) + self.padding
        except (struct.error, OverflowError) as error:
            raise LocalProtocolError(f"{message} does not fit a frame: {error}") from None

    def values(self, raw: bytes) -> dict[str, Any]:
        """The fields of one whole frame, by their names.

        Raises:
            RemoteProtocolError: the length or a letter is wrong.
        """
        body = raw.removesuffix(self.padding) if len(raw) > self.length else raw
        if len(body) != self.length:
            raise RemoteProtocolError(f"{len(raw)} bytes instead of {self.length}")
        for at, letter in self.letters.items():
            if body[at] != letter:
                raise RemoteProtocolError(f"byte {at} is {body[at]:02X} instead of {letter:02X}")
        return {field.name: value for field, value in zip(self.fields, self.packing.unpack(body)[2:-1:2], strict=True)}


STATUS_LAYOUT = Layout(
    fields=(
        Field(tag=ord("A"), name="lon_speed_m_s"),
        Field(tag=ord("B"), name="lat_speed_m_s"),
        Field(tag=ord("C"), name="heading_rate_rad_s"),
        Field(tag=ord("D"), name="steering_rad"),
    )
)
"""Simulator to board."""
COMMAND_LAYOUT = Layout(
    fields=(
        Field(tag=ord("S"), name="steering"),
        Field(tag=ord("W"), name="steering_rate"),
        Field(tag=ord("V"), name="speed"),
        Field(tag=ord("A"), name="acceleration"),
        Field(tag=ord("J"), name="jerk"),
        Field(tag=ord("M"), name="mode", size=1),
    ),
    padding=b"\0",
)
"""Board to simulator; the NUL behind it ends a C string and is sent with it."""
STATUS_BYTES = STATUS_LAYOUT.length
"""22"""
COMMAND_BYTES = COMMAND_LAYOUT.length + len(COMMAND_LAYOUT.padding)
"""30, the NUL counted."""


def encode_status(status: StatusFrame) -> bytes:
    """The 22 bytes of a status.

    Raises:
        LocalProtocolError: a value does not fit a float of 32 bits.
    """
    return STATUS_LAYOUT.encode(status)


def decode_status(raw: bytes) -> StatusFrame:
    """The status in 22 bytes.

    Raises:
        RemoteProtocolError: the length or a letter is wrong.
    """
    return StatusFrame(**STATUS_LAYOUT.values(raw))


def encode_command(command: CommandFrame) -> bytes:
    """The 30 bytes of a command.

    Raises:
        LocalProtocolError: a value does not fit its field.
    """
    return COMMAND_LAYOUT.encode(command)


def decode_command(raw: bytes) -> CommandFrame:
    """The command in 29 bytes, or in 30 with the NUL.

    Raises:
        RemoteProtocolError: the length or a letter is wrong.
    """
    return CommandFrame(**COMMAND_LAYOUT.values(raw))


_FrameT = TypeVar("_FrameT", StatusFrame, CommandFrame)


def finite(frame: _FrameT) -> bool:
    """No field is NaN or infinite."""
    return all(math.isfinite(getattr(frame, field.name)) for field in fields(frame))
