"""What a vehicle-interface board must do: every case of its catalogue, each in the profiles that hold it.

A case brings the board into a mode, changes one thing, and looks at the frames to the simulator, at the reports to the
driving stack, and at what somebody beside the board sees.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import pytest

from hilbench.check import Violation, at_least, at_most, near
from hilbench.check.provider import CaseBench
from hilbench.clock import NS_PER_S
from hilbench.suites._vehicle import (
    COMMAND,
    COMMAND_MISS_S,
    MISSES,
    MODE_WITHIN_S,
    STATUS,
    STATUS_HZ,
    STATUS_MISS_S,
    TICK_S,
    Frame,
    Vehicle,
    on_board,
    shown,
    vehicle_bench,
)
from protocols.autoware import (
    AckermannControlCommand,
    ControlMode,
    ControlModeReport,
    ControlModeRequest,
    ControlModeResponse,
    HazardLights,
    HazardLightsCommand,
    HazardLightsReport,
    SteeringReport,
    Time,
    TurnIndicators,
    TurnIndicatorsCommand,
    TurnIndicatorsReport,
    VelocityReport,
)
from protocols.carla import (
    COMMAND_BYTES,
    FULL_SCALE,
    STATUS_BYTES,
    VECTORS,
    X_AXIS,
    Y_AXIS,
    Axis,
    CommandFrame,
    Mode,
    StatusFrame,
    decode_command,
    decode_status,
    encode_status,
)

F1 = decode_command(VECTORS["F1"].data)
F3 = decode_command(VECTORS["F3"].data)
F6 = decode_status(VECTORS["F6"].data)

OTHER_WAY = AckermannControlCommand(
    steering_tire_angle=-0.4, steering_tire_rotation_rate=0.25, speed=-2.0, acceleration=-3.0, jerk=-0.5
)
"""To the right, in reverse and braking: each sign that F1 does not have."""
OTHER_WAY_FRAME = CommandFrame(
    steering=-0.48, steering_rate=0.3, speed=-2.0, acceleration=-3.0, jerk=-0.5, mode=Mode.AUTOWARE
)

MANUAL_S, MANUAL_MISS_S = 0.060, 0.160
AGENT_WAIT_S = 20.0
BOOT_S = 0.05
"""How long the board may take from power-on to its first instruction of the task. A choice."""
LATE_S = 25.0
REPORT_WITHIN_S = 0.003
"""How long the last byte of a status and the first of a report may lie apart, their own time on the line with it."""
MODE_REPORT_S = 0.1
"""How often the mode is reported. A choice: the original's task has no pace of its own."""
EXACTLY = 0.5
"""Tolerance of a whole number that has to be right."""
IMPOSSIBLE_M_S = 1e30
STATUS_FIELDS = ("lon_speed_m_s", "lat_speed_m_s", "heading_rate_rad_s", "steering_rad")


@pytest.fixture
def vehicle(bench: CaseBench) -> Vehicle:
    """The board under test, as the case finds it: power just on, or settled."""
    return Vehicle(vehicle_bench(bench))


# --- AUTOWARE


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
        _nine_misses(vehicle, vehicle.mark(), Mode.AUTOWARE, MISSES - 1, COMMAND_MISS_S)
        mark = vehicle.mark()
        vehicle.stack.send(COMMAND)
    vehicle.run(0.15)
    vehicle.require_modes(vehicle.frames(mark), Mode.AUTOWARE)


def _nine_misses(vehicle: Vehicle, mark: int, mode: Mode, count: int, step_s: float) -> None:
    """Wait for the frames since a mark that nine misses make; require that they have a mode and come at a steady pace.

    Raises:
        Violation: they do not.
    """
    found = vehicle.bench.run_until(lambda: len(vehicle.frames(mark)) >= count, (count + 1) * step_s + 0.2)
    frames = vehicle.frames(mark)
    if not found:
        raise Violation(f"{len(frames)} frames came in {count} times {step_s:g} s", shown(frames))
    vehicle.require_modes(frames, mode)
    vehicle.require_steps(frames, step_s, "between frames while nothing is said")


@on_board("VB44", lasts_s=4.0)
def test_any_status_begins_the_count_again(vehicle: Vehicle) -> None:
    vehicle.autoware()
    vehicle.simulator.statuses.stop()
    vehicle.run(3 * STATUS_MISS_S)
    _nine_misses_around_a_status(vehicle, Mode.AUTOWARE, STATUS_MISS_S)


@on_board("VB45", lasts_s=6.0)
def test_any_status_begins_the_count_again_in_manual(vehicle: Vehicle) -> None:
    vehicle.manual()
    vehicle.simulator.statuses.stop()
    vehicle.run(3 * MANUAL_MISS_S)
    _nine_misses_around_a_status(vehicle, Mode.MANUAL, MANUAL_MISS_S)


def _nine_misses_around_a_status(vehicle: Vehicle, mode: Mode, step_s: float) -> None:
    """While statuses are missing, say one behind a frame, and twice more behind nine misses; require one mode."""
    mark = vehicle.mark()
    vehicle.bench.run_until(lambda: vehicle.mark() > mark, 2 * step_s)
    for _ in range(2):
        mark = vehicle.mark()
        vehicle.say(STATUS)
        _nine_misses(vehicle, mark, mode, MISSES, step_s)
    mark = vehicle.mark()
    vehicle.say(STATUS, 2 * step_s)
    vehicle.require_modes(vehicle.frames(mark), mode)


def _without_commands(vehicle: Vehicle) -> tuple[list[Frame], Frame]:
    """Let commands stop; return the nine frames sent without one, and the first of mode 4."""
    mark = vehicle.autoware(command_hz=10.0)
    commands = vehicle.stack.commands
    said = commands.said
    vehicle.bench.run_until(lambda: commands.said > said, 0.2)
    commands.stop()
    stopped_ns = vehicle.bench.now_ns
    manual = vehicle.wait_for(Mode.MANUAL, 2.0, mark)
    frames = [got for got in vehicle.frames(mark) if stopped_ns < got.start_ns < manual.start_ns]
    # The first of them is that of the last command; the wait begins with the status behind it.
    rate_hz = 1 / COMMAND_MISS_S
    what = "frames from the last command to MANUAL"
    vehicle.require_count(len(frames), MISSES, EXACTLY, what=what, since_ns=stopped_ns, rate_hz=rate_hz)
    last, *without = frames
    vehicle.require_frame(last, F1, "the frame of the last command")
    first_s = (without[0].start_ns - last.start_ns) / NS_PER_S
    at_least(first_s, COMMAND_MISS_S - TICK_S, unit="s", what="the first frame without a command came after")
    at_most(
        first_s, COMMAND_MISS_S + 1 / STATUS_HZ + TICK_S, unit="s", what="the first frame without a command came after"
    )
    vehicle.require_steps([*without, manual], COMMAND_MISS_S, "between frames without a command")
    return without, manual


