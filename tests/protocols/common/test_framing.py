from __future__ import annotations

import enum

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.common.framing import Dropped, Frame, ScanningReader, Unfinished
from tests.each import each


class Reason(enum.Enum):
    LENGTH = "length"
    SUM = "sum"


def look(held):
    """A length of 1 to 4, as many bytes, their sum."""
    if not 1 <= held[0] <= 4:
        return Reason.LENGTH
    raw = held[: held[0] + 2]
    if len(raw) < held[0] + 2:
        return None
    return Frame(raw, raw[1:-1]) if sum(raw[:-1]) % 256 == raw[-1] else Reason.SUM


def frame(payload):
    body = bytes([len(payload), *payload])
    return body + bytes([sum(body) % 256])


FRAMES = st.binary(min_size=1, max_size=4).map(frame)
STREAMS = st.lists(st.one_of(FRAMES, st.binary(max_size=6))).map(b"".join)


def bytes_of(found):
    return b"".join(one.raw if isinstance(one, Frame) else one.data for one in found)


@given(STREAMS, st.data())
def test_cuts_do_not_matter_and_each_byte_is_in_one_piece(stream, data):
    whole, cut = ScanningReader(look), ScanningReader(look)
    at = data.draw(st.integers(0, len(stream)))
    expected = [*whole.receive(stream, 0), *whole.reset()]
    found = [*cut.receive(stream[:at], 0), *cut.receive(stream[at:], 0), *cut.reset()]
    assert bytes_of(found) == bytes_of(expected) == stream
    assert [one for one in found if isinstance(one, Frame)] == [one for one in expected if isinstance(one, Frame)]


@given(st.lists(FRAMES, min_size=1))
def test_sound_frames_are_found(frames):
    assert [one.raw for one in ScanningReader(look).receive(b"".join(frames), 0)] == frames


def test_bytes_in_a_row_that_are_dropped_for_one_reason_are_one_piece():
    found = ScanningReader(look).receive(b"\0\0\1\3\x09" + frame(b"a"), 0)
    assert found == [
        Dropped(Reason.LENGTH, b"\0\0"),
        Dropped(Reason.SUM, b"\1\3"),
        Dropped(Reason.LENGTH, b"\x09"),
        Frame(frame(b"a"), b"a"),
    ]


@each(("pause_ns", "kept"), [(20, True), (21, False)])
def test_a_pause_ends_a_frame(pause_ns, kept):
    reader = ScanningReader(look, gap_ns=20)
    raw = frame(b"ab")
    assert reader.receive(raw[:2], 100) == []
    found = reader.receive(raw[2:], 100 + pause_ns)
    assert (found == [Frame(raw, b"ab")]) is kept
    if not kept:
        assert found[0] == Dropped(Unfinished.ABANDONED, raw[:2])


def test_what_never_ends_is_given_up():
    reader = ScanningReader(lambda held: None, longest=4)
    assert reader.receive(b"abcdef", 0) == [Dropped(Unfinished.TOO_LONG, b"abc")]
    assert reader.reset() == [Dropped(Unfinished.ABANDONED, b"def")]


def line(held):
    """Text up to a newline, which begins with ``$``; a line that does not is refused as a whole."""
    end = held.find(b"\n") + 1
    if not end:
        return None
    return Frame(held[:end], held[1 : end - 1]) if held[:1] == b"$" else Dropped(Reason.SUM, held[:end])


def test_what_is_refused_as_a_whole_is_one_piece():
    stream = b"$a\nxyz\nuv\n$b\n$c"
    for cut in range(len(stream) + 1):
        reader = ScanningReader(line)
        assert [*reader.receive(stream[:cut], 0), *reader.receive(stream[cut:], 0)] == [
            Frame(b"$a\n", b"a"),
            Dropped(Reason.SUM, b"xyz\n"),
            Dropped(Reason.SUM, b"uv\n"),
            Frame(b"$b\n", b"b"),
        ]


@each("empty", [Frame(b"", b""), Dropped(Reason.SUM, b"")])
def test_a_piece_without_bytes_is_a_mistake_of_whoever_looks(empty):
    with pytest.raises(ValueError, match="without bytes"):
        ScanningReader(lambda held: empty).receive(b"a", 0)
