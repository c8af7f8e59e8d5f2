"""The agent with all its lines: a session at each, what the clients have created, and data from one to the others.

    agent = AgentService(("board", "host"))
    for line, data in agent.receive("board", data, now_ns):    # bytes that came; what is to be written, and where
        ports[line].write(data)
    agent.advance(now_ns)                                      # timers that are due, likewise
    when = agent.next_deadline_ns()                            # when to call advance at the latest
    agent.take_events()                                        # what has happened

What a client that does not read can make it keep is bounded: see `StreamOptions` and `AgentOptions`. As with `Session`,
no bytes can make it raise anything.

A request on a reliable stream is answered on the built-in reliable one, any other on the built-in best-effort one, as
with eProsima's agent (Micro-XRCE-DDS-Agent, Processor.cpp); data come on the stream that READ_DATA asks for. A request
of a service has the identity of its sample before it (24 bytes: GUID, number), which comes back before the reply; a
reply has the request's id and the requester's before it (Requester.cpp, Replier.cpp).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

from protocols.state_machine import earliest
from protocols.xrce.codes import BUILTIN_BEST_EFFORT, BUILTIN_RELIABLE, InfoMask, Status, is_reliable, with_kind
from protocols.xrce.descriptions import Profiles, Qos, TopicDescription
from protocols.xrce.entities import Entities, Entity
from protocols.xrce.errors import LocalProtocolError, StreamFullError
from protocols.xrce.events import Event, Received, SessionClosed, SessionOpened, Transmit
from protocols.xrce.objects import KIND_OF_OBJECT, DataReader, DataWriter, Replier, Requester
from protocols.xrce.options import AgentOptions
from protocols.xrce.reading import Reading
from protocols.xrce.service_events import (
    AgentEvent,
    ClientEvent,
    ObjectCreated,
    ObjectDeleted,
    RequestFailed,
    SampleRouted,
    SampleTooLong,
)
from protocols.xrce.session import Session
from protocols.xrce.space import DataSpace, Reader, SampleIdentity, StoredSample, Writer
from protocols.xrce.states import AgentState, Role
from protocols.xrce.submessages import (
    Create,
    DataReaderActivity,
    DataWriterActivity,
    Delete,
    GetInfo,
    Info,
    ReadData,
    StatusReply,
    Submessage,
    TopicData,
    WriteData,
)

__all__ = ["AgentService", "ServiceCounters", "Written"]

Written = list[tuple[str, bytes]]
"""Bytes to be written, each with its line."""

_GUID_BYTES, _IDENTITY_BYTES = 16, 24
_ERRORS_FROM = 0x80
_RELIABLE = Qos(reliable=True, durability=1)


@dataclass(slots=True, kw_only=True)
class ServiceCounters:
    """What an agent has done, since it was made.

    Attributes:
        routed: samples that came.
        delivered: samples that were handed to a client.
        undeliverable: samples that were too long for the stream they were wanted on.
        unanswered: answers that had no room on the client's stream.
        unreadable: samples that make no sense: in another format than plain data, or a reply to nothing.
    """

    routed: int = 0
    delivered: int = 0
    undeliverable: int = 0
    unanswered: int = 0
    unreadable: int = 0


@dataclass(slots=True)
class _Line:
    """What stands at a line: a session, what its client has created, and the stream that it is answered on now."""

    name: str
    session: Session
    entities: Entities | None = None
    answers_on: int = BUILTIN_RELIABLE


class AgentService:
    """See the module.

    Args:
        lines: their names.
        options: of every session, and of what is kept.

    Raises:
        LocalProtocolError: the references of the options make no sense.

    Attributes:
        sessions: by line.
        space: who writes and who reads; a program beside the agent may be one of them, see `writer` and `reader`.
        counters: what it has done.
    """

    def __init__(self, lines: Sequence[str], options: AgentOptions | None = None) -> None:
        self._options = options or AgentOptions()
        self._profiles = Profiles(self._options.references)
        self._lines = {name: _Line(name, Session(Role.AGENT, self._options)) for name in lines}
        self._events: list[AgentEvent] = []
        self._out: Written = []
        self._due_ns: int | None = None
        self._listeners: dict[int, tuple[Reader, Callable[[StoredSample], None]]] = {}
        self.sessions: Mapping[str, Session] = {name: line.session for name, line in self._lines.items()}
        self.space = DataSpace()
        self.counters = ServiceCounters()

    @property
    def held(self) -> int:
        """Bytes that are kept for clients; bounded."""
        there = (line.entities.held for line in self._lines.values() if line.entities)
        return sum(session.held for session in self.sessions.values()) + sum(there)

    @property
    def objects(self) -> Mapping[str, Mapping[int, Entity]]:
        """What the client at each line has created, by its id."""
        return {name: line.entities.by_id if line.entities else {} for name, line in self._lines.items()}

    # --- what a driver does

    def receive(self, line: str, data: bytes, now_ns: int) -> Written:
        """Takes bytes that came at a line; returns what is to be written, and where."""
        written: Written = []
        for events in self._lines[line].session.receive_each(data, now_ns):
            self._take(self._lines[line], events, now_ns)
            written += self._settle(now_ns)
        return written

    def advance(self, now_ns: int) -> Written:
        """Does what is due."""
        for line in self._lines.values():
            self._take(line, line.session.advance(now_ns), now_ns)
        return self._settle(now_ns)

    def line_down(self, line: str, now_ns: int) -> Written:
        """A line is gone, and with it its client and all that this has created."""
        self._take(self._lines[line], self._lines[line].session.line_down(now_ns), now_ns)
        return self._settle(now_ns)

    def next_deadline_ns(self) -> int | None:
        """When `advance` has something to do, in ns; None if nothing is waited for."""
        due_ns = self._due_ns
        for session in self.sessions.values():
            due_ns = earliest(due_ns, session.next_deadline_ns())
        return due_ns

    def take_events(self) -> list[AgentEvent]:
        """What has happened since the last call."""
        events, self._events = self._events, []
        return events

    # --- a program beside the agent

    def writer(self, topic: str, type_name: str, *, domain_id: int = 0, qos: Qos = _RELIABLE) -> Writer:
        """A writer for a program beside the agent; it writes by `write`, and leaves by `space.remove`."""
        options = self._options
        made = Writer(
            domain_id,
            TopicDescription(topic, type_name),
            qos,
            most=options.history,
            max_bytes=options.max_history_bytes,
        )
        self.space.add_writer(made)
        return made

    def write(self, writer: Writer, data: bytes, now_ns: int, *, identity: SampleIdentity | None = None) -> Written:
        """A program beside the agent writes a sample: CDR without a header, little-endian.

        A request of a service has an identity, by which its reply is known: `StoredSample.answers`.
        """
        self._route("", writer, StoredSample(data=data, identity=identity), now_ns)
        return self._settle(now_ns)

    def listen(
        self, topic: str, type_name: str, heard: Callable[[StoredSample], None], *, domain_id: int = 0
    ) -> Reader:
        """A reader for a program beside the agent: `heard` is called with each sample; it leaves by `silence`."""
        options = self._options
        made = Reader(
            domain_id,
            TopicDescription(topic, type_name),
            Qos(reliable=False),
            most=options.history,
            max_bytes=options.max_history_bytes,
        )
        self.space.add_reader(made)
        self._listeners[id(made)] = made, heard
        return made

    def silence(self, reader: Reader) -> None:
        """Ends what `listen` began."""
        del self._listeners[id(reader)]
        self.space.remove(reader)

    def hand(self, reader: Reader, sample: StoredSample, now_ns: int) -> Written:
        """Gives one reader a sample that comes from outside; see `DataSpace.outside`."""
        self._routed("", reader.domain_id, reader.topic.name, sample, int(reader.offer(sample)))
        return self._settle(now_ns)

    # --- what clients say

    def _take(self, line: _Line, events: Iterable[Event], now_ns: int) -> None:
        for event in events:
            match event:
                case Transmit():
                    self._out.append((line.name, event.data))
                    continue
                case Received():
                    line.answers_on = BUILTIN_RELIABLE if is_reliable(event.stream_id) else BUILTIN_BEST_EFFORT
                    self._answer(line, event.submessage, now_ns)
                    continue
                case SessionOpened():
                    self._begin(line, event.peer.client_key, now_ns)  # type: ignore[union-attr]
                case SessionClosed():
                    self._end(line)
            self._events.append(ClientEvent(line=line.name, what=type(event).__name__, event=event))

    def _begin(self, line: _Line, client_key: bytes, now_ns: int) -> None:
        """A session begins: of what its client had before, here or at another line, nothing is left."""
        self._end(line)
        for other in self._lines.values():
            if other.entities is not None and other.entities.client_key == client_key:
                self._take(other, other.session.disconnect(now_ns), now_ns)
        line.entities = Entities(client_key, self.space, self._profiles, self._options)

    def _end(self, line: _Line) -> None:
        if line.entities is not None:
            line.entities.clear()
            line.entities = None

    def _answer(self, line: _Line, said: Submessage, now_ns: int) -> None:
        entities = line.entities
        if entities is None:
            return
        match said:
            case Create():
                status = entities.create(said)
                if status is Status.OK:
                    made = entities.by_id[with_kind(said.object_id, KIND_OF_OBJECT[type(said.object)])]
                    self._events.append(_created(line.name, made))
                self._status(line, said, status, now_ns)
            case Delete():
                status = entities.delete(said.object_id)
                if status is Status.OK:
                    self._events.append(ObjectDeleted(line=line.name, object_id=said.object_id))
                self._status(line, said, status, now_ns)
            case GetInfo():
                self._say(line, _info(said, entities.by_id.get(said.object_id)), now_ns)
            case WriteData():
                self._write(line, said, entities.by_id.get(said.object_id), now_ns)
            case ReadData():
                self._read(line, said, entities.by_id.get(said.object_id), now_ns)
        self._events += entities.mismatches
        entities.mismatches.clear()

    def _write(self, line: _Line, said: WriteData, entity: Entity | None, now_ns: int) -> None:
        """WRITE_DATA; it is answered only where it fails."""
        if entity is None or entity.writer is None:
            self._status(line, said, Status.UNKNOWN_REFERENCE, now_ns)
            return
        sample = _sample_of(said, entity)
        if sample is None:
            self.counters.unreadable += 1
            self._status(line, said, Status.INVALID_DATA, now_ns)
            return
        self._route(line.name, entity.writer, sample, now_ns)

    def _route(self, line: str, writer: Writer, sample: StoredSample, now_ns: int) -> None:
        """Hands a sample on, as far as it is wanted at once: it must not be pushed out by the next one of a message."""
        reached = len(self.space.write(writer, sample))
        self._routed(line, writer.domain_id, writer.topic.name, sample, reached)
        self._deliver_all(now_ns)

    def _routed(self, line: str, domain_id: int, topic: str, sample: StoredSample, reached: int) -> None:
        self.counters.routed += 1
        size = len(sample.data)
        self._events.append(SampleRouted(line=line, domain_id=domain_id, topic=topic, size=size, readers=reached))

    def _read(self, line: _Line, said: ReadData, entity: Entity | None, now_ns: int) -> None:
        """READ_DATA; it is answered by data, and takes the place of the one before."""
        if entity is None or entity.reader is None:
            self._status(line, said, Status.UNKNOWN_REFERENCE, now_ns)
            return
        try:
            line.session.reserve(said.specification.stream_id)
        except LocalProtocolError:
            self._status(line, said, Status.RESOURCES, now_ns)
            return
        entity.reading = Reading(said, now_ns)
        self._deliver(line, entity, now_ns)

    def _status(self, line: _Line, said: Create | Delete | WriteData | ReadData, status: Status, now_ns: int) -> None:
        if status >= _ERRORS_FROM:
            self._events.append(
                RequestFailed(line=line.name, request_id=said.request_id, object_id=said.object_id, status=status)
            )
        self._say(line, StatusReply(request_id=said.request_id, object_id=said.object_id, status=status), now_ns)

    def _say(self, line: _Line, said: Submessage, now_ns: int) -> None:
        try:
            self._out.append((line.name, line.session.send(said, now_ns, stream_id=line.answers_on)))
        except LocalProtocolError:
            self.counters.unanswered += 1

    # --- data to clients

    def _settle(self, now_ns: int) -> Written:
        """Delivers what can be delivered; returns all that is to be written."""
        self._deliver_all(now_ns)
        out, self._out = self._out, []
        return [(name, data) for name, data in out if data]

    def _deliver_all(self, now_ns: int) -> None:
        self._due_ns = None
        for reader, heard in [*self._listeners.values()]:
            while reader.waiting:
                heard(reader.waiting.take())
        for line in self._lines.values():
            if line.entities is not None:
                for entity in line.entities.by_id.values():
                    self._deliver(line, entity, now_ns)

    def _deliver(self, line: _Line, entity: Entity, now_ns: int) -> None:
        """Hands over the samples that wait for a client, as far as it has asked for them and has room."""
        reader, reading = entity.reader, entity.reading
        if reader is None or reading is None or line.session.state is not AgentState.OPEN:
            return
        while reader.waiting:
            if reading.is_over(now_ns):
                entity.reading = None
                return
            if reading.next_ns > now_ns:
                self._due_ns = earliest(self._due_ns, reading.next_ns)
                return
            sample = next(iter(reader.waiting))
            data = _data_for(entity, sample)
            said = TopicData(
                request_id=reading.request_id,
                object_id=entity.object_id,
                data=data,
                little_endian=sample.little_endian,
            )
            try:
                self._out.append((line.name, line.session.send(said, now_ns, stream_id=reading.stream_id)))
            except StreamFullError:
                return  # until an ACKNACK makes room
            except LocalProtocolError:
                self.counters.undeliverable += 1
                self._events.append(
                    SampleTooLong(
                        line=line.name,
                        object_id=entity.object_id,
                        stream_id=reading.stream_id,
                        topic=reader.topic.name,
                        size=len(data),
                    )
                )
            else:
                self.counters.delivered += 1
                reading.delivered(len(data), now_ns)
            reader.waiting.take()


def _sample_of(said: WriteData, entity: Entity) -> StoredSample | None:
    """What a client has written; None if it makes no sense."""
    if not isinstance(said.data, bytes):
        return None
    assert entity.writer is not None
    match entity.object:
        case Requester():
            number = (entity.writer.written & 0xFFFF) << 16 | said.request_id
            identity = SampleIdentity(entity.guid, number)
            return StoredSample(data=said.data, little_endian=said.little_endian, identity=identity)
        case Replier():
            if len(said.data) < _IDENTITY_BYTES:
                return None
            head, data = said.data[:_IDENTITY_BYTES], said.data[_IDENTITY_BYTES:]
            answers = _identity_in(head, little_endian=said.little_endian)
            return StoredSample(data=data, little_endian=said.little_endian, answers=answers)
    return StoredSample(data=said.data, little_endian=said.little_endian)


def _data_for(entity: Entity, sample: StoredSample) -> bytes:
    """What a client reads: the sample, for a service with what it belongs to before it."""
    match entity.object:
        case Requester():
            assert sample.answers is not None
            request_id = sample.answers.number & 0xFFFF
            return request_id.to_bytes(2, "big") + entity.object_id.to_bytes(2, "big") + sample.data
        case Replier():
            identity = sample.identity or SampleIdentity(bytes(_GUID_BYTES), 0)
            return _identity_bytes(identity, little_endian=sample.little_endian) + sample.data
    return sample.data


def _identity_bytes(identity: SampleIdentity, *, little_endian: bool) -> bytes:
    """SampleIdentity: a GUID, the number's upper 32 bits, its lower 32 bits."""
    order = "little" if little_endian else "big"
    high, low = divmod(identity.number, 1 << 32)
    return identity.guid + high.to_bytes(4, order) + low.to_bytes(4, order)  # type: ignore[arg-type]