@on_board("VB05", lasts_s=3.0)
def test_a_command_that_moves_is_sent_again(vehicle: Vehicle) -> None:
    without, _ = _without_commands(vehicle)
    for got in without:
        vehicle.require_frame(got, F1, "the frame without a command")


@on_board("VB05H", lasts_s=3.0)
def test_without_a_command_the_car_is_stopped(vehicle: Vehicle) -> None:
    without, _ = _without_commands(vehicle)
    for got in without:
        vehicle.require_frame(got, _stop(), "the frame without a command")


def _stop() -> CommandFrame:
    return CommandFrame(steering=F1.steering, mode=Mode.AUTOWARE)


def _slow_commands(vehicle: Vehicle, between: CommandFrame) -> None:
    """Command at 5 Hz for 3 s; require the frames between the commands."""
    mark, begun_ns = vehicle.autoware(command_hz=5.0), vehicle.bench.now_ns
    vehicle.run(3.0)
    frames = vehicle.frames(mark)
    vehicle.require_modes(frames, Mode.AUTOWARE)
    vehicle.require_count(len(frames), 30, 2, what="frames in 3 s", since_ns=begun_ns, rate_hz=10.0)
    kinds = [_is(got, F1) for got in frames]
    if between == F1:
        for got in frames:
            vehicle.require_frame(got, F1, "a frame between commands")
    else:
        assert all(one != other for one, other in pairwise(kinds)), "commands and stops do not alternate"
        for got, is_command in zip(frames, kinds, strict=True):
            if not is_command:
                vehicle.require_frame(got, between, "a frame between commands")


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
        speeds = {frame.speed for _, frame in vehicle.simulator.since(mark, CommandFrame)}
        assert speeds <= {COMMAND.speed, 0.0}, f"speeds that were sent: {sorted(speeds)}"
    _require_no_bad_field(vehicle)


def _require_no_bad_field(vehicle: Vehicle) -> None:
    """Between sound commands, command what cannot be in each field; require that none of it is sent."""
    vehicle.stack.command = COMMAND
    vehicle.autoware(command_hz=10.0)
    mark, commands = vehicle.mark(), vehicle.stack.commands
    for name in ("steering_tire_angle", "steering_tire_rotation_rate", "speed", "acceleration", "jerk"):
        for value in (math.nan, math.inf, IMPOSSIBLE_M_S, -IMPOSSIBLE_M_S):
            said = commands.said
            vehicle.bench.run_until(lambda said=said: commands.said > said, 0.2)  # type: ignore[misc]
            vehicle.run(0.06)  # the status behind the command has come: the next one is waited for
            vehicle.stack.send(replace(COMMAND, **{name: value}))  # type: ignore[arg-type]
    vehicle.run(0.1)
    for got in vehicle.frames(mark):
        vehicle.require_frame(got, F1 if _is(got, F1) else _stop(), "a frame between commands without meaning")


# --- the start


@on_board("VB03", lasts_s=21.0)
def test_without_an_agent_manual(vehicle: Vehicle) -> None:
    vehicle.stack.online = False
    vehicle.feed(command_hz=None)
    first = vehicle.wait_for(Mode.MANUAL, AGENT_WAIT_S + 1.0, 0)
    bursts = vehicle.simulator.bursts
    if bursts[0].start_ns < first.start_ns:
        raise Violation(f"{len(bursts[0].data)} bytes came before the first frame of mode 4", shown([first]))
    near(vehicle.since_s(0, first), AGENT_WAIT_S, TICK_S + BOOT_S, unit="s", what="the first frame came after")


def _nothing_commanded(vehicle: Vehicle) -> Frame:
    """Have the agent there and command nothing; return the first frame of mode 4, 1.1 s after the agent."""
    vehicle.feed(command_hz=None)
    manual = vehicle.wait_for(Mode.MANUAL, 2.0, 0)
    expected_s = MISSES * COMMAND_MISS_S
    near(vehicle.since_s(0, manual), expected_s, TICK_S + BOOT_S, unit="s", what="the first of mode 4 came after")
    return manual


@on_board("VB04", lasts_s=1.5, noisy=True)
def test_frames_that_nobody_filled(vehicle: Vehicle) -> None:
    manual = _nothing_commanded(vehicle)
    before = [burst for burst in vehicle.simulator.bursts if burst.start_ns < manual.start_ns]
    if [len(burst.data) for burst in before] != [COMMAND_BYTES] * (MISSES - 1):
        sizes = ", ".join(str(len(burst.data)) for burst in before) or "none"
        raise Violation(f"bytes before mode 4: {sizes}; required nine times {COMMAND_BYTES}")
    starts_ns = [burst.start_ns for burst in before]
    for earlier, later in pairwise([*starts_ns, manual.start_ns]):
        near((later - earlier) / NS_PER_S, COMMAND_MISS_S, TICK_S, unit="s", what="between them")


@on_board("VB04H", lasts_s=1.5)
def test_nothing_before_there_is_something_to_say(vehicle: Vehicle) -> None:
    manual = _nothing_commanded(vehicle)
    first = vehicle.simulator.bursts[0]
    if first.start_ns < manual.start_ns:
        raise Violation(f"{len(first.data)} bytes came {first.start_ns / NS_PER_S:.3f} s after power-on")


@on_board("VB42", lasts_s=28.0)
def test_a_late_agent_is_not_heard(vehicle: Vehicle) -> None:
    mark = _late_agent(vehicle)
    vehicle.stack.send(ControlModeRequest(sequence=1, mode=ControlMode.AUTONOMOUS))
    vehicle.run(2.0)
    assert not vehicle.reports(0, ControlModeReport), "the mode is reported"
    assert not vehicle.reports(0, ControlModeResponse), "the request is answered"
    assert Mode.AUTOWARE not in vehicle.simulator.modes(mark), "the request is obeyed"


@on_board("VB42H", lasts_s=28.0)
def test_an_agent_may_come_late(vehicle: Vehicle) -> None:
    mark = _late_agent(vehicle)
    assert vehicle.reports(0, ControlModeReport), "the mode is not reported"
    answer = vehicle.stack.request(ControlMode.AUTONOMOUS)
    assert answer.success, "the request is refused"
    vehicle.wait_for(Mode.AUTOWARE, MODE_WITHIN_S, mark)


def _late_agent(vehicle: Vehicle) -> int:
    """Have the agent come after 25 s, with commands; return a mark in the frames from then on."""
    vehicle.stack.online = False
    vehicle.feed(command_hz=None)
    vehicle.run(LATE_S)
    mark = vehicle.mark()
    vehicle.stack.go_online()
    vehicle.feed()
    vehicle.run(0.3)
    return mark


