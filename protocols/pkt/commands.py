"""Commands: what a host tells the rover, in three schemas.

Opcodes, offsets and types: document and manual, "Referencia del protocolo de comunicación"; G0 rover-firmware
application.cpp `update_motor_speeds`; G1b ceai2020 at b73d4c7 and c47f7b4, application.cpp `set_motor_throttle`; G2 at
6058e92, application.cpp `set_motor_throttles` and the functions behind it. Parameters that follow the known ones are
ignored, as in all firmware.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from struct import Struct
from types import MappingProxyType

from protocols.pkt.codes import BOTH_MOTORS, Opcode
from protocols.pkt.errors import LocalProtocolError, RemoteProtocolError
from protocols.pkt.options import Schema

__all__ = [
    "COMMANDS",
    "Command",
    "CommandSpec",
    "LedOff",
    "LedOn",
    "MotorSpeeds",
    "MotorThrottles",
    "PidGains",
    "RequestTelemetry",
    "SpeedSetpoints",
    "UnknownCommand",
    "clamp_command",
    "decode_command",
    "encode_command",
]

MAX_SPEED = 255
"""The largest speed of the first two schemas, without a unit: the duty of an 8-bit PWM (document, 0x03)."""
MAX_THROTTLE = 1.0
"""The largest throttle of the last schema: all that the L298N can put out (manual, 0x03)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RequestTelemetry:
    """Asks for the general report. It touches no counter.

    Attributes:
        report_type: a byte that the author's client sends along, always 0, and no firmware reads
            (rover_groundcontrol/rover/__init__.py `request_tmy`).
    """

    report_type: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class LedOn:
    """Switches the test LED on."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LedOff:
    """Switches the test LED off."""


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorSpeeds:
    """First two schemas: sets the PWM of each pair of motors.

    Attributes:
        a: left pair, -255..255, negative is backwards.
        b: right pair, as above.
        flags: which of them, see `MotorFlag`.
    """

    a: int
    b: int
    flags: int = BOTH_MOTORS


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorThrottles:
    """Last schema: sets the throttle of each pair of motors, in manual mode.

    Attributes:
        a: left pair, -1..1 of full voltage, negative is backwards; a float of 32 bits on the wire.
        b: right pair, as above.
        flags: which of them, see `MotorFlag`.
    """

    a: float
    b: float
    flags: int = BOTH_MOTORS


@dataclass(frozen=True, slots=True, kw_only=True)
class SpeedSetpoints:
    """Second and last schema: sets the wheel speeds to be kept, in PID mode (G1b remembers them only).

    Attributes:
        a_rpm: left pair, turns of the wheel per minute; a float of 32 bits on the wire.
        b_rpm: right pair, as above.
        flags: which of them, see `MotorFlag`.
    """

    a_rpm: float
    b_rpm: float
    flags: int = BOTH_MOTORS


@dataclass(frozen=True, slots=True, kw_only=True)
class PidGains:
    """Last schema: sets the gains of both speed controllers and clears their sums.

    Attributes:
        kp: throttle per rpm.
        kd: throttle per (rpm/s); it stands before ki.
        ki: throttle per (rpm s).
    """

    kp: float
    kd: float
    ki: float


@dataclass(frozen=True, slots=True, kw_only=True)
class UnknownCommand:
    """A command whose opcode the schema does not have.

    Attributes:
        opcode: the opcode byte.
        parameters: what follows it.
    """

    opcode: int
    parameters: bytes = b""


_Known = RequestTelemetry | LedOn | LedOff | MotorSpeeds | MotorThrottles | SpeedSetpoints | PidGains
Command = _Known | UnknownCommand


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandSpec:
    """One command in one schema.

    Attributes:
        opcode: its first byte.
        name: as the sources call it.
        kind: the class that holds it.
        layout: the `struct` format of its parameters; the names of the class's fields are those of the items.
        text: what it does, and its parameters.
        source: where that is written.
    """

    opcode: Opcode
    name: str
    kind: type[_Known]
    layout: str
    text: str
    source: str

    @property
    def size(self) -> int:
        """The parameters' size, in bytes."""
        return Struct(self.layout).size


