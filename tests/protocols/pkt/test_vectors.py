"""Known frames, each made and read; checked with two other CRC implementations when they were written down."""

from __future__ import annotations

import pytest

from protocols.pkt import (
    ExecutionReport,
    Frame,
    FrameReader,
    Framing,
    FramingOptions,
    GeneralReport,
    GpsReport,
    LedOff,
    LedOn,
    MotionReport,
    MotorSpeeds,
    MotorThrottles,
    PidGains,
    RequestTelemetry,
    Schema,
    SpeedSetpoints,
    UnknownCommand,
    decode_command,
    decode_report,
    encode_command,
    encode_frame,
    encode_report,
    hides_newline,
)

LEN = FramingOptions()
TERM = FramingOptions(framing=Framing.TERM)
V1, V1B, V2 = Schema.V1, Schema.V1B, Schema.V2
ANY = (V1, V1B, V2)
REST = MotionReport()
BOOT = MotionReport(rpm=(1.0,) * 4)

VECTORS = [
    ("W1", LEN, ANY, RequestTelemetry(), "01 00 E1 F0 0A"),
    ("W1", TERM, ANY, RequestTelemetry(), "00 E1 F0 0A"),
    ("W2", LEN, ANY, RequestTelemetry(report_type=0), "02 00 00 1D 0F 0A"),
    ("W3", LEN, ANY, LedOn(), "01 01 F1 D1 0A"),
    ("W3", TERM, ANY, LedOn(), "01 F1 D1 0A"),
    ("W4", LEN, ANY, LedOff(), "01 02 C1 B2 0A"),
    ("W4", TERM, ANY, LedOff(), "02 C1 B2 0A"),
    ("W5", LEN, (V1,), MotorSpeeds(a=100, b=-100), "06 03 00 64 FF 9C 03 F1 55 0A"),
    ("W6", TERM, (V1,), MotorSpeeds(a=100, b=-100), "03 00 64 FF 9C 03 F1 55 0A"),
    ("W7", TERM, (V1,), MotorSpeeds(a=10, b=10), "03 00 0A 00 0A 03 77 F3 0A"),
    ("W8", TERM, (V1,), MotorSpeeds(a=59, b=59), "03 00 3B 00 3B 03 1B 0A 0A"),
    ("W9", LEN, (V1B,), MotorSpeeds(a=100, b=-100), "06 03 64 00 9C FF 03 6E EE 0A"),
    ("W10", LEN, (V2,), MotorThrottles(a=0.5, b=-0.25), "0A 03 00 00 00 3F 00 00 80 BE 03 8C 42 0A"),
    ("W11", LEN, (V2,), MotorThrottles(a=0.0, b=0.0), "0A 03 00 00 00 00 00 00 00 00 03 60 95 0A"),
    ("W12", LEN, (V1B, V2), SpeedSetpoints(a_rpm=30.0, b_rpm=30.0), "0A 04 00 00 F0 41 00 00 F0 41 03 A1 E8 0A"),
    (
        "W13",
        LEN,
        (V2,),
        PidGains(kp=0.01, kd=0.0001, ki=0.0001),
        "0D 05 0A D7 23 3C 17 B7 D1 38 17 B7 D1 38 53 4C 0A",
    ),
    ("W14", LEN, ANY, GeneralReport(), "06 80 00 00 00 00 00 DA 30 0A"),
    ("W14", TERM, ANY, GeneralReport(status=None), "80 00 00 00 00 33 DC 0A"),
    ("W15", LEN, ANY, GeneralReport(accepted=1, last_opcode=1), "06 80 01 00 01 00 00 47 51 0A"),
    ("W15", TERM, ANY, GeneralReport(accepted=1, last_opcode=1, status=None), "80 01 00 01 00 76 59 0A"),
    ("W16", LEN, ANY, ExecutionReport(opcode=1), "03 81 01 00 F3 C7 0A"),
    ("W16", TERM, ANY, ExecutionReport(opcode=1), "81 01 00 F3 C7 0A"),
    ("W17", LEN, ANY, ExecutionReport(opcode=0x7F, error=5), "03 81 7F 05 88 34 0A"),
    ("W18", LEN, ANY, UnknownCommand(opcode=0x7F), "01 7F 6E 88 0A"),
    ("W19", LEN, (V1B, V2), GpsReport(), "0C 84 00 00 00 00 00 00 00 00 00 00 00 23 8C 0A"),
    ("W19", LEN, (V1B, V2), GpsReport(validity=3), "0C 84 03 00 00 00 00 00 00 00 00 00 00 5B 76 0A"),
    ("W20", LEN, (V2,), REST, "34 83" + " 00" * 51 + "8C BB 0A"),
    ("W21", LEN, (V2,), BOOT, "34 83 00 00 00" + " 00 00 80 3F" * 4 + " 00" * 32 + "78 7F 0A"),
    (
        "W22",
        LEN,
        (V1B, V2),
        GpsReport(first_deg=-58.3683, second_deg=-34.6175),
        "0C 84 00 00 00 24 79 69 C2 52 78 0A C2 67 DA 0A",
    ),
]
CASES = [
    (f"{name}-{framing.framing.name}-{schema.name}", framing, schema, message, bytes.fromhex("50 4B 54 21 " + text))
    for name, framing, schemas, message, text in VECTORS
    for schema in schemas
]
REPORTS = (GeneralReport, ExecutionReport, GpsReport, MotionReport)


