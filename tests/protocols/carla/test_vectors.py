"""Frames worked out by hand, both ways."""

from __future__ import annotations

import struct

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from protocols.carla import (
    COMMAND_BYTES,
    STATUS_BYTES,
    VECTORS,
    AckermannCommand,
    CommandFrame,
    ControlCommand,
    LocalProtocolError,
    ManualCommand,
    RemoteProtocolError,
    StatusFrame,
    command_in,
    decode_command,
    decode_status,
    encode_command,
    encode_status,
)
from tests.each import each

FLOAT = st.floats(width=32, allow_nan=False)
STATUSES = st.builds(
    StatusFrame, lon_speed_m_s=FLOAT, lat_speed_m_s=FLOAT, heading_rate_rad_s=FLOAT, steering_rad=FLOAT
)
COMMANDS = st.builds(
    CommandFrame,
    steering=FLOAT,
    steering_rate=FLOAT,
    speed=FLOAT,
    acceleration=FLOAT,
    jerk=FLOAT,
    mode=st.integers(0, 255),
)


def codec(frame):
    return (encode_status, decode_status) if isinstance(frame, StatusFrame) else (encode_command, decode_command)


def as_binary32(frame):
    values = {name: getattr(frame, name) for name in frame.__dataclass_fields__}
    kept = {name: struct.unpack("<f", struct.pack("<f", value))[0] for name, value in values.items() if name != "mode"}
    return type(frame)(**(values | kept))


@each("name", VECTORS)
def test_each_vector_both_ways(name):
    vector = VECTORS[name]
    encode, decode = codec(vector.frame)
    assert encode(vector.frame) == vector.data
    assert decode(vector.data) == as_binary32(vector.frame)


def test_the_lengths_are_those_of_the_line():
    assert (STATUS_BYTES, COMMAND_BYTES) == (22, 30)
    assert len(encode_status(StatusFrame())) == 22
    assert encode_command(CommandFrame())[-2:] == b"$\0"


@each("name", ["F1", "F2", "F3"])
def test_a_command_is_read_with_and_without_its_nul(name):
    vector = VECTORS[name]
    assert decode_command(vector.data[:29]) == decode_command(vector.data)


@given(STATUSES)
@example(StatusFrame(lon_speed_m_s=-0.0))
def test_statuses_survive_the_line(status):
    assert decode_status(encode_status(status)) == status


@given(COMMANDS)
def test_commands_survive_the_line(command):
    assert decode_command(encode_command(command)) == command


@given(STATUSES, st.integers(0, 21), st.integers(1, 255))
def test_a_damaged_letter_is_seen_and_a_damaged_value_is_not(status, at, turned):
    data = bytearray(encode_status(status))
    data[at] ^= turned
    if at in (0, 1, 6, 11, 16, 21):
        with pytest.raises(RemoteProtocolError, match=f"byte {at} is"):
            decode_status(bytes(data))
    else:
        decode_status(bytes(data))


@each("data", [b"", VECTORS["F4"].data[:-1], VECTORS["F4"].data + b"\0", VECTORS["F1"].data])
def test_a_status_of_another_length_is_refused(data):
    with pytest.raises(RemoteProtocolError, match="instead of 22"):
        decode_status(data)


@each(
    "frame", [StatusFrame(lon_speed_m_s=1e39), CommandFrame(jerk=1e39), CommandFrame(mode=256), CommandFrame(mode=-1)]
)
def test_what_does_not_fit_is_the_callers_mistake(frame):
    encode, _ = codec(frame)
    with pytest.raises(LocalProtocolError, match="does not fit"):
        encode(frame)


def test_a_control_command_is_sent_with_its_steering_times_one_point_two():
    command = ControlCommand(
        steering_rad=0.5, steering_rate_rad_s=0.1, speed_m_s=5.0, acceleration_m_s2=1.0, jerk_m_s3=0.2
    )
    assert encode_command(command.frame()) == VECTORS["F1"].data


@each(
    ("name", "command"),
    [
        ("F2", ManualCommand(steer=-0.5, throttle=0.75)),
        ("F3", AckermannCommand()),
    ],
)
def test_what_a_frame_tells_the_simulator(name, command):
    frame = decode_command(VECTORS[name].data)
    assert command_in(frame) == command
    assert encode_command(command.frame() if name == "F2" else command.frame(frame.mode)) == VECTORS[name].data


def test_a_mode_that_nobody_knows_tells_nothing():
    assert command_in(CommandFrame(mode=7)) is None
