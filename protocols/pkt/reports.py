"""Reports: what the rover tells the host, in three schemas.

Sources: document and manual, "Referencia del protocolo de comunicación"; G0 rover-firmware application.cpp
`send_imu_report`; G1b ceai2020 at b73d4c7 and c47f7b4, and G2 at 6058e92, application.cpp `send_general_tmy_report` and
the functions behind it. Numbers of more than one byte are little-endian. The fields of a report are the raw ones; where
code and manual disagree about their meaning (g or m/s^2, which of the four is the scalar, which of the two the
latitude), `Dialect` in units.py decides.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from struct import Struct
from types import MappingProxyType

from protocols.pkt.codes import ReportId
from protocols.pkt.errors import LocalProtocolError, RemoteProtocolError
from protocols.pkt.options import Schema

__all__ = [
    "REPORTS",
    "EulerImuReport",
    "ExecutionReport",
    "GeneralReport",
    "GpsReport",
    "ImuReport",
    "MotionReport",
    "MotionReportV1b",
    "PidReport",
    "Report",
    "ReportSpec",
    "UnknownReport",
    "decode_report",
    "encode_report",
    "report_id",
]

Triple = tuple[float, float, float]
Four = tuple[float, float, float, float]
Counts = tuple[int, int, int, int]

_NO_TRIPLE: Triple = (0.0, 0.0, 0.0)
_NO_FOUR: Four = (0.0, 0.0, 0.0, 0.0)
_NO_COUNTS: Counts = (0, 0, 0, 0)


@dataclass(frozen=True, slots=True, kw_only=True)
class GeneralReport:
    """0x80: how many packets the rover took and what became of the last one.

    Attributes:
        accepted: sound packets taken, without REQUEST_TMY, modulo 256.
        rejected: errors of the decoder, modulo 256.
        last_opcode: of the last packet taken.
        last_error: see `ErrorCode`: of the last packet taken or rejected, whichever was later.
        status: see `StatusFlag`; None where the report ends before it, as in the tables of document and manual.
    """

    accepted: int = 0
    rejected: int = 0
    last_opcode: int = 0
    last_error: int = 0
    status: int | None = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class ExecutionReport:
    """0x81: what became of one command. No firmware ever sends it.

    Attributes:
        opcode: of the command.
        error: see `ErrorCode`.
    """

    opcode: int
    error: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class ImuReport:
    """0x82 of 60 bytes (G1b from c47f7b4 on, G2): inertial sensor, compass, attitude; X, Y, Z.

    Attributes:
        validity: bit 0 MPU9250 read, bit 1 magnetometer read; reserved in the manual.
        acceleration: see `Dialect`.
        rate_deg_s: angular rate.
        field_mgauss: magnetic field.
        temperature_c: of the chip.
        quaternion: the estimated attitude; see `Dialect`.
    """

    validity: int = 0
    acceleration: Triple = _NO_TRIPLE
    rate_deg_s: Triple = _NO_TRIPLE
    field_mgauss: Triple = _NO_TRIPLE
    temperature_c: float = 0.0
    quaternion: Four = _NO_FOUR


@dataclass(frozen=True, slots=True, kw_only=True)
class EulerImuReport:
    """0x82 of 68 bytes (G0, G1): as above, but with two estimates of three angles instead of the quaternion.

    Attributes:
        validity: 1 if the IMU works.
        acceleration: as the sensor's driver has it.
        rate_deg_s: angular rate.
        field_mgauss: magnetic field.
        temperature_c: of the chip.
        magnetic_angles_rad: from accelerometer and compass.
        gyro_angles_rad: from the summed rates.
    """

    validity: int = 0
    acceleration: Triple = _NO_TRIPLE
    rate_deg_s: Triple = _NO_TRIPLE
    field_mgauss: Triple = _NO_TRIPLE
    temperature_c: float = 0.0
    magnetic_angles_rad: Triple = _NO_TRIPLE
    gyro_angles_rad: Triple = _NO_TRIPLE


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionReport:
    """0x83 of 52 bytes (G2): wheels and motors.

    Attributes:
        rpm: wheel speeds without a sign, of tachometers 1 to 4: left front, right front, left back, right back.
        ticks: slots counted since the start, modulo 2^32, of the same.
        throttles: left and right pair, -1..1.
        setpoints_rpm: left and right pair.
    """

    rpm: Four = _NO_FOUR
    ticks: Counts = _NO_COUNTS
    throttles: tuple[float, float] = (0.0, 0.0)
    setpoints_rpm: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionReportV1b:
    """0x83 of 48 bytes (G1b from c47f7b4 on) or, without ticks, of 32 (b73d4c7).

    Attributes:
        rpm: as above.
        ticks: as above; None where there are none.
        throttles: the speeds last commanded, int16.
        setpoints_rpm: left and right pair.
    """

    rpm: Four = _NO_FOUR
    ticks: Counts | None = _NO_COUNTS
    throttles: tuple[int, int] = (0, 0)
    setpoints_rpm: tuple[float, float] = (0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class GpsReport:
    """0x84 of 12 bytes (G1b, G2): where the rover is.

    Attributes:
        validity: whether the position is known; G2 never writes this byte.
        first_deg: see `Dialect`.
        second_deg: see `Dialect`.
    """

    validity: int = 0
    first_deg: float = 0.0
    second_deg: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PidReport:
    """0x85 of 24 bytes (G2): the gains of the left pair's controller. Nothing in G2 ever sends it.

    Attributes:
        validity: never written.
        maximum: of the controller's output.
        minimum: of the controller's output.
        kp: throttle per rpm.
        kd: throttle per (rpm/s).
        ki: throttle per (rpm s).
    """

    validity: int = 0
    maximum: float = 1.0
    minimum: float = -1.0
    kp: float = 0.0
    kd: float = 0.0
    ki: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class UnknownReport:
    """A report whose id the schema does not have.

    Attributes:
        report_id: the id byte.
        data: what follows it.
    """

    report_id: int
    data: bytes = b""


_Known = (
    GeneralReport
    | ExecutionReport
    | ImuReport
    | EulerImuReport
    | MotionReport
    | MotionReportV1b
    | GpsReport
    | PidReport
)
Report = _Known | UnknownReport


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportSpec:
    """One form of a report.

    Attributes:
        report: its first byte.
        kind: the class that holds it.
        layout: the `struct` format of what follows; pad bytes are zero.
        counts: how many items of the layout each field of the class takes; 0 for a field that is not there.
        text: the fields in words.
        source: where that is written.
    """

    report: ReportId
    kind: type[_Known]
    layout: str
    counts: tuple[int, ...]
    text: str
    source: str

    @property
    def size(self) -> int:
        """The payload's size, in bytes, with the id."""
        return 1 + Struct(self.layout).size


