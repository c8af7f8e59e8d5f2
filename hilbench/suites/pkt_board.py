"""What a rover must do, frame by frame: every case of the PKT! catalogue, each in the profiles that hold it.

A case sends bytes and looks at the counters of the general report, at other reports, and at what somebody beside the
rover sees: LED, wheels, motor voltage. Stimuli are written as on the wire wherever the bytes are the point.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator, Sequence
from itertools import pairwise

import pytest

from hilbench.check import Inconclusive, Violation, at_least, at_most, near, within
from hilbench.check.provider import CaseBench
from hilbench.check.recorder import record_measure
from hilbench.clock import NS_PER_S
from hilbench.rover_hands import RoverBench
from hilbench.suites._rover import DONE_S, Counts, Rover, on_rover, rover_bench
from protocols.pkt import (
    TERMINATOR,
    Command,
    EulerImuReport,
    ExecutionReport,
    GeneralReport,
    GpsReport,
    ImuReport,
    LedOff,
    LedOn,
    MotionReport,
    MotorThrottles,
    PidGains,
    Report,
    RequestTelemetry,
    SpeedSetpoints,
    hides_newline,
)

REQUEST, REQUEST_TERM = bytes.fromhex("504B54210100E1F00A"), bytes.fromhex("504B542100E1F00A")
REQUEST_OF_AUTHOR = bytes.fromhex("504B5421020000 1D0F0A")
LED_ON, LED_ON_TERM = bytes.fromhex("504B54210101F1D10A"), bytes.fromhex("504B542101F1D10A")
LED_OFF, LED_OFF_TERM = bytes.fromhex("504B54210102C1B20A"), bytes.fromhex("504B542102C1B20A")
NO_LENGTH = bytes.fromhex("504B542100")
UNKNOWN = bytes.fromhex("504B5421017F6E880A")
CUT_THROTTLE = bytes.fromhex("504B54210A030000")

SUCCESS, BAD_SYNC, INVALID_LENGTH, BAD_CRC, BAD_TERMINATOR, UNKNOWN_OPCODE = range(6)

PACE_S = 0.015
"""Between two of many frames: a receiver that looks every 10 ms and keeps 256 bytes is not run over."""

FIX_WITHIN_S = 60.0
"""How long a GPS receiver may take (u-blox NEO-6 data sheet: 27 s from a cold start)."""

POSITION_DEG = 0.001
"""110 m along a meridian: enough to tell latitude from longitude, and much more than a receiver's error. A choice."""


@pytest.fixture
def there(bench: CaseBench) -> RoverBench:
    """The bench, power just on."""
    return rover_bench(bench)


@pytest.fixture
def rover(there: RoverBench) -> Rover:
    """The rover under test, which answers."""
    return Rover(there)


def _led_on(rover: Rover) -> bytes:
    return rover.peer.frame_of(LedOn())


# --- commands and their counters


@on_rover("P01", lasts_s=0.6)
def test_request_is_answered(rover: Rover) -> None:
    rover.after_periodic()
    mark = rover.mark()
    rover.write(rover.peer.frame_of(RequestTelemetry()))
    replies = [got for got, _ in rover.peer.since(mark, GeneralReport)]
    if len(replies) != 1:
        raise Violation(f"{len(replies)} of 0x80 came, required one", rover.peer.evidence())
    before = rover.before
    fields = [before.accepted, before.rejected, before.last_opcode, before.last_error]
    expected = rover.peer.frame(bytes([0x80, *fields, *([] if before.status is None else [before.status])]))
    assert replies[0].raw == expected, f"the answer is {replies[0].raw.hex(' ')}, required {expected.hex(' ')}"
    rover.require(0, 0, None, None)


@on_rover("P02", lasts_s=0.6)
def test_led_on_as_shipped(rover: Rover) -> None:
    rover.dark()
    mark = rover.mark()
    rover.write(LED_ON)
    rover.require(1, 0, 1, SUCCESS)
    assert rover.lit, "LED_ON does not light the LED"
    rover.require_executions(mark)


@on_rover("P02D", lasts_s=0.6)
def test_led_on_is_reported(rover: Rover) -> None:
    rover.dark()
    mark = rover.mark()
    rover.write(_led_on(rover))
    rover.require(1, 0, 1, SUCCESS)
    assert rover.lit, "LED_ON does not light the LED"
    rover.require_executions(mark, ExecutionReport(opcode=1, error=0))


@on_rover("P03", lasts_s=0.6)
def test_each_packet_counts(rover: Rover) -> None:
    for _ in range(2):
        rover.send(LedOff())
    rover.require(2, 0, 2, SUCCESS)


@on_rover("P04", lasts_s=0.6)
def test_unknown_opcode_is_accepted(rover: Rover) -> None:
    rover.write(UNKNOWN)
    rover.require(1, 0, 0x7F, UNKNOWN_OPCODE)


