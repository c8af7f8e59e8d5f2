"""The client under test: our own, a program that is started, or whoever connects."""

from __future__ import annotations

import os
import select
import signal
import sys
import textwrap

import pytest

from hilbench.bench import Bench
from hilbench.bench.client_under_test import ExecClient, ListenClient
from hilbench.clock import NS_PER_S, Scheduler
from hilbench.errors import UnavailableError
from hilbench.journal import Journal
from hilbench.judging.verdicts import Violation
from hilbench.links import Line, MemoryLink
from hilbench.systems.pioneer.client import P2osClient
from hilbench.systems.pioneer.under_test import OwnClient

WAIT_S = 60
"""How long a test waits for a program, in seconds; a program that is right needs a fraction of one."""


@pytest.fixture(autouse=True)
def patience(monkeypatch):
    """A program that obeys is given the time it needs to."""
    monkeypatch.setattr("hilbench.bench.client_under_test._TERMINATE_WITHIN_S", WAIT_S)


@pytest.fixture
def program(tmp_path):
    """A program that tells by a FIFO what it was given and what happens to it."""
    fifo = tmp_path / "told"
    os.mkfifo(fifo)
    reader = os.open(fifo, os.O_RDONLY | os.O_NONBLOCK)
    os.set_blocking(reader, True)
    keep_open = os.open(fifo, os.O_WRONLY)
    source = tmp_path / "a client.py"

    class Program:
        def write(self, body):
            source.write_text(
                textwrap.dedent(f"""
                import os, signal, sys
                told = os.open({str(fifo)!r}, os.O_WRONLY)
                def tell(text): os.write(told, (text + "\\n").encode())
                """)
                + textwrap.dedent(body)
            )
            return f"{sys.executable} '{source}'"

        def told(self):
            line = b""
            while not line.endswith(b"\n"):
                assert select.select([reader], [], [], WAIT_S)[0], "the program says nothing"
                line += os.read(reader, 1)
            return line.decode().strip()

    yield Program()
    os.close(keep_open)
    os.close(reader)


WAITS_FOR_SIGNALS = """
    def interrupted(number, frame): tell("interrupted")
    def terminated(number, frame):
        tell("terminated")
        sys.exit(0)
    signal.signal(signal.SIGINT, interrupted)
    signal.signal(signal.SIGTERM, terminated)
    tell("started " + " ".join(sys.argv[1:]))
    while True: signal.pause()
"""


def test_a_program_gets_its_pty_and_its_port(program):
    command = program.write(WAITS_FOR_SIGNALS) + " --line={pty} 'localhost:{port}' {other}"
    client = ExecClient(command, {"pty": "/dev/pts/7", "port": "8101"})
    client.start()
    assert program.told() == "started --line=/dev/pts/7 localhost:8101 {other}"
    client.close()


def test_a_program_is_interrupted_to_disconnect_and_terminated_to_close(program):
    client = ExecClient(program.write(WAITS_FOR_SIGNALS), {})
    client.start()
    assert program.told() == "started"
    client.disconnect()
    assert program.told() == "interrupted"
    client.close()
    assert program.told() == "terminated"
    client.close()


@pytest.fixture
def interrupts_ignored():
    """As in what a script starts with &."""
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interrupts_ignored")
def test_a_program_is_interrupted_also_if_we_are_not_to_be(program):
    client = ExecClient(
        program.write("""
            try:
                tell("started")
                signal.pause()
            except KeyboardInterrupt:
                tell("interrupted")
            """),
        {},
    )
    client.start()
    assert program.told() == "started"
    client.disconnect()
    assert program.told() == "interrupted"
    assert signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    client.close()


def test_all_that_a_program_has_started_ends_with_it(program):
    client = ExecClient(
        program.write("""
            if os.fork():
                tell("parent")
                os.wait()
            else:
                def terminated(number, frame):
                    tell("child terminated")
                    os._exit(0)
                signal.signal(signal.SIGTERM, terminated)
                tell("child")
                while True: signal.pause()
            """),
        {},
    )
    client.start()
    assert {program.told(), program.told()} == {"parent", "child"}
    client.close()
    assert program.told() == "child terminated"


def test_a_program_that_will_not_end_is_killed(program, monkeypatch):
    monkeypatch.setattr("hilbench.bench.client_under_test._TERMINATE_WITHIN_S", 0.05)
    client = ExecClient(
        program.write("""
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
            tell(str(os.getpid()))
            while True: signal.pause()
            """),
        {},
    )
    client.start()
    pid = int(program.told())
    client.close()
    with pytest.raises(ProcessLookupError):
        os.kill(pid, 0)


def test_a_program_may_be_started_for_each_case(program):
    client = ExecClient(program.write(WAITS_FOR_SIGNALS), {})
    for _ in range(2):
        client.start()
        assert program.told() == "started"
        client.close()
        assert program.told() == "terminated"


def test_a_program_that_has_ended_by_itself_is_not_signalled(program):
    client = ExecClient(program.write("tell('done')"), {})
    client.start()
    assert program.told() == "done"
    client._process.wait(WAIT_S)
    client.disconnect()
    client.close()


def test_a_missing_program_is_named(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))  # a folder of one's own PATH may be closed to whoever runs this
    with pytest.raises(UnavailableError, match="exec:no-such-client-program") as raised:
        ExecClient("no-such-client-program {pty}", {"pty": "/dev/pts/7"}).start()
    assert "No such file" in str(raised.value)


# --- whoever connects


@pytest.fixture
def bench():
    return Bench(Scheduler(), Journal())


@pytest.fixture
def link(bench):
    return MemoryLink(bench.scheduler, Line(baud=9600))


def settle(bench):
    bench.run_for(0.001)


def test_a_listener_waits_for_somebody(bench, link):
    link.hang_up()
    settle(bench)
    bench.scheduler.after(5 * NS_PER_S, link.restore)
    ListenClient(bench, link.a).start()
    assert link.a.line_is_up
    assert bench.now_ns < 6 * NS_PER_S


def test_a_listener_does_not_wait_for_ever(bench, link):
    link.hang_up()
    settle(bench)
    with pytest.raises(UnavailableError, match="no client came within 30 s"):
        ListenClient(bench, link.a).start()


def test_a_listener_wants_a_fresh_client(bench, link):
    link.b.write(b"of the case before")
    bench.run_for(1.0)
    bench.scheduler.after(8 * NS_PER_S, link.hang_up)
    bench.scheduler.after(9 * NS_PER_S, link.restore)
    ListenClient(bench, link.a).start()
    assert bench.now_ns >= 10 * NS_PER_S
    assert link.a.line_is_up


def test_a_client_that_does_not_leave_is_no_fresh_one(bench, link):
    link.b.write(b"of the case before")
    bench.run_for(1.0)
    with pytest.raises(UnavailableError, match="has not left"):
        ListenClient(bench, link.a).start()


# --- our own


def test_our_client_can_be_asked(bench, link):
    client = P2osClient(bench, link.b)
    own = OwnClient(client)
    assert own.own is client
    own.start()
    with pytest.raises(Violation, match="does not begin"):
        own.start()
    own.disconnect()
    with pytest.raises(Violation, match="does not end cleanly"):
        own.disconnect()
    own.close()
