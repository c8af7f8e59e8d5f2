"""Who is asked for what needs a hand on a target: in which order, by a command, at a terminal."""

from __future__ import annotations

import json
import os
import select
import subprocess
import sys
from contextlib import closing, contextmanager, suppress

import pytest

from hilbench.bench import Bench, operator_terminal
from hilbench.bench.devices import DeviceActor
from hilbench.bench.operator import CANNOT, DONE, Asked, NobodyThereError, Operator
from hilbench.bench.operator_hook import CANNOT_STATUS, CommandAsOperator
from hilbench.bench.operator_terminal import LIMIT_S, PersonAtTerminal
from hilbench.benchfile.line_hooks import COMMAND_LIMIT_S
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.cli import main
from hilbench.clock import NS_PER_MS, MonotonicHostClock, Scheduler
from hilbench.errors import UnavailableError, UsageError
from hilbench.journal import Journal
from hilbench.judging.provider import CaseInfo
from hilbench.judging.verdicts import NotApplicable
from hilbench.links import Line, PtyDoor
from hilbench.plugins.system import HandRequest
from hilbench.terminal.options import TargetChoice
from targets.robots.rover import RoverRobot, RoverSettings
from tests.each import each
from tests.hilbench.hosts import SkippingHost

REQUESTS = {
    "press": HandRequest(text="press the {} button", capability="button"),
    "hold": HandRequest(text="hold the lever", capability="lever", undo="release"),
    "release": HandRequest(text="let go of the lever", capability="lever"),
    "lamp": HandRequest(text="is the lamp lit?", capability="lamp", answers=("lit", "dark", "dim")),
}
CASE = CaseInfo(id="x/y", clause_ids=("X1",), seed=0)
PRESS = Asked(name="press", words=("red",), text="press the red button", answers=(DONE,), clause_ids=("X1",))
LAMP = Asked(name="lamp", words=(), text="is the lamp lit?", answers=("lit", "dark", "dim"), clause_ids=("X1", "X2"))
PATIENCE_S = 60


class Scripted:
    def __init__(self, *answers):
        self.answers, self.asked = [*answers], []

    def answer(self, _bench, asked):
        self.asked.append(asked.name)
        answer = self.answers.pop(0)
        if isinstance(answer, Exception):
            raise answer
        return answer

    def last(self, asked):
        self.asked.append(f"last {asked.name}")

    def close(self):
        self.asked.append("close")


@pytest.fixture
def bench():
    return Bench(Scheduler(), Journal())


@contextmanager
def locked(host):
    """A bench in the time of a host."""
    scheduler = Scheduler()
    with closing(host):
        scheduler.lock(host)
        yield Bench(scheduler, Journal())
        scheduler.unlock()


# --- the operator


def test_a_request_has_the_words_of_its_case_and_gets_an_answer(bench):
    operator = Operator(REQUESTS, [Scripted(DONE, "dark")])
    assert operator.ask(bench, CASE, "press", "red") == DONE
    assert operator.ask(bench, CASE, "lamp") == "dark"
    assert operator.capabilities == {"button", "lever", "lamp"}


def test_the_next_is_asked_where_one_cannot(bench):
    first, second = Scripted(CANNOT, DONE, CANNOT), Scripted("lit", CANNOT)
    operator = Operator(REQUESTS, [first, second])
    assert operator.ask(bench, CASE, "lamp") == "lit"
    assert operator.ask(bench, CASE, "hold") == DONE
    with pytest.raises(NotApplicable, match=r"^the operator cannot: press the red button$"):
        operator.ask(bench, CASE, "press", "red")
    assert (first.asked, second.asked) == (["lamp", "hold", "press"], ["lamp", "press"])


def test_who_has_not_answered_is_not_asked_again(bench):
    away = Scripted(NobodyThereError("the operator did not answer"))
    operator = Operator(REQUESTS, [away])
    for _ in range(2):
        with pytest.raises(NotApplicable, match=r"^the operator did not answer: is the lamp lit\?$"):
            operator.ask(bench, CASE, "lamp")
    assert away.asked == ["lamp"]


def test_what_was_done_is_taken_back_once(bench):
    somebody = Scripted(DONE, DONE)
    operator = Operator(REQUESTS, [somebody])
    operator.ask(bench, CASE, "hold")
    operator.restore(bench)
    operator.restore(bench)
    operator.close()
    assert somebody.asked == ["hold", "release", "close"]