@on_rover("P04D", lasts_s=0.6)
def test_unknown_opcode_is_reported(rover: Rover) -> None:
    mark = rover.mark()
    rover.write(UNKNOWN)
    rover.require_executions(mark, ExecutionReport(opcode=0x7F, error=UNKNOWN_OPCODE))


@on_rover("P64", lasts_s=0.8)
def test_each_command_is_reported(rover: Rover) -> None:
    commands: Sequence[Command] = (
        LedOn(),
        LedOff(),
        MotorThrottles(a=0.0, b=0.0),
        SpeedSetpoints(a_rpm=0.0, b_rpm=0.0),
        PidGains(kp=0.01, kd=0.0001, ki=0.0001),
    )
    for opcode, command in enumerate(commands, start=1):
        mark = rover.mark()
        rover.send(command)
        rover.require_executions(mark, ExecutionReport(opcode=opcode, error=SUCCESS))
    _require_refused(rover, b"\x03")


def _require_refused(rover: Rover, payload: bytes) -> None:
    """Require that a command is accepted and not carried out, and that 0x81 says so."""
    before, mark = rover.counts, rover.mark()
    rover.write(rover.peer.frame(payload))
    found, opcode = rover.counts, payload[0]
    counted = ((found.accepted - before.accepted) % 256, found.rejected - before.rejected, found.opcode)
    if counted != (1, 0, opcode) or found.error == SUCCESS:
        raise Violation(f"the state is {found} after {before}, required one more, and an error", rover.peer.evidence())
    rover.require_executions(mark, ExecutionReport(opcode=opcode, error=found.error))


# --- frames that are wrong


def _require_rejected(rover: Rover, stimulus: bytes, error: int) -> None:
    """Require that bytes are rejected, once, and light no LED."""
    rover.dark()
    rover.write(stimulus)
    rover.require(0, 1, None, error)
    rover.require_dark()


@on_rover("P05", lasts_s=0.6)
def test_wrong_crc(rover: Rover) -> None:
    _require_rejected(rover, bytes.fromhex("504B5421010100000A"), BAD_CRC)


@on_rover("P06", lasts_s=0.6)
def test_wrong_terminator(rover: Rover) -> None:
    _require_rejected(rover, LED_ON[:-1] + b"X", BAD_TERMINATOR)


@on_rover("P07", lasts_s=0.6)
def test_length_of_zero(rover: Rover) -> None:
    _require_rejected(rover, bytes.fromhex("504B542100"), INVALID_LENGTH)


@on_rover("P08", lasts_s=0.8)
def test_length_beyond_the_limit(rover: Rover) -> None:
    rover.write(bytes.fromhex("504B542161"))
    rover.require(0, 1, None, INVALID_LENGTH)
    rover.write(bytes.fromhex("504B5421FF"))
    rover.require(0, 2, None, INVALID_LENGTH)


@on_rover("P09", lasts_s=0.6)
def test_longest_payload(rover: Rover) -> None:
    rover.write(rover.peer.frame(b"\x01" + bytes(95)))
    rover.require(1, 0, 1, SUCCESS)


@on_rover("P10", lasts_s=0.6)
def test_broken_sync_word(rover: Rover) -> None:
    rover.write(bytes.fromhex("504B5821"))
    rover.require(0, 1, None, BAD_SYNC)


# --- a frame behind something else


@on_rover("P11", lasts_s=0.6)
def test_a_p_too_many_as_shipped(rover: Rover) -> None:
    _require_rejected(rover, b"P" + LED_ON, BAD_SYNC)


@on_rover("P11D", lasts_s=0.6)
def test_a_p_too_many(rover: Rover) -> None:
    rover.dark()
    rover.write(b"P" + LED_ON)
    rover.require(1, 1, 1, SUCCESS)
    assert rover.lit, "the frame behind the P was not executed"


@on_rover("P12", lasts_s=0.6)
def test_a_piece_of_a_sync_word_as_shipped(rover: Rover) -> None:
    rover.after_periodic()
    mark = rover.mark()
    rover.write(b"PK" + REQUEST_OF_AUTHOR)
    if rover.peer.since(mark, GeneralReport):
        raise Violation("the request was answered", rover.peer.evidence(mark))
    rover.require(0, 1, None, BAD_SYNC)


@on_rover("P12D", lasts_s=0.6)
def test_a_piece_of_a_sync_word(rover: Rover) -> None:
    rover.after_periodic()
    mark = rover.mark()
    rover.write(b"PK" + REQUEST_OF_AUTHOR)
    answers = [report for _, report in rover.peer.since(mark, GeneralReport)]
    if not answers:
        raise Violation("the request was not answered", rover.peer.evidence())
    rover.require(0, 1, None, BAD_SYNC)


