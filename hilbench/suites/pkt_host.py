"""What a host of a PKT! rover must do, faced with a scripted one: what it sends, and what it says it understood.

A client that splits its lines at newlines, as the one of the rover's author, is a profile of its own (`g0`, `g2`): its
cases hold it to the losses that come of that, and their twins say what is promised instead.
"""

from __future__ import annotations

import math
import random
from collections.abc import Callable, Collection, Sequence
from dataclasses import fields, replace
from itertools import pairwise
from typing import Any, TypeVar

import pytest

from hilbench.check import CaseSetup, Inconclusive, Untimely, Violation, at_least, at_most, case, near
from hilbench.clock import NS_PER_S
from hilbench.errors import InternalError, UnavailableError
from hilbench.suites._host_parameters import turned_round, wrong_parameters
from hilbench.suites._spoiling import other_rules
from hilbench.systems.rover.cases import HostCase
from hilbench.systems.rover.ground_station import GroundStation, Telemetry
from hilbench.systems.rover.reporting_station import ReportingStation
from hilbench.systems.rover.scripted import HeardCommand, ScriptedRover
from protocols.pkt import (
    ClientState,
    Command,
    GeneralReport,
    GpsReport,
    ImuReport,
    LedOff,
    LedOn,
    MotionReport,
    MotorSpeeds,
    MotorThrottles,
    PidGains,
    Report,
    SpeedSetpoints,
    UnknownCommand,
)
from protocols.pkt.clauses import HOST_CLAUSES
from protocols.pkt.decoding import DecodeOptions, checksum

FunctionT = TypeVar("FunctionT", bound=Callable[..., object])

_PROFILES = {clause.id: clause.profiles for clause in HOST_CLAUSES}

START_WITHIN_S = 10.0
"""How long a program may take to its first byte. A choice: a busy machine starts an interpreter in two."""

UNDERSTAND_S = 0.1
"""Until a report that is complete is understood. A choice."""

LEFT_S = 0.5
"""Until all that a host says when it leaves has come. A choice."""

TELL_WITHIN_S = 0.5
"""Until a host that tells what it understood has told it, or has done what it was told. A choice."""

SHOWN_WITHIN_S = 1.2
"""The author's client waits for the rest of a line for a second."""

MANY_IMU = 400
"""Reports for the share that is lost: its standard deviation is then 2 %."""


def on_host(clause_id: str, *, lasts_s: float) -> Callable[[FunctionT], FunctionT]:
    """Declare the case of a clause, in each of its profiles."""
    setups = {profile: CaseSetup(program=profile) for profile in _PROFILES[clause_id]}
    return case(clause_id, bench_time_s=lasts_s, setups=setups)


@pytest.fixture
def host(bench: HostCase) -> HostCase:
    """The bench, with the host begun."""
    bench.client.start()
    rover = bench.rover
    if not rover.wait(lambda: rover.bytes_received > 0 or bool(bench.client.ended()), _first_byte_s(bench)):
        if not _is_ours(bench):
            raise Untimely(
                f"the host sent nothing within {START_WITHIN_S:g} s of its start", spare_s=START_WITHIN_S / 2
            )
    elif rover.bytes_received == 0:
        raise UnavailableError(f"the host {bench.client.ended()} before it sent anything")
    return bench


def _is_ours(bench: HostCase) -> bool:
    return isinstance(bench.client.own, GroundStation)


def _first_byte_s(bench: HostCase) -> float:
    """Our own station speaks at once, where its profile lets it speak by itself."""
    return 0.5 if _is_ours(bench) else START_WITHIN_S


def _own(host: HostCase) -> GroundStation | ReportingStation:
    if host.client.own is None:
        raise InternalError("the case needs to ask the host and has not said so")
    return host.client.own


def _say(rover: ScriptedRover, data: bytes, wait_s: float = UNDERSTAND_S) -> None:
    rover.write(data)
    rover.bench.run_for(rover.line_s(len(data)) + wait_s)


