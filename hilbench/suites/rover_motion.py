"""Does a rover do what it is told, and does it say what it does?

Throttles and set points to wheels, wheels to the ground, and what tachometers, inertial sensor and GPS receiver say of
it, against the truth of the world. Each case runs the program on an emulated board with the parts of the bench `rover`
around it, power just on. What a wheel should do is reckoned by the figures of its parts (`_rover_law`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import pytest

from hilbench.check import Violation, at_least, at_most, near, within
from hilbench.clock import NS_PER_MS, NS_PER_S
from hilbench.mcu.board_case import BoardCase
from hilbench.suites._rover_law import CARRIED_KG_M2, STEP_S, Driven, settled_rpm, volts_at, wheel_course
from hilbench.suites._rover_motion import (
    ENABLES,
    FEED_S,
    LEFT,
    NAMES,
    RIGHT,
    Moment,
    Ride,
    ideal_turn_deg_s,
    metres_off,
    numbers_in,
    on_bench,
)
from protocols.pkt import (
    GpsReport,
    ImuReport,
    PidGains,
    Position,
    RequestTelemetry,
    acceleration_m_s2,
    attitude_wxyz,
    position,
)
from protocols.pkt.codes import StatusFlag
from protocols.pkt.units import STANDARD_GRAVITY_M_S2
from worlds.scenes.builtin import RAMP_FOOT_M, RAMP_SLOPE_RAD
from worlds.vehicles.rover_4wd import DEFAULTS

LAW_RPM = 4.0
"""How far a speed may be from the law. The bench puts pulses of 5 ms on steps of 4.2 ms. A choice."""

SAME_RPM = 1.0
"""How far apart wheels may be that are driven alike. A choice."""

LOOK_S = 0.2
"""Over which speeds are mean ones: ten periods of the pulses."""

TURNS_RPM, TWITCHES_RPM = 40.0, 5.0
"""A wheel that is faster turns, one that is slower stands: pulses that are too short move it a little. Choices."""

ORIGINAL_RPM = {0.39: (142.0, 145.0), 0.35: (133.0, 133.0), 0.30: (115.0, 120.0), 0.25: (95.0, 100.0)}
"""Throttle and speeds of the original's wheels in the air (nhorro/ceai2020 intro_se, notebooks)."""

ORIGINAL_OFF_RPM = 4.0
"""What is read from plots, of wheels that scatter, on cells of which nobody knows how full they were. A choice."""

KP, KI = 0.01, 0.0001
"""The gains at power-up (nhorro/ceai2020 rover_firmware/config.h)."""

POWER_UP_RPM, POWER_UP = 7.0, 0.05
"""Tolerance of speed and throttle then: a slot passes every 32 ms, so that the speed control sees steps. Choices."""

GAINS = PidGains(kp=0.003, kd=0.0, ki=0.006)
"""With which these motors settle: a sum that takes the place of the error in half a second. A choice."""

SETTLED_RPM, RIPPLE_RPM = 3.0, 6.0
"""How near a set point the mean is, and how far the speed may stray meanwhile. Choices."""

SLOT = 1.5
"""How far a count may be from the angle: where the disc stood at first, and what passes while 0x83 goes out."""

RPM = 0.04
"""Tolerance of a speed in 0x83, as a share: speeds swing with the pulses. A choice."""

SPEED, DRIFT, DRIFT_DEG = 0.03, 0.01, 1.0
"""Tolerance of the speed, drift a way, drift of the heading. Choices."""

RATIO = (0.42, 0.55)
"""Of four dragged wheels to two that roll: 0.60 with friction that is the same in all directions, and less in PyBullet
(docs/rover-vehicle.md)."""

STANDS_DEG_S = 2.0
"""What turns more slowly does not turn. A choice."""

G = STANDARD_GRAVITY_M_S2
ZERO_G_XY, ZERO_G_Z, SENSITIVITY = 0.06, 0.08, 0.03
"""Tolerances of the accelerometer in g and of both scales (PS-MPU-9250A-01, sections 3.1 and 3.2)."""

NOISE_G = 0.01
"""Five times 300 ug/rtHz in a band of 45 Hz (the same, section 3.2)."""

REST_DEG_S = 0.5
"""The gyroscope has been calibrated at rest; its noise is 0.06 deg/s in a band of 41 Hz. A choice."""

