"""The driver: its truth table, exact means of pulses of any length, drops by the data sheet, currents."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.parts import Ports
from targets.parts.l298n import L298n, L298nOverload, L298nSettings, bridge_shares
from targets.parts.testing import PartBench, Wire
from tests.each import each

MS = 1_000_000
STEP_NS = 4_166_667
SUPPLY_V = 8.4
NO_DROP = L298nSettings(drop_1a_v=0.0, drop_2a_v=0.0, own_current_a=0.0)
DROP_0_A = 2.55 - 1.15
"""The straight line through the two typical points, at no current."""


@pytest.fixture
def driver():
    """A driver between wires; `loads` are its motors' currents."""

    class Made:
        def __init__(self, settings):
            self.values = {"supply": SUPPLY_V}
            self.bench = PartBench(L298n, settings, quantities=lambda _ns: self.values, step_ns=STEP_NS)

        def put(self, **levels):
            for name, level in levels.items():
                self.bench.wires[name].set(bool(level), self.bench.now_ns)
            return self

        def out(self, steps=2):
            self.bench.run_to(self.bench.now_ns + steps * STEP_NS)
            return self.bench.quantities_out

    return lambda settings=NO_DROP: Made(settings)


@each(
    ("enable", "first", "second", "volts", "closed"),
    [
        (0, 0, 0, 0.0, 0.0),
        (0, 1, 0, 0.0, 0.0),
        (0, 0, 1, 0.0, 0.0),
        (0, 1, 1, 0.0, 0.0),
        (1, 0, 0, 0.0, 1.0),
        (1, 1, 1, 0.0, 1.0),
        (1, 1, 0, SUPPLY_V, 1.0),
        (1, 0, 1, -SUPPLY_V, 1.0),
    ],
)
def test_truth_table_of_both_channels(driver, enable, first, second, volts, closed):
    out = driver().put(ena=enable, in1=first, in2=second).out()
    assert (out["out_a"], out["closed_a"], out["out_b"], out["closed_b"]) == (volts, closed, 0.0, 0.0)
    out = driver().put(enb=enable, in3=first, in4=second).out()
    assert (out["out_b"], out["closed_b"], out["out_a"], out["closed_a"]) == (volts, closed, 0.0, 0.0)


def test_nothing_is_known_before_the_first_slice(driver):
    out = driver().put(ena=1, in1=1).out(steps=0)
    assert (out["out_a"], out["closed_a"]) == (SUPPLY_V, 1.0)  # the levels at power-on
    made = driver()
    made.bench.run_to(0)
    assert made.bench.quantities_out["closed_a"] == 0.0


def pulses(wire, period_ns, high_ns, until_ns):
    for start_ns in range(0, until_ns, period_ns):
        wire.set(True, start_ns)
        wire.set(False, start_ns + high_ns)


@each("period_ns", [20 * MS, 50_000, 3 * MS])
@each("duty", [0.1, 0.25, 0.5, 0.9])
def test_pulses_on_the_enable_add_up_whatever_their_period(driver, period_ns, duty):
    """At 50 Hz a pulse is longer than a step, so that one slice is all on and the next all off; the sum is exact."""
    made = driver().put(in1=1)
    pulses(made.bench.wires["ena"], period_ns, round(duty * period_ns), 300 * MS)
    total_v, total = 0.0, 0.0
    steps = 48
    made.out(steps=1)
    for _ in range(steps):
        out = made.out(steps=1)
        total_v += out["out_a"] / steps
        total += out["closed_a"] / steps
    assert total_v == pytest.approx(SUPPLY_V * duty, abs=SUPPLY_V * period_ns / (steps * STEP_NS))
    assert total == pytest.approx(total_v / SUPPLY_V)


def wire_of(edges):
    wire = Wire()
    for ns, level in sorted(edges.items()):
        wire.set(level, ns)
    wire.now_ns = 10_000
    return wire


EDGES = st.dictionaries(st.integers(0, 1_000), st.booleans(), max_size=8)


