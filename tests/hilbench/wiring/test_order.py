"""Who acts before whom within a step, and how late feedback is."""

from __future__ import annotations

import itertools
from functools import partial

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.benchfile.bench_file import PartPlan, QuantityEnd
from hilbench.benchfile.order import CircleError, order_of
from hilbench.mcu import parts as wiring
from hilbench.mcu.parts import Parts
from targets.parts import Direction, Part, Quantity
from tests.each import each


class Adder(Part):
    """Gives one more than what it takes; `late` is what it took late."""

    QUANTITIES = (
        Quantity(name="a", direction=Direction.IN, unit="1", needed=False),
        Quantity(name="back", direction=Direction.IN, unit="1", needed=False, late=True),
        Quantity(name="sum", direction=Direction.OUT, unit="1", needed=False),
    )

    def __init__(self, settings, ports, *, seed):
        self.values, self.seen = {}, []

    def feed(self, values):
        self.values = dict(values)

    def before_step(self, from_ns, to_ns):
        return {"sum": self.values.get("a", 0.0) + 1.0}

    def after_step(self, from_ns, to_ns, before, after):
        self.seen.append((dict(before), dict(after)))


class NoSignals:
    def __init__(self, _body, wanted):
        self.driven = []

    def read(self):
        return {}

    def drive(self, name, value):
        self.driven.append((name, value))


class Runner:
    def __init__(self):
        self.before, self.after = [], []

    def step(self):
        for act in (*self.before, *self.after):
            act(10, 20)


def plan(**sources):
    ends = {name: QuantityEnd(part=part, quantity="sum") for name, part in sources.items()}
    return PartPlan(kind="adder", settings=None, sources=ends)


@pytest.fixture
def alive(bench, monkeypatch):
    monkeypatch.setattr(wiring, "part_class", lambda _kind: Adder)

    def make(plans):
        parts, runner = Parts(bench, plans, {}, [], seed=1), Runner()
        parts.join(runner, partial(NoSignals, None))
        parts.power_on()
        return parts.by_name, runner

    return make


def kinds(plans):
    return dict.fromkeys(plans, Adder)


def test_who_gives_comes_before_who_takes_and_else_the_file_s_order_holds():
    plans = {"c": plan(a="b"), "x": plan(), "b": plan(a="a"), "a": plan()}
    assert order_of(plans, kinds(plans)) == ("a", "b", "c", "x")


def test_what_is_taken_late_asks_for_no_order():
    plans = {"a": plan(back="b"), "b": plan(a="a")}
    assert order_of(plans, kinds(plans)) == ("a", "b")


@each(
    ("plans", "names"),
    [
        ({"a": plan(a="a")}, ["a"]),
        ({"a": plan(a="b"), "b": plan(a="a")}, ["a", "b"]),
        ({"x": plan(a="a"), "a": plan(a="b"), "b": plan(a="c"), "c": plan(a="a")}, ["a", "b", "c"]),
    ],
)
def test_parts_that_wait_for_each_other_are_named(plans, names):
    with pytest.raises(CircleError) as caught:
        order_of(plans, kinds(plans))
    assert caught.value.names == names


@given(st.permutations("abcdef"))
def test_any_order_of_a_chain_in_the_file_gives_the_same_order(names):
    chain = {one: plan(a=other) for other, one in itertools.pairwise("abcdef")} | {"a": plan()}
    plans = {name: chain[name] for name in names}
    assert order_of(plans, kinds(plans)) == tuple("abcdef")


def test_a_value_goes_through_the_whole_chain_within_one_step(alive):
    parts, runner = alive({"c": plan(a="b"), "b": plan(a="a"), "a": plan()})
    runner.step()
    assert parts["c"].values == {"a": 2.0}
    assert parts["c"].seen == [({"a": 2.0}, {"a": 2.0})]


def test_feedback_is_that_of_the_step_before_and_nothing_at_first(alive):
    parts, runner = alive({"a": plan(back="b"), "b": plan(a="a")})
    taken = []
    for _ in range(3):
        runner.step()
        taken.append(parts["a"].values["back"])
    assert taken == [0.0, 2.0, 2.0]
