"""What a case on a bench in real time says of lateness: in its journal, and to whoever judges it."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import ExitStack, closing, contextmanager

import pytest

from hilbench.bench import Bench
from hilbench.bench.cases import CaseBase
from hilbench.check import Untimely, Verdict
from hilbench.check.bench_provider import make_provider
from hilbench.clock import NS_PER_MS, Scheduler
from hilbench.journal import Journal
from hilbench.judging.doubt import doubted
from hilbench.judging.outcome import outcome_of
from hilbench.judging.provider import CaseInfo
from hilbench.pace.lateness import IN_TIME, Lateness
from hilbench.serving import Notice, run_until_stopped
from hilbench.terminal.options import CheckOptions, TargetChoice
from hilbench.testing import FakeHostClock
from tests.each import each

INFO = CaseInfo(id="suite/x", clause_ids=(), seed=0)
PATIENCE_S = 600
WITHOUT_PROXY = pytest.mark.exhaustive("the gate has the same with a proxy before the door")


class Case(CaseBase):
    def _packets(self):
        return []


class Far:
    """A far bench that was as late as is said, and for which time passes as for everybody."""

    def __init__(self, lateness):
        self.said = lateness

    def lateness(self, _since_ns, _now_ns):
        return self.said

    def life_since(self, begin_ns):
        return lambda now_ns: now_ns - begin_ns


def case_of(late_ms=0, far=None, *, locked=True):
    """Return a case of a second, in which the host was late at once by so many ms."""
    bench, clock = Bench(Scheduler(), Journal()), FakeHostClock()
    if locked:
        bench.scheduler.lock(clock)
    if far is not None:
        bench.far.append(Far(far))
    case = Case(bench, INFO)
    if late_ms:
        clock.stall(clock.monotonic_ns() + NS_PER_MS, late_ms * NS_PER_MS)
    bench.run_for(1.0)
    return case


def told(case):
    return [event for event in case.journal.recent if event["kind"] == "host-lateness"]


@each(
    ("late_ms", "far", "least_s", "most_s"),
    [
        (0, None, 0.002, 0.002),
        (30, None, 0.030, 0.034),
        (300, None, 0.300, 0.352),
        (0, Lateness(late_ns=20 * NS_PER_MS, lost_ns=70 * NS_PER_MS), 0.089, 0.091),
        (30, Lateness(late_ns=20 * NS_PER_MS), 0.050, 0.054),
    ],
)
def test_the_journal_of_a_case_has_how_uncertain_its_times_are(late_ms, far, least_s, most_s):
    case = case_of(late_ms, far)
    case.finish("pass", "")
    (event,) = told(case)
    assert (event["source"], event["ns"]) == ("checker", case.now_ns)
    assert least_s <= event["uncertainty_s"] <= most_s
    assert event["uncertainty_s"] == case.uncertainty_s()


def test_it_is_no_part_of_what_a_case_is_known_by():
    calm, late = case_of(), case_of(30)
    for case in (calm, late):
        case.finish("pass", "")
    assert calm._hash == late._hash != ""
    assert told(calm) != told(late)


def test_virtual_time_is_never_late():
    case = case_of(locked=False)
    case.finish("pass", "")
    assert told(case) == []
    assert (case.uncertainty_s(), case.doubt().lateness_s, case.doubt().lived) == (0.0, 0.0, True)


@each(("late_ms", "far", "cause"), [
        (0, Lateness(late_ns=27_300_000), "the served bench was up to 27.3 ms late"),
        (0, Lateness(late_ns=9 * NS_PER_MS, lost_ns=300 * NS_PER_MS),
         "the served bench was up to 9.0 ms late and stood still for 0.300 s"),
        (16, Lateness(late_ns=20 * NS_PER_MS),
         "this bench was up to 16.0 ms late and the served bench was up to 20.0 ms late"),
        (16, Lateness(late_ns=NS_PER_MS), "this bench was up to 16.0 ms late"),
    ])  # fmt: skip
def test_who_was_late_is_said(late_ms, far, cause):
    assert case_of(late_ms, far).doubt().cause == cause


def test_only_a_late_case_is_in_doubt():
    assert case_of(far=IN_TIME).doubt().lateness_s == 0
    assert doubted(outcome_of(Untimely("no answer")), case_of().doubt()).verdict is Verdict.FAIL


@pytest.mark.slow("a bench that is served is stopped for half a second, behind a proxy")
@pytest.mark.real_time("it measures the lateness of a process that is stopped; the later it is, the clearer")
@pytest.mark.parametrize("doors", [pytest.param(1, marks=WITHOUT_PROXY), 2])
def test_a_process_that_is_stopped_is_found_late_by_a_check_at_its_door_and_behind_a_proxy(
    tmp_path, monkeypatch, doors
):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    paths = [str(tmp_path / f"line{number}") for number in range(doors)]
    commands = [["serve", "rover-model", "--pty", paths[0]], ["proxy", f"pty:{paths[-1]}", f"serial:{paths[0]}@115200"]]
    options = CheckOptions(bench="rover-model", targets=(TargetChoice(spec=f"serial:{paths[-1]}@115200"),))
    with ExitStack() as stack:
        served, *_ = [stack.enter_context(running(words)) for words in commands[:doors]]
        provider = stack.enter_context(closing(make_provider(options)))
        case = stack.enter_context(provider.open_case(INFO))
        bench, since_ns = case.bench, case.bench.now_ns
        served.send_signal(signal.SIGSTOP)
        assert bench.run_until(lambda: bench.far_lateness(since_ns).late_ns > 400 * NS_PER_MS, PATIENCE_S)
        served.send_signal(signal.SIGCONT)
        assert bench.run_until(lambda: bench.far_lateness(since_ns).lost_ns > 100 * NS_PER_MS, PATIENCE_S)
        assert case.uncertainty_s() > 0.1
        assert "the served bench was up to" in case.doubt().cause
        assert doubted(outcome_of(Untimely("no answer")), case.doubt()).verdict is Verdict.INCONCLUSIVE
        assert len([*(tmp_path / "hilbench" / "pace").iterdir()]) == doors
    assert not [*(tmp_path / "hilbench" / "pace").iterdir()]


def test_who_has_no_place_to_tell_it_serves_all_the_same(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    (tmp_path / "hilbench").mkdir()
    (tmp_path / "hilbench").chmod(0o755)  # whatever the umask
    said = []
    run_until_stopped(Scheduler(), said.append, lambda: True, notice=Notice())
    assert said[0].startswith("a check at these endpoints is not notified how late this bench is: ")
    assert said[0].endswith("is not a private folder of yours; remove it")
    assert said[-1].startswith("stopped after 0 s")


@contextmanager
def running(words):
    """Run a command of hilbench, from when it serves until it is interrupted."""
    command = [sys.executable, "-m", "hilbench", *words]
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdin=subprocess.DEVNULL) as process:
        try:
            said = b""
            while b"stop with" not in said:
                more = os.read(process.stderr.fileno(), 4096)
                assert more, said
                said += more
            yield process
        finally:
            process.send_signal(signal.SIGCONT)
            process.send_signal(signal.SIGINT)
            process.communicate(timeout=PATIENCE_S)


def test_serving_leaves_signals_as_it_found_them(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
    run_until_stopped(Scheduler(), str, lambda: True)
    assert signal.pthread_sigmask(signal.SIG_SETMASK, before) == before
