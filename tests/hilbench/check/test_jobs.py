"""Cases in several processes: the same report, journal and hash; a process that dies; Ctrl-C; who cannot."""

from __future__ import annotations

import json
import os
import subprocess
import sys

import pytest

from hilbench.check import CheckOptions
from hilbench.check.adding_up import added_up, in_order
from hilbench.check.runner import _time_left, run_check
from hilbench.commands.check import _provider_of
from hilbench.errors import UsageError
from hilbench.judging.observations import Coverage, EmulationNote, IgnoredCommand, Ledger, Observations, TouchedFeature
from hilbench.terminal import arguments
from hilbench.terminal.options import TargetChoice
from targets.firmware import image_path
from tests.each import each

HEAD = "import os, signal\nimport pytest\nfrom hilbench.check import case\n"
PLAIN = (
    HEAD
    + """
@case("X1", text="One.", source="us")
def test_one(peer): peer

@case("X2", text="Two.", source="us")
@pytest.mark.parametrize("n", range(3))
def test_two(peer, n):
    if n == 1:
        peer.start()
        peer.run(2.5)
    assert n != 1
"""
)
DIES = (
    HEAD
    + """
@case("X1", text="One.", source="us")
def test_one(peer): os.kill(os.getpid(), getattr(signal, "{signal}"))

@case("X2", text="Two.", source="us")
@pytest.mark.parametrize("n", range(3))
def test_two(peer, n): peer
"""
)
INTERRUPTED = (
    HEAD
    + """
@case("X1", text="One.", source="us")
def test_one(peer): peer

@case("X2", text="Two.", source="us")
def test_two(peer):
    os.kill(os.getppid(), signal.SIGINT)
    signal.pause()

@case("X3", text="Three.", source="us")
def test_three(peer): peer
"""
)


@pytest.fixture
def suite(tmp_path):
    def write(text):
        (tmp_path / "test_x.py").write_text(text)
        return str(tmp_path / "test_x.py")

    return write


@pytest.fixture
def check(tmp_path, capsys):
    """Run a check with so many jobs; return exit code, report and journal."""

    def run(jobs, *suites, select="", bench="pioneer-plane", **more):
        report, journal = tmp_path / f"{jobs}.json", tmp_path / f"{jobs}.jsonl"
        options = CheckOptions(
            bench=bench, suites=suites, select=select, jobs=jobs, json=str(report), journal=journal, **more
        )
        code = run_check(options, _provider_of)
        said = json.loads(report.read_text())
        said.pop("host_time_s")
        return code, said, journal.read_bytes()

    return run


@pytest.mark.exhaustive("the gate has a suite of four cases by one and by two")
@pytest.mark.parametrize(
    ("bench", "select"), [("pioneer-plane", "S02 or S10 or S60 or M4"), ("rover", "P02 or P03 or P05")]
)
def test_a_run_is_the_same_by_one_process_and_by_two(check, bench, select):
    assert check(2, select=select, bench=bench) == check(1, select=select, bench=bench)


@pytest.mark.slow("two processes")
def test_verdicts_stand_in_the_order_of_the_plan(check, suite, tmp_path):
    one, two = (check(jobs, suite(PLAIN), html=tmp_path / f"{jobs}.html") for jobs in (1, 2))
    assert two == one
    assert two[2].count(b'"margins"') == 1  # of the case that fails
    assert (tmp_path / "2.html").read_bytes() == (tmp_path / "1.html").read_bytes()
    assert [case["verdict"] for case in two[1]["cases"]] == ["pass", "pass", "fail", "pass"]


@pytest.mark.slow("three processes, one after another")
@pytest.mark.parametrize(
    ("name", "code"),
    [("SIGKILL", 3), pytest.param("SIGABRT", 5, marks=pytest.mark.exhaustive("the gate has another signal"))],
)
def test_a_process_that_dies_costs_its_own_case(check, suite, name, code):
    exit_code, report, journal = check(2, suite(DIES.replace("{signal}", name)))
    assert exit_code == code
    assert [case["verdict"] for case in report["cases"]] == ["error", "pass", "pass", "pass"]
    assert report["cases"][0]["cause"] == f"the process that ran it was ended by {name}"
    assert journal.count(b'"case-end"') == 3


