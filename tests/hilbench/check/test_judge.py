"""A measured figure against a limit: the interval decides."""

from __future__ import annotations

import math
import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.check import CaseResult, Inconclusive, Verdict, Violation, at_least, at_most, near, within
from hilbench.check.results import tightest_margins, worst_margin
from hilbench.judging.recorder import Recorded, recording, unrecorded
from tests.each import each

figures = st.floats(-1e6, 1e6)
doubts = st.floats(0, 1e6)


def verdict(judge, *args, **more):
    try:
        judge(*args, unit="s", what="stop", **more)
    except Violation:
        return "fail"
    except Inconclusive:
        return "inconclusive"
    return "pass"


@given(figures, figures, doubts)
def test_at_most_agrees_with_every_true_value_the_interval_allows(value, limit, doubt):
    lowest, highest = value - doubt, value + doubt
    expected = "pass" if highest <= limit else "fail" if lowest > limit else "inconclusive"
    assert verdict(at_most, value, limit, uncertainty=doubt) == expected


@given(figures, figures, doubts)
def test_at_least_is_the_mirror_image(value, limit, doubt):
    assert verdict(at_least, value, limit, uncertainty=doubt) == verdict(at_most, -value, -limit, uncertainty=doubt)


@given(figures, figures, st.floats(0, 1e6), doubts)
def test_within_is_the_worse_of_both_sides(value, low, width, doubt):
    high = low + width
    both = {verdict(at_least, value, low, uncertainty=doubt), verdict(at_most, value, high, uncertainty=doubt)}
    worst = next(word for word in ("fail", "inconclusive", "pass") if word in both)
    assert verdict(within, value, low, high, uncertainty=doubt) == worst


@given(figures, figures)
def test_without_uncertainty_nothing_is_inconclusive(value, limit):
    assert verdict(at_most, value, limit) == ("pass" if value <= limit else "fail")


def test_the_sentence_has_figure_uncertainty_unit_and_limit():
    with pytest.raises(Violation, match=r"^stop: 2\.31 ± 0\.01 s, required at most 2\.1 s$"):
        at_most(2.31, 2.1, uncertainty=0.01, unit="s", what="stop")


def test_a_bench_coarser_than_the_tolerance_says_so():
    with pytest.raises(Inconclusive, match=r"cannot resolve a tolerance of ± 0\.1 s"):
        near(2.0, 2.0, 0.1, uncertainty=0.2, unit="s", what="stop")


@each("doubt", [math.nan, -0.1])
def test_what_is_no_measurement_is_refused(doubt):
    with pytest.raises(ValueError, match="not a measurement"):
        at_most(1.0, 1.0, uncertainty=doubt, unit="s", what="stop")


@each("judge", [at_most, at_least])
def test_a_figure_of_a_target_that_is_no_number_is_a_violation(judge):
    with pytest.raises(Violation, match="throttle A: it is no number"):
        judge(math.nan, 1.0, unit="of full", what="throttle A")


def test_limits_the_wrong_way_round_are_refused():
    with pytest.raises(ValueError, match="above the upper limit"):
        within(1.0, 2.0, 1.0, unit="s", what="stop")


def test_every_figure_is_recorded_with_its_margin_also_when_it_fails():
    with recording() as recorded:
        within(3.0, 1.0, 4.0, unit="s", what="a")
        with pytest.raises(Violation):
            at_most(3.0, 2.0, unit="s", what="b", clause="X1")
    assert [(measure.name, measure.margin) for measure in recorded.measures] == [("a", 1.0), ("b", -1.0)]
    assert not at_most(1.0, 2.0, unit="s", what="outside a case").margin < 0
    assert len(recorded.measures) == 2


def test_a_figure_that_is_about_one_clause_is_the_margin_of_no_other():
    with recording() as recorded:
        at_most(1.9, 2.0, unit="s", what="one", clause="X1")
        at_most(1.0, 2.0, unit="s", what="all")
    result = CaseResult(
        id="s/c",
        suite="s",
        clause_ids=("X1", "X2"),
        verdict=Verdict.PASS,
        cause="",
        measures=tuple(recorded.measures),
        seed=0,
    )
    assert [worst_margin([result], clause).name for clause in ("X1", "X2")] == ["one", "all"]
    assert tightest_margins([result])[0].clause_ids == ("X1",)


def test_a_case_goes_on_behind_a_point_that_cannot_be_told():
    with recording() as recorded:
        at_most(2.0, 2.0, uncertainty=0.1, unit="s", what="stop")
        at_most(1.0, 2.0, unit="s", what="turn")
    assert [str(point) for point in recorded.unclear] == [
        "stop: 2 ± 0.1 s, required at most 2 s: the limit lies within the uncertainty"
    ]
    assert [measure.name for measure in recorded.measures] == ["stop", "turn"]


def test_steps_that_only_lead_somewhere_leave_no_point_open():
    with recording() as recorded, unrecorded():
        at_most(2.0, 2.0, uncertainty=0.1, unit="s", what="stop")
    assert recorded == Recorded()


UNCLEAR = 'at_most(2.0, 2.0, uncertainty=0.1, unit="s", what="stop")'


@pytest.mark.parametrize(
    ("behind", "verdict", "cause"),
    [
        ("pass", Verdict.INCONCLUSIVE, "stop: 2 ± 0.1 s, required at most 2 s: the limit lies within the uncertainty"),
        ('assert False, "it is red"', Verdict.FAIL, "it is red"),
        ('raise NotApplicable("no stop")', Verdict.NOT_APPLICABLE, "no stop"),
        ('raise RuntimeError("lost")', Verdict.ERROR, "lost"),
    ],
)
def test_what_comes_behind_such_a_point_counts(check, behind, verdict, cause):
    report = check(f'@my("A1")\ndef test_a(bench):\n    {UNCLEAR}\n    {UNCLEAR}\n    {behind}\n')
    (case,) = report.cases
    assert case.verdict is verdict
    assert cause in case.cause
    others = [line for line in case.evidence if line.startswith("cannot be judged either: stop: 2 ± 0.1 s")]
    assert len(others) == (1 if behind == "pass" else 2)
    assert len(case.measures) == 2


@each(
    ("value", "limit", "said"),
    [
        (0.207292, 0.2, "0.2073"),
        (0.00166667, 0.001, "0.001667"),
        (0.200002, 0.2, "0.200002"),
        (123456.7, 5.0, "123457"),
        (5.0, 2.0, "5"),
        (math.inf, 2.0, "inf"),
    ],
)
def test_a_figure_has_four_digits_or_as_many_as_tell_it_from_its_limit(value, limit, said):
    with pytest.raises(Violation, match=rf"^a wait: {re.escape(said)} s, required at most"):
        at_most(value, limit, unit="s", what="a wait")
