"""The vehicle interface's end of the XRCE client: who is answered, when, and what counts as the driving stack."""

from __future__ import annotations

import shutil
import struct
from typing import ClassVar

import pytest

from protocols import xrce
from protocols.testing import unchanged
from tests.targets.firmware.xrce import native
from tests.targets.firmware.xrce.native import MS, SECOND, State

SERVICE = "autoware_auto_vehicle_msgs::srv::dds_::ControlModeCommand_"
REQUESTS, REPLIES = "rq/control/control_mode_requestRequest", "rr/control/control_mode_requestReply"
ONLINE, REQUEST, VELOCITY_REPORT = 0x01, 0x04, 0x87
AUTONOMOUS, MANUAL = 1, 4
STATUS_AGENT = 4
ONE, TWO, THREE = (xrce.SampleIdentity(guid=bytes([octet]) * 16, number=octet) for octet in (0xA1, 0xB2, 0xC3))


class Vehicle(native.Native):
    """The vehicle interface at the line."""

    WRITTEN: ClassVar = {REQUESTS: f"{SERVICE}Request_"}
    READ: ClassVar = {REPLIES: f"{SERVICE}Response_"}

    def ask(self, identity, mode):
        """A node beside the agent asks for a mode."""
        self.publish(REQUESTS, struct.pack("<iIB", 0, 0, mode), identity)

    @property
    def replies(self):
        """What nodes have heard: to which request, and whether the mode is granted."""
        return [(reply.answers, reply.data == b"\x01") for reply in self.said[REPLIES]]


@pytest.fixture(scope="session")
def built(tmp_path_factory):
    """The file with the vehicle interface's end."""
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc here")
    folder = tmp_path_factory.mktemp("vehicle")
    return native.compiled(folder / "vehicle.so", "-shared", "-fPIC", harness="vehicle.c")


@pytest.fixture
def vehicle(built, tmp_path):
    """One that has just been switched on."""
    return Vehicle(native.loaded(shutil.copy(built, tmp_path)))


@pytest.fixture
def connected(vehicle):
    """One with a session."""
    vehicle.run(2 * SECOND)
    assert vehicle.state is State.OPEN
    return vehicle


def refused(data):
    """The same frames, with STATUS_AGENT made a refusal."""
    out = b""
    for frame in xrce.FrameReader().receive(data):
        head, body = xrce.decode_header(frame.payload)
        if body[0] == STATUS_AGENT:
            body = body[:4] + bytes([xrce.Status.DENIED]) + body[5:]
        out += xrce.encode_frame(xrce.encode_message(head, body))
    return out


def nothing(_data):
    """What comes through a line that is cut."""
    return b""


def test_each_reply_goes_to_its_requester_when_requests_come_at_once(connected):
    connected.damage = nothing
    connected.ask(ONE, AUTONOMOUS)  # comes again, behind the next one
    connected.damage = unchanged
    connected.ask(TWO, MANUAL)
    connected.run(SECOND)
    assert connected.replies == [(ONE, True), (TWO, False)]


def test_replies_wait_for_room_in_the_window(connected):
    connected.damage = nothing
    for _ in range(8):
        connected.write(VELOCITY_REPORT, bytes(20))
    connected.damage = unchanged
    connected.ask(ONE, AUTONOMOUS)
    connected.ask(TWO, MANUAL)
    connected.ask(THREE, AUTONOMOUS)
    connected.run(20 * MS)
    assert (len(connected.heard[REQUEST]), connected.unacknowledged) == (3, 8)
    assert connected.replies == []
    connected.run(SECOND)
    assert connected.replies == [(ONE, True), (TWO, False), (THREE, True)]


def test_the_agent_is_there_when_the_session_is(vehicle):
    vehicle.damage = refused
    vehicle.run(30 * SECOND)
    assert vehicle.written.count(b"XRCE") > 10
    assert ONLINE not in vehicle.heard
    vehicle.damage = unchanged
    vehicle.run(3 * SECOND)
    assert vehicle.state is State.OPEN
    assert len(vehicle.heard[ONLINE]) == 1