RATE_DEG_S = 3.0
"""Noise, and what the rate changes by until the sensor's filter of 41 Hz has followed. A choice."""

READ_BEFORE_NS = 10 * NS_PER_MS
"""The sensor is read one turn of the loop before it is reported."""

ROOM_C = 25.0
FIELD_MGAUSS, FIELD_OFF_MGAUSS = 227.0, 40.0
"""WMM2020 at the scene's origin, and what is left after a calibration (assumed)."""

FIELD_NORTH_MGAUSS, FIELD_UP_MGAUSS = 172.7, 147.5
"""Of the same: what is level, towards magnetic north, and what points up."""

LEANING_G = ZERO_G_Z + SENSITIVITY + NOISE_G
"""Tolerance of the acceleration of a sensor that was mounted otherwise."""

VALID = 3
"""Inertial sensor and magnetometer were read."""

LEVEL_DEG, HEADING_DEG = 6.0, 12.0
"""Of a sensor whose zero is off by 60 mg and whose field is off by 2 uT; the estimate runs at 10 Hz. Choices."""

CEP_M = 2.5
"""Half of the errors are smaller (NEO-6 data sheet GPS.G6-HW-09005, table 2); three times as much is rare: 0.2 %."""

PLACE_M = 0.7
"""Half of a float's last place at 58 degrees is 0.2 m, and 0x84 may be a step older than the truth. A choice."""

EPOCH_LATE_NS = 300 * NS_PER_MS
"""From the moment of a solution until the board has read it, at least: its sentences come at 9600 baud."""

FAILS_S = 0.5
"""Five readings of the sensor. A choice."""

MENDED_S = 2.6
"""The sensor is set up anew each second, and calibrated for half a second. A choice."""

MPU9250 = 0x68

LOST_S = (0.9, 1.0 + 0.010 + 0.020)
"""The heartbeat's second (nhorro/ceai2020 rover_firmware/config.h), one turn of the loop, and the period whose pulse
was under way; not before."""

REPORT_NS = 250 * NS_PER_MS

STALLED_S = 1.0 + 0.020 * 3 + 0.250
"""The second after which the manual shows 0, three readings of which the median is taken, and the wait for a 0x83."""

WALL_M = 1.4
"""Where the wall's face is in the scene `rover-room`."""


@pytest.fixture
def ride(bench: BoardCase) -> Ride:
    """The rover, power just on, with a watch on what it does."""
    return Ride(bench)


# --- throttles, wheels in the air


def course_rpm(driven: Driven, duration_s: float) -> float:
    """Return the mean speed of the last ten periods of a course."""
    course = list(wheel_course(driven, duration_s))
    last = course[-round(LOOK_S / STEP_S) :]
    return sum(last) / len(last) * 60 / math.tau


def require_speeds(ride: Ride, wanted_rpm: Sequence[float], tolerance_rpm: float, what: str) -> None:
    """Require the mean speeds of all wheels over the last ten periods."""
    for name, found_rpm, rpm in zip(NAMES, ride.rpm(LOOK_S), wanted_rpm, strict=True):
        near(found_rpm, rpm, tolerance_rpm, unit="rpm", what=f"{name} wheel {what}")


def require_law(ride: Ride, throttles: Sequence[float], duration_s: float, **others: float) -> None:
    """Drive at one throttle after the other, and hold the wheels' speeds against the law, from where they were."""
    start_rpm = 0.0
    for throttle in throttles:
        ride.drive(throttle, throttle, duration_s)
        wanted_rpm = course_rpm(Driven(throttle=throttle, start_rpm=start_rpm, **others), duration_s)
        require_speeds(ride, [wanted_rpm] * 4, LAW_RPM, f"{duration_s:g} s after throttle {throttle:g}")
        start_rpm = min(ride.rpm(LOOK_S))


@on_bench("R01", lasts_s=4.9)
def test_throttle_to_speed(ride: Ride) -> None:
    require_law(ride, (0.3, 0.5, 1.0, 0.4), 1.2)


@on_bench("R02", lasts_s=5.3)
def test_as_the_original_in_the_air(ride: Ride) -> None:
    ride.drive(0.5, 0.5, 0.8)
    for throttle, (low_rpm, high_rpm) in ORIGINAL_RPM.items():
        ride.drive(throttle, throttle, 1.1)
        for name, rpm in zip(NAMES, ride.rpm(LOOK_S), strict=True):
            what = f"{name} wheel at throttle {throttle:g}"
            within(rpm, low_rpm - ORIGINAL_OFF_RPM, high_rpm + ORIGINAL_OFF_RPM, unit="rpm", what=what)