@on_rover("P60", lasts_s=0.9)
def test_a_p_begins_a_frame_anywhere(rover: Rover) -> None:
    for count, broken in enumerate((b"P", b"PK", b"PKT", LED_ON[:-1]), start=1):
        rover.write(broken + LED_OFF)
        rover.require(count, count, 2, SUCCESS)


@on_rover("P13", lasts_s=0.6)
def test_noise(rover: Rover) -> None:
    rover.write(b"abcdefg\n" + _led_on(rover))
    rover.require(1, 0, 1, SUCCESS)


@on_rover("P14", lasts_s=0.6)
def test_noise_with_a_p(rover: Rover) -> None:
    rover.write(b"PING" + _led_on(rover))
    rover.require(1, 1, 1, SUCCESS)


@on_rover("P15", lasts_s=0.6)
def test_a_cut_frame_swallows_the_next(rover: Rover) -> None:
    _require_rejected(rover, CUT_THROTTLE + LED_ON, BAD_CRC)


@on_rover("P16", lasts_s=0.6)
def test_a_cut_frame_swallows_one_frame(rover: Rover) -> None:
    rover.write(CUT_THROTTLE + LED_ON * 3)
    rover.require(2, 1, 1, SUCCESS)


@on_rover("P16D", lasts_s=0.6)
def test_a_cut_frame_costs_one_at_most(rover: Rover) -> None:
    rover.write(CUT_THROTTLE + LED_ON * 3)
    found = rover.counts
    if found.accepted not in (2, 3) or found.rejected < 1 or found.error != SUCCESS:
        raise Violation(f"the state is {found}, required 2 or 3 accepted, 1 or more rejected, error 0")


@on_rover("P17", lasts_s=0.6)
def test_a_frame_without_a_length(rover: Rover) -> None:
    rover.write(LED_ON_TERM)
    rover.require(0, 1, None, BAD_CRC)


@on_rover("P18", lasts_s=0.6)
def test_a_frame_without_a_length_costs_no_other(rover: Rover) -> None:
    rover.write(LED_ON_TERM + LED_ON)
    rover.require(1, 1, 1, SUCCESS)


@on_rover("P19", lasts_s=1.0)
def test_newlines_in_a_payload(rover: Rover) -> None:
    rover.write(rover.peer.frame(bytes.fromhex("030A0A0A3E0000000003")))
    rover.require(1, 0, 3, SUCCESS)
    rover.require_throttles(rover.motion(), 0.1348, 0.0)


@on_rover("P20", lasts_s=0.6)
def test_two_frames_in_one_write(rover: Rover) -> None:
    rover.write(_led_on(rover) + rover.peer.frame_of(LedOff()))
    rover.require(2, 0, 2, SUCCESS)


@on_rover("P21", lasts_s=7.0)
def test_accepted_wraps(rover: Rover) -> None:
    peer = rover.peer
    for count in range(256):
        peer.write(_led_on(rover))
        peer.run(peer.line_s(len(LED_ON)) + PACE_S)
        if count == 254:
            rover.require(255, 0, 1, SUCCESS)
    rover.require(0, 0, 1, SUCCESS)


@on_rover("P65", lasts_s=6.0)
def test_rejected_wraps(rover: Rover) -> None:
    peer = rover.peer
    for count in range(256):
        peer.write(NO_LENGTH)
        peer.run(peer.line_s(len(NO_LENGTH)) + PACE_S)
        if count == 254:
            rover.require(0, 255, None, INVALID_LENGTH)
    rover.require(0, 0, None, INVALID_LENGTH)


# --- parameters


@on_rover("P22", lasts_s=0.6)
def test_missing_parameters_as_shipped(rover: Rover) -> None:
    rover.write(rover.peer.frame(b"\x03"))
    rover.require(1, 0, 3, SUCCESS)


@on_rover("P22D", lasts_s=1.6)
def test_missing_parameters(rover: Rover) -> None:
    rover.drive(0.5, -0.25)
    rover.write(rover.peer.frame(b"\x03"))
    found = rover.counts
    if (found.accepted, found.rejected, found.opcode) != (2, 0, 3) or found.error == SUCCESS:
        raise Violation(f"the state is {found}, required 2/0/3 and an error", rover.peer.evidence())
    rover.require_throttles(rover.motion(), 0.5, -0.25)


@on_rover("P66", lasts_s=1.6)
def test_missing_parameters_of_the_speed_control(rover: Rover) -> None:
    rover.send(SpeedSetpoints(a_rpm=30.0, b_rpm=-20.0))
    for opcode in (b"\x04", b"\x05"):
        for parameters in (b"", struct.pack("<ff", 1.0, 2.0)):
            _require_refused(rover, opcode + parameters)
    rover.require_setpoints(rover.motion(), 30.0, -20.0)


