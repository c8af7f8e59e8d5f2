"""What is done to a real board before it is tested, and what a run does while its board is unplugged."""

from __future__ import annotations

import os
import sys
import tty

import pytest

from hilbench.bench import Bench
from hilbench.benchfile.line_hooks import Step, parse_step, run_hook
from hilbench.benchfile.reader import open_bench
from hilbench.check.bench_provider import make_provider
from hilbench.clock import NS_PER_MS, Scheduler
from hilbench.errors import AwayError, UnavailableError, UsageError
from hilbench.journal import Journal
from hilbench.judging.provider import CaseInfo
from hilbench.links import Line, LineSettings, MemoryLink, PtyDoor
from hilbench.terminal.options import CheckOptions, TargetChoice
from tests.each import each

BENCH = """
version = 1
[targets.rover]
model = "rover"
[port]
{port}
"""


@each(
    ("text", "step"),
    [
        ("dtr on", Step(dtr=True)),
        ("rts off", Step(rts=False)),
        ("dtr off rts on", Step(dtr=False, rts=True)),
        ("break 250ms", Step(break_ns=250 * NS_PER_MS)),
        ("wait 1s", Step(wait_ns=1000 * NS_PER_MS)),
        ("run usbrelay 'my relay'=1", Step(command=("usbrelay", "my relay=1"))),
    ],
)
def test_steps(text, step):
    assert parse_step(text) == step


@each("text", ["", "dtr", "dtr up", "dtr on dtr off", "wait", "wait 3", "run", "run 'x", "cts on"])
def test_no_steps(text):
    with pytest.raises(ValueError, match=r"."):
        parse_step(text)


class Board:
    """A line with lines beside the data, and what was done to them."""

    def __init__(self):
        self.bench = Bench(Scheduler(), Journal())
        self.done = []
        self.port = MemoryLink(self.bench.scheduler, Line(baud=9600)).a
        self.port.set_lines = self.set_lines
        self.port.send_break = lambda duration_ns: self.done.append((self.bench.now_ns, "break", duration_ns))

    def set_lines(self, **levels):
        self.done.append((self.bench.now_ns, levels))

    def run(self, *steps):
        run_hook(self.bench, self.port, "reset", steps)


def test_a_hook_is_done_in_order_and_takes_its_time(tmp_path):
    board, mark = Board(), tmp_path / "mark"
    board.run("dtr off rts on", "wait 100ms", f'run {sys.executable} -c \'open("{mark}", "w")\'', "dtr on", "break 2ms")
    assert board.done == [
        (0, {"dtr": False, "rts": True}),
        (100 * NS_PER_MS, {"dtr": True, "rts": None}),
        (100 * NS_PER_MS, "break", 2 * NS_PER_MS),
    ]
    assert board.bench.now_ns == 102 * NS_PER_MS
    assert mark.exists()
    assert [event["name"] for event in board.bench.journal.recent] == ["reset"]


def test_nothing_to_do_is_not_recorded():
    board = Board()
    board.run()
    assert not board.bench.journal.recent


@each(
    ("command", "message"),
    [
        ("/nonexistent/relay", "cannot be run"),
        (f"{sys.executable} -c 'import sys; sys.exit(\"no probe\")'", "ended with status 1: no probe"),
        (f"{sys.executable} -c 'import os; os.write(2, bytes([255, 10])); os._exit(3)'", "ended with status 3: \ufffd"),
        ("a\0b", "cannot be run"),
    ],
)
def test_a_command_that_fails_is_said_in_one_line(command, message):
    with pytest.raises(UnavailableError, match=message) as caught:
        Board().run(f"run {command}")
    assert str(caught.value).startswith("[port] reset: ")


def test_a_line_without_these_lines():
    board = Board()
    del board.port.set_lines
    with pytest.raises(UnavailableError, match="no DTR and RTS"):
        board.run("dtr on")


def test_a_break_that_nobody_gets_is_no_reset():
    bench = Bench(Scheduler(), Journal())
    door = PtyDoor(bench.scheduler, None, Line(baud=9600))
    door.line_is_up = True
    with pytest.raises(UnavailableError, match="a break cannot be sent"):
        run_hook(bench, door, "reset", ["break 2ms"])
    door.close()