@on_bench("R03", lasts_s=5.2)
def test_breakaway(ride: Ride) -> None:
    """A wheel that is pulsed just below twitches a little."""
    for throttle, for_s, turns in ((0.21, 0.6, False), (0.26, 1.5, True), (0.21, 1.2, True), (0.17, 1.8, False)):
        ride.drive(throttle, throttle, for_s)
        for name, rpm in zip(NAMES, ride.rpm(LOOK_S), strict=True):
            what = f"{name} wheel {for_s:g} s after throttle {throttle:g}"
            if turns:
                at_least(rpm, TURNS_RPM, unit="rpm", what=what)
            else:
                at_most(rpm, TWITCHES_RPM, unit="rpm", what=what)


@on_bench("R04", lasts_s=2.5)
def test_both_directions(ride: Ride) -> None:
    ride.drive(-0.4, -0.4, 1.2)
    rpm = course_rpm(Driven(throttle=0.4), 1.2)
    require_speeds(ride, [-rpm] * 4, LAW_RPM, "1.2 s after throttle -0.4")
    ride.drive(0.4, -0.4, 1.2)
    left, right, *_ = ride.rpm(LOOK_S)
    require_speeds(ride, [left, right] * 2, SAME_RPM, "beside the other of its side")
    at_least(left, rpm / 2, unit="rpm", what="left wheels after throttle 0.4, 1.2 s after -0.4")
    near(right, -settled_rpm(Driven(throttle=0.4)), LAW_RPM, unit="rpm", what="right wheels after throttle -0.4")


@on_bench("R05", lasts_s=1.6)
def test_flags(ride: Ride) -> None:
    for flags, signs in ((1, (1, 0)), (2, (1, -1)), (0, (1, -1))):
        ride.drive(0.5 * (flags == 1), -0.5 * (flags == 2), 0.5, flags=flags)
        for side, wheels, sign in zip(("left", "right"), (LEFT, RIGHT), signs, strict=True):
            for wheel in wheels:
                rpm = ride.rpm(0.1)[wheel]
                what = f"{NAMES[wheel]} wheel after a command with flags {flags}"
                if sign:
                    at_least(rpm * sign, TURNS_RPM, unit="rpm", what=f"{what}, {side} {'+' if sign > 0 else '-'}")
                else:
                    at_most(abs(rpm), TWITCHES_RPM, unit="rpm", what=what)


# --- set points


def require_settled(ride: Ride, rpm: float, tolerance_rpm: float) -> None:
    """Require that all wheels keep a speed: their mean, and how far each physics step strays from it."""
    require_speeds(ride, [rpm] * 4, tolerance_rpm, f"at a set point of {rpm:g} rpm")
    speeds = [wheel for one, other in steps(ride, LOOK_S) for wheel in other.rpm_since(one)]
    ripple_rpm = max(speeds) - min(speeds)
    at_most(ripple_rpm, RIPPLE_RPM, unit="rpm", what=f"ripple of the wheels' speeds at a set point of {rpm:g} rpm")


def steps(ride: Ride, over_s: float) -> Sequence[tuple[Moment, Moment]]:
    """Return the last moments, two and two, a period of the pulses apart."""
    start = ride.before(over_s).at_ns
    last = [one for one in ride.moments if one.at_ns >= start]
    return list(zip(last, last[5:], strict=False))


@on_bench("R06", lasts_s=3.0)
def test_gains_at_power_up(ride: Ride) -> None:
    """From rest the first error of 120 rpm asks for more than full throttle, and the speed swings for a while."""
    ride.drive(0.3, 0.3, 1.2)
    ride.keep(120.0, 120.0, 1.6)
    low_rpm, high_rpm = 60.0, 120.0
    for _ in range(12):
        rpm = (low_rpm + high_rpm) / 2
        wanted = KP * (120.0 - rpm) + KI * (120.0 - rpm) * 1.6
        faster = settled_rpm(Driven(throttle=wanted, start_rpm=rpm)) > rpm
        low_rpm, high_rpm = (rpm, high_rpm) if faster else (low_rpm, rpm)
    require_speeds(ride, [low_rpm] * 4, POWER_UP_RPM, "at a set point of 120 rpm with the gains at power-up")
    _, report = ride.motion()
    for side, throttle, rpm in zip("AB", report.throttles, (min(report.rpm[::2]), min(report.rpm[1::2])), strict=True):
        near(throttle, KP * (120.0 - rpm), POWER_UP, unit="of full", what=f"throttle {side} at {rpm:.0f} rpm")
        at_least(rpm, TURNS_RPM, unit="rpm", what=f"speed of side {side} in 0x83")


