"""Parameters: missing ones, flags, and a throttle beyond one."""

from __future__ import annotations

import math
import struct

from hilbench.check import Inconclusive, Violation, near, within
from hilbench.suites._rover import Rover, on_rover
from hilbench.suites.pkt_board._frames import SUCCESS, require_refused
from protocols.pkt import MotorThrottles, SpeedSetpoints


@on_rover("P22", lasts_s=0.6)
def test_missing_parameters_as_shipped(rover: Rover) -> None:
    rover.write(rover.peer.frame(b"\x03"))
    rover.require(1, 0, 3, SUCCESS)


@on_rover("P22D", lasts_s=1.6)
def test_missing_parameters(rover: Rover) -> None:
    rover.drive(0.5, -0.25)
    rover.write(rover.peer.frame(b"\x03"))
    found = rover.counts
    if (found.accepted, found.rejected, found.opcode) != (2, 0, 3) or found.error == SUCCESS:
        raise Violation(f"the state is {found}, required 2/0/3 and an error", rover.peer.evidence())
    rover.require_throttles(rover.motion(), 0.5, -0.25)


@on_rover("P66", lasts_s=1.6)
def test_missing_parameters_of_the_speed_control(rover: Rover) -> None:
    rover.send(SpeedSetpoints(a_rpm=30.0, b_rpm=-20.0))
    for opcode in (b"\x04", b"\x05"):
        for parameters in (b"", struct.pack("<ff", 1.0, 2.0)):
            require_refused(rover, opcode + parameters)
    rover.require_setpoints(rover.motion(), 30.0, -20.0)


@on_rover("P27", lasts_s=2.6)
def test_flags(rover: Rover) -> None:
    rover.drive(0.5, -0.25)
    rover.send(MotorThrottles(a=0.125, b=0.125, flags=1))
    rover.require(2, 0, 3, SUCCESS)
    rover.require_throttles(rover.motion(), 0.125, -0.25)
    rover.send(MotorThrottles(a=0.75, b=0.75, flags=0))
    rover.require(3, 0, 3, SUCCESS)
    rover.require_throttles(rover.motion(), 0.125, -0.25)
    rover.send(MotorThrottles(a=0.75, b=0.375, flags=2))
    rover.require_throttles(rover.motion(), 0.125, 0.375)


@on_rover("P28", lasts_s=1.0)
def test_throttle_beyond_one_as_shipped(rover: Rover) -> None:
    rover.drive(1.5, 1.5)
    rover.require_throttles(rover.motion(), 1.5, 1.5)
    if not rover.seen:
        return
    for name, duty in zip("AB", rover.duties, strict=True):
        near(duty, 1.0, 0.01, unit="of full", what=f"duty {name}")


@on_rover("P28D", lasts_s=3.0)
def test_throttle_beyond_one(rover: Rover) -> None:
    rover.drive(0.5, 0.5)
    first = rover.motion().throttles
    if first != (0.5, 0.5):
        raise Inconclusive(f"0x83 does not show any throttle: {first} after 0.5")
    for throttle in (1.5, -2.0, math.nan):
        rover.drive(throttle, throttle)
        for name, shown in zip("AB", rover.motion().throttles, strict=True):
            if math.isnan(shown):
                raise Violation(f"0x83 shows no number as throttle {name} after {throttle}", rover.peer.evidence())
            within(shown, -1.0, 1.0, unit="of full", what=f"throttle {name} in 0x83 after {throttle}")
