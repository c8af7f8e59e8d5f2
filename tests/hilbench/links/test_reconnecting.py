"""A port that is unplugged and comes back under another name."""

from __future__ import annotations

import os
import selectors
import threading
import tty
from pathlib import Path

import pytest

from hilbench.bench import Bench
from hilbench.clock import NS_PER_MS, NS_PER_S, MonotonicHostClock, Scheduler
from hilbench.errors import PortClosedError, UnavailableError, UsageError
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink, MemoryPort, ReconnectingPort, SerialPort, SerialTarget
from hilbench.links.port import ModemLines
from hilbench.links.reconnecting import POLL_NS, identity_of
from hilbench.ports.listing import PortInfo
from hilbench.testing import FakeHostClock
from tests.hilbench.bay import BOARD, Bay

TIMES = 100


class WithLines(MemoryPort):
    """A port with lines beside the data, all asserted but that it does not ring."""

    modem_lines = ModemLines(dtr=True, rts=True, cts=True, dsr=True, ri=False, cd=True)


@pytest.fixture
def bench(tmp_path):
    scheduler = Scheduler()
    scheduler.lock(FakeHostClock())
    made = Bench(scheduler, Journal(tmp_path / "journal.jsonl", keep=100_000))
    yield made
    scheduler.unlock()
    made.journal.close()


@pytest.fixture
def bay(bench):
    made = Bay(bench)
    made.plug_in()
    return made


@pytest.fixture
def port(bench, bay):
    target = SerialTarget(url=bay.device, baud=0)  # without pace, a chunk is one entry
    made = ReconnectingPort(bench.scheduler, target, record=bench.record, ports=bay.ports, open_port=bay.open)
    yield made
    made.close()


def recorded(bench, kind):
    return [event for event in bench.journal.recent if event["kind"] == kind]


def test_what_is_not_it_is_not_taken_for_it(bench, bay, port):
    bay.pull_out()
    bench.run_for(5)
    assert not port.line_is_up
    port.write(b"lost")
    assert (port.counters.sent, port.counters.lost) == (4, 4)
    assert port.pending == 0
    port.withdraw(0)
    port.send_break(1)
    with pytest.raises(UnavailableError, match="is gone"):
        port.set_lines(dtr=True)


def test_who_may_not_be_opened_yet_is_tried_again_and_said_once(bench, bay, port):
    bay.pull_out()
    bay.refuse = "permission denied"
    bay.plug_in()
    bench.run_for(3)
    assert [event["text"] for event in recorded(bench, "port-refused")] == [f"{bay.device}: permission denied"]
    bay.refuse = None
    assert bench.run_until(lambda: port.line_is_up, POLL_NS / NS_PER_S)


def test_the_rate_that_was_set_meanwhile_holds_when_it_comes_back(bench, bay, port):
    port.baud = 57_600
    bay.pull_out()
    bench.run_for(0.1)
    port.baud = 19_200
    bay.plug_in()
    assert bench.run_until(lambda: port.line_is_up, 1)
    assert bay.link.a.baud == port.baud == 19_200


def test_lines_fall_when_the_plug_is_pulled_and_are_told_anew_when_it_comes_back(bench, bay, port):
    up = ModemLines(dtr=True, rts=True, cts=True, dsr=True, ri=False, cd=True)
    down = ModemLines(dtr=False, rts=False, cts=False, dsr=False, ri=False, cd=False)
    told = []
    port.on_modem = lambda lines, at_ns: told.append(lines)
    assert port.modem_lines is None
    bay.link.a.on_modem(up, bench.now_ns)
    bay.link.a.__class__ = WithLines
    assert port.modem_lines == up
    bay.pull_out()
    bench.run_for(1)
    assert port.modem_lines == down
    bay.kind = WithLines
    bay.plug_in()
    bench.run_for(1)
    assert told == [up, down, up]


