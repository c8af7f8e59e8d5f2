"""That an uncertainty comes of times is not lost on the way into a figure of another unit."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.bench import Bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.judging.uncertainty import OfTimes
from hilbench.testing import FakeHostClock
from tests.each import each

figures = st.floats(0.001, 1000)


@given(figures, figures)
def test_what_is_made_of_it_is_of_times_too(doubt_s, factor):
    made = (
        (OfTimes(doubt_s) * factor, doubt_s * factor),
        (factor * OfTimes(doubt_s), factor * doubt_s),
        (OfTimes(doubt_s) / factor, doubt_s / factor),
        (OfTimes(doubt_s) + factor, doubt_s + factor),
        (factor + OfTimes(doubt_s), factor + doubt_s),
        (sum([OfTimes(doubt_s), factor]), doubt_s + factor),
        (3 * OfTimes(doubt_s), 3 * doubt_s),
        (OfTimes(doubt_s) - factor, doubt_s - factor),
        (factor - OfTimes(doubt_s), factor - doubt_s),
        (abs(-OfTimes(doubt_s)), doubt_s),
    )
    for found, expected in made:
        assert isinstance(found, OfTimes)
        assert found == expected


@given(figures, figures)
def test_what_is_divided_by_it_is_not(doubt_s, factor):
    assert not isinstance(factor / OfTimes(doubt_s), OfTimes)
    assert factor / OfTimes(doubt_s) == factor / doubt_s


@each("other", ["x", None])
def test_it_is_made_with_numbers_alone(other):
    for made in (lambda: OfTimes(1) + other, lambda: OfTimes(1) / other, lambda: other + OfTimes(1)):
        with pytest.raises(TypeError):
            made()


def test_that_of_a_bench_is_of_times():
    bench = Bench(Scheduler(), Journal())
    assert bench.uncertainty_s(0) == 0
    bench.scheduler.lock(FakeHostClock())
    assert isinstance(bench.uncertainty_s(0), OfTimes)
    assert bench.uncertainty_s(0) > 0
    bench.scheduler.unlock()
