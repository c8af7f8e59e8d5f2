from __future__ import annotations

import contextlib
import gc
import os
import threading

import pytest

from hilbench.bench_provider import make_provider
from hilbench.check import CheckOptions, run_suites
from hilbench.cli import main
from hilbench.clock import Scheduler
from hilbench.errors import UnavailableError
from hilbench.links import Line, MemoryLink, PtyDoor, Rfc2217Door, TcpDoor
from hilbench.options import THROUGH
from hilbench.relay import Relay
from hilbench.through import Passages, loop, passages

ALL_BYTES = bytes(range(256)) * 20
DOORS = {"pty": PtyDoor, "tcp": TcpDoor, "rfc2217": Rfc2217Door, "proxy": PtyDoor}
WORDS = {
    "pty": "through pseudo-terminals of this machine",
    "tcp": "through TCP sockets of this machine",
    "rfc2217": "through RFC 2217 of this machine",
    "proxy": "through a proxy between two pseudo-terminals each of this machine",
}


@pytest.fixture(params=THROUGH)
def kind(request):
    return request.param


@pytest.fixture
def line(kind):
    """Both ends of a line in memory, the first one behind a door."""
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=921_600), name="line")
    ways = Passages(kind)
    yield scheduler, ways(link.a), link.b
    ways.close()


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
    """A door that upsets bytes upsets those that come out."""
    door = DOORS[kind]
    put = door._put
    monkeypatch.setattr(door, "_put", lambda self, data, at_ns: put(self, data.upper(), at_ns))
    relayed = []
    hand_on = Relay._pass
    monkeypatch.setattr(Relay, "_pass", lambda self, *words: relayed.append(words[3]) or hand_on(self, *words))
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=921_600), name="line")
    ways = Passages(kind)
    at_near = heard_by(ways(link.a))
    link.b.write(b"door")
    scheduler.run_for(10**9)
    ways.close()
    assert at_near == b"DOOR"
    assert len(relayed) == (4 if kind == "proxy" else 0)


def test_a_door_that_keeps_bytes_is_an_error(kind, monkeypatch):
    monkeypatch.setattr(DOORS[kind], "_put", lambda *_: None)
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=921_600), name="line")
    ways = Passages(kind)
    ways(link.a)
    monkeypatch.setattr(loop, "_ROUNDS", 2)
    link.b.write(b"x")
    with pytest.raises(UnavailableError, match=r"line.a: 0 of 1 bytes have passed, and no more come"):
        scheduler.run_for(10**9)
    ways.close()


def test_a_door_at_which_nobody_gets_in_is_an_error(kind, monkeypatch):
    monkeypatch.setattr(passages, "settle", lambda *_: False)
    monkeypatch.setattr(passages, "ReconnectingPort", Nobody)
    link = MemoryLink(Scheduler(), Line(baud=921_600), name="line")
    ways = Passages(kind)
    with pytest.raises(UnavailableError, match="nobody has come in at the door"):
        ways(link.a)
    ways.close()


class Nobody:
    def __init__(self, *_):
        self.closed = False

    def close(self):
        self.closed = True


def test_what_a_client_runs_into_is_said(kind, monkeypatch):
    def refuse(*_):
        raise UnavailableError("refused", where="here")

    monkeypatch.setattr(passages, "ReconnectingPort", refuse)
    link = MemoryLink(Scheduler(), Line(baud=921_600), name="line")
    ways = Passages(kind)
    with pytest.raises(UnavailableError, match="refused"):
        ways(link.a)
    ways.close()


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


def test_nothing_is_left_when_nobody_needs_the_ways_any_more(kind):
    def left():
        return sorted(os.listdir("/proc/self/fd")), threading.active_count()

    before = left()
    ways = Passages(kind)
    folder = ways.folder
    port = ways(MemoryLink(Scheduler(), Line(baud=9600), name="line").a)
    assert folder.is_dir()
    assert left() != before
    del ways, port
    gc.collect()
    assert left() == before
    assert not folder.exists()


@pytest.mark.parametrize(
    ("kind", "bench", "suite", "select"),
    [("pty", "pioneer-plane", "p2os-server", "S01"), ("proxy", "pioneer-plane", "p2os-client", "C01"),
     ("tcp", "rover-model", "pkt-board", "P01"), ("rfc2217", "rover-model", "pkt-host", "P50"),
     ("rfc2217", "vehicle-model", "vehicle-board", "VB05H"), ("tcp", "vehicle-model", "vehicle-host", "VS01")],
)  # fmt: skip
def test_a_run_is_the_same_with_it_and_without(kind, bench, suite, select, monkeypatch):
    def run(through):
        options = CheckOptions(bench=bench, suites=(suite,), select=select, through=through)
        provider = make_provider(options)
        with contextlib.closing(provider):
            return run_suites(options, provider)

    passed = []
    send = passages._Way._pass
    monkeypatch.setattr(passages._Way, "_pass", lambda *words: passed.append(words[3]) or send(*words))
    without = run("")
    assert not passed
    with_it = run(kind)
    assert sum(map(len, passed)) >= 10
    assert with_it.run_hash == without.run_hash
    assert with_it.bench["lines"] == WORDS[kind]


def test_a_checker_without_a_line_says_so():
    assert Passages("tcp").words == "nothing has passed TCP sockets: the checker has had no line"


@pytest.mark.parametrize("target", ["serial:/dev/null", "capture:run.jsonl", "listen:tcp:0"])
def test_what_has_a_port_of_its_own_has_its_way_there(target, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    suite = "p2os-client" if "listen" in target else "p2os-server"
    assert main(["check", "--through", "pty", "--target", target, "--suite", suite]) == 2
    assert "--through" in capsys.readouterr().err
