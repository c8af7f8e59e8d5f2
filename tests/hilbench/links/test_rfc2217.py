"""The door for clients of RFC 2217, and pyserial's client as a target, against each other."""

from __future__ import annotations

import contextlib
import os
import socket
import struct
import termios
import threading
import warnings

import pytest
import serial

from hilbench.bench import Bench
from hilbench.clock import NS_PER_MS
from hilbench.errors import UnavailableError
from hilbench.journal import Journal
from hilbench.links import Line, Rfc2217Door, SerialPort
from hilbench.links import serial_device as device_module
from hilbench.links.com_port import COM_PORT, ComPortServer, LinesSet
from hilbench.links.port import ModemLines
from hilbench.links.telnet import Data, Subnegotiation, TelnetDecoder, Verb, escape, negotiation, subnegotiation
from hilbench.serving.relay import Relay
from hilbench.terminal.options import Clients

from .conftest import until

S = 10**9


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
    url = f"rfc2217://127.0.0.1:{door.port}?timeout=60"
    made = do(locked, lambda: serial.serial_for_url(url, baudrate=115_200, timeout=60))
    until(locked, lambda: door.line_is_up)
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
        until(scheduler, lambda: self._has_come(door))  # a bench that is late greets it before

    def _has_come(self, door):
        me = self.socket.getsockname()
        return any(client.has_come and client.connection.getpeername() == me for client in door._clients)

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
    (session,) = door._sessions.values()
    assert (session.server.dtr, session.server.rts) == (False, True)
    assert do(locked, lambda: (client.cts, client.dsr, client.cd, client.ri)) == (True, True, True, False)
    do(locked, lambda: client.send_break(0.01))
    until(locked, lambda: len(breaks) == 1)
    assert door.counters.breaks == 1
    assert 10 * NS_PER_MS <= breaks[0][0] < breaks[0][1]


LEVELS = {"dtr": True, "rts": True, "cts": True, "dsr": True, "ri": False, "cd": True}


def notices(said):
    """Return the values of the notices of the lines beside the data."""
    payloads = [event.payload for event in said if isinstance(event, Subnegotiation)]
    return [payload[1] for payload in payloads if payload[0] == 107]


def test_lines_of_a_port_behind_are_told_to_a_client(locked, door, client):
    assert door.tell_lines(ModemLines(**LEVELS | {"cts": False, "cd": False, "ri": True}))
    do(locked, lambda: None)
    until(locked, lambda: not client.cts)
    assert (client.cts, client.dsr, client.ri, client.cd) == (False, True, True, False)
    door.tell_lines(ModemLines(**LEVELS))
    until(locked, lambda: client.cts)
    assert (client.cts, client.dsr, client.ri, client.cd) == (True, True, False, True)


def test_a_client_that_comes_later_is_told_what_holds(locked, door):
    door.tell_lines(ModemLines(**LEVELS | {"dsr": False}))
    url = f"rfc2217://127.0.0.1:{door.port}?timeout=60&poll_modem"
    client = do(locked, lambda: serial.serial_for_url(url, baudrate=115_200, timeout=60))
    assert do(locked, lambda: (client.cts, client.dsr, client.ri, client.cd)) == (True, False, False, True)
    do(locked, client.close)


@pytest.mark.parametrize(
    ("mask", "told"),
    [
        (0xFF, [0xB0, 0xA1, 0xE0, 0xA4]),  # all; that it no longer rings is told as an edge
        (0x00, [0xB0]),
        (0x11, [0xB0, 0x01]),
        (0x10, [0xB0]),  # CTS falls, and nothing is left of the state
        (0x40, [0xB0, 0x40]),
    ],
)
def test_a_client_is_told_of_what_it_asked_for(locked, door, raw, mask, told):
    """RFC 2217, section 3: the new state AND the mask, unless that is nothing."""
    raw.say(negotiation(Verb.WILL, COM_PORT) + subnegotiation(COM_PORT, bytes((11, mask))))
    raw.hear(lambda said: Subnegotiation(COM_PORT, bytes((111, mask))) in said)
    for change in ({"cts": False}, {"cts": False, "ri": True}, {"cts": False, "ri": True}, {"cts": False}):
        door.tell_lines(ModemLines(**LEVELS | change))
    raw.say(subnegotiation(COM_PORT, b"\x00"))  # the answer comes behind all that
    raw.hear(lambda said: any(isinstance(event, Subnegotiation) and event.payload[0] == 100 for event in said))
    assert notices(raw.said) == told