@on_bench("R07", lasts_s=7.4)
def test_settles_in_the_air(ride: Ride) -> None:
    ride.rover.send(GAINS)
    for rpm in (30.0, 60.0, 120.0):
        ride.keep(rpm, rpm, 2.4)
        require_settled(ride, rpm, SETTLED_RPM)


@on_bench("R08", lasts_s=7.2, scene="hard-floor")
def test_settles_on_the_floor(ride: Ride) -> None:
    ride.rover.send(GAINS)
    for rpm in (60.0, 120.0):
        ride.keep(-rpm, -rpm, 3.5)
        require_settled(ride, -rpm, SETTLED_RPM)


# --- tachometers


@on_bench("R09", lasts_s=2.8)
def test_tachometers(ride: Ride) -> None:
    """Each wheel has its own way behind it: one of a side after the other is held."""
    ride.hold("lb")
    ride.drive(0.35, -0.8, 0.8)
    ride.hold("lb", held=False)
    ride.hold("rb")
    ride.go(0.4)
    ride.hold("rb", held=False)
    ride.go(1.2)
    at_ns, report = ride.motion()
    slots = ride.slots_at(at_ns)
    rpm = ride.at(at_ns).rpm_since(ride.at(at_ns - round(LOOK_S * NS_PER_S)))
    for place, name in enumerate(NAMES):
        ticks = report.ticks[place]
        near(ticks, abs(slots[place]), SLOT, unit="slots", what=f"ticks of the {name} wheel beside its true angle")
        speed_rpm = abs(rpm[place])
        near(report.rpm[place], speed_rpm, RPM * speed_rpm, unit="rpm", what=f"speed of the {name} wheel in 0x83")


# --- on the floor


@on_bench("R10", lasts_s=2.2, scene="hard-floor")
def test_straight_on(ride: Ride) -> None:
    ride.go(0.1)
    start = ride.now
    ride.drive(0.5, 0.5, 2.0)
    before = ride.before(LOOK_S)
    speed_m_s = ride.now.seen_from(before)[0] / ((ride.now.at_ns - before.at_ns) / NS_PER_S)
    rpm = course_rpm(Driven(throttle=0.5, inertia_kg_m2=CARRIED_KG_M2), 2.0)
    law_m_s = rpm * math.tau / 60 * DEFAULTS.wheel_radius_m
    near(speed_m_s, law_m_s, SPEED * law_m_s, unit="m/s", what="speed over ground 2 s after throttle 0.5")
    ahead_m, left_m = ride.now.seen_from(start)
    at_most(abs(left_m), DRIFT * ahead_m, unit="m", what=f"drift to the side on {ahead_m:.2f} m")
    at_most(abs(ride.now.yaw_deg - start.yaw_deg), DRIFT_DEG, unit="deg", what="drift of the heading")


def turn_ratio(ride: Ride, over_s: float = 0.5) -> tuple[float, float]:
    """Return how fast the rover turned lately, in deg/s, + to the left, and its share of what two wheels would make."""
    before = ride.before(over_s)
    turn_deg_s = (ride.now.yaw_deg - before.yaw_deg) / ((ride.now.at_ns - before.at_ns) / NS_PER_S)
    return turn_deg_s, turn_deg_s / ideal_turn_deg_s(ride.now.rpm_since(before))


@on_bench("R11", lasts_s=3.6, scene="hard-floor")
def test_turning_on_the_spot(ride: Ride) -> None:
    for throttle, for_s, way in ((0.8, 1.5, "left"), (-0.8, 2.0, "right")):
        ride.drive(-throttle, throttle, for_s)
        turn_deg_s, ratio = turn_ratio(ride)
        at_least(turn_deg_s * math.copysign(1, throttle), 60.0, unit="deg/s", what=f"rate of turn to the {way}")
        within(ratio, *RATIO, unit="of two wheels", what=f"rate of turn to the {way}")


