"""The behavioural rover: its wheels against the published bench test, its controllers against their formula."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.pkt import (
    PROFILES,
    ClientOptions,
    Connection,
    GpsReport,
    ImuReport,
    LedOn,
    MotionReport,
    MotorSpeeds,
    MotorThrottles,
    PidGains,
    Position,
    ReportReceived,
    Role,
    SpeedSetpoints,
)
from targets.robots.rover import DEFECTS, LedSwitched, MotorsCommanded, Plant, RoverRobot, RoverSettings, steady_rpm
from tests.each import each

SECOND = 1_000_000_000
TICK = SECOND // 100


class Station:
    """A rover and somebody who talks to it over a line without delay."""

    def __init__(self, **settings):
        self.robot = RoverRobot(RoverSettings(**settings))
        server = self.robot.behaviour.server
        self.host = Connection(Role.CLIENT, ClientOptions(frames=server.frames, schema=server.schema, silence_s=None))
        self.now_ns = 0
        self.reports = []
        self.events = []

    def run(self, seconds, step_ns=TICK):
        end_ns = self.now_ns + round(seconds * SECOND)
        while self.now_ns < end_ns:
            self.now_ns = min(end_ns, self.now_ns + step_ns)
            self._hear(self.robot.advance(self.now_ns))

    def say(self, command):
        self._hear(self.robot.receive(self.host.send(command, self.now_ns), self.now_ns))

    def _hear(self, data):
        for event in self.host.receive(data, self.now_ns):
            if isinstance(event, ReportReceived):
                self.reports.append((self.now_ns, event.report))
        self.events += self.robot.take_events()

    def last(self, kind):
        return [report for _, report in self.reports if isinstance(report, kind)][-1]


# --- the plant


@each(("throttle", "rpm"), [(0.25, 97.5), (0.30, 117.5), (0.35, 133.0), (0.39, 143.5), (-0.30, -117.5)])
def test_steady_speeds_are_those_of_the_bench_test(throttle, rpm):
    assert steady_rpm(throttle, turning=True) == pytest.approx(rpm)
    plant = Plant(0.08)
    for tick in range(1, 200):
        plant.advance((throttle, throttle), tick * TICK)
    assert [wheel.rpm for wheel in plant.wheels] == pytest.approx([rpm] * 4, rel=1e-6)


def test_breakaway_has_a_hysteresis():
    assert steady_rpm(0.22, turning=False) == 0.0
    assert steady_rpm(0.23, turning=False) > 0
    assert steady_rpm(0.20, turning=True) > 0
    assert steady_rpm(0.19, turning=True) == 0.0
    assert steady_rpm(math.nan, turning=True) == 0.0


@given(st.floats(-2, 2), st.floats(-2, 2))
def test_more_throttle_is_never_slower(one, other):
    low, high = sorted((one, other))
    assert steady_rpm(low, turning=True) <= steady_rpm(high, turning=True)


@given(st.floats(-400, 400), st.lists(st.integers(1, 50), min_size=1, max_size=20))
def test_slots_are_counted_once_however_time_is_cut(rpm, steps_ms):
    whole, cut = Plant(0.08), Plant(0.08)
    now_ns = 0
    for plant in (whole, cut):
        plant.force(rpm)
    for step_ms in steps_ms:
        now_ns += step_ms * SECOND // 1000
        cut.advance((0.0, 0.0), now_ns)
    whole.advance((0.0, 0.0), now_ns)
    expected = abs(rpm) / 60 * now_ns / SECOND * 20
    assert abs(whole.wheels[0].ticks - cut.wheels[0].ticks) <= 1
    assert abs(whole.wheels[0].ticks - expected) <= 1


def test_held_wheels_stand():
    plant = Plant(0.08)
    plant.force(0.0)
    plant.advance((1.0, 1.0), SECOND)
    assert [wheel.ticks for wheel in plant.wheels] == [0] * 4


# --- what is said about it


@each("rpm", [30.0, 97.5, 149.0, 151.0, 180.0, 600.0])
def test_tachometers(rpm):
    documented, shipped = Station(), Station(profile="g2")
    for station in (documented, shipped):
        station.robot.plant.force(rpm)
        station.run(2.5)
    assert documented.last(MotionReport).rpm == pytest.approx((rpm,) * 4, rel=1e-3)
    assert shipped.last(MotionReport).rpm == pytest.approx((rpm if rpm <= 150 else 0.0,) * 4, rel=1e-3)


def test_slow_wheels_stand():
    """Below 3 rpm there is more than a second between two slots."""
    station = Station()
    station.robot.plant.force(2.5)
    station.run(5.0)
    assert station.last(MotionReport).rpm == (0.0,) * 4
    assert station.last(MotionReport).ticks[0] >= 3


@each("cycles", [1, 2, 12, 25])
def test_speed_controller_against_its_formula(cycles):
    """Held wheels, setpoint 30: kp e + ki e n dt, and kd e/dt in the first turn alone."""
    station = Station()
    station.robot.plant.force(0.0)
    station.run(0.01)
    station.say(SpeedSetpoints(a_rpm=30.0, b_rpm=30.0))
    station.run(0.02 * cycles)
    expected = 0.01 * 30 + 0.0001 * 30 * cycles * 0.02 + (0.0001 * 30 / 0.02 if cycles == 1 else 0.0)
    assert station.robot.motors.throttles == pytest.approx([expected] * 2)


def test_pid_mode_holds_a_speed_that_the_wheels_can_have():
    station = Station()
    station.say(PidGains(kp=0.001, kd=0.0, ki=0.004))
    station.say(SpeedSetpoints(a_rpm=110.0, b_rpm=-110.0))
    for _ in range(40):
        station.run(0.5)
        station.say(LedOn())
    assert station.last(MotionReport).rpm == pytest.approx((110.0,) * 4, rel=0.05)
    throttles = station.last(MotionReport).throttles
    assert throttles[0] > 0 > throttles[1]


def test_speeds_of_the_first_schema_are_shares_of_255():
    station = Station(profile="g0")
    station.say(MotorSpeeds(a=255, b=-51))
    assert station.robot.duties == (1.0, -0.2)


def test_a_throttle_beyond_one_reaches_the_motors_as_one():
    station = Station(profile="g2", boot_s=0.0)
    station.say(MotorThrottles(a=1.5, b=math.nan))
    station.run(0.02)
    assert station.robot.duties == (1.0, 0.0)
    assert station.robot.motors.throttles[0] == 1.5


def test_a_lost_link_stops_the_motors():
    station = Station()
    station.say(MotorThrottles(a=0.5, b=0.5))
    station.run(0.99)
    assert station.robot.duties == (0.5, 0.5)
    station.run(0.02)
    assert station.robot.duties == (0.0, 0.0)
    told = [event for event in station.events if isinstance(event, MotorsCommanded)]
    assert [event.throttles for event in told] == [(0.5, 0.5), (0.0, 0.0)]


def test_sensors_at_rest():
    station = Station()
    station.robot.position = Position(latitude_deg=52.5, longitude_deg=13.4)
    station.run(1.1)
    imu, gps = station.last(ImuReport), station.last(GpsReport)
    assert imu.acceleration == pytest.approx((0.0, 0.0, 9.80665))
    assert imu.quaternion == (0.0, 0.0, 0.0, 1.0)
    assert (gps.first_deg, gps.second_deg) == pytest.approx((52.5, 13.4))
    station.robot.position = None
    station.run(1.0)
    assert station.last(GpsReport) == GpsReport()


@each("profile", PROFILES)
def test_the_led(profile):
    station = Station(profile=profile)
    station.run(1.5)
    station.say(LedOn())
    station.run(0.02)
    assert station.robot.lit
    assert LedSwitched(lit=True) in station.events


def test_a_rover_that_boots_hears_nothing():
    station = Station(boot_s=0.955)
    station.say(LedOn())
    station.run(0.95)
    assert (station.robot.lit, station.reports) == (False, [])
    station.run(0.05)
    assert station.reports[0][0] == 96 * TICK


@given(st.lists(st.integers(1, 3 * TICK), min_size=1, max_size=30))
def test_what_is_said_does_not_depend_on_how_often_it_is_asked(steps_ns):
    asked, left_alone = Station(), Station()
    for station in (asked, left_alone):
        station.say(MotorThrottles(a=0.3, b=-0.3))
    for step_ns in steps_ns:
        asked.run(step_ns / SECOND, step_ns)
    left_alone.run(sum(steps_ns) / SECOND, sum(steps_ns))
    asked.run(0.01)
    left_alone.run(0.01)
    assert [report for _, report in asked.reports] == [report for _, report in left_alone.reports]


@each(
    ("settings", "message"),
    [({"defects": ("no-rsync",)}, "defects"), ({"boot_s": -1.0}, "boot_s"), ({"wheel_lag_s": 0.0}, "wheel_lag_s")],
)
def test_settings_that_make_no_rover(settings, message):
    with pytest.raises(ValueError, match=f"^{message} "):
        RoverSettings(**settings)


@each("defect", DEFECTS.values())
def test_a_defect_changes_something_and_names_its_source(defect):
    assert defect.text
    assert defect.source
    assert RoverRobot(RoverSettings(defects=(defect.name,))).behaviour != RoverRobot(RoverSettings()).behaviour