@on_rover("P27", lasts_s=2.6)
def test_flags(rover: Rover) -> None:
    rover.drive(0.5, -0.25)
    rover.send(MotorThrottles(a=0.125, b=0.125, flags=1))
    rover.require(2, 0, 3, SUCCESS)
    rover.require_throttles(rover.motion(), 0.125, -0.25)
    rover.send(MotorThrottles(a=0.75, b=0.75, flags=0))
    rover.require(3, 0, 3, SUCCESS)
    rover.require_throttles(rover.motion(), 0.125, -0.25)
    rover.send(MotorThrottles(a=0.75, b=0.375, flags=2))
    rover.require_throttles(rover.motion(), 0.125, 0.375)


@on_rover("P28", lasts_s=1.0)
def test_throttle_beyond_one_as_shipped(rover: Rover) -> None:
    rover.drive(1.5, 1.5)
    rover.require_throttles(rover.motion(), 1.5, 1.5)
    for name, duty in zip("AB", rover.duties, strict=True):
        near(duty, 1.0, 0.01, unit="of full", what=f"duty {name}")


@on_rover("P28D", lasts_s=3.0)
def test_throttle_beyond_one(rover: Rover) -> None:
    for throttle in (1.5, -2.0, math.nan):
        rover.drive(throttle, throttle)
        for name, shown in zip("AB", rover.motion().throttles, strict=True):
            if math.isnan(shown):
                raise Violation(f"0x83 shows no number as throttle {name} after {throttle}", rover.peer.evidence())
            within(shown, -1.0, 1.0, unit="of full", what=f"throttle {name} in 0x83 after {throttle}")


# --- time


FRAME_S, IN_TIME_S, TOO_LATE_S = 1.0, 0.9, 1.1
"""The time of a frame (G2 config.h, PACKET_TIMEOUT_IN_MS), and how near to it both sides are looked at. Choices."""


def _cut_led_on(rover: Rover, pause_s: float) -> None:
    rover.write(LED_ON[:6])
    rover.peer.run(pause_s)
    rover.write(LED_ON[6:])


@on_rover("P23", lasts_s=31.0)
def test_half_a_frame_waits_for_ever(rover: Rover) -> None:
    _cut_led_on(rover, 30.0)
    rover.require(1, 0, 1, SUCCESS)


@on_rover("P23D", lasts_s=39.5)
def test_half_a_frame_is_forgotten(rover: Rover) -> None:
    """The frame that is in time is sent at several times: no beat of the rover's own may cut it short."""
    for pause_s in (30.0, TOO_LATE_S):
        _cut_led_on(rover, pause_s)
        rover.require(0, 0, None, None)
    for count, wait_s in enumerate((0.1, 0.25, 0.4, 0.55, 0.7), start=1):
        rover.peer.run(wait_s)
        start_ns = rover.peer.bench.now_ns
        _cut_led_on(rover, IN_TIME_S)
        if rover.peer.uncertainty_s(start_ns) > FRAME_S - IN_TIME_S:
            raise Inconclusive("the bench was too late to say whether the frame was in time")
        rover.require(count, 0, 1, SUCCESS)


@on_rover("P61", lasts_s=10.5)
def test_half_a_frame_is_forgotten_anywhere(rover: Rover) -> None:
    for size in range(1, len(LED_ON)):
        rover.write(LED_ON[:size])
        rover.peer.run(1.2)
        rover.write(LED_OFF)
        rover.require(size, 0, 2, SUCCESS)


@on_rover("P24", lasts_s=11.0)
def test_a_lost_link_changes_nothing(rover: Rover) -> None:
    rover.drive(0.5, -0.25)
    rover.peer.run(10.0)
    rover.require_throttles(rover.next(MotionReport, 0.6), 0.5, -0.25)


@on_rover("P24D", lasts_s=9.0)
def test_a_lost_link_stops_the_motors(rover: Rover) -> None:
    rover.drive(0.5, -0.25)
    rover.keep_alive(3.0)
    if not all(rover.duties):
        raise Violation(f"the motors stand though the link is kept up: {rover.duties}", rover.peer.evidence())
    rover.drive(0.5, -0.25)
    sent_ns = rover.peer.bench.now_ns - round(DONE_S * NS_PER_S)
    rover.stop_s(sent_ns, 1.1)
    rover.keep_alive(2.0)
    if rover.duties != (0.0, 0.0):
        raise Violation("the motors run again though nothing has commanded them", rover.peer.evidence())
    rover.drive(0.5, -0.25)
    if not all(rover.duties):
        raise Violation("the motors do not obey any more", rover.peer.evidence())


