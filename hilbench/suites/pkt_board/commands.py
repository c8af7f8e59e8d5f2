"""Commands and their counters."""

from __future__ import annotations

from collections.abc import Sequence

from hilbench.check import Untimely
from hilbench.suites._rover import Rover, on_rover
from hilbench.suites.pkt_board._frames import LED_ON, SUCCESS, UNKNOWN, UNKNOWN_OPCODE, led_on_frame, require_refused
from protocols.pkt import (
    Command,
    ExecutionReport,
    GeneralReport,
    LedOff,
    LedOn,
    MotorThrottles,
    PidGains,
    RequestTelemetry,
    SpeedSetpoints,
)


@on_rover("P01", lasts_s=0.6)
def test_request_is_answered(rover: Rover) -> None:
    rover.after_periodic()
    mark = rover.mark()
    rover.write(rover.peer.frame_of(RequestTelemetry()))
    replies = [got for got, _ in rover.peer.since(mark, GeneralReport)]
    if len(replies) != 1:
        # None may be on its way, and of two one may be the periodic one.
        raise Untimely(f"{len(replies)} of 0x80 came, required one", rover.peer.evidence())
    before = rover.before
    fields = [before.accepted, before.rejected, before.last_opcode, before.last_error]
    expected = rover.peer.frame(bytes([0x80, *fields, *([] if before.status is None else [before.status])]))
    assert replies[0].raw == expected, f"the answer is {replies[0].raw.hex(' ')}, required {expected.hex(' ')}"
    rover.require(0, 0, None, None)


@on_rover("P02", lasts_s=0.6)
def test_led_on_as_shipped(rover: Rover) -> None:
    rover.dark()
    mark = rover.mark()
    rover.write(LED_ON)
    rover.require(1, 0, 1, SUCCESS)
    assert rover.lit, "LED_ON does not light the LED"
    rover.require_executions(mark)


@on_rover("P02D", lasts_s=0.6)
def test_led_on_is_reported(rover: Rover) -> None:
    rover.dark()
    mark = rover.mark()
    rover.write(led_on_frame(rover))
    rover.require(1, 0, 1, SUCCESS)
    assert rover.lit, "LED_ON does not light the LED"
    rover.require_executions(mark, ExecutionReport(opcode=1, error=0))


@on_rover("P03", lasts_s=0.6)
def test_each_packet_counts(rover: Rover) -> None:
    for _ in range(2):
        rover.send(LedOff())
    rover.require(2, 0, 2, SUCCESS)


@on_rover("P04", lasts_s=0.6)
def test_unknown_opcode_is_accepted(rover: Rover) -> None:
    rover.write(UNKNOWN)
    rover.require(1, 0, 0x7F, UNKNOWN_OPCODE)


@on_rover("P04D", lasts_s=0.6)
def test_unknown_opcode_is_reported(rover: Rover) -> None:
    mark = rover.mark()
    rover.write(UNKNOWN)
    rover.require_executions(mark, ExecutionReport(opcode=0x7F, error=UNKNOWN_OPCODE))


@on_rover("P64", lasts_s=0.8)
def test_each_command_is_reported(rover: Rover) -> None:
    commands: Sequence[Command] = (
        LedOn(),
        LedOff(),
        MotorThrottles(a=0.0, b=0.0),
        SpeedSetpoints(a_rpm=0.0, b_rpm=0.0),
        PidGains(kp=0.01, kd=0.0001, ki=0.0001),
    )
    for opcode, command in enumerate(commands, start=1):
        mark = rover.mark()
        rover.send(command)
        rover.require_executions(mark, ExecutionReport(opcode=opcode, error=SUCCESS))
    require_refused(rover, b"\x03")
