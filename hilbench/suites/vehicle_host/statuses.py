"""What is said of the car, and how often."""

from __future__ import annotations

from itertools import pairwise

from hilbench.check import Untimely, Violation, at_least, at_most, near
from hilbench.clock import NS_PER_S
from hilbench.suites.vehicle_host._host import COMMAND, F1, STOP_WITHIN_S, Host, host, on_host
from protocols.carla import STATUS_BYTES, StatusFrame
from targets.robots.car_host import CarState

__all__ = ["host"]


@on_host("VS13", lasts_s=2.2)
def test_a_status_has_22_bytes(host: Host) -> None:
    board = host.board
    mark, dropped = board.mark(), len(board.dropped)
    board.run(2.0)
    if board.dropped[dropped:]:
        between = board.dropped[dropped].data.hex(" ").upper()
        raise Violation(f"{between} is between the frames of {STATUS_BYTES} bytes", board.evidence())
    at_least(len(board.frames(mark)), 1, unit="statuses", what="in 2 s")


@on_host("VS14", lasts_s=1.0)
def test_a_status_waits_for_both_reports(host: Host) -> None:
    host.board.commands.start(20.0)  # a quiet board may hold statuses up, see VS21
    _require_one_status(host, CarState(lon_speed_m_s=3.0, steering_rad=0.25), "velocity", "steering")
    _require_one_status(host, CarState(lon_speed_m_s=-4.0, steering_rad=-0.1), "velocity", "steering")
    _require_one_status(host, CarState(lon_speed_m_s=5.0, steering_rad=0.3), "steering", "velocity")


def _require_one_status(host: Host, state: CarState, first: str, second: str) -> None:
    """Say one report and 0.15 s later the other; require no status behind the first, and one behind both."""
    host.move(state)
    host.board.run(0.1)
    mark = host.statuses_from_now()
    host.own.report(first)
    host.board.run(0.15)
    at_most(len(host.board.frames(mark)), 0, unit="statuses", what=f"of a {first} report alone")
    host.own.report(second)
    status = _only(host, mark, 0.15)
    near(status.lon_speed_m_s, state.lon_speed_m_s, 1e-6, unit="m/s", what="its speed")
    near(status.steering_rad, state.steering_rad, 1e-6, unit="rad", what="its steering")


def _only(host: Host, mark: int, wait_s: float) -> StatusFrame:
    """Let time pass; return the one status since a mark."""
    said = host.statuses(mark, wait_s)
    assert said, "no status comes after both reports"
    assert len(said) == 1, f"{len(said)} statuses come after both reports, required one"
    return said[0]


@on_host("VS15", lasts_s=0.6)
def test_the_newest_report_counts(host: Host) -> None:
    for newer in (
        CarState(lon_speed_m_s=4.0, lat_speed_m_s=0.3, yaw_rate_rad_s=0.4),
        CarState(lon_speed_m_s=6.0, lat_speed_m_s=0.2, yaw_rate_rad_s=0.1),
    ):
        _require_newer(host, newer)


def _require_newer(host: Host, newer: CarState) -> None:
    """Say a velocity, a newer one, and the steering; require one status with the newer velocity, its signs aside."""
    host.move(CarState(lon_speed_m_s=3.0, lat_speed_m_s=0.1, yaw_rate_rad_s=0.2))
    host.say(F1, 0.0)
    mark = host.statuses_from_now()
    host.own.report("velocity")
    host.own.sense(newer)
    host.own.report("velocity", "steering")
    said = host.statuses(mark, 0.1)
    speeds = [one.lon_speed_m_s for one in said]
    assert speeds == [newer.lon_speed_m_s], f"the reported speeds are {speeds}, required one, the newer"
    near(abs(said[0].lat_speed_m_s), newer.lat_speed_m_s, 1e-6, unit="m/s", what="B, its sign aside")
    near(abs(said[0].heading_rate_rad_s), newer.yaw_rate_rad_s, 1e-6, unit="rad/s", what="C, its sign aside")


def _said(host: Host, state: CarState) -> tuple[float, float, float, float]:
    """The status of a car that moves so."""
    host.move(state)
    host.say(F1, 0.0)
    mark = host.statuses_from_now()
    host.own.report("velocity", "steering")
    status = _only(host, mark, 0.1)
    return status.lon_speed_m_s, status.lat_speed_m_s, status.heading_rate_rad_s, status.steering_rad


@on_host("VS16", lasts_s=0.4)
def test_the_sign_of_steering(host: Host) -> None:
    for steer, wanted_rad in ((0.5, -0.5146), (-0.25, 0.2573)):
        *_, steering_rad = _said(host, CarState(steer=steer))
        near(steering_rad, wanted_rad, 1e-4, unit="rad", what="D")


@on_host("VS17", lasts_s=0.2)
def test_the_signs_of_motion_are_turned_round(host: Host) -> None:
    _require_motion(host, -1.0)


@on_host("VS17H", lasts_s=0.2)
def test_the_signs_of_motion_are_those_of_ros(host: Host) -> None:
    _require_motion(host, 1.0)


def _require_motion(host: Host, sign: float) -> None:
    """Require what is said of a car that turns and slides to the left."""
    _, lateral_m_s, rate_rad_s, _ = _said(host, CarState(lat_speed_m_s=0.05, yaw_rate_rad_s=0.1))
    near(rate_rad_s, sign * 0.1, 1e-6, unit="rad/s", what="C")
    near(lateral_m_s, sign * 0.05, 1e-6, unit="m/s", what="B")


@on_host("VS20", lasts_s=61.0)
def test_statuses_come_in_time(host: Host) -> None:
    host.board.command = COMMAND
    host.board.commands.start(20.0)
    host.board.run(1.0)
    mark, begun_ns = host.statuses_from_now(), host.bench.now_ns
    host.board.run(60.0)
    # A board that is late holds statuses up: each of them may come so much later.
    doubt = host.board.uncertainty_s(begun_ns) * 1200
    near(len(host.board.frames(mark)), 1200, 2, unit="statuses", what="in 60 s", uncertainty=doubt)
    assert not host.board.dropped, "a status is split by something else"


def _statuses_while_silent(host: Host) -> list[float]:
    """Let the board be silent for 2 s; return how far apart statuses come, in seconds."""
    host.say(F1, 0.2)
    mark = host.statuses_from_now()
    host.board.run(2.0)
    frames = host.board.frames(mark)
    if len(frames) < 2:
        text = f"{len(frames)} statuses came while the board was silent for 2 s{host.board.refused()}"
        raise Untimely(text, host.board.evidence(mark), spare_s=0.5)
    return [(later.start_ns - earlier.start_ns) / NS_PER_S for earlier, later in pairwise(frames)]


@on_host("VS21", lasts_s=2.3)
def test_a_quiet_board_holds_the_statuses_up(host: Host) -> None:
    gaps_s = _statuses_while_silent(host)
    near(max(gaps_s), STOP_WITHIN_S, 0.03, unit="s", what="the longest time between two statuses")


@on_host("VS21H", lasts_s=2.3)
def test_a_quiet_board_holds_nothing_up(host: Host) -> None:
    gaps_s = _statuses_while_silent(host)
    near(max(gaps_s), 0.05, 0.002, unit="s", what="the longest time between two statuses")
    near(min(gaps_s), 0.05, 0.002, unit="s", what="the shortest time between two statuses")
