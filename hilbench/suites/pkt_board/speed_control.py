"""Speed control, with the wheels in somebody's hand."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from hilbench.check import Inconclusive, near, within
from hilbench.clock import NS_PER_S
from hilbench.suites._rover import Rover, on_rover
from hilbench.suites.pkt_board._frames import SUCCESS, held_throttle
from protocols.pkt import MotionReport, PidGains, SpeedSetpoints


@on_rover("P26", lasts_s=1.2)
def test_speed_controller(rover: Rover) -> None:
    report = held_throttle(rover)
    for name, throttle, setpoint in zip("AB", report.throttles, report.setpoints_rpm, strict=True):
        near(throttle, 0.3008, 0.001, unit="of full", what=f"throttle {name} after 0.25 s")
        near(setpoint, 30.0, 1e-3, unit="rpm", what=f"setpoint {name}")


@on_rover("P63", lasts_s=3.2)
def test_setpoints_and_flags(rover: Rover) -> None:
    rover.hold_wheels()
    rover.send(SpeedSetpoints(a_rpm=30.0, b_rpm=-20.0))
    _require_controlled(rover, 30.0, -20.0)
    steps = ((10.0, 10.0, 1, (10.0, -20.0)), (50.0, 50.0, 0, (10.0, -20.0)), (40.0, 15.0, 2, (10.0, 15.0)))
    for count, (a_rpm, b_rpm, flags, (left_rpm, right_rpm)) in enumerate(steps, start=2):
        rover.send(SpeedSetpoints(a_rpm=a_rpm, b_rpm=b_rpm, flags=flags))
        rover.require(count, 0, 4, SUCCESS)
        _require_controlled(rover, left_rpm, right_rpm)


def _require_controlled(rover: Rover, left_rpm: float, right_rpm: float) -> None:
    """Require setpoints, and what the controllers make of them at wheels that stand because somebody holds them."""
    report = rover.motion()
    rover.require_setpoints(report, left_rpm, right_rpm)
    if rover.held:
        rover.require_throttles(report, left_rpm / 100, right_rpm / 100, 0.05)


@on_rover("P38", lasts_s=1.4)
def test_gains_as_shipped(rover: Rover) -> None:
    rover.write(rover.peer.frame(b"\x01" + bytes(20)))
    rover.send(PidGains(kp=0.0, kd=0.01, ki=0.0))
    for name, throttle in zip("AB", held_throttle(rover).throttles, strict=True):
        near(throttle, 0.3, 0.001, unit="of full", what=f"throttle {name} after 0.25 s")


@on_rover("P38D", lasts_s=1.4)
def test_gains(rover: Rover) -> None:
    rover.send(PidGains(kp=0.005, kd=0.0, ki=0.04))  # what the next one has to change
    rover.send(PidGains(kp=0.02, kd=0.0, ki=0.0))
    for name, throttle in zip("AB", held_throttle(rover).throttles, strict=True):
        near(throttle, 0.6, 0.001, unit="of full", what=f"throttle {name} after 0.25 s")


KP, KI = 0.001, 0.0007
SETPOINTS_RPM = 650.0, 450.0
"""With these no wheel comes as far, so that its throttle never turns round; nor does it come to its end, or so low that
a motor stands still."""

THROTTLE, SHARE = 0.02, 0.2
"""Tolerances: of a throttle that may be made of the speed of a turn of the loop before, and of what a sum gathers."""


@on_rover("P88", lasts_s=4.0)
def test_gains_are_seen_in_the_throttle(rover: Rover) -> None:
    """Nobody holds the wheels: what the rover says of its speeds has to give what it says of its throttles.

    The sum comes first, for whoever keeps it when the gains change.
    """
    rover.send(PidGains(kp=0.0, kd=0.0, ki=KI))
    rover.send(SpeedSetpoints(a_rpm=SETPOINTS_RPM[0], b_rpm=SETPOINTS_RPM[1]))
    for (before_ns, before), (now_ns, now) in pairwise(_reports(rover)):
        span_s = (now_ns - before_ns) / NS_PER_S
        for side, wanted_rpm in enumerate(SETPOINTS_RPM):
            fastest_rpm = max(*before.rpm[side::2], *now.rpm[side::2])
            low, high = KI * span_s * (wanted_rpm - fastest_rpm), KI * span_s * wanted_rpm
            within(
                now.throttles[side] - before.throttles[side],
                (1 - SHARE) * low - THROTTLE,
                (1 + SHARE) * high + THROTTLE,
                unit="of full",
                what=f"throttle {'AB'[side]}, gathered in {span_s:.2f} s",
                uncertainty=KI * wanted_rpm * rover.peer.uncertainty_s(before_ns),
            )
    rover.send(PidGains(kp=KP, kd=0.0, ki=0.0))
    for _, report in _reports(rover):
        for side, wanted_rpm in enumerate(SETPOINTS_RPM):
            off_rpm = [wanted_rpm - rpm for rpm in report.rpm[side::2]]
            low, high = KP * min(off_rpm) - THROTTLE, KP * max(off_rpm) + THROTTLE
            within(
                report.throttles[side],
                low,
                high,
                unit="of full",
                what=f"throttle {'AB'[side]}, {max(off_rpm):.0f} rpm to go",
            )
    rover.drive(0.0, 0.0)


def _reports(rover: Rover) -> list[tuple[int, MotionReport]]:
    """Return what 0x83 says in a second, with times; the first one may have been made before."""
    rover.next(MotionReport, 0.6)
    mark = rover.mark()
    rover.keep_alive(1.1)
    return [(got.start_ns, report) for got, report in rover.peer.since(mark, MotionReport)]


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