def test_what_nobody_takes_back_ends_no_run_and_is_said_last(bench):
    somebody = Scripted(DONE, CANNOT, DONE)
    operator = Operator(REQUESTS, [somebody])
    operator.ask(bench, CASE, "hold")
    operator.restore(bench)
    operator.ask(bench, CASE, "hold")
    operator.close()
    assert somebody.asked == ["hold", "release", "hold", "last release", "close"]


# --- a command


def hook(tmp_path, body):
    """A command of these lines of Python; what it was called with, and its input, are in `words`, `request`."""
    script = tmp_path / "hook.py"
    script.write_text(f"import json, sys\nwords, request = sys.argv[1:], json.load(sys.stdin)\n{body}\n")
    return CommandAsOperator([sys.executable, str(script)])


def answered(command, asked):
    with locked(MonotonicHostClock()) as bench:
        return command.answer(bench, asked)


def test_a_command_gets_the_request_and_answers(tmp_path):
    log = tmp_path / "log"
    body = f"open({str(log)!r}, 'w').write(json.dumps([words, request])); print(' Dark '); print('more')"
    command = hook(tmp_path, body)
    assert answered(command, LAMP) == "dark"
    assert json.loads(log.read_text()) == [
        ["lamp"],
        {
            "request": "lamp",
            "words": [],
            "text": "is the lamp lit?",
            "answers": ["lit", "dark", "dim"],
            "clauses": ["X1", "X2"],
        },
    ]
    assert answered(command, PRESS) == DONE
    words, request = json.loads(log.read_text())
    assert (words, request["words"], request["answers"]) == (["press", "red"], ["red"], [])
    log.unlink()
    command.last(PRESS)
    assert log.exists()


def test_a_command_may_say_that_it_cannot_and_a_broken_one_ends_the_run(tmp_path):
    assert answered(hook(tmp_path, f"sys.exit({CANNOT_STATUS})"), LAMP) == CANNOT
    for body, said in (
        ("sys.exit('no relay at /dev/relay')", "hook: .* lamp ended with status 1: no relay at /dev/relay$"),
        ("print('blue')", "hook: .* lamp answered 'blue', and not lit or dark or dim$"),
        ("", "hook: .* lamp answered '', and not lit or dark or dim$"),
    ):
        with pytest.raises(UnavailableError, match=said):
            answered(hook(tmp_path, body), LAMP)


def test_a_command_that_does_not_end_is_ended(tmp_path):
    command = hook(tmp_path, "import time\nwhile True: time.sleep(1)")
    with (
        locked(SkippingHost()) as bench,
        pytest.raises(UnavailableError, match=f"did not end within {COMMAND_LIMIT_S:g} s"),
    ):
        command.answer(bench, LAMP)


def test_a_command_need_not_read_its_request():
    assert answered(CommandAsOperator(["true"]), PRESS) == DONE


@each("words", [(), ("no-such-command",), ("/dev/null",)])
def test_a_command_that_is_none_is_refused(words):
    with pytest.raises(UsageError, match=r"--operator-hook: '.*' is no command that can be run"):
        CommandAsOperator(words)


# --- a terminal


class Terminal:
    """A terminal, and the fingers of a person at it, who types a line when he has read enough."""

    def __init__(self):
        self._master, self._slave = os.openpty()
        os.set_blocking(self._master, False)
        self.name, self.shown, self._lines, self._answered = os.ttyname(self._slave), "", [], 0

    def type(self, bench, *lines):
        """Type these lines, each behind another prompt, which ends in a colon and a blank."""
        self._lines += lines
        self._look(bench)

    def _look(self, bench):
        with suppress(BlockingIOError):
            self.shown += os.read(self._master, 4096).decode()
        asked = "cannot" in self.shown[self._answered :] and self.shown.endswith(": ")
        if self._lines and asked:
            self._answered = len(self.shown)
            os.write(self._master, self._lines.pop(0).encode())
        if self._lines:
            bench.scheduler.after(NS_PER_MS, lambda: self._look(bench))

    def read(self):
        while select.select([self._master], [], [], 0)[0]:
            self.shown += os.read(self._master, 4096).decode()
        return self.shown

    def close(self):
        os.close(self._master)
        os.close(self._slave)


@pytest.fixture
def terminal(monkeypatch):
    with closing(Terminal()) as made:
        monkeypatch.setattr(operator_terminal, "_TERMINAL", made.name)
        yield made


