"""The door for clients of RFC 2217, and pyserial's client as a target, against each other."""

from __future__ import annotations

import contextlib
import os
import socket
import threading
import warnings

import pytest
import serial

from hilbench.clock import NS_PER_MS
from hilbench.errors import UnavailableError
from hilbench.links import Line, Rfc2217Door, SerialPort
from hilbench.links.com_port import COM_PORT
from hilbench.links.telnet import Data, Subnegotiation, TelnetDecoder, Verb, escape, negotiation, subnegotiation

S = 10**9


def until(scheduler, condition):
    assert scheduler.run_until(condition, scheduler.now_ns + 60 * S), "it never happened"


class InThread:
    """Does something that waits for the bench, in a thread, while the bench runs."""

    def __init__(self, scheduler, action):
        self.result = self.error = None

        def run():
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore", DeprecationWarning)  # pyserial's way to start a thread
                    self.result = action()
            except Exception as error:
                self.error = error

        thread = threading.Thread(target=run)
        thread.start()
        until(scheduler, lambda: not thread.is_alive())
        thread.join()


def do(scheduler, action):
    """Return what `action` gives, or raise what it raises."""
    done = InThread(scheduler, action)
    if done.error is not None:
        raise done.error
    return done.result


@pytest.fixture
def door(locked):
    made = Rfc2217Door(locked, "0", Line(baud=115_200))
    made.got = bytearray()
    made.on_receive = lambda data, at_ns: made.got.extend(data)
    yield made
    made.close()


@pytest.fixture
def client(locked, door):
    url = f"rfc2217://127.0.0.1:{door.port}"
    made = do(locked, lambda: serial.serial_for_url(url, baudrate=115_200, timeout=20))
    yield made
    do(locked, made.close)


class Raw:
    """A client that says what it likes."""

    def __init__(self, scheduler, door):
        self.scheduler = scheduler
        self.socket = socket.create_connection(("127.0.0.1", door.port))
        self.socket.setblocking(False)
        self.decoder = TelnetDecoder()
        self.said = []

    def say(self, data):
        self.socket.sendall(data)

    def hear(self, condition):
        def heard():
            with contextlib.suppress(BlockingIOError):
                self.said += self.decoder.feed(self.socket.recv(65_536))
            return condition(self.said)

        until(self.scheduler, heard)

    @property
    def data(self):
        return b"".join(event.data for event in self.said if isinstance(event, Data))


@pytest.fixture
def raw(locked, door):
    made = Raw(locked, door)
    made.hear(lambda said: len(said) >= 3)
    yield made
    made.socket.close()


def test_every_byte_both_ways(locked, door, client):
    sent = bytes(range(256)) * 4
    client.write(sent)
    until(locked, lambda: len(door.got) == len(sent))
    assert door.got == sent
    door.write(sent)
    assert do(locked, lambda: client.read(len(sent))) == sent


def test_the_rate_has_to_be_that_of_the_line(locked, door, client):
    garbled = []
    door.on_garbled = garbled.append
    do(locked, lambda: setattr(client, "baudrate", 57_600))
    assert door.client_baud == 57_600
    client.write(b"hello")
    until(locked, lambda: len(door.got) > 0)
    assert door.got != b"hello"
    assert garbled == [57_600]
    door.any_baud = True
    client.write(b"hello")
    until(locked, lambda: door.got.endswith(b"hello"))


def test_lines_and_breaks(locked, door, client):
    breaks, levels = [], []
    door.on_break = lambda at_ns: breaks.append((door.break_ns, at_ns))
    door.on_lines = lambda dtr, rts, at_ns: levels.append((dtr, rts))
    do(locked, lambda: setattr(client, "dtr", False))
    until(locked, lambda: levels == [(False, None)])
    assert (door._session.dtr, door._session.rts) == (False, True)
    assert do(locked, lambda: (client.cts, client.dsr, client.cd, client.ri)) == (True, True, True, False)
    do(locked, lambda: client.send_break(0.01))
    until(locked, lambda: len(breaks) == 1)
    assert door.counters.breaks == 1
    assert 10 * NS_PER_MS <= breaks[0][0] < breaks[0][1]


