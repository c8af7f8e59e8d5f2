"""Frames of the stand-in link: against worked ones, and its limits; the rest is in tests/protocols/common."""

from __future__ import annotations

import pytest

from protocols.autoware import (
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


@each(
    ("data", "reason", "dropped"),
    [
        ("00 01 02", DropReason.NOISE, "00 01 02"),
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


def test_what_does_not_fit_is_a_local_error():
    with pytest.raises(LocalProtocolError, match="65 bytes"):
        encode_frame(bytes(65))
    for wrong in ({"local_address": 256}, {"remote_address": -1}, {"max_payload": 0}):
        with pytest.raises(LocalProtocolError, match=next(iter(wrong))):
            FramingOptions(**wrong)
    assert len(encode_frame(b"\x7e" * 64)) <= longest_frame()
