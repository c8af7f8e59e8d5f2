"""What touches no register, called in the committed images: readers, frames, the joystick's law."""

from __future__ import annotations

import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols import autoware, carla
from protocols.carla.joystick import manual_command
from protocols.carla.reading import LiveParser, StreamReader
from tests.each import each
from tests.targets.firmware.calls import Code

MS = 1_000_000
READER_BYTES, STATUS_BYTES = 22 + 2 + 4 * 22 + 4, 16
FLOATS = st.floats(width=32)
FRAMES = st.builds(carla.StatusFrame, **dict.fromkeys(carla.StatusFrame.__slots__, FLOATS))
STATUSES = FRAMES.map(carla.encode_status)
PIECES = STATUSES | st.binary(max_size=30) | STATUSES.flatmap(lambda data: st.integers(0, 22).map(lambda at: data[:at]))


@pytest.fixture(scope="module")
def vehicle():
    return Code("vehicle")


@pytest.fixture(scope="module")
def in_blocks():
    return Code("vehicle-h2")


class Place:
    """Memory for a function to work on."""

    def __init__(self, code, size, offset=0):
        self.code, self.size = code, size
        self.address = code.put(bytes(64 + size + offset)) + offset

    def take(self):
        return self.code.bytes_at(self.address, self.size)


def status_at(data):
    return carla.StatusFrame(**dict(zip(carla.StatusFrame.__slots__, struct.unpack("<4f", data), strict=True)))


@given(st.lists(st.tuples(st.integers(0, 150), PIECES), max_size=6))
def test_statuses_are_found_as_the_protocol_finds_them(vehicle, pieces):
    """Whatever comes, and however long it pauses."""
    reader = Place(vehicle, READER_BYTES)
    status = Place(vehicle, STATUS_BYTES, offset=READER_BYTES)
    theirs = StreamReader(carla.STATUS_LAYOUT, lambda _frame: None, timeout_ns=100 * MS)
    tick, ours, expected = 1000, [], []
    for pause, data in pieces:
        tick += pause
        expected += [one for one in theirs.receive(data, tick * MS) if isinstance(one, carla.StatusFrame)]
        ours += [
            status_at(status.take())
            for byte in data
            if vehicle.call("status_take", reader.address, byte, tick, status.address)
        ]
    assert list(map(repr, ours)) == list(map(repr, expected))


@given(st.lists(st.binary(min_size=22, max_size=22) | STATUSES, max_size=4))
def test_blocks_are_read_as_the_original_does(in_blocks, blocks):
    status = Place(in_blocks, STATUS_BYTES)
    theirs = LiveParser(carla.STATUS_LAYOUT)
    for block in blocks:
        expected = list(theirs.parse(block))
        at = in_blocks.put(block, status.address + 256)
        assert bool(in_blocks.call("status_take_block", at, status.address)) == bool(expected)
        assert repr(status_at(status.take())) == repr(theirs.snapshot())


@given(FRAMES)
def test_what_is_plausible(vehicle, status):
    fault = carla.checking.status_fault(carla.BoardOptions(), status)
    data = carla.encode_status(status)
    at = vehicle.put(b"".join(data[at : at + 4] for at in (2, 7, 12, 17)))
    assert bool(vehicle.call("status_plausible", at)) == (fault is None)


@each("name", ["F1", "F2", "F3"])
def test_the_commands_of_the_document(vehicle, name):
    command = carla.decode_command(carla.VECTORS[name].data)
    action = vehicle.put(struct.pack("<5fB", *[getattr(command, slot) for slot in carla.CommandFrame.__slots__]))
    vehicle.call("command_make", action + 64, action)
    assert vehicle.bytes_at(action + 64, carla.COMMAND_BYTES) == carla.VECTORS[name].data


@given(st.binary(min_size=1, max_size=64))
def test_frames_of_the_stand_in_link(vehicle, payload):
    at = vehicle.put(payload)
    size = vehicle.call("frame_make", at + 64, at, len(payload))
    assert vehicle.bytes_at(at + 64, size) == autoware.encode_frame(payload)


@given(st.lists(st.binary(max_size=40) | st.binary(min_size=1, max_size=64).map(autoware.encode_frame), max_size=5))
def test_frames_are_found_in_anything(vehicle, pieces):
    reader = vehicle.put(bytes(128))
    theirs, ours, expected = autoware.FrameReader(), [], []
    for byte in b"".join(pieces):
        expected += [one.payload for one in theirs.receive(bytes((byte,))) if isinstance(one, autoware.Frame)]
        size = vehicle.call("frame_take", reader, byte, reader + 100)
        if size:
            ours.append(vehicle.bytes_at(struct.unpack("<I", vehicle.bytes_at(reader + 100, 4))[0], size))
    assert ours == [payload for payload in expected if payload]


def test_sizes_of_messages(vehicle):
    sizes = {number: autoware.payload_size(kind) for kind, number in autoware.MESSAGE_IDS.items()}
    assert {number: vehicle.call("message_bytes", number) for number in range(256)} == {
        number: sizes.get(number, 0) for number in range(256)
    }


COUNTS = st.integers(0, 65_535) | st.sampled_from([1057, 1062, 33_469, 33_470, 34_470, 34_471, 33_080, 34_080])


@pytest.mark.parametrize(("name", "clamp"), [("vehicle", True), ("vehicle-no-clamp", False)])
@given(x=COUNTS, y=COUNTS)
def test_the_joystick(name, clamp, x, y):
    code = Code(name)
    at = code.put(bytes(64))
    code.call("stick_action", at, x, y)
    steer, _rate, throttle, brake, _jerk, mode = struct.unpack("<5fB", code.bytes_at(at, 21))
    command = manual_command(x, y, clamp=clamp)
    assert (steer, throttle, brake) == pytest.approx((command.steer, command.throttle, command.brake), abs=1e-7)
    assert mode == carla.Mode.MANUAL
    assert str(steer) == str(command.steer) or steer != 0  # -0.0 at rest
