"""What several tests of DDS-XRCE need: both ends of a session, on a line with faults."""

from __future__ import annotations

import pytest

from protocols.testing import Pair, unchanged
from protocols.xrce import (
    AgentOptions,
    ClientOptions,
    Received,
    Role,
    Session,
    StreamOptions,
    TopicData,
    Transmit,
    WriteData,
)

KEY = bytes.fromhex("AABBCCDD")


class Line(Pair):
    """A client and an agent that send each other numbered data, and a line between them."""

    def __init__(self, *, damage=unchanged, session_id=0x81, mtu=512, epoch_ns=0, silence_s=None, **streams):
        streams = StreamOptions(**streams)
        client = ClientOptions(client_key=KEY, session_id=session_id, mtu=mtu, streams=streams)
        agent = AgentOptions(streams=streams, epoch_ns=epoch_ns, silence_s=silence_s)
        super().__init__(Session(Role.CLIENT, client), Session(Role.AGENT, agent), transmit=Transmit, damage=damage)

    def say(self, end, data, *, stream_id=0x80):
        """The program at an end sends data on a stream."""
        kind = WriteData if end == "client" else TopicData
        session = self.client if end == "client" else self.server
        said = kind(request_id=10, object_id=0x15, data=data)
        written = session.send(said, self.now_ns, stream_id=stream_id)
        if written:
            self.write(end, written)

    def heard(self, end, *, stream_id=0x80):
        """The data that came to an end on a stream."""
        return [
            event.submessage.data
            for _, at, event in self.seen
            if at == end and isinstance(event, Received) and event.stream_id == stream_id
        ]


@pytest.fixture
def line():
    return Line
