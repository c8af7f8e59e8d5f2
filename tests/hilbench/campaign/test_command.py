"""``hilbench campaign``: each point once, in however many processes; what goes on, and what is wrong."""

from __future__ import annotations

import contextlib
import json
import os
import signal
import sqlite3
import subprocess
import sys
from collections import Counter
from types import SimpleNamespace

import pytest

from hilbench.campaign import hosts
from hilbench.campaign.point import Outcome, Point, run_point
from hilbench.campaign.processes import run_here
from hilbench.campaign.shipping import pack, run_shipped
from hilbench.cli import main
from hilbench.errors import UnavailableError
from tests.hilbench.campaign.dying import run

CAMPAIGN = """
version = 1
bench = "pioneer-plane"
select = "S01"
seeds = 2
[set]
"faults.0.kind" = "drop"
[factors]
"faults.0.probability" = [0.0001, 1.0]
"""
OWN_SUITE = """
from hilbench.check import case

@case("X1", text="One.", source="us")
def test_one(peer): peer
"""

OWN_BENCH = """
version = 1
[world]
physics = "plane"
[targets.robot]
model = "pioneer-2dx"
[[links]]
ends = ["peer", "robot.host"]
baud = 9600
"""


@pytest.fixture
def campaign(tmp_path, capsys):
    """Run a campaign; return exit code, report, and what was said."""
    file = tmp_path / "c.toml"

    def do(*words, text=CAMPAIGN):
        file.write_text(text)
        code = main(["campaign", str(file), "--json", str(tmp_path / "c.json"), *words])
        said = capsys.readouterr()
        report = tmp_path / "c.json"
        return code, json.loads(report.read_bytes()) if report.exists() else None, said

    return do


def rows(tmp_path):
    base = sqlite3.connect(tmp_path / "c.sqlite")
    found = base.execute("SELECT seed, point, outcome FROM points ORDER BY key").fetchall()
    base.close()
    return found


@pytest.mark.slow("starts two processes, which read all of the check")
def test_two_processes_come_to_what_one_call_comes_to_and_nothing_is_run_twice(campaign, tmp_path):
    code, report, said = campaign("--jobs", "2", "--html", str(tmp_path / "c.html"))
    assert code == 0
    assert (report["planned"], report["total"]["passed"], report["total"]["failed"]) == (4, 2, 2)
    assert "S01" in said.out
    assert "first fails at faults.0.probability = 1, never up to 0.0001" in said.out
    page = (tmp_path / "c.html").read_text()
    assert (
        "hilbench check pioneer-plane --set faults.0.kind=drop --set faults.0.probability=1.0 -k S01 --seed 1" in page
    )
    found = rows(tmp_path)
    for _, point, outcome in found:
        again = run_point(decoded(point))
        assert json.loads(outcome)["run_hash"] == again.run_hash
        assert json.loads(outcome)["verdict"] == again.verdict
    again_code, again_report, again_said = campaign()
    assert (again_code, again_report) == (0, report)
    assert "4 of 4 points have a result already" in again_said.err
    assert rows(tmp_path) == found


def decoded(text):
    import msgspec

    return msgspec.json.decode(text, type=Point)


def test_a_point_is_another_one_if_what_it_is_made_of_has_changed(campaign, tmp_path, monkeypatch):
    calls = Counter()

    def here(points, _jobs):
        for key, point in points.items():
            calls[point.seed] += 1
            yield key, Outcome(verdict="pass", exit_code=0)

    monkeypatch.setattr("hilbench.campaign.processes.run_here", here)
    suite = tmp_path / "mine.py"
    suite.write_text(OWN_SUITE)
    text = 'version = 1\nbench = "pioneer-plane"\nsuites = ["mine.py"]\nseeds = 2'
    assert campaign(text=text)[0] == 0
    assert campaign(text=text)[0] == 0
    assert calls == {0: 1, 1: 1}
    suite.write_text(f"{OWN_SUITE}\n# changed\n")
    assert campaign(text=text.replace("seeds = 2", "seeds = 3"))[0] == 0
    assert calls == {0: 2, 1: 2, 2: 1}


def test_what_could_not_be_run_is_said_and_tried_again(campaign, monkeypatch):
    outcomes = iter([Outcome(verdict="error", exit_code=3, cause="no physics"), Outcome(verdict="pass", exit_code=0)])
    given = []

    def here(points, _jobs):
        for key in points:
            given.append(key)
            yield key, next(outcomes)

    monkeypatch.setattr("hilbench.campaign.processes.run_here", here)
    text = 'version = 1\nbench = "pioneer-plane"'
    code, report, said = campaign(text=text)
    assert (code, report["total"]["errors"]) == (3, 1)
    assert "no physics; as: hilbench check pioneer-plane --seed 0" in said.err
    assert campaign(text=text)[0] == 0
    assert len(given) == 2