class Board:
    """The lines of a board's port, as its driver tells them."""

    def __init__(self, monkeypatch):
        self.bits = termios.TIOCM_CTS | termios.TIOCM_DSR
        real = device_module.fcntl.ioctl

        def ioctl(descriptor, request, argument=0):
            return struct.pack("i", self.bits) if request == termios.TIOCMGET else real(descriptor, request, argument)

        monkeypatch.setattr(device_module.fcntl, "ioctl", ioctl)


@pytest.fixture
def board(monkeypatch):
    return Board(monkeypatch)


def test_lines_of_a_board_reach_the_client_through_a_relay(locked, door, board):
    master, slave = os.openpty()
    port = SerialPort(locked, os.ttyname(slave), watch_lines=True)
    bench = Bench(locked, Journal(keep=100))
    Relay(bench, door, port, record=False)
    url = f"rfc2217://127.0.0.1:{door.port}?timeout=60"
    client = do(locked, lambda: serial.serial_for_url(url, baudrate=115_200, timeout=60))
    assert (client.cts, client.dsr, client.ri, client.cd) == (True, True, False, False)
    board.bits ^= termios.TIOCM_CTS | termios.TIOCM_CAR
    until(locked, lambda: not client.cts)
    assert (client.cts, client.dsr, client.ri, client.cd) == (False, True, False, True)
    modem = [event for event in bench.journal.recent if event["kind"] == "modem"]
    assert [(event["source"], event["cts"], event["cd"], event["told"]) for event in modem] == [
        ("server", True, False, True),
        ("server", False, True, True),
    ]
    do(locked, client.close)
    port.close()
    os.close(master)
    os.close(slave)


def test_lines_of_a_far_port_are_known(locked, door):
    """Our client of RFC 2217 at our door: what a chain of proxies hands on."""
    door.tell_lines(ModemLines(**LEVELS | {"cts": False}))
    url = f"rfc2217://127.0.0.1:{door.port}?timeout=60@115200"
    port = do(locked, lambda: SerialPort(locked, url, watch_lines=True))
    told = []
    port.on_modem = lambda lines, at_ns: told.append(lines)
    assert port.modem_lines == ModemLines(**LEVELS | {"cts": False})
    door.tell_lines(ModemLines(**LEVELS))
    until(locked, lambda: told)
    assert told == [ModemLines(**LEVELS)]
    do(locked, port.close)


def test_a_break_comes_behind_the_bytes_that_were_sent_before_it(locked, door, raw):
    door.baud = 9600
    order = []
    door.on_receive = lambda data, at_ns: order.extend(data)
    door.on_break = lambda at_ns: order.append("break")
    raw.say(b"abcdefgh" + subnegotiation(COM_PORT, b"\x05\x05") + subnegotiation(COM_PORT, b"\x05\x06") + b"i")
    until(locked, lambda: order[-1:] == [ord("i")])
    assert order == [*b"abcdefgh", "break", ord("i")]


def test_a_break_that_is_purged_is_none(locked, door, raw):
    door.baud = 300
    breaks = []
    door.on_break = breaks.append
    raw.say(b"xx" + subnegotiation(COM_PORT, b"\x05\x05") + subnegotiation(COM_PORT, b"\x05\x06"))
    raw.say(subnegotiation(COM_PORT, b"\x0c\x03") + b"y")
    until(locked, lambda: door.got == b"xy")
    assert breaks == []


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
    (session,) = door._sessions.values()
    until(locked, lambda: session.kept is not None)
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


@pytest.fixture
def shared(locked):
    made = Rfc2217Door(locked, "0", Line(baud=115_200), clients=Clients.ALL)
    yield made
    made.close()


def answer_to(client, command, payload):
    """Ask and return the value of the answer."""
    client.say(subnegotiation(COM_PORT, bytes((command,)) + payload))
    head = bytes((command + 100,))

    def answers():
        payloads = [event.payload for event in client.said if isinstance(event, Subnegotiation)]
        return [payload[1:] for payload in payloads if payload[:1] == head]

    before = len(answers())
    client.hear(lambda said: len(answers()) > before)
    return answers()[-1]