@each("step", ["dtr on", "break 2ms"])
def test_a_step_at_a_port_that_is_gone_is_not_passed_over(step):
    board = Board()
    board.port.line_is_up = False
    with pytest.raises(UnavailableError, match="the port is gone"):
        board.run("wait 1ms", step)
    assert board.done == []


def bench_file(tmp_path, port):
    path = tmp_path / "bench.toml"
    path.write_text(BENCH.format(port=port))
    return path


def test_a_bench_file_says_how_a_port_is_opened(tmp_path):
    port = open_bench(str(bench_file(tmp_path, 'dtr = false\nparity = "E"\nreset = ["dtr on", "wait 1s"]'))).port
    assert port.settings == LineSettings(dtr=False, parity="E")
    assert (port.boot, port.reset) == ((), ("dtr on", "wait 1s"))


@pytest.mark.parametrize(
    ("port", "message"),
    [
        ('boot = ["dtr up"]', r"bench.toml:6: .*'dtr up' is no step"),
        ("speed = 3", r"bench.toml:6: .*speed"),
        ('parity = "M"', r"bench.toml:6: .*parity"),
    ],
)
def test_what_is_wrong_in_it_is_said_with_its_line(tmp_path, port, message):
    with pytest.raises(UsageError, match=message):
        open_bench(str(bench_file(tmp_path, port)))


class PtyBoard:
    """A pty under a name that stays, in the place of a rover that says nothing."""

    def __init__(self, path):
        self.path = path
        self.plug_in()

    def plug_in(self):
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.path.symlink_to(os.ttyname(self.slave))

    def pull_out(self):
        self.path.unlink()
        os.close(self.slave)
        os.close(self.master)


@pytest.fixture
def board(tmp_path):
    made = PtyBoard(tmp_path / "board")
    yield made
    made.pull_out()


def case(number):
    return CaseInfo(id=f"case {number}", clause_ids=(), seed=0)


@pytest.mark.usefixtures("skips")
def test_hooks_are_done_at_the_opening_and_before_each_case(tmp_path, board):
    file = bench_file(tmp_path, 'boot = ["run /bin/true"]\nreset = ["wait 1ms"]')
    provider = make_provider(CheckOptions(bench=str(file), targets=(TargetChoice(spec=f"serial:{board.path}"),)))
    for number in range(2):
        with provider.open_case(case(number)) as bench:
            bench.finish("fail", "")
    hooks = [event["name"] for event in provider._shared.journal.recent if event["kind"] == "hook"]
    provider.close()
    assert hooks == ["boot", "reset", "reset"]


@pytest.mark.usefixtures("skips")
def test_a_case_whose_board_goes_is_no_verdict_and_the_next_one_waits_for_its_return(tmp_path, board, monkeypatch):
    file = bench_file(tmp_path, "")
    provider = make_provider(CheckOptions(bench=str(file), targets=(TargetChoice(spec=f"serial:{board.path}"),)))
    with provider.open_case(case(1)) as bench:
        board.pull_out()
        provider._bench.run_until(lambda: not bench.peer.port.line_is_up, 30)
        board.plug_in()
        assert provider._bench.run_until(lambda: bench.peer.port.line_is_up, 30)
        with pytest.raises(AwayError, match="the target closed the line"):
            bench.peer.require_line()  # though it is back
        bench.finish("error", "")
    board.pull_out()
    provider._bench.run_until(lambda: not bench.peer.port.line_is_up, 30)
    provider._scheduler.after(300 * NS_PER_MS, board.plug_in)
    with provider.open_case(case(2)) as bench:
        bench.peer.require_line()
        bench.finish("fail", "")
    monkeypatch.setattr("hilbench.bench.locked_providers.RETURN_WITHIN_S", 0.1)
    board.pull_out()
    provider._bench.run_until(lambda: not bench.peer.port.line_is_up, 30)
    with pytest.raises(UnavailableError, match="has not come back"), provider.open_case(case(3)):
        pass
    board.plug_in()
    provider.close()
