"""Messages behind their length, as over TCP; and an agent that finds out which framing a line has."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols import xrce
from protocols.xrce import Dropped, DropReason, Framing, FramingOptions, LengthReader, LineReader, encode_frame
from tests.each import each
from tests.protocols.xrce.conftest import KEY

LENGTH, EITHER = FramingOptions(framing=Framing.LENGTH), FramingOptions(framing=Framing.EITHER)
CREATE = xrce.encode_message(
    xrce.Header(session_id=0x80),
    xrce.encode_submessage(xrce.CreateClient(client=xrce.Client(client_key=KEY, session_id=0x81, mtu=512))),
)
PING = xrce.encode_message(
    xrce.Header(session_id=0x80),
    xrce.encode_submessage(xrce.GetInfo(request_id=10, object_id=xrce.OBJECT_AGENT, info_mask=2)),
)
ACCEPTED = xrce.encode_message(
    xrce.Header(session_id=0x81),
    xrce.encode_submessage(xrce.StatusAgent(status=xrce.Status.OK, agent=xrce.Agent())),
)
DATA = xrce.encode_message(
    xrce.Header(session_id=0x81), xrce.encode_submessage(xrce.WriteData(request_id=1, object_id=0x15, data=b"x"))
)
FRAME_IN_DATA = xrce.encode_message(
    xrce.Header(session_id=0x81),
    xrce.encode_submessage(xrce.WriteData(request_id=1, object_id=0x15, data=encode_frame(DATA))),
)
FRAMES_IN_CREATE = CREATE + encode_frame(DATA) + encode_frame(PING)


def kinds(found):
    return [item.reason if isinstance(item, Dropped) else item.payload for item in found]


def test_a_message_behind_its_length_byte_by_byte():
    assert encode_frame(CREATE, LENGTH) == b"\x18\0" + CREATE
    assert encode_frame(bytes(0x1234), LENGTH)[:2] == b"\x34\x12"
    with pytest.raises(xrce.LocalProtocolError, match="5 bytes"):
        encode_frame(bytes(5), FramingOptions(framing=Framing.LENGTH, max_payload=4))


@given(st.lists(st.binary(max_size=300), max_size=8), st.integers(1, 40))
def test_any_cut_of_any_messages(payloads, size):
    stream = b"".join(encode_frame(one, LENGTH) for one in payloads)
    reader, found = LengthReader(LENGTH), []
    for at in range(0, len(stream), size):
        found += reader.receive(stream[at : at + size])
    assert kinds(found) == payloads
    assert reader.held == 0
    reader.receive(b"\x05\0ab")
    assert kinds(reader.reset()) == [DropReason.CUT_SHORT]


def test_behind_a_message_that_is_too_long_nothing_is_found_until_the_line_is_reset():
    reader = LengthReader(FramingOptions(framing=Framing.LENGTH, max_payload=100))
    assert kinds(reader.receive(encode_frame(PING, LENGTH) + b"\xff\0" + bytes(20))) == [PING, DropReason.BAD_LENGTH]
    assert kinds(reader.receive(encode_frame(PING, LENGTH))) == [DropReason.BAD_LENGTH]
    assert reader.held == 0
    assert reader.reset() == []
    assert kinds(reader.receive(encode_frame(PING, LENGTH))) == [PING]


@each(
    ("stream", "framing", "expected"),
    [
        (encode_frame(CREATE, LENGTH) + encode_frame(DATA, LENGTH), Framing.LENGTH, [CREATE, DATA]),
        (encode_frame(PING, LENGTH) + encode_frame(CREATE, LENGTH), Framing.LENGTH, [PING, CREATE]),
        (encode_frame(ACCEPTED, LENGTH) + encode_frame(DATA, LENGTH), Framing.LENGTH, [ACCEPTED, DATA]),
        (encode_frame(CREATE) + encode_frame(DATA), Framing.SERIAL, [CREATE, DATA]),
        (encode_frame(DATA), Framing.SERIAL, [DATA]),
        (b"\x00\x00" + encode_frame(CREATE), Framing.SERIAL, [DropReason.NOISE, CREATE]),
        (b"\x18\x00noise" + encode_frame(CREATE), Framing.SERIAL, [DropReason.NOISE, CREATE]),
        (encode_frame(CREATE)[:9] + encode_frame(CREATE), Framing.SERIAL, [DropReason.CUT_SHORT, CREATE]),
        (encode_frame(CREATE, LENGTH) + encode_frame(FRAME_IN_DATA, LENGTH), Framing.LENGTH, [CREATE, FRAME_IN_DATA]),
        (encode_frame(FRAMES_IN_CREATE, LENGTH), Framing.SERIAL, [DropReason.NOISE, DATA, PING]),
        (encode_frame(DATA, LENGTH) + encode_frame(CREATE), Framing.SERIAL, [DropReason.NOISE, CREATE]),
    ],
)
def test_which_framing_a_line_has(stream, framing, expected):
    for size in (1, 7, 1000):
        reader, found = LineReader(EITHER), []
        for at in range(0, len(stream), size):
            found += reader.receive(stream[at : at + size])
        assert kinds(found) == expected
        assert reader.framing is framing
        assert b"".join(getattr(item, "raw", None) or item.data for item in found) == stream
        reader.reset()
        assert (reader.framing, reader.held) == (Framing.EITHER, 0)


@given(st.binary(max_size=2000), st.integers(1, 200))
def test_a_line_of_noise_loses_no_byte(noise, size):
    reader, found = LineReader(EITHER), []
    for at in range(0, len(noise), size):
        found += reader.receive(noise[at : at + size])
    found += reader.reset()
    assert b"".join(item.data if isinstance(item, Dropped) else item.raw for item in found) == noise


def test_what_is_held_in_doubt_is_bounded():
    reader = LineReader(EITHER)
    for _ in range(100):
        reader.receive(b"\xff" * 2000)
        assert reader.held <= 3 * 65600
    assert reader.framing is Framing.SERIAL
