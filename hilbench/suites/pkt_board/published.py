"""What the published firmware does besides, and what was promised in its place."""

from __future__ import annotations

import struct

from hilbench.check import Inconclusive, at_least, at_most, within
from hilbench.clock import NS_PER_S
from hilbench.judging.recorder import record_measure
from hilbench.suites._rover import Rover, at_power_up, on_rover
from hilbench.suites.pkt_board._frames import SUCCESS, UNKNOWN, held_throttle, led_on_frame
from hilbench.systems.rover.hands import RoverBench
from protocols.pkt import GeneralReport, LedOff, LedOn, MotionReport, PidGains, RequestTelemetry, SpeedSetpoints


@on_rover("P44", lasts_s=0.8)
def test_led_toggles_as_shipped(rover: Rover) -> None:
    rover.dark()
    for lit in (True, False):
        rover.write(UNKNOWN)
        assert rover.lit is lit, "a packet does not toggle the LED"


@on_rover("P44D", lasts_s=2.0)
def test_led_is_its_own(rover: Rover) -> None:
    for command, lit in ((LedOn(), True), (LedOff(), False)):
        rover.send(command)
        for _ in range(3):
            rover.write(UNKNOWN)
            assert rover.lit is lit, "a packet that is no LED command changes the LED"


@on_rover("P45", lasts_s=5.0)
def test_sum_grows_as_shipped(rover: Rover) -> None:
    assert _after_saturation(rover) > 0, "the sum of the speed controller did not grow at its limit"


@on_rover("P45D", lasts_s=5.0)
def test_sum_stands_at_the_limit(rover: Rover) -> None:
    throttle = _after_saturation(rover)
    record_measure("throttle half a second after the turn", throttle, "of full", high=0.0)
    assert throttle < 0, f"the throttle is still {throttle:.3f} half a second after the setpoint has turned"


def _after_saturation(rover: Rover) -> float:
    """Wind the controller up against held wheels, turn the setpoint, and return the throttle half a second later."""
    _set_integral_gain(rover, 1.0)
    rover.hands.hold_wheels(True)
    rover.send(SpeedSetpoints(a_rpm=30.0, b_rpm=30.0))
    rover.keep_alive(3.0)
    _require_reached(rover.motion().throttles[0], 0.99, "the speed controller is not at its limit: throttle")
    rover.send(SpeedSetpoints(a_rpm=-30.0, b_rpm=-30.0))
    rover.peer.run(0.5)
    report = rover.motion()
    _require_reached(-report.setpoints_rpm[0], 29.9, "the setpoint has not turned: less")
    return report.throttles[0]


def _require_reached(found: float, least: float, otherwise: str) -> None:
    """Require that a stimulus has had the effect without which what comes next shows nothing."""
    if not found >= least:
        raise Inconclusive(f"{otherwise} {found:.3f}, required {least:g}")


def _set_integral_gain(rover: Rover, ki: float) -> None:
    """Set kp and kd to 0, whether the gains are read where they stand or four bytes behind."""
    if rover.peer.profile.server.pid_reads_late:
        # What follows the gains in the frame is what is taken for ki: kp, sent kd, sent ki, ki.
        rover.write(rover.peer.frame(b"\x05" + struct.pack("<ffff", 0.0, 0.0, 0.0, ki)))
    else:
        rover.send(PidGains(kp=0.0, kd=0.0, ki=ki))


@on_rover("P46", lasts_s=4.0)
def test_sum_outlives_its_mode_as_shipped(rover: Rover) -> None:
    assert _after_new_mode(rover) > 0.5, "the sum of the speed controller was forgotten with its mode"


@on_rover("P46D", lasts_s=4.0)
def test_sum_begins_with_its_mode(rover: Rover) -> None:
    within(_after_new_mode(rover), 0.0, 0.2, unit="of full", what="throttle a quarter of a second after PID mode began")