@on_bench("R12", lasts_s=2.7, scene="carpet")
def test_turning_on_a_carpet(ride: Ride) -> None:
    ride.drive(-0.8, 0.8, 0.8)
    turn_deg_s, _ = turn_ratio(ride, 0.3)
    at_most(abs(turn_deg_s), STANDS_DEG_S, unit="deg/s", what="rate of turn at throttles -0.8 and 0.8")
    ride.drive(-1.0, 1.0, 1.8)
    within(turn_ratio(ride)[0], 10.0, 60.0, unit="deg/s", what="rate of turn at throttles -1 and 1")


@on_bench("R13", lasts_s=1.3, scene="hard-floor")
def test_unequal_throttles(ride: Ride) -> None:
    ride.drive(0.4, 0.7, 1.2)
    at_least(min(ride.rpm(LOOK_S)), TURNS_RPM, unit="rpm", what="slowest wheel at throttles 0.4 and 0.7")
    at_most(abs(ride.now.yaw_deg), DRIFT_DEG, unit="deg", what="turn at throttles 0.4 and 0.7")


# --- inertial sensor


def next_imu(ride: Ride) -> tuple[int, ImuReport]:
    """Wait for the next 0x82, and keep the link up; return it with the time of its first byte."""
    mark = ride.rover.mark()
    for _ in range(3):
        ride.go(FEED_S)
        if found := ride.rover.peer.since(mark, ImuReport):
            return found[0][0].start_ns, numbers_in(found[0][1])
    raise Violation("no 0x82 within 1.2 s", ride.rover.peer.evidence(mark))


@on_bench("R14", lasts_s=1.3)
def test_inertial_sensor_at_rest(ride: Ride) -> None:
    ride.go(0.8)
    _, report = next_imu(ride)
    require_valid(report)
    *level, up = acceleration_m_s2(report, ride.dialect)
    for axis, value in zip("xy", level, strict=True):
        near(value, 0.0, (ZERO_G_XY + NOISE_G) * G, unit="m/s^2", what=f"acceleration along {axis} at rest")
    near(up, G, (ZERO_G_Z + SENSITIVITY + NOISE_G) * G, unit="m/s^2", what="acceleration along z at rest")
    for axis, value in zip("xyz", report.rate_deg_s, strict=True):
        near(value, 0.0, REST_DEG_S, unit="deg/s", what=f"rate about {axis} at rest")
    near(report.temperature_c, ROOM_C, 1.0, unit="C", what="temperature")
    field_mgauss = math.hypot(*report.field_mgauss)
    near(field_mgauss, FIELD_MGAUSS, FIELD_OFF_MGAUSS, unit="mG", what="strength of the magnetic field")


def require_valid(report: ImuReport) -> None:
    """Require both validity bits of a 0x82."""
    if report.validity != VALID:
        raise Violation(f"the validity byte of 0x82 is {report.validity}, required {VALID}")


@on_bench("R15", lasts_s=2.2, scene="hard-floor")
def test_gyroscope(ride: Ride) -> None:
    ride.go(0.8)
    ride.drive(-1.0, 1.0, 0.5)
    at_ns, report = next_imu(ride)
    true_deg_s = ride.at(at_ns - READ_BEFORE_NS).turn_deg_s
    at_least(true_deg_s, 60.0, unit="deg/s", what="rate of turn")
    tolerance = SENSITIVITY * true_deg_s + RATE_DEG_S
    for axis, value, true in zip("xyz", report.rate_deg_s, (0.0, 0.0, true_deg_s), strict=True):
        near(value, true, tolerance, unit="deg/s", what=f"rate about {axis} in a turn to the left")


def angles_deg(ride: Ride, report: ImuReport) -> tuple[float, float, float]:
    """Return roll, pitch and yaw that the attitude of a 0x82 stands for."""
    w, x, y, z = attitude_wxyz(report, ride.dialect)
    near(math.hypot(w, x, y, z), 1.0, 1e-3, unit="", what="length of the quaternion")
    roll = math.atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    pitch = math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x))))
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    return math.degrees(roll), math.degrees(pitch), math.degrees(yaw)


