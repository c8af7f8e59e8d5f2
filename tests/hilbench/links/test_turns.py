"""What has to wait for the bytes before it: a break, another rate; and what a port says that is not to be believed."""

from __future__ import annotations

import io
import os
import threading

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hilbench.clock import NS_PER_MS, MonotonicHostClock, Scheduler
from hilbench.errors import UnavailableError
from hilbench.links import SerialPort
from hilbench.links import serialport as serialport_module
from hilbench.links.outgoing import Outgoing, Turn
from hilbench.links.port import Line
from hilbench.testing import FakeHostClock
from tests.share import examples

from .conftest import until

S = 10**9


class Stub:
    """Something of pyserial's kind, without a descriptor, that remembers what was done with it in which order."""

    port = "stub://"
    in_waiting = 0

    def __init__(self):
        self.done = []
        self.refuses, self.low, self.refused_rate = False, None, None
        self.closed, self.gate = threading.Event(), threading.Event()
        self.gate.set()
        self.rate = 9600
        self.to_read = 0
        self.all_read = threading.Event()

    def fileno(self):
        raise io.UnsupportedOperation

    def read(self, size):
        if self.to_read:
            self.to_read -= 1
            return b"x"
        self.all_read.set()
        if self.closed.wait(0.01):
            raise TypeError("closed under its hands")
        return b""

    def write(self, data):
        self.gate.wait()
        self.done.append(bytes(data))

    def _take(self, what):
        if what == "low" and self.low is not None:
            raise self.low
        if self.refuses or what == self.refused_rate:
            raise ValueError("remote rejected value for option 'control'")
        self.done.append(what)

    baudrate = property(lambda self: self.rate, lambda self, rate: self._take(rate))
    break_condition = property(lambda self: False, lambda self, on: self._take("low" if on else "high"))
    dtr = property(lambda self: True, lambda self, on: self._take("dtr"))

    def close(self):
        self.closed.set()


@pytest.fixture
def stub(opens):
    return opens(Stub())


@pytest.fixture
def port(locked, stub):
    made = SerialPort(locked, "stub://x@9600")
    yield made
    made.close()


def test_a_break_waits_for_the_bytes_before_it_and_those_behind_it_for_its_end(locked, stub, port):
    port.write(b"before")
    port.send_break(2 * NS_PER_MS)
    port.write(b"after")
    assert port.pending == len(b"beforeafter")
    until(locked, lambda: stub.done[-1:] == [b"after"])
    assert stub.done == [b"before", "low", "high", b"after"]


def test_a_rate_holds_from_the_next_byte_on(locked, stub, port):
    port.write(b"at 9600")
    port.baud = 57_600
    port.write(b"at 57600")
    assert port.baud == 57_600
    until(locked, lambda: not port.pending)
    assert stub.done == [b"at 9600", 57_600, b"at 57600"]


def test_nothing_waits_where_nothing_is_before_it(stub, port):
    port.baud = 57_600
    port.send_break(NS_PER_MS)
    assert stub.done == [57_600, "low"]


@settings(max_examples=examples(30))
@given(st.lists(st.sampled_from([b"a", b"bc", 19_200, 38_400, "break"]), max_size=12))
def test_everything_is_done_in_the_order_in_which_it_was_asked_for(asked):
    scheduler, stub = Scheduler(), Stub()
    scheduler.lock(MonotonicHostClock())
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(serialport_module, "open_serial", lambda target, write_timeout_s: stub)
        port = SerialPort(scheduler, "stub://x@9600")
    wanted, rate = [], 9600
    for what in asked:
        if isinstance(what, bytes):
            port.write(what)
            wanted += what
        elif what == "break":
            port.send_break(NS_PER_MS)
            wanted += ["low", "high"]
        else:
            port.baud = what
            wanted += [what] * (what != rate)
            rate = what
    until(scheduler, lambda: len(one_by_one(stub.done)) == len(wanted))
    assert one_by_one(stub.done) == wanted
    port.close()


def one_by_one(done):
    return [each for one in done for each in (one if isinstance(one, bytes) else [one])]


def test_what_is_refused_late_is_told(locked, stub, port):
    said = []
    port.on_refused = lambda *words: said.append(words)
    port.write(b"before")
    stub.refuses = True
    port.baud = 57_600
    until(locked, lambda: said)
    ((baud, error),) = said
    assert baud == 57_600
    assert "cannot be set to 57600 baud" in str(error)
    assert port.baud == 9600


def test_a_break_that_is_refused_late_takes_no_rate_back(locked, stub, port):
    said = []
    port.write(b"before")
    port.send_break(NS_PER_MS, said.append)
    port.baud = 57_600
    stub.low = ValueError("remote rejected value for option 'break'")
    until(locked, lambda: stub.done[-1:] == [57_600])
    assert [str(error) for error in said] == [f"stub://x: a break cannot be sent: the port says: {stub.low}"]
    assert port.baud == 57_600


def test_a_rate_that_is_refused_late_leaves_the_next_one_to_its_turn(locked, stub, port):
    said = []
    port.on_refused = lambda baud, error: said.append((baud, port.baud))
    port.write(b"before")
    port.baud = 12_345
    port.baud = 57_600
    stub.refused_rate = 12_345
    until(locked, lambda: stub.done[-1:] == [57_600])
    assert (said, port.baud) == ([(12_345, 57_600)], 57_600)