def _shown(host: HostCase, kind: type[Report]) -> int:
    return _own(host).counts[kind]


def _until(host: HostCase, condition: Callable[[], bool]) -> None:
    """Give a host of somebody else's the time to tell, until a condition holds; ours has told."""
    if not _is_ours(host):
        host.rover.bench.run_until(condition, TELL_WITHIN_S)


def _never() -> bool:
    return False


# --- what it sends


@on_host("P50", lasts_s=5.5)
def test_all_is_frames(host: HostCase) -> None:
    rover = host.rover
    rover.bench.run_for(5.0)
    if rover.dropped:
        raise Violation(f"{rover.dropped[0].reason.value}: {rover.dropped[0].data.hex(' ')}", rover.evidence())
    for heard in rover.received:
        if heard.command is None or isinstance(heard.command, UnknownCommand):
            raise Violation(f"the rover has no command {heard.payload.hex(' ')}", rover.evidence())
        if wrong := wrong_parameters(heard.payload):
            raise Violation(wrong, rover.evidence())
    if wrong := turned_round([heard.payload for heard in rover.received]):
        raise Violation(wrong, rover.evidence())
    assert rover.received, "not a single frame came in five seconds"


@on_host("P51", lasts_s=10.5)
def test_heard_in_time(host: HostCase) -> None:
    rover, start_ns = host.rover, host.bench.now_ns
    rover.bench.run_for(10.0)
    times_ns = [start_ns, *(heard.at_ns for heard in rover.received if heard.at_ns > start_ns), rover.bench.now_ns]
    longest_s = max(later - earlier for earlier, later in pairwise(times_ns)) / NS_PER_S
    uncertainty_s = rover.bench.uncertainty_s(start_ns)
    at_most(longest_s, 1.0, unit="s", what="the longest silence of the host", uncertainty=uncertainty_s)


def _stops(heard: HeardCommand) -> bool:
    match heard.command:
        case MotorThrottles(a=a, b=b, flags=flags) | MotorSpeeds(a=a, b=b, flags=flags):
            return (a, b, flags & 3) == (0, 0, 3)
    return False


@on_host("P52", lasts_s=5.0)
def test_leaving_stops_the_motors(host: HostCase) -> None:
    rover = host.rover
    rover.bench.run_for(1.0)
    mark = len(rover.received)
    host.client.disconnect()
    rover.bench.run_for(LEFT_S)
    if not any(map(_stops, rover.received[mark:])):
        raise Untimely("the host left without stopping the motors", rover.evidence(), spare_s=LEFT_S)
    mark = len(rover.received)
    rover.bench.run_for(3.0)
    if len(rover.received) > mark:
        raise Untimely("the host speaks though it has left", rover.evidence(), spare_s=LEFT_S)


def _sent(host: HostCase, command: Command, before: Collection[bytes]) -> Sequence[bytes]:
    """Have the host send a command; return the frames that come of it.

    Left out are requests, and motor commands of ``before`` and of now that are said again: a rover may want that.
    """
    rover = host.rover
    mark = len(rover.received)

    def commands() -> list[bytes]:
        return [heard.raw for heard in rover.received[mark:] if heard.payload[0] and heard.raw not in before]

    _own(host).send(command)
    rover.bench.run_for(0.05)
    _until(host, lambda: bool(commands()))
    return list(dict.fromkeys(commands())) if isinstance(command, MOTOR_COMMANDS) else commands()


MOTOR_COMMANDS = (MotorThrottles, SpeedSetpoints)


