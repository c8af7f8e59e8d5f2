from __future__ import annotations

import contextlib
import tty

import pytest

from hilbench.bench_provider import make_provider
from hilbench.check import CheckOptions, run_suites
from hilbench.cli import main
from hilbench.clock import Scheduler
from hilbench.errors import UnavailableError
from hilbench.links import Line, MemoryLink, through_pty
from hilbench.links.through_pty import PtyPassages

ALL_BYTES = bytes(range(256)) * 20


@pytest.fixture
def line():
    """Both ends of a line in memory, the first one behind a pseudo-terminal."""
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=921_600), name="line")
    return scheduler, PtyPassages()(link.a), link.b


def heard_by(port):
    heard = bytearray()
    port.on_receive = lambda data, _at_ns: heard.extend(data)
    return heard


def test_every_byte_passes_both_ways_as_it_is(line):
    scheduler, near, far = line
    at_near, at_far = heard_by(near), heard_by(far)
    near.write(ALL_BYTES)
    far.write(ALL_BYTES[::-1])
    scheduler.run_for(10**9)
    assert at_far == ALL_BYTES
    assert at_near == ALL_BYTES[::-1]
    assert (near.counters.sent, near.counters.received) == (len(ALL_BYTES), len(ALL_BYTES))


def test_the_terminal_is_really_on_the_way(line, monkeypatch):
    """One that is not raw makes other bytes of them."""
    monkeypatch.setattr(tty, "setraw", lambda *_: None)
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=921_600), name="cooked")
    near, at_far = PtyPassages()(link.a), heard_by(link.b)
    near.write(b"a\n")
    scheduler.run_for(10**9)
    assert at_far == b"a\r"


def test_a_terminal_that_keeps_bytes_is_an_error(line, monkeypatch):
    monkeypatch.setattr(tty, "setraw", lambda *_: None)
    monkeypatch.setattr(through_pty, "_PATIENCE_MS", 1)
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=921_600), name="cooked")
    PtyPassages()(link.a)
    link.b.write(b"no end of line")
    with pytest.raises(UnavailableError, match="passed on 0 of 1 bytes"):
        scheduler.run_for(10**9)


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


@pytest.mark.parametrize(
    ("bench", "suite", "select"),
    [("pioneer-plane", "p2os-server", "S01"), ("pioneer-plane", "p2os-client", "C01"),
     ("rover-model", "pkt-board", "P01"), ("rover-model", "pkt-host", "P50"),
     ("vehicle-model", "vehicle-board", "VB05H"), ("vehicle-model", "vehicle-host", "VS01")],
)  # fmt: skip
def test_a_run_is_the_same_with_it_and_without(bench, suite, select, monkeypatch):
    def run(through):
        options = CheckOptions(bench=bench, suites=(suite,), select=select, through=through)
        provider = make_provider(options)
        with contextlib.closing(provider):
            return run_suites(options, provider)

    passed = []
    take = through_pty._Passage._pass
    monkeypatch.setattr(through_pty._Passage, "_pass", lambda self, *ends: passed.append(ends[2]) or take(self, *ends))
    without = run("")
    assert not passed
    with_it = run("pty")
    assert sum(map(len, passed)) >= 10
    assert with_it.run_hash == without.run_hash
    assert with_it.bench["lines"] == "through pseudo-terminals of this machine"


@pytest.mark.parametrize("target", ["serial:/dev/null", "capture:run.jsonl", "listen:tcp:0"])
def test_what_has_a_port_of_its_own_has_its_way_there(target, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    suite = "p2os-client" if "listen" in target else "p2os-server"
    assert main(["check", "--through", "pty", "--target", target, "--suite", suite]) == 2
    assert "--through" in capsys.readouterr().err
