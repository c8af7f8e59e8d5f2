"""The arithmetic timer against the one that does every tick, with random settings written at random cycles."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from targets.mcu.services import Watch
from tests.share import examples

SMALL = st.integers(0, 12)
ENABLES = st.integers(0, 0x3FFF)


def modes_of(output_modes, *, inputs=False, preload=(0, 8)):
    byte = st.builds(
        lambda mode, buffered, extra: mode << 4 | buffered | extra,
        st.sampled_from(output_modes),
        st.sampled_from(preload),
        st.sampled_from([0, 0, 0, 4, 0x80] if inputs else [0]),
    )
    if inputs:
        byte = st.one_of(
            byte, st.builds(lambda select, every: every << 2 | select, st.integers(1, 3), st.integers(0, 2))
        )
    return st.builds(lambda low, high: low | high << 8, byte, byte)


CR1 = st.builds(
    lambda run, bits, alignment: run | bits | alignment << 5,
    st.sampled_from([1, 1, 1, 0]),
    st.sampled_from([0, 0, 0, 0x80, 0x80, 0x10, 0x90, 2, 4, 8, 0x100, 0x200]),
    st.sampled_from([0, 0, 0, 1, 2, 3]),
)
BASE = [
    st.tuples(st.just("CR1"), CR1),
    st.tuples(st.just("ARR"), SMALL),
    st.tuples(st.just("PSC"), st.integers(0, 3)),
    st.tuples(st.just("RCR"), st.integers(0, 3)),
    st.tuples(st.just("CNT"), st.one_of(SMALL, st.integers(0xFFF8, 0xFFFF))),
    st.tuples(st.just("EGR"), st.sampled_from([1, 1, 1, 2, 0x1E, 0x1F])),
    st.tuples(st.just("SR"), st.one_of(st.just(0), st.integers(0, 0xFFFF))),
    st.tuples(st.just("DIER"), st.integers(0, 0x7FFF)),
    *[st.tuples(st.just(f"CCR{number}"), SMALL) for number in range(1, 5)],
]
OUTPUTS = [
    st.tuples(st.just("CCMR1"), modes_of(range(8))),
    st.tuples(st.just("CCMR2"), modes_of([6, 6, 7, 3])),
    st.tuples(st.just("CCER"), ENABLES),
]
ADVANCED = [
    *OUTPUTS,
    st.tuples(
        st.just("BDTR"), st.builds(lambda dead, bits: dead | bits << 10, st.integers(0, 9), st.integers(0, 0x3F))
    ),
    st.tuples(
        st.just("CR2"), st.builds(lambda idle, low: idle << 8 | low, st.integers(0, 0x7F), st.sampled_from([0, 1, 8]))
    ),
    st.tuples(st.just("EGR"), st.sampled_from([1, 0x20, 0x80])),
    st.tuples(st.just("BKIN"), st.booleans()),
]
INPUTS = [
    st.tuples(st.just("CCMR1"), modes_of([0, 6, 7], inputs=True)),
    st.tuples(st.just("CCMR2"), modes_of([0, 6, 3], inputs=True)),
    st.tuples(st.just("CCER"), st.one_of(st.just(0), ENABLES)),
    st.tuples(
        st.just("SMCR"),
        st.builds(
            lambda mode, trigger, bits: mode | trigger << 4 | bits,
            st.integers(0, 7),
            st.integers(0, 7),
            st.sampled_from([0, 0, 0, 0x4000, 0x8000, 0xC000]),
        ),
    ),
    st.tuples(st.just("CR2"), st.sampled_from([0, 0x20, 0x30, 0x80, 0xA0, 8])),
]
EDGES = [
    st.tuples(st.just(name), st.booleans()) for name in ("CH1", "CH1", "CH2", "CH2", "CH3", "CH4", "ETR", "ITR", "ITR")
]
LEVELS = ("CH1", "CH2", "CH3", "CH4", "ETR", "ITR", "BKIN")
READS = [st.tuples(st.just("read"), st.sampled_from(["CNT", "SR", "CR1", "CCR1", "CCR2", "CCR3", "CCR4"]))]


def steps_of(*kinds):
    """First a timer that is likely to run and to show something, then anything at all."""
    action = st.one_of(*[action for kind in kinds for action in kind])
    setup = st.tuples(
        st.tuples(st.just("ARR"), SMALL),
        st.tuples(st.just("CCR1"), SMALL),
        st.one_of(kinds[1]),
        st.one_of(kinds[1]),
        st.tuples(st.just("CR1"), CR1),
    ).map(lambda actions: [(0, action) for action in actions])
    gap = st.one_of(st.integers(0, 40), st.integers(0, 3))
    return st.builds(
        lambda first, rest: first + rest, setup, st.lists(st.tuples(gap, action), min_size=10, max_size=40)
    )


def play(bench, steps, look=lambda: None):
    for cycles, (what, value) in steps:
        bench.advance(cycles)
        if what == "read":
            bench.read(value)
        elif what in LEVELS:
            bench.drive(what, value)
        elif what == "clock":
            bench.change_clock(value)
        else:
            bench.write(what, value)
        look()
    bench.advance(80)
    bench.compare()


@settings(max_examples=examples(120))
@given(steps=steps_of(BASE, OUTPUTS, READS), divider=st.sampled_from([1, 1, 2]))
def test_registers_are_right_after_every_step(make_bench, steps, divider):
    bench = make_bench(divider=divider)
    play(bench, steps, bench.compare)
    bench.compare_log()
    bench.compare_edges()


@settings(max_examples=examples(120))
@given(steps=steps_of(BASE, OUTPUTS))
def test_registers_are_right_when_nobody_looks_in_between(make_bench, steps):
    bench = make_bench()
    for name in bench.OUTPUTS:
        bench.output(name).set_watch(Watch.NOBODY)
    play(bench, steps)
    bench.advance(2_000)
    bench.compare()
    bench.compare_outputs()
    bench.compare_log()


@settings(max_examples=examples(120))
@given(steps=steps_of(BASE, ADVANCED, READS), watch=st.sampled_from(list(Watch)))
def test_outputs_of_tim1(make_bench, steps, watch):
    bench = make_bench("TIM1")
    for name in bench.OUTPUTS:
        bench.output(name).set_watch(watch)
    play(bench, steps, bench.compare_outputs if watch is Watch.NOBODY else lambda: None)
    bench.compare_log()
    if watch is not Watch.NOBODY:
        bench.compare_edges()


WATCH = [st.tuples(st.just("watch"), st.tuples(st.integers(0, 6), st.sampled_from(list(Watch))))]
CLOCK = [st.tuples(st.just("clock"), st.integers(1, 3))]


@settings(max_examples=examples(120))
@given(steps=steps_of(BASE, OUTPUTS, WATCH), name=st.sampled_from(["TIM1", "TIM2"]))
def test_watching_changes_nothing_but_what_is_seen(make_bench, steps, name):
    bench = make_bench(name)
    for cycles, (what, value) in [(0, ("BDTR", 0x8003)), *steps]:
        bench.advance(cycles)
        if what == "watch":
            bench.output(bench.OUTPUTS[value[0]]).set_watch(value[1])
        else:
            bench.write(what, value)
        bench.compare()
        bench.compare_outputs()


@settings(max_examples=examples(120))
@given(steps=steps_of(BASE, ADVANCED, CLOCK), watch=st.sampled_from(list(Watch)))
def test_the_clock_may_change_at_any_time(make_bench, steps, watch):
    bench = make_bench("TIM1")
    for name in bench.OUTPUTS:
        bench.output(name).set_watch(watch)
    play(bench, steps)
    bench.compare_outputs()
    bench.compare_log()
    if watch is not Watch.NOBODY:
        bench.compare_edges()


@settings(max_examples=examples(120))
@given(steps=steps_of(BASE, INPUTS, EDGES, READS), name=st.sampled_from(["TIM1", "TIM2"]))
def test_inputs_triggers_and_captures(make_bench, steps, name):
    bench = make_bench(name)
    play(bench, steps, bench.compare)
    bench.compare_log()
    bench.compare_edges()


@settings(max_examples=examples(120))
@given(
    setup=st.tuples(st.integers(1, 3), st.integers(0, 3), st.integers(1, 20), st.integers(0, 1)),
    moves=st.lists(st.tuples(st.integers(0, 5), st.sampled_from(["CH1", "CH2"])), min_size=20, max_size=80),
)
def test_encoder(make_bench, setup, moves):
    mode, polarity, arr, psc = setup
    bench = make_bench()
    for register, value in (
        ("CCMR1", 0x0101),
        ("CCER", polarity & 1 << 1 | (polarity >> 1) << 5),
        ("SMCR", mode),
        ("ARR", arr),
        ("PSC", psc),
        ("EGR", 1),
        ("SR", 0),
        ("CR1", 1),
    ):
        bench.write(register, value)
    for cycles, name in moves:
        bench.advance(cycles)
        bench.drive(name, not bench.slow.level[name])
        bench.compare()