@on_host("P53", lasts_s=0.9)
def test_commands_to_the_byte(host: HostCase) -> None:
    expected: dict[Command, str] = {
        LedOn(): "504B54210101F1D10A",
        LedOff(): "504B54210102C1B20A",
        MotorThrottles(a=0.5, b=-0.25): "504B54210A030000003F000080BE038C420A",
        SpeedSetpoints(a_rpm=30.0, b_rpm=30.0): "504B54210A040000F0410000F04103A1E80A",
        PidGains(kp=0.01, kd=0.0001, ki=0.0001): "504B54210D050AD7233C17B7D13817B7D138534C0A",
        MotorThrottles(a=-1.0, b=0.75, flags=1): "504B54210A03000080BF0000403F01DD870A",
        SpeedSetpoints(a_rpm=-45.5, b_rpm=60.25, flags=2): "504B54210A04000036C2000071420225000A",
        PidGains(kp=0.5, kd=-0.125, ki=0.25): "504B54210D050000003F000000BE0000803E29070A",
        MotorThrottles(a=0.125, b=1.0, flags=2): "504B54210A030000003E0000803F02F16A0A",
        SpeedSetpoints(a_rpm=10.0, b_rpm=-7.5, flags=1): "504B54210A04000020410000F0C001E86D0A",
    }
    before: list[bytes] = []
    for command, wanted in expected.items():
        sent = _sent(host, command, before)
        if sent != [bytes.fromhex(wanted)]:
            shown = ", ".join(raw.hex(" ").upper() for raw in sent) or "nothing"
            kind = Violation if sent else Untimely
            raise kind(f"{command} is {shown}, required {bytes.fromhex(wanted).hex(' ').upper()}")
        if isinstance(command, MOTOR_COMMANDS):
            before += sent


# --- what it understands


def _random_imu(seed: int, count: int) -> Sequence[bytes]:
    """Payloads of 0x82 whose bytes behind the first four are random."""
    chance = random.Random(seed)
    return [b"\x82\x03\0\0" + chance.randbytes(56) for _ in range(count)]


def _imu_shown(host: HostCase) -> float:
    """Return the share of random 0x82 that the host shows."""
    rover = host.rover
    rover.answers = False
    before = _shown(host, ImuReport)
    for payload in _random_imu(host.case.seed, MANY_IMU):
        frame = rover.frame_around(payload)
        _say(rover, frame, 0.002)
    rover.bench.run_for(SHOWN_WITHIN_S)
    _until(host, _never)
    return (_shown(host, ImuReport) - before) / MANY_IMU


def _expected_share() -> float:
    """The share of 0x82 without a newline in 56 random bytes and two of the CRC; what stands before has none."""
    return (255 / 256) ** (56 + 2)


@on_host("P36", lasts_s=6.0)
def test_line_splitting_loses_imu(host: HostCase) -> None:
    if _own(host).options.schema.name == "V1":
        _require_line_splitting(host)
        return
    share = _imu_shown(host)
    spread = math.sqrt(_expected_share() * (1 - _expected_share()) / MANY_IMU)
    near(share, _expected_share(), 4 * spread, unit="of all", what=f"the share shown of {MANY_IMU} reports")


def _require_line_splitting(host: HostCase) -> None:
    """In the first schema 0x82 has another form: general reports show the same."""
    lost = [value for value in range(256) if not _general_is_shown(host, value)]
    assert 10 in lost, "0x80 with ACC 10 is shown"
    if len(lost) == 256:
        raise Inconclusive("no report is shown at all")
    at_least(len(lost), 2, unit="reports", what="lost of 256")


@on_host("P36D", lasts_s=6.0)
def test_no_imu_is_lost(host: HostCase) -> None:
    share = _imu_shown(host)
    at_least(share, 1.0, unit="of all", what=f"the share shown of {MANY_IMU} reports")


def _general_is_shown(host: HostCase, accepted: int) -> bool:
    rover = host.rover
    before = _shown(host, GeneralReport)
    _say(rover, rover.frame(GeneralReport(accepted=accepted, status=rover.general.status)), 0.005)
    _until(host, lambda: _shown(host, GeneralReport) > before)
    return _shown(host, GeneralReport) > before


@on_host("P37", lasts_s=1.8)
def test_a_ten_is_never_shown(host: HostCase) -> None:
    host.rover.answers = False
    shown = _general_is_shown(host, 10)
    host.rover.bench.run_for(SHOWN_WITHIN_S)
    assert not shown, "0x80 with ACC 10 is shown"
    assert _general_is_shown(host, 9), "0x80 with ACC 9 is not shown either"


