"""The checker as a client of an agent: says what a case wants, acknowledges what comes, and has no opinion about it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

from hilbench.bench.protocol_peer import ProtocolPeer
from protocols import xrce
from protocols.xrce.decoding import Message

__all__ = [
    "KEY",
    "PARTICIPANT",
    "PUBLISHER",
    "READER",
    "SUBSCRIBER",
    "TOPIC",
    "WRITER",
    "Board",
    "objects",
    "xml_objects",
]

SaidT = TypeVar("SaidT")

KEY = b"\x48\x42\x00\x01"
ANSWER_S = 0.2
DATA_S = 0.5

PARTICIPANT, TOPIC, PUBLISHER, SUBSCRIBER, WRITER, READER = 0xF11, 0xF12, 0xF13, 0xF14, 0xF15, 0xF16
_NAME, _TYPE = "rt/hilbench/check", "std_msgs::msg::dds_::Float32_"
_ENDPOINT_XML = (
    f"<dds><{{0}}><qos><reliability><kind>RELIABLE</kind></reliability></qos><topic><kind>NO_KEY</kind><name>{_NAME}</name>"
    f"<dataType>{_TYPE}</dataType></topic></{{0}}></dds>"
)


class Board:
    """A client at the checker's end of the line.

    Args:
        peer: that end.
        session_id: of its session.
    """

    def __init__(self, peer: ProtocolPeer, session_id: int = 0x81) -> None:
        self.peer = peer
        self.session_id = session_id
        self.acknowledges = True
        self._mark = 0
        self._numbers: dict[int, int] = {}
        self._request_id = 9

    def header(self, stream_id: int = 0, sequence: int = 0) -> xrce.Header:
        """The header of a message of the session."""
        key = KEY if xrce.has_client_key(self.session_id) else None
        return xrce.Header(session_id=self.session_id, stream_id=stream_id, sequence=sequence, client_key=key)

    def write(self, header: xrce.Header, *said: Any) -> None:
        """Put a message on the line; from it on answers count."""
        self._mark = self.peer.mark()
        self.peer.send(Message(header=header, submessages=said))

    def say(self, *said: Any, stream_id: int = 0x80) -> None:
        """Say submessages with the next number of a stream."""
        number = self._numbers.get(stream_id, 0) if stream_id else 0
        self._numbers[stream_id] = number + 1
        self.write(self.header(stream_id, number), *said)

    def hear(
        self, kind: type[SaidT], within_s: float = ANSWER_S, *, where: Callable[[SaidT], bool] = lambda _said: True
    ) -> tuple[xrce.Header, SaidT]:
        """Wait for a submessage; what came on reliable streams meanwhile is acknowledged.

        Raises:
            Untimely: it does not come.
        """

        def fits(message: Message) -> bool:
            return any(isinstance(one, kind) and where(one) for one in message.submessages)

        message = self.peer.expect(Message, within_s, where=fits, what=kind.__name__, mark=self._mark)
        heard = next(one for one in message.submessages if isinstance(one, kind) and where(one))
        if self.acknowledges and xrce.is_reliable(message.header.stream_id):
            first = xrce.after(message.header.sequence)
            said = xrce.AckNack(first_unacked=first, nack_bitmap=0, stream_id=message.header.stream_id)
            self.peer.send(Message(header=self.header(), submessages=(said,)))
        return message.header, heard

    def heard(self, kind: type[SaidT], for_s: float = DATA_S) -> list[SaidT]:
        """Let time pass; return the submessages of a kind since the last message of our own."""
        self.peer.run(for_s)
        found = self.peer.since(self._mark, Message)
        return [one for _, message in found for one in message.submessages if isinstance(one, kind)]

    def connect(self, client: xrce.Client | None = None) -> tuple[xrce.Header, xrce.StatusAgent]:
        """Ask for a session; the answer."""
        self._numbers.clear()
        key = KEY if xrce.has_client_key(self.session_id) else None
        outside = xrce.Header(session_id=self.session_id & 0x80, client_key=key)
        asked = client or xrce.Client(client_key=KEY, session_id=self.session_id, mtu=512)
        self.write(outside, xrce.CreateClient(client=asked))
        return self.hear(xrce.StatusAgent)

    def request_id(self) -> int:
        """A new one."""
        self._request_id += 1
        return self._request_id

    def create(self, object_id: int, made: Any, *, stream_id: int = 0x80, **flags: bool) -> xrce.Status:
        """Ask for an object; the status of the answer."""
        request_id = self.request_id()
        self.say(xrce.Create(request_id=request_id, object_id=object_id, object=made, **flags), stream_id=stream_id)
        return self._status(request_id, object_id)

    def delete(self, object_id: int) -> xrce.Status:
        """Ask that an object be deleted; the status of the answer."""
        request_id = self.request_id()
        self.say(xrce.Delete(request_id=request_id, object_id=object_id))
        return self._status(request_id, object_id)

    def begin(self) -> None:
        """Begin a session and create one object of each kind."""
        self.connect()
        for object_id, made in objects().items():
            self.create(object_id, made)

    def read(self, most: int = xrce.UNLIMITED, *, stream_id: int = 0x80) -> int:
        """Ask for samples; the id of the request."""
        request_id = self.request_id()
        control = xrce.DeliveryControl(max_samples=most)
        specification = xrce.ReadSpecification(stream_id=stream_id, delivery=control)
        self.say(xrce.ReadData(request_id=request_id, object_id=READER, specification=specification))
        return request_id

    def sample(self, data: bytes) -> xrce.WriteData:
        """A sample of the data writer."""
        return xrce.WriteData(request_id=self.request_id(), object_id=WRITER, data=data)

    def _status(self, request_id: int, object_id: int) -> xrce.Status:
        def fits(said: xrce.StatusReply) -> bool:
            return (said.request_id, said.object_id) == (request_id, object_id)

        return self.hear(xrce.StatusReply, where=fits)[1].status


def objects() -> dict[int, Any]:
    """One of each kind, in binary, in an order in which they can be created."""
    named = xrce.TopicBinary(topic_name=_NAME, type_name=_TYPE)
    there = {"participant_id": PARTICIPANT}
    volatile = xrce.QosFlag.RELIABLE
    return {
        PARTICIPANT: xrce.Participant(representation=xrce.ParticipantBinary()),
        TOPIC: xrce.Topic(representation=named, **there),
        PUBLISHER: xrce.Publisher(representation=xrce.PublisherBinary(), **there),
        SUBSCRIBER: xrce.Subscriber(representation=xrce.SubscriberBinary(), **there),
        WRITER: xrce.DataWriter(
            representation=xrce.DataWriterBinary(topic_id=TOPIC, qos=xrce.DataWriterQos(flags=volatile)),
            publisher_id=PUBLISHER,
        ),
        READER: xrce.DataReader(
            representation=xrce.DataReaderBinary(topic_id=TOPIC, qos=xrce.DataReaderQos(flags=volatile)),
            subscriber_id=SUBSCRIBER,
        ),
    }


def xml_objects() -> dict[int, Any]:
    """The same in XML."""
    there = {"participant_id": PARTICIPANT}
    participant = "<dds><participant><rtps><name>hilbench</name></rtps></participant></dds>"
    topic = f"<dds><topic><name>{_NAME}</name><dataType>{_TYPE}</dataType></topic></dds>"
    return {
        PARTICIPANT: xrce.Participant(representation=xrce.AsXml(text=participant)),
        TOPIC: xrce.Topic(representation=xrce.AsXml(text=topic), **there),
        PUBLISHER: xrce.Publisher(representation=xrce.AsXml(text=""), **there),
        SUBSCRIBER: xrce.Subscriber(representation=xrce.AsXml(text=""), **there),
        WRITER: xrce.DataWriter(
            representation=xrce.AsXml(text=_ENDPOINT_XML.format("data_writer")), publisher_id=PUBLISHER
        ),
        READER: xrce.DataReader(
            representation=xrce.AsXml(text=_ENDPOINT_XML.format("data_reader")), subscriber_id=SUBSCRIBER
        ),
    }
