"""The ground station against a behavioural rover: over a line in the bench, in each profile."""

from __future__ import annotations

import math
import runpy
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.bench import Bench
from hilbench.bench.devices import DeviceActor
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.systems.rover.ground_station import Chassis, GroundStation
from protocols.pkt import (
    PROFILES,
    ClientOptions,
    ClientState,
    GeneralReport,
    ImuReport,
    LocalProtocolError,
    Schema,
)
from targets.robots.rover import RoverRobot, RoverSettings
from tests.each import each


@pytest.fixture
def make():
    """Make a station and a rover of a profile; our own client's habits with that profile's frames."""

    def make(profile="documented", **options):
        server = PROFILES[profile].server
        bench = Bench(Scheduler(), Journal())
        link = MemoryLink(bench.scheduler, Line(baud=115200), name="host")
        robot = RoverRobot(RoverSettings(profile=profile))
        actor = DeviceActor(bench, robot, link.b, name="rover")
        client = ClientOptions(frames=server.frames, schema=server.schema, **options)
        station = GroundStation(bench, link.a, PROFILES[profile], options=client)
        return SimpleNamespace(bench=bench, link=link, robot=robot, actor=actor, station=station)

    return make


def test_the_link_is_kept_up_while_it_is_connected(make):
    there = make()
    there.station.connect()
    there.station.drive_motors(0.3, -0.3)
    there.bench.run_for(10.0)
    assert there.station.state is ClientState.LINKED
    assert there.robot.duties == pytest.approx((0.3, -0.3))
    assert there.station.totals.accepted == 1
    there.station.disconnect()
    there.bench.run_for(0.1)
    assert there.robot.duties == (0.0, 0.0)
    assert there.station.state is ClientState.IDLE


def test_without_it_the_rover_stops(make):
    there = make(request_s=None)
    there.station.drive_motors(0.3, 0.3)
    there.bench.run_for(0.9)
    assert there.robot.duties != (0.0, 0.0)
    there.bench.run_for(0.3)
    assert there.robot.duties == (0.0, 0.0)


def test_telemetry_in_one_set_of_units(make):
    for profile in ("documented", "g2"):
        there = make(profile)
        there.station.connect()
        there.bench.run_for(2.2)
        assert there.station.acceleration_m_s2 == pytest.approx((0.0, 0.0, 9.80665), rel=1e-6)
        assert there.station.attitude_wxyz == (1.0, 0.0, 0.0, 0.0)
        assert there.station.rate_deg_s == (0.0, 0.0, 0.0)
        assert there.station.counts[ImuReport] >= 2


def test_position_and_none(make):
    there = make()
    assert there.station.position is None
    there.bench.run_for(1.0)
    assert there.station.position.latitude_deg == pytest.approx(-34.6175)
    assert there.station.position.longitude_deg == pytest.approx(-58.3683)
    there.robot.position = None
    there.bench.run_for(1.2)
    assert there.station.position is None


def test_speeds_are_kept(make):
    there = make()
    there.station.connect()
    there.station.set_gains(0.001, 0.0, 0.004)
    there.station.drive_wheels(120.0, 110.0)
    there.bench.run_for(15.0)
    assert there.station.motion.rpm == pytest.approx((120.0, 110.0, 120.0, 110.0), rel=0.05)
    assert there.station.motion.setpoints_rpm == (120.0, 110.0)


def test_the_led(make):
    there = make()
    there.station.switch_led(lit=True)
    there.bench.run_for(0.1)
    assert there.robot.lit
    there.station.switch_led(lit=False)
    there.bench.run_for(0.1)
    assert not there.robot.lit


@each("profile", ["g0", "term-doc"])
def test_rovers_of_the_first_schema_are_driven_by_voltages(make, profile):
    there = make(profile)
    there.station.connect()
    there.station.drive_motors(1.0, -0.2)
    there.bench.run_for(0.1)
    assert there.robot.duties == (1.0, -0.2)
    there.station.drive_wheels(125.0, -125.0)
    there.bench.run_for(0.1)
    assert there.robot.duties == pytest.approx((0.5, -0.5), abs=0.003)
    with pytest.raises(LocalProtocolError):
        there.station.drive_motors(1.2, 0.0)
    with pytest.raises(LocalProtocolError):
        there.station.set_gains(1.0, 0.0, 0.0)


def test_a_rover_that_falls_silent_is_lost_and_found(make):
    there = make()
    there.station.connect()
    there.bench.run_for(1.0)
    assert there.station.failure == ""
    there.link.hang_up()
    there.bench.run_for(0.1)
    assert there.station.failure == "the line went down"
    there.link.restore()
    there.bench.run_for(2.0)
    assert there.station.failure == ""
    assert there.station.state is ClientState.LINKED


def test_history_is_bounded(make):
    there = make()
    there.station.history = type(there.station.history)(maxlen=5)
    heard = []
    there.station.on_report = heard.append
    there.bench.run_for(3.0)
    assert len(there.station.history) == 5
    assert list(there.station.history) == heard[-5:]
    assert there.station.counts.total() == len(heard) > 20
    assert there.station.general == there.station.latest[GeneralReport].report


def test_counters_do_not_wrap(make):
    there = make()
    there.station.connect()
    for _ in range(300):
        there.station.switch_led(lit=True)
        there.bench.run_for(0.02)
    there.station.request()
    there.bench.run_for(0.1)
    assert there.station.totals.accepted == 300
    assert there.station.general.accepted == 300 - 256


# --- the unicycle


@given(st.floats(-1, 1), st.floats(-5, 5), st.floats(1, 3))
def test_unicycle_and_back(speed_m_s, turn_rad_s, slip):
    chassis = Chassis(turn_slip=slip)
    left, right = (rpm / 60 * 2 * math.pi * 0.0325 for rpm in chassis.wheels_rpm(speed_m_s, turn_rad_s))
    assert (left + right) / 2 == pytest.approx(speed_m_s, abs=1e-9)
    assert (right - left) / 0.140 / slip == pytest.approx(turn_rad_s, abs=1e-9)


def test_a_turn_to_the_left_runs_the_right_wheels(make):
    there = make()
    there.station.drive(0.2, 1.0)
    there.bench.run_for(0.5)
    left, right = there.robot.motors.setpoints_rpm
    assert right > left > 0
    assert there.station.options.schema is Schema.V2


def test_the_example_drives(monkeypatch, capfd):
    monkeypatch.setattr(sys, "argv", ["drive_rover.py"])
    runpy.run_path(str(Path(__file__).parents[4] / "examples" / "clients" / "drive_rover.py"), run_name="__main__")
    out, err = capfd.readouterr()
    assert err == ""
    assert "wheels  97.3" in out
    assert out.splitlines()[-1].startswith("  2.9")
