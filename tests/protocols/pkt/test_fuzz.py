"""Whatever the bytes: no exception, bounded memory, and the same events however they are cut."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols.pkt import (
    LINE_LIMIT,
    PROFILES,
    Connection,
    GeneralReport,
    ImuReport,
    LedOn,
    MotionReport,
    MotorSpeeds,
    MotorThrottles,
    PidGains,
    ReportDue,
    Role,
    SpeedSetpoints,
    StateChanged,
    Transmit,
    UnknownCommand,
    encode_command,
    encode_frame,
    encode_report,
    longest_frame,
)
from tests.share import examples

SECOND = 1_000_000_000
MAX_HELD = LINE_LIMIT + 256 + longest_frame()

COMMANDS = {
    True: [LedOn(), MotorThrottles(a=0.5, b=0.5), SpeedSetpoints(a_rpm=1.0, b_rpm=1.0), PidGains(kp=1, kd=1, ki=1)],
    False: [LedOn(), MotorSpeeds(a=10, b=59), UnknownCommand(opcode=4, parameters=b"PKT!\n")],
}
REPORTS = {True: [GeneralReport(accepted=10), ImuReport(), MotionReport()], False: [GeneralReport(status=None)]}


def end_of(profile, role):
    options = PROFILES[profile].server if role is Role.SERVER else PROFILES[profile].client
    connection = Connection(role, options)
    if role is Role.CLIENT:
        connection.connect(0)
    return connection


def frames_for(profile, role):
    """Sound frames as this end gets them."""
    options = PROFILES[profile].server
    latest = profile in ("documented", "g2")
    if role is Role.SERVER:
        payloads = [encode_command(command, options.schema) for command in COMMANDS[latest]]
    else:
        payloads = [encode_report(report, options.schema) for report in REPORTS[latest]]
    return [encode_frame(payload, options.frames) for payload in [*payloads, b"\x00", b"\x03"]]


@st.composite
def streams(draw, frames):
    """Good frames, damaged frames and noise."""
    parts = draw(st.lists(st.one_of(st.sampled_from([*frames, b"PKT!", b"P"]), st.binary(max_size=12)), max_size=20))
    stream = bytearray(b"".join(parts))
    for at in draw(st.lists(st.integers(0, max(0, len(stream) - 1)), max_size=4)):
        if at < len(stream):
            stream[at] ^= 1 << draw(st.integers(0, 7))
    return bytes(stream)


every_end = pytest.mark.parametrize(
    ("profile", "role"), [(profile, role) for profile in PROFILES for role in Role], ids=str
)


@every_end
def test_any_cut_of_any_stream_gives_the_same_events(profile, role):
    @settings(max_examples=examples(40))
    @given(st.lists(st.tuples(streams(frames_for(profile, role)), st.integers(0, 2 * SECOND)), max_size=5))
    def check(bursts):
        whole, single = end_of(profile, role), end_of(profile, role)
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
            assert single.frame_visits == whole.frame_visits
        assert single.counters == whole.counters

    check()


@every_end
def test_thirty_thousand_bytes(profile, role):
    """Half noise, half frames with a bit turned now and then, in pieces of any size, at any time."""
    chance = random.Random(f"{profile} {role.name}")
    connection, frames = end_of(profile, role), frames_for(profile, role)
    stream = bytearray()
    while len(stream) < 30_000:
        stream += chance.choice(frames) if chance.random() < 0.7 else chance.randbytes(chance.randrange(20))
        if chance.random() < 0.1:
            stream[-1 - chance.randrange(9)] ^= 1 << chance.randrange(8)
    at, now_ns, state = 0, 0, connection.state
    while at < len(stream):
        size = chance.choice((1, 7, 11, 64, 300))
        now_ns += chance.randrange(SECOND // 20)
        for event in connection.receive(bytes(stream[at : at + size]), now_ns):
            if isinstance(event, StateChanged):
                assert event.old is state
                state = event.new
            elif isinstance(event, Transmit):
                assert event.data.startswith(b"PKT!")
            elif isinstance(event, ReportDue):
                assert role is Role.SERVER
        at += size
        assert connection.held <= MAX_HELD
        deadline_ns = connection.next_deadline_ns()
        assert deadline_ns is None or deadline_ns > now_ns
    assert connection.state is state
    assert connection.counters.bytes_in == len(stream)
    assert connection.counters.frames_in > 150
