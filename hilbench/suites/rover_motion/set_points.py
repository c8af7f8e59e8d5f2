"""Set points of the speed control, in the air and on the floor."""

from __future__ import annotations

from collections.abc import Sequence

from hilbench.check import at_least, at_most, near
from hilbench.suites._rover_law import Driven, settled_rpm
from hilbench.suites._rover_motion import Moment, Ride, on_bench
from hilbench.suites.rover_motion._judged import LOOK_S, TURNS_RPM, require_speeds, ride
from protocols.pkt import PidGains

__all__ = ["ride"]

KP, KI = 0.01, 0.0001
"""The gains at power-up (nhorro/ceai2020 rover_firmware/config.h)."""

POWER_UP_RPM, POWER_UP = 7.0, 0.05
"""Tolerance of speed and throttle then: a slot passes every 32 ms, so that the speed control sees steps. Choices."""

GAINS = PidGains(kp=0.003, kd=0.0, ki=0.006)
"""With which these motors settle: a sum that takes the place of the error in half a second. A choice."""

SETTLED_RPM, RIPPLE_RPM = 3.0, 6.0
"""How near a set point the mean is, and how far the speed may stray meanwhile. Choices."""


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