def test_another_form_of_a_byte_is_refused(locked, client):
    with pytest.raises(ValueError, match="remote rejected value for option 'parity'"):
        do(locked, lambda: setattr(client, "parity", "E"))


def test_a_break_of_the_line_reaches_a_client_that_wants_to_know(locked, door, raw):
    raw.say(negotiation(Verb.WILL, COM_PORT) + subnegotiation(COM_PORT, b"\x0a\x10"))
    raw.hear(lambda said: Subnegotiation(COM_PORT, b"\x6e\x10") in said)
    door.send_break(NS_PER_MS)
    raw.hear(lambda said: Subnegotiation(COM_PORT, b"\x6a\x10") in said)


def test_who_wants_nothing_for_a_while_gets_it_later(locked, door, raw):
    raw.say(subnegotiation(COM_PORT, b"\x08"))
    until(locked, lambda: door._kept is not None)
    door.write(b"one\xff")
    locked.run_for(20 * NS_PER_MS)
    assert raw.data == b""
    raw.say(subnegotiation(COM_PORT, b"\x09"))
    raw.hear(lambda said: raw.data == b"one\xff")


def test_what_was_sent_and_is_not_on_the_line_can_be_purged(locked, door, raw):
    door.baud = 300
    raw.say(b"x" * 50 + subnegotiation(COM_PORT, b"\x0c\x03"))
    until(locked, lambda: door.counters.withdrawn == 49)
    locked.run_for(200 * NS_PER_MS)
    assert door.got == b"x"


def test_a_client_that_reads_nothing_loses_whole_bytes_only(locked, door, raw):
    door.baud = 0
    raw.socket.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    for _ in range(300):
        door.write(bytes((255,)) * 1000)
        locked.run_for(NS_PER_MS)
    assert door.counters.lost > 0
    expected = 300_000 - door.counters.lost
    raw.hear(lambda said: len(raw.data) >= expected)
    assert raw.data == bytes((255,)) * expected
    door.write(escape(b"z"))
    raw.hear(lambda said: raw.data.endswith(b"z"))


def test_the_next_client_begins_anew(locked, door, raw):
    raw.say(subnegotiation(COM_PORT, b"\x01\x00\x00\xe1\x00"))
    until(locked, lambda: door.client_baud == 57_600)
    raw.socket.close()
    until(locked, lambda: not door.line_is_up)
    again = Raw(locked, door)
    until(locked, lambda: door.line_is_up)
    assert door.client_baud == 115_200
    door.baud = 9600
    door.follow(115_200, unasked=False)
    assert door.client_baud == 9600
    again.socket.close()


def test_our_own_port_at_our_own_door(locked, door, monkeypatch):
    """Opening waits for the far end, so it is done in a thread; from then on nothing waits."""
    before = threading.active_count()
    url = f"rfc2217://127.0.0.1:{door.port}"
    opened = do(locked, lambda: serial.serial_for_url(url, baudrate=115_200, timeout=0.1))
    monkeypatch.setattr("hilbench.links.serialport.open_serial", lambda target, write_timeout_s: opened)
    port = SerialPort(locked, f"{url}@115200")
    got, data = bytearray(), os.urandom(2000)
    port.on_receive = lambda heard, at_ns: got.extend(heard)
    port.write(data)
    door.write(data)
    until(locked, lambda: len(got) == len(door.got) == len(data))
    assert got == door.got == data
    do(locked, lambda: setattr(port, "baud", 57_600))
    assert door.client_baud == 57_600
    door.close()
    until(locked, lambda: not port.line_is_up)
    port.close()
    assert threading.active_count() == before


def test_a_far_end_that_speaks_no_telnet_is_said_in_one_line(locked):
    with socket.create_server(("127.0.0.1", 0)) as listener:
        url = f"rfc2217://127.0.0.1:{listener.getsockname()[1]}?timeout=0.1"
        with pytest.raises(UnavailableError, match="does not seem to support RFC2217") as caught:
            SerialPort(locked, url)
    assert "\n" not in str(caught.value)
