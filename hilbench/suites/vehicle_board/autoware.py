"""AUTOWARE: how commands are handed on, and what is sent where one is missing."""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import pairwise

from hilbench.check import Untimely, at_least, at_most
from hilbench.clock import NS_PER_S
from hilbench.suites._vehicle import (
    COMMAND,
    COMMAND_MISS_S,
    MISSES,
    STATUS_HZ,
    STATUS_MISS_S,
    TICK_S,
    Frame,
    Vehicle,
    on_board,
)
from hilbench.suites.vehicle_board._moves import (
    EXACTLY,
    F1,
    IMPOSSIBLE_M_S,
    OTHER_WAY,
    OTHER_WAY_FRAME,
    PING_S,
    WHICH,
    nine_misses,
    nine_misses_around_a_status,
)
from protocols.autoware import AgentPing
from protocols.carla import CommandFrame, Mode

_MOST = {"steering_tire_angle": 2.5 / 1.2, "steering_tire_rotation_rate": 50.0 / 1.2}
_MOST |= {"speed": 150.0, "acceleration": 100.0, "jerk": 1000.0}
"""What a command can be meant with, rad, rad/s, m/s, m/s^2 and m/s^3; the angle and its rate before the factor."""

INSIDE, OUTSIDE = 0.99, 1.01
"""Shares of a limit that are just within it and just beyond."""


@on_board("VB01", lasts_s=1.0)
def test_a_command_is_handed_on(vehicle: Vehicle) -> None:
    mark = vehicle.autoware()
    vehicle.run(0.5)
    frames = vehicle.frames(mark)
    assert frames, "no frame came"
    for got in frames:
        vehicle.require_frame(got, F1, "the frame of the command")
    vehicle.stack.command = OTHER_WAY
    vehicle.run(0.2)
    turned = vehicle.mark()
    vehicle.run(0.5)
    assert vehicle.mark() > turned, "no frame came"
    for got in vehicle.frames(turned):
        vehicle.require_frame(got, OTHER_WAY_FRAME, "the frame of the command to the other side")
    _require_no_more_pings(vehicle)


def _require_no_more_pings(vehicle: Vehicle) -> None:
    """Require that a board whose ping was answered asks no further."""
    pings = [got for got, _ in vehicle.stack.since(0, AgentPing)]
    late = [got for got in pings if (got.start_ns - pings[0].start_ns) / NS_PER_S > PING_S / 2]
    if late:
        text = f"{len(late)} pings came though the first one was answered and commands came"
        raise Untimely(text, vehicle.stack.evidence(0)[:8], spare_s=PING_S / 2)


@on_board("VB02", lasts_s=4.0)
def test_one_command_for_each_status(vehicle: Vehicle) -> None:
    mark, begun_ns = vehicle.autoware(), vehicle.bench.now_ns
    vehicle.run(3.0)
    frames = vehicle.frames(mark)
    vehicle.require_count(len(frames), 60, 2, what="frames in 3 s", since_ns=begun_ns, rate_hz=STATUS_HZ)
    vehicle.require_modes(frames, Mode.AUTOWARE)


@on_board("VB06", lasts_s=4.0)
def test_any_command_begins_the_count_again(vehicle: Vehicle) -> None:
    vehicle.autoware(command_hz=10.0)
    commands = vehicle.stack.commands
    said = commands.said
    vehicle.bench.run_until(lambda: commands.said > said, 0.2)
    commands.stop()
    for _ in range(2):
        vehicle.run(0.02)  # the frame of the command itself
        nine_misses(vehicle, vehicle.mark(), Mode.AUTOWARE, MISSES - 1, COMMAND_MISS_S)
        mark = vehicle.mark()
        vehicle.stack.send(COMMAND)
    vehicle.run(0.15)
    vehicle.require_modes(vehicle.frames(mark), Mode.AUTOWARE)


@on_board("VB44", lasts_s=4.0)
def test_any_status_begins_the_count_again(vehicle: Vehicle) -> None:
    vehicle.autoware()
    vehicle.simulator.statuses.stop()
    vehicle.run(3 * STATUS_MISS_S)
    nine_misses_around_a_status(vehicle, Mode.AUTOWARE, STATUS_MISS_S)