# --- EMERGENCY


@on_board("VB07", lasts_s=3.5)
def test_ten_statuses_missed_are_an_emergency(vehicle: Vehicle) -> None:
    vehicle.autoware()
    statuses = vehicle.simulator.statuses
    said = statuses.said
    vehicle.bench.run_until(lambda: statuses.said > said, 0.2)
    statuses.stop()
    mark, stopped_ns = vehicle.mark(), vehicle.bench.now_ns
    first = vehicle.wait_for(Mode.EMERGENCY, 2.0, mark)
    vehicle.run(0.55)
    frames = vehicle.frames(mark)
    moving = [got for got in frames if stopped_ns < got.start_ns < first.start_ns]
    rate_hz = 1 / STATUS_MISS_S
    vehicle.require_count(
        len(moving), MISSES, EXACTLY, what="more frames of mode 1", since_ns=stopped_ns, rate_hz=rate_hz
    )
    vehicle.require_modes(moving, Mode.AUTOWARE)
    vehicle.require_steps([*moving, first], STATUS_MISS_S, "between frames without a status")
    after = [got for got in frames if got.start_ns >= first.start_ns]
    vehicle.require_steps(after, STATUS_MISS_S, "between frames of the emergency")
    _require_emergency(vehicle, after)


def _require_emergency(vehicle: Vehicle, frames: Sequence[Frame]) -> None:
    """Require that frames are F3, in every field."""
    assert frames, "no frame came"
    for got in frames:
        vehicle.require_frame(got, F3, "the frame of the emergency")


def _status_returns(vehicle: Vehicle) -> int:
    """Have statuses come back in EMERGENCY; return a mark in the frames from then on."""
    vehicle.emergency()
    vehicle.run(0.15)
    mark = vehicle.mark()
    vehicle.simulator.statuses.start(STATUS_HZ)
    vehicle.wait_for(Mode.MANUAL, MODE_WITHIN_S, mark)
    return mark


@on_board("VB08", lasts_s=3.0)
def test_a_status_ends_the_emergency_in_manual(vehicle: Vehicle) -> None:
    vehicle.emergency()
    vehicle.run(0.15)
    mark, told = vehicle.mark(), vehicle.stack.mark()
    vehicle.say(STATUS, 0.05)
    frames = vehicle.frames(mark)
    modes = [got.packet.mode for got in frames if got.packet is not None]
    if modes[:1] != [Mode.MANUAL] or Mode.AUTOWARE in modes:
        raise Violation(f"the modes behind the status are {modes}, required MANUAL next", shown(frames))
    vehicle.simulator.statuses.start(STATUS_HZ)
    vehicle.run(0.2)
    assert vehicle.modes_told(told)[-1:] == [Mode.MANUAL], "the control-mode report does not say 4"
    assert vehicle.light == "green", f"lit is {vehicle.light}, required green"


@on_board("VB09", lasts_s=4.0)
def test_from_there_a_press_leads_back(vehicle: Vehicle) -> None:
    _status_returns(vehicle)
    vehicle.run(0.3)
    mark = vehicle.mark()
    vehicle.hands.press()
    vehicle.wait_for(Mode.AUTOWARE, MODE_WITHIN_S, mark)


@on_board("VB10", lasts_s=4.5)
def test_a_press_in_emergency_does_nothing(vehicle: Vehicle) -> None:
    vehicle.emergency()
    mark = vehicle.mark()
    vehicle.hands.press()
    vehicle.run(0.5)
    _require_emergency(vehicle, vehicle.frames(mark))
    mark = vehicle.mark()
    vehicle.simulator.statuses.start(STATUS_HZ)
    vehicle.wait_for(Mode.MANUAL, MODE_WITHIN_S, mark)
    vehicle.run(1.0)
    assert Mode.AUTOWARE not in vehicle.simulator.modes(mark), "the press was remembered"


@on_board("VB11", lasts_s=4.0)
def test_autoware_can_be_ordered_in_emergency(vehicle: Vehicle) -> None:
    vehicle.emergency()
    mark = vehicle.mark()
    assert vehicle.stack.request(ControlMode.AUTONOMOUS).success, "the request is refused"
    begun = vehicle.wait_for(Mode.AUTOWARE, MODE_WITHIN_S, mark)
    ended = vehicle.wait_for(Mode.EMERGENCY, 2.0, _behind(vehicle, begun))
    at_least((ended.start_ns - begun.start_ns) / NS_PER_S, 1.0 - TICK_S, unit="s", what="frames of mode 1 for")


def _behind(vehicle: Vehicle, frame: Frame) -> int:
    """Return a mark behind a frame."""
    return vehicle.simulator.received.index(frame) + 1


@on_board("VB11H", lasts_s=3.5)
def test_nobody_orders_anything_in_emergency(vehicle: Vehicle) -> None:
    vehicle.emergency()
    mark = vehicle.mark()
    for mode in (ControlMode.AUTONOMOUS, ControlMode.MANUAL):
        assert not vehicle.stack.request(mode).success, f"the request for {mode.name} is granted"
    vehicle.run(0.6)
    _require_emergency(vehicle, vehicle.frames(mark))


@on_board("VB33", lasts_s=4.5)
def test_without_commands_nobody_watches_the_simulator(vehicle: Vehicle) -> None:
    emergency_s, modes = _all_stops(vehicle)
    assert Mode.MANUAL in modes, "MANUAL does not come first"
    near(emergency_s, 2.7, 0.2, unit="s", what="the emergency came after")


@on_board("VB33H", lasts_s=4.5)
def test_the_simulator_is_watched_without_commands(vehicle: Vehicle) -> None:
    emergency_s, _ = _all_stops(vehicle)
    _require_emergency(vehicle, vehicle.frames()[-1:])
    at_most(emergency_s, 1.3, unit="s", what="the emergency came after")


def _all_stops(vehicle: Vehicle) -> tuple[float, Sequence[int]]:
    """Let commands and statuses stop at once; return when the emergency comes, and the modes before it."""
    mark = vehicle.autoware()
    vehicle.feed(status_hz=None, command_hz=None)
    stopped_ns = vehicle.bench.now_ns
    first = vehicle.wait_for(Mode.EMERGENCY, 4.0, mark)
    return vehicle.since_s(stopped_ns, first), vehicle.simulator.modes(mark)


def _told_in_emergency(vehicle: Vehicle) -> set[int]:
    vehicle.emergency()
    mark = vehicle.stack.mark()
    vehicle.run(0.5)
    return {*vehicle.modes_told(mark)}


