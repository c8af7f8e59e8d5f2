"""The sixteen submessages, each a class, and how they stand on the line.

    id  flags  length low  length high  payload

Bit 0 of the flags says that numbers in the payload are little-endian; the length always is (OMG DDS-XRCE 1.0, 8.3.4).
What the other bits mean is in the fields: `Create.reuse` and `replace`, `Fragment.last`, the format of data.

Layouts are those of 8.3.5, with eProsima's differences, without which no client in use could be spoken to: STATUS_AGENT
has a result, and in INFO the configuration comes before the activity.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from protocols.xrce import wire
from protocols.xrce.codes import DataFormat, ObjectKind, Status, SubmessageId
from protocols.xrce.data import DATA_LAYOUTS, Data, format_of
from protocols.xrce.errors import LocalProtocolError, RemoteProtocolError
from protocols.xrce.objects import AGENT_LAYOUT, CLIENT_LAYOUT, OBJECT_LAYOUT, Agent, Client, Object
from protocols.xrce.wire import Either, Optional, Record, Sequence

__all__ = [
    "SUBMESSAGES",
    "AckNack",
    "AgentActivity",
    "Create",
    "CreateClient",
    "DataReaderActivity",
    "DataWriterActivity",
    "Delete",
    "DeliveryControl",
    "Fragment",
    "GetInfo",
    "Heartbeat",
    "Info",
    "LargeLocator",
    "MediumLocator",
    "RawSubmessage",
    "ReadData",
    "ReadSpecification",
    "Reset",
    "SmallLocator",
    "StatusAgent",
    "StatusReply",
    "Submessage",
    "TextLocator",
    "Time",
    "Timestamp",
    "TimestampReply",
    "TopicData",
    "WriteData",
    "decode_submessage",
    "encode_submessage",
    "split_submessages",
]

_LITTLE_ENDIAN, _REUSE, _REPLACE, _LAST_FRAGMENT = 0x01, 0x02, 0x04, 0x02
_FORMAT_BITS = 0x0E
_HAS_PROPERTIES_AT, _BYTES_WITHOUT_PROPERTIES = 13, 16
_HEADER_BYTES = 4
_LONGEST = 0xFFFF
_NS_PER_S = 1_000_000_000
_SIGN = 1 << 31


@dataclass(frozen=True, slots=True)
class Time:
    """A time: seconds since the epoch, -2^31..2^31-1, which begin anew then; and ns besides."""

    seconds: int = 0
    nanoseconds: int = 0

    @classmethod
    def of_ns(cls, ns: int) -> Time:
        """The time that is so many ns after the epoch."""
        seconds, nanoseconds = divmod(ns, _NS_PER_S)
        return cls((seconds + _SIGN) % (2 * _SIGN) - _SIGN, nanoseconds)

    @property
    def ns(self) -> int:
        """Since the epoch, in ns."""
        return self.seconds * _NS_PER_S + self.nanoseconds


@dataclass(frozen=True, slots=True, kw_only=True)
class CreateClient:
    """Client: begins a session."""

    client: Client


@dataclass(frozen=True, slots=True, kw_only=True)
class Create:
    """Client: creates an object; if there is one of this id, it is kept, replaced, or an error, as the flags say."""

    request_id: int
    object_id: int
    object: Object
    reuse: bool = False
    replace: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class GetInfo:
    """Client: asks for an object's configuration or activity; `info_mask` has bits of `InfoMask`."""

    request_id: int
    object_id: int
    info_mask: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Delete:
    """Client: deletes an object, or ends the session (`OBJECT_CLIENT`)."""

    request_id: int
    object_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusAgent:
    """Agent: the answer to CREATE_CLIENT."""

    status: Status
    implementation_status: int = 0
    agent: Agent


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusReply:
    """Agent: the answer to a request: STATUS."""

    request_id: int
    object_id: int
    status: Status
    implementation_status: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class SmallLocator:
    """An address of 2 bytes and a port, 0..255."""

    address: bytes
    port: int