def _without_commands(vehicle: Vehicle, commanded: CommandFrame, wanted: CommandFrame) -> None:
    """Let commands stop; require the frame of the last one, then nine that are wanted without one, then mode 4."""
    mark = vehicle.autoware(command_hz=10.0)
    commands = vehicle.stack.commands
    said = commands.said
    vehicle.bench.run_until(lambda: commands.said > said, 0.2)
    commands.stop()
    stopped_ns = vehicle.bench.now_ns
    manual = vehicle.wait_for(Mode.MANUAL, 2.0, mark)
    frames = [got for got in vehicle.frames(mark) if stopped_ns < got.start_ns < manual.start_ns]
    vehicle.simulator.require_punctual(stopped_ns, COMMAND_MISS_S / 4, WHICH)
    # The first of them is that of the last command; the wait begins with the status behind it.
    rate_hz = 1 / COMMAND_MISS_S
    what = "frames from the last command to MANUAL"
    vehicle.require_count(len(frames), MISSES, EXACTLY, what=what, since_ns=stopped_ns, rate_hz=rate_hz)
    last, *without = frames
    vehicle.require_frame(last, commanded, "the frame of the last command")
    for got in without:
        vehicle.require_frame(got, wanted, "the frame without a command")
    vehicle.require_steps([*without, manual], COMMAND_MISS_S, "between frames without a command", unprompted=True)
    # Never sooner by the board's own clock; how long it waits for the status before that is a matter of ours, too.
    what = "the first frame without a command came after"
    gap_s, doubt_s = vehicle.bench.span(last.start_ns, without[0].start_ns, unprompted=True)
    at_least(gap_s, COMMAND_MISS_S - TICK_S, unit="s", what=what, uncertainty=doubt_s)
    gap_s, doubt_s = vehicle.bench.span(last.start_ns, without[0].start_ns)
    at_most(gap_s, COMMAND_MISS_S + 1 / STATUS_HZ + TICK_S, unit="s", what=what, uncertainty=doubt_s)


@on_board("VB05", lasts_s=3.0)
def test_a_command_that_moves_is_sent_again(vehicle: Vehicle) -> None:
    _without_commands(vehicle, F1, F1)


@on_board("VB05H", lasts_s=6.0)
def test_without_a_command_the_car_is_stopped(vehicle: Vehicle) -> None:
    for command, commanded in ((COMMAND, F1), (OTHER_WAY, OTHER_WAY_FRAME)):
        vehicle.stack.command = command
        _without_commands(vehicle, commanded, _stop(commanded))


def _stop(commanded: CommandFrame = F1) -> CommandFrame:
    return CommandFrame(steering=commanded.steering, mode=Mode.AUTOWARE)


def _slow_commands(vehicle: Vehicle, between: CommandFrame) -> None:
    """Command at 5 Hz for 3 s; require the frames between the commands."""
    mark, begun_ns = vehicle.autoware(command_hz=5.0), vehicle.bench.now_ns
    vehicle.run(3.0)
    frames = vehicle.frames(mark)
    vehicle.require_modes(frames, Mode.AUTOWARE)
    kinds = [_is(got, F1) for got in frames]
    if between == F1:
        for got in frames:
            vehicle.require_frame(got, F1, "a frame between commands")
    else:
        if any(one == other for one, other in pairwise(kinds)):
            raise Untimely("commands and stops do not alternate", spare_s=2 * COMMAND_MISS_S - 1 / 5.0)
        for got, is_command in zip(frames, kinds, strict=True):
            if not is_command:
                vehicle.require_frame(got, between, "a frame between commands")
    # A command that is late by more has two frames before it that fill up.
    vehicle.simulator.require_punctual(begun_ns, 2 * COMMAND_MISS_S - 1 / 5.0, WHICH)
    vehicle.require_count(len(frames), 30, 2, what="frames in 3 s", since_ns=begun_ns, rate_hz=10.0)