@on_host("P37D", lasts_s=3.0)
def test_each_count_is_shown(host: HostCase) -> None:
    host.rover.answers = False
    missing = [value for value in range(256) if not _general_is_shown(host, value)]
    assert not missing, f"0x80 is not shown with ACC {', '.join(map(str, missing))}"


def _damaged(rover: ScriptedRover) -> bytes:
    frame = rover.frame(GeneralReport(accepted=7))
    return frame[:-2] + bytes((frame[-2] ^ 0x01,)) + frame[-1:]


@on_host("P54", lasts_s=1.8)
def test_a_wrong_crc_is_shown(host: HostCase) -> None:
    host.rover.answers = False
    before = _shown(host, GeneralReport)
    _say(host.rover, _damaged(host.rover), SHOWN_WITHIN_S)
    assert _shown(host, GeneralReport) == before + 1, "0x80 with a wrong CRC is not shown"


def _wrong_crcs(rover: ScriptedRover) -> Sequence[tuple[str, bytes]]:
    """Return frames of 0x80 that are sound but for their CRC."""
    frame = rover.frame(GeneralReport(accepted=7))
    rule = checksum(DecodeOptions())
    first = rule.put(frame, bytes((rule.of(frame)[0] ^ 0x01, rule.of(frame)[1])))
    return [
        ("turned in its last byte", _damaged(rover)),
        ("turned in its first byte", first),
        *other_rules(frame, rule),
    ]


@on_host("P54D", lasts_s=1.2)
def test_a_wrong_crc_is_not_shown(host: HostCase) -> None:
    host.rover.answers = False
    before = _shown(host, GeneralReport)
    for what, frame in _wrong_crcs(host.rover):
        _say(host.rover, frame)
        _until(host, _never)
        assert _shown(host, GeneralReport) == before, f"0x80 with a CRC {what} is shown"
    assert _general_is_shown(host, 8), "the report after it is lost"


@on_host("P55", lasts_s=1.8)
def test_noise_costs_a_report(host: HostCase) -> None:
    host.rover.answers = False
    before = _shown(host, GeneralReport)
    _say(host.rover, b"abc" + host.rover.frame(GeneralReport(accepted=7)), SHOWN_WITHIN_S)
    assert _shown(host, GeneralReport) == before, "0x80 after noise is reported"
    if not _general_is_shown(host, 8):
        raise Inconclusive("0x80 without noise is not shown either")


@on_host("P55D", lasts_s=1.4)
def test_noise_costs_none(host: HostCase) -> None:
    rover = host.rover
    rover.answers = False
    frame = rover.frame(GeneralReport(accepted=7))
    for noise in (b"abc", b"PK", frame[:9], rover.frame(MotionReport())[:30]):
        before = _shown(host, GeneralReport)
        _say(rover, noise + frame * 5)
        rover.bench.run_for(1.0)  # a frame that was cut may be waited for
        _until(host, _never)
        found = _shown(host, GeneralReport) - before
        at_least(found, 5, unit="reports", what=f"of five shown behind {noise[:4].hex(' ').upper()}")


@on_host("P56", lasts_s=3.5)
def test_pieces_of_any_size(host: HostCase) -> None:
    rover = host.rover
    rover.answers = False
    before = _shown(host, MotionReport)
    for byte in rover.frame(MotionReport(throttles=(0.5, 0.5))):
        _say(rover, bytes((byte,)), 0.02)
    _until(host, lambda: _shown(host, MotionReport) > before)
    assert _shown(host, MotionReport) == before + 1, "0x83 in single bytes is not understood"
    before = _shown(host, GeneralReport)
    _say(rover, rover.frame(GeneralReport(accepted=7)) * 10)
    _until(host, _never)
    assert _shown(host, GeneralReport) == before + 10, "ten of 0x80 without a gap are not all understood"