def test_two_clients_have_one_port(locked, shared):
    """Rate and lines are those that either has set last, as at a pseudo-terminal that two have open."""
    one, other = Raw(locked, shared), Raw(locked, shared)
    answer_to(one, 1, (57_600).to_bytes(4, "big"))
    answer_to(one, 5, b"\x09")
    late = Raw(locked, shared)
    for client in (other, late):
        assert answer_to(client, 1, bytes(4)) == (57_600).to_bytes(4, "big")
        assert answer_to(client, 5, b"\x07") == b"\x09"
        assert answer_to(client, 5, b"\x0a") == b"\x0b"
    got = bytearray()
    shared.any_baud = True
    shared.on_receive = lambda data, at_ns: got.extend(data)
    other.say(escape(b"one\xff"))
    until(locked, lambda: got == b"one\xff")
    shared.write(b"two\xff")
    for client in (one, other, late):
        client.hear(lambda said, client=client: client.data == b"two\xff")
        client.socket.close()
    until(locked, lambda: not shared.line_is_up)
    assert shared.counters.lost == 0


def test_one_of_two_clients_may_want_nothing_for_a_while(locked, shared):
    one, other = Raw(locked, shared), Raw(locked, shared)
    answer_to(one, 12, b"\x01")
    answer_to(other, 12, b"\x01")
    one.say(subnegotiation(COM_PORT, b"\x08"))
    until(locked, lambda: any(session.kept is not None for session in shared._sessions.values()))
    shared.write(b"hello")
    other.hear(lambda said: other.data == b"hello")
    one.hear(lambda said: True)
    assert one.data == b""
    one.say(subnegotiation(COM_PORT, b"\x09"))
    one.hear(lambda said: one.data == b"hello")
    one.socket.close()
    other.socket.close()


def test_the_next_client_begins_anew(locked, door, raw):
    raw.say(subnegotiation(COM_PORT, b"\x01\x00\x00\xe1\x00"))
    until(locked, lambda: door.client_baud == 57_600)
    raw.socket.close()
    until(locked, lambda: not door.line_is_up)
    again = Raw(locked, door)
    assert door.client_baud == 115_200
    door.baud = 9600
    door.follow(115_200, unasked=False)
    assert door.client_baud == 9600
    again.socket.close()


def test_our_own_port_at_our_own_door(locked, door, monkeypatch):
    """Opening waits for the far end, so it is done in a thread; from then on nothing waits."""
    before = threading.active_count()
    url = f"rfc2217://127.0.0.1:{door.port}?timeout=60"
    opened = do(locked, lambda: serial.serial_for_url(url, baudrate=115_200, timeout=0.1))
    monkeypatch.setattr("hilbench.links.serialport.open_serial", lambda target, write_timeout_s: opened)
    port = SerialPort(locked, f"{url}@115200")
    got, data = bytearray(), os.urandom(2000)
    port.on_receive = lambda heard, at_ns: got.extend(heard)
    until(locked, lambda: door.line_is_up)
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


@contextlib.contextmanager
def far_end_without_lines(listener, asked):
    """Leave DTR and RTS unanswered for one client, as ser2net with a pseudo-terminal behind; `asked` when it asks."""
    session = ComPortServer(115_200)

    def serve():
        client, _ = listener.accept()
        with client, contextlib.suppress(ConnectionError):
            client.sendall(session.answers)
            while heard := client.recv(4096):
                session.answers.clear()
                if any(isinstance(event, LinesSet) for event in session.receive(heard)):
                    asked.set()
                else:
                    client.sendall(session.answers)

    far = threading.Thread(target=serve)
    far.start()
    yield
    far.join()


def test_a_far_end_without_control_lines_is_said_with_what_to_do(locked, monkeypatch):
    asked = threading.Event()

    class UntilAsked(serial.serialutil.Timeout):
        """Ends when the far end has heard what it leaves unanswered, so that nobody waits for longer."""

        def expired(self):
            return asked.is_set() or super().expired()

    with socket.create_server(("127.0.0.1", 0)) as listener:
        url = f"rfc2217://127.0.0.1:{listener.getsockname()[1]}?timeout=60"
        advised = f"{url}&ign_set_control"
        with far_end_without_lines(listener, asked), monkeypatch.context() as patch:
            patch.setattr("serial.rfc2217.Timeout", UntilAsked)
            with pytest.raises(UnavailableError, match="option 'control'") as caught:
                SerialPort(locked, url)
        assert caught.value.hint.endswith(f"if it has none: {advised}")
        with far_end_without_lines(listener, asked):
            SerialPort(locked, advised).close()


def test_what_to_do_keeps_what_the_url_asks_for(locked, monkeypatch):
    def silent(self):
        raise serial.SerialException("timeout while waiting for option 'control'")

    monkeypatch.setattr("serial.rfc2217.Serial.open", silent)
    with pytest.raises(UnavailableError) as caught:
        SerialPort(locked, "rfc2217://host:4000?timeout=9@57600")
    assert caught.value.hint.endswith(": rfc2217://host:4000?timeout=9&ign_set_control")
