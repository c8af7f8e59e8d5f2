"""Whatever the bytes: no exception, bounded memory, and the same events however they are cut."""

from __future__ import annotations

import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols.carla import (
    NOISE_RUN,
    PROFILES,
    QUIRKS,
    VECTORS,
    BlockReader,
    CommandFrame,
    Connection,
    ControlCommand,
    Role,
    StatusFrame,
    Transmit,
    decode_command,
    encode_command,
    encode_status,
    with_quirks,
)
from tests.share import examples

MS = 1_000_000
SECOND = 1_000_000_000
MAX_HELD = NOISE_RUN + 30 + 4096
FRAMES = [vector.data for vector in VECTORS.values()]
ENDS = [(profile, role) for profile in PROFILES for role in Role]
PIECES = st.lists(
    st.one_of(
        st.binary(max_size=40),
        st.sampled_from([*FRAMES, *(frame[:at] for frame in FRAMES for at in (1, 2, 7, 21, 29))]),
        st.sampled_from([b"#", b"$", b"#$", b"#M\x04$", b"\0", b"\r", b"#A"]),
    ),
    max_size=20,
)


def end_of(profile, role, quirks=()):
    ends = with_quirks(PROFILES[profile], quirks)
    return Connection(role, ends.board if role is Role.BOARD else ends.simulator)


@pytest.mark.parametrize(("profile", "role"), ENDS)
@given(pieces=PIECES, cuts=st.lists(st.integers(1, 30), max_size=60))
def test_how_bytes_are_cut_does_not_matter(profile, role, pieces, cuts):
    data = b"".join(pieces)
    whole, cut = end_of(profile, role), end_of(profile, role)
    in_one = [*whole.receive(data, 5 * MS), *whole.advance(2 * SECOND)]
    in_pieces, at = [], 0
    for size in [*cuts, len(data)]:
        in_pieces += cut.receive(data[at : at + size], 5 * MS)
        at += size
    in_pieces += cut.advance(2 * SECOND)
    assert repr(in_one) == repr(in_pieces)
    assert repr(whole.counters) == repr(cut.counters)


@pytest.mark.parametrize(("profile", "role"), ENDS)
@given(steps=st.lists(st.tuples(st.binary(max_size=60), st.integers(0, 300)), max_size=40))
def test_whatever_the_bytes(profile, role, steps):
    connection, now_ns = end_of(profile, role), 0
    for data, wait_ms in steps:
        connection.receive(data, now_ns)
        now_ns += wait_ms * MS
        connection.advance(now_ns)
        assert connection.held <= MAX_HELD
        deadline_ns = connection.next_deadline_ns()
        assert deadline_ns is None or deadline_ns > now_ns


FLOAT = st.floats(width=32)
INPUTS = st.one_of(
    st.tuples(st.just("bytes"), st.one_of(st.binary(max_size=50), st.sampled_from(FRAMES[3:]))),
    st.tuples(
        st.just("command"),
        st.builds(ControlCommand, steering_rad=FLOAT, speed_m_s=FLOAT, acceleration_m_s2=FLOAT, jerk_m_s3=FLOAT),
    ),
    st.tuples(st.just("request"), st.integers(0, 255)),
    st.tuples(st.just("press"), st.none()),
    st.tuples(st.just("agent"), st.booleans()),
    st.tuples(st.just("joystick"), st.tuples(st.integers(0, 65535), st.integers(0, 65535))),
    st.tuples(st.just("line error"), st.none()),
    st.tuples(st.just("wait"), st.integers(1, 1500)),
)


def put(board, what, value, now_ns):
    match what:
        case "bytes":
            return board.receive(value, now_ns)
        case "command":
            return board.command(value, now_ns)
        case "request":
            return board.request(value, now_ns)
        case "agent":
            return board.agent(now_ns, online=value)
        case "joystick":
            return board.joystick(*value, now_ns)
        case "press":
            return board.press(now_ns)
        case "line error":
            return board.line_error(now_ns)
    return []


@pytest.mark.parametrize("quirk", [None, *QUIRKS])
@given(inputs=st.lists(INPUTS, max_size=40))
@settings(max_examples=examples(30))
def test_whatever_is_said_and_done_to_a_board(quirk, inputs):
    board, now_ns, frames = end_of("hardened", Role.BOARD, [quirk] if quirk else []), 0, []
    for what, value in [("agent", True), *inputs, ("wait", 3000)]:
        events = put(board, what, value, now_ns)
        now_ns += value * MS if what == "wait" else MS
        frames += [event for event in [*events, *board.advance(now_ns)] if isinstance(event, Transmit)]
    assert board.counters.frames_out == len(frames)
    assert all(len(frame.data) == 30 for frame in frames)
    if quirk in (None, "H2", "H7", "V1"):
        for frame in frames:
            said = decode_command(frame.data)
            assert said.mode in (0, 1, 4)
            assert abs(said.speed) <= 150
            if said.mode == 4:
                assert max(abs(said.steering), said.speed, said.acceleration) <= 1


def test_random_bytes_and_then_a_frame():
    """A small run of what `make soak` does with a million."""
    chance = random.Random(25)
    for profile, role in ENDS:
        connection, now_ns = end_of(profile, role), 0
        for _ in range(200):
            connection.receive(chance.randbytes(100), now_ns)
            now_ns += 100 * MS
            connection.advance(now_ns)
        before = connection.counters.frames_in
        data = encode_status(StatusFrame()) if role is Role.BOARD else encode_command(CommandFrame())
        for _ in range(3):
            now_ns += 100 * MS
            connection.receive(data, now_ns)
        connection.advance(now_ns + SECOND)
        taken = connection.counters.frames_in - before
        lost_for_ever = role is Role.BOARD and profile != "hardened"
        assert taken >= (0 if lost_for_ever else 2)


def test_a_shipped_board_may_take_noise_for_a_status():
    """#$ within a block is a frame to it: one in some three thousand blocks of noise."""
    reader = BlockReader()
    found = reader.receive(random.Random(1).randbytes(22 * 5_000), 0)
    assert 1 <= sum(isinstance(item, StatusFrame) for item in found) <= 20