def test_nobody_looks_for_a_port_that_was_closed(bench, bay, port):
    lines, breaks = [], []
    port.on_line = lambda up, at_ns: lines.append(up)
    port.on_break = breaks.append
    bay.link.b.send_break(NS_PER_MS)
    bench.run_for(0.1)
    assert len(breaks) == 1
    bay.pull_out()
    bench.run_for(0.1)
    port.close()
    bay.plug_in()
    bench.run_for(2)
    assert lines == [False]
    assert not port.line_is_up
    with pytest.raises(PortClosedError):
        port.write(b"!")


def test_an_identity_is_found_by_any_name(tmp_path):
    device = tmp_path / "ttyACM0"
    device.touch()
    link = tmp_path / "by-id"
    link.symlink_to(device)
    ports = [PortInfo(device=str(device), usb=BOARD, links=("/dev/hilbench/nucleo",)), PortInfo(device="/dev/ttyS0")]
    assert identity_of(str(link), ports) == identity_of("/dev/hilbench/nucleo", ports) == BOARD
    assert identity_of("/dev/ttyS0", ports) is None


class WatchingFakeClock(FakeHostClock):
    """A fake clock that sees real descriptors: time jumps only where none is readable."""

    def wait_until(self, host_ns):
        with selectors.SelectSelector() as selector:
            for source in self.watched:
                selector.register(source.fileno(), selectors.EVENT_READ, source)
            ready = [key.data for key, _ in selector.select(0)]
        return ready or super().wait_until(host_ns)


class PtyBoard:
    """A pseudo-terminal in the place of a USB port."""

    def __init__(self):
        self.master, self.slave = os.openpty()
        tty.setraw(self.slave)
        self.name = os.ttyname(self.slave)

    def pull_out(self):
        os.close(self.slave)
        os.close(self.master)


def open_descriptors():
    return len(list(Path("/proc/self/fd").iterdir()))


def test_no_descriptor_and_no_thread_is_left_behind():
    scheduler = Scheduler()
    scheduler.lock(WatchingFakeClock())
    before = (open_descriptors(), threading.active_count())
    board = PtyBoard()
    plugged = [board]
    port = ReconnectingPort(
        scheduler,
        SerialTarget(url=board.name, baud=115_200),
        ports=lambda: [PortInfo(device=one.name, usb=BOARD) for one in plugged],
    )
    got = bytearray()
    port.on_receive = lambda data, at_ns: got.extend(data)

    def wait(condition):
        assert scheduler.run_until(condition, scheduler.now_ns + 3600 * NS_PER_S), "it never happened"

    for number in range(TIMES):
        wait(lambda: port.line_is_up)
        words = b"%03d" % number * 20
        os.write(board.master, words)
        wait(lambda number=number: len(got) == 60 * (number + 1))
        assert got.endswith(words)
        following = PtyBoard()  # while the other is still there: it gets another name
        plugged.clear()
        board.pull_out()
        wait(lambda: not port.line_is_up)
        board = following
        plugged.append(board)
    wait(lambda: port.line_is_up)
    assert port.device == board.name
    assert port.counters.received == len(got)
    port.close()
    board.pull_out()
    assert (open_descriptors(), threading.active_count()) == before
    scheduler.unlock()


def test_a_line_without_an_identity_is_looked_for_where_it_was(tmp_path):
    scheduler = Scheduler()
    host = MonotonicHostClock()
    scheduler.lock(host)
    board = PtyBoard()
    (tmp_path / "port").symlink_to(board.name)
    target = SerialTarget(url=str(tmp_path / "port"), baud=9600)
    port = ReconnectingPort(scheduler, target, ports=list, open_port=SerialPort)
    (tmp_path / "port").unlink()
    board.pull_out()
    assert scheduler.run_until(lambda: not port.line_is_up, 60 * NS_PER_S)
    board = PtyBoard()
    (tmp_path / "port").symlink_to(board.name)
    assert scheduler.run_until(lambda: port.line_is_up, scheduler.now_ns + 60 * NS_PER_S)
    port.close()
    board.pull_out()
    host.close()


