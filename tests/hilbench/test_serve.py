"""`hilbench serve` as a process: how it begins, what its clients may do to it, and what it leaves behind."""

from __future__ import annotations

import contextlib
import fcntl
import os
import re
import select
import signal
import socket
import termios

import pytest

from hilbench.cli import main
from hilbench.clock import NS_PER_S, MonotonicHostClock
from hilbench.journal import Journal
from tests.hilbench.forked import CLOSED, HILBENCH, PATIENCE_S
from tests.share import few

SYNC0 = bytes.fromhex("FAFB03000000")
SYNC1 = OPEN = bytes.fromhex("FAFB03010001")
SYNC2 = bytes.fromhex("FAFB03020002")
SIP = re.compile(rb"\xfa\xfb.\x32", re.DOTALL)
FAST = ("--baud", "115200", "--any-baud")
BENCHES = pytest.mark.parametrize("bench", [pytest.param("pioneer", marks=pytest.mark.needs_physics), "pioneer-plane"])
SERVED = pytest.mark.real_time("a process that serves; its words and bytes are waited for, and nothing is timed")


class Client:
    """One end of a line to the robot, read without waiting."""

    def __init__(self, descriptor, close):
        self.descriptor, self.close = descriptor, close
        self.say_no_more = close

    def write(self, data):
        return os.write(self.descriptor, data)

    def flood(self, count):
        """Send so many bytes and read none."""
        while count > 0:
            select.select((), (self.descriptor,), (), PATIENCE_S)
            count -= self.write(SYNC0 * 300)

    def receive(self, count):
        """Wait for so many bytes."""
        data = b""
        while len(data) < count:
            assert select.select((self.descriptor,), (), (), PATIENCE_S)[0], f"only {data.hex()} came"
            more = os.read(self.descriptor, 4096)
            assert more, "hung up"
            data += more
        return data

    def receive_until(self, pattern):
        data = b""
        while not pattern.search(data):
            assert len(data) < 200, data.hex()
            data += self.receive(1)
        return data

    def is_answered(self):
        self.write(SYNC0)
        return self.receive(6) == SYNC0

    def is_answered_after_what_is_under_way(self):
        self.write(SYNC0)
        return self.receive_until(re.compile(re.escape(SYNC0)))

    def set_baud(self, constant):
        attributes = termios.tcgetattr(self.descriptor)
        attributes[4] = attributes[5] = constant
        termios.tcsetattr(self.descriptor, termios.TCSANOW, attributes)


class Served:
    """A serving process, its standard error line by line, and the clients that were opened."""

    def __init__(self, process):
        self.process = process
        self.said = ""
        self.clients = contextlib.ExitStack()

    def ready(self):
        return self.has_said("stop with")

    def has_said(self, words):
        """Wait until it has said these words."""
        self.said = self.process.hear(words)
        return self

    @property
    def port(self):
        return int(re.search(r"tcp .*:(\d+),", self.said)[1])

    def at_pty(self, path):
        descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        return self._client(descriptor, os.close, descriptor)

    def at_tcp(self, buffer_bytes=None):
        connection = socket.socket()
        if buffer_bytes:
            connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, buffer_bytes)
        connection.connect(("127.0.0.1", self.port))
        connection.setblocking(False)
        client = self._client(connection.fileno(), connection.close)
        client.say_no_more = lambda: connection.shutdown(socket.SHUT_WR)
        return client

    def _client(self, descriptor, close, *what):
        closing = self.clients.enter_context(contextlib.ExitStack())
        closing.callback(close, *what)
        return Client(descriptor, closing.close)

    def descriptors(self):
        return len(os.listdir(f"/proc/{self.process.pid}/fd"))

    def end(self, number=signal.SIGINT):
        """Stop it; return its exit code."""
        self.process.send_signal(number)
        self.said += self.process.communicate()[1]
        return self.process.returncode


@pytest.fixture
def link(tmp_path):
    return tmp_path / "p2"


@pytest.fixture
def serve(forkable):
    with contextlib.ExitStack() as stack:

        def start(*words, bench="pioneer-plane", **more):
            process = stack.enter_context(forkable.start("serve", bench, *map(str, words), **more))
            served = Served(process)
            stack.callback(served.clients.close)
            return served

        yield start