@each("asked, lines, answer, prompts", [
    (PRESS, ["\n"], DONE, ["X1: press the red button, then Enter (or cannot; within 120 s): "]),
    (PRESS, ["c\n"], CANNOT, []),
    (PRESS, ["done\n"], DONE, []),
    (LAMP, ["Lit\n"], "lit", ["X1, X2: is the lamp lit? lit, dark, dim (or cannot; within 120 s): "]),
    (LAMP, ["\n", "d\n", "blue\n", " da \n"], "dark", [
        "'' is none of lit, dark, dim, cannot: ", "'d' is none of", "'blue' is none of",
    ]),
    (LAMP, ["cannot\n"], CANNOT, []),
])  # fmt: skip
def test_a_person_is_asked_at_the_terminal(monkeypatch, asked, lines, answer, prompts):
    with closing(Terminal()) as terminal, locked(MonotonicHostClock()) as bench:
        monkeypatch.setattr(operator_terminal, "_TERMINAL", terminal.name)
        with closing(PersonAtTerminal()) as person:
            terminal.type(bench, *lines)
            assert person.answer(bench, asked) == answer
        shown = terminal.read()
        assert [prompt for prompt in prompts if prompt not in shown] == []


def test_bench_time_goes_on_while_a_person_thinks(terminal):
    with locked(MonotonicHostClock()) as bench, closing(PersonAtTerminal()) as person:
        beats = []
        for number in range(5):
            bench.scheduler.after(number * 10 * NS_PER_MS, lambda number=number: beats.append(number))
        bench.scheduler.after(60 * NS_PER_MS, lambda: terminal.type(bench, "\n"))
        assert person.answer(bench, PRESS) == DONE
        assert beats == [*range(5)]


def test_a_person_who_does_not_answer_is_not_waited_for_any_longer(terminal):
    with locked(SkippingHost()) as bench, closing(PersonAtTerminal()) as person:
        with pytest.raises(NobodyThereError, match=f"did not answer within {LIMIT_S:g} s"):
            person.answer(bench, LAMP)
        assert bench.now_s == pytest.approx(LIMIT_S)


def test_a_person_who_leaves_the_terminal_is_gone(terminal):
    with locked(MonotonicHostClock()) as bench, closing(PersonAtTerminal()) as person:
        terminal.type(bench, "\x04")
        with pytest.raises(NobodyThereError, match="has left the terminal"):
            person.answer(bench, LAMP)


def test_whoever_interrupts_at_any_moment_leaves_nothing_watched(terminal):
    class Interrupted(SkippingHost):
        def watch(self, source):
            raise KeyboardInterrupt

    with locked(Interrupted()) as bench, closing(PersonAtTerminal()) as person, pytest.raises(KeyboardInterrupt):
        person.answer(bench, PRESS)


def test_what_is_left_to_undo_is_said_as_the_check_ends(terminal):
    with closing(PersonAtTerminal()) as person:
        person.last(PRESS)
    assert "the check is over: press the red button" in terminal.read()


# --- a check


def put_a_rover(provider, tmp_path):
    """Put a model of a rover at the far end of the pty that a provider opens, in its own bench time."""
    door = PtyDoor(provider._scheduler, str(tmp_path / "rover"), Line(baud=115200), any_baud=True)
    robot = RoverRobot(RoverSettings())
    DeviceActor(provider._bench, robot, door, name="rover")
    return door, robot


def options_for(tmp_path, **more):
    target = TargetChoice(spec=f"serial:{tmp_path / 'rover'}@115200")
    return CheckOptions(bench="rover-model", targets=(target,), suites=("pkt-board",), **more)


@pytest.mark.slow("a check behind a pseudo-terminal, and its operator at another")
@pytest.mark.real_time("a rover behind a pseudo-terminal; where the host is late, nothing is concluded")
def test_a_check_asks_at_the_terminal(tmp_path, terminal):
    options = options_for(tmp_path, operator=True, select="documented and P02D")
    provider = make_provider(options)
    door, _ = put_a_rover(provider, tmp_path)
    with closing(door):
        terminal.type(provider._bench, "dark\n", "lit\n")
        report = run_suites(options, provider)
        provider.close()
    (case,) = report.cases
    assert case.asked == ("is the test LED lit?: dark", "is the test LED lit?: lit")
    assert case.verdict in {Verdict.PASS, Verdict.INCONCLUSIVE}
    assert report.clauses[0].reproduce.endswith("-k P02D --seed 0 --operator")
    assert "P02D: is the test LED lit? lit, dark (or cannot" in terminal.read()


