"""A board with micro-ROS, as the agent's client in the dashboard: it says its speed, and hears what it has said."""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable

from hilbench.clock import NS_PER_MS, NS_PER_S
from protocols import xrce
from protocols.common.decoding import NoOptions
from protocols.state_machine import earliest

__all__ = ["OBJECTS", "READER", "WRITER", "SpeedBoard"]

_KEY = b"\x48\x42\x00\x02"
_EVERY_NS = 100 * NS_PER_MS
_AGAIN_NS = NS_PER_S
_PARTICIPANT, _TOPIC, _PUBLISHER, _SUBSCRIBER, WRITER, READER = 0x11, 0x12, 0x13, 0x14, 0x15, 0x16
_THERE = {"participant_id": _PARTICIPANT}
OBJECTS: dict[int, xrce.Object] = {
    _PARTICIPANT: xrce.Participant(representation=xrce.ParticipantBinary()),
    _TOPIC: xrce.Topic(
        representation=xrce.TopicBinary(topic_name="rt/speed", type_name="std_msgs::msg::dds_::Float32_"), **_THERE
    ),
    _PUBLISHER: xrce.Publisher(representation=xrce.PublisherBinary(), **_THERE),
    _SUBSCRIBER: xrce.Subscriber(representation=xrce.SubscriberBinary(), **_THERE),
    WRITER: xrce.DataWriter(representation=xrce.DataWriterBinary(topic_id=_TOPIC), publisher_id=_PUBLISHER),
    READER: xrce.DataReader(representation=xrce.DataReaderBinary(topic_id=_TOPIC), subscriber_id=_SUBSCRIBER),
}


class SpeedBoard:
    """See the module; a device at the agent's line.

    Args:
        settings: there are none.
    """

    def __init__(self, settings: NoOptions) -> None:
        del settings
        self._session = xrce.Session(xrce.Role.CLIENT, xrce.ClientOptions(client_key=_KEY))
        self._events: list[object] = []
        self._next_ns = 0

    @property
    def observed(self) -> xrce.Session:
        """What a dashboard looks at."""
        return self._session

    def receive(self, data: bytes, now_ns: int) -> bytes:
        """Take bytes off the line; return what to put on it."""
        return self._take(self._session.receive(data, now_ns), now_ns)

    def advance(self, now_ns: int) -> bytes:
        """Do what is due; return what to put on the line."""
        sent = self._take(self._session.advance(now_ns), now_ns)
        if now_ns < self._next_ns:
            return sent
        self._next_ns = now_ns + _EVERY_NS
        if self._session.state is xrce.ClientState.CLOSED:
            self._next_ns = now_ns + _AGAIN_NS
            return sent + self._take(self._session.connect(now_ns), now_ns)
        if self._session.state is xrce.ClientState.OPEN:
            speed_m_s = 1 + math.sin(now_ns / NS_PER_S)
            said = xrce.WriteData(
                request_id=self._session.new_request_id(), object_id=WRITER, data=struct.pack("<f", speed_m_s)
            )
            return sent + self._session.send(said, now_ns, stream_id=xrce.BUILTIN_BEST_EFFORT)
        return sent

    def next_deadline_ns(self) -> int | None:
        """Return when `advance` must be called, in ns."""
        return earliest(self._session.next_deadline_ns(), self._next_ns)

    def line_down(self, now_ns: int) -> bytes:
        """Take note that the line was hung up."""
        return self._take(self._session.line_down(now_ns), now_ns)

    def take_events(self) -> list[object]:
        """Return what happened since the last call."""
        events, self._events = self._events, []
        return events

    def _take(self, events: Iterable[xrce.Event], now_ns: int) -> bytes:
        sent = b""
        for event in events:
            if isinstance(event, xrce.Transmit):
                sent += event.data
                continue
            self._events.append(event)
            if isinstance(event, xrce.SessionOpened):
                sent += self._begin(now_ns)
        return sent

    def _begin(self, now_ns: int) -> bytes:
        """Create everything, and ask for all samples."""
        session = self._session
        sent = [
            session.send(xrce.Create(request_id=session.new_request_id(), object_id=one, object=made), now_ns)
            for one, made in OBJECTS.items()
        ]
        specification = xrce.ReadSpecification(
            stream_id=xrce.BUILTIN_BEST_EFFORT, delivery=xrce.DeliveryControl(max_samples=xrce.UNLIMITED)
        )
        asked = xrce.ReadData(request_id=session.new_request_id(), object_id=READER, specification=specification)
        return b"".join((*sent, session.send(asked, now_ns)))
