"""The adapter drives the virtual Pioneer: codes on wires to metres on the floor, echoes to levels."""

from __future__ import annotations

import math

import pytest

from targets.parts.p2os_adapter import P2osAdapterSettings, RobotConnected
from targets.robots.pioneer import RobotSettings

MS = 1_000_000
OTHER_CODES = pytest.mark.exhaustive("other codes; the gate has the ends of their range")


class PioneerEnd:
    """A rig of the virtual robot as the far end of an adapter's line."""

    def __init__(self, rig) -> None:
        self.rig = rig
        self._seen = 0

    def receive(self, data: bytes, _now_ns: int) -> bytes:
        self.rig.send(data)
        return self._fresh()

    def advance(self, now_ns: int) -> bytes:
        self.rig.run((now_ns - self.rig.now_ns) / 1e9)
        self.rig.connected = self.rig.robot.connection.state.name == "OPEN"
        return self._fresh()

    def _fresh(self) -> bytes:
        fresh = self.rig.received[self._seen :]
        self._seen = len(self.rig.received)
        return b"".join(received.raw for received in fresh)


@pytest.fixture
def drive(make_adapter, make_rig):
    """An adapter in session with a virtual Pioneer; settings of the adapter by name."""

    def make(**settings):
        adapter = make_adapter(PioneerEnd(make_rig(RobotSettings())), **settings)
        adapter.connect()
        assert adapter.told(RobotConnected)[0].subclass == "p2dx"
        return adapter

    return make


def test_it_connects_and_never_runs_into_the_watchdog(drive) -> None:
    adapter = drive()
    adapter.run(8.0)
    names = {type(event).__name__ for event in adapter.robot.rig.events}
    assert "WatchdogExpired" not in names
    assert adapter.robot.rig.sips[-1].motors_enabled


@pytest.mark.parametrize(
    ("code", "speed_m_s"),
    [
        (3, 0.187),
        (-4, -0.250),
        pytest.param(1, 0.062, marks=OTHER_CODES),
        pytest.param(0, 0.0, marks=OTHER_CODES),
    ],
)
def test_g02_speed_of_a_code(drive, code, speed_m_s) -> None:
    adapter = drive()
    chassis = adapter.robot.rig.chassis
    adapter.codes(code, code)
    adapter.run(2.0)
    before_m = chassis.x_m
    adapter.run(2.0)
    assert (chassis.x_m - before_m) / 2 == pytest.approx(speed_m_s, abs=0.002)
    assert abs(chassis.yaw_rad) < math.radians(0.5)
    adapter.codes(0, 0)
    adapter.run(1.0)
    there_m = chassis.x_m
    adapter.run(1.0)
    assert chassis.x_m == pytest.approx(there_m, abs=1e-3)


@pytest.mark.parametrize(("turning", "deg_s"), [("published", 2), ("differential", 20)])
def test_g20_turning(drive, turning, deg_s) -> None:
    adapter = drive(turning=turning)
    chassis = adapter.robot.rig.chassis
    adapter.codes(-1, 1)
    adapter.run(2.0)
    before_rad = chassis.yaw_rad
    adapter.run(2.0)
    assert math.degrees(chassis.yaw_rad - before_rad) / 2 == pytest.approx(deg_s, rel=0.1, abs=0.2)


def test_obstacles_before_each_disc(drive) -> None:
    adapter = drive(dd1_forced_low=False, dd7_8_driven=True)
    chassis = adapter.robot.rig.chassis
    for disc in range(8):
        chassis.echoes = {number: (0.6 if number == disc else 3.0) for number in range(8)}
        adapter.run(0.7)
        assert adapter.distances() == [number == disc for number in range(8)]
    chassis.echoes = {}
    adapter.run(0.7)
    assert adapter.distances() == [False] * 8


def test_encoder_wires_in_the_wheel_form_follow_the_wheels(drive) -> None:
    adapter = drive(encoder_form="wheel", encoder_order="lsb-first")
    adapter.codes(3, 2)
    for _ in range(10):
        adapter.run(0.5)
        for word, angle_rad in zip(
            adapter.encoders("lsb-first"), adapter.robot.rig.chassis.wheel_angles_rad(), strict=True
        ):
            behind = (angle_rad / (math.pi / 4) - word) % 8
            assert behind < 1.5 or behind > 7.8, "more than a SIP and some rounding behind"


def test_g22_reset_makes_the_link_anew_and_the_robot_stops_meanwhile(drive, pulse) -> None:
    adapter = drive()
    adapter.codes(3, 3)
    adapter.run(2.0)
    pulse(adapter.wire("rst"), adapter.now_ns, adapter.now_ns + 10 * MS)
    adapter.run(6.0)
    assert len(adapter.told(RobotConnected)) == 2
    before_m = adapter.robot.rig.chassis.x_m
    adapter.run(1.0)
    assert adapter.robot.rig.chassis.x_m - before_m == pytest.approx(0.187, abs=0.002)


def test_leaving_stops_the_robot(drive) -> None:
    adapter = drive()
    adapter.codes(3, 3)
    adapter.run(2.0)
    adapter.put("p2dx_con", False)
    adapter.run(2.0)
    there_m = adapter.robot.rig.chassis.x_m
    adapter.run(2.0)
    assert adapter.robot.rig.chassis.x_m == there_m
    assert not adapter.robot.rig.chassis.servo


def test_published_encoder_numbers_repeat_eight_times_per_radian(drive) -> None:
    """Half a metre straight on is five rad of a 0.1 m wheel: forty numbers."""
    from targets.parts.p2os_adapter import EncoderWords

    adapter = drive()
    adapter.codes(1, 1)
    adapter.run(0.5 / 0.062)
    words = [event.left for event in adapter.told(EncoderWords)]
    assert len(words) == pytest.approx(40, abs=2)
    assert P2osAdapterSettings().encoder_radius_m == 0.1
