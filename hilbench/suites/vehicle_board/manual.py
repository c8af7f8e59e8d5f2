"""MANUAL: how often its frames come, and what it does with statuses, or without."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

from hilbench.check import Untimely, Violation, at_least, at_most, near
from hilbench.clock import NS_PER_S
from hilbench.suites._vehicle import MISSES, STATUS, STATUS_HZ, STATUS_MISS_S, TICK_S, Frame, Vehicle, on_board
from hilbench.suites.vehicle_board._moves import (
    MANUAL_MISS_S,
    MANUAL_S,
    nine_misses,
    nine_misses_around_a_status,
    require_emergencies,
    require_emergency,
    require_newest,
    say_a_hundred,
)
from protocols.carla import FULL_SCALE, Mode


@on_board("VB45", lasts_s=10.5)
def test_any_status_begins_the_count_again_in_manual(vehicle: Vehicle) -> None:
    vehicle.manual()
    vehicle.simulator.statuses.stop()
    vehicle.run(3 * MANUAL_MISS_S)
    nine_misses_around_a_status(vehicle, Mode.MANUAL, MANUAL_MISS_S)
    vehicle.emergency()
    vehicle.run(0.15)
    mark = vehicle.mark()
    vehicle.say(STATUS)
    nine_misses(vehicle, mark, Mode.MANUAL, MISSES, MANUAL_MISS_S)


@on_board("VB19", lasts_s=6.0)
def test_manual_at_20_hz(vehicle: Vehicle) -> None:
    mark = vehicle.manual()
    stack_mark = vehicle.stack.mark()
    begun_ns = vehicle.bench.now_ns
    newest = say_a_hundred(vehicle)
    frames = vehicle.frames(mark)
    _require_no_emergency(vehicle, frames, begun_ns)
    vehicle.require_modes(frames, Mode.MANUAL)
    vehicle.require_steps(frames, MANUAL_S, "between frames of the joystick")
    reports = require_newest(vehicle, stack_mark, newest)
    at_least(reports, len(frames) - 2, unit="reports", what="of the status")
    vehicle.require_reported(vehicle.other_status(3.0), vehicle.stack.mark())


def _require_no_emergency(vehicle: Vehicle, frames: Sequence[Frame], begun_ns: int) -> None:
    """Require that the simulator's statuses, which come all the time, are seen."""
    false = [got for got in frames if got.packet is not None and got.packet.mode == Mode.EMERGENCY]
    if false:
        first_s = (false[0].start_ns - begun_ns) / NS_PER_S
        steps_s = [(later.start_ns - earlier.start_ns) / NS_PER_S for earlier, later in pairwise(false)]
        often = f", one every {sum(steps_s) / len(steps_s):.3f} s" if steps_s else ""
        raise Violation(
            f"{len(false)} frames of EMERGENCY in {(frames[-1].start_ns - begun_ns) / NS_PER_S:.1f} s of MANUAL though "
            f"statuses come at {STATUS_HZ:g} Hz: the first after {first_s:.3f} s{often}",
            vehicle.shown(false[:4]),
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
    vehicle.hold_joystick(FULL_SCALE, FULL_SCALE)
    mark = vehicle.manual()
    vehicle.simulator.statuses.stop()
    first = vehicle.wait_for(Mode.EMERGENCY, 2.5, mark)
    before = [got for got in vehicle.frames(mark) if got.start_ns < first.start_ns]
    vehicle.require_modes(before, Mode.MANUAL)
    if len(before) < MISSES:
        text = f"{len(before)} frames of mode {Mode.MANUAL.value} came before the emergency, required {MISSES}"
        raise Untimely(text, vehicle.shown(before))
    unanswered = [*before[-MISSES:], first]
    vehicle.require_steps(unanswered, MANUAL_MISS_S, "between frames without a status", unprompted=True)
    if len(before) > MISSES:  # else the last status came before the first frame that is looked at
        answered_s = (before[-MISSES].start_ns - before[-MISSES - 1].start_ns) / NS_PER_S
        at_most(answered_s, MANUAL_MISS_S - 2 * TICK_S, unit="s", what="the frame before them was followed after")
    vehicle.run(3.5 * STATUS_MISS_S)
    emergency = [got for got in vehicle.frames(mark) if got.start_ns >= first.start_ns]
    vehicle.require_steps(emergency, STATUS_MISS_S, "between frames of the emergency", unprompted=True)
    require_emergency(vehicle, emergency)
    require_emergencies(vehicle, len(emergency), 4, first.start_ns)


@on_board("VB22", lasts_s=6.0)
def test_the_false_emergency(vehicle: Vehicle) -> None:
    mark = vehicle.manual()
    stack_mark = vehicle.stack.mark()
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
    stands = [speed for speed in vehicle.speeds(stack_mark) if speed != 3.0]
    assert stands, "the status that is reported follows that of the simulator at once"
    assert {*stands} <= {*before}, f"the status that is reported is {stands[:4]}, required {before}"