@on_rover("P62", lasts_s=7.0)
def test_a_lost_link_ends_speed_control(rover: Rover) -> None:
    rover.hands.hold_wheels(True)
    rover.send(SpeedSetpoints(a_rpm=60.0, b_rpm=-60.0))
    rover.keep_alive(2.0)
    if not all(rover.duties):
        raise Violation(f"the motors stand though the link is kept up: {rover.duties}", rover.peer.evidence())
    rover.send(SpeedSetpoints(a_rpm=60.0, b_rpm=-60.0))
    sent_ns = rover.peer.bench.now_ns - round(DONE_S * NS_PER_S)
    rover.stop_s(sent_ns, 1.1)
    rover.keep_alive(1.0)
    if rover.duties != (0.0, 0.0):
        raise Violation("the motors run again though nothing has commanded them", rover.peer.evidence())
    report = rover.motion()
    rover.require_throttles(report, 0.0, 0.0)
    rover.require_setpoints(report, 0.0, 0.0)
    rover.send(SpeedSetpoints(a_rpm=60.0, b_rpm=60.0, flags=1))
    left, right = rover.duties
    at_least(left, 0.3, unit="of full", what="duty A after a setpoint for A alone")
    near(right, 0.0, 0.1, unit="of full", what="duty B after a setpoint for A alone")


def _eleven_bytes(rover: Rover, times: int) -> Counts:
    """Send a frame of eleven bytes several times, each at another time of a receiver that looks every 10 ms."""
    frame = rover.peer.frame(bytes.fromhex("010000"))
    for count in range(times):
        rover.write(frame)
        rover.peer.run(0.0213 * (count % 4))
    return rover.counts


@on_rover("P25", lasts_s=1.2)
def test_eleven_bytes_are_lost(rover: Rover) -> None:
    """A line can cut the eleven bytes in two looks; most of the times it does not."""
    found = _eleven_bytes(rover, 8)
    if rover.peer.line_s(11) > 0.005:
        raise Inconclusive("the line is too slow for eleven bytes in one look of 10 ms")
    if found.accepted > 4 or found.rejected:
        raise Violation(f"the state is {found} after eight frames, most of which have to be lost without a count")


@on_rover("P25D", lasts_s=1.2)
def test_eleven_bytes_are_a_frame(rover: Rover) -> None:
    found = _eleven_bytes(rover, 8)
    if (found.accepted, found.rejected, found.opcode, found.error) != (8, 0, 1, SUCCESS):
        raise Violation(f"the state is {found}, required 8/0/1/0 after eight frames", rover.peer.evidence())


@on_rover("P30", lasts_s=11.0)
def test_periodic_reports(rover: Rover) -> None:
    """Where the bench was late, as many reports are uncertain as come in that time."""
    mark, start_ns = rover.mark(), rover.peer.bench.now_ns
    rover.peer.run(10.0)
    uncertainty_s = rover.peer.uncertainty_s(start_ns)
    wanted: Sequence[tuple[int, type[Report], int, int]] = (
        (0x80, GeneralReport, 30, 31),
        (0x83, MotionReport, 40, 41),
        (0x82, ImuReport, 10, 11),
        (0x84, GpsReport, 10, 11),
    )
    for number, kind, least, most in wanted:
        count = len(rover.peer.since(mark, kind))
        uncertain = round(most / 10 * uncertainty_s)
        within(count, least, most, unit="reports", what=f"0x{number:02X} in 10 s", uncertainty=uncertain)


# --- speed control, with the wheels in somebody's hand


def _held_throttle(rover: Rover) -> MotionReport:
    """Hold the wheels, command 30 rpm just behind a 0x83, and return the next one, a quarter of a second later."""
    rover.hands.hold_wheels(True)
    rover.next(MotionReport, 0.6)
    rover.send(SpeedSetpoints(a_rpm=30.0, b_rpm=30.0))
    return rover.next(MotionReport, 0.6)


@on_rover("P26", lasts_s=1.2)
def test_speed_controller(rover: Rover) -> None:
    report = _held_throttle(rover)
    for name, throttle, setpoint in zip("AB", report.throttles, report.setpoints_rpm, strict=True):
        near(throttle, 0.3008, 0.001, unit="of full", what=f"throttle {name} after 0.25 s")
        near(setpoint, 30.0, 1e-3, unit="rpm", what=f"setpoint {name}")


@on_rover("P63", lasts_s=3.2)
def test_setpoints_and_flags(rover: Rover) -> None:
    rover.hands.hold_wheels(True)
    rover.send(SpeedSetpoints(a_rpm=30.0, b_rpm=-20.0))
    report = rover.motion()
    rover.require_setpoints(report, 30.0, -20.0)
    rover.require_throttles(report, 0.3, -0.2, 0.05)
    steps = ((10.0, 10.0, 1, (10.0, -20.0)), (50.0, 50.0, 0, (10.0, -20.0)), (40.0, 15.0, 2, (10.0, 15.0)))
    for count, (a_rpm, b_rpm, flags, (left_rpm, right_rpm)) in enumerate(steps, start=2):
        rover.send(SpeedSetpoints(a_rpm=a_rpm, b_rpm=b_rpm, flags=flags))
        rover.require(count, 0, 4, SUCCESS)
        report = rover.motion()
        rover.require_setpoints(report, left_rpm, right_rpm)
        rover.require_throttles(report, left_rpm / 100, right_rpm / 100, 0.05)