@pytest.mark.slow("a check behind a pseudo-terminal, and a process for each request")
@pytest.mark.real_time("a rover behind a pseudo-terminal; where the host is late, nothing is concluded")
def test_a_check_asks_a_command(tmp_path):
    script = tmp_path / "hook.sh"
    script.write_text(f'#!/bin/sh\necho "$@" >>{tmp_path}/log\n[ "$1" != led ] || exit {CANNOT_STATUS}\n')
    script.chmod(0o755)
    options = options_for(tmp_path, operator_hook=(str(script),), select="documented and (P02D or P26)")
    provider = make_provider(options)
    door, robot = put_a_rover(provider, tmp_path)
    with closing(door):
        robot.plant.force(0.0)
        report = run_suites(options, provider)
        provider.close()
    verdicts = {clause.id: (clause.verdict, clause.cause) for clause in report.clauses}
    assert verdicts["P02D"] == (Verdict.NOT_APPLICABLE, "the operator cannot: is the test LED lit?")
    assert verdicts["P26"][0] in {Verdict.PASS, Verdict.INCONCLUSIVE}
    assert (tmp_path / "log").read_text().splitlines() == ["led", "hold-wheels", "release-wheels"]
    assert report.clauses[0].reproduce.endswith(f"--operator-hook {script}")


def test_the_list_says_what_is_asked_and_needs_no_terminal(tmp_path):
    options = options_for(tmp_path, operator=True, list_only=True, select="documented and (P26 or P29D or P67)")
    provider = make_provider(options)
    listed = {case.clause_ids[0]: (case.missing, case.by_hand) for case in list_cases(options, provider)}
    provider.close()
    assert listed == {
        "P26": ((), {"wheels"}),
        "P29D": (("wheels",), frozenset()),  # nobody's eye tells how fast they turn
        "P67": ((), frozenset()),
    }


NOBODY = [
    ("check rover-model --operator", "--operator: this bench never asks an operator; name the port"),
    ("check pioneer --operator", "--operator: this target never needs an operator"),
    ("check rover-model --operator-hook no-such", "--operator-hook: 'no-such' is no command that can be run"),
    ("check rover-model --operator-hook ''", "--operator-hook: '' is no command"),
    ("check rover-model --operator-hook true", "--operator-hook: this bench never asks an operator"),
]


@each("line, said", NOBODY)
def test_a_bench_where_nobody_is_asked_has_no_operator(capfd, terminal, line, said):
    words = [word.strip("'") for word in line.split()]
    assert main(words) == 2
    out, err = capfd.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert said in err


@pytest.mark.slow("a process of the command")
def test_without_a_terminal_it_says_so_in_a_line(tmp_path):
    words = ["check", "rover-model", "--target", f"serial:{tmp_path}/none", "--operator"]
    done = subprocess.run(
        [sys.executable, "-m", "hilbench", *words], start_new_session=True, capture_output=True, text=True, check=False
    )
    said = (
        "hilbench: --operator: there is no terminal to ask at; run it at one, or name a command: --operator-hook CMD\n"
    )
    assert (done.returncode, done.stdout, done.stderr) == (2, "", said)


@pytest.mark.exhaustive("a check and what it checks; the gate interrupts a check in test_cli_process")
@pytest.mark.slow("a check and what it checks, in processes of their own, with a terminal")
def test_ctrl_c_ends_a_check_that_waits_for_its_operator(tmp_path):
    line, (master, slave) = str(tmp_path / "rover"), os.openpty()
    options = ["--target", f"serial:{line}@115200", "--suite", "pkt-board", "-k", "P26", "--operator"]
    serve = [sys.executable, "-m", "hilbench", "serve", "rover-model", "--pty", line]
    command = [sys.executable, "-c", AT_TERMINAL, os.ttyname(slave), "check", "rover-model", *options]
    with running(serve, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as served:
        served.stdout.readline()
        with running(command, start_new_session=True, stdin=slave, stdout=slave, stderr=slave) as checked:
            hear(master, b"hold all four wheels")
            os.write(master, b"\x03")
            hear(master, b"exit 130: interrupted")
            checked.wait()
    os.close(master)
    os.close(slave)
    assert checked.returncode == 130


AT_TERMINAL = """
import os, sys
os.open(sys.argv[1], os.O_RDWR)  # what a process without a terminal opens becomes its own
os.execv(sys.executable, [sys.executable, "-m", "hilbench", *sys.argv[2:]])
"""


@contextmanager
def running(command, **more):
    """Run a command for as long as this lasts."""
    with subprocess.Popen(command, **more) as process:
        try:
            yield process
        finally:
            process.kill()


def hear(master, words):
    """Read a terminal until it has shown these words."""
    shown = b""
    while words not in shown:
        assert select.select([master], [], [], PATIENCE_S)[0], shown
        shown += os.read(master, 4096)
    return shown
