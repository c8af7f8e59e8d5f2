"""What the agent's clients publish, subscribe to, ask and answer, in a DDS domain as well.

Each endpoint of a client has one of its own in DDS, with its topic, type and quality of service. So samples of other
participants reach exactly the readers that they are for, none of ours comes back to us, and two agents of one domain
hand nothing on from each other. CDR passes as it is, but for big-endian messages, which are turned.

A service has the header of ROS 2 with Cyclone DDS before its data (ros2/rmw_cyclonedds, serdata.hpp,
cdds_request_header_t): 8 bytes that the client knows itself by, and a number, both of which come back with the reply.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from functools import cache
from hashlib import blake2b

from hilbench.bench import Bench
from hilbench.clock import EventClass
from hilbench.errors import UnavailableError
from hilbench.files.names import printable
from hilbench.systems.xrce_agent.cyclone import DdsError, Endpoint, Participant, Watch
from hilbench.systems.xrce_agent.samples import message_of
from hilbench.terminal.options import ITS_DOMAINS
from protocols.xrce import (
    AgentService,
    LocalProtocolError,
    Mismatch,
    Reader,
    RemoteProtocolError,
    SampleIdentity,
    StoredSample,
    Writer,
)
from protocols.xrce.cdr import INTERFACES, MessageTypes, definition_of

__all__ = ["DdsDomain"]

_REQUEST, _REPLY = "rq/", "rr/"
"""What the topics of services begin with (ROS 2, topic and service name mapping to DDS)."""
_ID_BYTES, _HEADER_BYTES = 8, 16
_FROM_DDS = bytes(8)
"""What the first half of a requester's GUID is if it is not one of ours; see `protocols.xrce.entities`."""
_WHY = {
    "reliability": "the reader wants a reliable writer, and the writer is best-effort",
    "durability": "the reader wants samples from before its time, and the writer keeps none, or not as long",
}


@cache
def _known_types() -> MessageTypes:
    types = MessageTypes()
    for name in INTERFACES:
        types.add(definition_of(name))
    return types


def _little_endian(type_name: str, data: bytes) -> bytes:
    """Return a big-endian sample in the order that DDS has here.

    Raises:
        LocalProtocolError: its type is not known.
        RemoteProtocolError: it is none of its type.
    """
    name = message_of(type_name)
    if name is None or name not in INTERFACES:
        raise LocalProtocolError(f"it is big-endian, and {type_name} is not known here")
    return _known_types().encode(name, _known_types().decode(name, data, little_endian=False))


