"""Commands and reports: both ways in every schema, and what is refused."""

from __future__ import annotations

import math
import struct

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.pkt import (
    COMMANDS,
    REPORTS,
    Dialect,
    EulerImuReport,
    ExecutionReport,
    GeneralReport,
    GpsReport,
    ImuReport,
    LedOff,
    LedOn,
    LocalProtocolError,
    MotionReport,
    MotionReportV1b,
    MotorSpeeds,
    MotorThrottles,
    PacketTotals,
    PidGains,
    PidReport,
    PktError,
    Position,
    PositionOrder,
    QuaternionOrder,
    RemoteProtocolError,
    RequestTelemetry,
    Schema,
    SpeedSetpoints,
    UnknownCommand,
    UnknownReport,
    acceleration_m_s2,
    acceleration_raw,
    attitude_wxyz,
    clamp_command,
    decode_command,
    decode_report,
    encode_command,
    encode_report,
    gps_report,
    position,
    quaternion_raw,
    report_id,
    unwrap,
)
from protocols.pkt.units import AccelerationUnit
from tests.each import each

V1, V1B, V2 = Schema.V1, Schema.V1B, Schema.V2
every_schema = pytest.mark.parametrize("schema", list(Schema), ids=lambda schema: schema.name)

u8 = st.integers(0, 255)
u32 = st.integers(0, 2**32 - 1)
i16 = st.integers(-(2**15), 2**15 - 1)
f32 = st.floats(width=32, allow_nan=False)


def many(item, n):
    return st.tuples(*[item] * n)


COMMON_COMMANDS = [
    st.builds(RequestTelemetry, report_type=st.one_of(st.none(), u8)),
    st.just(LedOn()),
    st.just(LedOff()),
]
SPEEDS = st.builds(MotorSpeeds, a=i16, b=i16, flags=u8)
SETPOINTS = st.builds(SpeedSetpoints, a_rpm=f32, b_rpm=f32, flags=u8)
COMMANDS_OF = {
    V1: [*COMMON_COMMANDS, SPEEDS, st.builds(UnknownCommand, opcode=st.integers(4, 255), parameters=st.binary())],
    V1B: [
        *COMMON_COMMANDS,
        SPEEDS,
        SETPOINTS,
        st.builds(UnknownCommand, opcode=st.integers(5, 255), parameters=st.binary()),
    ],
    V2: [
        *COMMON_COMMANDS,
        st.builds(MotorThrottles, a=f32, b=f32, flags=u8),
        SETPOINTS,
        st.builds(PidGains, kp=f32, kd=f32, ki=f32),
        st.builds(UnknownCommand, opcode=st.integers(6, 255), parameters=st.binary()),
    ],
}
IMU_FIELDS = {
    "validity": u8,
    "acceleration": many(f32, 3),
    "rate_deg_s": many(f32, 3),
    "field_mgauss": many(f32, 3),
    "temperature_c": f32,
}
COMMON_REPORTS = [
    st.builds(GeneralReport, accepted=u8, rejected=u8, last_opcode=u8, last_error=u8, status=st.one_of(st.none(), u8)),
    st.builds(ExecutionReport, opcode=u8, error=u8),
]
IMU = st.builds(ImuReport, **IMU_FIELDS, quaternion=many(f32, 4))
EULER = st.builds(EulerImuReport, **IMU_FIELDS, magnetic_angles_rad=many(f32, 3), gyro_angles_rad=many(f32, 3))
GPS = st.builds(GpsReport, validity=u8, first_deg=f32, second_deg=f32)
REPORTS_OF = {
    V1: [*COMMON_REPORTS, EULER, st.builds(UnknownReport, report_id=st.integers(0x83, 0xFF), data=st.binary())],
    V1B: [
        *COMMON_REPORTS,
        IMU,
        EULER,
        st.builds(
            MotionReportV1b,
            rpm=many(f32, 4),
            ticks=st.one_of(st.none(), many(u32, 4)),
            throttles=many(i16, 2),
            setpoints_rpm=many(f32, 2),
        ),
        GPS,
        st.builds(UnknownReport, report_id=st.integers(0x85, 0xFF), data=st.binary()),
    ],
    V2: [
        *COMMON_REPORTS,
        IMU,
        st.builds(
            MotionReport, rpm=many(f32, 4), ticks=many(u32, 4), throttles=many(f32, 2), setpoints_rpm=many(f32, 2)
        ),
        GPS,
        st.builds(PidReport, validity=u8, maximum=f32, minimum=f32, kp=f32, kd=f32, ki=f32),
        st.builds(UnknownReport, report_id=st.integers(0x86, 0xFF), data=st.binary()),
    ],
}


