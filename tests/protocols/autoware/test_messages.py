"""Messages and their payloads: against the layout written out, and back."""

from __future__ import annotations

from dataclasses import fields

import pytest
from hypothesis import given

from protocols.autoware import (
    MESSAGE_IDS,
    MESSAGES,
    AckermannControlCommand,
    AgentPing,
    ControlModeResponse,
    LocalProtocolError,
    RemoteProtocolError,
    Sender,
    SteeringReport,
    Time,
    UnknownMessage,
    VelocityReport,
    decode_message,
    encode_message,
    payload_size,
)
from tests.each import each

SIZES = {
    "AgentOnline": 1,
    "Clock": 9,
    "AckermannControlCommand": 29,
    "ControlModeRequest": 11,
    "TurnIndicatorsCommand": 10,
    "HazardLightsCommand": 10,
    "AgentPing": 1,
    "ControlModeReport": 10,
    "ControlModeResponse": 3,
    "TurnIndicatorsReport": 10,
    "HazardLightsReport": 10,
    "VelocityReport": 21,
    "SteeringReport": 13,
}


def test_a_control_command_byte_by_byte():
    command = AckermannControlCommand(
        stamp=Time(12, 500_000_000),
        steering_tire_angle=0.5,
        steering_tire_rotation_rate=0.1,
        speed=5.0,
        acceleration=1.0,
        jerk=0.2,
    )
    expected = "03 0C000000 0065CD1D 0000003F CDCCCC3D 0000A040 0000803F CDCC4C3E"
    assert encode_message(command) == bytes.fromhex(expected)


def test_every_class_has_its_description_its_id_and_its_size():
    assert {kind.__name__: payload_size(kind) for kind in MESSAGES} == SIZES
    assert set(MESSAGE_IDS) == set(MESSAGES)
    assert len(set(MESSAGE_IDS.values())) == len(MESSAGE_IDS)
    for kind, spec in MESSAGES.items():
        assert [field.name for field in fields(kind)] == [field.name for field in spec.fields]
        assert (MESSAGE_IDS[kind] >= 0x80) is (spec.sender is Sender.BOARD)


def test_every_message_comes_back(messages, alike):
    @given(messages())
    def check(message):
        payload = encode_message(message)
        assert len(payload) == payload_size(type(message))
        assert alike(decode_message(payload), message)

    check()


def test_an_unknown_id_is_handed_on():
    assert decode_message(b"\x7f\x01") == UnknownMessage(id=0x7F, body=b"\x01")
    assert encode_message(UnknownMessage(id=0x7F, body=b"\x01")) == b"\x7f\x01"
    with pytest.raises(LocalProtocolError, match="id 256"):
        encode_message(UnknownMessage(id=256))


@each(
    "message",
    [
        AckermannControlCommand(speed=1e39),
        AckermannControlCommand(stamp=Time(1 << 31, 0)),
        ControlModeResponse(sequence=256),
        SteeringReport(stamp=Time(0, -1)),
    ],
)
def test_what_does_not_fit_is_refused(message):
    with pytest.raises(LocalProtocolError, match="does not fit"):
        encode_message(message)


@each("change", [-1, 1])
@each("kind", MESSAGES)
def test_another_size_is_refused(kind, change):
    payload = encode_message(kind())
    payload = payload + b"\0" if change > 0 else payload[:-1]
    with pytest.raises(RemoteProtocolError):
        decode_message(payload)


def test_a_success_is_0_or_1():
    assert decode_message(bytes((0x84, 9, 1))) == ControlModeResponse(sequence=9, success=True)
    assert decode_message(bytes((0x84, 9, 0))) == ControlModeResponse(sequence=9, success=False)
    with pytest.raises(RemoteProtocolError, match="success"):
        decode_message(bytes((0x84, 9, 2)))


def test_stamps_in_ns():
    assert Time.from_ns(12_500_000_000) == Time(12, 500_000_000)
    assert Time(12, 500_000_000).ns == 12_500_000_000
    for wrong in (-1, (1 << 31) * 1_000_000_000):
        with pytest.raises(LocalProtocolError):
            Time.from_ns(wrong)


def test_a_velocity_report_is_that_of_the_original():
    fields_of = {field.name: field for field in MESSAGES[VelocityReport].fields}
    assert fields_of["stamp"].original == "header.stamp"
    assert MESSAGES[VelocityReport].topic == "/vehicle/status/velocity_status"
    assert MESSAGES[AgentPing].choice
