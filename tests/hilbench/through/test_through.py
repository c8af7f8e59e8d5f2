from __future__ import annotations

import contextlib
import errno
import gc
import os
import threading
import time
from types import SimpleNamespace

import pytest
from serial.serialutil import Timeout

from hilbench.check import CheckOptions, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.cli import main
from hilbench.clock import Scheduler
from hilbench.errors import InternalError, UnavailableError
from hilbench.links import Line, MemoryLink, PtyDoor, Rfc2217Door, TcpDoor
from hilbench.serving.relay import Relay
from hilbench.terminal.options import THROUGH
from hilbench.through import Routes, loop, way
from hilbench.through.loop import settle
from tests.share import few

TWO_LINES = pytest.mark.exhaustive("the gate has each door, and each bench, in another pair")
ALL_BYTES = bytes(range(256)) * 20
DOORS = {"pty": PtyDoor, "tcp": TcpDoor, "rfc2217": Rfc2217Door, "proxy": PtyDoor}
WORDS = {
    "pty": "through pseudo-terminals of this machine",
    "tcp": "through TCP sockets of this machine",
    "rfc2217": "through RFC 2217 within this machine",
    "proxy": "through pseudo-terminals of this machine, a proxy between two each",
}


@pytest.fixture(autouse=True)
def at_once(monkeypatch):
    """Have pyserial hang up at once, and its client of RFC 2217 look for answers as soon as they may be there.

    By itself it lets 0.3 s pass once it has hung up, looks 20 times a second, and gives up after three.
    """
    for module in ("serial.rfc2217", "serial.urlhandler.protocol_socket"):
        monkeypatch.setattr(f"{module}.time", SimpleNamespace(sleep=lambda _s: time.sleep(0.001)))
    monkeypatch.setattr("serial.rfc2217.Timeout", lambda seconds: Timeout(600 if seconds == 3 else seconds))


@pytest.fixture(params=THROUGH)
def kind(request):
    return request.param


def lined(ways):
    """Return both ends of a line in memory, the first one behind a door, and what it is on."""
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=921_600), name="line")
    return scheduler, ways(link.a), link.b


@pytest.fixture
def line(kind):
    with contextlib.closing(Routes(kind)) as ways:
        yield lined(ways)


def left():
    """What this process has open; a client that has come in is about to end, and so is what nothing leads to."""
    for thread in threading.enumerate():
        if thread.name.startswith("client"):
            thread.join()
    gc.collect()  # an epoll of an earlier test is closed when it is collected, which may be between two calls
    opened = {}
    for name in os.listdir("/proc/self/fd"):
        with contextlib.suppress(FileNotFoundError):  # that of the listing itself
            opened[name] = os.readlink(f"/proc/self/fd/{name}")
    return opened, [thread.name for thread in threading.enumerate()]


def heard_by(port):
    heard = bytearray()
    port.on_receive = lambda data, _at_ns: heard.extend(data)
    return heard


def test_every_byte_passes_both_ways_as_it_is(line):
    scheduler, near, far = line
    at_near, at_far = heard_by(near), heard_by(far)
    near.write(ALL_BYTES)
    far.write(ALL_BYTES[::-1][:64])
    scheduler.run_for(10**9)
    assert at_far == ALL_BYTES
    assert at_near == ALL_BYTES[::-1][:64]
    assert (near.counters.sent, near.counters.received) == (len(ALL_BYTES), 64)


def test_what_is_on_the_way_is_what_a_bench_has_in_real_time(kind, monkeypatch):
    """A door that upsets bytes is noticed."""
    door = DOORS[kind]
    put = door._put
    monkeypatch.setattr(door, "_put", lambda self, data, at_ns: put(self, data.upper(), at_ns))
    relayed = []
    hand_on = Relay._pass
    monkeypatch.setattr(Relay, "_pass", lambda self, *words: relayed.append(words[3]) or hand_on(self, *words))
    with contextlib.closing(Routes(kind)) as ways:
        scheduler, _, far = lined(ways)
        far.write(b"d")
        with pytest.raises(InternalError, match=r"b'd' has come out as b'D'"):
            scheduler.run_for(10**9)
    assert len(relayed) == (1 if kind == "proxy" else 0)


@pytest.mark.parametrize("back", [False, True], ids=["same-way", "other-way"])
def test_a_door_that_invents_bytes_is_noticed(kind, back, monkeypatch):
    door = DOORS[kind]
    put = door._put

    def put_twice(self, data, at_ns):
        put(self, data * 2, at_ns)

    monkeypatch.setattr(door, "_put", put_twice)
    with contextlib.closing(Routes(kind)) as ways:
        scheduler, near, far = lined(ways)
        with pytest.raises(InternalError, match="come"):
            for value in b"abc":
                far.write(bytes([value]))
                scheduler.run_for(10**9)
                if back:
                    near.write(b"x")
                    scheduler.run_for(10**9)


def test_a_door_that_keeps_bytes_is_an_error(kind, monkeypatch):
    monkeypatch.setattr(DOORS[kind], "_put", lambda *_: None)
    with contextlib.closing(Routes(kind)) as ways:
        scheduler, _, far = lined(ways)
        monkeypatch.setattr(loop, "_ROUNDS", 2)
        far.write(b"x")
        with pytest.raises(UnavailableError, match=r"line.a: 0 of 1 bytes have passed, and no more come"):
            scheduler.run_for(10**9)


