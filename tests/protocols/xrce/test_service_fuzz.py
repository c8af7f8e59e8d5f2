"""The agent with its lines: whatever bytes come, it raises nothing and keeps no more than it may."""

from __future__ import annotations

import contextlib
import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols import xrce
from protocols.testing import lossy
from protocols.xrce import AgentOptions, AgentService, Framing, FramingOptions, Profiles
from tests.each import each
from tests.protocols.xrce.star import MS, READER, SECOND, Star, objects
from tests.protocols.xrce.test_service import ENDPOINT_XML, SERVICE_XML, xml_objects
from tests.share import seeds

TEXTS = st.one_of(
    st.text(max_size=60),
    st.sampled_from(["<dds/>", "", "\0", "<?xml version='1.0' encoding='no-such'?><dds/>"]),
    st.tuples(st.sampled_from([ENDPOINT_XML, SERVICE_XML]), st.integers(0, 300), st.text(max_size=3)).map(
        lambda parts: parts[0][: parts[1]] + parts[2] + parts[0][parts[1] :]
    ),
)


@given(TEXTS)
def test_any_xml_is_read_or_refused(text):
    said = xrce.AsXml(text=text)
    for read in (Profiles().topic, Profiles().writer, Profiles().reader, Profiles().check_participant):
        with contextlib.suppress(xrce.RemoteProtocolError):
            read(said)
    with contextlib.suppress(xrce.RemoteProtocolError):
        Profiles().service("requester", said)


def test_xml_as_deep_as_a_message_can_be():
    with pytest.raises(xrce.RemoteProtocolError, match="no element topic"):
        Profiles().topic(xrce.AsXml(text="<a>" * 9000 + "</a>" * 9000))


def conversation():
    """What two clients say that create everything, write and read: frames, by line."""
    star, said = Star("a", "b"), {"a": [], "b": []}
    fly = star._fly

    def note(end, line, data):
        if end == "agent":
            said[line] += [one.raw for one in xrce.FrameReader().receive(data)]
        fly(end, line, data)

    star._fly = note
    star.connect()
    for name, made in (("a", objects()), ("b", xml_objects())):
        for object_id, one in made.items():
            star.create(name, object_id, one)
        star.read(name)
    for number in range(20):
        star.write("a", bytes((number,)) * 40)
    star.run(SECOND)
    return said


def hear(seed, rounds):
    """Gives both lines what was said again and again, frames changed, left out, repeated; returns the agent."""
    chance, said = random.Random(seed), conversation()
    streams = xrce.StreamOptions(max_queued=3000, max_message=3000)
    options = AgentOptions(
        frames=FramingOptions(framing=Framing.EITHER),
        streams=streams,
        history=4,
        max_history_bytes=2000,
        max_objects=12,
    )
    agent, now_ns = AgentService(("a", "b"), options), 0
    at = {"a": 0, "b": 0}
    for _ in range(rounds):
        line = chance.choice("ab")
        at[line] = chance.randrange(1000) if chance.random() < 0.02 else at[line] + 1
        data = bytearray(said[line][at[line] % len(said[line])])
        if chance.random() < 0.1:
            (found,) = xrce.FrameReader().receive(bytes(data))
            payload = bytearray(found.payload)
            payload[chance.randrange(len(payload))] ^= 1 << chance.randrange(8)
            if chance.random() < 0.3:
                del payload[chance.randrange(len(payload)) :]
            data = bytearray(xrce.encode_frame(bytes(payload)))
        if chance.random() < 0.1:
            data += chance.randbytes(chance.randrange(30))
        now_ns += chance.randrange(50 * MS)
        agent.receive(line, bytes(data), now_ns)
        deadline_ns = agent.next_deadline_ns()
        if deadline_ns is not None and chance.random() < 0.2:
            now_ns = max(now_ns, deadline_ns)
            agent.advance(now_ns)
        if chance.random() < 0.01:
            agent.line_down(line, now_ns)
        assert agent.held < 400_000
    return agent


@pytest.mark.parametrize("seed", seeds(10, 2))
def test_mutated_conversations(seed):
    agent = hear(seed, 1500)
    events = agent.take_events()
    assert any(isinstance(one, xrce.ObjectCreated) for one in events)
    assert any(isinstance(one, xrce.RequestFailed) for one in events)
    assert agent.counters.routed > 0


FAULTS = {"lost": {"drop": 0.2}, "turned": {"flip": 0.2}, "twice": {"repeat": 0.3}, "noise": {"noise": 0.5}}


@each("fault", FAULTS)
def test_from_client_to_client_over_faulty_lines_everything_arrives_once_and_in_order(fault):
    damage = lossy(26, **FAULTS[fault])
    star = Star("a", "b", mtu=128)
    star.connect()
    star.create_all("a")
    star.create_all("b")
    star.read("b")
    star.damage = damage
    expected = [number.to_bytes(2, "big") * (1 + number * 37 % 90) for number in range(60)]
    for one in expected:
        star.write("a", one)
        star.run(20 * MS)
    star.run(60 * SECOND)
    assert star.data("b") == expected
    assert star.agent.objects["b"][READER].reader.waiting.overrun == 0
