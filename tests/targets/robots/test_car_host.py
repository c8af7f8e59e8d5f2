"""The simulator's side as a device on a line: commands to the car, statuses from it, CARLA's ackermann node."""

from __future__ import annotations

import pytest

from protocols.carla import (
    ORIGINAL_SIGNS,
    PROFILES,
    ROS_SIGNS,
    VECTORS,
    AckermannCommand,
    CommandFrame,
    ManualCommand,
    Mode,
    decode_status,
    encode_command,
)
from targets.robots.car_host import (
    BEHAVIOURS,
    DEFECTS,
    PROFILE_NAMES,
    CarCommanded,
    CarHost,
    CarHostSettings,
    CarState,
    behaviour_of,
)
from tests.each import each

MS = 1_000_000
F1, F2 = VECTORS["F1"].data, VECTORS["F2"].data


class Line:
    """A host, with the bytes that it has sent."""

    def __init__(self, **settings):
        self.host = CarHost(CarHostSettings(**settings))
        self.now_ns = 0
        self.sent = b""

    def run(self, ms, data=b""):
        if data:
            self.sent += self.host.receive(data, self.now_ns)
        self.now_ns += round(ms * MS)
        self.sent += self.host.advance(self.now_ns)

    @property
    def statuses(self):
        return [decode_status(self.sent[at : at + 22]) for at in range(0, len(self.sent), 22)]

    def commanded(self):
        return [event for event in self.host.take_events() if isinstance(event, CarCommanded)]


def test_commands_reach_the_car():
    line = Line()
    assert line.host.wish is None
    line.run(10, F1)
    assert isinstance(line.host.wish, AckermannCommand)
    line.run(10, F2)
    assert line.host.wish == ManualCommand(steer=-0.5, throttle=0.75, brake=0.0)
    assert len(line.commanded()) == 2


@each(
    ("settings", "sign"),
    [({}, 1), ({"signs": "original"}, -1), ({"signs": "ros"}, 1)],
)
def test_statuses_come_twenty_times_a_second_with_the_signs_asked_for(settings, sign):
    line = Line(**settings)
    line.host.sense(CarState(lon_speed_m_s=5.0, lat_speed_m_s=0.5, yaw_rate_rad_s=0.25, steering_rad=-0.125))
    line.run(1000)
    assert len(line.statuses) == 20
    last = line.statuses[-1]
    assert (last.lon_speed_m_s, last.lat_speed_m_s, last.heading_rate_rad_s, last.steering_rad) == (
        5.0,
        sign * 0.5,
        sign * 0.25,
        -0.125,
    )


def test_another_rate():
    line = Line(status_hz=50.0)
    line.run(1000)
    assert len(line.statuses) == 50


def test_reports_by_hand():
    line = Line()
    line.host.report_by_hand()
    line.run(1000)
    assert line.sent == b""
    line.sent += line.host.report("velocity", now_ns=line.now_ns)
    assert line.sent == b""
    line.sent += line.host.report("steering", now_ns=line.now_ns)
    assert len(line.statuses) == 1


def test_a_board_that_falls_silent_stops_the_car():
    line = Line()
    line.run(600, F1)
    assert line.host.wish == AckermannCommand()
    drives_on = Line(defects=("never-stops",))
    drives_on.run(600, F1)
    assert drives_on.host.wish.speed_m_s == 5.0


def test_signs_are_those_of_the_profile_unless_others_are_asked_for():
    assert behaviour_of("hardened", ()).host.signs == ROS_SIGNS
    assert behaviour_of("v0", ()).host.signs == behaviour_of("v1", ()).host.signs == ORIGINAL_SIGNS
    assert behaviour_of("v0", (), "ros").host.signs == ROS_SIGNS


def test_the_ackermann_node_contradicts_the_joystick():
    line = Line(defects=("node-overlap",))
    line.run(20, F1)
    for _ in range(30):
        line.run(60, encode_command(CommandFrame(speed=0.5, mode=Mode.MANUAL)))
    by_node = [event for event in line.commanded() if event.by_node]
    assert 15 <= len(by_node) <= 21
    assert line.host.wish == ManualCommand(throttle=0.5)


def test_a_line_that_goes_down_is_not_noticed():
    line = Line()
    line.sent += line.host.line_down(0)
    line.run(100)
    assert len(line.statuses) == 2


def test_reading_that_fails_gives_nothing_new():
    line = Line(profile="v0")
    line.run(30, F1)
    line.sent += line.host.read_error(failing=True, now_ns=line.now_ns)
    line.run(400)
    assert len(line.commanded()) >= 18


def test_profiles_and_defects():
    assert {*PROFILE_NAMES} == {*PROFILES} == {*BEHAVIOURS}
    assert {"H1", "H3", "H4", "H5"} <= {*DEFECTS}
    for name in DEFECTS:
        assert behaviour_of("hardened", [name]) != BEHAVIOURS["hardened"]
    with pytest.raises(ValueError, match="defects has 'H2', which is none"):
        CarHostSettings(defects=("H2",))
    with pytest.raises(ValueError, match=r"status_hz 0\.5 is not 1\.\.1000 Hz"):
        CarHostSettings(status_hz=0.5)