@on_bench("R16", lasts_s=2.1, scene="ramp")
def test_attitude_on_a_ramp(ride: Ride) -> None:
    """Nose up is a negative pitch: x forward, y left, z up."""
    half = DEFAULTS.wheelbase_m / 2
    ride.place(RAMP_FOOT_M + 1.0, 0.0, 0.0, (1.0 + half) * math.tan(RAMP_SLOPE_RAD) + 0.002)
    ride.go(0.8)
    for _ in range(2):
        _, report = next_imu(ride)
    roll, pitch, _ = angles_deg(ride, report)
    near(pitch, -math.degrees(RAMP_SLOPE_RAD), LEVEL_DEG, unit="deg", what="pitch on the ramp")
    near(roll, 0.0, LEVEL_DEG, unit="deg", what="roll on the ramp")
    wanted = (G * math.sin(RAMP_SLOPE_RAD), 0.0, G * math.cos(RAMP_SLOPE_RAD))
    for axis, value, true in zip("xyz", acceleration_m_s2(report, ride.dialect), wanted, strict=True):
        near(value, true, ZERO_G_Z * G + NOISE_G * G, unit="m/s^2", what=f"acceleration along {axis} on the ramp")


@on_bench("R17", lasts_s=4.2, scene="hard-floor")
def test_heading_after_a_turn(ride: Ride) -> None:
    """The scene's x axis looks to magnetic north, and so does the rover at first."""
    ride.go(0.8)
    ride.drive(-0.8, 0.8, 1.5)
    ride.drive(0.0, 0.0, 0.6)
    for _ in range(2):
        at_ns, report = next_imu(ride)
    true_deg = ride.at(at_ns).yaw_deg
    at_least(true_deg, 60.0, unit="deg", what="turn to the left")
    *_, yaw = angles_deg(ride, report)
    require_field(report, true_deg)
    off_deg = math.remainder(yaw - true_deg, 360)
    near(off_deg, 0.0, HEADING_DEG, unit="deg", what=f"heading beside the true {true_deg:.0f} degrees")


def require_field(report: ImuReport, yaw_deg: float) -> None:
    """Require the field that a level rover sees which looks so far to the left of magnetic north."""
    yaw_rad = math.radians(yaw_deg)
    ahead, left = FIELD_NORTH_MGAUSS * math.cos(yaw_rad), -FIELD_NORTH_MGAUSS * math.sin(yaw_rad)
    for axis, value, true in zip("xyz", report.field_mgauss, (ahead, left, FIELD_UP_MGAUSS), strict=True):
        near(value, true, FIELD_OFF_MGAUSS, unit="mG", what=f"field along {axis} at {yaw_deg:.0f} degrees")


def require_axes_of_a_turn(ride: Ride, up: Sequence[float]) -> None:
    """Turn to the left, and require gravity and the turn along the axis of the sensor that points upward."""
    ride.go(0.8)
    _, report = next_imu(ride)
    for axis, value, share in zip("xyz", acceleration_m_s2(report, ride.dialect), up, strict=True):
        near(value, share * G, LEANING_G * G, unit="m/s^2", what=f"acceleration along {axis} of a sensor that leans")
    ride.drive(-1.0, 1.0, 0.5)
    at_ns, report = next_imu(ride)
    true_deg_s = ride.at(at_ns - READ_BEFORE_NS).turn_deg_s
    at_least(true_deg_s, 60.0, unit="deg/s", what="rate of turn")
    for axis, value, share in zip("xyz", report.rate_deg_s, up, strict=True):
        tolerance = SENSITIVITY * true_deg_s + RATE_DEG_S
        near(value, share * true_deg_s, tolerance, unit="deg/s", what=f"rate about {axis} of a sensor that leans")


@on_bench("R27", lasts_s=2.2, scene="hard-floor", settings={"imu": {"mount_roll_deg": 90.0}})
def test_sensor_on_its_side(ride: Ride) -> None:
    require_axes_of_a_turn(ride, (0.0, 1.0, 0.0))


@on_bench("R27", lasts_s=2.2, scene="hard-floor", settings={"imu": {"mount_pitch_deg": 90.0}})
def test_sensor_on_its_nose(ride: Ride) -> None:
    require_axes_of_a_turn(ride, (-1.0, 0.0, 0.0))


# --- position


def fixes(ride: Ride, mark: int) -> list[tuple[int, Position]]:
    """Return the positions of the 0x84 since a mark that say they are known, each with the time of its first byte."""
    found = ride.rover.peer.since(mark, GpsReport)
    return [(got.start_ns, position(numbers_in(report), ride.dialect)) for got, report in found if report.validity]


