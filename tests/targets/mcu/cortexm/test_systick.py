"""SysTick to the cycle: known sequences, and a counter that steps cycle by cycle as the manual tells it."""

from __future__ import annotations

import struct

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from targets.mcu.cortexm.exceptions import Exceptions, Number
from targets.mcu.cortexm.systick import SysTick
from targets.mcu.engine.api import Access, Reg, StopKind
from targets.mcu.engine.core_engine import CoreEngine
from targets.mcu.engine.timing import make_timing
from targets.mcu.testing import FakeChip, peek, poke

ENABLE, TICKINT, HCLK, COUNTFLAG = 1, 2, 4, 1 << 16


class Bench:
    def __init__(self):
        self.engine = CoreEngine(make_timing("table"))
        self.exceptions = Exceptions(self.engine, 43, 4)
        services = FakeChip().services
        self.timer = SysTick(0xE000_E000, services, self.engine, self.exceptions)

    def advance(self, cycles):
        self.engine.add_cycles(cycles)
        self.engine.ask("hil_tick")

    @property
    def next_cycle(self):
        """The next cycle at which something happens, or None."""
        alarm = self.engine.alarm
        return None if alarm == 2**64 - 1 else alarm

    @property
    def pending(self):
        return self.exceptions.is_pending(Number.SYSTICK)

    def taken(self):
        """Say whether the exception is pending, and take it off."""
        was = self.pending
        self.exceptions.unpend(Number.SYSTICK)
        return was


@pytest.fixture
def bench():
    return Bench()


def start(bench, load, control, value=True):
    poke(bench.timer, "LOAD", load)
    if value:
        poke(bench.timer, "VAL", 0)
    poke(bench.timer, "CTRL", control)


def test_period_is_load_plus_one(bench):
    start(bench, 7_199, ENABLE | TICKINT | HCLK)
    ticks = []
    for cycle in range(1, 5 * 7_200 + 2):
        due = bench.next_cycle == cycle
        bench.advance(1)
        assert bench.taken() is due
        if due:
            ticks.append(cycle)
    assert ticks == [7_200 * k for k in range(1, 6)]


def test_sequence_from_zero(bench):
    start(bench, 3, ENABLE | HCLK)
    values = [peek(bench.timer, "VAL")]
    for _ in range(9):
        bench.advance(1)
        values.append(peek(bench.timer, "VAL"))
    assert values == [0, 3, 2, 1, 0, 3, 2, 1, 0, 3]


def test_countflag_is_set_at_zero_and_cleared_by_reading(bench):
    start(bench, 9, ENABLE | HCLK)
    bench.advance(9)
    assert peek(bench.timer, "CTRL") == ENABLE | HCLK
    bench.advance(1)
    assert peek(bench.timer, "CTRL") == ENABLE | HCLK | COUNTFLAG
    assert peek(bench.timer, "CTRL") == ENABLE | HCLK
    bench.advance(9)
    assert not peek(bench.timer, "CTRL") & COUNTFLAG
    bench.advance(1)
    assert peek(bench.timer, "CTRL") & COUNTFLAG
    assert not bench.pending


def test_a_byte_read_of_the_flag_clears_it_a_byte_write_does_not_disturb_it(bench):
    start(bench, 9, ENABLE | HCLK)
    bench.advance(10)
    bench.timer.write_part(0x10, 1, ENABLE | HCLK)
    assert bench.timer.read_part(0x12, 1) == 1
    assert bench.timer.read_part(0x12, 1) == 0


def test_writing_the_value_clears_it_and_the_flag_without_exception(bench):
    start(bench, 9, ENABLE | TICKINT | HCLK)
    bench.advance(10)
    assert bench.taken()
    bench.advance(4)
    poke(bench.timer, "VAL", 1234)
    assert peek(bench.timer, "VAL") == 0
    assert not peek(bench.timer, "CTRL") & COUNTFLAG
    assert not bench.pending
    bench.advance(9)
    assert not bench.pending
    bench.advance(1)
    assert bench.pending


def test_load_takes_effect_at_the_next_reload(bench):
    start(bench, 9, ENABLE | TICKINT | HCLK)
    bench.advance(3)
    poke(bench.timer, "LOAD", 99)
    assert peek(bench.timer, "VAL") == 7
    bench.advance(7)
    assert bench.taken()
    bench.advance(99)
    assert not bench.pending
    bench.advance(1)
    assert bench.pending