def test_a_door_at_which_nobody_gets_in_is_an_error(kind, monkeypatch):
    monkeypatch.setattr(way, "settle", lambda *_: False)
    unused = []

    class Nobody:
        def close(self):
            unused.append(self)

    monkeypatch.setattr(way, "ReconnectingPort", lambda *_: Nobody())
    with contextlib.closing(Routes(kind)) as ways, pytest.raises(UnavailableError, match="no client has connected"):
        lined(ways)
    assert unused
    assert ways.words.startswith("line.a could not be led through ")


def test_a_client_that_is_turned_away_tries_again_and_what_it_runs_into_is_said(kind, monkeypatch):
    tried = []

    def refuse(*_):
        tried.append(True)
        raise UnavailableError("refused", where="here")

    monkeypatch.setattr(way, "ReconnectingPort", refuse)
    with contextlib.closing(Routes(kind)) as ways, pytest.raises(UnavailableError, match="refused"):
        lined(ways)
    assert len(tried) == 3


def full(*_args, **_names):
    raise OSError(errno.EMFILE, "Too many open files")


def test_want_of_descriptors_is_said(kind, monkeypatch):
    monkeypatch.setattr(way, "Loop", full)
    with contextlib.closing(Routes(kind)) as ways, pytest.raises(UnavailableError, match="Too many open files"):
        lined(ways)


@pytest.mark.parametrize("kind", ["pty", "proxy"])
def test_want_of_room_for_links_is_said(kind, monkeypatch):
    monkeypatch.setattr(way.tempfile, "TemporaryDirectory", full)
    with contextlib.closing(Routes(kind)) as ways, pytest.raises(UnavailableError, match="Too many open files"):
        lined(ways)


@pytest.mark.parametrize("kind", few(THROUGH, 2, "the other doors"))
def test_an_interrupted_opening_leaves_nothing(kind, monkeypatch):
    before = left()

    def interrupted(others, done):
        settle(others, done)
        raise KeyboardInterrupt

    monkeypatch.setattr(way, "settle", interrupted)
    ways = Routes(kind)
    with pytest.raises(KeyboardInterrupt):
        lined(ways)
    ways.close()
    assert left() == before


def test_what_else_a_port_does_reaches_the_port(line):
    scheduler, near, far = line
    breaks, lines = [], []
    far.on_break = breaks.append
    near.on_line = lambda up, _at_ns: lines.append(up)
    near.write(b"1")
    assert near.pending == 1
    near.send_break(10**6)
    scheduler.run_for(10**9)
    assert len(breaks) == 1
    near.baud = 9600
    assert near.baud == 9600
    far.close()
    scheduler.run_for(10**6)
    assert lines == [False]
    assert not near.line_is_up
    near.close()
    assert near.closed


@pytest.mark.parametrize("kind", few(THROUGH, 1, "the other doors, which are closed as well after each test here"))
def test_nothing_is_left_of_a_run_that_is_over(kind, tmp_path, monkeypatch):
    monkeypatch.setattr(way.tempfile, "tempdir", str(tmp_path))
    options = CheckOptions(bench="rover-model", suites=("pkt-board",), select="P01 and documented", through=kind)
    before = left()
    provider = make_provider(options)
    run_suites(options, provider)
    assert left() != before
    provider.close()
    assert left() == before
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("kind", "bench", "suite", "select"),
    [("pty", "pioneer-plane", "p2os-server", "S01"), ("proxy", "pioneer-plane", "p2os-client", "C01"),
     ("tcp", "rover-model", "pkt-board", "P01"), ("rfc2217", "rover-model", "pkt-host", "P50"),
     pytest.param("rfc2217", "vehicle-model", "vehicle-board", "VB05H", marks=TWO_LINES),
     ("tcp", "vehicle-model", "vehicle-host", "VS01")],
)  # fmt: skip
def test_a_run_is_the_same_with_it_and_without(kind, bench, suite, select, monkeypatch):
    def run(through):
        options = CheckOptions(bench=bench, suites=(suite,), select=select, through=through)
        provider = make_provider(options)
        with contextlib.closing(provider):
            return run_suites(options, provider)

    passed = []
    send = way.Way._pass
    monkeypatch.setattr(way.Way, "_pass", lambda *words: passed.append(words[3]) or send(*words))
    without = run("")
    assert not passed
    with_it = run(kind)
    assert sum(map(len, passed)) >= 10
    assert with_it.run_hash == without.run_hash
    assert with_it.bench["lines"] == WORDS[kind]
    assert f"--through {kind}" in with_it.clauses[0].reproduce
    assert "--through" not in without.clauses[0].reproduce


def test_a_checker_without_a_line_says_so():
    assert Routes("tcp").words == "nothing has passed TCP sockets of this machine: the checker has had no line"


@pytest.mark.parametrize("target", ["serial:/dev/null", "capture:run.jsonl", "listen:tcp:0"])
def test_what_has_a_port_of_its_own_has_its_way_there(target, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    suite = "p2os-client" if "listen" in target else "p2os-server"
    assert main(["check", "--through", "pty", "--target", target, "--suite", suite]) == 2
    assert "--through" in capsys.readouterr().err
