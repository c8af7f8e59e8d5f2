"""What a client asks an agent to create: objects of each kind, by reference, in XML or in binary.

An object has a `representation`, which is `ByReference` (a name in the agent's configuration), `AsXml` (a text as
there) or the kind's own class in binary, and the id of the object that it belongs to.

Layouts are those of OMG DDS-XRCE 1.0, 7.7 and dds_xrce_types.idl. In binary they are eProsima's where these differ, as
micro-ROS sends them: a topic has the name of its type instead of a TypeIdentifier, writer and reader have their topic's
object id instead of its name; requesters and repliers are not in the specification at all
(Micro-XRCE-DDS-Client, include/uxr/client/core/type/xrce_types.h).
"""

from __future__ import annotations

from dataclasses import dataclass
from types import MappingProxyType

from protocols.xrce import wire
from protocols.xrce.codes import COOKIE, VENDOR_EPROSIMA, VERSION, ObjectKind, QosFlag
from protocols.xrce.wire import Either, Embedded, Optional, Record, Sequence

__all__ = [
    "AGENT_LAYOUT",
    "CLIENT_LAYOUT",
    "KIND_OF_OBJECT",
    "OBJECT_LAYOUT",
    "Agent",
    "Application",
    "AsXml",
    "ByReference",
    "Client",
    "DataReader",
    "DataReaderBinary",
    "DataReaderQos",
    "DataWriter",
    "DataWriterBinary",
    "DataWriterQos",
    "GroupQos",
    "Object",
    "Participant",
    "ParticipantBinary",
    "Properties",
    "Publisher",
    "PublisherBinary",
    "QosProfile",
    "Replier",
    "ReplierBinary",
    "Requester",
    "RequesterBinary",
    "Subscriber",
    "SubscriberBinary",
    "Topic",
    "TopicBinary",
    "Type",
]

Properties = tuple[tuple[str, str], ...]
"""Names and values."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ByReference:
    """The name of something in the agent's configuration."""

    name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class AsXml:
    """What would stand in the agent's configuration."""

    text: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticipantBinary:
    """A participant; its domain is that of `Participant`."""

    domain_reference: str | None = None
    qos_profile_reference: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class TopicBinary:
    """A topic, as ``rt/chatter`` of ``std_msgs::msg::dds_::String_``."""

    topic_name: str
    type_reference: str | None = None
    type_name: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class GroupQos:
    """Quality of service of a publisher or subscriber."""

    partitions: tuple[str, ...] | None = None
    group_data: bytes | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class PublisherBinary:
    """A publisher."""

    name: str | None = None
    qos: GroupQos | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class SubscriberBinary:
    """A subscriber."""

    name: str | None = None
    qos: GroupQos | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class DataWriterQos:
    """Quality of service of a data writer; times in ms, None where the default holds."""

    flags: int = QosFlag.RELIABLE
    history_depth: int | None = None
    deadline_ms: int | None = None
    lifespan_ms: int | None = None
    user_data: bytes | None = None
    ownership_strength: int | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class DataReaderQos:
    """Quality of service of a data reader; times in ms, None where the default holds."""

    flags: int = QosFlag.RELIABLE
    history_depth: int | None = None
    deadline_ms: int | None = None
    lifespan_ms: int | None = None
    user_data: bytes | None = None
    time_based_filter_ms: int | None = None
    content_based_filter: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class DataWriterBinary:
    """A data writer of a topic."""

    topic_id: int
    qos: DataWriterQos | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class DataReaderBinary:
    """A data reader of a topic."""

    topic_id: int
    qos: DataReaderQos | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class RequesterBinary:
    """The asking end of a service."""

    service_name: str
    request_type: str
    reply_type: str
    request_topic_name: str | None = None
    reply_topic_name: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class ReplierBinary:
    """The answering end of a service."""

    service_name: str
    request_type: str
    reply_type: str
    request_topic_name: str | None = None
    reply_topic_name: str | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Participant:
    """A participant of a DDS domain, -32768..32767."""

    representation: ByReference | AsXml | ParticipantBinary
    domain_id: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Topic:
    """A topic of a participant."""

    representation: ByReference | AsXml | TopicBinary
    participant_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Publisher:
    """A publisher of a participant."""

    representation: ByReference | AsXml | PublisherBinary
    participant_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Subscriber:
    """A subscriber of a participant."""

    representation: ByReference | AsXml | SubscriberBinary
    participant_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class DataWriter:
    """A data writer of a publisher."""

    representation: ByReference | AsXml | DataWriterBinary
    publisher_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class DataReader:
    """A data reader of a subscriber."""

    representation: ByReference | AsXml | DataReaderBinary
    subscriber_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Requester:
    """A requester of a participant."""

    representation: ByReference | AsXml | RequesterBinary
    participant_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Replier:
    """A replier of a participant."""

    representation: ByReference | AsXml | ReplierBinary
    participant_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Type:
    """A type of data."""

    representation: ByReference | AsXml


@dataclass(frozen=True, slots=True, kw_only=True)
class QosProfile:
    """A profile of qualities of service."""

    representation: ByReference | AsXml


@dataclass(frozen=True, slots=True, kw_only=True)
class Application:
    """A whole application."""

    representation: ByReference | AsXml


