"""Rates with their certainty, levels from which on something fails, and margins."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.campaign.plots import plots_of
from hilbench.campaign.point import Clause, Figure, Outcome, Point
from hilbench.campaign.statistics import statistics, wilson
from hilbench.campaign.summary import lines_of


def result(verdict, level=0.0, *, clauses=(), figures=(), name="rate"):
    point = Point(bench="b", seed=0, levels={name: level})
    judged = tuple(Clause(id=clause, verdict=word, cause=f"{clause} {word}") for clause, word in clauses)
    measured = tuple(
        Figure(case="c", clause="X1", name="t", unit="s", value=v, low=lo, high=hi) for v, lo, hi in figures
    )
    return point, Outcome(verdict=verdict, exit_code=0, clauses=judged, figures=measured, bench_time_s=1.5)


def test_intervals_are_those_of_the_literature():
    # R. G. Newcombe, Two-sided confidence intervals for the single proportion, Statistics in Medicine 17 (1998)
    rows = {(81, 263): (0.2553, 0.3662), (15, 148): (0.0624, 0.1605), (0, 20): (0.0, 0.1611), (1, 29): (0.0061, 0.1718)}
    for (failed, tries), interval in rows.items():
        assert wilson(failed, tries) == pytest.approx(interval, abs=5e-5), (failed, tries)


@given(st.integers(1, 10_000), st.data())
def test_an_interval_holds_the_rate_and_mirrors(tries, data):
    failed = data.draw(st.integers(0, tries))
    low, high = wilson(failed, tries)
    assert 0 <= low <= failed / tries <= high <= 1
    mirrored_low, mirrored_high = wilson(tries - failed, tries)
    assert (low, high) == pytest.approx((1 - mirrored_high, 1 - mirrored_low))


def test_what_is_inconclusive_or_wrong_counts_for_no_rate():
    found = statistics([result(word) for word in ("pass", "fail", "inconclusive", "error")], ["rate"], 6)
    total = found.total
    assert (total.points, total.passed, total.failed, total.inconclusive, total.errors) == (4, 1, 1, 1, 1)
    assert total.rate == 0.5
    assert found.bench_time_s == 6.0
    first = next(iter(lines_of(found)))
    assert first == "6 points, 2 without a result: 1 pass, 1 fail, 1 inconclusive, 1 error; 6.0 s of bench time"


def test_nothing_judged_is_no_rate():
    found = statistics([result("inconclusive")], ["rate"], 1)
    assert (found.total.rate, found.total.low, found.total.high) == (None, 0.0, 1.0)


def test_a_clause_says_from_where_it_fails_and_up_to_where_it_never_did():
    rows = [(0.1, "pass"), (0.2, "pass"), (0.3, "fail"), (0.4, "pass"), (0.5, "fail")]
    found = statistics(
        [result(word, level, clauses=[("X1", word), ("X2", "pass")]) for level, word in rows], ["rate"], 5
    )
    (clause,) = found.clauses
    assert (clause.clause, clause.first_failing, clause.last_clean) == ("X1", {"rate": 0.3}, {"rate": 0.2})
    assert clause.cause == "X1 fail"
    assert "      first fails at rate = 0.3, never up to 0.2" in list(lines_of(found))


def test_one_that_fails_everywhere_was_clean_nowhere():
    found = statistics([result("fail", level, clauses=[("X1", "fail")]) for level in (1.0, 2.0)], ["rate"], 2)
    assert (found.clauses[0].first_failing, found.clauses[0].last_clean) == ({"rate": 1.0}, {})


def test_levels_in_words_stay_as_they_came():
    found = statistics([result("pass", "new"), result("fail", "old"), result("fail", "old")], ["rate"], 3)
    assert [(level.level, level.value, level.tally.points) for level in found.levels] == [
        ("new", None, 1),
        ("old", None, 2),
    ]
    assert found.clauses == ()


@given(st.lists(st.floats(0, 1), min_size=21, max_size=300))
def test_many_values_go_into_bins_and_none_is_lost(values):
    found = statistics([result("pass", value) for value in values], ["rate"], len(values))
    assert len(found.levels) <= 20
    assert sum(level.tally.points for level in found.levels) == len(values)


def test_margins_are_shares_of_the_tolerance_the_nearest_first():
    figures = [(9.0, None, 10.0), (5.0, None, 10.0), (11.0, None, 10.0), (4.0, 0.0, 10.0), (3.0, 0.0, None)]
    found = statistics([result("pass", figures=figures)], [], 1)
    (figure,) = found.figures
    assert (figure.count, figure.values[0], figure.values[2], figure.values[-1]) == (5, 3.0, 5.0, 11.0)
    # 0.1, 0.5, -0.1 and 0.8; a limit of 0 alone is no measure
    assert figure.margins == pytest.approx((-0.1, -0.07, 0.3, 0.755, 0.8))


def test_a_figure_without_a_limit_has_no_margin_and_comes_last():
    found = statistics([result("pass", figures=[(7.0, None, None)])], [], 1)
    assert [(one.values, one.margins) for one in found.figures] == [((7.0,) * 5, None)]
    assert any("7, 7, 7 s" in line for line in lines_of(found))


def test_no_text_breaks_a_line():
    point = Point(bench="b", seed=0, levels={"a\nb": "c\x1b[31m\nd"})
    outcome = Outcome(verdict="fail", exit_code=1, clauses=(Clause(id="X\n1", verdict="fail", cause="y\r\nz\x00"),))
    lines = list(lines_of(statistics([(point, outcome)], ["a\nb"], 1)))
    assert not any(char < " " for line in lines for char in line)


def test_plots_are_pictures_of_rates_and_margins():
    pytest.importorskip("matplotlib")
    rows = [result("fail" if level > 0.2 else "pass", level, figures=[(1, None, 2)]) for level in (0.001, 0.1, 0.3)]
    plots = plots_of(statistics(rows, ["rate"], 3))
    assert [plot.what for plot in plots] == [
        "Rate of failures over rate",
        "Margins: least, 5 %, median, 95 % and greatest",
    ]
    assert all(plot.address.startswith("data:image/svg+xml;base64,") for plot in plots)


def test_where_nothing_could_be_judged_nothing_is_said_to_be_clean():
    rows = [
        result(word, level, clauses=[("X1", word)]) for level, word in ((1, "pass"), (2, "inconclusive"), (3, "fail"))
    ]
    assert statistics(rows, ["rate"], 3).clauses[0].last_clean == {"rate": 1.0}
    assert statistics(rows[1:], ["rate"], 2).clauses[0].last_clean == {}


def test_levels_that_differ_look_different():
    rows = [result("pass", level) for level in (1_000_001, 1_000_002)]
    assert [one.level for one in statistics(rows, ["rate"], 2).levels] == ["1000001", "1000002"]