def last_position(ride: Ride, mark: int = 0) -> GpsReport:
    """Return the newest 0x84 since a mark."""
    found = ride.rover.peer.since(mark, GpsReport)
    if not found:
        raise Violation("no 0x84 came", ride.rover.peer.evidence(mark))
    return numbers_in(found[-1][1])


def off_m(ride: Ride, at_ns: int, place: Position) -> float:
    """Return how far a reported position is from where the rover was at the receiver's last full second before."""
    epoch_ns = (at_ns - EPOCH_LATE_NS) // NS_PER_S * NS_PER_S
    return math.dist(metres_off(ride.origin, place), ride.east_north_m(ride.at(epoch_ns)))


@on_bench("R18", lasts_s=3.2, scene="hard-floor")
def test_accuracy_of_the_position(ride: Ride) -> None:
    ride.go(3.1)
    found = fixes(ride, 0)
    if not found:
        raise Violation("no 0x84 with a known position within 3.1 s of a hot start", ride.rover.peer.evidence())
    for at_ns, place in found:
        at_most(off_m(ride, at_ns, place), 3 * CEP_M, unit="m", what="error of the position")


@on_bench("R19", lasts_s=8.3, scene="hard-floor", settings={"gps": {"accuracy_m": 0.0, "noise_m": 0.0}})
def test_positions_along_a_way(ride: Ride) -> None:
    ride.drive(1.0, 1.0, 8.2)
    found = fixes(ride, 0)
    at_least(len(found), 5, unit="positions", what="known positions in 8 s from a hot start")
    for at_ns, place in found:
        at_most(off_m(ride, at_ns, place), PLACE_M, unit="m", what="error of the position on the way")
    (_, first), *_, (_, last) = found
    way_m = math.dist(metres_off(ride.origin, first), metres_off(ride.origin, last))
    at_least(way_m, 2.0, unit="m", what="way between the first position and the last")


@on_bench("R20", lasts_s=6.4, scene="stand")
def test_without_a_fix(ride: Ride) -> None:
    ride.go(3.2)
    mark = ride.rover.mark()
    known = fixes(ride, 0)
    if not known:
        raise Violation("no 0x84 with a known position within 3.2 s of a hot start", ride.rover.peer.evidence())
    ride.open_sky(0.0)
    ride.go(3.1)
    report = last_position(ride, mark)
    if report.validity:
        raise Violation("0x84 knows a position, and the receiver sees no sky", ride.rover.peer.evidence())
    off = math.dist(metres_off(ride.origin, position(report, ride.dialect)), metres_off(ride.origin, known[-1][1]))
    at_most(off, 3 * CEP_M, unit="m", what="position in 0x84 beside the last known one")
    require_status(ride, 0)


def require_status(ride: Ride, wanted: int) -> None:
    """Require the STATUS byte."""
    status = ride.status()
    if status != wanted:
        raise Violation(f"STATUS is {status:#04x}, required {wanted:#04x}", ride.rover.peer.evidence())


@on_bench("R21", lasts_s=3.9, settings={"gps": {"baud": 4800}})
def test_receiver_that_is_not_understood(ride: Ride) -> None:
    require_status(ride, 0)
    ride.go(3.8)
    require_status(ride, StatusFlag.GPS_FAIL)
    if last_position(ride).validity:
        raise Violation("0x84 says that the position is known", ride.rover.peer.evidence())


# --- what breaks on the way


@on_bench("R22", lasts_s=5.8)
@pytest.mark.parametrize("fault", ["stuck", "deaf"])
def test_bus_of_the_inertial_sensor_breaks(ride: Ride, fault: str) -> None:
    ride.drive(0.4, 0.4, 1.2)
    require_status(ride, 0)
    broken_ns = break_bus(ride, fault)
    while not ride.status() & StatusFlag.AHRS_FAIL and ride.now.at_ns - broken_ns < NS_PER_S:
        ride.go(0.02)
    at_most((ride.now.at_ns - broken_ns) / NS_PER_S, FAILS_S, unit="s", what="time from the fault to STATUS")
    ride.drive(0.6, 0.6, 1.2)
    _, report = next_imu(ride)
    if report.validity:
        raise Violation(f"the validity byte of 0x82 is {report.validity}, and the sensor is not there")
    require_speeds(ride, [settled_rpm(Driven(throttle=0.6))] * 4, LAW_RPM, "at throttle 0.6, without the sensor")
    ride.bus.unstick()
    ride.bus.deaf.clear()
    ride.go(MENDED_S)
    require_status(ride, 0)


