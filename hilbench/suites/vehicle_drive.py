"""Does a car drive through the board as it should: by the driving stack, by the joystick, and when somebody is lost?

A closed loop: a driver follows the track's middle line by the reports of the board, its commands go through the board
to the car in its world, whose motion goes back through the board to the driver. Each case begins with power just on, at
the start of the track, on a straight of 90 m.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from statistics import fmean
from typing import TypeVar

import pytest

from hilbench.check import CaseSetup, Violation, at_least, at_most, case, near
from hilbench.clock import NS_PER_S
from hilbench.mcu.board_case import BoardCase
from hilbench.suites._vehicle_drive import Drive, Moment, drive_bench
from protocols.autoware import ControlMode, SteeringReport, VelocityReport
from protocols.carla import AckermannCommand, ManualCommand, Mode
from worlds.car_parameters import DEFAULTS as CAR

LAP_WITHIN_S = 90.0
"""400 m at up to 10 m/s, and 6 to 7 in turns and between cones. A choice with room."""

REPORT_AGE_S = 0.1
"""A status comes each 50 ms and is reported when the control task waits for one, after a frame. A choice."""

SPEED_M_S, TURN_RAD_S, ANGLE_RAD = 0.02, 0.02, 0.005
"""Tolerance of reports against the truth within that time. Choices."""

ANGLE_SHARE = 0.05
"""Tolerance of the tyre angle against what was asked for: 1.2 makes 1.1 % too much, as `DrivenCar` says, and the tyres
need their time to follow. A choice."""

HALF = 0.5
"""Of the stick's way, beyond the dead band."""

PEDAL_SHARE = 0.05
"""Tolerance of the acceleration by throttle, as a share: rolling resistance and drag are in the figure. A choice."""

ASIDE = 0.2
STEER_RAD = 0.01
"""Tolerance of the tyre angle by the stick: a code of the converter is 0.00003 rad. A choice."""

ROLLS_M_S2 = 0.5
"""What rolls with free pedals slows down less than this: resistance and drag make 0.15 m/s² at 8 m/s. A choice."""

STACK_M_S2 = 1.5 + 0.3
"""The driver's own limit of braking, and what a step of 4 ms may be off. A choice."""

DECEL_M_S2 = CAR.max_decel_m_s2
STANDS_M_S = 0.05
MISS_S = 0.110
LOOP_S = 0.110
"""What may be left to wait for before the first miss begins: the command's own wait for a status, twice 50 ms, and some
ticks. A choice."""

LOST_AT_M_S = 7.0
"""The car stands before the mode is MANUAL, 0.99 s after the first miss; pedals at rest would let it roll on."""

STOP_M = 0.15
"""Tolerance of a stopping distance: three steps of the physics at 10 m/s. A choice."""

STRAIGHT_RAD = 0.02
"""What is straight: a tyre angle, or a heading that changed by less. A choice."""

HARDENED = CaseSetup(program="hardened")

FunctionT = TypeVar("FunctionT", bound=Callable[..., object])


def on_track(*clause_ids: str, lasts_s: float) -> Callable[[FunctionT], FunctionT]:
    """Declare a case at the start of the track."""
    return case(*clause_ids, bench_time_s=lasts_s, scene="test-track", setup=HARDENED)


@pytest.fixture
def drive(bench: BoardCase) -> Drive:
    """A car at the start of the track, everything just switched on."""
    return Drive(drive_bench(bench))


# --- by the driving stack


@on_track("VD01", "VD02", "VD11", lasts_s=55.0)
def test_a_lap(drive: Drive) -> None:
    drive.start()
    require_driven(drive, drive.path.length_m)