_GENERAL = ReportSpec(
    report=ReportId.GENERAL,
    kind=GeneralReport,
    layout="<BBBBB",
    counts=(1, 1, 1, 1, 1),
    text="ACCEPTED, REJECTED, LAST_OPCODE, LAST_ERROR, STATUS",
    source="all firmware, application.cpp send_general_tmy_report",
)
_GENERAL_SHORT = ReportSpec(
    report=ReportId.GENERAL,
    kind=GeneralReport,
    layout="<BBBB",
    counts=(1, 1, 1, 1, 0),
    text="ACCEPTED, REJECTED, LAST_OPCODE, LAST_ERROR",
    source="document and manual, 0x80",
)
_EXECUTION = ReportSpec(
    report=ReportId.EXECUTION_STATUS,
    kind=ExecutionReport,
    layout="<BB",
    counts=(1, 1),
    text="OPCODE, STATUS_CODE",
    source="document and manual, 0x81",
)
_IMU = ReportSpec(
    report=ReportId.IMU,
    kind=ImuReport,
    layout="<Bxx14f",
    counts=(1, 3, 3, 3, 1, 4),
    text="validity, 2 zero, acceleration x y z, rate x y z, field x y z, temperature, quaternion",
    source="manual, 0x82; G2 application.cpp send_imu_report",
)
_IMU_EULER = ReportSpec(
    report=ReportId.IMU,
    kind=EulerImuReport,
    layout="<Bxx16f",
    counts=(1, 3, 3, 3, 1, 3, 3),
    text="validity, 2 zero, acceleration x y z, rate x y z, field x y z, temperature, two times three angles",
    source="G0 application.cpp send_imu_report",
)
_MOTION = ReportSpec(
    report=ReportId.MOTION,
    kind=MotionReport,
    layout="<xxx4f4I2f2f",
    counts=(4, 4, 2, 2),
    text="3 zero, rpm of 4 wheels, ticks of 4 wheels u32, throttles A B, setpoints A B in rpm",
    source="manual, 0x83; G2 application.cpp send_motion_control_report",
)
_MOTION_V1B = ReportSpec(
    report=ReportId.MOTION,
    kind=MotionReportV1b,
    layout="<xxx4f4I2h2f",
    counts=(4, 4, 2, 2),
    text="3 zero, rpm of 4 wheels, ticks of 4 wheels u32, throttles A B int16, setpoints A B in rpm",
    source="G1b at c47f7b4, application.cpp send_motion_control_report",
)
_MOTION_NO_TICKS = ReportSpec(
    report=ReportId.MOTION,
    kind=MotionReportV1b,
    layout="<xxx4f2h2f",
    counts=(4, 0, 2, 2),
    text="3 zero, rpm of 4 wheels, throttles A B int16, setpoints A B in rpm",
    source="G1b at b73d4c7, application.cpp send_motion_control_report",
)
_GPS = ReportSpec(
    report=ReportId.GPS,
    kind=GpsReport,
    layout="<Bxx2f",
    counts=(1, 1, 1),
    text="validity, 2 zero, longitude, latitude (manual: latitude, longitude)",
    source="G2 application.cpp send_gps_report; manual, 0x84",
)
_PID = ReportSpec(
    report=ReportId.PID,
    kind=PidReport,
    layout="<Bxx5f",
    counts=(1, 1, 1, 1, 1, 1),
    text="validity, 2 zero, maximum, minimum, kp, kd, ki",
    source="G2 application.cpp send_pid_report",
)