def test_load_zero_stops_at_the_next_zero(bench):
    start(bench, 9, ENABLE | TICKINT | HCLK)
    bench.advance(3)
    poke(bench.timer, "LOAD", 0)
    bench.advance(7)
    assert bench.taken()
    bench.advance(1000)
    assert not bench.pending
    assert peek(bench.timer, "VAL") == 0
    assert bench.next_cycle is None


def test_a_load_written_in_the_cycle_of_the_clearing_comes_after_the_reload(bench):
    """LOAD = v, VAL = 0, LOAD = 0: one tick in v + 1 cycles, also where the stores take no cycle of their own."""
    start(bench, 0, ENABLE | TICKINT | HCLK)
    bench.advance(20)
    for value in (9, 99):
        poke(bench.timer, "LOAD", value)
        poke(bench.timer, "VAL", 0)
        poke(bench.timer, "LOAD", 0)
        assert bench.timer.count(0x18) is None
        bench.advance(1)
        assert peek(bench.timer, "VAL") == bench.timer.count(0x18).value == value
        bench.advance(value - 1)
        assert not bench.pending
        bench.advance(1)
        assert bench.taken()
        bench.advance(1000)
        assert peek(bench.timer, "VAL") == 0
        assert not bench.pending


def test_on_the_reference_clock_the_reload_comes_with_its_next_edge_and_finds_the_last_load(bench):
    start(bench, 9, ENABLE | TICKINT)
    poke(bench.timer, "LOAD", 0)
    bench.advance(1000)
    assert peek(bench.timer, "VAL") == 0
    assert not bench.pending


@pytest.mark.parametrize("apart", [0, 1, 5])
def test_a_load_written_in_the_cycle_of_the_start_comes_after_the_reload(bench, apart):
    poke(bench.timer, "LOAD", 9)
    poke(bench.timer, "VAL", 0)
    bench.advance(apart)
    poke(bench.timer, "CTRL", ENABLE | TICKINT | HCLK)
    poke(bench.timer, "LOAD", 0)
    bench.advance(9)
    assert not bench.pending
    bench.advance(1)
    assert bench.taken()


def test_a_load_for_a_counter_that_found_zero_takes_effect_a_cycle_later(bench):
    start(bench, 0, ENABLE | TICKINT | HCLK)
    poke(bench.timer, "VAL", 0)
    poke(bench.timer, "LOAD", 5)
    poke(bench.timer, "LOAD", 7)
    values = []
    for _ in range(4):
        bench.advance(1)
        values.append(peek(bench.timer, "VAL"))
    assert values == [0, 7, 6, 5]
    assert not bench.pending


def test_stopping_keeps_the_value_and_starting_goes_on(bench):
    start(bench, 9, ENABLE | TICKINT | HCLK)
    bench.advance(4)
    poke(bench.timer, "CTRL", TICKINT | HCLK)
    bench.advance(1000)
    assert peek(bench.timer, "VAL") == 6
    assert not bench.pending
    poke(bench.timer, "CTRL", ENABLE | TICKINT | HCLK)
    bench.advance(5)
    assert not bench.pending
    bench.advance(1)
    assert bench.pending


def test_reference_clock_is_an_eighth(bench):
    start(bench, 8_999, ENABLE | TICKINT)
    bench.advance(71_999)
    assert not bench.pending
    assert peek(bench.timer, "VAL") == 1
    bench.advance(1)
    assert bench.taken()
    bench.advance(72_000)
    assert bench.taken()


def test_calibration_is_a_millisecond_of_the_reference_clock(bench):
    calibration = peek(bench.timer, "CALIB")
    assert calibration & 0xFF_FFFF == 9000
    assert not calibration >> 31


def test_nothing_is_entered_that_nobody_could_notice(bench):
    start(bench, 1, ENABLE | HCLK)
    bench.advance(2)
    assert bench.next_cycle is None
    assert peek(bench.timer, "CTRL") & COUNTFLAG
    assert bench.next_cycle == 4


def test_an_access_that_comes_late_finds_the_tick_done(bench):
    """The instructions of an IT block are not interrupted by events; a later one of them must still see the zero."""
    start(bench, 9, ENABLE | TICKINT | HCLK)
    bench.engine.add_cycles(13)
    assert peek(bench.timer, "CTRL") & COUNTFLAG
    assert bench.taken()
    assert peek(bench.timer, "VAL") == 7
    bench.advance(7)
    assert bench.taken()


