"""An agent with several lines, and a client at each: what the tests of the agent have, and no more than a client."""

from __future__ import annotations

import heapq
import itertools

from protocols import xrce
from protocols.testing import LATENCY_NS, unchanged
from protocols.xrce import AgentOptions, AgentService, ClientOptions, Role, Session, Status

MS = 1_000_000
SECOND = 1000 * MS
PARTICIPANT, TOPIC, PUBLISHER, SUBSCRIBER = 0x11, 0x12, 0x13, 0x14
WRITER, READER, REQUESTER, REPLIER = 0x15, 0x16, 0x17, 0x18
FLOAT = "std_msgs::msg::dds_::Float32_"


class Star:
    """See the module.

    Attributes:
        heard: what came to each client: its submessages, with the stream that they came on.
        events: what the agent has reported.
    """

    def __init__(self, *names, damage=unchanged, options=None, mtu=512, session_ids=None, framing=None, **streams):
        streams = xrce.StreamOptions(**streams)
        frames = xrce.FramingOptions(framing=framing or xrce.Framing.SERIAL)
        self.options = options or AgentOptions(streams=streams)
        self.client_options = {
            name: ClientOptions(
                client_key=bytes((1, 2, 3, number)),
                session_id=(session_ids or {}).get(name, 0x81),
                mtu=mtu,
                streams=streams,
                frames=frames,
            )
            for number, name in enumerate(names, 1)
        }
        self.clients = {name: Session(Role.CLIENT, one) for name, one in self.client_options.items()}
        self.agent = AgentService(names, self.options)
        self.heard = {name: [] for name in names}
        self.events = []
        self.damage = damage
        self.now_ns = 0
        self.deaf = set()
        self._flying = []
        self._order = itertools.count()

    # --- what a client does

    def connect(self, *names):
        for name in names or self.clients:
            self._took(name, self.clients[name].connect(self.now_ns))
        self.run(SECOND)

    def say(self, name, *submessages, stream_id=0x80):
        self._fly("agent", name, self.clients[name].send(submessages, self.now_ns, stream_id=stream_id))

    def ask(self, name, submessage, *, stream_id=0x80):
        """The client says something; returns what it hears within a second."""
        at = len(self.heard[name])
        self.say(name, submessage, stream_id=stream_id)
        self.run(SECOND)
        return [said for _, said in self.heard[name][at:]]

    def create(self, name, object_id, made, **flags):
        """The client creates an object; returns the status that it is told."""
        (said,) = self.ask(name, xrce.Create(request_id=10, object_id=object_id, object=made, **flags))
        assert (said.request_id, said.object_id) == (10, object_id)
        return said.status

    def create_all(self, name, *, topic="rt/speed", type_name=FLOAT, domain_id=0, **endpoint):
        """What a node of micro-ROS creates for one topic, in binary."""
        for object_id, made in objects(topic, type_name, domain_id, **endpoint).items():
            assert self.create(name, object_id, made) is Status.OK, (name, object_id)

    def read(self, name, object_id=READER, *, stream_id=0x80, request_id=20, **control):
        control = xrce.DeliveryControl(**{"max_samples": xrce.UNLIMITED, **control})
        specification = xrce.ReadSpecification(stream_id=stream_id, delivery=control)
        self.say(name, xrce.ReadData(request_id=request_id, object_id=object_id, specification=specification))
        self.run(100 * MS)

    def write(self, name, data, object_id=WRITER, *, stream_id=0x80, request_id=30):
        said = xrce.WriteData(request_id=request_id, object_id=object_id, data=data)
        self.say(name, said, stream_id=stream_id)

    def data(self, name, *, stream_id=0x80):
        """The samples that a client has heard on a stream."""
        heard = self.heard[name]
        return [said.data for stream, said in heard if isinstance(said, xrce.TopicData) and stream == stream_id]

    def restart(self, name):
        """The client's board is reset: it knows nothing any more."""
        self.clients[name] = Session(Role.CLIENT, self.client_options[name])
        self.heard[name].clear()

    # --- the line and time

    def run(self, duration_ns):
        end_ns = self.now_ns + duration_ns
        while (next_ns := self._next_ns()) <= end_ns:
            self.now_ns = max(next_ns, self.now_ns)
            while self._flying and self._flying[0][0] <= self.now_ns:
                _, _, end, line, data = heapq.heappop(self._flying)
                if end == "agent":
                    self._wrote(self.agent.receive(line, data, self.now_ns))
                elif line not in self.deaf:
                    self._took(line, self.clients[line].receive(data, self.now_ns))
            self._wrote(self.agent.advance(self.now_ns))
            for name, client in self.clients.items():
                if name not in self.deaf:
                    self._took(name, client.advance(self.now_ns))
        self.now_ns = end_ns

    def of(self, kind):
        """The agent's reports of a kind."""
        self.events += self.agent.take_events()
        return [event for event in self.events if isinstance(event, kind)]

    def _next_ns(self):
        ends = [self.agent, *(one for name, one in self.clients.items() if name not in self.deaf)]
        times = [one.next_deadline_ns() for one in ends] + [self._flying[0][0] if self._flying else None]
        return min((time for time in times if time is not None), default=1 << 62)

    def _took(self, name, events):
        for event in events:
            if isinstance(event, xrce.Transmit):
                self._fly("agent", name, event.data)
            elif isinstance(event, xrce.Received):
                self.heard[name].append((event.stream_id, event.submessage))

    def _wrote(self, written):
        for line, data in written:
            self._fly("client", line, data)

    def _fly(self, end, line, data):
        data = self.damage(data)
        if data:
            heapq.heappush(self._flying, (self.now_ns + LATENCY_NS, next(self._order), end, line, data))


def objects(topic="rt/speed", type_name=FLOAT, domain_id=0, *, writer=None, reader=None):
    """What a node of micro-ROS creates for one topic, in binary, by id."""
    named = xrce.TopicBinary(topic_name=topic, type_name=type_name)
    there = {"participant_id": PARTICIPANT}
    return {
        PARTICIPANT: xrce.Participant(representation=xrce.ParticipantBinary(), domain_id=domain_id),
        TOPIC: xrce.Topic(representation=named, **there),
        PUBLISHER: xrce.Publisher(representation=xrce.PublisherBinary(), **there),
        SUBSCRIBER: xrce.Subscriber(representation=xrce.SubscriberBinary(), **there),
        WRITER: xrce.DataWriter(
            representation=xrce.DataWriterBinary(topic_id=TOPIC, qos=writer or xrce.DataWriterQos()),
            publisher_id=PUBLISHER,
        ),
        READER: xrce.DataReader(
            representation=xrce.DataReaderBinary(topic_id=TOPIC, qos=reader or xrce.DataReaderQos()),
            subscriber_id=SUBSCRIBER,
        ),
    }