@on_rover("P38", lasts_s=1.4)
def test_gains_as_shipped(rover: Rover) -> None:
    rover.write(rover.peer.frame(b"\x01" + bytes(20)))
    rover.send(PidGains(kp=0.0, kd=0.01, ki=0.0))
    for name, throttle in zip("AB", _held_throttle(rover).throttles, strict=True):
        near(throttle, 0.3, 0.001, unit="of full", what=f"throttle {name} after 0.25 s")


@on_rover("P38D", lasts_s=1.4)
def test_gains(rover: Rover) -> None:
    rover.send(PidGains(kp=0.02, kd=0.0, ki=0.0))
    for name, throttle in zip("AB", _held_throttle(rover).throttles, strict=True):
        near(throttle, 0.6, 0.001, unit="of full", what=f"throttle {name} after 0.25 s")


FAST_RPM = 155.0
"""A wheel that turns faster is beyond what the published firmware shows, for certain."""


def _fast_wheels(rover: Rover) -> Iterator[tuple[int, float, float]]:
    """Drive the wheels fast; yield the number of each, its true speed in rpm, and the one that 0x83 shows."""
    rover.drive(0.8, 0.8)
    rover.keep_alive(2.0)
    report, true_rpm = rover.motion(), rover.hands.wheels_rpm()
    if min(true_rpm) < FAST_RPM:
        raise Inconclusive(f"the wheels turn at {min(true_rpm):.0f} rpm only, required {FAST_RPM:.0f}")
    yield from zip(range(1, 5), true_rpm, report.rpm, strict=True)


@on_rover("P29", lasts_s=3.0)
def test_a_fast_wheel_as_shipped(rover: Rover) -> None:
    for number, true_rpm, shown_rpm in _fast_wheels(rover):
        near(shown_rpm, 0.0, 1e-6, unit="rpm", what=f"wheel {number} at {true_rpm:.0f} rpm")


@on_rover("P29D", lasts_s=3.0)
def test_a_fast_wheel(rover: Rover) -> None:
    for number, true_rpm, shown_rpm in _fast_wheels(rover):
        near(shown_rpm, true_rpm, 0.05 * true_rpm, unit="rpm", what=f"wheel {number} at {true_rpm:.0f} rpm")


# --- sensors


@on_rover("P39", lasts_s=3.5)
def test_stale_byte_of_the_position(rover: Rover) -> None:
    for before, byte in _bytes_of_position(rover):
        assert byte == before, f"byte 1 of 0x84 is {byte:02X}, that of the report before it {before:02X}"


@on_rover("P39D", lasts_s=3.5)
def test_byte_of_the_position(rover: Rover) -> None:
    pairs = _bytes_of_position(rover)
    if all(byte == before for before, byte in pairs):
        if pairs[0][1] in (0, 1):
            raise Inconclusive("it is the byte of the report before, and could be its own")
        raise Violation(f"byte 1 of 0x84 is {pairs[0][1]:02X}, always that of the report before", rover.peer.evidence())


def _bytes_of_position(rover: Rover) -> Sequence[tuple[int, int]]:
    """Return byte 1 of some 0x84, each with that of the report before it."""
    mark = rover.mark()
    rover.peer.run(3.2)
    received = rover.peer.received[mark:]
    at = 5  # behind sync word and length: the id; byte 1 follows
    pairs = [
        (before.raw[at + 1], got.raw[at + 1]) for before, got in pairwise(received) if isinstance(got.packet, GpsReport)
    ]
    if not pairs:
        raise Violation("no 0x84 came in 3.2 s", rover.peer.evidence(mark))
    return pairs


@on_rover("P40", lasts_s=5.0)
def test_no_position(rover: Rover) -> None:
    """The receiver has its fix after a second or two."""
    rover.peer.run(3.0)
    report = rover.next(GpsReport, 1.2)
    found = (report.first_deg, report.second_deg)
    assert found == (0.0, 0.0), f"0x84 has {found[0]} and {found[1]}"


@on_rover("P40D", lasts_s=4.0)
def test_position(rover: Rover) -> None:
    """The first 0x84 with numbers in it counts: a receiver needs a while for its fix."""
    rover.peer.bench.run_until(lambda: any(r.first_deg for _, r in rover.peer.since(0, GpsReport)), FIX_WITHIN_S)
    report, true = rover.next(GpsReport, 2.0), rover.hands.position()
    near(report.first_deg, true.latitude_deg, POSITION_DEG, unit="deg", what="bytes 4 to 7 of 0x84, the latitude")
    near(report.second_deg, true.longitude_deg, POSITION_DEG, unit="deg", what="bytes 8 to 11 of 0x84, the longitude")


def _magnitude(report: ImuReport | EulerImuReport) -> float:
    return math.hypot(*report.acceleration)


