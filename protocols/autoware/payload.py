"""What a message is on the stand-in link: one byte, the id, then its fields, little-endian and without gaps.

All of this is our choice; with a micro-ROS agent the same messages travel as CDR inside XRCE-DDS.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass, fields
from struct import Struct
from types import MappingProxyType

from protocols.autoware.catalogue import MESSAGES, MessageSpec, WireType
from protocols.autoware.errors import LocalProtocolError, RemoteProtocolError
from protocols.autoware.messages import (
    AckermannControlCommand,
    AgentOnline,
    AgentPing,
    Clock,
    ControlModeReport,
    ControlModeRequest,
    ControlModeResponse,
    HazardLightsCommand,
    HazardLightsReport,
    Message,
    SteeringReport,
    Time,
    TurnIndicatorsCommand,
    TurnIndicatorsReport,
    VelocityReport,
)

__all__ = ["MESSAGE_IDS", "UnknownMessage", "decode_message", "encode_message", "payload_size"]

MESSAGE_IDS = MappingProxyType(
    {
        AgentOnline: 0x01,
        Clock: 0x02,
        AckermannControlCommand: 0x03,
        ControlModeRequest: 0x04,
        TurnIndicatorsCommand: 0x05,
        HazardLightsCommand: 0x06,
        AgentPing: 0x81,
        ControlModeReport: 0x83,
        ControlModeResponse: 0x84,
        TurnIndicatorsReport: 0x85,
        HazardLightsReport: 0x86,
        VelocityReport: 0x87,
        SteeringReport: 0x88,
    }
)
"""The id of each message; the board's have bit 7 set, and an answer or report that of its command besides."""

_CODES = {WireType.TIME: "iI", WireType.FLOAT32: "f", WireType.UINT8: "B", WireType.BOOL: "B"}
_OF_ID = {number: MESSAGES[kind] for kind, number in MESSAGE_IDS.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class UnknownMessage:
    """A message whose id nobody knows.

    Attributes:
        id: the first byte.
        body: what follows it.
    """

    id: int
    body: bytes = b""


def _layout(spec: MessageSpec) -> Struct:
    return Struct("<B" + "".join(_CODES[field.type] for field in spec.fields))


_LAYOUTS = {kind: _layout(spec) for kind, spec in MESSAGES.items()}


def payload_size(kind: type[Message]) -> int:
    """How many bytes the payload of a message has, its id included."""
    return _LAYOUTS[kind].size


def encode_message(message: Message | UnknownMessage) -> bytes:
    """The payload of a message.

    Raises:
        LocalProtocolError: a number does not fit its field.
    """
    if isinstance(message, UnknownMessage):
        if not 0 <= message.id <= 0xFF:
            raise LocalProtocolError(f"id {message.id} is not 0..255")
        return bytes((message.id,)) + message.body
    kind = type(message)
    values: list[int | float] = []
    for field in fields(message):
        value = getattr(message, field.name)
        values += (value.sec, value.nanosec) if isinstance(value, Time) else (value,)
    try:
        return _LAYOUTS[kind].pack(MESSAGE_IDS[kind], *values)
    except (struct.error, OverflowError) as error:
        raise LocalProtocolError(f"{message} does not fit the stand-in link: {error}") from None


def decode_message(payload: bytes) -> Message | UnknownMessage:
    """The message in a frame's payload.

    Raises:
        RemoteProtocolError: the payload is empty or has another size than its message, or a bool is neither 0 nor 1.
    """
    if not payload:
        raise RemoteProtocolError("an empty payload holds no message")
    spec = _OF_ID.get(payload[0])
    if spec is None:
        return UnknownMessage(id=payload[0], body=payload[1:])
    layout = _LAYOUTS[spec.kind]
    if len(payload) != layout.size:
        raise RemoteProtocolError(f"a payload of {spec.kind.__name__} has {layout.size} bytes, not {len(payload)}")
    numbers = iter(layout.unpack(payload)[1:])
    values: dict[str, object] = {}
    for field in spec.fields:
        number = next(numbers)
        if field.type is WireType.TIME:
            values[field.name] = Time(number, next(numbers))
        elif field.type is WireType.BOOL:
            values[field.name] = _truth(spec, field.name, number)
        else:
            values[field.name] = number
    return spec.kind(**values)  # type: ignore[arg-type]


def _truth(spec: MessageSpec, name: str, number: int) -> bool:
    if number > 1:
        raise RemoteProtocolError(f"{name} of {spec.kind.__name__} is {number}, neither 0 nor 1")
    return number == 1