def _identity_in(data: bytes, *, little_endian: bool) -> SampleIdentity:
    order = "little" if little_endian else "big"
    high, low = (int.from_bytes(data[at : at + 4], order) for at in (16, 20))  # type: ignore[arg-type]
    return SampleIdentity(data[:_GUID_BYTES], high << 32 | low)


def _created(line: str, entity: Entity) -> ObjectCreated:
    end = entity.writer or entity.reader
    topic = entity.topic if end is None else end.topic
    named = {} if topic is None else {"topic": topic.name, "type_name": topic.type_name}
    return ObjectCreated(line=line, object_id=entity.object_id, kind=type(entity.object).__name__, **named)


def _info(said: GetInfo, entity: Entity | None) -> Info:
    """What GET_INFO is answered with: an object as its client has described it, and how far it has come."""
    if entity is None:
        return Info(request_id=said.request_id, object_id=said.object_id, status=Status.UNKNOWN_REFERENCE)
    activity: DataWriterActivity | DataReaderActivity | None = None
    if said.info_mask & InfoMask.ACTIVITY:
        if isinstance(entity.object, DataWriter) and entity.writer is not None:
            activity = DataWriterActivity(sample_sequence=entity.writer.written, stream_sequence=0)
        elif isinstance(entity.object, DataReader) and entity.reader is not None:
            activity = DataReaderActivity(highest_acked=entity.reader.received & 0x7FFF)
    config = entity.object if said.info_mask & InfoMask.CONFIGURATION else None
    return Info(request_id=said.request_id, object_id=said.object_id, config=config, activity=activity)