def require_driven(drive: Drive, way_m: float) -> None:
    """Let the car be driven so far; require that it keeps in its lane, is reported truly and is steered as asked."""
    drive.until(lambda: drive.driver.travelled_m >= way_m or drive.is_astray, LAP_WITHIN_S)
    if drive.is_astray:
        require_in_lane(drive, drive.moments, "VD01")
    if drive.driver.travelled_m < way_m:
        raise Violation(f"{drive.driver.travelled_m:.0f} m of {way_m:.0f} m in {LAP_WITHIN_S:g} s", drive.said())
    require_in_lane(drive, drive.moments, "VD01")
    require_mode(drive, 0.0, Mode.AUTOWARE, "VD01")
    for report_s, report in drive.reports:
        require_true(drive, report_s, report)
    at_least(len(drive.reports), 2 * 15 * drive.now_s, unit="", what="velocity and steering reports", clause="VD02")
    asked = [abs(command.steering_tire_angle) for _, command in drive.asked]
    stood = [abs(moment.steering_rad) for moment in drive.moments]
    share = fmean(stood) / fmean(asked)
    near(
        share, 1.0, ANGLE_SHARE, unit="", what="tyre angle on the lap, as a share of what was asked for", clause="VD11"
    )


def require_in_lane(drive: Drive, moments: Sequence[Moment], clause: str) -> None:
    """Require that the car was in its lane all the time, and touched nothing."""
    off_m = max(abs(moment.offset_m) for moment in moments)
    at_most(off_m, drive.half_lane_m, unit="m", what="farthest off the middle line", clause=clause)
    touching = [moment for moment in moments if moment.touches]
    if touching:
        where = f"x {touching[0].x_m:.1f} m, y {touching[0].y_m:.1f} m"
        raise Violation(f"the car touched something at {touching[0].at_s:.2f} s, {where}", clause=clause)


def require_mode(drive: Drive, since_s: float, mode: Mode, clause: str = "") -> None:
    """Require that every frame since then is of one mode."""
    others = [one for one in drive.published(since_s) if one.mode != mode]
    if others:
        first = f"at {others[0].ns / NS_PER_S:.3f} s a frame of mode {others[0].mode} tells the car {others[0].command}"
        raise Violation(f"{len(others)} times the mode is not {mode}: {first}", drive.said(), clause=clause)


def require_true(drive: Drive, report_s: float, report: VelocityReport | SteeringReport) -> None:
    """Require that a report is true of some moment shortly before."""
    if isinstance(report, SteeringReport):
        require_seen(drive, report_s, "steering_rad", report.steering_tire_angle, ANGLE_RAD)
    else:
        require_seen(drive, report_s, "speed_m_s", report.longitudinal_velocity, SPEED_M_S)
        require_seen(drive, report_s, "lateral_speed_m_s", report.lateral_velocity, SPEED_M_S)
        require_seen(drive, report_s, "turn_rad_s", report.heading_rate, TURN_RAD_S)


def require_seen(drive: Drive, report_s: float, name: str, value: float, tolerance: float) -> None:
    """Require that a figure of the car was as reported at some moment shortly before."""
    values = [getattr(moment, name) for moment in drive.between(report_s - REPORT_AGE_S, report_s)] or [0.0]
    if not min(values) - tolerance <= value <= max(values) + tolerance:
        text = f"{name} is reported as {value:.4f} at {report_s:.3f} s, was {min(values):.4f} to {max(values):.4f}"
        raise Violation(text, clause="VD02")


# --- by the joystick


@on_track("VD03", lasts_s=8.3)
def test_by_joystick(drive: Drive) -> None:
    drive.go(0.5)
    require_answer(drive.ask(ControlMode.MANUAL), "MANUAL")
    drive.go(0.3)
    drive.stick(forward=HALF)
    start = drive.wait(0.5)
    end = drive.wait(2.0)
    gained = (end.speed_m_s - start.speed_m_s) / (end.at_s - start.at_s)
    wanted = HALF * CAR.max_accel_m_s2 - resistance_m_s2((start.speed_m_s + end.speed_m_s) / 2)
    near(gained, wanted, PEDAL_SHARE * wanted, unit="m/s2", what="acceleration at half of the stick's way")
    for side in (1, -1):
        drive.stick(right=side * ASIDE)
        turned = drive.wait(1.0)
        near(
            turned.steering_rad,
            -side * ASIDE * CAR.max_steering_rad,
            STEER_RAD,
            unit="rad",
            what="tyre angle by the stick",
        )
        at_least(-side * turned.turn_rad_s, 0.1, unit="rad/s", what="turn rate to the side of the stick")
    drive.stick(forward=-1.0)
    drive.wait(3.0)
    at_most(drive.now.speed_m_s, STANDS_M_S, unit="m/s", what="speed after braking")
    require_mode(drive, start.at_s, Mode.MANUAL)


