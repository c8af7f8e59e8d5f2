from __future__ import annotations

import errno
import fcntl
import os
import select
import struct
import termios
import threading

import pytest

from hilbench.clock import Scheduler
from hilbench.errors import HilbenchError, UnavailableError, UsageError
from hilbench.links import Line, PtyDoor
from hilbench.links.inotify import OpenCloseWatch
from hilbench.links.uart import resample
from tests.hilbench.hosts import SkippingHost

from .conftest import HURRY, until

S = 10**9


class Client:
    """A program that opens the pty: the raw descriptor, read without waiting."""

    def __init__(self, door):
        self.descriptor = os.open(door.path or door.slave_name, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)

    def set_baud(self, constant):
        attributes = termios.tcgetattr(self.descriptor)
        attributes[4] = attributes[5] = constant
        termios.tcsetattr(self.descriptor, termios.TCSANOW, attributes)

    def write(self, data):
        return os.write(self.descriptor, data)

    def read(self):
        data = b""
        while select.select((self.descriptor,), (), (), 0)[0]:
            data += os.read(self.descriptor, 4096)
        return data

    def close(self):
        os.close(self.descriptor)


class Log:
    def __init__(self, port):
        self.data = b""
        self.lines = []
        self.order = []
        port.on_receive = self.received
        port.on_line = self.line

    def received(self, data, at_ns):
        self.data += data
        self.order.append(data)

    def line(self, up, at_ns):
        self.lines.append(up)
        self.order.append(up)


@pytest.fixture
def pace():
    return HURRY


@pytest.fixture
def make_door(locked, tmp_path):
    doors = []

    def make(path="port", baud=921_600, **options):
        door = PtyDoor(locked, tmp_path / path if path else None, Line(baud=baud), **options)
        doors.append(door)
        return door

    yield make
    for door in doors:
        door.close()


def test_client_comes_talks_and_goes(locked, make_door):
    door = make_door(baud=57_600)
    log = Log(door)
    assert not door.line_is_up
    client = Client(door)
    until(locked, lambda: door.line_is_up)
    assert door.client_baud == 57_600
    client.write(b"\x00\x03\x04\x0d\x0a\x11\x13\x1a\xff")
    until(locked, lambda: len(log.data) == 9)
    assert log.data == b"\x00\x03\x04\x0d\x0a\x11\x13\x1a\xff"
    door.write(b"\x00\x0d\x0a\x03\xff")
    received = []
    until(locked, lambda: received.append(client.read()) or b"".join(received) == b"\x00\x0d\x0a\x03\xff")
    client.write(b"bye")
    client.close()
    until(locked, lambda: not door.line_is_up)
    assert log.order[-1] is False
    assert log.data.endswith(b"bye")


def test_twenty_clients_one_after_the_other(locked, make_door):
    door = make_door()
    log = Log(door)
    for number in range(20):
        client = Client(door)
        client.write(bytes([number]))
        client.close()
        until(locked, lambda number=number: log.lines.count(False) == number + 1)
    assert log.order == [item for number in range(20) for item in (True, bytes([number]), False)]


def test_clients_on_each_others_heels_are_told_apart(locked, make_door):
    door = make_door()
    log = Log(door)
    first = Client(door)
    until(locked, lambda: door.line_is_up)
    first.close()
    second = Client(door)
    second.write(b"hello")
    until(locked, lambda: log.data == b"hello")
    assert log.lines == [True, False, True]
    assert log.order[:3] == [True, False, True]
    second.close()
    until(locked, lambda: not door.line_is_up)


def test_a_client_that_comes_while_the_bench_learns_that_another_left(locked, make_door):
    """It opens between the notice of the closing and the look whether anybody is there: a hang-up all the same."""
    door = make_door()
    log = Log(door)
    first = Client(door)
    first.write(b"first")
    until(locked, lambda: log.data == b"first")
    notices, heirs = door._watch.read, []

    def read_and_let_in():
        happened = notices()
        if False in happened and not heirs:
            heirs.append(Client(door))
            heirs[0].write(b"heir")
        return happened

    door._watch.read = read_and_let_in
    first.close()
    until(locked, lambda: log.data == b"firstheir")
    assert log.lines == [True, False, True]
    door._watch.read = notices
    heirs[0].close()
    until(locked, lambda: not door.line_is_up)
    assert log.lines == [True, False, True, False]