@pytest.mark.parametrize(
    ("register", "value"), [("CTRL", ENABLE | TICKINT | HCLK), ("CTRL", 0), ("LOAD", 99), ("VAL", 0)]
)
def test_a_store_that_comes_late_does_not_undo_the_tick(bench, register, value):
    start(bench, 9, ENABLE | TICKINT | HCLK)
    bench.engine.add_cycles(13)
    poke(bench.timer, register, value)
    assert bench.pending
    assert bool(peek(bench.timer, "CTRL") & COUNTFLAG) is (register != "VAL")


@pytest.mark.parametrize("load", [5, 6, 7, 300])
def test_a_run_ends_where_the_timer_that_it_has_started_comes_to_zero(bench, load):
    engine, flash = bench.engine, bytearray(struct.pack("<2H", 0x6008, 0xE7FE))  # str r0, [r1]; b .
    engine.map_memory(0x0800_0000, flash, writable=False)
    engine.map_registers(0xE000_E000, 0x1000, Access(lambda _offset, _size: 0, lambda _offset, _size, _value: None))
    start(bench, load, 0)
    for register, content in (
        (Reg.XPSR, 1 << 24),
        (Reg.PC, 0x0800_0000),
        (Reg.R0, ENABLE | HCLK),
        (Reg.R1, 0xE000_E010),
    ):
        engine.set(register, content)
    assert engine.run(1 << 40).kind is StopKind.LIMIT
    assert engine.alarm == load + 1
    assert load < engine.cycle <= load + 3  # a branch takes three cycles


def test_reset(bench):
    start(bench, 9, ENABLE | TICKINT | HCLK)
    bench.advance(4)
    bench.timer.reset()
    assert [peek(bench.timer, name) for name in ("CTRL", "LOAD", "VAL")] == [0, 0, 0]
    bench.advance(1000)
    assert not bench.pending


class Stepper:
    """The counter of section B3.3, one cycle at a time."""

    def __init__(self):
        self.control = self.load = self.value = self.flag = self.pending = self.cycle = 0
        self.cleared = self.reloaded = False  # in this cycle

    def clear(self):
        self.value = self.flag = 0
        self.cleared, self.reloaded = True, False

    def set_load(self, value):
        if self.cleared and self.control & ENABLE and self.control & HCLK:
            self.value, self.reloaded = self.load, True
        self.cleared = False
        self.load = value

    def step(self):
        self.cycle += 1
        reloaded, self.cleared, self.reloaded = self.reloaded, False, False
        if reloaded or not self.control & ENABLE or (not self.control & HCLK and self.cycle % 8):
            return
        if self.value:
            self.value -= 1
            if not self.value:
                self.flag = COUNTFLAG
                self.pending |= self.control & TICKINT
        else:
            self.value = self.load


actions = st.one_of(
    st.tuples(st.just("wait"), st.integers(1, 60)),
    st.tuples(st.just("load"), st.integers(0, 12)),
    st.tuples(st.just("control"), st.integers(0, 7)),
    st.tuples(st.just("value"), st.integers(0, 9)),
    st.tuples(st.just("one shot"), st.integers(0, 12)),
    st.tuples(st.just("read control"), st.just(0)),
    st.tuples(st.just("take"), st.just(0)),
)


@given(st.lists(actions, max_size=40))
@example([("control", ENABLE | TICKINT | HCLK), ("one shot", 5), ("wait", 4), ("wait", 1), ("wait", 1), ("wait", 60)])
def test_as_the_stepper(steps):
    bench, model = Bench(), Stepper()
    for action, argument in steps:
        if action == "wait":
            bench.advance(argument)
            for _ in range(argument):
                model.step()
        elif action == "load":
            poke(bench.timer, "LOAD", argument)
            model.set_load(argument)
        elif action == "control":
            poke(bench.timer, "CTRL", argument)
            model.control = argument
        elif action == "value":
            poke(bench.timer, "VAL", argument)
            model.clear()
        elif action == "one shot":
            start(bench, argument, bench.engine.systick.ctrl)
            poke(bench.timer, "LOAD", 0)
            model.set_load(argument)
            model.clear()
            model.set_load(0)
        elif action == "read control":
            assert peek(bench.timer, "CTRL") == model.control | model.flag
            model.flag = 0
        else:
            assert bench.taken() == bool(model.pending)
            model.pending = 0
        assert peek(bench.timer, "VAL") == model.value
        assert bench.pending == bool(model.pending)