@every_schema
def test_every_command_comes_back(schema):
    @given(st.one_of(COMMANDS_OF[schema]))
    def check(command):
        payload = encode_command(command, schema)
        assert decode_command(payload, schema) == command
        if not isinstance(command, RequestTelemetry | UnknownCommand):
            assert len(payload) == 1 + COMMANDS[schema][payload[0]].size
            assert decode_command(payload + b"\1\2\3", schema) == command

    check()


@every_schema
def test_every_report_comes_back(schema):
    @given(st.one_of(REPORTS_OF[schema]))
    def check(report):
        payload = encode_report(report, schema)
        assert payload[0] == report_id(report)
        assert decode_report(payload, schema) == report

    check()


@every_schema
def test_every_command_and_report_of_the_tables_is_tested(schema):
    kinds = {spec.kind.__name__ for spec in COMMANDS[schema].values()}
    assert all(any(name in repr(strategy) for strategy in COMMANDS_OF[schema]) for name in kinds)
    kinds = {spec.kind.__name__ for spec in REPORTS[schema]}
    assert all(any(name in repr(strategy) for strategy in REPORTS_OF[schema]) for name in kinds)


@every_schema
def test_any_payload_is_read_or_refused(schema):
    @given(st.binary(max_size=97))
    def check(payload):
        for decode, encode in ((decode_command, encode_command), (decode_report, encode_report)):
            try:
                message = decode(payload, schema)
            except RemoteProtocolError:
                continue
            again = encode(message, schema)
            assert encode(decode(again, schema), schema) == again

    check()


@every_schema
def test_known_sizes(schema):
    """What stands in the tables of document, manual and code."""
    sizes = {(spec.report, spec.kind, spec.size) for spec in REPORTS[schema]}
    assert {(0x80, GeneralReport, 6), (0x80, GeneralReport, 5), (0x81, ExecutionReport, 3)} <= sizes
    expected = {
        V1: {(0x82, EulerImuReport, 68)},
        V1B: {
            (0x82, ImuReport, 60),
            (0x82, EulerImuReport, 68),
            (0x83, MotionReportV1b, 48),
            (0x83, MotionReportV1b, 32),
            (0x84, GpsReport, 12),
        },
        V2: {(0x82, ImuReport, 60), (0x83, MotionReport, 52), (0x84, GpsReport, 12), (0x85, PidReport, 24)},
    }[schema]
    assert sizes >= expected
    assert len(sizes) == len(expected) + 3


def test_offsets_of_the_manual():
    """0x82 and 0x83 by their byte offsets, not by our tables."""
    imu = ImuReport(
        validity=3,
        acceleration=(1.0, 2.0, 3.0),
        rate_deg_s=(4.0, 5.0, 6.0),
        field_mgauss=(7.0, 8.0, 9.0),
        temperature_c=10.0,
        quaternion=(11.0, 12.0, 13.0, 14.0),
    )
    payload = encode_report(imu)
    assert payload[:4] == b"\x82\x03\0\0"
    assert [struct.unpack_from("<f", payload, at)[0] for at in range(4, 60, 4)] == list(range(1, 15))
    motion = MotionReport(
        rpm=(1.0, 2.0, 3.0, 4.0), ticks=(5, 6, 7, 8), throttles=(9.0, 10.0), setpoints_rpm=(11.0, 12.0)
    )
    payload = encode_report(motion)
    assert payload[:4] == b"\x83\0\0\0"
    assert struct.unpack_from("<4f4I2f2f", payload, 4) == tuple(range(1, 13))


@each(
    ("message", "schema", "text"),
    [
        (MotorThrottles(a=0.0, b=0.0), V1, "no command of schema V1"),
        (MotorSpeeds(a=0, b=0), V2, "no command of schema V2"),
        (SpeedSetpoints(a_rpm=0.0, b_rpm=0.0), V1, "no command"),
        (PidGains(kp=0.0, kd=0.0, ki=0.0), V1B, "no command"),
        (MotorSpeeds(a=40_000, b=0), V1, "does not fit"),
        (MotorThrottles(a=1e39, b=0.0), V2, "does not fit"),
        (MotorThrottles(a=0.0, b=0.0, flags=256), V2, "does not fit"),
        (MotorSpeeds(a=0.5, b=0), V1, "does not fit"),
        (UnknownCommand(opcode=256), V2, "opcode 256"),
        (RequestTelemetry(report_type=-1), V2, "report_type -1"),
        (GeneralReport(accepted=256), V2, "does not fit"),
        (MotionReport(ticks=(0, 0, 0, -1)), V2, "does not fit"),
        (MotionReport(rpm=(0.0, 0.0, 0.0)), V2, "does not fit"),
        (MotionReport(ticks=None), V2, "no report of schema V2"),
        (ImuReport(), V1, "no report of schema V1"),
        (EulerImuReport(), V2, "no report of schema V2"),
        (PidReport(), V1B, "no report of schema V1B"),
        (UnknownReport(report_id=-1), V2, "report_id -1"),
    ],
)
def test_what_does_not_fit_is_the_programs_fault(message, schema, text):
    encode = encode_command if "Report" not in type(message).__name__ else encode_report
    with pytest.raises(LocalProtocolError, match=text):
        encode(message, schema)


