"""Who may change the mode: requests of the driving stack, presses of the joystick."""

from __future__ import annotations

from itertools import pairwise

from hilbench.check import Violation, at_least, near
from hilbench.clock import NS_PER_S
from hilbench.suites._vehicle import COMMAND_MISS_S, MISSES, MODE_WITHIN_S, TICK_S, Frame, Vehicle, on_board
from hilbench.suites.vehicle_board._moves import (
    AGENT_WAIT_S,
    MANUAL_S,
    OTHER_WAY,
    OTHER_WAY_FRAME,
    behind,
    status_returns,
)
from protocols.autoware import ControlMode, ControlModeRequest, ControlModeResponse
from protocols.carla import CommandFrame, Mode


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
        raise Violation(f"the mode changed {changes} times, required once", vehicle.shown(frames[-6:]))
    vehicle.run(0.2)
    for pause_s, mode in ((1.01, Mode.AUTOWARE), (0.99, Mode.MANUAL), (0.6, Mode.MANUAL)):
        vehicle.hands.hold()
        vehicle.run(0.02)
        vehicle.hands.let_go()
        vehicle.run(pause_s - 0.02)
        found = vehicle.simulator.modes()[-1]
        if found != mode:
            raise Violation(f"{pause_s:g} s after a press the mode is {found}, required {mode.value}")


@on_board("VB51", lasts_s=5.0)
def test_the_switch_acts_when_it_is_let_go_of(vehicle: Vehicle) -> None:
    mark = vehicle.autoware()
    vehicle.run(1.2)
    vehicle.hands.hold()
    vehicle.run(1.5)
    vehicle.require_modes(vehicle.frames(mark), Mode.AUTOWARE)
    mark = vehicle.mark()
    vehicle.hands.let_go()
    vehicle.wait_for(Mode.MANUAL, MODE_WITHIN_S, mark)
    vehicle.run(1.2)
    assert vehicle.simulator.modes()[-1] == Mode.MANUAL, "MANUAL does not stay"


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


AT_ONCE_S = 0.016
"""How far apart two requests may come that find the control task in one of its waits. A choice."""


def _ask_both(vehicle: Vehicle, *modes: ControlMode) -> None:
    """Ask for both modes within a millisecond, just after a frame: the control task waits then."""
    mark = vehicle.mark()
    vehicle.bench.run_until(lambda: vehicle.mark() > mark, 0.2)
    sent_ns = vehicle.bench.now_ns
    for sequence, mode in enumerate(modes):
        vehicle.stack.send(ControlModeRequest(sequence=100 + sequence, mode=mode))
    vehicle.run(0.05)
    vehicle.simulator.require_punctual(sent_ns, AT_ONCE_S, "these requests did not come at once")
    vehicle.run(0.45)


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
    """From EMERGENCY by a status and a press to AUTOWARE; return the first frame behind the amber light.

    What is commanded changes in MANUAL.
    """
    vehicle.hands.set_joystick(65_535, 65_535)
    status_returns(vehicle)
    vehicle.stack.command = OTHER_WAY
    vehicle.run(0.3)
    vehicle.hands.press()
    amber = vehicle.bench.run_until(lambda: vehicle.light == "amber", MODE_WITHIN_S)
    assert amber, f"lit is {vehicle.light}, required amber"
    now_ns = vehicle.bench.now_ns
    found = vehicle.bench.run_until(lambda: vehicle.frames()[-1].start_ns > now_ns, MODE_WITHIN_S)
    assert found, "no frame comes after the amber light"
    return next(got for got in vehicle.frames() if got.start_ns > now_ns)


@on_board("VB38", lasts_s=4.0)
def test_the_joystick_s_values_as_a_command(vehicle: Vehicle) -> None:
    first = _first_behind_amber(vehicle)
    vehicle.require_frame(first, CommandFrame(steering=-1.0, speed=1.0, mode=Mode.MANUAL), "the first in AUTOWARE")


@on_board("VB38H", lasts_s=4.0)
def test_autoware_begins_with_a_command(vehicle: Vehicle) -> None:
    vehicle.require_frame(_first_behind_amber(vehicle), OTHER_WAY_FRAME, "the first in AUTOWARE")


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
    mark, begun_ns = _asked_in_manual(vehicle), vehicle.bench.now_ns
    vehicle.run(2.5)
    frames = vehicle.frames(mark)
    assert Mode.AUTOWARE not in vehicle.simulator.modes(mark), "commands are forwarded"
    steps_s = [(later.start_ns - earlier.start_ns) / NS_PER_S for earlier, later in pairwise(frames)]
    again = [step_s for step_s in steps_s if abs(step_s - COMMAND_MISS_S) <= TICK_S]
    vehicle.simulator.require_punctual(begun_ns, TICK_S, "how far apart frames were sent is not known")
    near(len(again), MISSES - 1, 1, unit="frames", what="sent again 110 ms apart, until MANUAL is back")


@on_board("VB23H", lasts_s=5.0)
def test_autoware_can_be_ordered_in_manual(vehicle: Vehicle) -> None:
    mark = _asked_in_manual(vehicle)
    begun = vehicle.wait_for(Mode.AUTOWARE, MODE_WITHIN_S, mark)
    vehicle.run(3.0)
    vehicle.require_modes(vehicle.frames(behind(vehicle, begun)), Mode.AUTOWARE)