@on_board("VB36", lasts_s=3.0)
def test_emergency_is_kept_from_the_stack(vehicle: Vehicle) -> None:
    told = _told_in_emergency(vehicle)
    assert told == {Mode.AUTOWARE}, f"the modes told in EMERGENCY are {sorted(told)}"


@on_board("VB36H", lasts_s=3.0)
def test_emergency_is_reported(vehicle: Vehicle) -> None:
    told = _told_in_emergency(vehicle)
    assert told == {ControlMode.NOT_READY}, f"the modes told in EMERGENCY are {sorted(told)}"


@on_board("VB37", lasts_s=3.0)
def test_emergency_is_reported_as_manual(vehicle: Vehicle) -> None:
    told = _told_in_emergency(vehicle)
    assert told == {Mode.MANUAL}, f"the modes told in EMERGENCY are {sorted(told)}"


# --- requests and presses


@on_board("VB12", lasts_s=4.0)
def test_other_modes_are_refused(vehicle: Vehicle) -> None:
    mark = vehicle.autoware()
    _ask_for_others(vehicle)
    assert vehicle.stack.request(ControlMode.AUTONOMOUS).success, "AUTOWARE is refused in AUTOWARE"
    vehicle.run(0.5)
    vehicle.require_modes(vehicle.frames(mark), Mode.AUTOWARE)
    mark = vehicle.manual()
    _ask_for_others(vehicle)
    assert vehicle.stack.request(ControlMode.MANUAL).success, "MANUAL is refused in MANUAL"
    vehicle.run(0.5)
    assert Mode.AUTOWARE not in vehicle.simulator.modes(mark), "one of these requests is obeyed"


def _ask_for_others(vehicle: Vehicle) -> None:
    """Ask for each mode that is none of the board's; require that it is refused."""
    mark = vehicle.stack.mark()
    others = (0, 2, 3, 5, 6, 255)
    for mode in others:
        assert not vehicle.stack.request(mode).success, f"mode {mode} is granted"
    vehicle.run(0.2)
    answers = vehicle.reports(mark, ControlModeResponse)
    assert len(answers) == len(others), f"{len(others)} requests are answered {len(answers)} times"


@on_board("VB48", lasts_s=6.5)
def test_the_mode_is_reported(vehicle: Vehicle) -> None:
    vehicle.autoware()
    _require_mode_told(vehicle, ControlMode.AUTONOMOUS)
    vehicle.manual()
    _require_mode_told(vehicle, ControlMode.MANUAL)


def _require_mode_told(vehicle: Vehicle, mode: ControlMode) -> None:
    """Require that a mode and no other is reported, at the usual rate."""
    mark, begun_ns = vehicle.stack.mark(), vehicle.bench.now_ns
    vehicle.run(2.0)
    told = vehicle.modes_told(mark)
    if {*told} != {mode}:
        raise Violation(f"the modes told are {sorted({*told})}, required {mode.value}", vehicle.stack.evidence(mark))
    what, rate_hz = f"reports of mode {mode.value} in 2 s", 1 / MODE_REPORT_S
    vehicle.require_count(len(told), round(2.0 * rate_hz), 2, what=what, since_ns=begun_ns, rate_hz=rate_hz)


@on_board("VB49", lasts_s=2.5)
def test_reports_are_stamped(vehicle: Vehicle) -> None:
    vehicle.autoware()
    for time_ns in (12_345_678_901, 13_000_000_000):
        vehicle.stack.set_clock(time_ns)
        vehicle.run(0.2)
        mark = vehicle.stack.mark()
        vehicle.run(0.3)
        stamps = {
            "mode": [report.stamp for report in vehicle.reports(mark, ControlModeReport)],
            "velocity": [report.stamp for report in vehicle.reports(mark, VelocityReport)],
            "steering": [report.stamp for report in vehicle.reports(mark, SteeringReport)],
        }
        for what, found in stamps.items():
            if {*found} != {Time.from_ns(time_ns)}:
                text = f"the reports of {what} are stamped {found[:3]}, required {Time.from_ns(time_ns)}"
                raise Violation(text, vehicle.stack.evidence(mark))


@on_board("VB13", lasts_s=7.0)
def test_two_presses_within_a_second_are_one(vehicle: Vehicle) -> None:
    vehicle.autoware()
    vehicle.run(1.2)
    for pause_s in (0.5, 1.0):
        vehicle.hands.press()
        vehicle.run(pause_s)
    frames = vehicle.frames()
    assert vehicle.simulator.modes()[-1] == Mode.MANUAL, "the second press changed the mode as well"
    changes = sum(one != other for one, other in pairwise(vehicle.simulator.modes()))
    if changes != 1:
        raise Violation(f"the mode changed {changes} times, required once", shown(frames[-6:]))
    vehicle.run(0.2)
    for pause_s, mode in ((1.1, Mode.AUTOWARE), (0.94, Mode.MANUAL), (0.6, Mode.MANUAL)):
        vehicle.hands.press()
        vehicle.run(pause_s)
        found = vehicle.simulator.modes()[-1]
        if found != mode:
            raise Violation(f"{pause_s:g} s behind a press the mode is {found}, required {mode.value}")


@on_board("VB14", lasts_s=2.0)
def test_the_first_second_is_blind(vehicle: Vehicle) -> None:
    mark = vehicle.autoware()
    vehicle.run(0.9 - vehicle.bench.now_s)
    vehicle.hands.press()
    vehicle.run(0.7)
    vehicle.require_modes(vehicle.frames(mark), Mode.AUTOWARE)


@on_board("VB40", lasts_s=2.0)
def test_of_two_requests_autoware_is_taken(vehicle: Vehicle) -> None:
    mark = vehicle.autoware()
    _ask_both(vehicle, ControlMode.AUTONOMOUS, ControlMode.MANUAL)
    vehicle.require_modes(vehicle.frames(mark), Mode.AUTOWARE)


@on_board("VB40H", lasts_s=3.0)
def test_of_two_requests_manual_is_taken(vehicle: Vehicle) -> None:
    for one, other in (
        (ControlMode.AUTONOMOUS, ControlMode.MANUAL),
        (ControlMode.MANUAL, ControlMode.AUTONOMOUS),
    ):
        vehicle.autoware()
        _ask_both(vehicle, one, other)
        last = vehicle.simulator.modes()[-1]
        assert last == Mode.MANUAL, f"{one.name} and {other.name} at once lead to mode {last}"


def _ask_both(vehicle: Vehicle, *modes: ControlMode) -> None:
    """Ask for both modes within a millisecond, just after a frame: the control task waits then."""
    mark = vehicle.mark()
    vehicle.bench.run_until(lambda: vehicle.mark() > mark, 0.2)
    for sequence, mode in enumerate(modes):
        vehicle.stack.send(ControlModeRequest(sequence=100 + sequence, mode=mode))
    vehicle.run(0.5)


