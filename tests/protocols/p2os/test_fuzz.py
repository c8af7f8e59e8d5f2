"""Whatever the bytes: no exception, bounded memory, and the same events however they are cut."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols.p2os import (
    ClientOptions,
    Command,
    CommandNumber,
    ConfigPacket,
    Connection,
    Identification,
    Role,
    ServerOptions,
    Sip,
    SonarReading,
    StateChanged,
    SyncEcho,
    SyncError,
    Transmit,
    encode_command,
    encode_frame,
    encode_packet,
)
from protocols.p2os.framing import NOISE_RUN
from tests.share import examples

MAX_HELD = max(203, NOISE_RUN)
SECOND = 1_000_000_000

from_client = [
    *(encode_frame(bytes((number,))) for number in (0, 1, 2)),
    *(encode_command(Command(number, 1)) for number in (CommandNumber.OPEN, CommandNumber.CLOSE, CommandNumber.CONFIG)),
    encode_command(Command(CommandNumber.VEL, -200)),
    encode_command(Command(CommandNumber.SAY, b"\xfa\xfb\x03\x00\x00\x00")),
    encode_frame(b"\x0b\x3c\x01"),
]
from_server = [
    *(encode_packet(SyncEcho(number=number)) for number in (0, 1)),
    encode_packet(Identification(name="x", subclass="p2dx")),
    encode_packet(Identification(name="x", subclass="?")),
    encode_packet(SyncError()),
    encode_packet(Sip(moving=True, sonars=(SonarReading(number=1, range_raw=0xFBFA),))),
    encode_packet(ConfigPacket(name="x")),
    encode_frame(b"\x33\x00"),
    encode_frame(b"\x02x"),
]


@st.composite
def streams(draw, frames):
    """Good frames, damaged frames and noise."""
    parts = draw(st.lists(st.one_of(st.sampled_from(frames), st.binary(max_size=12)), max_size=25))
    stream = bytearray(b"".join(parts))
    for at in draw(st.lists(st.integers(0, max(0, len(stream) - 1)), max_size=4)):
        if at < len(stream):
            stream[at] ^= 1 << draw(st.integers(0, 7))
    return bytes(stream)


def server():
    return Connection(Role.SERVER, ServerOptions(handshake_limit_s=3))


def client():
    connection = Connection(Role.CLIENT, ClientOptions(max_restarts=3))
    connection.connect(0)
    return connection


ROLES = pytest.mark.parametrize(
    ("make", "frames"), [(server, from_client), (client, from_server)], ids=["server", "client"]
)


@ROLES
def test_any_cut_of_any_stream_gives_the_same_events(make, frames):
    @settings(max_examples=examples(200))
    @given(st.lists(st.tuples(streams(frames), st.integers(0, 2 * SECOND)), max_size=6))
    def check(bursts):
        whole, single = make(), make()
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


@ROLES
def test_mutated_bytes_at_any_time(make, frames):
    @settings(max_examples=examples(150))
    @given(st.lists(st.tuples(st.one_of(streams(frames), st.binary(max_size=300)), st.integers(0, SECOND)), max_size=8))
    def check(bursts):
        connection = make()
        now_ns, state = 0, connection.state
        for stream, gap_ns in bursts:
            now_ns += gap_ns
            for event in connection.receive(stream, now_ns) + connection.advance(now_ns):
                if isinstance(event, StateChanged):
                    assert event.old is state
                    state = event.new
                elif isinstance(event, Transmit):
                    assert event.data.startswith(b"\xfa\xfb")
            assert connection.state is state
            assert connection.held <= MAX_HELD
            deadline_ns = connection.next_deadline_ns()
            assert deadline_ns is None or deadline_ns > now_ns

    check()
