"""Whatever the bytes, and however they are cut: the same events, no exception, bounded memory."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols import xrce
from protocols.xrce import Role, Session
from tests.protocols.xrce.conftest import KEY
from tests.protocols.xrce.vectors import SUBMESSAGES
from tests.share import examples

SECOND = 1_000_000_000
OPTIONS = xrce.StreamOptions(max_message=2000, max_queued=2000, max_streams=4)
MAX_HELD = 4 * (16 * 600 + 2000) + 16 * 600 + 2000 + xrce.longest_frame()

every_role = pytest.mark.parametrize("role", Role, ids=lambda role: role.value)


def end_of(role):
    """A session in which something is on its way."""
    client = Session(Role.CLIENT, xrce.ClientOptions(client_key=KEY, streams=OPTIONS))
    agent = Session(Role.AGENT, xrce.AgentOptions(streams=OPTIONS))
    for event in agent.receive(client.connect(0)[-1].data, 0):
        if isinstance(event, xrce.Transmit):
            client.receive(event.data, 0)
    if role is Role.CLIENT:
        client.send([xrce.Delete(request_id=10, object_id=0x15)], 0)
        return client
    agent.send([xrce.StatusReply(request_id=10, object_id=0x15, status=xrce.Status.OK)], 0)
    return agent


def frame_of(submessages, session_id, stream_id, sequence):
    key = KEY if session_id < 0x80 else None
    header = xrce.Header(session_id=session_id, stream_id=stream_id, sequence=sequence, client_key=key)
    return xrce.encode_frame(xrce.encode_message(header, xrce.pack_submessages(submessages)))


FRAMES = st.builds(
    frame_of,
    st.lists(st.sampled_from([vector.data for vector in SUBMESSAGES]), max_size=3),
    st.sampled_from([0x81, 0x81, 0x81, 0x80, 0x00, 0x82]),
    st.sampled_from([0, 1, 0x80, 0x80, 0x81]),
    st.integers(0, 5),
)


@st.composite
def streams(draw):
    """Sound frames, damaged ones, and noise."""
    stream = bytearray(b"".join(draw(st.lists(st.one_of(FRAMES, FRAMES, st.binary(max_size=12)), max_size=8))))
    for at in draw(st.lists(st.integers(0, max(0, len(stream) - 1)), max_size=3)):
        if at < len(stream):
            stream[at] ^= 1 << draw(st.integers(0, 7))
    return bytes(stream)


@every_role
def test_any_cut_of_any_stream_gives_the_same_events(role):
    @settings(max_examples=examples(100))
    @given(st.lists(st.tuples(streams(), st.integers(0, 2 * SECOND)), max_size=4))
    def check(bursts):
        whole, single = end_of(role), end_of(role)
        now_ns = 0
        for stream, gap_ns in bursts:
            now_ns += gap_ns
            expected = whole.receive(stream, now_ns)
            events = single.advance(now_ns)
            for byte in stream:
                events += single.receive(bytes((byte,)), now_ns)
                assert single.held <= MAX_HELD
            assert events == expected
            assert single.state is whole.state
            assert single.next_deadline_ns() == whole.next_deadline_ns()
        assert single.counters == whole.counters

    check()


def hear(role, count, seed):
    """A session hears so many bytes: sound frames, some damaged, and noise, in pieces of any size, at any time."""
    chance = random.Random(f"{role.name} {seed}")
    session, now_ns, heard = end_of(role), 0, 0
    before = session.counters.bytes_in
    while heard < count:
        stream = bytearray()
        while len(stream) < 2000:
            several = [chance.choice(SUBMESSAGES).data for _ in range(chance.randrange(4))]
            stream_id, number = chance.choice((0, 1, 0x80, 0x81)), chance.randrange(0x10000)
            if chance.random() < 0.5:
                number = heard // 3000  # one that is about to come
            session_id = chance.choice((0x81,) * 9 + (0x80, 0x01))
            stream += frame_of(several, session_id, stream_id, number)
            if chance.random() < 0.3:
                stream += chance.randbytes(chance.randrange(20))
            if chance.random() < 0.2:
                stream[-1 - chance.randrange(min(40, len(stream)))] ^= 1 << chance.randrange(8)
        at = 0
        while at < len(stream):
            size = chance.choice((1, 7, 64, 300))
            now_ns += chance.randrange(SECOND // 20)
            for event in session.receive(bytes(stream[at : at + size]), now_ns):
                assert not isinstance(event, xrce.Transmit) or event.data.startswith(b"\x7e")
            at += size
            assert session.held <= MAX_HELD
        heard += len(stream)
    assert session.counters.bytes_in - before == heard
    assert session.counters.frames_in > count // 200
    return session


@every_role
def test_thirty_thousand_bytes(role):
    session = hear(role, 30_000, 0)
    assert session.counters.bad_crcs > 0
    assert session.counters.misplaced > 0


@pytest.mark.exhaustive("a minute and more: two million bytes into either end; the gate has thirty thousand")
@every_role
def test_two_million_bytes(role):
    for seed in range(1, 21):
        hear(role, 100_000, seed)
