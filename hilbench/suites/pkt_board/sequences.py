"""Families of commands at other moments: two at once in each order and twice, each one late behind each timer."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

from hilbench.check import Inconclusive, Untimely, Violation
from hilbench.suites._rover import Rover, on_rover
from hilbench.suites.pkt_board._frames import SUCCESS
from hilbench.suites.pkt_board.silence import FRAME_S
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
    encode_command,
)

COMMANDS: Mapping[str, Command] = {
    "REQUEST_TMY": RequestTelemetry(),
    "LED_ON": LedOn(),
    "LED_OFF": LedOff(),
    "0x03 to the left": MotorThrottles(a=0.25, b=-0.5),
    "0x03 to the right": MotorThrottles(a=0.5, b=0.125),
    "0x04 to the left": SpeedSetpoints(a_rpm=30.0, b_rpm=-20.0),
    "0x04 to the right": SpeedSetpoints(a_rpm=10.0, b_rpm=15.0),
    "0x05": PidGains(kp=0.01, kd=0.0001, ki=0.0001),
}
"""None has a P in its parameters, which would begin a frame in what is left of a cut one."""

LATE_S = 1.2
"""Later than a frame and a link are waited for, each 1 s. A choice."""


@on_rover("P81", lasts_s=7.5)
def test_two_commands_at_once_in_each_order(rover: Rover) -> None:
    def are_taken(pair: tuple[Command, Command]) -> None:
        accepted = rover.counts.accepted
        if RequestTelemetry() in pair:
            rover.after_periodic()
        mark = rover.mark()
        rover.write(b"".join(map(rover.peer.frame_of, pair)))
        _require_taken(rover, accepted, mark, pair)

    members = [
        (f"{one} and {other}" if one != other else f"{one} twice", (COMMANDS[one], COMMANDS[other]))
        for one, other in itertools.product(COMMANDS, COMMANDS)
    ]
    rover.try_members("pairs of commands", members, are_taken, budget=16)


def _require_taken(rover: Rover, accepted: int, mark: int, commands: tuple[Command, ...]) -> None:
    """Require that commands were counted, answered and carried out, each in its turn."""
    opcodes = [opcode for command in commands if (opcode := encode_command(command, rover.schema)[0])]
    if len(opcodes) < len(commands) and not rover.peer.since(mark, GeneralReport):
        raise Untimely("REQUEST_TMY was not answered", rover.peer.evidence(mark))
    rover.require_executions(mark, *(ExecutionReport(opcode=opcode, error=SUCCESS) for opcode in opcodes))
    found = (rover.counts.accepted - accepted) % 256
    if found != len(opcodes):
        raise Violation(f"ACCEPTED went up by {found}, required {len(opcodes)}", rover.peer.evidence(mark))
    for command in reversed(commands):
        if isinstance(command, MotorThrottles):
            rover.require_throttles(rover.motion(), command.a, command.b)
        elif isinstance(command, SpeedSetpoints):
            rover.require_setpoints(rover.motion(), command.a_rpm, command.b_rpm)
        else:
            continue
        return


@on_rover("P82", lasts_s=14.0)
def test_each_command_is_late(rover: Rover) -> None:
    def is_taken(command: Command) -> None:
        rover.drive(0.5, -0.25)
        accepted = rover.counts.accepted
        rover.peer.run(LATE_S)
        mark = rover.mark()
        rover.write(rover.peer.frame_of(command))
        _require_taken(rover, accepted, mark, (command,))
        if not isinstance(command, MotorThrottles | SpeedSetpoints):
            rover.require_throttles(rover.motion(), 0.0, 0.0)

    def is_forgotten(command_and_size: tuple[Command, int]) -> None:
        command, size = command_and_size
        frame, accepted = rover.peer.frame_of(command), rover.counts.accepted
        rover.after_periodic()
        begun_ns = rover.peer.bench.now_ns
        rover.write(frame[:size])
        rover.peer.run(LATE_S)
        if rover.peer.uncertainty_s(begun_ns) > LATE_S - FRAME_S:
            raise Inconclusive("the bench was too late to say whether the frame was too late")
        mark = rover.mark()
        rover.write(frame[size:])
        rover.require_executions(mark)
        rover.write(frame)
        _require_taken(rover, accepted, mark, (command,))

    late = [(f"{name} behind a lost link", command) for name, command in COMMANDS.items()]
    cut = [
        (f"{name} cut behind {size} bytes", (command, size))
        for name, command in COMMANDS.items()
        for size in range(1, len(rover.peer.frame_of(command)))
    ]
    rover.try_members("late commands", late, is_taken, budget=4)
    rover.try_members("late ends of frames", cut, is_forgotten, budget=4)
