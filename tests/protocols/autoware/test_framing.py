"""Frames of the stand-in link: against worked ones, escaping, resynchronisation, every byte once."""

from __future__ import annotations

import crcmod.predefined
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.autoware import (
    NOISE_RUN,
    AckermannControlCommand,
    AgentOnline,
    AgentPing,
    ControlModeReport,
    Dropped,
    DropReason,
    Frame,
    FrameReader,
    FramingOptions,
    LocalProtocolError,
    Time,
    crc16,
    encode_frame,
    encode_message,
    longest_frame,
)
from tests.each import each

VECTORS = [
    (AgentOnline(), "7E 00 00 01 00 01 C1 C0"),
    (AgentPing(), "7E 00 00 01 00 81 C0 60"),
    (ControlModeReport(mode=4), "7E 00 00 0A 00 83 00 00 00 00 00 00 00 00 04 F6 24"),
    (
        AckermannControlCommand(
            stamp=Time(12, 500_000_000),
            steering_tire_angle=0.5,
            steering_tire_rotation_rate=0.1,
            speed=5.0,
            acceleration=1.0,
            jerk=0.2,
        ),
        "7E 00 00 1D 00 03 0C 00 00 00 00 65 CD 1D 00 00 00 3F CD CC CC 3D 00 00 A0 40 00 00 80 3F CD CC 4C 3E 82 D4",
    ),
    (ControlModeReport(stamp=Time(0x7E, 0x7D)), "7E 00 00 0A 00 83 7D 5E 00 00 00 7D 5D 00 00 00 00 B2 4F"),
]


@each(("message", "frame"), VECTORS)
def test_worked_frames_both_ways(message, frame):
    frame = bytes.fromhex(frame)
    assert encode_frame(encode_message(message)) == frame
    assert FrameReader().receive(frame) == [Frame(raw=frame, source=0, payload=encode_message(message))]


def test_the_crc_is_that_of_another_hand():
    other = crcmod.predefined.mkPredefinedCrcFun("crc-16")
    assert crc16(b"") == 0
    assert crc16(b"123456789") == 0xBB3D
    assert all(crc16(bytes((byte,))) == other(bytes((byte,))) for byte in range(256))


@given(st.binary(max_size=80))
def test_the_crc_of_anything_is_that_of_another_hand(data):
    assert crc16(data) == crcmod.predefined.mkPredefinedCrcFun("crc-16")(data)


@given(st.binary(min_size=1, max_size=64))
def test_a_flag_begins_a_frame_and_stands_nowhere_else(payload):
    frame = encode_frame(payload)
    assert frame[0] == 0x7E
    assert 0x7E not in frame[1:]
    assert len(frame) <= longest_frame()
    assert FrameReader().receive(frame) == [Frame(raw=frame, source=0, payload=payload)]


@given(st.binary(max_size=40), st.binary(min_size=1, max_size=64))
def test_a_frame_behind_anything_is_found(noise, payload):
    frame = encode_frame(payload)
    found = FrameReader().receive(noise + frame)
    assert found[-1] == Frame(raw=frame, source=0, payload=payload)
    assert b"".join(item.raw if isinstance(item, Frame) else item.data for item in found) == noise + frame


@each(
    ("data", "reason", "dropped"),
    [
        ("00 01 02", DropReason.NOISE, "00 01 02"),
        ("7E", DropReason.NOISE, "7E"),
        ("7E 00 00 01 00", DropReason.CUT_SHORT, "7E 00 00 01 00"),
        ("7E 00 00 01 00 01 C1 7D", DropReason.CUT_SHORT, "7E 00 00 01 00 01 C1 7D"),
        ("7E 00 05", DropReason.NOT_FOR_US, "7E 00 05"),
        ("7E 00 00 41 00", DropReason.BAD_LENGTH, "7E 00 00 41 00"),
        ("7E 00 00 01 01", DropReason.BAD_LENGTH, "7E 00 00 01 01"),
        ("7E 00 00 01 00 01 C1 C1", DropReason.BAD_CRC, "7E 00 00 01 00 01 C1 C1"),
    ],
)
def test_what_is_no_frame_is_said_and_the_next_one_is_found(data, reason, dropped):
    good = bytes.fromhex(VECTORS[0][1])
    found = FrameReader().receive(bytes.fromhex(data) + good)
    assert found[0] == Dropped(reason=reason, data=bytes.fromhex(dropped))
    assert found[1:] == [Frame(raw=good, source=0, payload=b"\x01")]


def test_an_escape_is_undone_whatever_follows_it():
    frame = bytes.fromhex("7E 7D 20 00 01 00 01 C1 C0")
    assert FrameReader().receive(frame) == [Frame(raw=frame, source=0, payload=b"\x01")]


def test_an_empty_payload_is_a_sound_frame_that_nobody_sends():
    frame = bytes.fromhex("7E 00 00 00 00 00 00")
    assert FrameReader().receive(frame) == [Frame(raw=frame, source=0, payload=b"")]
    for wrong in (b"", bytes(65)):
        with pytest.raises(LocalProtocolError, match=r"not 1\.\.64"):
            encode_frame(wrong)


def test_addresses_are_checked_and_told():
    options = FramingOptions(local_address=3, remote_address=7)
    frame = encode_frame(b"\x01", options)
    assert frame[1:3] == bytes((3, 7))
    assert isinstance(FrameReader(options).receive(frame)[0], Dropped)
    other = FramingOptions(local_address=7, remote_address=3)
    assert FrameReader(other).receive(frame) == [Frame(raw=frame, source=3, payload=b"\x01")]
    for wrong in ({"local_address": 256}, {"remote_address": -1}, {"max_payload": 0}):
        with pytest.raises(LocalProtocolError, match=next(iter(wrong))):
            FramingOptions(**wrong)


def test_noise_is_kept_in_runs():
    reader = FrameReader()
    found = reader.receive(bytes(3 * NOISE_RUN + 1))
    assert [len(item.data) for item in found] == [NOISE_RUN] * 3
    assert reader.held == 1
    assert reader.reset() == [Dropped(reason=DropReason.NOISE, data=b"\0")]
    assert reader.held == 0


def test_a_frame_is_given_up_with_the_line():
    reader = FrameReader()
    reader.receive(bytes.fromhex("7E 00 00 01 7D"))
    assert [item.reason for item in reader.reset()] == [DropReason.CUT_SHORT]
    good = bytes.fromhex(VECTORS[0][1])
    assert isinstance(reader.receive(good)[0], Frame)
