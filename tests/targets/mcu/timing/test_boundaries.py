"""What an instruction brings about counts from the very next one on, however the program is executed just then."""

from __future__ import annotations

import pytest

from targets.mcu.engine.api import Reg
from tests.share import matrix
from tests.targets.mcu.timing.assembly import BX_LR, HANG, SCS, Code

PENDSV = 14
ICSR, PENDSVSET = SCS + 0xD04, 1 << 28
MS = 1_000_000

# Waits longer each time, so that the store happens wherever the machine may be in its search for idle loops: r4 counts
# the rounds, r7 collects what r5 was in the handler, which has to be 0.
ROUNDS = (
    Code()
    .load(2, ICSR)
    .load(3, PENDSVSET)
    .add(0x2401, 0x2700)  # movs r4, #1; movs r7, #0
    .add(0x2500, 0x0020)  # next: movs r5, #0; movs r0, r4
    .add(0x3801, 0xD1FD)  # subs r0, #1; bne .-2
    .add(0x6013, 0x2501)  # str r3, [r2]; movs r5, #1
    .add(0x3401, 0xF5B4, 0x7F00, 0xD1F5)  # adds r4, #1; cmp.w r4, #512; bne next
    .add(HANG)
)
HANDLER = Code(0x432F, BX_LR)  # orrs r7, r5


@pytest.mark.parametrize(("skip_idle", "timing", "step_ns"), matrix([True, False], ["flat", "table"], [None, 10_000]))
def test_an_exception_that_a_store_makes_pending_is_taken_after_the_store(start, skip_idle, timing, step_ns):
    machine = start(ROUNDS, {PENDSV: HANDLER}, skip_idle=skip_idle, timing=timing)
    taken = []
    machine.core.on_running = taken.append
    for limit_ns in [] if step_ns is None else range(0, 50 * MS, step_ns):
        machine.run_to(limit_ns)
    machine.run_to(100 * MS)
    assert machine.engine.get(Reg.R4) == 512
    assert taken.count(PENDSV) == 511
    assert machine.engine.get(Reg.R7) == 0