@given(EDGES, EDGES, EDGES, st.lists(st.integers(1, 999), max_size=6))
def test_shares_are_exact_and_do_not_depend_on_the_cuts(enable, first, second, cuts):
    wires = wire_of(enable), wire_of(first), wire_of(second)
    expected = {"forward": 0, "backward": 0, "brake": 0}
    for ns in range(1_000):
        on, one, two = (wire.level_at(ns) for wire in wires)
        if on:
            expected["brake" if one is two else "forward" if one else "backward"] += 1
    whole = bridge_shares(*wires, 0, 1_000)
    assert {name: getattr(whole, name) * 1_000 for name in expected} == pytest.approx(expected)
    ends = sorted({0, 1_000, *cuts})
    for name, total in expected.items():
        pieces = [
            getattr(bridge_shares(*wires, start, end), name) * (end - start) for start, end in itertools.pairwise(ends)
        ]
        assert sum(pieces) == pytest.approx(total)


@each(("load_a", "drop_v"), [(0.0, DROP_0_A), (0.5, 1.975), (1.0, 2.55), (2.0, 3.70)])
def test_the_drop_is_the_data_sheet_s(driver, load_a, drop_v):
    made = driver(L298nSettings()).put(ena=1, in1=1)
    made.values |= {"load_a1": load_a / 2, "load_a2": load_a / 2}
    assert made.out(steps=40)["out_a"] == pytest.approx(SUPPLY_V - drop_v, abs=1e-6)


def test_the_drop_counts_backward_as_well(driver):
    assert driver(L298nSettings()).put(ena=1, in2=1).out()["out_a"] == pytest.approx(-(SUPPLY_V - DROP_0_A))


def test_a_supply_that_is_below_the_drop_gives_nothing(driver):
    made = driver(L298nSettings()).put(ena=1, in1=1)
    made.values["supply"] = 1.0
    assert made.out()["out_a"] == 0.0


def test_a_supply_sags_by_the_currents_of_both_channels(driver):
    made = driver(L298nSettings(drop_1a_v=0.0, drop_2a_v=0.0, own_current_a=0.1)).put(ena=1, in1=1, enb=1, in4=1)
    made.values |= {"source": 0.5, "load_a1": 1.0, "load_b1": 0.6}
    assert made.out(steps=40)["out_a"] == pytest.approx(SUPPLY_V - 0.5 * (1.0 + 0.6 + 0.1), abs=1e-6)


def test_a_pulse_carries_more_than_the_mean(driver):
    """With a duty of a quarter a mean of 0.5 A is 2 A while it conducts, and the drop is that of 2 A."""
    made = driver(L298nSettings()).put(in1=1)
    pulses(made.bench.wires["ena"], 40_000, 10_000, 400 * MS)
    made.values["load_a1"] = 0.5
    assert made.out(steps=80)["out_a"] == pytest.approx((SUPPLY_V - 3.70) / 4, rel=0.01)


@each(("second", "drawn_a"), [(0, 0.8), (1, 0.0)])
def test_what_drives_comes_from_the_supply_and_what_brakes_does_not(driver, second, drawn_a):
    made = driver().put(ena=1, in1=1, in2=second)
    made.values |= {"load_a1": 0.5, "load_a2": 0.3}
    assert made.out(steps=3)["current"] == pytest.approx(drawn_a)


@each(("first", "drawn_a"), [(1, 0.0), (0, 0.5)])
def test_nothing_goes_back_into_the_supply(driver, first, drawn_a):
    made = driver().put(ena=1, in1=first, in2=1 - first)
    made.values["load_a1"] = -0.5
    assert made.out(steps=3)["current"] == pytest.approx(drawn_a)


def test_its_own_current_is_always_there(driver):
    assert driver(L298nSettings(own_current_a=0.04)).out()["current"] == pytest.approx(0.04)


def test_more_than_a_channel_may_carry_is_told_once(driver):
    made = driver().put(ena=1, in1=1)
    made.values["load_a1"] = 3.0
    made.out(steps=50)
    made.values["load_a1"] = 1.0
    made.out(steps=50)
    made.values["load_a1"] = 2.5
    made.out(steps=50)
    told = made.bench.told(L298nOverload)
    assert [event.channel for event in told] == ["a", "a"]
    assert all(event.current_a > 2.0 for event in told)


def test_without_wires_it_is_open():
    part = L298n(L298nSettings(), Ports(), seed=0)
    part.power_on(0)
    part.feed({"supply": 8.0})
    out = part.before_step(0, STEP_NS)
    assert {name: out[name] for name in ("out_a", "out_b", "closed_a", "closed_b")} == dict.fromkeys(
        ("out_a", "out_b", "closed_a", "closed_b"), 0.0
    )