@on_board("VB31", lasts_s=24.0)
def test_autoware_without_a_stack(vehicle: Vehicle) -> None:
    mark = _pressed_without_agent(vehicle)
    amber = vehicle.bench.run_until(lambda: vehicle.light == "amber", MODE_WITHIN_S)
    assert amber, f"lit is {vehicle.light}, required amber"
    vehicle.hands.set_joystick(65_535, 65_535)
    vehicle.bench.run_until(lambda: vehicle.light == "green", 2.0)
    vehicle.run(0.05)
    frames = [got for got in vehicle.frames(mark) if got.packet is not None]
    still = [got for got in frames if got.packet is not None and got.packet.speed == 0.0]
    at_least(len(still), MISSES - 1, unit="frames", what="of the joystick as it was")
    vehicle.require_steps(still[-(MISSES - 1) :], COMMAND_MISS_S, "between frames without a command")


@on_board("VB31H", lasts_s=24.0)
def test_no_autoware_without_a_stack(vehicle: Vehicle) -> None:
    mark = _pressed_without_agent(vehicle)
    vehicle.run(1.5)
    assert vehicle.light == "green", f"lit is {vehicle.light}, required green"
    vehicle.require_steps(vehicle.frames(mark), MANUAL_S, "between frames of the joystick")


def _pressed_without_agent(vehicle: Vehicle) -> int:
    """Without an agent, in MANUAL, press the joystick; return a mark from then on."""
    vehicle.stack.online = False
    vehicle.feed(command_hz=None)
    vehicle.wait_for(Mode.MANUAL, AGENT_WAIT_S + 1.0, 0)
    vehicle.run(0.5)
    mark = vehicle.mark()
    vehicle.hands.press()
    return mark


def _first_behind_amber(vehicle: Vehicle) -> Frame:
    """From EMERGENCY by a status and a press to AUTOWARE; return the first frame behind the amber light."""
    vehicle.hands.set_joystick(65_535, 65_535)
    _status_returns(vehicle)
    vehicle.run(0.3)
    vehicle.hands.press()
    amber = vehicle.bench.run_until(lambda: vehicle.light == "amber", MODE_WITHIN_S)
    assert amber, f"lit is {vehicle.light}, required amber"
    now_ns = vehicle.bench.now_ns
    found = vehicle.bench.run_until(lambda: vehicle.frames()[-1].start_ns > now_ns, MODE_WITHIN_S)
    assert found, "no frame comes behind the amber light"
    return next(got for got in vehicle.frames() if got.start_ns > now_ns)


@on_board("VB38", lasts_s=4.0)
def test_the_joystick_s_values_as_a_command(vehicle: Vehicle) -> None:
    first = _first_behind_amber(vehicle)
    vehicle.require_frame(first, CommandFrame(steering=-1.0, speed=1.0, mode=Mode.MANUAL), "the first in AUTOWARE")


@on_board("VB38H", lasts_s=4.0)
def test_autoware_begins_with_a_command(vehicle: Vehicle) -> None:
    vehicle.require_frame(_first_behind_amber(vehicle), F1, "the first in AUTOWARE")


# --- MANUAL


def _joystick(vehicle: Vehicle, x_count: int, y_count: int) -> Frame:
    """In MANUAL, move the joystick; return the last of the frames that follow."""
    vehicle.manual()
    vehicle.hands.set_joystick(x_count, y_count)
    vehicle.run(0.2)
    mark = vehicle.mark()
    vehicle.run(0.4)
    frames = [got for got in vehicle.frames(mark) if got.packet is not None and got.packet.mode == Mode.MANUAL]
    assert frames, "no frame of mode 4 came"
    return frames[-1]


def _manual(steer: float, throttle: float, brake: float) -> CommandFrame:
    return CommandFrame(steering=steer, speed=throttle, acceleration=brake, mode=Mode.MANUAL)


@on_board("VB15", lasts_s=1.5)
def test_the_joystick_at_rest(vehicle: Vehicle) -> None:
    got = _joystick(vehicle, 33_970, 33_580)
    vehicle.require_frame(got, _manual(0.0, 0.0, 0.0), "the joystick at rest")
    if got.raw[2:6] != bytes.fromhex("00000080"):
        raise Violation(f"S is {got.raw[2:6].hex(' ')}, required 00 00 00 80", shown([got]))


@on_board("VB16", lasts_s=2.5)
def test_the_dead_band_has_its_edges(vehicle: Vehicle) -> None:
    for counts in ((34_470, 34_080), (33_470, 33_080)):
        vehicle.require_frame(_joystick(vehicle, *counts), _manual(0.0, 0.0, 0.0), f"the joystick at {counts}")


@on_board("VB17", lasts_s=1.5)
def test_the_joystick_at_its_upper_ends(vehicle: Vehicle) -> None:
    vehicle.require_frame(_joystick(vehicle, 65_535, 65_535), _manual(-1.0, 1.0, 0.0), "the joystick at its ends")


@on_board("VB18", lasts_s=1.5)
def test_the_joystick_at_its_lower_ends(vehicle: Vehicle) -> None:
    vehicle.require_frame(_joystick(vehicle, 1057, 1062), _manual(1.0, 0.0, 1.0), "the joystick at its ends")


@on_board("VB46", lasts_s=7.0)
def test_the_joystick_between_its_ends(vehicle: Vehicle) -> None:
    for part in (0.25, 0.5, 0.75):
        for sign in (1, -1):
            counts = (_reading(X_AXIS, sign * part), _reading(Y_AXIS, sign * part))
            _require_stick(vehicle, *counts)
    for sign in (1, -1):
        beyond = sign * (X_AXIS.dead_band + 1)
        _require_stick(vehicle, X_AXIS.zero + beyond, Y_AXIS.zero + beyond)


def _reading(axis: Axis, position: float) -> int:
    """Return the reading next to a position, -1 to 1."""
    end, sign = (axis.greatest, 1) if position > 0 else (axis.least, -1)
    edge = axis.zero + sign * axis.dead_band
    return round(edge + abs(position) * (end - edge))


def _require_stick(vehicle: Vehicle, x_count: int, y_count: int) -> None:
    """Require what the calibration makes of two readings."""
    got = _joystick(vehicle, x_count, y_count)
    across, along = X_AXIS.position(x_count), Y_AXIS.position(y_count)
    vehicle.require_frame(got, _manual(-across, max(0.0, along), max(0.0, -along)), f"at {x_count} and {y_count}")


