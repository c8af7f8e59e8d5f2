"""What one client has created at its agent, and what its requests to create and delete lead to.

Results are those of OMG DDS-XRCE 1.0, 7.8.3.2: an object of an id that is there already is an error, kept (`reuse`, if
it is the same) or replaced. What an object belongs to has to be there; with it goes all that belongs to it. The kind in
an id is that of what is meant, whatever a client writes there (7.8.3.1; Micro-XRCE-DDS-Agent, ProxyClient.cpp).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from protocols.xrce.codes import ObjectKind, Status, with_kind
from protocols.xrce.descriptions import (
    EndpointDescription,
    Profiles,
    Qos,
    ServiceDescription,
    TopicDescription,
    UnknownProfileError,
    reader_qos,
    writer_qos,
)
from protocols.xrce.errors import RemoteProtocolError
from protocols.xrce.objects import (
    KIND_OF_OBJECT,
    OBJECT_LAYOUT,
    DataReader,
    DataReaderBinary,
    DataWriter,
    DataWriterBinary,
    Object,
    Participant,
    ParticipantBinary,
    Publisher,
    Replier,
    Requester,
    Subscriber,
    Topic,
)
from protocols.xrce.options import AgentOptions
from protocols.xrce.reading import Reading
from protocols.xrce.space import DataSpace, Reader, Writer
from protocols.xrce.submessages import Create
from protocols.xrce.wire import payload_writer

__all__ = ["Entities", "Entity", "Mismatch"]

_SERVICE_QOS = Qos(reliable=True)
_K = ObjectKind
_PARENTS: Mapping[type, tuple[ObjectKind, ...]] = MappingProxyType(
    {
        Topic: (_K.PARTICIPANT,),
        Publisher: (_K.PARTICIPANT,),
        Subscriber: (_K.PARTICIPANT,),
        Requester: (_K.PARTICIPANT,),
        Replier: (_K.PARTICIPANT,),
        DataWriter: (_K.PUBLISHER, _K.TOPIC),
        DataReader: (_K.SUBSCRIBER, _K.TOPIC),
    }
)
"""What an object belongs to; a writer or reader in XML names its topic itself."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mismatch:
    """A writer and a reader of one topic that cannot speak to each other.

    Attributes:
        domain_id: of both.
        topic: its name.
        why: in words.
    """

    domain_id: int
    topic: str
    why: str


@dataclass(slots=True, kw_only=True)
class Entity:
    """An object that a client has created.

    Attributes:
        object_id: its id.
        object: as the client has described it.
        size: of this description in binary, in bytes.
        domain_id: of its participant.
        parents: the ids of the objects that it goes with.
        topic: what a topic is.
        writer: what it writes by.
        reader: what it reads by.
        reading: what its client has asked for last.
        guid: of a requester or replier.
    """

    object_id: int
    object: Object
    size: int = 0
    domain_id: int = 0
    parents: tuple[int, ...] = ()
    topic: TopicDescription | None = None
    writer: Writer | None = None
    reader: Reader | None = None
    reading: Reading | None = None
    guid: bytes = b""


