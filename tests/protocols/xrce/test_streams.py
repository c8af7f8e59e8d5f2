"""Streams alone: numbers that begin anew, windows, what is missing, what is too much."""

from __future__ import annotations

import random

import pytest

from protocols.xrce import AckNack, Heartbeat, LocalProtocolError, RemoteProtocolError, StreamFullError, StreamOptions
from protocols.xrce.sequence import after, ahead, is_newer
from protocols.xrce.streams import Fragments, ReliableInput, ReliableOutput
from tests.each import each

SECOND = 1_000_000_000
MS = 1_000_000


@each(
    ("one", "other", "newer"),
    [(1, 0, True), (0, 0, False), (0, 1, False), (0, 0xFFFF, True), (0x7FFF, 0, True), (0x8000, 0, False)],
)
def test_numbers_are_compared_around_65535(one, other, newer):
    assert is_newer(one, other) is newer
    assert after(other, ahead(one, other)) == one


def test_more_messages_than_there_are_numbers_arrive_once_and_in_order():
    """A quarter of all messages and acknowledgements is lost."""
    chance = random.Random(26)
    output, into = ReliableOutput(0x80, StreamOptions()), ReliableInput(0x80, StreamOptions())
    heard, said, flying, now_ns = [], 0, [], 0
    while len(heard) < 0x10000 + 100:
        more = range(said, said + 16 - output.unacknowledged)
        output.push([number.to_bytes(4, "big") for number in more])
        said = more.stop
        now_ns += SECOND
        flying += output.sendable(now_ns)
        for number, body in flying:
            if chance.random() < 0.75:
                into.take(number, body)
        heard += iter(into.next, None)
        if (heartbeat := output.heartbeat(SECOND << 20)) and chance.random() < 0.75:
            assert into.announced(heartbeat) == 0
        flying = output.acknowledge(into.acknack(), now_ns) if chance.random() < 0.75 else []
    assert heard == [number.to_bytes(4, "big") for number in range(len(heard))]


def test_a_message_is_not_sent_again_twice_within_half_the_time_to_a_heartbeat():
    output = ReliableOutput(0x80, StreamOptions())
    output.push([b"0", b"1"])
    assert len(list(output.sendable(0))) == 2
    first, both = (AckNack(first_unacked=0, nack_bitmap=bits, stream_id=0x80) for bits in (0b01, 0b11))
    again = [(at_ms, output.acknowledge(said, at_ms * MS)) for at_ms, said in [(1, first), (1, first), (2, both)]]
    assert again == [(1, [(0, b"0")]), (1, []), (2, [(1, b"1")])]
    again = [output.acknowledge(both, at_ms * MS) for at_ms in (50, 51, 52)]
    assert again == [[], [(0, b"0")], [(1, b"1")]]


def test_what_may_wait_is_limited():
    output = ReliableOutput(0x80, StreamOptions(window=2, max_queued=10))
    output.push([bytes(5)] * 4)
    assert [number for number, _ in output.sendable(0)] == [0, 1]
    with pytest.raises(StreamFullError, match="4 messages unacknowledged; 11 bytes would wait where 10 may"):
        output.push([b"!"])
    assert (output.unacknowledged, output.held) == (4, 20)
    assert output.acknowledge(AckNack(first_unacked=1, nack_bitmap=0b10, stream_id=0x80), 0) == []
    assert [number for number, _ in output.sendable(0)] == [2]
    missing = output.acknowledge(AckNack(first_unacked=1, nack_bitmap=0b11, stream_id=0x80), 0)
    assert missing == [(1, bytes(5)), (2, bytes(5))]


def test_what_would_never_fit_is_not_to_be_offered_again():
    output = ReliableOutput(0x80, StreamOptions(window=2, max_queued=10))
    with pytest.raises(LocalProtocolError, match="15 bytes would wait where 10 may, however empty") as caught:
        output.push([bytes(5)] * 5)
    assert not isinstance(caught.value, StreamFullError)


def test_the_first_unacknowledged_message_says_when_a_heartbeat_is_due():
    output = ReliableOutput(0x80, StreamOptions())
    for now_ns in (0, SECOND // 20):
        output.push([b"x"])
        assert len(list(output.sendable(now_ns))) == 1
        assert output.due_ns == SECOND // 10


def test_what_a_sender_has_lost_is_not_waited_for_nor_kept():
    into = ReliableInput(0x80, StreamOptions())
    into.take(3, b"older")
    into.take(7, b"newer")
    into.fragments.add(b"a beginning", last=False)
    assert into.announced(Heartbeat(first_unacked=6, last_unacked=2, stream_id=0x80)) == 6
    assert (into.held, into.next()) == (len(b"newer"), None)
    assert into.acknack() == AckNack(first_unacked=6, nack_bitmap=0b01, stream_id=0x80)
    assert into.announced(Heartbeat(first_unacked=7, last_unacked=7, stream_id=0x80)) == 1
    assert into.next() == b"newer"
    assert into.announced(Heartbeat(first_unacked=20, last_unacked=10, stream_id=0x80)) == 12
    assert into.acknack() == AckNack(first_unacked=20, nack_bitmap=0, stream_id=0x80)


def test_a_receiver_keeps_a_window_and_no_more():
    into = ReliableInput(0x80, StreamOptions(window=4))
    assert [number for number in (1, 3, 4, 5, 1, 0xFFFF) if into.take(number, b"12345")] == [1, 3]
    assert (into.held, into.next()) == (10, None)
    assert into.acknack() == AckNack(first_unacked=0, nack_bitmap=0b0101, stream_id=0x80)
    into.announced(Heartbeat(first_unacked=0, last_unacked=0x7000, stream_id=0x80))
    assert into.acknack().nack_bitmap == 0xFFF5


def test_fragments_are_a_whole_with_the_last():
    fragments = Fragments(6)
    assert fragments.add(b"abc", last=False) is None
    assert fragments.add(b"def", last=True) == b"abcdef"
    assert fragments.add(b"ghijklm", last=False) is None
    assert fragments.held <= 6
    with pytest.raises(RemoteProtocolError, match="6 bytes"):
        fragments.add(b"n", last=True)
    assert fragments.add(b"op", last=True) == b"op"