def resistance_m_s2(speed_m_s: float) -> float:
    """What rolling resistance and drag take from an acceleration."""
    drag_n = CAR.air_density_kg_m3 * CAR.drag_coefficient * CAR.drag_area_m2 / 2 * speed_m_s**2
    return CAR.rolling_resistance * 9.81 + drag_n / CAR.mass_kg


def require_answer(answer: bool | None, mode: str) -> None:
    """Require that a mode was granted."""
    if answer is not True:
        raise Violation(f"asked for {mode} the board says {'no' if answer is False else 'nothing'}")


# --- hand-overs


@on_track("VD04", "VD05", lasts_s=8.8)
def test_hand_over_by_press(drive: Drive) -> None:
    drive.stick()
    drive.start()
    drive.reach(8.0)
    pressed_s = drive.now_s
    drive.hands.press()
    drive.go(1.2)
    require_rolling(drive, pressed_s)
    back_s = drive.now_s
    drive.hands.press()
    drive.go(2.0)
    require_driven_on(drive, back_s)


@on_track("VD04", "VD05", lasts_s=8.7)
def test_hand_over_by_request(drive: Drive) -> None:
    drive.stick()
    drive.start()
    drive.reach(8.0)
    asked_s = drive.now_s
    require_answer(drive.ask(ControlMode.MANUAL), "MANUAL")
    drive.go(1.2)
    require_rolling(drive, asked_s)
    back_s = drive.now_s
    require_answer(drive.ask(ControlMode.AUTONOMOUS), "AUTOWARE")
    drive.go(2.0)
    require_driven_on(drive, back_s)


def require_rolling(drive: Drive, since_s: float) -> None:
    """Require that the joystick took over, at rest, and that the car only rolled."""
    commands = drive.commanded(since_s)
    manual = [(at_s, one) for at_s, one in commands if isinstance(one, ManualCommand)]
    if not manual or not isinstance(commands[-1][1], ManualCommand):
        raise Violation("the joystick does not take over", drive.said(), clause="VD04")
    for at_s, one in manual:
        if (abs(one.steer), one.throttle, one.brake) != (0.0, 0.0, 0.0):
            raise Violation(f"at {at_s:.3f} s, the stick at rest, the car is sent {one}", drive.said(), clause="VD04")
    require_mode(drive, manual[0][0], Mode.MANUAL, "VD04")
    accels = [moment.accel_m_s2 for moment in drive.since(manual[0][0] + 0.02)]
    at_most(max(accels), 0.0, unit="m/s2", what="acceleration with free pedals", clause="VD04")
    at_least(min(accels), -ROLLS_M_S2, unit="m/s2", what="acceleration with free pedals", clause="VD04")


def require_driven_on(drive: Drive, since_s: float) -> None:
    """Require that the driving stack took over with commands of its own, and drove on."""
    commands = drive.commanded(since_s)
    if not commands or not isinstance(commands[-1][1], AckermannCommand):
        raise Violation("the driving stack does not take over", drive.said(), clause="VD05")
    first_s = next(at_s for at_s, one in commands if isinstance(one, AckermannCommand))
    require_mode(drive, first_s, Mode.AUTOWARE, "VD05")
    moments = drive.since(since_s)
    braking = min(moment.accel_m_s2 for moment in moments)
    at_least(braking, -STACK_M_S2, unit="m/s2", what="acceleration after the hand-over", clause="VD05")
    gained = moments[-1].speed_m_s - moments[0].speed_m_s
    at_least(gained, 0.5, unit="m/s", what="speed gained after the hand-over", clause="VD05")
    require_in_lane(drive, moments, "VD05")


# --- somebody is lost, and comes back


