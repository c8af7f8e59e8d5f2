"""A machine that stops at breakpoints and watchpoints, and goes on as if it had not."""

from __future__ import annotations

from targets.boards import built_in_board
from targets.firmware import image_path
from targets.mcu.engine.hooks import HitKind, Watchpoint
from targets.mcu.image import limits_for, load_image
from targets.mcu.machine import Machine

MS = 1_000_000
BLUE_PILL = built_in_board("bluepill")


def machine_with(image):
    return Machine(BLUE_PILL, load_image(image_path(image), limits_for(BLUE_PILL.chip)))


def test_it_stops_at_main_and_goes_on():
    machine = machine_with("bench-tick-1khz")
    main = machine.image.symbols.find("main").address & ~1
    machine.engine.hooks.breakpoints = {main}
    machine.run_to(5 * MS)
    assert (machine.hit.kind, machine.hit.pc, machine.pc) == (HitKind.BREAKPOINT, main, main)
    assert machine.now_ns < 5 * MS
    machine.run_to(5 * MS)
    assert (machine.hit, machine.now_ns) == (None, 5 * MS)


def test_each_write_to_a_pin_is_told_with_its_value():
    """bench-busy toggles PA0 by BSRR in each round."""
    machine = machine_with("bench-busy")
    machine.run_to(10 * MS)
    machine.engine.hooks.watchpoints = [Watchpoint(0x4001_0800, 0x400)]
    values = []
    for _ in range(4):
        machine.run_to(200 * MS)
        assert machine.hit.kind is HitKind.WRITE
        values.append((machine.hit.address, machine.hit.value))
    assert len(set(values)) == 2
    assert values[:2] == values[2:]


def test_horizon_and_end_are_as_before():
    plain, stopped = machine_with("boot-combined"), machine_with("boot-combined")
    stopped.engine.hooks.breakpoints = {stopped.image.symbols.find("main").address}
    stopped.run_to(50 * MS)
    assert stopped.hit is not None
    for machine in (plain, stopped):
        machine.run_to(50 * MS)
    assert (plain.cycle, plain.ended, plain.engine.fingerprint()) == (
        stopped.cycle,
        stopped.ended,
        stopped.engine.fingerprint(),
    )