def test_a_client_whose_closing_is_told_before_it_is_done(locked, make_door):
    """The kernel tells of a closing before it hangs the line up: between the two it seems that somebody is there."""
    door = make_door()
    log = Log(door)
    client = Client(door)
    client.write(b"bye")
    until(locked, lambda: log.data == b"bye")
    notices, reads, closing = door._watch.read, [], threading.Thread(target=client.close)

    def read_early():
        notices()
        reads.append(1)
        if len(reads) == 3:  # it was told, the bench has let go of the line and looked at it
            closing.start()
        return [False] if len(reads) == 1 else []

    door._watch.read = read_early
    door._look(locked.now_ns)
    closing.join()
    until(locked, lambda: not door.line_is_up)
    assert log.lines == [True, False]


def test_a_client_whose_opening_is_told_after_it_is_done(locked, make_door):
    """The kernel tells of an opening when the line is no longer hung up: a hang-up has been in between all the same."""
    door = make_door()
    log = Log(door)
    first = Client(door)
    first.write(b"first")
    until(locked, lambda: log.data == b"first")
    notices, heirs = door._watch.read, []
    says = iter(([False], [], []))  # told; before the bench lets go; after it has looked

    def read_late():
        if not heirs and not notices():
            return []
        if not heirs:
            heirs.append(Client(door))
            heirs[0].write(b"heir")
            return next(says)
        said = next(says, None)
        if said is None:
            return notices() and [True]  # at last
        return said

    door._watch.read = read_late
    first.close()
    until(locked, lambda: log.data == b"firstheir")
    assert log.lines == [True, False, True]
    door._watch.read = notices
    heirs[0].close()
    until(locked, lambda: not door.line_is_up)
    assert log.lines == [True, False, True, False]