@on_track("VD06", "VD07", lasts_s=11.1)
def test_stack_lost(drive: Drive) -> None:
    drive.start()
    drive.reach(LOST_AT_M_S)
    lost = drive.now
    drive.stack.stop_driving()
    drive.go(1.3)
    stop = drive.now
    at_most(stop.speed_m_s, STANDS_M_S, unit="m/s", what="speed 1.3 s after the last command", clause="VD06")
    fastest = max(moment.speed_m_s for moment in drive.since(lost.at_s))
    most_m = fastest * (MISS_S + LOOP_S) + fastest**2 / (2 * DECEL_M_S2) + STOP_M
    at_most(way_m(lost, stop), most_m, unit="m", what="way from the last command to rest", clause="VD06")
    held = [moment.steering_rad for moment in drive.since(lost.at_s) if moment.speed_m_s > 1.0]
    at_most(max(held) - min(held), STRAIGHT_RAD, unit="rad", what="change of the tyre angle", clause="VD06")
    if not isinstance(drive.commanded()[-1][1], ManualCommand) or drive.stack.mode != ControlMode.MANUAL:
        raise Violation("the mode is not MANUAL 1.3 s after the last command", drive.said(), clause="VD06")
    drive.follow()
    require_stands_and_drives_on(drive, "VD07")


@on_track("VD08", "VD09", lasts_s=13.2)
def test_simulator_lost(drive: Drive) -> None:
    drive.start()
    drive.reach(8.0)
    drive.car.statuses.stop()
    lost_s = (drive.car.statuses.last_ns or 0) / NS_PER_S
    emergency_s = drive.emergency(2.0)
    near(emergency_s - lost_s, 1.0, 0.035, unit="s", what="last status to EMERGENCY", clause="VD08")
    if drive.hands.lights() != {"red"}:
        raise Violation(f"the lights are {sorted(drive.hands.lights())}, not red", clause="VD08")
    fastest = drive.now.speed_m_s
    drive.go(fastest / DECEL_M_S2 + 0.1)
    at_most(drive.now.speed_m_s, STANDS_M_S, unit="m/s", what="speed after full braking", clause="VD08")
    drive.go(0.5)
    back_s = drive.now_s
    drive.car.statuses.start(20.0)
    if not drive.until(lambda: isinstance(drive.commanded()[-1][1], ManualCommand), 0.5):
        raise Violation("statuses come again and the mode is not MANUAL", drive.said(), clause="VD09")
    at_most(drive.now_s - back_s, 0.01, unit="s", what="first status to MANUAL", clause="VD09")
    require_stands_and_drives_on(drive, "VD09")


def require_stands_and_drives_on(drive: Drive, clause: str) -> None:
    """Require that the car stands by itself in MANUAL, and drives on when AUTOWARE is asked for."""
    begin = drive.now
    drive.go(1.0)
    require_mode(drive, begin.at_s + 0.001, Mode.MANUAL, clause)
    at_most(way_m(begin, drive.now), 0.05, unit="m", what="way before AUTOWARE is asked for", clause=clause)
    require_answer(drive.ask(ControlMode.AUTONOMOUS), "AUTOWARE")
    back_s = drive.now_s
    drive.go(4.0)
    at_least(drive.now.speed_m_s, 3.0, unit="m/s", what="speed 4 s after AUTOWARE was granted", clause=clause)
    require_in_lane(drive, drive.since(back_s), clause)


@on_track("VD10", lasts_s=9.9)
def test_emergency_stop(drive: Drive) -> None:
    drive.start()
    drive.reach(9.99)
    drive.car.statuses.stop()
    drive.emergency(2.0)
    begin = drive.now
    drive.go(begin.speed_m_s / DECEL_M_S2 + 0.3)
    end = drive.now
    at_most(end.speed_m_s, STANDS_M_S, unit="m/s", what="speed at the end")
    ideal_m = begin.speed_m_s**2 / (2 * DECEL_M_S2)
    near(way_m(begin, end), ideal_m, STOP_M, unit="m", what=f"stopping distance from {begin.speed_m_s:.2f} m/s")
    at_most(abs(end.steering_rad), STRAIGHT_RAD, unit="rad", what="tyre angle at the end")
    at_most(abs(end.yaw_rad - begin.yaw_rad), STRAIGHT_RAD, unit="rad", what="change of the heading")


def way_m(begin: Moment, end: Moment) -> float:
    """How far the car came between two moments, as the crow flies."""
    return math.dist((begin.x_m, begin.y_m), (end.x_m, end.y_m))