@dataclass(slots=True)
class Entities:
    """See the module.

    Attributes:
        client_key: of the client.
        space: where its writers and readers stand.
        profiles: what its references mean.
        options: of the agent.
        by_id: all that there is.
        mismatches: what has been found since somebody looked.
    """

    client_key: bytes
    space: DataSpace
    profiles: Profiles
    options: AgentOptions
    by_id: dict[int, Entity] = field(default_factory=dict)
    mismatches: list[Mismatch] = field(default_factory=list)

    def create(self, said: Create) -> Status:
        """Does what CREATE asks for; returns what it is answered with."""
        object_id = with_kind(said.object_id, KIND_OF_OBJECT[type(said.object)])
        there = self.by_id.get(object_id)
        if there is not None:
            if said.reuse and there.object == said.object:
                return Status.OK_MATCHED
            if not said.replace:
                return Status.MISMATCH if said.reuse else Status.ALREADY_EXISTS
        elif len(self.by_id) >= self.options.max_objects:
            return Status.RESOURCES
        try:
            made = self._make(object_id, said.object)
        except UnknownProfileError:
            return Status.UNKNOWN_REFERENCE
        except RemoteProtocolError:
            return Status.INVALID_DATA
        if made is None:
            return Status.DENIED
        if any(parent not in self.by_id for parent in made.parents):
            return Status.UNKNOWN_REFERENCE
        self.delete(object_id)
        made.size = _size(said.object)
        self.by_id[object_id] = made
        self._enter(made)
        return Status.OK

    def delete(self, object_id: int) -> Status:
        """Deletes an object and all that belongs to it; returns what DELETE is answered with."""
        gone = self.by_id.pop(object_id, None)
        if gone is None:
            return Status.UNKNOWN_REFERENCE
        for one in (gone.writer, gone.reader):
            if one is not None:
                self.space.remove(one)
        for child in [one.object_id for one in self.by_id.values() if object_id in one.parents]:
            self.delete(child)
        return Status.OK

    def clear(self) -> None:
        """Deletes everything."""
        for object_id in [*self.by_id]:
            self.delete(object_id)

    @property
    def held(self) -> int:
        """Bytes of what the client has described, and of the samples that wait for it, or for later readers."""
        stores = [one.reader.waiting for one in self.by_id.values() if one.reader]
        stores += [one.writer.kept for one in self.by_id.values() if one.writer]
        return sum(one.held for one in stores) + sum(one.size for one in self.by_id.values())

    def _make(self, object_id: int, said: Object) -> Entity | None:
        """The object, not in its place yet; None of a kind that an agent does not create.

        Raises:
            RemoteProtocolError: it makes no sense.
        """
        match said:
            case Participant():
                if not isinstance(said.representation, ParticipantBinary):
                    self.profiles.check_participant(said.representation)
                return Entity(object_id=object_id, object=said, domain_id=said.domain_id)
            case Topic():
                made = self._child(object_id, said, said.participant_id)
                made.topic = self.profiles.topic(said.representation)
                return made
            case Publisher() | Subscriber():
                return self._child(object_id, said, said.participant_id)
            case DataWriter():
                return self._data_writer(object_id, said)
            case DataReader():
                return self._data_reader(object_id, said)
            case Requester() | Replier():
                return self._service(object_id, said)
        return None

    def _child(self, object_id: int, said: Object, *parents: int) -> Entity:
        ids = tuple(with_kind(one, kind) for one, kind in zip(parents, _PARENTS[type(said)], strict=False))
        there = self.by_id.get(ids[0])
        return Entity(object_id=object_id, object=said, parents=ids, domain_id=0 if there is None else there.domain_id)

    def _data_writer(self, object_id: int, said: DataWriter) -> Entity:
        asked = said.representation
        if isinstance(asked, DataWriterBinary):
            made = self._child(object_id, said, said.publisher_id, asked.topic_id)
            topic, qos = self._topic_of(asked.topic_id), writer_qos(asked.qos)
        else:
            made = self._child(object_id, said, said.publisher_id)
            topic, qos = _both(self.profiles.writer(asked))
        made.writer = None if topic is None else self._writer(made, topic, qos)
        return made

    def _data_reader(self, object_id: int, said: DataReader) -> Entity:
        asked = said.representation
        if isinstance(asked, DataReaderBinary):
            made = self._child(object_id, said, said.subscriber_id, asked.topic_id)
            topic, qos = self._topic_of(asked.topic_id), reader_qos(asked.qos)
        else:
            made = self._child(object_id, said, said.subscriber_id)
            topic, qos = _both(self.profiles.reader(asked))
        made.reader = None if topic is None else self._reader(made, topic, qos)
        return made

    def _service(self, object_id: int, said: Requester | Replier) -> Entity:
        made = self._child(object_id, said, said.participant_id)
        made.guid = b"\x01\x0f" + self.client_key + bytes(8) + object_id.to_bytes(2, "big")
        asks = isinstance(said, Requester)
        found: ServiceDescription = self.profiles.service("requester" if asks else "replier", said.representation)
        made.writer = self._writer(made, found.request if asks else found.reply, _SERVICE_QOS)
        made.reader = self._reader(
            made, found.reply if asks else found.request, _SERVICE_QOS, made.guid if asks else None
        )
        return made

    def _topic_of(self, object_id: int) -> TopicDescription | None:
        there = self.by_id.get(with_kind(object_id, ObjectKind.TOPIC))
        return None if there is None else there.topic

    def _writer(self, made: Entity, topic: TopicDescription, qos: Qos) -> Writer:
        options = self.options
        return Writer(made.domain_id, topic, qos, most=options.history, max_bytes=options.max_history_bytes)

    def _reader(self, made: Entity, topic: TopicDescription, qos: Qos, guid: bytes | None = None) -> Reader:
        options = self.options
        return Reader(made.domain_id, topic, qos, most=options.history, max_bytes=options.max_history_bytes, guid=guid)

    def _enter(self, made: Entity) -> None:
        """Puts its writer and reader into the data space."""
        if made.writer is not None:
            for reader in self.space.add_writer(made.writer):
                self.mismatches.append(_mismatch(made.writer, reader))
        if made.reader is not None:
            for writer in self.space.add_reader(made.reader):
                self.mismatches.append(_mismatch(writer, made.reader))


def _size(described: Object) -> int:
    out = payload_writer(little_endian=True)
    OBJECT_LAYOUT.write(out, described)
    return len(out.data)


def _both(found: EndpointDescription) -> tuple[TopicDescription | None, Qos]:
    return found.topic, found.qos


def _mismatch(writer: Writer, reader: Reader) -> Mismatch:
    if writer.topic != reader.topic:
        why = f"the writer's type is {writer.topic.type_name}, the reader's {reader.topic.type_name}"
    elif writer.qos.reliable < reader.qos.reliable:
        why = "the reader wants a reliable writer, and the writer is best-effort"
    else:
        why = "the reader wants samples from before its time, and the writer keeps none, or not as long"
    return Mismatch(domain_id=reader.domain_id, topic=reader.topic.name, why=why)
