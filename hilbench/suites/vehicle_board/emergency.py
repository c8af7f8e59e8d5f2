"""EMERGENCY: what leads there, what is sent meanwhile, and what ends it."""

from __future__ import annotations

from collections.abc import Sequence

from hilbench.check import Untimely, Violation, at_least, at_most, near
from hilbench.clock import NS_PER_S
from hilbench.suites._vehicle import (
    MISSES,
    MODE_WITHIN_S,
    STATUS,
    STATUS_HZ,
    STATUS_MISS_S,
    TICK_S,
    Vehicle,
    on_board,
)
from hilbench.suites.vehicle_board._moves import (
    EXACTLY,
    behind,
    require_emergencies,
    require_emergency,
    status_returns,
)
from protocols.autoware import ControlMode
from protocols.carla import X_AXIS, Y_AXIS, CommandFrame, Mode


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
    after = [got for got in frames if got.start_ns >= first.start_ns]
    require_emergency(vehicle, after)
    vehicle.require_steps([*moving, first], STATUS_MISS_S, "between frames without a status", unprompted=True)
    vehicle.require_steps(after, STATUS_MISS_S, "between frames of the emergency", unprompted=True)
    require_emergencies(vehicle, len(after), 6, first.start_ns)


BRAKE = CommandFrame(acceleration=1.0, mode=Mode.MANUAL)
"""The joystick pulled back as far as it goes."""


@on_board("VB08", lasts_s=3.0)
def test_a_status_ends_the_emergency_in_manual(vehicle: Vehicle) -> None:
    vehicle.hands.set_joystick(X_AXIS.zero, Y_AXIS.least)
    vehicle.emergency()
    vehicle.run(0.15)
    mark, stack_mark = vehicle.mark(), vehicle.stack.mark()
    vehicle.say(STATUS, 0.05)
    frames = vehicle.frames(mark)
    modes = [got.packet.mode for got in frames if got.packet is not None]
    if modes[:1] != [Mode.MANUAL] or Mode.AUTOWARE in modes:
        kind = Violation if Mode.AUTOWARE in modes else Untimely  # or the status has come too late for a frame
        raise kind(f"the modes behind the status are {modes}, required MANUAL next", vehicle.shown(frames))
    vehicle.require_frame(frames[0], BRAKE, "the first frame of MANUAL", vehicle.hands.off_share)
    vehicle.simulator.statuses.start(STATUS_HZ)
    vehicle.run(0.2)
    assert vehicle.modes_reported(stack_mark)[-1:] == [Mode.MANUAL], "the control-mode report does not say 4"
    lit = vehicle.light
    assert lit == "green", f"lit is {lit}, required green"


@on_board("VB09", lasts_s=4.0)
def test_from_there_a_press_leads_back(vehicle: Vehicle) -> None:
    status_returns(vehicle)
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
    require_emergency(vehicle, vehicle.frames(mark))
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
    ended = vehicle.wait_for(Mode.EMERGENCY, 2.0, behind(vehicle, begun))
    # It begins with a command, which may be handed over late, and is read late.
    doubt_s, lasted_s = 2 * vehicle.uncertainty_s(begun.start_ns), (ended.start_ns - begun.start_ns) / NS_PER_S
    at_least(lasted_s, 1.0 - TICK_S, unit="s", what="frames of mode 1 for", uncertainty=doubt_s)


@on_board("VB11H", lasts_s=4.5)
def test_nobody_orders_anything_in_emergency(vehicle: Vehicle) -> None:
    vehicle.emergency()
    mark = vehicle.mark()
    for mode in (ControlMode.AUTONOMOUS, ControlMode.MANUAL):
        assert not vehicle.stack.request(mode).success, f"the request for {mode.name} is granted"
    vehicle.run(0.6)
    require_emergency(vehicle, vehicle.frames(mark))
    mark = vehicle.mark()
    vehicle.simulator.statuses.start(STATUS_HZ)
    vehicle.wait_for(Mode.MANUAL, MODE_WITHIN_S, mark)
    vehicle.run(0.5)
    assert Mode.AUTOWARE not in vehicle.simulator.modes(mark), "the request was remembered"


@on_board("VB33", lasts_s=4.5)
def test_without_commands_nobody_watches_the_simulator(vehicle: Vehicle) -> None:
    emergency_s, modes = _all_stops(vehicle)
    assert Mode.MANUAL in modes, "MANUAL does not come first"
    near(emergency_s, 2.7, 0.2, unit="s", what="the emergency came after")


@on_board("VB33H", lasts_s=4.5)
def test_the_simulator_is_watched_without_commands(vehicle: Vehicle) -> None:
    begun_ns = vehicle.bench.now_ns
    emergency_s, _ = _all_stops(vehicle)
    require_emergency(vehicle, vehicle.frames()[-1:])
    doubt_s = vehicle.uncertainty_s(begun_ns)
    at_most(emergency_s, 1.3, unit="s", what="the emergency came after", uncertainty=doubt_s)


def _all_stops(vehicle: Vehicle) -> tuple[float, Sequence[int]]:
    """Let commands and statuses stop at once; return when the emergency comes, and the modes before it."""
    mark = vehicle.autoware()
    vehicle.feed(status_hz=None, command_hz=None)
    stopped_ns = vehicle.bench.now_ns
    first = vehicle.wait_for(Mode.EMERGENCY, 4.0, mark)
    return vehicle.since_s(stopped_ns, first), vehicle.simulator.modes(mark)