_FLAGS = "flags u8: bit 0 left pair A, bit 1 right pair B"
_REQUEST = CommandSpec(
    opcode=Opcode.REQUEST_TMY,
    name="REQUEST_TMY",
    kind=RequestTelemetry,
    layout="<",
    text="asks for 0x80; no counter moves",
    source="document and manual",
)
_LEDS = (
    CommandSpec(
        opcode=Opcode.LED_ON,
        name="LED_ON",
        kind=LedOn,
        layout="<",
        text="test LED on",
        source="document and manual",
    ),
    CommandSpec(
        opcode=Opcode.LED_OFF,
        name="LED_OFF",
        kind=LedOff,
        layout="<",
        text="test LED off",
        source="document and manual",
    ),
)
_SPEEDS_V1 = CommandSpec(
    opcode=Opcode.UPDATE_MOTORS,
    name="UPDATE_MOTOR_SPEEDS",
    kind=MotorSpeeds,
    layout=">hhB",
    text=f"A, B int16 big-endian, -255..255; {_FLAGS}",
    source="document, 0x03; G0 application.cpp update_motor_speeds",
)
_SPEEDS_V1B = CommandSpec(
    opcode=Opcode.UPDATE_MOTORS,
    name="UPDATE_MOTOR_SPEEDS",
    kind=MotorSpeeds,
    layout="<hhB",
    text=f"A, B int16 little-endian; {_FLAGS}",
    source="G1b application.cpp set_motor_throttle",
)
_THROTTLES = CommandSpec(
    opcode=Opcode.UPDATE_MOTORS,
    name="UPDATE_MOTOR_THROTTLES",
    kind=MotorThrottles,
    layout="<ffB",
    text=f"A, B float32 little-endian, -1..1, manual mode; {_FLAGS}",
    source="manual, 0x03; G2 application.cpp set_motor_throttles",
)
_SETPOINTS = CommandSpec(
    opcode=Opcode.UPDATE_MOTOR_SPEED_SETPOINTS,
    name="UPDATE_MOTOR_SPEED_SETPOINTS",
    kind=SpeedSetpoints,
    layout="<ffB",
    text=f"A, B float32 little-endian, rpm, PID mode; {_FLAGS}",
    source="manual, 0x04; G1b and G2 application.cpp set_motor_speed_setpoints",
)
_GAINS = CommandSpec(
    opcode=Opcode.RESET_PID_CONTROLLER,
    name="RESET_PID_CONTROLLER",
    kind=PidGains,
    layout="<fff",
    text="kp, kd, ki float32 little-endian",
    source="manual, 0x05; rover_groundcontrol/rover/__init__.py configure_motor_pid",
)


def _by_opcode(*specs: CommandSpec) -> Mapping[int, CommandSpec]:
    return MappingProxyType({int(spec.opcode): spec for spec in specs})


COMMANDS: Mapping[Schema, Mapping[int, CommandSpec]] = MappingProxyType(
    {
        Schema.V1: _by_opcode(_REQUEST, *_LEDS, _SPEEDS_V1),
        Schema.V1B: _by_opcode(_REQUEST, *_LEDS, _SPEEDS_V1B, _SETPOINTS),
        Schema.V2: _by_opcode(_REQUEST, *_LEDS, _THROTTLES, _SETPOINTS, _GAINS),
    }
)
"""Every command of each schema, by opcode."""

_LAYOUTS = {schema: {n: Struct(spec.layout) for n, spec in specs.items()} for schema, specs in COMMANDS.items()}
_OPCODES = {schema: {spec.kind: n for n, spec in specs.items()} for schema, specs in COMMANDS.items()}


def encode_command(command: Command, schema: Schema = Schema.V2) -> bytes:
    """The payload of a command.

    Raises:
        LocalProtocolError: the schema does not have it, or a parameter does not fit its place.
    """
    if isinstance(command, UnknownCommand):
        return _byte("opcode", command.opcode) + command.parameters
    opcode = _OPCODES[schema].get(type(command))
    if opcode is None:
        raise LocalProtocolError(f"{type(command).__name__} is no command of schema {schema.name}")
    if isinstance(command, RequestTelemetry):
        extra = b"" if command.report_type is None else _byte("report_type", command.report_type)
        return bytes((opcode,)) + extra
    values = [getattr(command, name) for name in command.__slots__]
    try:
        return bytes((opcode,)) + _LAYOUTS[schema][opcode].pack(*values)
    except (struct.error, OverflowError) as error:
        raise LocalProtocolError(f"{command} does not fit schema {schema.name}: {error}") from None


def decode_command(payload: bytes, schema: Schema = Schema.V2, *, at: int = 1) -> Command:
    """The command in a frame's payload; what follows its parameters is ignored.

    Args:
        payload: the payload of a sound frame.
        schema: which meanings apply.
        at: where the parameters begin; 1, but 5 in the gains as G2 reads them.

    Raises:
        RemoteProtocolError: the payload is empty, or its parameters too short.
    """
    if not payload:
        raise RemoteProtocolError("an empty payload holds no opcode")
    opcode = payload[0]
    spec = COMMANDS[schema].get(opcode)
    if spec is None:
        return UnknownCommand(opcode=opcode, parameters=payload[1:])
    if spec.kind is RequestTelemetry:
        return RequestTelemetry(report_type=payload[1] if len(payload) > 1 else None)
    layout = _LAYOUTS[schema][opcode]
    if len(payload) < at + layout.size:
        raise RemoteProtocolError(f"{spec.name} has {len(payload) - at} bytes of parameters, not {layout.size}")
    values = layout.unpack_from(payload, at)
    return spec.kind(**dict(zip(spec.kind.__slots__, values, strict=True)))


def clamp_command(command: Command) -> Command:
    """The same command with speeds and throttles brought into their range; NaN becomes 0."""
    if isinstance(command, MotorSpeeds):
        low, high = -MAX_SPEED, MAX_SPEED
        return MotorSpeeds(a=min(max(command.a, low), high), b=min(max(command.b, low), high), flags=command.flags)
    if isinstance(command, MotorThrottles):
        return MotorThrottles(a=_clamped(command.a), b=_clamped(command.b), flags=command.flags)
    return command


def _clamped(throttle: float) -> float:
    return 0.0 if math.isnan(throttle) else min(max(throttle, -MAX_THROTTLE), MAX_THROTTLE)


def _byte(name: str, value: int) -> bytes:
    if not 0 <= value <= 0xFF:
        raise LocalProtocolError(f"{name} {value} is not 0..255")
    return bytes((value,))