@on_board("VB34", lasts_s=1.5)
def test_beyond_the_calibration_is_beyond_one(vehicle: Vehicle) -> None:
    got = _joystick(vehicle, 0, 0)
    vehicle.require_frame(got, _manual(33_470 / 32_413, 0.0, 33_080 / 32_018), "the joystick beyond its ends")


@on_board("VB34H", lasts_s=1.5)
def test_the_joystick_ends_at_one(vehicle: Vehicle) -> None:
    vehicle.require_frame(_joystick(vehicle, 0, 0), _manual(1.0, 0.0, 1.0), "the joystick beyond its ends")


@on_board("VB19", lasts_s=6.0)
def test_manual_at_20_hz(vehicle: Vehicle) -> None:
    mark = vehicle.manual()
    told = vehicle.stack.mark()
    begun_ns = vehicle.bench.now_ns
    newest = _say_a_hundred(vehicle)
    frames = vehicle.frames(mark)
    _require_no_emergency(frames, begun_ns)
    vehicle.require_modes(frames, Mode.MANUAL)
    vehicle.require_steps(frames, MANUAL_S, "between frames of the joystick")
    reports = vehicle.stack.since(told, VelocityReport)
    late_ns = round((REPORT_WITHIN_S + vehicle.uncertainty_s(begun_ns)) * NS_PER_S)
    for got, report in reports:
        of_old = [speed for when_ns, speed in newest if when_ns <= got.start_ns - late_ns][-1:]
        since = [speed for when_ns, speed in newest if got.start_ns - late_ns < when_ns <= got.start_ns]
        if report.longitudinal_velocity not in (*of_old, *since) and newest[0][0] < got.start_ns - late_ns:
            found, at_s = report.longitudinal_velocity, got.start_ns / NS_PER_S
            raise Violation(f"{found:g} m/s is reported at {at_s:.4f} s, the newest are {[*of_old, *since]}")
    at_least(len(reports), len(frames) - 2, unit="reports", what="of the status")
    vehicle.require_reported(vehicle.other_status(3.0), vehicle.stack.mark())


def _say_a_hundred(vehicle: Vehicle) -> list[tuple[int, float]]:
    """Change the status each time it is said, in whole m/s; return when each was said, in ns, and its speed."""
    statuses = vehicle.simulator.statuses
    said_ns = []
    for number in range(100):
        speed_m_s = float(1 + number % 30)
        vehicle.other_status(speed_m_s)
        said = statuses.said
        vehicle.bench.run_until(lambda said=said: statuses.said > said, 0.2)  # type: ignore[misc]
        said_ns.append((vehicle.bench.now_ns, speed_m_s))
    return said_ns


def _require_no_emergency(frames: Sequence[Frame], begun_ns: int) -> None:
    """Require that the simulator's statuses, which come all the time, are seen."""
    false = [got for got in frames if got.packet is not None and got.packet.mode == Mode.EMERGENCY]
    if false:
        first_s = (false[0].start_ns - begun_ns) / NS_PER_S
        steps_s = [(later.start_ns - earlier.start_ns) / NS_PER_S for earlier, later in pairwise(false)]
        often = f", one every {sum(steps_s) / len(steps_s):.3f} s" if steps_s else ""
        raise Violation(
            f"{len(false)} frames of EMERGENCY in {(frames[-1].start_ns - begun_ns) / NS_PER_S:.1f} s of MANUAL though "
            f"statuses come at {STATUS_HZ:g} Hz: the first after {first_s:.3f} s{often}",
            shown(false[:4]),
        )


@on_board("VB20", lasts_s=3.0)
def test_manual_at_10_hz(vehicle: Vehicle) -> None:
    mark = vehicle.manual(status_hz=10.0)
    vehicle.run(2.0)
    frames = vehicle.frames(mark)
    vehicle.require_modes(frames, Mode.MANUAL)
    vehicle.require_steps(frames, 0.1, "between frames of the joystick")


@on_board("VB21", lasts_s=3.0)
def test_the_emergency_in_manual(vehicle: Vehicle) -> None:
    vehicle.hands.set_joystick(FULL_SCALE, FULL_SCALE)
    mark = vehicle.manual()
    vehicle.simulator.statuses.stop()
    first = vehicle.wait_for(Mode.EMERGENCY, 2.5, mark)
    before = [got for got in vehicle.frames(mark) if got.start_ns < first.start_ns]
    vehicle.require_modes(before, Mode.MANUAL)
    unanswered = [*before[-MISSES:], first]
    vehicle.require_steps(unanswered, MANUAL_MISS_S, "between frames without a status")
    answered_s = (before[-MISSES].start_ns - before[-MISSES - 1].start_ns) / NS_PER_S
    at_most(answered_s, MANUAL_MISS_S - 2 * TICK_S, unit="s", what="the frame before them was followed after")
    vehicle.run(3.5 * STATUS_MISS_S)
    emergency = [got for got in vehicle.frames(mark) if got.start_ns >= first.start_ns]
    vehicle.require_steps(emergency, STATUS_MISS_S, "between frames of the emergency")
    _require_emergency(vehicle, emergency)


@on_board("VB22", lasts_s=6.0)
def test_the_false_emergency(vehicle: Vehicle) -> None:
    mark = vehicle.manual()
    told = vehicle.stack.mark()
    before = vehicle.speeds(0)[-1:]
    vehicle.other_status(3.0)
    vehicle.run(5.0)
    frames = vehicle.frames(mark)
    modes = vehicle.simulator.modes(mark)
    manual = [got for got, mode in zip(frames, modes, strict=True) if mode == Mode.MANUAL]
    false = [got for got, mode in zip(frames, modes, strict=True) if mode == Mode.EMERGENCY]
    vehicle.require_steps(manual, MANUAL_MISS_S, "between frames of the joystick")
    near(len(false), 3, 1, unit="frames", what="of EMERGENCY in 5 s")
    vehicle.require_steps(false, MISSES * MANUAL_MISS_S, "between false emergencies")
    stands = [speed for speed in vehicle.speeds(told) if speed != 3.0]
    assert stands, "the status that is told follows that of the simulator at once"
    assert {*stands} <= {*before}, f"the status that is told is {stands[:4]}, required {before}"


def _asked_in_manual(vehicle: Vehicle) -> int:
    """In MANUAL, ask for AUTOWARE just after a frame, when the status is waited for; return a mark from then on."""
    vehicle.manual()
    mark = vehicle.mark()
    vehicle.bench.run_until(lambda: vehicle.mark() > mark, 0.3)
    mark = vehicle.mark()
    assert vehicle.stack.request(ControlMode.AUTONOMOUS).success, "the request is refused"
    return mark