@on_rover("P41", lasts_s=2.0)
def test_acceleration_as_shipped(rover: Rover) -> None:
    rover.next(ImuReport, 1.2)
    near(_magnitude(rover.next(ImuReport, 1.2)), 1.0, 0.1, unit="g", what="acceleration at rest")


@on_rover("P41D", lasts_s=2.0)
def test_acceleration(rover: Rover) -> None:
    rover.next(ImuReport, 1.2)
    near(_magnitude(rover.next(ImuReport, 1.2)), 9.8, 1.0, unit="m/s^2", what="acceleration at rest")


@on_rover("P42", lasts_s=2.0)
def test_quaternion_as_shipped(rover: Rover) -> None:
    _require_scalar(rover, 0)


@on_rover("P42D", lasts_s=2.0)
def test_quaternion(rover: Rover) -> None:
    _require_scalar(rover, 3)


SCALAR = 0.98
"""How near to 1 the scalar is at least where the others are near to 0: 23 degrees off. A choice."""


def _require_scalar(rover: Rover, index: int) -> None:
    rover.next(ImuReport, 1.2)
    quaternion = rover.next(ImuReport, 1.2).quaternion
    if any(map(math.isnan, quaternion)):
        raise Violation("the quaternion is no number", rover.peer.evidence())
    within(abs(quaternion[index]), SCALAR, 1.001, unit="", what=f"size of component {index + 1}, the scalar")


def _motions_from_power_up(there: RoverBench, duration_s: float) -> Sequence[MotionReport]:
    peer = there.peer
    peer.run(duration_s)
    reports = [report for _, report in peer.since(0, MotionReport)]
    if not reports:
        raise Violation(f"no 0x83 within {duration_s:g} s of power-up", peer.evidence())
    return reports


@on_rover("P43", lasts_s=3.0)
def test_wheels_at_power_up_as_shipped(there: RoverBench) -> None:
    first = _motions_from_power_up(there, 3.0)[0]
    assert first.rpm == (1.0, 1.0, 1.0, 1.0), f"the first 0x83 shows {first.rpm} rpm"


@on_rover("P43D", lasts_s=3.0)
def test_wheels_at_power_up(there: RoverBench) -> None:
    for report in _motions_from_power_up(there, 3.0):
        assert report.rpm == (0.0, 0.0, 0.0, 0.0), f"a 0x83 shows {report.rpm} rpm"


# --- what the published firmware does besides


@on_rover("P44", lasts_s=0.8)
def test_led_toggles_as_shipped(rover: Rover) -> None:
    rover.dark()
    for lit in (True, False):
        rover.write(UNKNOWN)
        assert rover.lit is lit, "a packet does not toggle the LED"


@on_rover("P44D", lasts_s=2.0)
def test_led_is_its_own(rover: Rover) -> None:
    for command, lit in ((LedOn(), True), (LedOff(), False)):
        rover.send(command)
        for _ in range(3):
            rover.write(UNKNOWN)
            assert rover.lit is lit, "a packet that is no LED command changes the LED"


@on_rover("P45", lasts_s=5.0)
def test_sum_grows_as_shipped(rover: Rover) -> None:
    assert _after_saturation(rover) > 0, "the sum of the speed controller did not grow at its limit"


@on_rover("P45D", lasts_s=5.0)
def test_sum_stands_at_the_limit(rover: Rover) -> None:
    throttle = _after_saturation(rover)
    record_measure("throttle half a second after the turn", throttle, "of full", high=0.0)
    assert throttle < 0, f"the throttle is still {throttle:.3f} half a second after the setpoint has turned"


def _after_saturation(rover: Rover) -> float:
    """Wind the controller up against held wheels, turn the setpoint, and return the throttle half a second later."""
    _set_integral_gain(rover, 1.0)
    rover.hands.hold_wheels(True)
    rover.send(SpeedSetpoints(a_rpm=30.0, b_rpm=30.0))
    rover.keep_alive(3.0)
    rover.send(SpeedSetpoints(a_rpm=-30.0, b_rpm=-30.0))
    rover.peer.run(0.5)
    return rover.motion().throttles[0]


def _set_integral_gain(rover: Rover, ki: float) -> None:
    """Set kp and kd to 0, whether the gains are read where they stand or four bytes behind."""
    if rover.peer.profile.server.pid_reads_late:
        # What follows the gains in the frame is what is taken for ki: kp, sent kd, sent ki, ki.
        rover.write(rover.peer.frame(b"\x05" + struct.pack("<ffff", 0.0, 0.0, 0.0, ki)))
    else:
        rover.send(PidGains(kp=0.0, kd=0.0, ki=ki))


@on_rover("P46", lasts_s=4.0)
def test_sum_outlives_its_mode_as_shipped(rover: Rover) -> None:
    assert _after_new_mode(rover) > 0.5, "the sum of the speed controller was forgotten with its mode"


