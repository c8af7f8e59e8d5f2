"""Families of messages at other moments: two at once in each order and twice, and each one late."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import replace

from hilbench.check import Violation
from hilbench.suites._vehicle import (
    COMMAND,
    COMMAND_HZ,
    MODE_WITHIN_S,
    STATUS,
    STATUS_HZ,
    Vehicle,
    on_board,
    status_of,
)
from hilbench.suites.vehicle_board._moves import F1, OTHER_WAY, OTHER_WAY_FRAME, quiet, require_emergency
from protocols.autoware import (
    AckermannControlCommand,
    AgentOnline,
    Clock,
    HazardLights,
    HazardLightsCommand,
    Message,
    Time,
    TurnIndicators,
    TurnIndicatorsCommand,
)
from protocols.carla import CommandFrame, Mode, StatusFrame, encode_status

FAST, SLOW = status_of(9.0), status_of(2.0)

STATUSES: Mapping[str, tuple[StatusFrame, StatusFrame | None]] = {
    "one of 9 m/s": (FAST, FAST),
    "one of 2 m/s": (SLOW, SLOW),
    "one with a NaN": (replace(FAST, heading_rate_rad_s=math.nan), None),
}
"""What is said, and what is reported of it."""

COMMANDS: Mapping[str, tuple[AckermannControlCommand, CommandFrame | None]] = {
    "one ahead": (COMMAND, F1),
    "one back": (OTHER_WAY, OTHER_WAY_FRAME),
    "one with a NaN": (replace(OTHER_WAY, speed=math.nan), None),
}
"""What is commanded, and what is handed on."""

BEFORE = replace(COMMAND, speed=3.0)
"""What is commanded until then."""

TAKEN_S = 0.3


def _pairs(kinds: Mapping[str, object]) -> list[tuple[str, tuple[str, str]]]:
    pairs = itertools.product(kinds, kinds)
    return [(f"{one} and {other}" if one != other else f"{one}, twice", (one, other)) for one, other in pairs]


@on_board("VB63", lasts_s=9.0)
def test_two_messages_at_once_in_each_order(vehicle: Vehicle) -> None:
    def later_is_reported(pair: tuple[str, str]) -> None:
        stack_mark = quiet(vehicle)
        mark = vehicle.mark()
        vehicle.simulator.write(b"".join(encode_status(STATUSES[name][0]) for name in pair))
        sound = [status for name in pair if (status := STATUSES[name][1]) is not None]
        if sound:
            vehicle.require_reported(sound[-1], stack_mark)
        vehicle.run(2 / COMMAND_HZ)
        reported = {FAST.lon_speed_m_s, SLOW.lon_speed_m_s} & {*vehicle.speeds(stack_mark)[-1:]}
        if reported != {status.lon_speed_m_s for status in sound[-1:]}:
            raise Violation(f"reported last is {reported or 'none of them'}", vehicle.stack.evidence(stack_mark))
        vehicle.require_modes(vehicle.frames(mark), Mode.AUTOWARE)
        vehicle.simulator.status = STATUS

    def later_is_handed_on(pair: tuple[str, str]) -> None:
        vehicle.stack.command = BEFORE
        vehicle.autoware(command_hz=10.0)
        vehicle.stack.commands.stop()
        mark = vehicle.mark()
        vehicle.stack.write(b"".join(vehicle.stack.wire(COMMANDS[name][0]) for name in pair))
        vehicle.run(TAKEN_S)
        frames = vehicle.frames(mark)
        vehicle.require_modes(frames, Mode.AUTOWARE)
        sound = [frame for name in pair if (frame := COMMANDS[name][1]) is not None]
        moving = [got for got in frames if got.packet is not None and got.packet.speed not in (0.0, BEFORE.speed)]
        if bool(moving) != bool(sound):
            raise Violation(f"{len(moving)} frames of the two were forwarded", vehicle.shown(frames[-6:]))
        if sound:
            vehicle.require_frame(moving[-1], sound[-1], "the last frame of a command")

    vehicle.try_members("pairs of statuses", _pairs(STATUSES), later_is_reported, budget=4)
    vehicle.try_members("pairs of commands", _pairs(COMMANDS), later_is_handed_on, budget=4)


LATE_S = [number * 0.05 for number in range(1, 15)]
"""Within the second in which a status may be missing, with room for a bench that is late."""

LATE_MESSAGES: Mapping[str, Message] = {
    "a command": COMMAND,
    "a command back": OTHER_WAY,
    "the clock": Clock(clock=Time.from_ns(5_000_000_000)),
    "a turn indicator": TurnIndicatorsCommand(command=TurnIndicators.ENABLE_LEFT),
    "hazard lights": HazardLightsCommand(command=HazardLights.ENABLE),
    "an agent's sign": AgentOnline(),
}

LATE_BYTES: Mapping[str, bytes] = {
    **{f"{count} bytes of a status": encode_status(FAST)[:count] for count in range(1, 22)},
    "a status with a NaN": encode_status(STATUSES["one with a NaN"][0]),
    "22 hashes": b"#" * 22,
}

STAYS_S = 0.25
"""Two frames of the emergency, and some."""


@on_board("VB62", lasts_s=10.0)
def test_each_message_is_late(vehicle: Vehicle) -> None:
    def is_taken(late_s: float) -> None:
        stack_mark = quiet(vehicle)
        mark = vehicle.mark()
        vehicle.run(late_s)
        vehicle.say(FAST)
        vehicle.require_reported(FAST, stack_mark)
        vehicle.require_modes(vehicle.frames(mark), Mode.AUTOWARE)
        vehicle.simulator.status = STATUS

    def ends_nothing(late: tuple[Message | None, bytes]) -> None:
        mark = vehicle.mark()
        to_stack, to_simulator = late
        vehicle.stack.write(b"" if to_stack is None else vehicle.stack.wire(to_stack))
        vehicle.simulator.write(to_simulator)
        vehicle.run(STAYS_S)
        require_emergency(vehicle, vehicle.frames(mark))

    times = [(f"one {round(late_s * 1000)} ms late", late_s) for late_s in LATE_S]
    vehicle.try_members("late statuses", times, is_taken, budget=4)
    vehicle.emergency()
    late: list[tuple[str, tuple[Message | None, bytes]]] = [
        *((name, (message, b"")) for name, message in LATE_MESSAGES.items()),
        *((name, (None, data)) for name, data in LATE_BYTES.items()),
    ]
    vehicle.try_members("messages in EMERGENCY", late, ends_nothing, budget=8)
    vehicle.run(0.15)  # what was begun is given up
    mark = vehicle.mark()
    vehicle.simulator.statuses.start(STATUS_HZ)
    vehicle.wait_for(Mode.MANUAL, MODE_WITHIN_S, mark)