class DdsDomain:
    """See the module; it is told by the agent's data space, and tells it.

    Args:
        domain_id: of all endpoints, or `ITS_DOMAINS`.
        history: how many samples an endpoint keeps at most.
        say: takes lines for a person.
    """

    def __init__(self, domain_id: int, *, history: int, say: Callable[[str], None]) -> None:
        self._domain_id = domain_id
        self._history = history
        self._say = say
        self._salt = os.urandom(_ID_BYTES)  # two agents may have clients of one key
        self._participants: dict[int, Participant] = {}
        self._endpoints: dict[int, tuple[Writer | Reader, Endpoint]] = {}
        self._told: set[tuple[int, str, str]] = set()

    def join(
        self, bench: Bench, name: str, agent: AgentService, transmit: Callable[[Iterable[tuple[str, bytes]]], None]
    ) -> None:
        """Begin.

        Args:
            bench: whose time and journal are used.
            name: of the agent in the journal.
            agent: whose clients are joined; it has none yet.
            transmit: puts on the agent's lines what it wants there.

        Raises:
            UnavailableError: Cyclone DDS is not installed, or does not start, or cannot join a domain.
        """
        self._watch = Watch()
        domain_id = 0 if self._domain_id == ITS_DOMAINS else self._domain_id
        try:
            Participant(self._watch, domain_id).close()  # now, where somebody reads what is wrong, not with a client
        except DdsError as error:
            self._watch.close()
            hint = "the line before says why; interfaces are those that CYCLONEDDS_URI names"
            raise UnavailableError(f"DDS domain {domain_id} cannot be joined: {error}", hint=hint) from None
        self._bench, self._name, self._agent, self._transmit = bench, name, agent, transmit
        agent.space.outside = self
        bench.scheduler.add_source(self)

    def close(self) -> None:
        """Leave."""
        self._bench.scheduler.remove_source(self)
        self._agent.space.outside = None
        self._watch.close()
        for participant in self._participants.values():
            participant.close()

    # --- what the data space tells

    def opened(self, one: Writer | Reader) -> None:
        """See `protocols.xrce.space.Outside`."""
        domain_id = one.domain_id if self._domain_id == ITS_DOMAINS else self._domain_id
        try:
            if domain_id not in self._participants:
                self._participants[domain_id] = Participant(self._watch, domain_id)
            made = Endpoint(
                self._participants[domain_id],
                one.topic.name,
                one.topic.type_name,
                writes=isinstance(one, Writer),
                reliable=one.qos.reliable,
                durability=min(one.qos.durability, 1),
                depth=min(one.qos.depth or self._history, self._history),
            )
        except DdsError as error:
            self._tell(one, f"it cannot be joined to DDS domain {domain_id}: {error}")
            return
        self._endpoints[id(one)] = one, made

    def closed(self, one: Writer | Reader) -> None:
        """See `protocols.xrce.space.Outside`."""
        if id(one) in self._endpoints:
            self._endpoints.pop(id(one))[1].close()

    def written(self, writer: Writer, sample: StoredSample) -> None:
        """See `protocols.xrce.space.Outside`."""
        header = self._header(writer.topic.name, sample)
        if header is None or id(writer) not in self._endpoints:
            return
        try:
            data = sample.data if sample.little_endian else _little_endian(writer.topic.type_name, sample.data)
            self._endpoints[id(writer)][1].write(header + data)
        except (DdsError, LocalProtocolError, RemoteProtocolError) as error:
            self._tell(writer, f"a sample was not handed on to DDS: {error}")

    # --- what DDS tells

    def fileno(self) -> int:
        """See `hilbench.clock.host.InputSource`."""
        return self._watch.fileno()

    def on_readable(self, at_ns: int) -> None:
        """See `hilbench.clock.host.InputSource`."""
        self._watch.take()
        self._bench.scheduler.at(at_ns, self._look, order=EventClass.INPUT, source=self._name)

    def _look(self) -> None:
        sent: list[tuple[str, bytes]] = []
        for one, endpoint in [*self._endpoints.values()]:
            try:
                self._compare(one, endpoint)
                samples = [self._sample(one, data) for data in endpoint.take()] if isinstance(one, Reader) else []
            except DdsError as error:
                self._tell(one, f"DDS does not say what came: {error}")
                continue
            for sample in samples:
                if sample is not None and isinstance(one, Reader):
                    sent += self._agent.hand(one, sample, self._bench.now_ns)
        self._watch.looked()
        self._transmit(sent)

    def _compare(self, one: Writer | Reader, endpoint: Endpoint) -> None:
        if what := endpoint.mismatch():
            who = "a reader" if isinstance(one, Writer) else "a writer"
            self._tell(one, f"{who} in DDS does not suit: {_WHY.get(what, f'their {what} differs')}")

    def _tell(self, one: Writer | Reader, why: str) -> None:
        """Reports something once."""
        key = one.domain_id, one.topic.name, why
        if key not in self._told:
            self._told.add(key)
            self._bench.record_event(self._name, Mismatch(domain_id=one.domain_id, topic=one.topic.name, why=why))
            self._say(printable(f"{self._bench.now_s:10.3f} s  {one.topic.name}: {why}"))

    # --- services

    def _id(self, guid: bytes) -> bytes:
        """What a requester of ours is known by in DDS."""
        return blake2b(guid, digest_size=_ID_BYTES, salt=self._salt).digest()

    def _header(self, topic: str, sample: StoredSample) -> bytes | None:
        """What stands before the data in DDS; None for a reply to nobody there."""
        if topic.startswith(_REQUEST) and sample.identity is not None:
            return self._id(sample.identity.guid) + sample.identity.number.to_bytes(8, "little")
        if topic.startswith(_REPLY) and sample.answers is not None:
            guid = sample.answers.guid
            known = guid.startswith(_FROM_DDS)
            return guid[_ID_BYTES:] + sample.answers.number.to_bytes(8, "little") if known else None
        return b""

    def _sample(self, reader: Reader, data: bytes) -> StoredSample | None:
        """What a reader is handed of a sample from DDS; None if it is no request or reply."""
        topic = reader.topic.name
        if not topic.startswith((_REQUEST, _REPLY)):
            return StoredSample(data=data)
        if len(data) < _HEADER_BYTES:
            return None
        known_by, number = data[:_ID_BYTES], int.from_bytes(data[_ID_BYTES:_HEADER_BYTES], "little")
        data = data[_HEADER_BYTES:]
        if topic.startswith(_REQUEST):
            return StoredSample(data=data, identity=SampleIdentity(_FROM_DDS + known_by, number))
        ours = reader.guid is not None and known_by == self._id(reader.guid)
        guid = reader.guid if ours and reader.guid is not None else _FROM_DDS + known_by
        return StoredSample(data=data, answers=SampleIdentity(guid, number))