def payload_of(message, schema):
    return encode_report(message, schema) if isinstance(message, REPORTS) else encode_command(message, schema)


def test_a_message_becomes_these_bytes():
    for name, framing, schema, message, raw in CASES:
        assert encode_frame(payload_of(message, schema), framing) == raw, name


def test_these_bytes_become_the_message():
    for name, framing, schema, message, raw in CASES:
        options = framing
        if framing is TERM and hides_newline(payload_of(message, schema)):  # W7 and W8: nobody can read them strictly
            assert not any(isinstance(item, Frame) for item in FrameReader(TERM).receive(raw, 0)), name
            options = FramingOptions(framing=Framing.TERM, tolerant_newline=True)
        found = FrameReader(options).receive(raw, 0)
        assert [item.raw for item in found] == [raw], name
        decoded = (decode_report if isinstance(message, REPORTS) else decode_command)(found[0].payload, schema)
        assert type(decoded) is type(message), name
        assert payload_of(decoded, schema) == found[0].payload, name


def test_byte_by_byte_is_the_same_frame():
    for name, framing, _, _, raw in CASES:
        single, whole = FrameReader(framing), FrameReader(framing)
        assert [item for byte in raw for item in single.receive(bytes((byte,)), 0)] == whole.receive(raw, 0), name
        assert single.visits == whole.visits, name


def test_the_length_of_every_motor_command_is_itself_a_newline():
    assert encode_frame(encode_command(MotorThrottles(a=0.0, b=0.0)))[4] == 0x0A
    assert encode_frame(encode_command(SpeedSetpoints(a_rpm=0.0, b_rpm=0.0)))[4] == 0x0A


def test_a_throttle_with_newlines_in_it():
    """P19: its payload is as good as any where there is a length byte."""
    payload = b"\x03" + b"\x0a\x0a\x0a\x3e" + b"\0\0\0\0" + b"\x03"
    (frame,) = FrameReader().receive(encode_frame(payload), 0)
    command = decode_command(frame.payload)
    assert command.a == pytest.approx(0.1348, abs=1e-4)


def test_how_many_speeds_hide_a_newline():
    """1.56 % of all commands of two speeds cannot be told to a rover without length bytes."""
    speeds = [n.to_bytes(2, "big", signed=True) for n in range(-255, 256)]
    hidden = sum(hides_newline(b"\x03" + a + b + b"\x03") for a in speeds for b in speeds)
    assert hidden == 4062
