"""Frames as on the wire, error codes, and how a case rejects one."""

from __future__ import annotations

from hilbench.check import Violation
from hilbench.suites._rover import Rover
from protocols.pkt import ExecutionReport, LedOn, MotionReport, SpeedSetpoints

LED_ON, LED_ON_TERM = bytes.fromhex("504B54210101F1D10A"), bytes.fromhex("504B542101F1D10A")

LED_OFF = bytes.fromhex("504B54210102C1B20A")

UNKNOWN = bytes.fromhex("504B5421017F6E880A")

SUCCESS, BAD_SYNC, INVALID_LENGTH, BAD_CRC, BAD_TERMINATOR, UNKNOWN_OPCODE = range(6)


def led_on_frame(rover: Rover) -> bytes:
    return rover.peer.frame_of(LedOn())


def require_refused(rover: Rover, payload: bytes) -> None:
    """Require that a command is accepted and not carried out, and that 0x81 says so."""
    before, mark = rover.counts, rover.mark()
    rover.write(rover.peer.frame(payload))
    found, opcode = rover.counts, payload[0]
    counted = ((found.accepted - before.accepted) % 256, found.rejected - before.rejected, found.opcode)
    if counted != (1, 0, opcode) or found.error == SUCCESS:
        raise Violation(f"the state is {found} after {before}, required one more, and an error", rover.peer.evidence())
    rover.require_executions(mark, ExecutionReport(opcode=opcode, error=found.error))


def require_rejected(rover: Rover, stimulus: bytes, error: int) -> None:
    """Require that bytes are rejected, once, and light no LED."""
    rover.dark()
    rover.write(stimulus)
    rover.require(0, 1, None, error)
    rover.require_dark()


def held_throttle(rover: Rover) -> MotionReport:
    """Hold the wheels, command 30 rpm just behind a 0x83, and return the next one, a quarter of a second later."""
    rover.hands.hold_wheels(True)
    rover.next(MotionReport, 0.6)
    rover.send(SpeedSetpoints(a_rpm=30.0, b_rpm=30.0))
    return rover.next(MotionReport, 0.6)