def break_bus(ride: Ride, fault: str) -> int:
    """Break the sensor's bus; return when."""
    if fault == "stuck":
        ride.bus.stick()
    else:
        ride.bus.deaf.add(MPU9250)
    return ride.now.at_ns


@on_bench("R23", lasts_s=4.4, scene="hard-floor")
@pytest.mark.parametrize("control", ["throttles", "setpoints"])
def test_lost_link(ride: Ride, control: str) -> None:
    if control == "throttles":
        ride.drive(0.5, 0.5, 0.8)
    else:
        ride.keep(120.0, 120.0, 0.8)
    ride.rover.peer.send(RequestTelemetry())
    last_ns = ride.heard_ns()
    ride.rover.peer.run(2.2)
    for pin in ENABLES:
        pulses = ride.pulses(pin, last_ns)
        gone_s = (pulses[-1] - last_ns) / NS_PER_S if pulses else 0.0
        within(gone_s, *LOST_S, unit="s", what=f"time from the last frame to the last pulse at {pin}")
    at_most(max(map(abs, ride.rpm(0.1))), TWITCHES_RPM, unit="rpm", what="wheels 2.2 s after the last frame")
    ride.go(0.6)
    at_most(max(map(abs, ride.rpm(0.1))), TWITCHES_RPM, unit="rpm", what="wheels with requests alone")
    _, report = ride.motion()
    ride.rover.require_throttles(report, 0.0, 0.0)
    ride.drive(0.5, 0.5, 0.6)
    at_least(min(ride.rpm(0.1)), TURNS_RPM, unit="rpm", what="wheels after the next command")


@on_bench("R24", lasts_s=3.3)
def test_a_stalled_wheel(ride: Ride) -> None:
    """Its motor draws more, and the others get less."""
    ride.drive(0.5, 0.5, 1.2)
    ride.hold("rf")
    held_ns = ride.now.at_ns
    while ride.now.at_ns - held_ns < NS_PER_S + REPORT_NS:
        at_ns, report = ride.motion()
        if report.rpm[1] == 0.0:
            break
    at_most((at_ns - held_ns) / NS_PER_S, STALLED_S, unit="s", what="time from the stall to a 0x83 with 0 rpm")
    at_most(abs(ride.rpm(0.1)[1]), 0.5, unit="rpm", what="the wheel that is held")
    ticks = report.ticks[1]
    for place, name in enumerate(NAMES):
        if place != 1:
            at_least(report.rpm[place], TURNS_RPM, unit="rpm", what=f"the {name} wheel meanwhile, in 0x83")
    ride.hold("rf", held=False)
    ride.go(0.5)
    _, report = ride.motion()
    at_least(report.rpm[1], TURNS_RPM, unit="rpm", what="the wheel that was let go, in 0x83")
    at_least(report.ticks[1], ticks + 1, unit="slots", what="its ticks")


@on_bench("R25", lasts_s=3.5, scene="rover-room")
def test_a_wall(ride: Ride) -> None:
    ride.place(WALL_M - DEFAULTS.body_length_m / 2 - 0.3, 0.0)
    ride.go(0.1)
    start = ride.now
    ride.drive(0.35, 0.35, 2.0)
    near(ride.now.seen_from(start)[0], 0.3, 0.02, unit="m", what="way to the wall")
    ride.go(1.1)
    _, report = ride.motion()
    for name, true_rpm, rpm in zip(NAMES, ride.rpm(LOOK_S), report.rpm, strict=True):
        at_most(abs(true_rpm), TWITCHES_RPM, unit="rpm", what=f"{name} wheel at the wall")
        near(rpm, 0.0, 0.01, unit="rpm", what=f"{name} wheel at the wall, in 0x83")
    ride.rover.require_throttles(report, 0.35, 0.35)


@on_bench("R26", lasts_s=1.6, settings={"cells": {"charge": 0.1}})
def test_an_empty_battery(ride: Ride) -> None:
    require_law(ride, (1.0,), 1.5, emf_v=volts_at(0.1))
    rpm = max(ride.rpm(LOOK_S))
    at_most(rpm, 0.9 * settled_rpm(Driven(throttle=1.0)), unit="rpm", what="fastest wheel at full throttle")
