"""Ticks of a clock of its own, and what falls due at them."""

from __future__ import annotations

from fractions import Fraction

import pytest

from targets.mcu.stm32.ticks import Edges, Ticks
from targets.mcu.timebase import Timebase


@pytest.fixture
def time():
    return Timebase(1000)


def test_a_tick_that_is_under_way_keeps_its_part_when_the_rate_changes(time):
    rates = [Fraction(10)]
    ticks = Ticks(time, lambda: rates[0])
    ticks.refresh()
    happened = []
    ticks.at("later", 4, lambda: happened.append(time.now))
    time.run_due(250)  # two ticks and a half
    rates[0] = Fraction(100)
    ticks.refresh()
    assert ticks.now() == 2
    time.run_due(254)
    assert ticks.now() == 2
    time.run_due(255)
    assert ticks.now() == 3
    time.run_due(300)
    assert happened == [265]


def test_nothing_falls_due_while_the_clock_stands_still(time):
    rates: list[Fraction | None] = [None]
    ticks = Ticks(time, lambda: rates[0])
    happened = []
    ticks.after("later", 3, lambda: happened.append(time.now))
    time.run_due(1000)
    assert not ticks.runs
    rates[0] = Fraction(10)
    ticks.refresh()
    time.run_due(2000)
    assert happened == [1300]
    ticks.after("never", 1, lambda: happened.append(time.now))
    ticks.forget_all()
    time.run_due(3000)
    assert happened == [1300]


def test_edges_are_ticks():
    edges = Edges()
    happened = []
    edges.after("second", 2, lambda: happened.append(("second", edges.now())))
    edges.at("first", 1, lambda: happened.append(("first", edges.now())))
    edges.at("never", 3, lambda: happened.append(("never", edges.now())))
    for _ in range(2):
        edges.step()
    edges.forget("never")
    edges.step()
    assert happened == [("first", 1), ("second", 2)]
