"""WFI, WFE, SEV, sleep on exit, and what wakes."""

from __future__ import annotations

import pytest

from targets.mcu.engine.api import Reg, StopKind


def sleep(rig, kind=StopKind.WFI):
    rig.stop(kind)
    return rig.core.sleeping


class TestWaitForInterrupt:
    def test_an_interrupt_wakes_and_runs(self, rig):
        assert sleep(rig)
        assert not rig.core.wakes()
        rig.interrupt(0)
        assert rig.core.wakes()
        rig.settle()
        assert not rig.core.sleeping
        assert rig.began == [16]

    def test_primask_lets_it_wake_without_running(self, rig):
        rig.cpu.set(Reg.PRIMASK, 1)
        assert sleep(rig)
        rig.interrupt(0)
        assert rig.core.wakes()
        assert not rig.core.can_take()
        rig.core.wake()
        assert not rig.core.sleeping
        rig.settle()
        assert rig.began == []

    @pytest.mark.parametrize("mask", [Reg.BASEPRI, Reg.FAULTMASK])
    def test_other_masks_keep_it_asleep(self, rig, mask):
        rig.cpu.set(mask, 0x10)
        rig.cpu.set(Reg.FAULTMASK, int(mask is Reg.FAULTMASK))
        assert sleep(rig)
        rig.interrupt(0, priority=0x20)
        assert not rig.core.wakes()
        rig.poke("SCB", "ICSR", 1 << 31)
        assert rig.core.wakes()

    def test_disabled_or_less_urgent_interrupts_do_not_wake(self, rig):
        rig.interrupt(0, priority=0x20)
        rig.settle()
        assert sleep(rig)
        rig.core.exceptions.pend(20)
        rig.interrupt(1, priority=0x20)
        assert not rig.core.wakes()
        rig.interrupt(2, priority=0x10)
        assert rig.core.wakes()

    def test_what_is_pending_already_ends_it_at_once(self, rig):
        rig.cpu.set(Reg.PRIMASK, 1)
        rig.interrupt(0)
        assert not sleep(rig)

    def test_the_event_register_does_not_matter(self, rig):
        rig.stop(StopKind.SEV)
        assert sleep(rig)


class TestWaitForEvent:
    def test_event_register_is_consumed(self, rig):
        rig.stop(StopKind.SEV)
        assert not sleep(rig, StopKind.WFE)
        assert sleep(rig, StopKind.WFE)

    def test_a_masked_interrupt_does_not_wake(self, rig):
        rig.cpu.set(Reg.PRIMASK, 1)
        assert sleep(rig, StopKind.WFE)
        rig.interrupt(0)
        assert not rig.core.wakes()

    def test_sevonpend_lets_it_wake_even_if_disabled(self, rig):
        rig.poke("SCB", "SCR", 1 << 4)
        assert sleep(rig, StopKind.WFE)
        rig.core.irq(0).set(True)
        assert rig.core.wakes()
        rig.core.wake()
        assert rig.began == []
        assert sleep(rig, StopKind.WFE)  # the event was consumed, and pending again is no change
        rig.core.exceptions.pend(16)
        assert not rig.core.wakes()

    def test_a_handler_sets_the_event_register(self, rig):
        assert sleep(rig, StopKind.WFE)
        rig.interrupt(0)
        rig.settle()
        assert rig.began == [16]
        rig.exit()
        assert not rig.core.sleeping
        assert not sleep(rig, StopKind.WFE)

    def test_an_event_from_the_chip(self, rig):
        assert sleep(rig, StopKind.WFE)
        rig.core.receive_event()
        assert rig.core.wakes()
        rig.core.wake()
        rig.core.receive_event()
        assert not sleep(rig, StopKind.WFE)
        assert sleep(rig)
        rig.core.receive_event()
        assert not rig.core.wakes()  # WFI does not care

    def test_reset_clears_it(self, rig):
        rig.stop(StopKind.SEV)
        rig.core.reset(rig.VECTORS)
        assert sleep(rig, StopKind.WFE)


class TestSleepOnExit:
    def test_returning_to_thread_mode_sleeps(self, rig):
        rig.poke("SCB", "SCR", 1 << 1)
        rig.interrupt(0, priority=0x40)
        rig.settle()
        rig.interrupt(1, priority=0x20)
        rig.settle()
        rig.exit()
        assert not rig.core.sleeping  # back in the first handler
        rig.exit()
        assert rig.core.sleeping
        assert rig.core.running == 0
        rig.interrupt(2)
        rig.settle()
        assert rig.began == [16, 17, 18]

    def test_tail_chaining_does_not_sleep(self, rig):
        rig.poke("SCB", "SCR", 1 << 1)
        rig.interrupt(0)
        rig.settle()
        rig.interrupt(1)
        rig.exit()
        assert rig.core.running == 17
        assert not rig.core.sleeping


def test_deep(rig):
    assert not rig.core.deep
    rig.poke("SCB", "SCR", 1 << 2)
    assert rig.core.deep


def test_lines_that_stop_for_nothing_are_harmless(rig):
    rig.stop(StopKind.LIMIT)
    rig.core.wake()
    assert not rig.core.wakes()
