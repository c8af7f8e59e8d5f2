"""What a part learns of a pin whose chip runs ahead of the bench, and when what it drives is there."""

from __future__ import annotations

import math

from hypothesis import given
from hypothesis import strategies as st

from hilbench.bench import Bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.mcu.terminals import AnalogPinOutput, PinInput, PinOutput
from targets.parts.part import HISTORY_NS
from tests.each import each

MS = 1_000_000


def test_a_level_is_that_of_its_time_and_at_an_edge_the_new_one(bench, pin):
    wire = pin(level=False)
    terminal = PinInput(bench, wire)
    wire.edge(10, True)
    wire.edge(20, False)
    assert [terminal.level_at(ns) for ns in (0, 9, 10, 19, 20, 100)] == [False, False, True, True, False, False]


def test_edges_of_a_chip_that_is_ahead_are_not_seen_yet(bench, pin):
    wire = pin(level=False)
    terminal = PinInput(bench, wire)
    wire.edge(5 * MS, True)
    assert not terminal.level()
    bench.run_for(0.005)
    assert terminal.level()


def test_the_level_before_the_first_edge_is_the_one_it_began_with(bench, pin):
    terminal = PinInput(bench, pin(level=True))
    assert terminal.level_at(0)
    assert terminal.mean(0, 1000) == 1.0


def test_a_pin_that_floats_reads_low(bench, pin):
    wire = pin(level=None)
    terminal = PinInput(bench, wire)
    assert not terminal.level()
    wire.edge(10, True)
    wire.edge(20, None)
    assert not terminal.level_at(30)


def test_the_latch_is_what_the_pin_s_is(bench, pin):
    wire = pin()
    wire.latch = True
    assert PinInput(bench, wire).latch()


def test_the_mean_counts_only_what_lies_in_its_span(bench, pin):
    wire = pin(level=False)
    terminal = PinInput(bench, wire)
    wire.edge(100, True)
    wire.edge(400, False)
    assert terminal.mean(0, 400) == 0.75
    assert terminal.mean(200, 600) == 0.5
    assert terminal.mean(100, 400) == 1.0
    assert terminal.mean(400, 500) == 0.0
    assert terminal.mean(250, 250) == 1.0
    assert terminal.mean(400, 400) == 0.0


@given(
    edges=st.lists(st.tuples(st.integers(1, 1000), st.sampled_from([True, False, None])), max_size=12),
    span=st.tuples(st.integers(0, 1000), st.integers(1, 1000)),
)
def test_the_mean_is_that_of_all_instants(pin, edges, span):
    wire = pin(level=False)
    terminal = PinInput(Bench(Scheduler(), Journal()), wire)
    ordered = sorted(edges, key=lambda edge: edge[0])
    for ns, level in ordered:
        wire.edge(ns, level)
    from_ns, to_ns = span[0], span[0] + span[1]
    expected = sum(terminal.level_at(ns) for ns in range(from_ns, to_ns)) / (to_ns - from_ns)
    assert math.isclose(terminal.mean(from_ns, to_ns), expected, abs_tol=1e-12)


def test_the_past_is_kept_as_long_as_parts_may_ask(bench, pin):
    wire = pin(level=False)
    terminal = PinInput(bench, wire)
    wire.edge(1 * MS, True)
    bench.run_for(HISTORY_NS / 1e9)
    wire.edge(HISTORY_NS, False)
    assert terminal.level_at(1 * MS)
    bench.run_for(HISTORY_NS / 1e9)
    wire.edge(2 * HISTORY_NS, True)
    wire.edge(2 * HISTORY_NS + 1, False)
    assert [terminal.level_at(ns) for ns in (2 * HISTORY_NS - 1, 2 * HISTORY_NS)] == [False, True]


def test_many_edges_cost_no_more_than_the_history(bench, pin):
    wire = pin(level=False)
    terminal = PinInput(bench, wire)
    for number in range(1000):
        bench.run_for(0.001)
        wire.edge(bench.now_ns, number % 2 == 0)
    assert len(terminal._edges) <= HISTORY_NS // MS + 2


def test_what_is_driven_reaches_the_chip_at_its_time(machine):
    chip = machine(PA4=None)
    output = PinOutput(chip, chip.chip.pins["PA4"])
    output.set(False, 0)
    output.set(True, 1500)
    output.set(None, 2500)
    assert chip.chip.pins["PA4"].driven == []
    chip.run()
    assert chip.done == [0, 1500, 2500]
    assert chip.chip.pins["PA4"].driven == [False, True, None]


@each("level", [False, True, None])
def test_what_does_not_change_is_not_put_into_the_chip_again(machine, level):
    chip = machine(PA4=None)
    output = PinOutput(chip, chip.chip.pins["PA4"])
    output.set(not level, 0)
    output.set(level, 5)
    output.set(level, 10)
    chip.run()
    assert chip.done == [0, 5]


@given(
    edges=st.lists(st.tuples(st.integers(0, 100), st.booleans()), max_size=12),
    one_ns=st.integers(0, 100),
    other_ns=st.integers(0, 100),
)
def test_changes_lead_from_one_level_to_the_other(pin, edges, one_ns, other_ns):
    wire = pin(level=False)
    terminal = PinInput(Bench(Scheduler(), Journal()), wire)
    for ns, level in sorted(edges, key=lambda edge: edge[0]):
        wire.edge(ns, level)
    from_ns, to_ns = sorted((one_ns, other_ns))
    changes = terminal.changes(from_ns, to_ns)
    assert changes == sorted(changes, key=lambda change: change[0])
    assert all(from_ns < ns <= to_ns for ns, _ in changes)
    assert len(changes) == sum(from_ns < ns <= to_ns for ns, _ in edges)
    assert terminal.level_at(to_ns) is ([terminal.level_at(from_ns)] + [level for _, level in changes])[-1]


def test_the_voltage_of_a_wire_is_that_of_the_bench_s_present_and_the_chip_is_not_asked(bench, machine):
    chip = machine(PA4=None)
    output = AnalogPinOutput(bench, chip, chip.chip.pins["PA4"])
    assert output.volts is None
    output.put(1.0, 0)
    output.put(2.0, 2 * MS)
    output.put(3.0, 3 * MS)
    seen = [output.volts]
    for _ in range(4):
        bench.run_for(0.001)
        seen.append(output.volts)
    assert seen == [1.0, 1.0, 2.0, 3.0, 3.0]
    assert chip.done == []
    assert chip.chip.pins["PA4"].volts == []


def test_what_was_put_on_a_wire_long_ago_is_forgotten_though_nobody_looks(bench, machine):
    chip = machine(PA4=None)
    output = AnalogPinOutput(bench, chip, chip.chip.pins["PA4"])
    for number in range(1000):
        bench.run_for(0.001)
        output.put(number / 1000, bench.now_ns)
    assert len(output._put) <= 2
    assert output.volts == 0.999