def _is(got: Frame, frame: CommandFrame) -> bool:
    assert got.packet is not None
    return abs(got.packet.speed - frame.speed) < 1e-6


@on_board("VB30", lasts_s=4.0, noisy=True)  # the first command may come after a miss: what nobody filled is sent (VB04)
def test_slow_commands_are_filled_up(vehicle: Vehicle) -> None:
    _slow_commands(vehicle, F1)


@on_board("VB30H", lasts_s=4.0)
def test_between_slow_commands_the_car_is_stopped(vehicle: Vehicle) -> None:
    _slow_commands(vehicle, _stop())


@on_board("VB41", lasts_s=1.5)
def test_a_command_without_meaning_is_handed_on(vehicle: Vehicle) -> None:
    mark = vehicle.autoware()
    vehicle.stack.command = replace(COMMAND, speed=math.nan)
    vehicle.run(0.5)
    speeds = [frame.speed for _, frame in vehicle.simulator.since(mark, CommandFrame)]
    assert any(map(math.isnan, speeds)), "no frame has the NaN of the command"


@on_board("VB41H", lasts_s=9.0)
def test_a_command_without_meaning_is_none(vehicle: Vehicle) -> None:
    for speed in (math.nan, IMPOSSIBLE_M_S):
        vehicle.stack.command = COMMAND
        vehicle.autoware()
        vehicle.stack.command = replace(COMMAND, speed=speed)
        mark = vehicle.mark()
        vehicle.wait_for(Mode.MANUAL, MISSES * COMMAND_MISS_S + 0.3, mark)
        said = [frame for _, frame in vehicle.simulator.since(mark, CommandFrame)]
        speeds = {frame.speed for frame in said if frame.mode != Mode.MANUAL}  # that of MANUAL is the joystick's
        assert speeds <= {COMMAND.speed, 0.0}, f"speeds that were sent: {sorted(speeds)}"
    _require_no_bad_field(vehicle)
    for sign in (1, -1):
        _require_the_most(vehicle, sign)


def _require_no_bad_field(vehicle: Vehicle) -> None:
    """Between sound commands, command what cannot be in each field; require that none of it is sent."""
    vehicle.stack.command = COMMAND
    vehicle.autoware(command_hz=10.0)
    mark = vehicle.mark()
    for name, most in _MOST.items():
        for value in (math.nan, math.inf, OUTSIDE * most, -OUTSIDE * most):
            _between_commands(vehicle)
            vehicle.stack.send(replace(COMMAND, **{name: value}))  # type: ignore[arg-type]
    vehicle.run(0.1)
    for got in vehicle.frames(mark):
        vehicle.require_frame(got, F1 if _is(got, F1) else _stop(), "a frame between commands without meaning")


def _between_commands(vehicle: Vehicle) -> None:
    """Go on to where the status behind the next command has come, and another command is waited for."""
    commands = vehicle.stack.commands
    said = commands.said
    vehicle.bench.run_until(lambda: commands.said > said, 0.2)
    vehicle.run(0.06)


def _require_the_most(vehicle: Vehicle, sign: int) -> None:
    """Between sound commands, command just what can be meant; require that it is sent."""
    figures = {name: sign * INSIDE * most for name, most in _MOST.items()}
    angle, rate, *others = figures.values()
    _between_commands(vehicle)
    mark, sent_ns = vehicle.mark(), vehicle.bench.now_ns
    vehicle.stack.send(replace(COMMAND, **figures))  # type: ignore[arg-type]
    vehicle.run(0.02)
    vehicle.simulator.require_punctual(sent_ns, 0.02, WHICH)
    frames = vehicle.frames(mark)
    assert frames, f"a command of {sign * INSIDE:g} of each limit is not sent"
    speed, acceleration, jerk = others
    wanted = CommandFrame(
        steering=1.2 * angle,
        steering_rate=1.2 * rate,
        speed=speed,
        acceleration=acceleration,
        jerk=jerk,
        mode=Mode.AUTOWARE,
    )
    vehicle.require_frame(frames[0], wanted, "the frame of a command just within the limits")
