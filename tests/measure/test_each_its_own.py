"""A fault is looked for by all of its cases at once, or by one after the other until it is found."""

from __future__ import annotations

import pytest

from hilbench.check import CheckOptions
from measure.mutants.each_its_own import Fault, judge
from tests.hilbench.check.conftest import PRELUDE, FakeBench, FakeProvider

SUITE = f"""{PRELUDE}
@my("A1", bench_time_s=9.0)
def test_long(bench): assert not bench.wrong

@my("A1", bench_time_s=1.0)
def test_short(bench): assert not bench.wrong or BLIND

@my("A2", bench_time_s=5.0)
def test_other(bench): assert not bench.wrong
"""


class Wrong(FakeBench):
    wrong = False

    def __init__(self, case, provider):
        super().__init__(case, provider)
        provider.met.append((provider.name, case.id.partition("/")[2]))


class Provider(FakeProvider):
    """Benches with a fault, or without one if it has no name; and which cases met them."""

    def __init__(self, met, name="", *, wrong=False):
        super().__init__(bench=type("Bench", (Wrong,), {"wrong": wrong}))
        self.met, self.name = met, name


@pytest.fixture
def look(tmp_path):
    """Look for a fault by each of two clauses; return verdicts, and which cases met which fault."""

    def look(*, blind=False, wrong=True, until_found):
        file = tmp_path / "test_panel.py"
        file.write_text(SUITE.replace("BLIND", str(blind)))
        met = []
        faults = [
            Fault(name=name, clause_id=clause, open_case=Provider(met, name, wrong=wrong).open_case)
            for name, clause in (("one", "A1"), ("two", "A2"))
        ]
        options = CheckOptions(suites=(str(file),), select="long")
        return judge(options, Provider(met), faults, until_found=until_found), met

    return look


def test_all_cases_of_a_clause_meet_its_fault_and_no_other(look):
    verdicts, met = look(until_found=False)
    assert (verdicts.found_by, verdicts.not_found) == ({"A1", "A2"}, {})
    assert met == [("one", "long"), ("one", "short"), ("two", "other")]


def test_the_shortest_that_finds_it_is_enough(look):
    verdicts, met = look(until_found=True)
    assert (verdicts.found_by, verdicts.not_found) == ({"A1", "A2"}, {})
    assert met == [("one", "short"), ("two", "other")]


def test_where_it_finds_nothing_the_next_one_is_tried(look):
    verdicts, met = look(blind=True, until_found=True)
    assert (verdicts.found_by, verdicts.not_found) == ({"A1", "A2"}, {})
    assert met == [("one", "short"), ("two", "other"), ("one", "long")]


def test_what_no_case_finds_is_not_found(look):
    for until_found in (False, True):
        verdicts, _ = look(wrong=False, until_found=until_found)
        assert (verdicts.found_by, verdicts.open_clauses) == (set(), {"A1", "A2"})