def wait_for(condition):
    host = MonotonicHostClock()
    for _ in range(PATIENCE_S * 100):
        if condition():
            break
        host.wait_until(host.monotonic_ns() + NS_PER_S // 100)
    else:
        raise AssertionError("it never happened")
    host.close()


def refused(serve, *words):
    """Return exit code and the only line of a serve that does not begin."""
    served = serve(*words)
    _, said = served.process.communicate()
    assert said.startswith("hilbench: ")
    assert said.count("\n") == 1
    return served.process.returncode, said


# --- ending


@BENCHES
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@SERVED
def test_it_is_stopped_by_a_signal_and_leaves_nothing(serve, link, number, bench):
    served = serve("--pty", link, "--tcp", 0, bench=bench).ready()
    client = served.at_tcp()
    assert client.is_answered()
    assert served.end(number) == 0
    assert not link.is_symlink()
    with socket.socket() as again:
        again.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        again.bind(("127.0.0.1", served.port))
    assert "stopped after" in served.said
    client.close()


@BENCHES
@pytest.mark.parametrize("moment", ["__init__", "close"])
@SERVED
def test_signals_while_it_begins_or_ends_leave_nothing(serve, link, moment, bench):
    program = f"""
import os, signal, sys
import hilbench.systems.pioneer.robot
from hilbench.cli import main
Robot = hilbench.systems.pioneer.robot.VirtualPioneer
usual = Robot.{moment}
def interrupted(self, *words, **more):
    for number in (signal.SIGTERM, signal.SIGINT):
        os.kill(os.getpid(), number)
    usual(self, *words, **more)
Robot.{moment} = interrupted
sys.exit(main())
"""
    served = serve("--pty", link, "--tcp", 0, program=program, bench=bench)
    if moment == "close":
        served.ready().process.send_signal(signal.SIGINT)
    served.said += served.process.communicate()[1]
    assert served.process.returncode == 0
    assert "stopped after" in served.said
    assert "Traceback" not in served.said
    assert not link.is_symlink()


@SERVED
def test_what_a_killed_one_leaves_is_cleared_away_and_its_journal_can_be_read(serve, link, tmp_path):
    served = serve("--pty", link, "--journal", tmp_path / "j").ready()
    client = served.at_pty(link)
    assert client.is_answered()
    wait_for(lambda: '"tx"' in (tmp_path / "j").read_text())
    served.end(signal.SIGKILL)
    assert link.is_symlink()
    client.close()
    recording = Journal.read(tmp_path / "j")
    assert recording.problem is None
    assert not recording.ended
    assert {"kind": "tx", "source": "robot", "data": SYNC0.hex()}.items() <= next(
        event for event in recording.events if event["kind"] == "tx"
    ).items()
    again = serve("--pty", link).ready()
    assert again.at_pty(link).is_answered()
    assert again.end() == 0
    assert not link.is_symlink()


def test_the_help_says_how_it_ends(capfd):
    assert main(["serve", "--help"]) == 0
    assert "the exit code is 0" in " ".join(capfd.readouterr().out.split())


# --- what keeps it from beginning


@SERVED
def test_a_path_or_a_port_that_is_taken(serve, link, tmp_path):
    served = serve("--pty", link, "--tcp", 0).ready()
    code, said = refused(serve, "--pty", link)
    assert code == 3
    assert f"{link}: leads to {link.readlink()}, which is in use; stop the other bench" in said
    code, said = refused(serve, "--tcp", served.port)
    assert code == 3
    assert f"127.0.0.1:{served.port}: cannot listen: Address already in use" in said
    assert served.at_pty(link).is_answered()
    mine = tmp_path / "mine"
    mine.write_text("mine")
    code, said = refused(serve, "--pty", mine)
    assert (code, mine.read_text()) == (2, "mine")
    assert served.end() == 0


def test_a_refused_one_has_touched_nothing(serve, link, tmp_path):
    """Neither the journal of the run before, nor the first door when there is no second."""
    journal = tmp_path / "j"
    Journal(journal).close()
    before = journal.read_text()
    with socket.create_server(("127.0.0.1", 0)) as taken:
        code, _ = refused(serve, "--pty", link, "--tcp", taken.getsockname()[1], "--journal", journal)
    assert (code, journal.read_text()) == (3, before)
    assert not link.is_symlink()


@pytest.mark.parametrize(
    ("words", "code", "hint"),
    [
        (("--scene", "corridr"), 2, "did you mean 'corridor'?"),
        (("--baud", "9600.5"), 2, "9600.5"),
        (("--baud", "0"), 2, "0"),
        (("--clients", "last"), 2, "--clients: invalid choice: 'last' (choose from "),
        (("--hangup", "open"), 2, "--hangup: invalid choice: 'open' (choose from "),
        (("--baud", "14400"), 2, "must be one of 9600, 19200, 38400, 57600, 115200, not 14400"),
        (("--journal", "/dev/full"), 3, "No space left on device"),
    ],
)
def test_wrong_wishes(serve, link, words, code, hint):
    got, said = refused(serve, "--pty", link, *words)
    assert got == code
    assert hint in said
    assert not link.is_symlink()


def test_no_door(serve):
    code, said = refused(serve)
    assert code == 2
    assert "--pty" in said


# --- what clients do


@SERVED
def test_many_clients_at_both_doors_leave_no_descriptors(serve, link):
    served = serve("--pty", link, "--tcp", 0, "--clients", "first", *FAST).ready()
    before = served.descriptors()
    for _ in range(8):
        for client in (served.at_pty(link), served.at_tcp()):
            assert client.is_answered()
            client.close()
    wait_for(lambda: served.descriptors() <= before)
    assert served.end() == 0
    assert served.said.count("a client came") == served.said.count("a client left") == 16


@SERVED
def test_at_either_door_the_first_has_the_line(serve, link):
    served = serve("--pty", link, "--tcp", 0, "--clients", "first", *FAST).ready()
    first = served.at_pty(link)
    assert first.is_answered()
    second = served.at_tcp()
    served.has_said("another client came and is ignored: the first one has the line, at another endpoint")
    second.write(SYNC0)
    assert first.is_answered()
    first.close()
    # What the second said while the first had the line is lost; he is heard once the robot has seen the first go.
    wait_for(lambda: second.write(SYNC0) and select.select((second.descriptor,), (), (), 0)[0])
    second.close()
    third = served.at_pty(link)
    wait_for(lambda: third.write(SYNC0) and select.select((third.descriptor,), (), (), 0)[0])
    assert served.end() == 0


@SERVED
def test_a_second_tcp_client_is_turned_away(serve):
    served = serve("--tcp", 0, "--clients", "first", *FAST).ready()
    first = served.at_tcp()
    assert first.is_answered()
    second = served.at_tcp()
    served.has_said("a client was refused: another one is connected")
    assert select.select((second.descriptor,), (), (), PATIENCE_S)[0]
    assert os.read(second.descriptor, 1) == b""
    assert first.is_answered()
    assert served.end() == 0
    assert "1 clients refused" in served.said


@SERVED
def test_a_program_that_leaks_its_first_socket_is_heard_at_its_second(serve):
    served = serve("--tcp", 0, *FAST).ready()
    leaked = served.at_tcp()
    served.has_said("a client came")
    second = served.at_tcp()
    assert second.is_answered()
    assert leaked.receive(6) == SYNC0
    second.close()
    served.has_said("another client came: 2 are connected").has_said("one client left: 1 still connected")
    assert served.end() == 0
    assert "refused" not in served.said


@SERVED
def test_the_newest_client_may_take_over(serve):
    served = serve("--tcp", 0, "--clients", "newest", *FAST).ready()
    first = served.at_tcp()
    assert first.is_answered()
    second = served.at_tcp()
    assert second.is_answered()
    assert select.select((first.descriptor,), (), (), PATIENCE_S)[0]
    assert os.read(first.descriptor, 1) == b""
    assert served.end() == 0
    assert "another client came and took over; the one before it was disconnected" in served.said
    assert served.said.count("a client came") == 2


@pytest.mark.parametrize("door", ["pty", "tcp"])
@SERVED
def test_a_robot_that_is_not_told_of_a_hang_up_goes_on_with_the_session(serve, link, door):
    served = serve("--pty", link, "--tcp", 0, "--hangup", "ignore", *FAST).ready()
    came = served.at_pty if door == "pty" else lambda _link: served.at_tcp()
    client = came(link)
    client.write(SYNC0)
    client.receive_until(re.compile(re.escape(SYNC0)))
    client.write(SYNC1 + SYNC2 + OPEN)
    client.receive_until(SIP)
    client.close()
    served.has_said("a client left; the target is not notified")
    came(link).receive_until(SIP)
    assert served.end() == 0


@pytest.mark.parametrize("door", ["pty", "tcp"])
@SERVED
def test_a_client_that_dies_in_session_finds_the_robot_free_at_once(serve, link, door):
    """A line whose last client has closed it is hung up, however soon the next one opens it."""
    served = serve("--pty", link, "--tcp", 0, *FAST).ready()
    for _ in range(4):
        client = served.at_pty(link) if door == "pty" else served.at_tcp()
        client.write(SYNC0)
        # On a pty the first bytes may be the rest of a packet that was on the wire when the client came.
        assert not SIP.search(client.receive_until(re.compile(re.escape(SYNC0))))
        client.write(SYNC1 + SYNC2 + OPEN)
        client.receive_until(SIP)
        client.close()
    assert served.end() == 0
    assert served.said.count("a client came") == 4


FORGETFUL = f"""\
import sys
import hilbench.links.tcp
from hilbench.links import PtyDoor, TcpDoor

def telling(put):
    def give(door, data, at_ns):
        before = door.counters.lost
        put(door, data, at_ns)
        if door.counters.lost > before == 0:
            print("there is no more room", file=sys.stderr, flush=True)
    return give

hilbench.links.tcp._UNREAD_BYTES = 1000
for door in (PtyDoor, TcpDoor):
    door._put = telling(door._put)
{HILBENCH}"""
"""Serving that keeps little for a TCP client that does not read, and says when that is full.

What a pty keeps is the system's: up to 22 000 bytes.
"""


@pytest.mark.slow("the line takes two seconds for more bytes than the system keeps for the reader of a pty")
@pytest.mark.parametrize("door", few(["tcp", "pty"], 1, "the gate has a socket here, and a pty in links/test_pty"))
@SERVED
def test_a_client_that_does_not_read_harms_nobody(serve, link, door):
    served = serve("--pty", link, "--tcp", 0, *FAST, program=FORGETFUL).ready()
    deaf = served.at_pty(link) if door == "pty" else served.at_tcp(4096)
    deaf.flood(30_000 if door == "pty" else 8_000)
    served.has_said("there is no more room")
    deaf.say_no_more()
    served.has_said("a client left")
    assert served.at_pty(link).is_answered_after_what_is_under_way()
    assert served.end() == 0
    assert re.search(r"[1-9]\d* of them dropped, as no client read them", served.said), served.said


@SERVED
def test_a_wrong_rate_garbles_and_is_told_once(serve, link):
    served = serve("--pty", link).ready()
    client = served.at_pty(link)
    client.set_baud(termios.B115200)
    for _ in range(3):
        client.write(SYNC0)
        client.set_baud(termios.B115200)
    served.has_said("garbled")
    client.set_baud(termios.B9600)
    # What the robot has not read yet of the bytes before, it hears at the rate of now.
    assert client.is_answered_after_what_is_under_way()
    assert served.end() == 0
    assert served.said.count("garbled") == 1
    assert (
        "the client set 115200 baud, the target listens at 9600; "
        "bytes are garbled as on a real line; --any-baud or --baud 115200"
    ) in served.said


@SERVED
def test_any_baud_garbles_nothing(serve, link):
    served = serve("--pty", link, "--any-baud").ready()
    client = served.at_pty(link)
    client.set_baud(termios.B115200)
    assert client.is_answered()
    assert served.end() == 0
    assert "garbled" not in served.said


# --- nobody listens to what it says


@pytest.mark.parametrize("stream", ["closed", "broken", "full"])
@SERVED
def test_nobody_hears_it(serve, link, stream):
    read, write = os.pipe()
    words: dict[str, object] = {"stderr": write}
    if stream == "broken":
        os.close(read)
    elif stream == "full":
        fcntl.fcntl(write, fcntl.F_SETPIPE_SZ, 4096)
        os.write(write, bytes(4096))
    else:
        words = {"stderr": CLOSED}
    served = serve("--pty", link, *FAST, **words)
    wait_for(link.is_symlink)
    for _ in range(3):
        client = served.at_pty(link)
        assert client.is_answered()
        client.close()
    assert served.end() == 0
    assert not link.is_symlink()
    os.close(write)
    if stream != "broken":
        os.close(read)