def test_what_is_refused_late_ends_the_run_where_nobody_is_told(locked, stub, port):
    port.write(b"before")
    stub.refuses = True
    port.baud = 57_600
    with pytest.raises(UnavailableError, match="cannot be set to 57600 baud"):
        until(locked, lambda: False)


def test_a_far_port_that_refuses_dtr_is_no_defect(stub, port):
    stub.refuses = True
    with pytest.raises(UnavailableError, match="DTR and RTS cannot be set"):
        port.set_lines(dtr=False)


def test_a_uart_has_bytes_that_its_driver_does_not_tell_of(locked, terminal, monkeypatch):
    """A pseudo-terminal that is taken for a UART: the driver says that all is out, the wire needs its time."""
    monkeypatch.setattr(serialport_module, "is_pseudo_terminal", lambda descriptor: False)
    _, name = terminal
    port = SerialPort(locked, f"{name}@9600")
    port.write(bytes(48))
    begin_ns = locked.now_ns
    port.baud = 19_200
    until(locked, lambda: port._serial.baudrate == 19_200)
    assert locked.now_ns - begin_ns >= 48 * 10 * S // 9600
    port.close()


def test_what_takes_all_at_once_is_not_waited_for_as_if_it_had_a_wire(terminal, monkeypatch):
    """Such as USB CDC: at most what an adapter holds beyond its driver may still be on the way."""
    scheduler = Scheduler()
    scheduler.lock(FakeHostClock())
    monkeypatch.setattr(serialport_module, "is_pseudo_terminal", lambda descriptor: False)
    _, name = terminal
    port, write = SerialPort(scheduler, f"{name}@9600"), os.write
    ours = port._serial.fd
    monkeypatch.setattr(os, "write", lambda fd, data: len(data) if fd == ours else write(fd, data))
    port.write(bytes(100_000))
    scheduler.run_for(S)
    begin_ns = scheduler.now_ns
    port.baud = 19_200
    until(scheduler, lambda: port._serial.baudrate == 19_200)
    assert scheduler.now_ns - begin_ns <= Line(baud=9600).bytes_ns(4096) + 10 * NS_PER_MS
    port.close()


def test_a_far_port_that_takes_nothing_is_not_asked_for_what_stands_behind(stub):
    """It would have to wait for the writer, and the bench with it."""
    scheduler = Scheduler()
    scheduler.lock(FakeHostClock())
    port = SerialPort(scheduler, "stub://x@9600")
    stub.gate.clear()
    port.write(b"stuck")
    port.baud = 57_600
    port.send_break(NS_PER_MS)
    port.write(b"behind")
    until(scheduler, lambda: port.counters.lost)
    assert port.counters.lost == len(b"behind")
    assert stub.done == []
    stub.gate.set()
    until(scheduler, lambda: stub.done[-1:] == ["high"])
    assert stub.done == [b"stuck", 57_600, "low", "high"]
    port.close()


def test_what_need_not_wait_is_out_before_the_port_is_closed(locked, terminal):
    master, name = terminal
    port = SerialPort(locked, f"{name}@9600")
    port.write(b"before")
    port.baud = 19_200
    port.write(b"behind")
    port.close()
    assert port.counters.lost == 0
    got = b""
    while len(got) < len(b"beforebehind"):
        got += os.read(master, 100)
    assert got == b"beforebehind"


def test_a_port_that_is_readable_without_a_byte_is_not_gone_for_that(locked, terminal, monkeypatch):
    """Somebody else may have thrown the byte away (tcflush(3))."""
    master, name = terminal
    port = SerialPort(locked, name)
    got, empty = bytearray(), [b""]
    port.on_receive = lambda data, at_ns: got.extend(data)
    read = os.read
    monkeypatch.setattr("hilbench.links.serialport.os.read", lambda *words: empty.pop() if empty else read(*words))
    os.write(master, b"there")
    until(locked, lambda: got == b"there")
    assert not empty
    assert port.line_is_up
    port.close()


def test_a_far_end_that_talks_to_nobody_does_not_hold_up_closing(locked, stub):
    """More pieces than a pipe holds bytes."""
    stub.to_read = 70_000
    port = SerialPort(locked, "stub://x")
    assert stub.all_read.wait(60)
    port.close()


@given(st.lists(st.one_of(st.binary(max_size=3), st.just(None))))
def test_bytes_are_forgotten_and_turns_are_not(steps):
    out, order = Outgoing(), []
    for number, step in enumerate(steps):
        if step is None:
            out.add_turn(Turn(act=lambda number=number: order.append(number), refused=order.append))
        else:
            out.add(step)
    assert out.clear_bytes() == sum(len(step) for step in steps if step is not None)
    assert len(out) == 0
    while (turn := out.next_turn()) is not None:
        turn.act()
    assert order == [number for number, step in enumerate(steps) if step is None]
    assert out.idle


@given(st.lists(st.one_of(st.binary(max_size=3), st.just(None))))
def test_turns_stand_between_the_bytes_that_were_before_and_behind_them(steps):
    out, order = Outgoing(), []
    for number, step in enumerate(steps):
        if step is None:
            out.add_turn(Turn(act=lambda number=number: order.append(number), refused=order.append))
        else:
            out.add(step)
    assert len(out) == sum(len(step) for step in steps if step is not None)
    while not out.idle:
        order += out.first
        out.first.clear()
        if (turn := out.next_turn()) is not None:
            turn.act()
    wanted = []
    for number, step in enumerate(steps):
        wanted += [number] if step is None else step
    assert order == wanted
    assert out.clear() == 0