@on_host("P57", lasts_s=7.0)
def test_silence_is_noticed(host: HostCase) -> None:
    rover, station = host.rover, _own(host)
    rover.say(rover.general)
    rover.bench.run_for(0.5)
    assert station.state is ClientState.LINKED, "the host does not know that its rover is there"
    rover.answers = False
    start_ns = rover.bench.now_ns
    lost = rover.wait(lambda: station.state is ClientState.LOST, 6.0)
    assert lost, "the host does not notice that its rover is silent"
    at_most((rover.bench.now_ns - start_ns) / NS_PER_S, 5.0, unit="s", what="the rover was lost after")
    rover.say(rover.general)
    rover.bench.run_for(0.5)
    assert station.state is ClientState.LINKED, "the host does not notice that its rover is there again"


@on_host("P58", lasts_s=0.9)
def test_unknown_reports(host: HostCase) -> None:
    rover = host.rover
    rover.answers = False
    _say(rover, rover.frame_around(b"\x8f\x01\x02\x03"))
    assert _general_is_shown(host, 8), "0x80 after an unknown report is lost"


_TELLING: Sequence[Report] = (
    GeneralReport(accepted=1, rejected=2, last_opcode=3, last_error=4, status=5),
    ImuReport(
        validity=3,
        acceleration=(0.25, -0.5, 9.75),
        rate_deg_s=(1.5, -2.5, 3.5),
        field_mgauss=(170.5, -20.25, -140.75),
        temperature_c=24.5,
        quaternion=(0.125, -0.25, 0.5, 0.75),
    ),
    MotionReport(
        rpm=(10.5, -20.5, 30.5, -40.5),
        ticks=(100, 200, 300, 70000),
        throttles=(0.25, -0.5),
        setpoints_rpm=(60.5, -70.5),
    ),
    GpsReport(validity=1, first_deg=-34.625, second_deg=-58.375),
)
"""Reports with another number in each field; a float of 32 bits has each of them to the last digit."""


def _halved(report: Report) -> Report:
    """The report with half of each of its numbers, those that are whole rounded down."""
    said = {field.name: getattr(report, field.name) for field in fields(report)}
    return replace(report, **{name: _half(value) for name, value in said.items()})


def _half(value: Any) -> Any:
    if isinstance(value, tuple):
        return tuple(map(_half, value))
    return value // 2 if isinstance(value, int) else value / 2


def _shown_of(host: HostCase, report: Report) -> Telemetry | None:
    """Say a report, which is to be shown once; return the newest of its kind that the host shows then."""
    kind, before = type(report), _shown(host, type(report))
    _say(host.rover, host.rover.frame(report))
    _until(host, lambda: _shown(host, kind) > before)
    times = _shown(host, kind) - before
    assert times <= 1, f"{kind.__name__} is shown {times} times"
    return _own(host).latest.get(kind)


@on_host("P79", lasts_s=1.8)
def test_each_field_is_understood(host: HostCase) -> None:
    rover = host.rover
    rover.answers = False
    for report in (one for telling in _TELLING for one in (_halved(telling), telling)):
        shown = _shown_of(host, report)
        name = type(report).__name__
        assert shown is not None, f"{name} is not shown"
        wrong = [
            f"{field.name} {getattr(shown.report, field.name)}, sent {getattr(report, field.name)}"
            for field in fields(report)
            if getattr(shown.report, field.name) != getattr(report, field.name)
        ]
        assert not wrong, f"{name} is shown with {'; '.join(wrong)}"


@on_host("P59", lasts_s=0.9)
def test_counters_go_on(host: HostCase) -> None:
    rover, station = host.rover, _own(host)
    rover.answers = False
    totals = []
    for accepted in (250, 5):
        assert _general_is_shown(host, accepted), f"0x80 with ACC {accepted} is not shown"
        _until(host, _never)
        assert station.totals is not None, "the host has no totals"
        totals.append(station.totals.accepted)
    near(totals[1] - totals[0], 11, 0, unit="packets", what="the total went up by")