@pytest.mark.slow("three processes")
def test_ctrl_c_ends_all_of_them_and_leaves_a_report(suite, tmp_path):
    words = ["check", "pioneer-plane", "--suite", suite(INTERRUPTED), "--jobs", "2", "--json", "-"]
    done = subprocess.run(
        [sys.executable, "-P", "-m", "hilbench", *words], capture_output=True, cwd=tmp_path, timeout=600, check=False
    )
    report = json.loads(done.stdout)
    assert done.returncode == report["exit_code"] == 130
    by_id = {case["id"]: case["verdict"] for case in report["cases"]}
    assert by_id["x/two"] == "not-run"
    assert "interrupted" in report["stopped"]


@pytest.mark.exhaustive("two processes; the gate has other errors of theirs")
def test_what_no_worker_can_do_is_said_as_by_one(check):
    image = TargetChoice(name="brain.words", spec=f"bluepill:{image_path('style-registers')}")
    for jobs in (1, 2):
        with pytest.raises(UsageError, match="no case that is selected runs it"):
            check(jobs, "bluepill-dodge", select="wall", bench="bluepill", targets=(image,))


def test_a_target_that_is_there_but_once_is_checked_by_one(suite, provider, capsys):
    path = suite(PLAIN.replace("peer", "bench"))
    run_check(CheckOptions(suites=(path,), jobs=2), lambda _options: provider)
    assert "--jobs: the cases of this target run one after the other" in capsys.readouterr().err
    assert len(provider.opened) == 4


@each(
    ("elapsed_s", "begun", "said"),
    [(5.0, 9, ""), (10.0, 10, ", 90 s left:"), (60.0, 10, ", 9 min left:"), (9, 100, "")],
)
def test_how_long_the_rest_will_take(elapsed_s, begun, said):
    assert _time_left(elapsed_s, begun, 100) == said


@each("text", ["0", "-1", "257", "many", ""])
def test_what_is_no_number_of_processes(text):
    with pytest.raises(ValueError, match="not"):
        arguments.jobs(text)


def test_as_many_as_there_are_processors():
    assert arguments.jobs("auto") == len(os.sched_getaffinity(0))


PLACES = {"a": 0, "b": 1, "c": 2}


class TestAddingUp:
    def test_coverage_is_what_any_of_them_covered(self):
        one, two = (
            Observations(coverage=(Coverage(peer="p", states=3, states_missed=s, edges=2, edges_missed=e),))
            for s, e in ((("S1", "S2"), ("E1",)), (("S2",), ("E2",)))
        )
        (found,) = added_up([one, two], PLACES).coverage
        assert (found.states_missed, found.edges_missed) == (("S2",), ())

    def test_a_note_stands_where_it_was_seen_first(self):
        def note(text, at, *cases):
            return EmulationNote(board="b", kind="misuse", where="W", text=text, at=at, case_ids=cases)

        one = Observations(notes=(note("late", "one", "c"), note("both", "one", "c")))
        two = Observations(notes=(note("both", "two", "a", "b"),))
        found = added_up([one, two], PLACES).notes
        assert [(each.text, each.at, each.case_ids) for each in found] == [
            ("both", "two", ("a", "b", "c")),
            ("late", "one", ("c",)),
        ]

    def test_ledgers_do_not_depend_on_who_saw_what(self):
        def ledger(case, *commands):
            touched = TouchedFeature(feature="f", fidelity="partly", note="", commands=commands, case_ids=(case,))
            ignored = tuple(IgnoredCommand(command=name, reason="off", case_ids=(case,)) for name in commands)
            return Observations(ledger=Ledger(modelled=1, partly=1, absent=0, touched=(touched,), ignored=ignored))

        one, two = ledger("b", "V", "A"), ledger("a", "V", "B")
        found = in_order(added_up([one, two], PLACES))
        assert found == in_order(added_up([two, one], PLACES))
        assert found.ledger.touched[0].commands == ("A", "B", "V")
        assert [(one.command, one.case_ids) for one in found.ledger.ignored] == [
            ("A", ("b",)),
            ("B", ("a",)),
            ("V", ("a", "b")),
        ]

    def test_nothing_at_all(self):
        assert added_up([], {}) == Observations()
