"""The start: with the driving stack there, without it, and when it comes late; and after a hang."""

from __future__ import annotations

from itertools import pairwise

from hilbench.check import Untimely, Violation, at_most, near
from hilbench.clock import NS_PER_S
from hilbench.suites._vehicle import COMMAND_MISS_S, MISSES, MODE_WITHIN_S, TICK_S, Frame, Vehicle, on_board
from hilbench.suites.vehicle_board._moves import AGENT_WAIT_S, F1, PING_S
from protocols.autoware import AgentPing, ControlMode, ControlModeReport, ControlModeRequest, ControlModeResponse
from protocols.carla import COMMAND_BYTES, Mode

BACK_S = 1.0
"""How soon a board that hung drives again: 0.5 s of its watchdog, with room for its clock and the start. A choice."""

LATE_S = 25.0

STILL_WAITS_S = 18.0
"""Well within the 20 s, so that a board's own count of them may be off."""

CLOCKS = 4
"""Seconds for which only clock messages come: more than the 3 s of silence after which a stack is lost (VB55H)."""
PING_OFF_S = 0.02
"""How far off a step between two of them may be: a turn of the loop that asks. A choice."""


@on_board("VB03", lasts_s=21.0)
def test_without_an_agent_manual(vehicle: Vehicle) -> None:
    vehicle.stack.online = False
    vehicle.feed(command_hz=None)
    first = vehicle.wait_for(Mode.MANUAL, AGENT_WAIT_S + 1.0, 0)
    bursts = vehicle.simulator.bursts
    if bursts[0].start_ns < first.start_ns:
        raise Violation(f"{len(bursts[0].data)} bytes came before the first frame of mode 4", vehicle.shown([first]))
    found_s = vehicle.since_s(vehicle.started_ns, first)
    near(found_s, AGENT_WAIT_S, TICK_S, unit="s", what="the first frame came after")
    asked = [got for got, _ in vehicle.stack.since(0, AgentPing) if got.start_ns < first.start_ns]
    doubt_s = vehicle.uncertainty_s(0)
    for before, after in pairwise(asked):
        step_s = (after.start_ns - before.start_ns) / NS_PER_S
        near(step_s, PING_S, PING_OFF_S, unit="s", what="between pings", uncertainty=doubt_s)
    near(len(asked), AGENT_WAIT_S / PING_S, 1, unit="pings", what="before that")


def _nothing_commanded(vehicle: Vehicle) -> Frame:
    """Have the agent there and command nothing; return the first frame of mode 4, 1.1 s after the agent."""
    vehicle.feed(command_hz=None)
    manual = vehicle.wait_for(Mode.MANUAL, 2.0, 0)
    found_s, expected_s = vehicle.since_s(vehicle.linked_ns, manual), MISSES * COMMAND_MISS_S
    near(found_s, expected_s, TICK_S, unit="s", what="the first of mode 4 came after")
    return manual


@on_board("VB04", lasts_s=1.5, noisy=True)
def test_frames_that_nobody_filled(vehicle: Vehicle) -> None:
    manual = _nothing_commanded(vehicle)
    before = [burst for burst in vehicle.simulator.bursts if burst.start_ns < manual.start_ns]
    whole = COMMAND_BYTES * (MISSES - 1)
    if [len(burst.data) for burst in before] != [COMMAND_BYTES] * (MISSES - 1):
        sizes = ", ".join(str(len(burst.data)) for burst in before) or "none"
        text = f"bytes before mode 4: {sizes}; required nine times {COMMAND_BYTES}"
        # Bytes that are read late fall into other bursts than they were sent in.
        raise (Untimely if sum(len(burst.data) for burst in before) == whole else Violation)(text)
    starts_ns = [burst.start_ns for burst in before]
    for earlier, later in pairwise([*starts_ns, manual.start_ns]):
        near((later - earlier) / NS_PER_S, COMMAND_MISS_S, TICK_S, unit="s", what="between them")


@on_board("VB04H", lasts_s=1.5)
def test_nothing_before_there_is_something_to_say(vehicle: Vehicle) -> None:
    manual = _nothing_commanded(vehicle)
    first = vehicle.simulator.bursts[0]
    if first.start_ns < manual.start_ns:
        raise Violation(f"{len(first.data)} bytes came {first.start_ns / NS_PER_S:.3f} s after power-on")


