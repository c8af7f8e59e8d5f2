"""What breaks or is in the way: the sensor's bus, the link, a wheel, a wall, the battery."""

from __future__ import annotations

import pytest

from hilbench.check import Violation, at_least, at_most, near, within
from hilbench.clock import NS_PER_MS, NS_PER_S
from hilbench.suites._rover_law import Driven, settled_rpm, volts_at
from hilbench.suites._rover_motion import ENABLES, NAMES, Ride, on_bench
from hilbench.suites.rover_motion._judged import (
    LAW_RPM,
    LOOK_S,
    TURNS_RPM,
    TWITCHES_RPM,
    next_imu,
    require_law,
    require_speeds,
    require_status,
    ride,
)
from protocols.pkt import RequestTelemetry
from protocols.pkt.codes import StatusFlag
from worlds.vehicles.rover_4wd import DEFAULTS

__all__ = ["ride"]

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
