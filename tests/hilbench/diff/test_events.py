"""`hilbench diff --events`: the first event that is not the same, case by case."""

from __future__ import annotations

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.diff.events import EventOptions, compare_events
from hilbench.journal import Recording

_events = st.lists(
    st.tuples(st.integers(0, 50), st.sampled_from(["tx", "rx", "event"]), st.sampled_from("ab"), st.integers(0, 2)),
    max_size=12,
)


def recording(events, case=""):
    told, ns = [], 0
    if case:
        told.append({"ns": 7, "kind": "case", "source": "journal", "case": case})
    for step, kind, source, what in events:
        ns += step
        told.append({"ns": ns + 7 * bool(case), "kind": kind, "source": source, "what": what})
    return Recording(header={}, events=tuple(told), problem=None, ended=True)


@given(events=_events)
def test_a_recording_is_equal_to_itself_with_or_without_a_case_around_it(events):
    plain = recording(events)
    assert compare_events(plain, plain, EventOptions()).equal
    found = compare_events(recording(events, "x"), recording(events, "x"), EventOptions())
    assert found.equal
    assert [case.a for case in found.cases] == [len(events)]


@given(events=_events, at=st.integers(0, 11), change=st.sampled_from(["value", "time", "lost"]))
def test_one_change_is_found_at_its_place(events, at, change):
    at = min(at, len(events) - 1)
    if at < 0:
        return
    other = list(events)
    step, kind, source, what = events[at]
    if change == "lost":
        del other[at]
        if at < len(other):
            after = other[at]
            other[at] = (after[0] + step, *after[1:])
    else:
        other[at] = (step + (change == "time"), kind, source, what + 10 * (change == "value"))
    a, b = recording(events), recording(other)
    (case,) = compare_events(a, b, EventOptions()).cases if other else (None,)
    if case is None:
        return
    assert case.first is not None
    assert case.first.ns >= a.events[at]["ns"]
    if change == "value":
        assert case.first.a == a.events[at]
        assert case.first.what == "another what"
    swapped = compare_events(b, a, EventOptions()).cases[0].first
    assert (swapped.ns, swapped.a, swapped.b) == (case.first.ns, case.first.b, case.first.a)


def test_a_shift_within_the_tolerance_and_the_order_alone(journal, diff):
    a = journal("a.jsonl", [(1, "tx", "checker", {"data": "00"}), (2, "rx", "checker", {"data": "01"})])
    b = journal("b.jsonl", [(1, "tx", "checker", {"data": "00"}), (4, "rx", "checker", {"data": "01"})])
    assert diff(a, b, "--events", "--tolerance", "2ms")[0] == 0
    assert diff(a, b, "--events", "--order-only")[0] == 0
    code, out, _ = diff(a, b, "--events")
    assert code == 1
    assert "checker rx, number 1: B is 2 ms later" in out
    assert diff(a, b, "--events", "--only", "checker tx")[0] == 0


@pytest.fixture
def checked(tmp_path):
    """Write the journal of cases, each with a byte and a verdict."""
    from hilbench.journal import Journal

    def written(name, cases):
        log = Journal(tmp_path / name)
        for number, (case, byte, verdict) in enumerate(cases):
            begin_ns = number * 1000
            log.begin_case(case, begin_ns)
            log.record("tx", "robot", begin_ns + 10, data=bytes([byte]))
            log.record("host-lateness", "checker", begin_ns + 11, uncertainty_s=number)
            log.record("verdict", "checker", begin_ns + 20, verdict=verdict, cause=f"prose {number}")
            log.end_case(begin_ns + 20)
        log.close()
        return str(tmp_path / name)

    return written


def test_cases_are_held_against_each_other_whatever_their_order(checked, diff):
    a = checked("a.jsonl", [("one", 1, "pass"), ("two", 2, "pass"), ("gone", 1, "pass")])
    b = checked("b.jsonl", [("two", 3, "fail"), ("one", 1, "pass"), ("new", 1, "pass")])
    code, out, _ = diff(a, b, "--events", "--json")
    assert code == 1
    found = {case["case"]: case for case in json.loads(out)["cases"]}
    assert found["one"]["equal"]
    assert (found["two"]["first"]["stream"], found["two"]["first"]["what"]) == ("robot tx", "another data")
    assert found["two"]["verdicts"] == ["pass", "fail"]
    assert (found["gone"]["b"], found["new"]["a"]) == (None, None)
    assert diff(a, b, "--events", "--case", "one")[0] == 0
    out = diff(a, b, "--events")[1]
    assert "two: 2 events in A, 2 in B, pass in A and fail in B" in out
    assert "gone: only in A" in out
    assert "different: 3 of 4 cases" in out


def test_another_format_is_the_same_recording(checked, diff, tmp_path):
    from hilbench.cli import main

    a = checked("a.jsonl", [("one", 1, "pass")])
    for name in ("mcap", "csv", "pcapng"):
        assert main(["export", a, f"--{name}", str(tmp_path / name)]) == 0
        assert diff(a, str(tmp_path / name), "--events")[0] == 0
        code, out, err = diff(str(tmp_path / name), str(tmp_path / name))
        said = "is neither waveforms nor a table of pins, but events; compare its events with --events"
        assert (code, out, err) == (3, "", f"hilbench: {tmp_path / name}: {said}\n")


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        (("--events", "--pins", "PB*"), 2, "--pins: is about pins"),
        (("--only", "x"), 2, "--only: is about events"),
        (("--events", "--case", "a", "--case", "b"), 2, "the same case in both"),
        (("--events", "--only", "nobody *"), 2, "nothing to compare"),
    ],
)
def test_wrong_usage(checked, diff, words, code, said):
    a = checked("a.jsonl", [("one", 1, "pass")])
    found, out, err = diff(a, a, *words)
    assert (found, out) == (code, "")
    assert said in err