def test_several_clients_at_once_even_when_the_notices_are_merged(locked, make_door):
    door = make_door()
    clients = [Client(door) for _ in range(3)]
    until(locked, lambda: door.line_is_up)
    clients.pop().close()
    locked.run_for(S // 50)
    assert door.line_is_up
    for client in clients:
        client.close()
    until(locked, lambda: not door.line_is_up)
    log = Log(door)
    client = Client(door)
    client.write(b"x")
    until(locked, lambda: log.data == b"x")
    assert log.lines == [True]
    client.close()


def test_a_client_that_does_not_read_never_blocks_the_bench(locked, make_door):
    door = make_door(baud=0)
    client = Client(door)
    until(locked, lambda: door.line_is_up)
    for _ in range(20):
        door.write(bytes(8000))
        locked.run_for(0)
    locked.run_for(S // 100)
    assert 100_000 < door.counters.lost < door.counters.sent == 160_000
    unread = client.read()
    assert 1000 < len(unread) == door.counters.sent - door.counters.lost
    door.write(b"fresh")
    received = []
    until(locked, lambda: received.append(client.read()) or b"".join(received) == b"fresh")
    client.close()


def test_a_client_that_looks_away_for_a_moment_loses_nothing(locked, make_door):
    """The kernel keeps 13 kB at least: 140 ms of a full line at 921600 baud."""
    door = make_door(baud=921_600)
    client = Client(door)
    until(locked, lambda: door.line_is_up)
    said = bytes(range(251)) * 50
    door.write(said)
    locked.run_for(S // 5)
    heard = []
    until(locked, lambda: heard.append(client.read()) or len(b"".join(heard)) == len(said))
    assert b"".join(heard) == said
    assert door.counters.lost == 0
    client.close()


def test_nothing_stale_waits_for_the_next_client(locked, make_door):
    door = make_door()
    door.write(b"nobody there")
    locked.run_for(S // 100)
    assert door.counters.lost == 12
    first = Client(door)
    until(locked, lambda: door.line_is_up)
    door.write(b"unread")
    locked.run_for(S // 100)
    first.close()
    until(locked, lambda: not door.line_is_up)
    second = Client(door)
    until(locked, lambda: door.line_is_up)
    assert second.read() == b""
    second.close()


def test_what_left_the_wire_before_a_client_came_is_not_for_it(tmp_path):
    """Were it given to the client and then thrown away, its read would find nothing where poll(2) had seen bytes.

    A bench that is late runs what was due before the client came after it has learnt that the client is there.
    """
    host, scheduler = SkippingHost(), Scheduler()
    scheduler.lock(host)
    door = PtyDoor(scheduler, tmp_path / "port", Line(baud=921_600))
    door.write(b"before")
    host.pass_time(S // 500)
    client = Client(door)
    until(scheduler, lambda: door.line_is_up)
    assert door.counters.lost == len(b"before")
    door.write(b"after")
    scheduler.run_for(S // 100)
    assert client.read() == b"after"
    client.close()
    door.close()
    host.close()


def test_a_line_without_anything_unread_is_not_flushed(locked, make_door, monkeypatch):
    """Within a flush poll(2) may say that there is something to read: Linux moves the tail of the buffer first."""
    door = make_door()
    monkeypatch.setattr(termios, "tcflush", lambda *_: pytest.fail("flushed"))
    for _ in range(2):
        client = Client(door)
        until(locked, lambda: door.line_is_up)
        door.write(b"x")
        locked.run_for(S // 100)
        assert client.read() == b"x"
        client.close()
        until(locked, lambda: not door.line_is_up)


def alone(descriptor):
    """Whether a port is somebody's alone (TIOCGEXCL, ioctl_tty(2))."""
    return bool(struct.unpack("i", fcntl.ioctl(descriptor, 0x80045440, bytes(4)))[0])


def test_a_client_that_takes_it_for_itself_alone_keeps_it_so_long_as_it_is_there(locked, make_door):
    """Whoever has not all rights cannot open such a port: nor could we, to see whether somebody is there."""
    door = make_door()
    one, other = Client(door), Client(door)
    until(locked, lambda: door.line_is_up)
    fcntl.ioctl(one.descriptor, termios.TIOCEXCL)
    log = Log(door)
    other.write(b"?")
    other.close()
    until(locked, lambda: log.data == b"?")
    locked.run_until(lambda: False, locked.now_ns + S // 20)
    assert door.line_is_up
    assert alone(one.descriptor)
    one.close()
    until(locked, lambda: not door.line_is_up)
    third = Client(door)
    assert not alone(third.descriptor)
    third.close()


def test_a_port_that_was_taken_away_meanwhile_is_said_and_closed(locked, make_door, monkeypatch):
    door = make_door()
    client = Client(door)
    until(locked, lambda: door.line_is_up)

    def refused(path, flags):
        raise OSError(errno.EBUSY, "Device or resource busy")

    monkeypatch.setattr("hilbench.links.pty.os.open", refused)
    client.close()
    with pytest.raises(UnavailableError, match="a client took it for itself alone"):
        until(locked, lambda: not door.line_is_up)
    door.close()


def test_a_client_at_another_rate_gets_and_gives_garbage(locked, make_door):
    door = make_door(baud=9600)
    log = Log(door)
    client = Client(door)
    client.set_baud(termios.B19200)
    client.write(b"hello")
    expected = bytes(byte.value for byte in resample(b"hello", 19_200, 9600))
    until(locked, lambda: len(log.data) >= len(expected))
    assert door.client_baud == 19_200
    assert log.data == expected != b"hello"
    door.write(b"h")
    garbage = bytes(byte.value for byte in resample(b"h", 9600, 19_200))
    received = []
    until(locked, lambda: received.append(client.read()) or b"".join(received) == garbage)
    client.set_baud(termios.B9600)
    log.data = b""
    client.write(b"hello")
    until(locked, lambda: log.data == b"hello")
    client.close()


def test_settings_are_ours_again_when_the_last_client_has_left(locked, make_door):
    door = make_door(baud=250_000)
    assert door.client_baud == 250_000
    client = Client(door)
    until(locked, lambda: door.line_is_up)
    client.set_baud(termios.B19200)
    attributes = termios.tcgetattr(client.descriptor)
    attributes[3] |= termios.ECHO | termios.ICANON
    termios.tcsetattr(client.descriptor, termios.TCSANOW, attributes)
    client.close()
    until(locked, lambda: not door.line_is_up)
    assert door.client_baud == 250_000
    client = Client(door)
    assert not termios.tcgetattr(client.descriptor)[3] & (termios.ECHO | termios.ICANON)
    client.close()


def test_any_baud(locked, make_door):
    door = make_door(any_baud=True)
    log = Log(door)
    client = Client(door)
    client.set_baud(termios.B19200)
    client.write(b"hello")
    until(locked, lambda: log.data == b"hello")
    client.close()


def test_a_client_that_floods_is_held_back(locked, make_door):
    door = make_door(baud=921_600)
    log = Log(door)
    client = Client(door)
    written = 0
    with_room = True
    while written < 60_000 and with_room:
        try:
            written += client.write(bytes(1000))
        except BlockingIOError:
            locked.run_for(S // 200)
    until(locked, lambda: len(log.data) == written)
    assert door._incoming.pending == 0
    client.close()


class TestLink:
    def test_it_leads_to_the_slave_and_goes_with_the_door(self, make_door, tmp_path):
        door = make_door()
        assert os.readlink(tmp_path / "port") == door.slave_name
        door.close()
        door.close()
        assert not os.path.lexists(tmp_path / "port")

    def test_a_link_to_a_dead_pty_is_replaced(self, make_door, tmp_path):
        (tmp_path / "port").symlink_to("/dev/pts/99999")
        door = make_door()
        assert os.readlink(tmp_path / "port") == door.slave_name

    def test_a_link_to_a_living_pty_is_left_alone(self, make_door, tmp_path):
        first = make_door()
        with pytest.raises(UnavailableError, match="in use"):
            make_door()
        assert os.readlink(tmp_path / "port") == first.slave_name

    @pytest.mark.parametrize("what", ["file", "folder", "link", "no folder"])
    def test_anything_else_is_left_alone(self, make_door, tmp_path, what):
        path = tmp_path / "port"
        if what == "file":
            path.write_text("precious")
        elif what == "folder":
            path.mkdir()
        elif what == "link":
            path.symlink_to("/somewhere")
        with pytest.raises(UsageError) as caught:
            make_door("missing/port" if what == "no folder" else "port")
        assert "\n" not in str(caught.value)
        assert str(tmp_path) in str(caught.value)
        if what == "file":
            assert path.read_text() == "precious"

    def test_a_failure_leaks_nothing(self, tmp_path):
        (tmp_path / "port").write_text("precious")
        before = os.listdir("/proc/self/fd")
        with pytest.raises(HilbenchError):
            PtyDoor(Scheduler(), tmp_path / "port")
        assert os.listdir("/proc/self/fd") == before

    def test_a_link_that_was_replaced_meanwhile_stays(self, make_door, tmp_path):
        door = make_door()
        (tmp_path / "port").unlink()
        (tmp_path / "port").write_text("somebody else's")
        door.close()
        assert (tmp_path / "port").read_text() == "somebody else's"

    def test_without_a_path(self, make_door):
        assert make_door(None).slave_name.startswith("/dev/pts/")


def test_what_does_not_exist_cannot_be_watched(tmp_path):
    before = len(os.listdir("/proc/self/fd"))
    with pytest.raises(UnavailableError, match="No such file"):
        OpenCloseWatch(str(tmp_path / "missing"))
    assert len(os.listdir("/proc/self/fd")) == before