@on_board("VB23", lasts_s=4.0)
def test_the_way_to_autoware_is_lost(vehicle: Vehicle) -> None:
    mark = _asked_in_manual(vehicle)
    vehicle.run(2.5)
    frames = vehicle.frames(mark)
    assert Mode.AUTOWARE not in vehicle.simulator.modes(mark), "commands are handed on"
    steps_s = [(later.start_ns - earlier.start_ns) / NS_PER_S for earlier, later in pairwise(frames)]
    again = [step_s for step_s in steps_s if abs(step_s - COMMAND_MISS_S) <= TICK_S]
    near(len(again), MISSES - 1, 1, unit="frames", what="sent again 110 ms apart, until MANUAL is back")


@on_board("VB23H", lasts_s=5.0)
def test_autoware_can_be_ordered_in_manual(vehicle: Vehicle) -> None:
    mark = _asked_in_manual(vehicle)
    begun = vehicle.wait_for(Mode.AUTOWARE, MODE_WITHIN_S, mark)
    vehicle.run(3.0)
    vehicle.require_modes(vehicle.frames(_behind(vehicle, begun)), Mode.AUTOWARE)


# --- statuses: frames that are whole, cut, or damaged


@on_board("VB24", lasts_s=1.5)
def test_delimiters_within_a_float_are_data(vehicle: Vehicle) -> None:
    vehicle.autoware()
    mark = vehicle.stack.mark()
    vehicle.simulator.status = F6
    vehicle.require_reported(F6, mark)


def _quiet(vehicle: Vehicle) -> int:
    """In AUTOWARE, let statuses stop between two of them; return a mark in the reports from then on."""
    vehicle.autoware()
    statuses = vehicle.simulator.statuses
    said = statuses.said
    vehicle.bench.run_until(lambda: statuses.said > said, 0.2)
    statuses.stop()
    vehicle.run(0.02)
    return vehicle.stack.mark()


def _go_on(vehicle: Vehicle, speed_m_s: float) -> int:
    """Let statuses come again, with another speed; return a mark in the reports from then on."""
    vehicle.other_status(speed_m_s)
    vehicle.simulator.statuses.start(STATUS_HZ)
    return vehicle.stack.mark()


@on_board("VB25", lasts_s=63.0)
def test_one_stray_byte_is_for_ever(vehicle: Vehicle) -> None:
    _quiet(vehicle)
    mark = vehicle.mark()
    vehicle.simulator.write(b"\0")
    told = _go_on(vehicle, 3.0)
    vehicle.wait_for(Mode.EMERGENCY, 1.3, mark)
    vehicle.run(60.0)
    assert 3.0 not in vehicle.speeds(told), "a status is accepted behind a stray byte"
    vehicle.require_modes(vehicle.frames()[-20:], Mode.EMERGENCY)


_WHOLE = encode_status(STATUS)
_STRAY = (
    *(bytes(count) for count in range(1, 31)),
    *(_WHOLE[:count] for count in range(1, STATUS_BYTES)),
    *(_WHOLE[count:] for count in range(1, STATUS_BYTES)),
    b"##",
    b"#A#",
    b"#" * STATUS_BYTES,
    b"#" * 30,
)
"""Zeros, beginnings and ends of a status, and what looks like beginnings."""


@on_board("VB25H", lasts_s=12.0)
def test_stray_bytes_cost_no_status(vehicle: Vehicle) -> None:
    _quiet(vehicle)
    mark = vehicle.mark()
    for number, stray in enumerate(_STRAY):
        vehicle.simulator.write(stray)
        vehicle.run(0.01)
        told = vehicle.stack.mark()
        status = vehicle.other_status(1.0 + number % 30)
        vehicle.say(status)
        vehicle.require_reported(status, told, 1 / STATUS_HZ + 0.03)
    vehicle.require_modes(vehicle.frames(mark), Mode.AUTOWARE)


@on_board("VB47", lasts_s=3.0)
def test_half_a_status_is_given_up(vehicle: Vehicle) -> None:
    for count in (1, 10, 21):
        mark = _quiet(vehicle)
        data = encode_status(vehicle.other_status(float(count)))
        vehicle.simulator.write(data[:count])
        vehicle.run(0.15)
        vehicle.simulator.write(data[count:])
        vehicle.run(0.1)
        speeds = vehicle.speeds(mark)
        assert float(count) not in speeds, f"a status in pieces of {count} and {STATUS_BYTES - count} is accepted"
        told = _go_on(vehicle, 4.0)
        vehicle.require_reported(vehicle.simulator.status, told)


@on_board("VB26", lasts_s=1.5)
def test_a_frame_may_come_in_pieces(vehicle: Vehicle) -> None:
    mark = _quiet(vehicle)
    data = encode_status(vehicle.other_status(3.0))
    vehicle.simulator.write(data[:10])
    vehicle.run(0.05)
    vehicle.simulator.write(data[10:])
    vehicle.require_reported(vehicle.simulator.status, mark)


_SHORT = b"#A" + bytes.fromhex("00004040") + b"$" + bytes(15)
"""A field A of 3.0 and the end, in a block of 22 bytes."""


@on_board("VB27", lasts_s=1.5)
def test_missing_fields_keep_their_old_values(vehicle: Vehicle) -> None:
    mark = _quiet(vehicle)
    vehicle.simulator.write(_SHORT)
    vehicle.require_reported(replace(STATUS, lon_speed_m_s=3.0), mark)


@on_board("VB27H", lasts_s=2.5)
def test_a_frame_that_lacks_a_field_is_none(vehicle: Vehicle) -> None:
    twice = encode_status(replace(STATUS, lon_speed_m_s=3.0)).replace(b"B", b"A", 1)
    for stimulus in (_SHORT, twice):
        mark = _quiet(vehicle)
        vehicle.simulator.write(stimulus)
        vehicle.run(0.05)
        told = _go_on(vehicle, 4.0)
        vehicle.require_reported(vehicle.simulator.status, told)
        assert 3.0 not in vehicle.speeds(mark), f"{stimulus.hex(' ')} is accepted"


@on_board("VB28", lasts_s=2.5)
def test_hashes_are_no_status(vehicle: Vehicle) -> None:
    told = _quiet(vehicle)
    mark, quiet_ns = vehicle.mark(), vehicle.bench.now_ns
    vehicle.run(5 * STATUS_MISS_S)
    vehicle.simulator.write(b"#" * 22)
    first = vehicle.wait_for(Mode.EMERGENCY, 1.3, mark)
    moving = [got for got in vehicle.frames(mark) if got.start_ns < first.start_ns]
    what, rate_hz = "frames of mode 1 without a status", 1 / STATUS_MISS_S
    vehicle.require_count(len(moving), MISSES, 1.5, what=what, since_ns=quiet_ns, rate_hz=rate_hz)
    others = [speed for speed in vehicle.speeds(told) if abs(speed - STATUS.lon_speed_m_s) > 1e-5]
    assert not others, f"a speed of {others[0]:g} m/s is reported, which nobody said"