def _after_new_mode(rover: Rover) -> float:
    """Gather a sum of 0.6, go to manual mode and back, and return the throttle soon after."""
    _set_integral_gain(rover, 0.01)
    rover.hands.hold_wheels(True)
    rover.send(SpeedSetpoints(a_rpm=30.0, b_rpm=30.0))
    rover.keep_alive(2.0)
    _require_reached(rover.motion().throttles[0], 0.5, "no sum was gathered: throttle")
    rover.drive(0.0, 0.0)
    _require_reached(-abs(rover.motion().throttles[0]), 0.0, "manual mode has not begun: throttle, below zero,")
    report = held_throttle(rover)
    _require_reached(report.setpoints_rpm[0], 29.9, "PID mode has not begun again: setpoint")
    return report.throttles[0]


def _shown_after_stopping(rover: Rover) -> float:
    """Drive, stop the wheels by hand, and return the fastest speed that the next 0x83 half a second later shows."""
    rover.drive(0.3, 0.3)
    rover.keep_alive(2.0)
    if min(rover.hands.wheels_rpm()) < 60.0:
        raise Inconclusive(f"the wheels turn at {min(rover.hands.wheels_rpm()):.0f} rpm only")
    _require_reached(max(rover.next(MotionReport, 0.6).rpm), 50.0, "0x83 shows no wheel that turns: rpm")
    rover.peer.run(0.2)
    rover.hands.hold_wheels(True)
    rover.next(MotionReport, 0.6)
    rover.next(MotionReport, 0.6)
    shown = max(rover.next(MotionReport, 0.6).rpm)
    _require_reached(-max(map(abs, rover.hands.wheels_rpm())), -1.0, "the wheels do not stand: rpm, below zero,")
    return shown


@on_rover("P47", lasts_s=4.0)
def test_a_stopped_wheel_as_shipped(rover: Rover) -> None:
    at_least(_shown_after_stopping(rover), 50.0, unit="rpm", what="the fastest wheel half a second after it stood")


@on_rover("P47D", lasts_s=4.0)
def test_a_stopped_wheel(rover: Rover) -> None:
    at_most(_shown_after_stopping(rover), 15.0, unit="rpm", what="the fastest wheel half a second after it stood")


MANY = 100


@on_rover("P48", lasts_s=1.6)
def test_a_full_line_as_shipped(rover: Rover) -> None:
    _require_fast(rover)
    rover.write(led_on_frame(rover) * MANY)
    rover.peer.run(0.2)
    found = rover.counts_in(rover.next(GeneralReport, 1.2))  # a request could end in a frame that was cut
    assert found.accepted < MANY, f"the state is {found}: nothing was lost"
    _require_reached(found.accepted, 1, "no frame was taken at all: accepted")


@on_rover("P48D", lasts_s=0.6)
def test_a_full_line(rover: Rover) -> None:
    _require_fast(rover)
    rover.write(led_on_frame(rover) * MANY)
    rover.peer.run(0.2)
    rover.require(MANY, 0, 1, SUCCESS)


def _require_fast(rover: Rover) -> None:
    if rover.peer.line_s(3200) > 1.0:
        raise Inconclusive("the line is too slow for more than 3200 bytes/s")


@at_power_up("P49", lasts_s=1.1)
def test_silence_at_power_up_as_shipped(there: RoverBench) -> None:
    there.peer.expect_silence(0.9, why="the sensors are being set up")
    if not there.peer.wait_ready():
        raise Inconclusive("it says nothing later either")


@at_power_up("P49D", lasts_s=0.1)
def test_there_at_power_up(there: RoverBench) -> None:
    peer = there.peer
    for _ in range(10):
        peer.send(RequestTelemetry())
        if peer.bench.run_until(lambda: bool(peer.since(0, GeneralReport)), 0.1):
            break
    at_most(peer.bench.now_ns / NS_PER_S, 0.5, unit="s", what="the first 0x80 came after power-up by")