@each(
    ("decode", "payload", "text"),
    [
        (decode_command, b"", "empty"),
        (decode_command, b"\x03", "0 bytes of parameters, not 9"),
        (decode_command, b"\x05" + bytes(11), "11 bytes of parameters, not 12"),
        (decode_report, b"", "empty"),
        (decode_report, b"\x82" + bytes(60), "no form of 61 bytes"),
        (decode_report, b"\x80", "no form of 1 bytes"),
    ],
)
def test_what_cannot_be_read_is_the_peers_fault(decode, payload, text):
    with pytest.raises(RemoteProtocolError, match=text):
        decode(payload)


def test_one_family_holds_both():
    assert issubclass(LocalProtocolError, PktError)
    assert issubclass(RemoteProtocolError, PktError)
    assert not issubclass(LocalProtocolError, RemoteProtocolError)


@each(
    ("given_", "expected"),
    [
        (MotorThrottles(a=1.5, b=-2.0, flags=1), MotorThrottles(a=1.0, b=-1.0, flags=1)),
        (MotorThrottles(a=math.nan, b=math.inf), MotorThrottles(a=0.0, b=1.0)),
        (MotorThrottles(a=0.25, b=-1.0), MotorThrottles(a=0.25, b=-1.0)),
        (MotorSpeeds(a=256, b=-32768), MotorSpeeds(a=255, b=-255)),
        (SpeedSetpoints(a_rpm=1e9, b_rpm=0.0), SpeedSetpoints(a_rpm=1e9, b_rpm=0.0)),
    ],
)
def test_the_range_of_the_documents(given_, expected):
    assert clamp_command(given_) == expected


# ---- what the numbers mean

MANUAL = Dialect(
    acceleration=AccelerationUnit.M_S2, quaternion=QuaternionOrder.XYZW, position=PositionOrder.LATITUDE_FIRST
)
every_dialect = pytest.mark.parametrize("dialect", [Dialect(), MANUAL], ids=["code", "manual"])


@every_dialect
def test_meaning_and_field_are_inverse(dialect):
    where = Position(latitude_deg=-34.5, longitude_deg=-58.25)
    assert position(gps_report(where, dialect, validity=1), dialect) == where
    attitude = (1.0, 0.5, 0.25, 0.125)
    assert attitude_wxyz(ImuReport(quaternion=quaternion_raw(attitude, dialect)), dialect) == attitude
    force = (1.0, -2.0, 9.80665)
    back = acceleration_m_s2(ImuReport(acceleration=acceleration_raw(force, dialect)), dialect)
    assert back == pytest.approx(force)


def test_code_and_manual_read_the_same_report_otherwise():
    gps = GpsReport(first_deg=-58.0, second_deg=-34.0)
    assert position(gps).longitude_deg == position(gps, MANUAL).latitude_deg == -58.0
    still = ImuReport(acceleration=(0.0, 0.0, 1.0), quaternion=(1.0, 0.0, 0.0, 0.0))
    assert acceleration_m_s2(still)[2] == 9.80665
    assert acceleration_m_s2(still, MANUAL)[2] == 1.0
    assert attitude_wxyz(still) == (1.0, 0.0, 0.0, 0.0)
    assert attitude_wxyz(still, MANUAL) == (0.0, 1.0, 0.0, 0.0)


@given(st.lists(st.integers(0, 255), max_size=20), st.integers(0, 255))
def test_a_counter_that_wraps_is_followed(steps, first):
    truth = first
    totals = PacketTotals.of(GeneralReport(accepted=first, rejected=0))
    for step in steps:
        truth += step
        totals = PacketTotals.of(GeneralReport(accepted=truth % 256, rejected=0), totals)
        assert totals.accepted == truth
    assert totals.rejected == 0


def test_unwrap_never_goes_back():
    assert unwrap(255, 0) == 256
    assert unwrap(300, 44) == 300
    assert unwrap(2**32 - 1, 5, 2**32) == 2**32 + 5