def test_it_is_opened_again_with_the_rate_that_was_set_last(bench, bay, port):
    """In one step: a port that is open and whose rate cannot be set any more would be left open."""
    opened = []

    def opens(scheduler, target):
        opened.append(target.baud)
        return bay.open(scheduler, target)

    port.baud = 57_600
    bay.pull_out()
    bench.run_for(0.1)
    port._open_port = opens
    bay.plug_in()
    assert bench.run_until(lambda: port.line_is_up, 2)
    assert opened == [57_600]


def test_a_rate_that_was_refused_is_not_asked_for_again(bench, bay, port):
    """Else a port that has gone could not be opened with it."""

    class Fastidious(MemoryPort):
        baud = property(lambda self: 9600, lambda self, baud: refuse(baud))

    def refuse(baud):
        raise UnavailableError(f"cannot be set to {baud} baud", where="usb")

    before = port.baud
    bay.link.a.__class__ = Fastidious
    with pytest.raises(UnavailableError):
        port.baud = 12_345
    bay.pull_out()
    bench.run_for(0.1)
    bay.plug_in()
    assert bench.run_until(lambda: port.line_is_up, 1)
    assert port.baud == bay.link.a.baud == before


@pytest.mark.parametrize("error", [UsageError, UnavailableError])
def test_what_cannot_be_opened_with_a_rate_set_meanwhile_is_opened_with_that_it_had(bench, bay, port, error):
    said, before, opened = [], port.baud, []

    def opens(scheduler, target):
        opened.append(target.baud)
        if target.baud == 12_345:
            raise error("the rate cannot be set", where="usb")
        return bay.open(scheduler, target)

    port.on_refused = lambda baud, error: said.append((baud, str(error)))
    port._open_port = opens
    bay.pull_out()
    bench.run_for(0.1)
    port.baud = 12_345
    bay.plug_in()
    assert bench.run_until(lambda: port.line_is_up, 1)
    assert (opened, port.baud) == ([12_345, before], before)
    assert said == [(12_345, "usb: the rate cannot be set")]
    bench.run_for(1)
    assert len(recorded(bench, "port-returned")) == 1
    bay.pull_out()
    bench.run_for(0.1)
    port.baud, bay.refuse = 57_600, "permission denied"  # not for the rate: it stays
    bay.plug_in()
    bench.run_for(1)
    bay.refuse = None
    assert bench.run_until(lambda: port.line_is_up, 1)
    assert port.baud == 57_600


@pytest.mark.parametrize("error", [UsageError, UnavailableError])
def test_whatever_is_wrong_while_it_is_opened_again_it_is_tried_again(bench, bay, port, error):
    def refuses(_scheduler, _target):
        raise error("pyserial does not know it: the rate cannot be set", where="usb")

    bay.pull_out()
    bay.plug_in()
    port._open_port = refuses
    bench.run_for(1)
    assert len(recorded(bench, "port-refused")) == 1
    port._open_port = bay.open
    assert bench.run_until(lambda: port.line_is_up, 1)