@on_rover("P46D", lasts_s=4.0)
def test_sum_begins_with_its_mode(rover: Rover) -> None:
    within(_after_new_mode(rover), 0.0, 0.2, unit="of full", what="throttle a quarter of a second after PID mode began")


def _after_new_mode(rover: Rover) -> float:
    """Gather a sum of 0.6, go to manual mode and back, and return the throttle soon after."""
    _set_integral_gain(rover, 0.01)
    rover.hands.hold_wheels(True)
    rover.send(SpeedSetpoints(a_rpm=30.0, b_rpm=30.0))
    rover.keep_alive(2.0)
    rover.drive(0.0, 0.0)
    return _held_throttle(rover).throttles[0]


def _shown_after_stopping(rover: Rover) -> float:
    """Drive, stop the wheels by hand, and return the fastest speed that the next 0x83 half a second later shows."""
    rover.drive(0.3, 0.3)
    rover.keep_alive(2.0)
    if min(rover.hands.wheels_rpm()) < 60.0:
        raise Inconclusive(f"the wheels turn at {min(rover.hands.wheels_rpm()):.0f} rpm only")
    rover.next(MotionReport, 0.6)
    rover.peer.run(0.2)
    rover.hands.hold_wheels(True)
    rover.next(MotionReport, 0.6)
    rover.next(MotionReport, 0.6)
    return max(rover.next(MotionReport, 0.6).rpm)


@on_rover("P47", lasts_s=4.0)
def test_a_stopped_wheel_as_shipped(rover: Rover) -> None:
    at_least(_shown_after_stopping(rover), 50.0, unit="rpm", what="the fastest wheel half a second after it stood")


@on_rover("P47D", lasts_s=4.0)
def test_a_stopped_wheel(rover: Rover) -> None:
    at_most(_shown_after_stopping(rover), 15.0, unit="rpm", what="the fastest wheel half a second after it stood")


MANY = 100


@on_rover("P48", lasts_s=1.6)
def test_a_full_line_as_shipped(rover: Rover) -> None:
    if rover.peer.line_s(3200) > 1.0:
        raise Inconclusive("the line is too slow for more than 3200 bytes/s")
    rover.write(_led_on(rover) * MANY)
    rover.peer.run(0.2)
    found = rover.counts_in(rover.next(GeneralReport, 1.2))  # a request could end in a frame that was cut
    assert found.accepted < MANY, f"the state is {found}: nothing was lost"


@on_rover("P48D", lasts_s=0.6)
def test_a_full_line(rover: Rover) -> None:
    rover.write(_led_on(rover) * MANY)
    rover.peer.run(0.2)
    rover.require(MANY, 0, 1, SUCCESS)


@on_rover("P49", lasts_s=0.9)
def test_silence_at_power_up_as_shipped(there: RoverBench) -> None:
    there.peer.expect_silence(0.9, why="the sensors are being set up")


@on_rover("P49D", lasts_s=0.1)
def test_there_at_power_up(there: RoverBench) -> None:
    peer = there.peer
    for _ in range(10):
        peer.send(RequestTelemetry())
        if peer.bench.run_until(lambda: bool(peer.since(0, GeneralReport)), 0.1):
            break
    at_most(peer.bench.now_ns / NS_PER_S, 0.5, unit="s", what="the first 0x80 came after power-up by")


# --- frames that end at a newline


@on_rover("P31", lasts_s=0.6)
def test_newline_in_the_payload(rover: Rover) -> None:
    rover.write(bytes.fromhex("504B542103000A000A0377F30A"))
    rover.require(0, 1, None, BAD_CRC)


@on_rover("P32", lasts_s=0.6)
def test_newline_in_the_crc(rover: Rover) -> None:
    rover.write(bytes.fromhex("504B542103003B003B031B0A0A"))
    found, expected = rover.counts, Counts(0, 1, rover.before.last_opcode, BAD_CRC)
    tolerant = Counts(1, 0, 3, SUCCESS)
    if found not in (expected, tolerant):
        raise Violation(f"the state is {found}, required {expected}, or {tolerant} of a tolerant receiver")


@on_rover("P33", lasts_s=0.6)
def test_longest_payload_of_lines(rover: Rover) -> None:
    payload = b"\x01" + bytes(63)
    assert not hides_newline(payload)
    rover.write(rover.peer.frame(payload))
    rover.require(1, 0, 1, SUCCESS)


@on_rover("P34", lasts_s=0.8)
def test_limit_of_lines(rover: Rover) -> None:
    rover.write(b"PKT!" + b"x" * 70)
    rover.require(0, 1, None, INVALID_LENGTH)
    rover.write(LED_ON_TERM)
    rover.require(1, 1, 1, SUCCESS)


@on_rover("P35", lasts_s=0.6)
def test_no_room_for_a_crc(rover: Rover) -> None:
    rover.write(b"PKT!" + TERMINATOR)
    rover.require(0, 1, None, BAD_CRC)
