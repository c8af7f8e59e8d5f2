"""Which exception runs: against an oracle that follows the manual's words, and rules of the NVIC one by one."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.engine.api import Reg, Stop, StopKind

NUMBERS = [2, 3, 4, 5, 6, 11, 12, 14, 15, 16, 17, 18, 40, 58]
CONFIGURABLE = NUMBERS[2:]
FIXED = {2: -2, 3: -1}


def oracle(pending, enabled, active, priorities, prigroup, primask, basepri, faultmask):
    """ARMv7-M ARM, ExecutionPriority(), and the choice among pending exceptions, from sections B1.5.4 and B1.5.7."""

    def group(priority):
        return priority if priority < 0 else priority - priority % (2 << prigroup)

    def priority_of(number):
        return FIXED.get(number, priorities.get(number, 0) // 16 * 16)

    running = min((group(priority_of(n)) for n in active), default=256)
    boosted = 256
    if basepri // 16:
        boosted = group(basepri // 16 * 16)
    if primask:
        boosted = 0
    if faultmask:
        boosted = -1
    ready = sorted((priority_of(n), n) for n in pending if n in enabled or n in (2, 3, 11, 14, 15))
    if not ready:
        return None
    priority, number = ready[0]
    return number if group(priority) < min(running, boosted) else None


some = st.sets(st.sampled_from(NUMBERS))


@given(
    pending=some,
    enabled=some,
    active=some,
    priorities=st.dictionaries(st.sampled_from(CONFIGURABLE), st.integers(0, 255)),
    prigroup=st.integers(0, 7),
    primask=st.booleans(),
    basepri=st.integers(0, 255),
    faultmask=st.booleans(),
)
def test_what_runs_is_what_the_manual_says(
    pending, enabled, active, priorities, prigroup, primask, basepri, faultmask, shared_rig
):
    rig = shared_rig
    exceptions = rig.core.exceptions
    exceptions.reset()
    rig.core.reset(rig.VECTORS)
    for number in pending:
        exceptions.pend(number)
    for number in enabled:
        exceptions.enable(number)
    for number in active:
        exceptions.set_active(number, True)
    for number, priority in priorities.items():
        exceptions.set_priority(number, priority)
    exceptions.set_grouping(prigroup)
    rig.cpu.set(Reg.PRIMASK, int(primask))
    rig.cpu.set(Reg.BASEPRI, basepri)
    rig.cpu.set(Reg.FAULTMASK, int(faultmask))
    expected = oracle(pending, enabled, active, priorities, prigroup, primask, basepri, faultmask)
    assert rig.core.can_take() == (expected is not None)
    if expected is not None:
        rig.core.take()
        assert rig.core.can_take()  # the vector is still to be read
        rig.core.take()
        assert rig.core.running == expected
        assert rig.cpu.get(Reg.XPSR) & 0x1FF == expected
        assert exceptions.is_active(expected)
        assert not exceptions.is_pending(expected)


@given(steps=st.lists(st.tuples(st.sampled_from(["pulse", "return"]), st.integers(0, 7)), max_size=40))
def test_nesting_ends_where_it_began_and_never_inverts(steps, shared_rig):
    rig = shared_rig
    rig.core.reset(rig.VECTORS)
    exceptions = rig.core.exceptions
    for irq in range(8):
        exceptions.set_priority(16 + irq, 0x20 * (irq // 2))
        exceptions.enable(16 + irq)
    depth_before = rig.cpu.get(Reg.MSP)
    for action, irq in steps:
        if action == "pulse":
            rig.core.irq(irq).set(True)
            rig.core.irq(irq).set(False)
            rig.settle()
        elif rig.core.running:
            rig.exit()
        active = [n for n in range(16, 24) if exceptions.is_active(n)]
        assert len({exceptions.priorities[n] for n in active}) == len(active)  # one for each level at most
        if active:
            assert rig.core.running == min(active, key=lambda n: exceptions.priorities[n])
        assert rig.cpu.get(Reg.MSP) == depth_before - 32 * len(active)
    while rig.core.running:
        rig.exit()
    assert rig.cpu.get(Reg.MSP) == depth_before
    assert exceptions.pending == 0
    assert exceptions.active == 0
    assert rig.cpu.get(Reg.PC) == rig.MAIN


class TestLines:
    @pytest.fixture
    def nvic(self, rig):
        rig.core.exceptions.enable(16)
        return rig.core.exceptions

    @pytest.fixture
    def begin(self, rig):
        """Enter the handler of what is pending."""
        return rig.settle

    @pytest.fixture
    def end(self, rig):
        """Return from it, as far as that is before anything else begins."""
        return lambda: rig.core.handle(Stop(StopKind.EXCEPTION_RETURN, rig.cpu.get(Reg.LR)))

    def test_rising_edge_pends_and_falling_edge_leaves_it(self, nvic):
        nvic.lines[0].set(True)
        nvic.lines[0].set(False)
        assert nvic.is_pending(16)
        assert nvic.kept.best == 16

    def test_a_line_that_stays_high_is_pended_again_at_return(self, nvic, begin, end):
        nvic.lines[0].set(True)
        begin()
        assert not nvic.is_pending(16)
        end()
        assert nvic.is_pending(16)

    def test_a_pulse_while_active_is_remembered(self, nvic, begin, end):
        nvic.lines[0].set(True)
        begin()
        for level in (False, True, False):
            nvic.lines[0].set(level)
        end()
        assert nvic.is_pending(16)

    def test_a_served_line_stays_quiet(self, nvic, begin, end):
        nvic.lines[0].set(True)
        begin()
        nvic.lines[0].set(False)
        end()
        assert not nvic.is_pending(16)

    def test_clearing_pending_does_not_help_against_a_high_line(self, nvic):
        nvic.lines[0].set(True)
        nvic.unpend(16)
        assert nvic.is_pending(16)
        nvic.lines[0].set(False)
        nvic.unpend(16)
        assert not nvic.is_pending(16)

    def test_clearing_pending_while_active_and_high_lasts_until_return(self, nvic, begin):
        nvic.lines[0].set(True)
        begin()
        nvic.pend(16)
        nvic.unpend(16)
        assert not nvic.is_pending(16)

    def test_a_run_ends_only_for_what_could_be_taken(self, rig, nvic, begin):
        def ends(change, *arguments):
            rig.cpu._state.attention = 0
            change(*arguments)
            return bool(rig.cpu._state.attention)

        assert not ends(nvic.pend, 17)  # not enabled
        assert ends(nvic.enable, 17)
        begin()
        assert not ends(nvic.pend, 16)  # the same priority as what runs
        assert ends(nvic.set_priority, 17, 0x40)

    def test_wrong_interrupt_numbers(self, rig):
        for number in (-1, 43):
            with pytest.raises(ValueError, match="no interrupt"):
                rig.core.irq(number)


def test_subpriority_orders_but_does_not_preempt(rig):
    rig.poke("SCB", "AIRCR", 0x05FA_0500)  # two group bits, two of subpriority
    rig.interrupt(3, priority=0x50)
    rig.settle()
    rig.interrupt(1, priority=0x40)
    rig.interrupt(2, priority=0x70)
    rig.settle()
    assert rig.began == [19]
    rig.exit()
    rig.exit()
    rig.exit()
    assert rig.began == [19, 17, 18]


def test_equal_priorities_go_by_number(rig):
    for irq in (9, 4, 7):
        rig.core.exceptions.enable(16 + irq)
        rig.core.exceptions.pend(16 + irq)
    rig.settle()
    rig.exit()
    rig.exit()
    assert rig.began == [20, 23, 25]