@on_board("VB58", lasts_s=19.5)
def test_an_agent_is_waited_for(vehicle: Vehicle) -> None:
    vehicle.stack.online = False
    vehicle.feed(command_hz=None)
    vehicle.run(STILL_WAITS_S)
    assert not vehicle.simulator.bursts, "something is sent before the driving stack is there"
    vehicle.stack.go_online()
    vehicle.feed()
    first = vehicle.wait_for(Mode.AUTOWARE, PING_S + MODE_WITHIN_S, 0)
    vehicle.require_frame(first, F1, "the frame of the command")
    assert vehicle.reports(0, ControlModeReport), "the mode is not reported"


@on_board("VB42", lasts_s=28.0)
def test_a_late_agent_is_not_heard(vehicle: Vehicle) -> None:
    mark = _late_agent(vehicle)
    vehicle.feed()
    vehicle.run(0.3)
    vehicle.stack.send(ControlModeRequest(sequence=1, mode=ControlMode.AUTONOMOUS))
    vehicle.run(2.0)
    assert not vehicle.reports(0, ControlModeReport), "the mode is reported"
    assert not vehicle.reports(0, ControlModeResponse), "the request is answered"
    assert Mode.AUTOWARE not in vehicle.simulator.modes(mark), "the request is obeyed"


@on_board("VB42H", lasts_s=32.0)
def test_an_agent_may_come_late(vehicle: Vehicle) -> None:
    mark = _late_agent(vehicle)
    assert vehicle.reports(0, ControlModeReport), "the mode is not reported"
    for _ in range(CLOCKS):
        vehicle.stack.set_clock(vehicle.bench.now_ns)
        vehicle.run(0.7)
        stack_mark = vehicle.stack.mark()
        vehicle.run(0.3)
        assert vehicle.reports(stack_mark, ControlModeReport), "the mode is not reported while only clock messages come"
    vehicle.feed()
    vehicle.run(0.3)
    answer = vehicle.stack.request(ControlMode.AUTONOMOUS)
    assert answer.success, "the request is refused"
    vehicle.wait_for(Mode.AUTOWARE, MODE_WITHIN_S, mark)


def _late_agent(vehicle: Vehicle) -> int:
    """Have the agent come after 25 s, and command nothing yet; return a mark in the frames from then on."""
    vehicle.stack.online = False
    vehicle.feed(command_hz=None)
    vehicle.run(LATE_S)
    mark = vehicle.mark()
    vehicle.stack.go_online()
    vehicle.run(0.3)
    return mark


@on_board("VB14", lasts_s=2.0)
def test_the_first_second_is_blind(vehicle: Vehicle) -> None:
    mark = vehicle.autoware()
    started_s = vehicle.started_ns / NS_PER_S
    vehicle.hands.hold()
    vehicle.run(started_s + 0.99 - vehicle.bench.now_s)
    vehicle.hands.let_go()
    vehicle.run(0.01)
    vehicle.hands.hold()
    vehicle.run(0.01)
    vehicle.require_modes(vehicle.frames(mark), Mode.AUTOWARE)
    mark = vehicle.mark()
    vehicle.hands.let_go()
    vehicle.wait_for(Mode.MANUAL, MODE_WITHIN_S, mark)


@on_board("VB56", lasts_s=6.5)
def test_a_program_that_hangs_is_gone(vehicle: Vehicle) -> None:
    vehicle.autoware()
    mark = _hangs(vehicle)
    vehicle.run(5.0)
    assert not vehicle.frames(mark), "frames come again"


@on_board("VB56H", lasts_s=5.0)
def test_a_program_that_hangs_starts_again(vehicle: Vehicle) -> None:
    vehicle.autoware()
    _require_start(vehicle)
    vehicle.manual()
    _require_start(vehicle)


def _require_start(vehicle: Vehicle) -> None:
    """Have the program hang; require that it drives again."""
    mark, hung_ns = _hangs(vehicle), vehicle.bench.now_ns
    first = vehicle.wait_for(Mode.AUTOWARE, BACK_S + 0.5, mark)
    at_most(vehicle.since_s(hung_ns, first), BACK_S, unit="s", what="a frame came again after")
    vehicle.require_frame(first, F1, "the frame of the command")


def _hangs(vehicle: Vehicle) -> int:
    """Just behind a frame, have the program hang; return a mark in the frames from then on."""
    mark = vehicle.mark()
    vehicle.bench.run_until(lambda: vehicle.mark() > mark, 0.2)
    vehicle.run(0.005)
    vehicle.hands.hang()
    return vehicle.mark()
