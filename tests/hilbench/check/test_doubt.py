"""What a verdict is worth on a bench that was late."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.check import Inconclusive, Untimely, Verdict, Violation, at_least, at_most, near
from hilbench.check.collector import Collector
from hilbench.check.plugin import CheckPlugin
from hilbench.check.pytest_run import run_pytest
from hilbench.judging.doubt import BORNE_S, Doubt, doubted, excused
from hilbench.judging.outcome import outcome_of
from hilbench.judging.recorder import uncertain
from hilbench.judging.uncertainty import OfTimes
from tests.each import each

CAUSE = "the served bench was up to 27.3 ms late"


def ended(error, lateness_s, *, lived=True):
    """Return the outcome of a case that ended with this exception, on benches that were so late together."""
    return doubted(outcome_of(error), Doubt(lateness_s=lateness_s, cause=CAUSE, lived=lived))


def error_of(judge, *args, **more):
    with pytest.raises((Violation, Inconclusive)) as raised:
        judge(*args, unit="s", what="stop", **more)
    return raised.value


@pytest.mark.parametrize("error", [Violation("wrong answer"), AssertionError("wrong answer")])
@given(lateness_s=st.floats(0, 10))
def test_what_was_said_is_held_against_a_target_however_late_it_was_read(error, lateness_s):
    assert ended(error, lateness_s) == outcome_of(error)
    assert ended(error, lateness_s).verdict is Verdict.FAIL


@given(lateness_s=st.floats(0, 1), spare_s=st.floats(0, 1))
def test_what_did_not_come_is_held_against_a_target_as_far_as_the_benches_were_in_time(lateness_s, spare_s):
    outcome = ended(Untimely("no answer", spare_s=spare_s), lateness_s)
    if lateness_s <= max(BORNE_S, spare_s):
        assert (outcome.verdict, outcome.cause) == (Verdict.FAIL, "no answer")
    else:
        assert outcome.verdict is Verdict.INCONCLUSIVE
        assert outcome.cause == f"no answer: not counted against the target, because {CAUSE}"


def test_a_number_of_things_has_no_lateness_but_what_it_is_given():
    with pytest.raises(Violation) as raised:
        at_least(3, 6, unit="reports", what="of a status")
    assert ended(raised.value, 1.0).verdict is Verdict.FAIL


@given(st.floats(0, 10))
def test_a_figure_that_is_wrong_by_more_than_it_is_uncertain_stays_wrong(lateness_s):
    error = error_of(at_most, 0.4, 0.2, uncertainty=OfTimes(0.1))
    assert ended(error, lateness_s) == outcome_of(error)
    with uncertain(lambda: 0.1):
        error = error_of(at_most, 0.4, 0.2)
    assert ended(error, lateness_s) == outcome_of(error)


@pytest.mark.parametrize("unit", ["s", "deg"])
@given(lateness_s=st.floats(0, 10))
def test_a_figure_whose_uncertainty_has_nothing_to_do_with_lateness_is_held_against_a_target(unit, lateness_s):
    with pytest.raises(Violation) as raised:
        at_most(0.4, 0.2, unit=unit, what="stop", uncertainty=0.1)
    assert ended(raised.value, lateness_s).verdict is Verdict.FAIL


def test_a_figure_says_whether_its_uncertainty_is_of_times():
    assert at_most(1, 3, unit="mm", what="way", uncertainty=400 * OfTimes(0.001)).of_times
    assert not at_most(1, 3, unit="mm", what="way", uncertainty=0.4).of_times
    assert not at_most(1, 3, unit="mm", what="way", uncertainty=OfTimes(0)).of_times
    assert type(at_most(1, 3, unit="s", what="it", uncertainty=OfTimes(0.1)).uncertainty) is float


def test_a_figure_that_cannot_be_told_says_who_was_late():
    error = error_of(at_most, 0.21, 0.2, uncertainty=0.03)
    assert ended(error, 0.03).cause == f"{error}; {CAUSE}"
    assert ended(error, 0.0009).cause == str(error)


@given(st.floats(0, 10))
def test_a_pass_stays_one_unless_the_target_had_less_time_than_the_case(lateness_s):
    assert ended(None, lateness_s).verdict is Verdict.PASS
    outcome = ended(None, lateness_s, lived=False)
    assert outcome.verdict is Verdict.INCONCLUSIVE
    assert outcome.cause == f"less time passed for the target than the case waited: {CAUSE}"


@each("error", [Inconclusive("who knows"), RuntimeError("defect")])
def test_other_verdicts_stay(error):
    assert ended(error, 1.0) == outcome_of(error)


def verdict_of(value, limit, unit="s", **more):
    return outcome_of(raised_by(lambda: at_most(value, limit, unit=unit, what="stop", **more))).verdict


def raised_by(action):
    try:
        action()
    except (Violation, Inconclusive) as error:
        return error
    return None


@given(st.floats(0, 1), st.floats(-3, 3), st.floats(0.001, 1))
def test_a_time_without_an_uncertainty_has_that_of_the_case(value_s, share, doubt_s):
    limit_s = value_s + share * doubt_s
    expected = verdict_of(value_s, limit_s, uncertainty=doubt_s)
    with uncertain(lambda: doubt_s):
        assert verdict_of(value_s, limit_s) is expected
        assert verdict_of(value_s, limit_s, uncertainty=1e-9) is verdict_of(value_s, limit_s, uncertainty=1e-9)
        assert at_most(3, 3, unit="frames", what="count").uncertainty == 0
        assert near(3, 3, 5000, unit="ms", what="time").uncertainty == pytest.approx(doubt_s * 1000)
    assert near(3, 3, 5, unit="s", what="time").uncertainty == 0


def test_a_case_is_judged_by_what_its_bench_was_late_by(check, late):
    report = check(
        """
        @my("A1")
        def test_in_time(bench):
            assert False, "no answer"

        @my("A2")
        def test_late(bench):
            bench.is_late(0.0273)
            raise Untimely("no answer")

        @my("A3")
        def test_time(bench):
            bench.is_late(0.001)
            at_most(0.0995, 0.1, unit="s", what="the answer took")

        @my("A4")
        def test_certain(bench):
            bench.is_late(0.001)
            at_most(0.0985, 0.1, unit="s", what="the answer took")

        @my("A5")
        def test_slow(bench):
            bench.lived = False
        """,
        provider=late,
    )
    verdicts = [clause.verdict.value for clause in report.clauses]
    assert verdicts == ["fail", "inconclusive", "inconclusive", "pass", "inconclusive"]
    assert report.clauses[1].cause.endswith("the served bench was up to 27.3 ms late")
    assert report.cases[2].measures[0].uncertainty == 0.001
    told = [bench.verdicts[0][0] for bench in late.opened]
    assert told == verdicts  # the journal has the same


def test_under_plain_pytest_too_what_is_in_doubt_is_neither_a_pass_nor_a_violation(write_suite, late):
    file = write_suite(
        """
        @my("A1")
        def test_pass(bench):
            bench.is_late(0.0273)

        @my("A2")
        def test_slow(bench):
            bench.lived = False

        @my("A3")
        def test_late(bench):
            bench.is_late(0.0273)
            raise Untimely("no answer")
        """
    )
    reports = []

    class Listening(CheckPlugin):
        def pytest_runtest_logreport(self, report):
            reports.append(report)

    run_pytest([file], Listening(Collector(), late, seed=0, only_cases=False))
    passed, slow, unanswered = (report for report in reports if report.when == "call")
    assert (passed.outcome, slow.outcome, unanswered.outcome) == ("passed", "failed", "failed")
    assert str(slow.longrepr).startswith("inconclusive: less time passed")
    assert str(unanswered.longrepr) == "inconclusive: no answer: not counted against the target, because " + CAUSE


LACKS = "brain waits in main, polling CEC_ISR; CEC is not modelled"


@each("error", [Violation("no answer"), AssertionError("no answer")])
def test_what_a_target_fails_to_do_while_it_waits_on_what_is_not_modelled_is_not_held_against_it(error):
    outcome = excused(outcome_of(error), LACKS)
    assert (outcome.verdict, outcome.cause) == (
        Verdict.INCONCLUSIVE,
        f"no answer: not counted against the target, because {LACKS}",
    )
    assert excused(outcome_of(error), "") == outcome_of(error)


def test_a_verdict_that_cannot_be_told_anyway_names_it_too_and_a_defect_stays_one():
    assert excused(outcome_of(Inconclusive("too slow")), LACKS).cause == f"too slow; {LACKS}"
    assert excused(outcome_of(RuntimeError("defect")), LACKS) == outcome_of(RuntimeError("defect"))


def test_a_bench_is_asked_what_it_lacks_of_cases_that_do_not_pass(check, provider):
    def lacks(bench):
        bench.asked = True
        return LACKS

    provider.bench = type("LackingBench", (provider.bench,), {"lacks": lacks, "asked": False})
    report = check('@my("A1")\ndef test_a(bench): pass\n\n@my("A2")\ndef test_b(bench): assert False, "no answer"\n')
    assert [case.verdict for case in report.cases] == [Verdict.PASS, Verdict.INCONCLUSIVE]
    assert [bench.asked for bench in provider.opened] == [False, True]
    assert report.exit_code == 4
