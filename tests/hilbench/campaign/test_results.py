"""The file of results: each point once, whole or not at all."""

from __future__ import annotations

import sqlite3

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hilbench.campaign.point import Clause, Figure, Outcome, Point
from hilbench.campaign.results import Results
from hilbench.errors import UnavailableError, UsageError
from tests.share import examples

words = st.text(max_size=8)
numbers = st.floats(allow_nan=False, allow_infinity=False)
names = st.text("abc", min_size=1, max_size=3)
outcomes = st.builds(
    Outcome,
    verdict=st.sampled_from(["pass", "fail", "inconclusive", "error"]),
    exit_code=st.integers(0, 5),
    cause=words,
    clauses=st.lists(st.builds(Clause, id=names, verdict=words, cause=words), max_size=3, unique_by=lambda c: c.id).map(
        tuple
    ),
    figures=st.lists(
        st.builds(Figure, case=words, clause=words, name=words, value=numbers, unit=words, low=st.none() | numbers),
        max_size=3,
    ).map(tuple),
)
POINT = Point(bench="b", seed=3, levels={"rate": 0.5, "image": "new"})


@settings(max_examples=examples(30))
@given(st.lists(st.tuples(names, outcomes), max_size=8))
def test_what_was_entered_last_is_what_is_known(tmp_path_factory, entries):
    path = tmp_path_factory.mktemp("results") / "r.sqlite"
    with Results(path) as results:
        for key, outcome in entries:
            results.enter(key, POINT, outcome)
    expected = dict(entries)
    with Results(path) as results:
        assert results.known(["other", *expected], errors=True) == expected
        assert results.known(expected) == {key: one for key, one in expected.items() if one.verdict != "error"}
    with sqlite3.connect(path) as base:
        assert base.execute("SELECT count(*) FROM points").fetchone() == (len(expected),)
        assert base.execute("SELECT count(*) FROM levels").fetchone() == (2 * len(expected),)
        clauses = sum(len(outcome.clauses) for outcome in expected.values())
        assert base.execute("SELECT count(*) FROM clauses").fetchone() == (clauses,)
    base.close()


def test_what_is_interrupted_in_the_middle_leaves_what_was_there(tmp_path):
    before = Outcome(verdict="pass", exit_code=0)
    torn = Outcome(
        verdict="fail", exit_code=1, clauses=(Clause(id="X", verdict="fail"), Clause(id="X", verdict="fail"))
    )
    with Results(tmp_path / "r.sqlite") as results:
        results.enter("k", POINT, before)
        with pytest.raises(UnavailableError, match="UNIQUE"):
            results.enter("k", POINT, torn)
        assert results.known(["k"]) == {"k": before}


def test_another_file_is_left_alone(tmp_path):
    text, other, newer = tmp_path / "a.txt", tmp_path / "b.sqlite", tmp_path / "c.sqlite"
    text.write_text("not a database, but a text that somebody needs" * 100)
    for path, table in ((other, "mine"), (newer, "about")):
        base = sqlite3.connect(path)
        base.execute(f"CREATE TABLE {table} (name TEXT, value TEXT)")
        base.close()
    rows = {text: "is no file of results", other: "holds tables of something else", newer: "is not of the format"}
    for path, said in rows.items():
        before = path.read_bytes()
        with pytest.raises(UsageError, match=said):
            Results(path)
        assert path.read_bytes() == before


def test_a_folder_that_is_not_there_is_one_line(tmp_path):
    with pytest.raises(UnavailableError, match="unable to open"):
        Results(tmp_path / "no" / "r.sqlite")