def _damaged(vehicle: Vehicle, damaged: StatusFrame) -> tuple[list[VelocityReport], list[SteeringReport]]:
    """Say a status that cannot be, and then sound ones; return the reports."""
    mark = _quiet(vehicle)
    vehicle.say(damaged, 0.06)
    told = _go_on(vehicle, 4.0)
    vehicle.require_reported(vehicle.simulator.status, told)
    return vehicle.reports(mark, VelocityReport), vehicle.reports(mark, SteeringReport)


@on_board("VB29", lasts_s=1.5)
def test_a_nan_is_handed_on(vehicle: Vehicle) -> None:
    velocities, _ = _damaged(vehicle, replace(STATUS, heading_rate_rad_s=math.nan))
    assert any(math.isnan(report.heading_rate) for report in velocities), "the NaN is not reported"


@on_board("VB29H", lasts_s=10.0)
def test_a_nan_is_no_figure(vehicle: Vehicle) -> None:
    for name in STATUS_FIELDS:
        for value in (math.nan, math.inf):
            figures = _figures(*_damaged(vehicle, replace(STATUS, **{name: value})))
            assert all(map(math.isfinite, figures)), f"{value} in {name} is reported"


def _figures(velocities: Sequence[VelocityReport], steerings: Sequence[SteeringReport]) -> Sequence[float]:
    """Return every figure of some reports."""
    return [
        *(report.longitudinal_velocity for report in velocities),
        *(report.lateral_velocity for report in velocities),
        *(report.heading_rate for report in velocities),
        *(report.steering_tire_angle for report in steerings),
    ]


@on_board("VB35", lasts_s=1.5)
def test_damaged_figures_are_believed(vehicle: Vehicle) -> None:
    velocities, _ = _damaged(vehicle, replace(STATUS, lon_speed_m_s=IMPOSSIBLE_M_S))
    assert any(report.longitudinal_velocity > 1e29 for report in velocities), "1e30 m/s is not reported"


@on_board("VB35H", lasts_s=10.0)
def test_what_cannot_be_is_dropped(vehicle: Vehicle) -> None:
    for name in STATUS_FIELDS:
        for value in (IMPOSSIBLE_M_S, -IMPOSSIBLE_M_S):
            figures = _figures(*_damaged(vehicle, replace(STATUS, **{name: value})))
            assert max(map(abs, figures)) < 1e29, f"{value:g} in {name} is reported"


def _reports_without_statuses(vehicle: Vehicle) -> list[VelocityReport]:
    """Let statuses stop; return what is reported from 0.1 s after it on, until just before the emergency."""
    _quiet(vehicle)
    vehicle.run(STATUS_MISS_S)
    mark = vehicle.stack.mark()
    vehicle.run(0.75)
    return vehicle.reports(mark, VelocityReport)


@on_board("VB32", lasts_s=2.0)
def test_an_old_status_is_reported_as_new(vehicle: Vehicle) -> None:
    at_least(len(_reports_without_statuses(vehicle)), 6, unit="reports", what="of a status that was long ago")


@on_board("VB32H", lasts_s=2.0)
def test_no_status_no_report(vehicle: Vehicle) -> None:
    at_most(len(_reports_without_statuses(vehicle)), 0, unit="reports", what="without a status")


def _after_line_error(vehicle: Vehicle) -> int:
    """Make a framing error between two statuses; return a mark in the reports of what follows."""
    _quiet(vehicle)
    vehicle.simulator.port.send_break(200_000)
    vehicle.run(0.01)
    return _go_on(vehicle, 3.0)


@on_board("VB39", lasts_s=5.0)
def test_a_line_error_ends_reception(vehicle: Vehicle) -> None:
    told = _after_line_error(vehicle)
    vehicle.wait_for(Mode.EMERGENCY, 1.5, vehicle.mark())
    vehicle.run(2.0)
    assert 3.0 not in vehicle.speeds(told), "a status is accepted behind a line error"
    vehicle.require_modes(vehicle.frames()[-10:], Mode.EMERGENCY)


@on_board("VB39H", lasts_s=2.0)
def test_a_line_error_costs_a_status(vehicle: Vehicle) -> None:
    told = _after_line_error(vehicle)
    vehicle.require_reported(vehicle.simulator.status, told, 1 / STATUS_HZ + 0.03)


# --- turn indicators and hazard lights


@on_board("VB43", lasts_s=6.0)
def test_turn_indicators_and_hazard_lights(vehicle: Vehicle) -> None:
    vehicle.autoware()
    off = TurnIndicators.DISABLE
    _require_lamps(vehicle, TurnIndicatorsCommand(command=TurnIndicators.ENABLE_LEFT), (True, False))
    _require_lamps(vehicle, TurnIndicatorsCommand(command=TurnIndicators.NO_COMMAND), (True, False))
    _require_told(vehicle, TurnIndicators.ENABLE_LEFT, HazardLights.DISABLE)
    _require_lamps(vehicle, TurnIndicatorsCommand(command=TurnIndicators.ENABLE_RIGHT), (False, True))
    _require_lamps(vehicle, TurnIndicatorsCommand(command=off), (False, False))
    _require_lamps(vehicle, HazardLightsCommand(command=HazardLights.ENABLE), (True, True))
    _require_told(vehicle, off, HazardLights.ENABLE)


def _require_lamps(
    vehicle: Vehicle, command: TurnIndicatorsCommand | HazardLightsCommand, blinks: tuple[bool, bool]
) -> None:
    """Require that a command makes some lamps blink, once a second at least, and the others dark."""
    vehicle.stack.send(command)
    vehicle.run(0.1)
    seen = []
    for _ in range(22):
        vehicle.run(0.05)
        seen.append(vehicle.hands.lamps())
    for name, side, wanted in zip(("left", "right"), zip(*seen, strict=True), blinks, strict=True):
        found = True in side and False in side if wanted else True in side
        if found is not wanted:
            does = "does not blink" if wanted else "is lit"
            raise Violation(f"the {name} lamp {does} behind {command}")


def _require_told(vehicle: Vehicle, turn: int, hazard: int) -> None:
    """Require what the driving stack is told of the lamps."""
    mark = vehicle.stack.mark()
    vehicle.run(0.2)
    turns = {report.report for report in vehicle.reports(mark, TurnIndicatorsReport)}
    hazards = {report.report for report in vehicle.reports(mark, HazardLightsReport)}
    if (turns, hazards) != ({turn}, {hazard}):
        raise Violation(f"told are {turns} and {hazards}, required {turn} and {hazard}", vehicle.stack.evidence(mark))
