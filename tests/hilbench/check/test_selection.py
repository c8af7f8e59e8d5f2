"""The expression of ``-k``."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.check.selection import Candidate, compile_selection
from hilbench.errors import UsageError
from tests.each import each

CANDIDATE = Candidate.of(["S3"], ["p2os-server/watchdog_stops[2]", "Motors stop"])
IDS = {"S3", "S36", "W1"}


@each(
    ("expression", "selected"),
    [
        ("", True),
        ("S3", True),
        ("s3", True),
        ("S36", False),
        ("S", True),
        ("watchdog", True),
        ("WATCH and motors", True),
        ("watch and W1", False),
        ("W1 or stop", True),
        ("not W1", True),
        ("not (W1 or stop)", False),
        ("not not stop", True),
        ("W1 or W1 and W1 or stop", True),
        ("p2os-server/watchdog_stops[2]", True),
        ("nothing", False),
    ],
)
def test_what_is_selected(expression, selected):
    assert compile_selection(expression, IDS)(CANDIDATE) is selected


def test_an_id_means_its_clause_and_not_those_it_begins():
    longer = Candidate.of(["S36"], ["p2os-server/other"])
    assert not compile_selection("S3", IDS)(longer)
    assert compile_selection("S3", {"S36"})(longer)


@each("expression", ["and", "a and", "a b", "(a", "a)", "not", "or a", "()", "a or or b"])
def test_a_malformed_expression_is_wrong_usage(expression):
    with pytest.raises(UsageError, match=r"^-k '"):
        compile_selection(expression, IDS)


words = st.sampled_from(["S3", "stop", "W1", "zzz"])
expressions = st.recursive(
    words,
    lambda inner: st.one_of(
        inner.map(lambda a: f"not {a}"),
        st.tuples(inner, inner).map(lambda ab: f"({ab[0]} and {ab[1]})"),
        st.tuples(inner, inner).map(lambda ab: f"({ab[0]} or {ab[1]})"),
    ),
)


@given(expressions)
def test_it_means_what_python_means(expression):
    truth = {"S3": True, "stop": True, "W1": False, "zzz": False}
    assert compile_selection(expression, IDS)(CANDIDATE) == eval(expression, {}, truth)