class Far:
    """A far port whose host takes its time, and a bench that has lost it."""

    def __init__(self, monkeypatch):
        self.scheduler = Scheduler()
        self.scheduler.lock(MonotonicHostClock())
        self.gate, self.asked, self.opened, self.closed = threading.Event(), [], [], threading.Event()
        monkeypatch.setattr("hilbench.links.reconnecting.open_serial", self.open_serial)
        target = SerialTarget(url="rfc2217://far:4000", baud=9600)
        self.port = ReconnectingPort(self.scheduler, target, open_port=self.open_port, poll_ns=NS_PER_S // 500)
        self.scheduler.after(0, lambda: self.ours.on_line(False, self.scheduler.now_ns), source="far")
        self.until(lambda: self.asked)

    def open_serial(self, target, write_timeout_s):
        self.asked.append((target.baud, threading.current_thread()))
        assert self.gate.wait(60)
        return self

    def open_port(self, scheduler, target, opened=None):
        self.opened.append(opened)
        self.ours = MemoryLink(scheduler, Line(baud=target.baud), name="far").a
        return self.ours

    def until(self, condition):
        assert self.scheduler.run_until(condition, self.scheduler.now_ns + 60 * NS_PER_S), "it never happened"

    def close(self):
        self.closed.set()


def test_a_bench_goes_on_while_a_far_host_takes_its_time(monkeypatch):
    far = Far(monkeypatch)
    polled_ns = far.scheduler.now_ns + NS_PER_S // 50
    far.until(lambda: far.scheduler.now_ns >= polled_ns)
    assert [thread is threading.current_thread() for _, thread in far.asked] == [False]
    assert not far.port.line_is_up
    far.gate.set()
    far.until(lambda: far.port.line_is_up)
    assert far.opened == [None, far]
    far.port.close()


def test_a_far_port_whose_rate_was_changed_while_it_was_opened_is_opened_again(monkeypatch):
    far = Far(monkeypatch)
    far.port.baud = 57_600
    far.gate.set()
    far.until(lambda: far.port.line_is_up)
    assert [baud for baud, _ in far.asked] == [9600, 57_600]
    assert far.closed.wait(60)
    far.port.close()


def test_nobody_waits_until_a_far_port_that_is_not_wanted_has_hung_up(monkeypatch):
    far, hang_up = Far(monkeypatch), threading.Event()
    far.close = lambda: hang_up.wait(60) or far.closed.set()
    far.port.baud = 57_600
    far.gate.set()
    far.until(lambda: far.port.line_is_up)
    assert not far.closed.is_set(), "somebody has waited for it"
    hang_up.set()
    far.port.close()
    far.port.close()


def test_a_far_port_that_refuses_a_rate_set_meanwhile_is_opened_with_that_it_had(monkeypatch):
    far, said, opens = Far(monkeypatch), [], []
    far.port.on_refused = lambda baud, error: said.append((baud, str(error)))
    far.port.baud = 12_345

    def refuses(target, write_timeout_s):
        opens.append(target.baud)
        if target.baud == 12_345:
            refused = UnavailableError("the far port refuses what is asked of it", where=target.url)
            raise refused from ValueError("remote rejected value for option 'baudrate'")
        return far

    monkeypatch.setattr("hilbench.links.reconnecting.open_serial", refuses)
    far.gate.set()
    far.until(lambda: far.port.line_is_up)
    assert (opens, far.port.baud) == ([12_345, 9600], 9600)
    assert said == [(12_345, "rfc2217://far:4000: the far port refuses what is asked of it")]
    far.port.close()


def test_a_far_port_that_nobody_wants_any_more_is_closed_when_it_is_there(monkeypatch):
    far = Far(monkeypatch)
    far.port.close()
    far.gate.set()
    assert far.closed.wait(60)


def test_what_a_far_host_refuses_is_recorded_and_tried_again(monkeypatch):
    far, events = Far(monkeypatch), []
    far.port._record = lambda kind, source, **fields: events.append((kind, fields.get("text")))

    def refuses(target, write_timeout_s):
        raise UnavailableError("cannot be opened: it says nothing", where=target.url)

    monkeypatch.setattr("hilbench.links.reconnecting.open_serial", refuses)
    far.port.baud = 19_200
    far.gate.set()
    far.until(lambda: events)
    assert events == [("port-refused", "rfc2217://far:4000: cannot be opened: it says nothing")]
    monkeypatch.setattr("hilbench.links.reconnecting.open_serial", far.open_serial)
    far.until(lambda: far.port.line_is_up)
    assert far.port.baud == 19_200
    far.port.close()