_EVERYWHERE = (_GENERAL, _GENERAL_SHORT, _EXECUTION)
REPORTS: Mapping[Schema, tuple[ReportSpec, ...]] = MappingProxyType(
    {
        Schema.V1: (*_EVERYWHERE, _IMU_EULER),
        Schema.V1B: (*_EVERYWHERE, _IMU, _IMU_EULER, _MOTION_V1B, _MOTION_NO_TICKS, _GPS),
        Schema.V2: (*_EVERYWHERE, _IMU, _MOTION, _GPS, _PID),
    }
)
"""Every form of every report of each schema; forms of one report differ in size."""

_LAYOUTS = {spec.layout: Struct(spec.layout) for specs in REPORTS.values() for spec in specs}
_BY_SIZE = {schema: {(int(s.report), s.size): s for s in specs} for schema, specs in REPORTS.items()}
_IDS = {schema: frozenset(int(spec.report) for spec in specs) for schema, specs in REPORTS.items()}


def report_id(report: Report) -> int:
    """The first byte of a report."""
    if isinstance(report, UnknownReport):
        return report.report_id
    return next(int(s.report) for specs in REPORTS.values() for s in specs if s.kind is type(report))


def encode_report(report: Report, schema: Schema = Schema.V2) -> bytes:
    """The payload of a report.

    Raises:
        LocalProtocolError: the schema does not have it, or a field does not fit its place.
    """
    if isinstance(report, UnknownReport):
        if not 0 <= report.report_id <= 0xFF:
            raise LocalProtocolError(f"report_id {report.report_id} is not 0..255")
        return bytes((report.report_id,)) + report.data
    fields = [getattr(report, name) for name in report.__slots__]
    spec = _form(report, fields, schema)
    try:
        values = [value for field in fields if field is not None for value in _items(field)]
        return bytes((spec.report,)) + _LAYOUTS[spec.layout].pack(*values)
    except (struct.error, OverflowError) as error:
        raise LocalProtocolError(f"{report} does not fit schema {schema.name}: {error}") from None


def decode_report(payload: bytes, schema: Schema = Schema.V2) -> Report:
    """The report in a frame's payload.

    Raises:
        RemoteProtocolError: the payload is empty, or no form of this report has its size.
    """
    if not payload:
        raise RemoteProtocolError("an empty payload holds no report id")
    spec = _BY_SIZE[schema].get((payload[0], len(payload)))
    if spec is None:
        if payload[0] in _IDS[schema]:
            raise RemoteProtocolError(f"report {payload[0]:02X} has no form of {len(payload)} bytes")
        return UnknownReport(report_id=payload[0], data=payload[1:])
    values = _LAYOUTS[spec.layout].unpack_from(payload, 1)
    fields: dict[str, object] = {}
    at = 0
    for name, count in zip(spec.kind.__slots__, spec.counts, strict=True):
        item = values[at] if count == 1 else values[at : at + count]
        fields[name] = item if count else None
        at += count
    return spec.kind(**fields)  # type: ignore[arg-type]


def _form(report: _Known, fields: list[object], schema: Schema) -> ReportSpec:
    """The form that holds all fields that are there."""
    there = [field is not None for field in fields]
    for spec in REPORTS[schema]:
        if spec.kind is type(report) and [bool(count) for count in spec.counts] == there:
            return spec
    raise LocalProtocolError(f"{type(report).__name__} is no report of schema {schema.name}")


def _items(field: object) -> tuple[object, ...]:
    return field if isinstance(field, tuple) else (field,)
