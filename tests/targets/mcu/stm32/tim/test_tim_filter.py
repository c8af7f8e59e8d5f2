"""The input filters against one that takes every sample."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from targets.mcu.stm32.tim.inputs import Filter, TickClock
from targets.mcu.testing import FakeChip
from tests.each import each
from tests.share import examples

# RM0008, IC1F: by code, sampling period in tDTS (0: the timer's clock itself) and samples
CODES = {
    1: (0, 2), 2: (0, 4), 3: (0, 8), 4: (2, 6), 5: (2, 8), 6: (4, 6), 7: (4, 8), 8: (8, 6), 9: (8, 8),
    10: (16, 5), 11: (16, 6), 12: (16, 8), 13: (32, 5), 14: (32, 6), 15: (32, 8),
}  # fmt: skip


def sampled(changes, period, samples, end):
    """Return the edges behind the filter: at each sample, the run of samples that differ is counted.

    A sample takes the level from before its cycle.
    """
    out, run, edges, levels = False, 0, [], dict(changes)
    level = False
    for cycle in range(end + 1):
        level = levels.get(cycle - 1, level)
        if cycle % period == 0:
            run = run + 1 if level is not out else 0
            if run == samples:
                out, run = level, 0
                edges.append((cycle, out))
    return edges


@settings(max_examples=examples(200))
@given(
    code=st.sampled_from(sorted(CODES)), dts=st.sampled_from([1, 2, 4]), gaps=st.lists(st.integers(1, 80), max_size=40)
)
def test_every_sample(code, dts, gaps):
    chip = FakeChip()
    edges, changes, level = [], [], False
    period, samples = CODES[code]
    period = period * dts or 1
    filtered = Filter(chip.time, TickClock(chip.time), lambda high: edges.append((chip.time.now, high)))
    filtered.configure(code, dts)
    for gap in gaps:
        chip.advance(gap * max(1, period // 4))
        level = not level
        changes.append((chip.time.now, level))
        filtered.feed(level)
    chip.advance(10 * period)
    assert edges == sampled(changes, period, samples, chip.time.now)


def test_a_change_of_the_clock_times_the_samples_anew():
    chip = FakeChip()
    clock, edges = TickClock(chip.time), []
    filtered = Filter(chip.time, clock, lambda high: edges.append((chip.time.now, high)))
    filtered.configure(3, 1)
    chip.advance(10)
    filtered.feed(True)
    chip.advance(3)
    clock.change(10)
    filtered.replan()
    chip.advance(100)
    assert edges == [(13 + 10 * (18 - 13), True)]


def test_a_filter_that_is_changed_in_the_middle_begins_anew():
    chip = FakeChip()
    edges = []
    filtered = Filter(chip.time, TickClock(chip.time), lambda high: edges.append((chip.time.now, high)))
    filtered.configure(3, 1)
    chip.advance(10)
    filtered.feed(True)
    chip.advance(3)
    filtered.configure(1, 1)
    chip.advance(100)
    assert edges == [(15, True)]


@each(("code", "late"), [(0, 0), (1, 2), (2, 4), (3, 8), (15, 32 * 8)])
def test_a_filtered_capture_is_late_by_its_samples(make_timer, code, late):
    chip, timer = make_timer("TIM2")
    timer.write(0x18, 0x01 | code << 4)
    timer.write(0x20, 1)
    timer.write(0x00, 1)
    chip.advance(320)
    chip.input("TIM2_CH1").drive(True)
    chip.advance(late)
    assert timer.read(0x10) & 2
    assert timer.read(0x34) == 319 + late


def test_a_glitch_shorter_than_the_filter_is_not_seen(make_timer):
    chip, timer = make_timer("TIM2")
    timer.write(0x18, 0x01 | 3 << 4)
    timer.write(0x20, 1)
    for _ in range(10):
        chip.input("TIM2_CH1").drive(True)
        chip.advance(7)
        chip.input("TIM2_CH1").drive(False)
        chip.advance(1)
    chip.advance(100)
    assert not timer.read(0x10) & 2


@each("order", [0, 1])
@each("width", [7, 8, 9])
def test_the_order_of_events_at_a_cycle_does_not_matter(make_timer, order, width):
    chip, timer = make_timer("TIM2")
    timer.write(0x18, 0x01 | 3 << 4)
    timer.write(0x20, 1)
    pin = chip.input("TIM2_CH1")
    chip.time.at(20, lambda: pin.drive(True), order=order)
    chip.time.at(20 + width, lambda: pin.drive(False), order=order)
    chip.advance(100)
    assert timer.read(0x10) & 2 == 2 * (width >= 8)