@dataclass(frozen=True, slots=True, kw_only=True)
class Agent:
    """What an agent says of itself."""

    cookie: bytes = COOKIE
    version: bytes = VERSION
    vendor_id: bytes = VENDOR_EPROSIMA
    properties: Properties | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Client:
    """What a client says of itself.

    Attributes:
        client_key: 4 bytes.
        session_id: of the session that it wants.
        mtu: the longest message that it takes, in bytes. The specification has none, eProsima's clients send it.
    """

    client_key: bytes
    session_id: int
    cookie: bytes = COOKIE
    version: bytes = VERSION
    vendor_id: bytes = VENDOR_EPROSIMA
    properties: Properties | None = None
    mtu: int | None = None


Object = (
    Participant
    | Topic
    | Publisher
    | Subscriber
    | DataWriter
    | DataReader
    | Requester
    | Replier
    | Type
    | QosProfile
    | Application
    | Agent
    | Client
)

_PROPERTIES = Optional(Sequence(wire.Pair(wire.TEXT, wire.TEXT)))
_HEAD = {"cookie": wire.Octets(4), "version": wire.Octets(2), "vendor_id": wire.Octets(2)}
AGENT_LAYOUT = Record(Agent, **_HEAD, properties=_PROPERTIES)
CLIENT_LAYOUT = Record(
    Client,
    **_HEAD,
    client_key=wire.Octets(4),
    session_id=wire.U8,
    properties=_PROPERTIES,
    mtu=wire.IfLeft(wire.U16),
)

_MAYBE_TEXT, _MAYBE_U32, _MAYBE_BLOB = Optional(wire.TEXT), Optional(wire.U32), Optional(wire.BLOB)
_GROUP = {
    "name": _MAYBE_TEXT,
    "qos": Optional(Record(GroupQos, partitions=Optional(Sequence(wire.TEXT)), group_data=_MAYBE_BLOB)),
}
_ENDPOINT = {
    "flags": wire.U16,
    "history_depth": Optional(wire.U16),
    "deadline_ms": _MAYBE_U32,
    "lifespan_ms": _MAYBE_U32,
    "user_data": _MAYBE_BLOB,
}
_WRITER_QOS = Record(DataWriterQos, **_ENDPOINT, ownership_strength=_MAYBE_U32)
_READER_QOS = Record(DataReaderQos, **_ENDPOINT, time_based_filter_ms=_MAYBE_U32, content_based_filter=_MAYBE_TEXT)
_SERVICE = {
    "service_name": wire.TEXT,
    "request_type": wire.TEXT,
    "reply_type": wire.TEXT,
    "request_topic_name": _MAYBE_TEXT,
    "reply_topic_name": _MAYBE_TEXT,
}


def _representation(binary: Record | None = None) -> Either:
    """By reference or in XML, and in binary where the kind has one."""
    cases: dict[int, wire.Codec] = {1: Record(ByReference, name=wire.TEXT), 2: Record(AsXml, text=wire.TEXT)}
    return Either(cases | ({3: Embedded(binary)} if binary else {}))


_LAYOUTS = {
    ObjectKind.PARTICIPANT: Record(
        Participant,
        representation=_representation(
            Record(ParticipantBinary, domain_reference=_MAYBE_TEXT, qos_profile_reference=_MAYBE_TEXT)
        ),
        domain_id=wire.I16,
    ),
    ObjectKind.TOPIC: Record(
        Topic,
        representation=_representation(
            Record(TopicBinary, topic_name=wire.TEXT, type_reference=_MAYBE_TEXT, type_name=_MAYBE_TEXT)
        ),
        participant_id=wire.ID,
    ),
    ObjectKind.PUBLISHER: Record(
        Publisher, representation=_representation(Record(PublisherBinary, **_GROUP)), participant_id=wire.ID
    ),
    ObjectKind.SUBSCRIBER: Record(
        Subscriber, representation=_representation(Record(SubscriberBinary, **_GROUP)), participant_id=wire.ID
    ),
    ObjectKind.DATAWRITER: Record(
        DataWriter,
        representation=_representation(Record(DataWriterBinary, topic_id=wire.ID, qos=Optional(_WRITER_QOS))),
        publisher_id=wire.ID,
    ),
    ObjectKind.DATAREADER: Record(
        DataReader,
        representation=_representation(Record(DataReaderBinary, topic_id=wire.ID, qos=Optional(_READER_QOS))),
        subscriber_id=wire.ID,
    ),
    ObjectKind.REQUESTER: Record(
        Requester, representation=_representation(Record(RequesterBinary, **_SERVICE)), participant_id=wire.ID
    ),
    ObjectKind.REPLIER: Record(
        Replier, representation=_representation(Record(ReplierBinary, **_SERVICE)), participant_id=wire.ID
    ),
    ObjectKind.TYPE: Record(Type, representation=_representation()),
    ObjectKind.QOSPROFILE: Record(QosProfile, representation=_representation()),
    ObjectKind.APPLICATION: Record(Application, representation=_representation()),
    ObjectKind.AGENT: AGENT_LAYOUT,
    ObjectKind.CLIENT: CLIENT_LAYOUT,
}

OBJECT_LAYOUT = Either(_LAYOUTS)
KIND_OF_OBJECT = MappingProxyType({layout.kind: kind for kind, layout in _LAYOUTS.items()})
"""The kind of each class of object."""