def test_interrupted_it_keeps_what_was_run_and_says_so(campaign, monkeypatch):
    def here(points, _jobs):
        yield next(iter(points)), Outcome(verdict="pass", exit_code=0)
        raise KeyboardInterrupt

    monkeypatch.setattr("hilbench.campaign.processes.run_here", here)
    code, report, said = campaign()
    assert code == 130
    assert (report["planned"], report["total"]["points"]) == (4, 1)
    assert "4 points, 3 without a result" in said.out


def test_two_levels_that_are_the_same_point_count_both_and_are_run_once(campaign, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "hilbench.campaign.processes.run_here", lambda points, _: ((k, run_point(points[k])) for k in points)
    )
    levels = '[factors]\nstep.a = { "world.step_hz" = 240 }\nstep.b = { "world.step_hz" = 240 }'
    _, report, _ = campaign(text=f'version = 1\nbench = "pioneer-plane"\nselect = "S01"\n{levels}')
    assert [(level["level"], level["tally"]["points"]) for level in report["levels"]] == [("a", 1), ("b", 1)]
    assert len(rows(tmp_path)) == 1


def test_a_result_of_a_file_that_has_changed_meanwhile_is_not_kept(campaign, tmp_path, monkeypatch):
    bench = tmp_path / "b.toml"
    bench.write_text(OWN_BENCH)

    def here(points, _jobs):
        yield next(iter(points)), Outcome(verdict="pass", exit_code=0)
        bench.write_text(f"{OWN_BENCH}# another one\n")
        yield from ((key, Outcome(verdict="fail", exit_code=1)) for key in [*points][1:])

    monkeypatch.setattr("hilbench.campaign.processes.run_here", here)
    code, _, said = campaign(text='version = 1\nbench = "b.toml"\nseeds = 2')
    assert code == 3
    assert "b.toml: its files have changed while points were run; what was run before is kept" in said.err
    assert len(rows(tmp_path)) == 1


def test_a_figure_that_is_no_number_does_not_spoil_the_results(campaign, tmp_path, monkeypatch):
    monkeypatch.setattr(
        "hilbench.campaign.processes.run_here", lambda points, _: ((k, run_point(points[k])) for k in points)
    )
    (tmp_path / "mine.py").write_text(
        "from hilbench.check import case, record_measure\n"
        '@case("X1", text="One.", source="us")\ndef test_one(peer):\n'
        '    record_measure("a", float("nan"), "s")\n'
        '    record_measure("b", 1.0, "s", high=float("inf"))\n'
    )
    text = 'version = 1\nbench = "pioneer-plane"\nsuites = ["mine.py"]'
    for _ in range(2):
        code, report, _ = campaign(text=text)
        assert (code, report["total"]["passed"]) == (0, 1)
        assert [(one["name"], one["margins"]) for one in report["figures"]] == [("b", None)]


def test_a_list_runs_nothing(campaign, tmp_path):
    code, _, said = campaign("--list")
    assert code == 0
    assert len(said.out.splitlines()) == 4
    assert said.out.startswith("hilbench check pioneer-plane --set faults.0.kind=drop --set")
    assert not (tmp_path / "c.sqlite").exists()


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ('version = 1\nbench = "nowhere"', "no such bench file"),
        ('version = 1\nbench = "pioneer-plane"\n[set]\n"world.scene" = "x"', "--set world.scene=x: no scene 'x'"),
        ('version = 1\nbench = "pioneer-plane"\nsuites = ["none.py"]', "none.py"),
        ('version = 2\nbench = "pioneer-plane"', "c.toml:1"),
        ("version = 1\nbench =\nseeds = 1", "c.toml:2: is not TOML"),
    ],
)
def test_what_is_wrong_is_one_line_before_anything_is_run(campaign, tmp_path, text, said):
    code, _, out = campaign(text=text)
    assert code == 2
    assert said in out.err
    assert len(out.err.splitlines()) == 1
    assert not (tmp_path / "c.sqlite").exists()


@pytest.mark.slow("starts processes, and has one of them killed")
def test_a_process_that_dies_costs_its_own_point_and_no_other():
    points = {str(seed): Point(bench="b", seed=seed) for seed in range(8)}
    found = dict(run_here(points, 2, run))
    assert found.keys() == points.keys()
    assert [key for key, outcome in found.items() if outcome.verdict == "error"] == ["3"]
    assert all(found[key].bench_time_s == point.seed for key, point in points.items() if key != "3")


@pytest.mark.slow("starts processes, and has the first one killed")
def test_no_process_outlives_a_campaign_that_is_killed():
    program = "from tests.hilbench.campaign.dying import campaign_without_end; campaign_without_end()"
    campaign = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, start_new_session=True)
    assert campaign.stdout.readline() == b"0\n"
    campaign.kill()
    try:
        campaign.communicate(timeout=120)  # until the last process that holds its output has ended
    finally:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(campaign.pid, signal.SIGKILL)


