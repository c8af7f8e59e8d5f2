"""Time: half a frame, a lost link, eleven bytes at once, and reports that come by themselves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from itertools import pairwise

from hilbench.check import Inconclusive, Untimely, Violation, at_least, at_most, near, within
from hilbench.clock import NS_PER_S
from hilbench.judging.uncertainty import OfTimes
from hilbench.suites._rover import (
    DONE_S,
    MOTION_AND_COMMAND,
    OTHER_REPORTS,
    Counts,
    Rover,
    at_power_up,
    on_rover,
)
from hilbench.suites.pkt_board._frames import LED_OFF, LED_ON, SUCCESS
from hilbench.systems.rover.hands import RoverBench
from hilbench.systems.rover.peer import READY_WITHIN_S
from protocols.pkt import (
    GeneralReport,
    GpsReport,
    ImuReport,
    LedOn,
    MotionReport,
    Report,
    ReportId,
    RequestTelemetry,
    SpeedSetpoints,
)

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
        # Both halves may be handed over late, and `write` waits for that, too.
        if 3 * rover.peer.uncertainty_s(start_ns) > FRAME_S - IN_TIME_S - DONE_S:
            raise Inconclusive("the bench was too late to say whether the frame was in time")
        rover.require(count, 0, 1, SUCCESS)


@on_rover("P61", lasts_s=10.5)
def test_half_a_frame_is_forgotten_anywhere(rover: Rover) -> None:
    for size in range(1, len(LED_ON)):
        rover.write(LED_ON[:size])
        begun_ns = rover.peer.bench.now_ns
        rover.peer.run(1.2)
        if rover.peer.uncertainty_s(begun_ns) > 1.2 - FRAME_S:
            raise Inconclusive("the bench was too late to say whether the frame was too late")
        rover.write(LED_OFF)
        rover.require(size, 0, 2, SUCCESS)


@on_rover("P24", lasts_s=11.0)
def test_a_lost_link_changes_nothing(rover: Rover) -> None:
    rover.drive(0.5, -0.25)
    rover.peer.run(10.0)
    rover.require_throttles(rover.next(MotionReport, 0.6), 0.5, -0.25)


STOP_WITHIN_S = 1.1
"""The time of a link (G2 config.h, HEARTBEAT_TIMEOUT_IN_MS) and as much again as a loop takes ten times. A choice."""


@on_rover("P24D", lasts_s=9.0)
def test_a_lost_link_stops_the_motors(rover: Rover) -> None:
    rover.drive(0.5, -0.25)
    rover.require_shown()
    rover.keep_alive(3.0)
    if not rover.runs:
        raise Violation(f"the motors stand though the link is kept up: {rover.duties}", rover.peer.evidence())
    rover.before_silence(STOP_WITHIN_S)
    rover.drive(0.5, -0.25)
    sent_ns = rover.peer.bench.now_ns - round(DONE_S * NS_PER_S)
    rover.stop_s(sent_ns, STOP_WITHIN_S)
    rover.keep_alive(2.0)
    if rover.duties != (0.0, 0.0):
        raise Violation("the motors run again though nothing has commanded them", rover.peer.evidence())
    rover.drive(0.5, -0.25)
    if not rover.runs:
        raise Violation("the motors do not obey any more", rover.peer.evidence())


@on_rover("P80", lasts_s=4.0)
def test_noise_does_not_keep_the_motors_running(rover: Rover) -> None:
    rover.drive(0.5, -0.25)
    rover.require_shown()
    if not rover.runs:
        raise Inconclusive("the motors do not run", rover.peer.evidence())
    rover.before_silence(STOP_WITHIN_S)
    rover.drive(0.5, -0.25)
    sent_ns = rover.peer.bench.now_ns - round(DONE_S * NS_PER_S)
    for noise in NO_FRAMES * 3:
        rover.peer.write(noise)
        rover.peer.run(0.1)
    rover.stop_s(sent_ns, STOP_WITHIN_S)


NO_FRAMES = (b"abcdefg\n", LED_ON[:-3] + bytes(2) + LED_ON[-1:], LED_ON[:-1] + b"X")


@on_rover("P76", lasts_s=4.5)
def test_every_lost_link_stops_the_motors(rover: Rover) -> None:
    rover.drive(0.5, -0.25)
    rover.require_shown()
    for _ in range(3):
        rover.before_silence(STOP_WITHIN_S)
        rover.drive(0.5, -0.25)
        sent_ns = rover.peer.bench.now_ns - round(DONE_S * NS_PER_S)
        if rover.seen and not rover.runs:
            raise Violation(f"the motors do not obey: {rover.duties}", rover.peer.evidence())
        rover.stop_s(sent_ns, STOP_WITHIN_S)


@on_rover("P77", lasts_s=2.2)
def test_a_request_after_a_lost_link(rover: Rover) -> None:
    """The case begins with a request that was answered; behind the periodic 0x80 nothing else can be the answer."""
    rover.peer.run(1.5)
    rover.after_periodic()
    mark = rover.mark()
    rover.write(rover.peer.frame_of(RequestTelemetry()))
    replies = rover.peer.since(mark, GeneralReport)
    if len(replies) != 1:
        # None may be on its way, and of two one may be the periodic one.
        raise Untimely(f"{len(replies)} reports 0x80 came after a silence, required one", rover.peer.evidence())
    rover.require(0, 0, None, None)


@at_power_up("P78", lasts_s=0.2)
def test_nothing_is_counted_at_power_up(there: RoverBench) -> None:
    peer = there.peer
    if not peer.wait_ready():
        text = f"the rover does not answer REQUEST_TMY{peer.refused()}"
        raise Untimely(text, peer.evidence(), spare_s=READY_WITHIN_S / 2)
    (got, _), *_ = peer.since(0, GeneralReport)
    expected = peer.frame(bytes.fromhex("80 00 00 00 00 00"))
    if got.raw != expected:
        found = got.raw.hex(" ").upper()
        raise Violation(f"the first 0x80 is {found}, required {expected.hex(' ').upper()}", peer.evidence())


@on_rover("P62", lasts_s=7.0)
def test_a_lost_link_ends_speed_control(rover: Rover) -> None:
    rover.hold_wheels()
    rover.send(SpeedSetpoints(a_rpm=60.0, b_rpm=-60.0))
    rover.require_shown()
    rover.keep_alive(2.0)
    if not rover.runs:
        raise Violation(f"the motors stand though the link is kept up: {rover.duties}", rover.peer.evidence())
    rover.before_silence(STOP_WITHIN_S)
    rover.send(SpeedSetpoints(a_rpm=60.0, b_rpm=-60.0))
    sent_ns = rover.peer.bench.now_ns - round(DONE_S * NS_PER_S)
    rover.stop_s(sent_ns, STOP_WITHIN_S)
    rover.keep_alive(1.0)
    if rover.duties != (0.0, 0.0):
        raise Violation("the motors run again though nothing has commanded them", rover.peer.evidence())
    report = rover.motion()
    rover.require_throttles(report, 0.0, 0.0)
    rover.require_setpoints(report, 0.0, 0.0)
    rover.send(SpeedSetpoints(a_rpm=60.0, b_rpm=60.0, flags=1))
    if not rover.seen:
        rover.require_setpoints(rover.motion(), 60.0, 0.0)
        return
    left, right = rover.duties
    at_least(left, 0.3, unit="of full", what="duty A after a setpoint for A alone")
    near(right, 0.0, 0.1, unit="of full", what="duty B after a setpoint for A alone")


def _eleven_bytes(rover: Rover, times: int) -> Counts:
    """Send a frame of eleven bytes several times, each at another time of a receiver that looks every 10 ms."""
    if rover.peer.line_s(11) > 0.005:
        raise Inconclusive("the line is too slow for eleven bytes in one look of 10 ms")
    frame = rover.peer.frame(bytes.fromhex("010000"))
    for count in range(times):
        rover.write(frame)
        rover.peer.run(0.0213 * (count % 4))
    return rover.counts


@on_rover("P25", lasts_s=1.2)
def test_eleven_bytes_are_lost(rover: Rover) -> None:
    """A line can cut the eleven bytes in two looks; most of the times it does not."""
    found = _eleven_bytes(rover, 8)
    if found.accepted > 4 or found.rejected:
        raise Violation(f"the state is {found} after eight frames; most of them must be lost without being counted")
    rover.send(LedOn())
    if rover.counts.accepted != found.accepted + 1:
        raise Inconclusive(f"other frames are not accepted either: {rover.counts}")


@on_rover("P25D", lasts_s=1.2)
def test_eleven_bytes_are_a_frame(rover: Rover) -> None:
    found = _eleven_bytes(rover, 8)
    if (found.accepted, found.rejected, found.opcode, found.error) != (8, 0, 1, SUCCESS):
        raise Violation(f"the state is {found}, required 8/0/1/0 after eight frames", rover.peer.evidence())


@on_rover("P30", lasts_s=11.0)
def test_periodic_reports(rover: Rover) -> None:
    """Where the bench was late, those reports are uncertain that are so near to the beginning or the end."""
    mark, start_ns = rover.mark(), rover.peer.bench.now_ns
    rover.peer.run(10.0)
    end_ns, doubt_s = rover.peer.bench.now_ns, rover.peer.uncertainty_s(start_ns)
    if doubt_s:
        rover.peer.run(doubt_s)
    wanted: Sequence[tuple[int, type[Report], int, int]] = (
        (0x80, GeneralReport, 30, 31),
        (0x83, MotionReport, 40, 41),
        (0x82, ImuReport, 10, 11),
        (0x84, GpsReport, 10, 11),
    )
    for number, kind, least, most in wanted:
        ends_ns = [got.at_ns for got, _ in rover.peer.since(mark, kind)]
        count = sum(at_ns <= end_ns for at_ns in ends_ns)
        near_edge = sum(min(abs(at_ns - start_ns), abs(at_ns - end_ns)) <= doubt_s * NS_PER_S for at_ns in ends_ns)
        uncertain = OfTimes(near_edge) if doubt_s else 0.0
        within(count, least, most, unit="reports", what=f"0x{number:02X} in 10 s", uncertainty=uncertain)


UNEVEN_S = 0.05
"""How far off its time a report may be, beside what stands before it on the line. A choice: five turns of a loop."""


@on_rover("P85", lasts_s=3.4)
def test_periodic_reports_come_evenly(rover: Rover) -> None:
    """From the first one on; 0x80 is left out, which is an answer, too."""
    rover.peer.run(3.2)
    server = rover.peer.profile.server
    allowed_s = UNEVEN_S + rover.peer.line_s(MOTION_AND_COMMAND + OTHER_REPORTS)
    for number, kind, ticks in (
        (rate.report, KINDS[rate.report], rate.ticks) for rate in server.rates if rate.report in KINDS
    ):
        starts_ns = [got.start_ns for got, _ in rover.peer.since(0, kind)]
        if len(starts_ns) < 2:
            raise Untimely(f"no two 0x{number:02X} came", rover.peer.evidence(), spare_s=1.0)
        spans_s = [(after - before) / NS_PER_S for before, after in pairwise(starts_ns)]
        at_most(
            max(abs(span_s - ticks / server.tick_hz) for span_s in spans_s),
            allowed_s,
            unit="s",
            what=f"time between two 0x{number:02X} that is farthest off",
            uncertainty=rover.peer.uncertainty_s(starts_ns[0]),
        )


KINDS: Mapping[ReportId, type[Report]] = {
    ReportId.IMU: ImuReport,
    ReportId.MOTION: MotionReport,
    ReportId.GPS: GpsReport,
}
