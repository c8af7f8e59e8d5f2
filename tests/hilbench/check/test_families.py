"""Families of stimuli: which members are tried, what is said of the one that fails, and what the report says of all."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.check import CaseResult, Inconclusive, Report, Verdict, Violation, try_members
from hilbench.check.report import footer
from hilbench.check.results import Counts
from hilbench.judging.recorder import leave_open, recording
from hilbench.judging.verdicts import Sampled, Untimely
from tests.each import each

BITS = [(f"bit {bit}", 1 << bit) for bit in range(16)]


def tried(members, seed, budget):
    seen = []
    try_members("bits", members, seen.append, seed=seed, budget=budget)
    return seen


@given(st.integers(0, 2**63 - 1), st.integers(1, 30))
def test_none_is_tried_twice_and_the_seed_says_which(seed, budget):
    seen = tried(BITS, seed, budget)
    assert len(seen) == len(set(seen)) == min(budget, len(BITS))
    assert seen == sorted(seen) == tried(BITS, seed, budget)
    assert set(seen) <= {stimulus for _, stimulus in BITS}


def test_a_budget_that_has_room_tries_all():
    assert tried(BITS, 5, len(BITS)) == [stimulus for _, stimulus in BITS]


def test_every_member_is_drawn_by_some_seed():
    assert {one for seed in range(100) for one in tried(BITS, seed, 2)} == {stimulus for _, stimulus in BITS}


@each(("members", "budget"), [([], 3), (BITS, 0)])
def test_nothing_to_try_is_no_pass(members, budget):
    with pytest.raises(ValueError, match="leave nothing to try"):
        tried(members, 1, budget)


@each("kind", [Violation, Inconclusive])
def test_the_member_that_ends_the_case_is_named(kind):
    def judge(stimulus):
        if stimulus == 1 << 5:
            raise kind("it was taken", ["its bytes"], clause="X1")

    with recording() as recorded, pytest.raises(kind) as caught:
        try_members("bits", BITS, judge, seed=7, budget=16)
    assert caught.value.cause == "member 6 of 16 bits (bit 5), case seed 7: it was taken"
    assert caught.value.evidence == ("its bytes",)
    assert caught.value.clause == "X1"
    assert recorded.families == [Sampled(family="bits", tried=6, members=16)]


def test_what_an_outcome_knows_besides_stays():
    def judge(stimulus):
        raise Untimely("no answer", spare_s=2.0)

    with pytest.raises(Untimely, match="member 1 of 16 bits") as caught:
        try_members("bits", BITS, judge, seed=7, budget=16)
    assert caught.value.spare_s == 2.0


def test_a_point_that_is_left_open_names_its_member():
    def judge(stimulus):
        if stimulus == 4:
            leave_open(Inconclusive("too late to tell"))

    with recording() as recorded:
        try_members("bits", BITS, judge, seed=7, budget=16)
    assert [str(point) for point in recorded.unclear] == ["member 3 of 16 bits (bit 2), case seed 7: too late to tell"]


def test_a_failed_assertion_is_a_violation_of_its_member():
    def judge(stimulus):
        assert stimulus != 2, "two is taken"

    with pytest.raises(Violation, match=r"^member 2 of 16 bits \(bit 1\), case seed 7: two is taken$"):
        try_members("bits", BITS, judge, seed=7, budget=16)


def result(case_id, *families):
    return CaseResult(id=case_id, suite="s", clause_ids=("X1",), verdict=Verdict.PASS, families=families)


def test_the_report_says_how_many_of_how_many():
    some, all_bits, other = (
        Sampled(family="bits", tried=4, members=16),
        Sampled(family="bits", tried=16, members=16),
        Sampled(family="sizes", tried=3, members=90),
    )
    report = Report(
        format="",
        hilbench="",
        bench={},
        seed=0,
        strict=False,
        select="",
        exit_code=0,
        exit_meaning="",
        stopped="",
        run_hash=None,
        no_run_hash="",
        bench_time_s=0,
        host_time_s=0,
        counts=Counts(clauses=1, passed=1, failed=0, warned=0, inconclusive=0, error=0, not_applicable=0, not_run=0),
        clauses=(),
        cases=(result("a", all_bits), result("b", some, other)),
    )
    assert footer.lines(report) == ["tried: X1 4 of 16 bits, 3 of 90 sizes"]
