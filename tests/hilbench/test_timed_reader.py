"""A reader that knows when each frame began."""

from __future__ import annotations

import pytest

from hilbench.bench.timed_reader import TimedReader


class Lines:
    """Frames that end with a newline."""

    def __init__(self):
        self.held = b""

    def receive(self, data, _now_ns):
        *found, self.held = (self.held + data).split(b"\n")
        return [line + b"\n" for line in found]


@pytest.fixture
def reader():
    return TimedReader(Lines().receive)


def test_a_frame_begins_with_its_first_byte(reader):
    assert list(reader.receive(b"ab", 10)) == []
    assert list(reader.receive(b"c", 20)) == []
    (frame,) = reader.receive(b"\n", 30)
    assert reader.start_ns(frame) == 10
    assert reader.last_byte_ns == 30
    assert reader.bytes_received == 4


def test_each_frame_of_a_chunk_is_there_before_the_byte_behind_it(reader):
    list(reader.receive(b"a", 10))
    seen = [(frame, reader.start_ns(frame), reader.bytes_received) for frame in reader.receive(b"b\nc\nd", 20)]
    assert seen == [(b"ab\n", 10, 3), (b"c\n", 20, 5)]
    assert reader.bytes_received == 6


def test_what_completes_nothing_is_kept_as_far_as_it_can_be_shown(reader):
    list(reader.receive(b"ab\ncd", 10))
    assert reader.begun == b"cd"
    list(reader.receive(b"e" * 40, 20))
    assert reader.begun == b"e" * 32
    list(reader.receive(b"\n", 30))
    assert reader.begun == b""


def test_of_a_frame_longer_than_what_is_remembered_the_oldest_time_is_given(reader):
    list(reader.receive(b"a", 10))
    (frame,) = reader.receive(b"b" * 2000 + b"\n", 20)
    assert reader.start_ns(frame) == 20
