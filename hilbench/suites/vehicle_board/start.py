"""The start: with the driving stack there, without it, and when it comes late."""

from __future__ import annotations

from itertools import pairwise

from hilbench.check import Violation, near
from hilbench.clock import NS_PER_S
from hilbench.suites._vehicle import COMMAND_MISS_S, MISSES, MODE_WITHIN_S, TICK_S, Frame, Vehicle, on_board, shown
from hilbench.suites.vehicle_board._moves import AGENT_WAIT_S
from protocols.autoware import ControlMode, ControlModeReport, ControlModeRequest, ControlModeResponse
from protocols.carla import COMMAND_BYTES, Mode

BOOT_S = 0.05
"""How long the board may take from power-on to its first instruction of the task. A choice."""

LATE_S = 25.0


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


@on_board("VB14", lasts_s=2.0)
def test_the_first_second_is_blind(vehicle: Vehicle) -> None:
    mark = vehicle.autoware()
    vehicle.run(0.9 - vehicle.bench.now_s)
    vehicle.hands.press()
    vehicle.run(0.7)
    vehicle.require_modes(vehicle.frames(mark), Mode.AUTOWARE)