@dataclass(frozen=True, slots=True, kw_only=True)
class MediumLocator:
    """An IPv4 address and a port."""

    address: bytes
    port: int


@dataclass(frozen=True, slots=True, kw_only=True)
class LargeLocator:
    """An IPv6 address and a port."""

    address: bytes
    port: int


@dataclass(frozen=True, slots=True, kw_only=True)
class TextLocator:
    """Any other address."""

    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentActivity:
    """Whether an agent takes clients (0 if not), and where it is reached."""

    availability: int = 1
    addresses: tuple[SmallLocator | MediumLocator | LargeLocator | TextLocator, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class DataReaderActivity:
    """What a reader's client has acknowledged."""

    highest_acked: int


@dataclass(frozen=True, slots=True, kw_only=True)
class DataWriterActivity:
    """How far a writer has come."""

    sample_sequence: int
    stream_sequence: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Info:
    """Agent: the answer to GET_INFO; to a ping, `implementation_status` is 1 if there is a session (eProsima)."""

    request_id: int
    object_id: int
    status: Status = Status.OK
    implementation_status: int = 0
    config: Object | None = None
    activity: AgentActivity | DataReaderActivity | DataWriterActivity | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class WriteData:
    """Client: data for a data writer, requester or replier; the byte order is that of the data, too."""

    request_id: int
    object_id: int
    data: Data
    little_endian: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class DeliveryControl:
    """How much a read brings: samples (65535 without limit), seconds, bytes per second, ms between two."""

    max_samples: int
    max_elapsed_s: int = 0
    max_bytes_per_s: int = 0
    min_pace_ms: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadSpecification:
    """What a read is to bring, and how: once if there is no delivery control."""

    stream_id: int
    format: DataFormat = DataFormat.DATA
    content_filter: str | None = None
    delivery: DeliveryControl | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ReadData:
    """Client: asks for data of a data reader, requester or replier."""

    request_id: int
    object_id: int
    specification: ReadSpecification


@dataclass(frozen=True, slots=True, kw_only=True)
class TopicData:
    """Agent: data of a data reader: DATA; the request is that of READ_DATA."""

    request_id: int
    object_id: int
    data: Data
    little_endian: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class AckNack:
    """What was received of a reliable stream.

    Attributes:
        first_unacked: all before this number have been received.
        nack_bitmap: bit i says that first_unacked + i is missing.
        stream_id: of the stream.
    """

    first_unacked: int
    nack_bitmap: int
    stream_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Heartbeat:
    """What is unacknowledged of a reliable stream: the first and the last number."""

    first_unacked: int
    last_unacked: int
    stream_id: int


@dataclass(frozen=True, slots=True)
class Reset:
    """Every stream of the session begins anew."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Fragment:
    """A piece of submessages that are too long for one message."""

    data: bytes
    last: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Timestamp:
    """Client: asks for the agent's time."""

    transmit: Time


@dataclass(frozen=True, slots=True, kw_only=True)
class TimestampReply:
    """Agent: when TIMESTAMP was sent (by the client's clock), came, and was answered."""

    transmit: Time
    receive: Time
    originate: Time


Submessage = (
    CreateClient
    | Create
    | GetInfo
    | Delete
    | StatusAgent
    | StatusReply
    | Info
    | WriteData
    | ReadData
    | TopicData
    | AckNack
    | Heartbeat
    | Reset
    | Fragment
    | Timestamp
    | TimestampReply
)

_REQUEST = {"request_id": wire.ID, "object_id": wire.ID}
_RESULT = {"status": wire.Named(wire.U8, Status), "implementation_status": wire.U8}
_TIME = Record(Time, seconds=wire.I32, nanoseconds=wire.U32)
_LOCATOR = Either(
    {
        0: Record(SmallLocator, address=wire.Octets(2), port=wire.U8),
        1: Record(MediumLocator, address=wire.Octets(4), port=wire.U16),
        2: Record(LargeLocator, address=wire.Octets(16), port=wire.U32),
        3: Record(TextLocator, text=wire.TEXT),
    }
)
_ACTIVITY = Either(
    {
        ObjectKind.AGENT: Record(AgentActivity, availability=wire.I16, addresses=Sequence(_LOCATOR)),
        ObjectKind.DATAREADER: Record(DataReaderActivity, highest_acked=wire.I16),
        ObjectKind.DATAWRITER: Record(DataWriterActivity, sample_sequence=wire.U64, stream_sequence=wire.I16),
    }
)
_SPECIFICATION = Record(
    ReadSpecification,
    stream_id=wire.U8,
    format=wire.Named(wire.U8, DataFormat),
    content_filter=Optional(wire.TEXT),
    delivery=Optional(
        Record(
            DeliveryControl,
            max_samples=wire.U16,
            max_elapsed_s=wire.U16,
            max_bytes_per_s=wire.U16,
            min_pace_ms=wire.U16,
        )
    ),
)

_I = SubmessageId
_LAYOUTS: Mapping[SubmessageId, Record] = {
    _I.CREATE_CLIENT: Record(CreateClient, client=CLIENT_LAYOUT),
    _I.CREATE: Record(Create, **_REQUEST, object=OBJECT_LAYOUT),
    _I.GET_INFO: Record(GetInfo, **_REQUEST, info_mask=wire.U32),
    _I.DELETE: Record(Delete, **_REQUEST),
    _I.STATUS_AGENT: Record(StatusAgent, **_RESULT, agent=AGENT_LAYOUT),
    _I.STATUS: Record(StatusReply, **_REQUEST, **_RESULT),
    _I.INFO: Record(Info, **_REQUEST, **_RESULT, config=Optional(OBJECT_LAYOUT), activity=Optional(_ACTIVITY)),
    _I.WRITE_DATA: Record(WriteData, **_REQUEST),
    _I.READ_DATA: Record(ReadData, **_REQUEST, specification=_SPECIFICATION),
    _I.DATA: Record(TopicData, **_REQUEST),
    _I.ACKNACK: Record(AckNack, first_unacked=wire.U16, nack_bitmap=wire.ID, stream_id=wire.U8),
    _I.HEARTBEAT: Record(Heartbeat, first_unacked=wire.U16, last_unacked=wire.U16, stream_id=wire.U8),
    _I.RESET: Record(Reset),
    _I.FRAGMENT: Record(Fragment, data=wire.REST),
    _I.TIMESTAMP: Record(Timestamp, transmit=_TIME),
    _I.TIMESTAMP_REPLY: Record(TimestampReply, transmit=_TIME, receive=_TIME, originate=_TIME),
}

SUBMESSAGES: Mapping[type, SubmessageId] = MappingProxyType({record.kind: one for one, record in _LAYOUTS.items()})
"""The id of each class."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RawSubmessage:
    """A submessage whose payload has not been read; `id` may be one that nobody knows."""

    id: int
    flags: int
    payload: bytes


def encode_submessage(submessage: Submessage | RawSubmessage, *, little_endian: bool = True) -> bytes:
    """A submessage, header and all; the padding that may have to follow it is not part of it.

    WRITE_DATA and DATA have a byte order of their own. Those longer than the length field can say have length 0 there,
    as eProsima's send them in fragments (write_access.c, UCLIENT_TWEAK_XRCE_WRITE_LIMIT).

    Raises:
        LocalProtocolError: something does not fit its field.
    """
    if isinstance(submessage, RawSubmessage):
        return _with_header(submessage.id, submessage.flags, submessage.payload)
    if isinstance(submessage, WriteData | TopicData):
        little_endian = submessage.little_endian
    number = SUBMESSAGES[type(submessage)]
    out = wire.payload_writer(little_endian=little_endian)
    _LAYOUTS[number].write(out, submessage)
    if isinstance(submessage, WriteData | TopicData):
        DATA_LAYOUTS[format_of(submessage.data)].write(out, submessage.data)
    return _with_header(number, _LITTLE_ENDIAN * little_endian | _flags_of(submessage), out.data)


def decode_submessage(raw: RawSubmessage) -> Submessage:
    """What a submessage says.

    Raises:
        RemoteProtocolError: its id is unknown, or its payload makes no sense.
    """
    record = _LAYOUTS.get(raw.id)  # type: ignore[call-overload]
    if record is None:
        raise RemoteProtocolError(f"{raw.id} is no submessage")
    little_endian = bool(raw.flags & _LITTLE_ENDIAN)
    data = wire.payload_reader(raw.payload, little_endian=little_endian)
    fields: dict[str, Any] = record.fields(data)
    match raw.id:
        case SubmessageId.CREATE:
            fields |= {"reuse": bool(raw.flags & _REUSE), "replace": bool(raw.flags & _REPLACE)}
        case SubmessageId.FRAGMENT:
            fields["last"] = bool(raw.flags & _LAST_FRAGMENT)
        case SubmessageId.WRITE_DATA | SubmessageId.DATA:
            layout = DATA_LAYOUTS.get(raw.flags & _FORMAT_BITS)  # type: ignore[call-overload]
            if layout is None:
                raise RemoteProtocolError(f"{raw.flags & _FORMAT_BITS:#x} is no format of data")
            fields |= {"data": layout.read(data), "little_endian": little_endian}
    return record.kind(**fields)  # type: ignore[no-any-return]


def split_submessages(data: bytes) -> Iterator[RawSubmessage]:
    """Yields the submessages in a message behind its header, or in fragments put together.

    Each begins at a multiple of 4; up to 3 bytes behind the last are padding. WRITE_DATA and DATA of length 0 are all
    that is left, and so is CREATE_CLIENT with properties but a length without them, as eProsima's client has it
    (session_info_internal.h, CREATE_CLIENT_PAYLOAD_SIZE).

    Raises:
        RemoteProtocolError: one ends behind the end of the message; those before it have been yielded.
    """
    at = 0
    while at + _HEADER_BYTES <= len(data):
        number, flags, length = data[at], data[at + 1], int.from_bytes(data[at + 2 : at + _HEADER_BYTES], "little")
        at += _HEADER_BYTES
        if _takes_all(number, length, data[at:]):
            length = len(data) - at
        if at + length > len(data):
            raise RemoteProtocolError(f"submessage {number} of {length} bytes where {len(data) - at} are left")
        yield RawSubmessage(id=number, flags=flags, payload=data[at : at + length])
        at += length + -length % _HEADER_BYTES


def _takes_all(number: int, length: int, rest: bytes) -> bool:
    """A submessage whose length does not say how long it is."""
    if number == SubmessageId.CREATE_CLIENT:
        has_properties = rest[_HAS_PROPERTIES_AT : _HAS_PROPERTIES_AT + 1] == b"\1"
        return has_properties and length == _BYTES_WITHOUT_PROPERTIES
    return not length and number in (SubmessageId.WRITE_DATA, SubmessageId.DATA)


def _flags_of(submessage: Submessage) -> int:
    match submessage:
        case Create(reuse=reuse, replace=replace):
            return _REUSE * reuse | _REPLACE * replace
        case Fragment(last=last):
            return _LAST_FRAGMENT * last
        case WriteData(data=data) | TopicData(data=data):
            return format_of(data)
    return 0


def _with_header(number: int, flags: int, payload: bytes) -> bytes:
    length = len(payload)
    if length > _LONGEST:
        if number not in (SubmessageId.WRITE_DATA, SubmessageId.DATA):
            raise LocalProtocolError(f"a submessage of {length} bytes is longer than {_LONGEST}")
        length = 0
    return bytes((number, flags)) + length.to_bytes(2, "little") + payload