def test_files_go_along_once_and_stand_elsewhere_as_they_stand_here(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "there"))
    own, folder = hosts.own_digest(), tmp_path / "here"
    folder.mkdir()
    (folder / "mine.py").write_text(OWN_SUITE)
    (folder / "b.toml").write_text(OWN_BENCH)
    point = Point(bench=str(folder / "b.toml"), seed=0, suites=(str(folder / "mine.py"),))
    parcel = pack([point])
    assert {name.rpartition("/")[2] for name in parcel.files} == {"b.toml", "mine.py"}
    assert run_shipped(point, parcel.digest, None, own) is None
    (folder / "mine.py").unlink()
    (folder / "b.toml").unlink()
    outcome = run_shipped(point, parcel.digest, parcel.files, own)
    assert (outcome.verdict, outcome.cause) == ("pass", "")
    assert run_shipped(point, parcel.digest, None, own).run_hash == outcome.run_hash
    assert run_shipped(point, parcel.digest, None, "other").cause.startswith("the worker has another hilbench")


def test_a_worker_that_cannot_keep_the_files_says_so(tmp_path, monkeypatch):
    (tmp_path / "cache").write_text("a file where a folder belongs")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    outcome = run_shipped(Point(bench="b.toml", seed=0), "d", {"/b.toml": b""}, hosts.own_digest())
    assert (outcome.verdict, outcome.exit_code) == ("error", 3)
    assert outcome.cause.startswith("the worker cannot keep the files of the campaign: ")


class KilledError(Exception):
    """What Dask says of a task that has cost it four workers."""


class Completed(list):
    """Gives futures back in the order in which they were added."""

    def __init__(self, loop):
        super().__init__()

    def add(self, future):
        self.append(future)

    def __iter__(self):
        while self:
            yield self.pop(0)


class Future:
    def __init__(self, result):
        self.result = result


class FakeClient:
    """Answers as workers would: with what a list says for each time that a point is given out."""

    loop = None

    def __init__(self, answers):
        self.answers = answers
        self.given = []

    def nthreads(self):
        return {"w": 1}

    def submit(self, function, point, parcel, files, hilbench, *, pure):
        assert (function, parcel, pure) == (run_shipped, "d", False)
        self.given.append((point.seed, files))
        answer = self.answers.get(point.seed, [Outcome(verdict="pass", exit_code=0)]).pop(0)

        def result():
            if isinstance(answer, BaseException):
                raise answer
            return answer

        return Future(result)


def test_what_is_no_address_is_not_tried(campaign, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", SimpleNamespace(Client=None))
    code, _, said = campaign("--scheduler", "nonsense")
    assert code == 2
    assert "--scheduler nonsense: is no address; such as tcp://10.0.0.5:8786" in said.err


def test_without_dask_it_says_how_to_get_it(campaign, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    code, _, said = campaign("--scheduler", "tcp://127.0.0.1:8786")
    assert code == 3
    assert "--scheduler needs Dask, which is not installed; pip install 'hilbench[campaign]'" in said.err


@pytest.mark.parametrize(
    ("answers", "said"),
    [
        ({}, "the scheduler has no worker; start one"),
        ({"a": OSError("gone")}, "the scheduler has no worker; start one"),
        ({"a": "own", "b": "other"}, "worker b: has another hilbench; install the same wheel there"),
        ({"a": "own", "b": OSError("gone")}, ""),
    ],
)
def test_workers_are_asked_for_their_hilbench(answers, said, monkeypatch):
    monkeypatch.setattr(hosts, "own_digest", lambda: "own")
    client = SimpleNamespace(run=lambda function, *, on_error: answers)
    if not said:
        hosts._check_workers(client, "tcp://h:1")
        return
    with pytest.raises(UnavailableError) as caught:
        hosts._check_workers(client, "tcp://h:1")
    assert said in str(caught.value)


def test_each_point_comes_back_once_whatever_befalls_the_workers(monkeypatch):
    scheduler = SimpleNamespace(KilledWorker=KilledError)
    monkeypatch.setitem(sys.modules, "distributed", SimpleNamespace(as_completed=Completed, scheduler=scheduler))
    monkeypatch.setitem(sys.modules, "distributed.scheduler", scheduler)
    good = Outcome(verdict="pass", exit_code=0)
    killed = [KilledError() for _ in range(6)]
    client = FakeClient({1: [None, good], 2: [*killed[:2], good], 3: killed})
    points = {str(seed): Point(bench="b", seed=seed) for seed in range(100)}
    giving = hosts._Giving(client, points, hosts.Parcel("d", {"f": b"x"}))
    found = Counter(giving.outcomes())
    assert sorted(int(key) for key, _ in found) == list(range(100))
    assert set(found.values()) == {1}
    assert {key for key, outcome in found if outcome.verdict == "error"} == {"3"}
    assert [files for seed, files in client.given if seed == 1] == [None, {"f": b"x"}]
