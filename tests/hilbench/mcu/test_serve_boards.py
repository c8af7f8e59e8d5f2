"""Doors of emulated boards, and `hilbench serve bluepill:IMAGE` as a process."""

from __future__ import annotations

import contextlib
import os
import re
import select
import signal
import socket
import termios
from pathlib import Path

import pytest

from hilbench.errors import UsageError
from hilbench.serving.usart_doors import assign
from hilbench.terminal.options import PtyDoor, ServeOptions, TcpDoor
from tests.each import each
from tests.hilbench.forked import PATIENCE_S

IMAGES = Path(__file__).parents[3] / "targets/firmware/images"
SERVED = pytest.mark.real_time("a process that serves; its words and bytes are waited for, and nothing is timed")


# --- which USART gets which door

FREE = ["bluepill.usart1", "bluepill.usart2", "bluepill.usart3"]


def assigned(*wishes, free=FREE):
    ptys = tuple(wish for wish in wishes if isinstance(wish, PtyDoor))
    tcps = tuple(wish for wish in wishes if isinstance(wish, TcpDoor))
    return dict(assign(ServeOptions(what="x", ptys=ptys, tcps=tcps), free))


def pty(path, link=""):
    return PtyDoor(path=Path(path), link=link)


def test_without_a_wish_each_usart_has_a_pty_called_after_it():
    doors = assigned()
    assert [str(door.path) for (door,) in doors.values()] == ["bluepill-usart1", "bluepill-usart2", "bluepill-usart3"]
    assert list(doors) == FREE


def test_a_board_may_say_which_of_them_have_one_unasked():
    doors = assign(ServeOptions(what="x", ptys=(), tcps=()), FREE, FREE[1:2])
    assert {name: [str(door.path) for door in found] for name, found in doors.items()} == {FREE[1]: ["bluepill-usart2"]}


def test_doors_without_a_name_take_the_usarts_in_order():
    tcp = TcpDoor(port=8101)
    assert assigned(pty("a"), pty("b"), tcp) == {FREE[0]: [pty("a"), tcp], FREE[1]: [pty("b")]}
    assert assigned(pty("a"), pty("b", "usart1")) == {FREE[0]: [pty("b", "usart1")], FREE[1]: [pty("a")]}
    assert list(assigned(pty("a", "bluepill.usart3"))) == [FREE[2]]
    assert list(assigned(pty("a", "USART2"))) == [FREE[1]]


@each(
    ("wishes", "free", "said"),
    [
        (
            [pty("a", "usart4")],
            FREE,
            "--pty usart4=: no such line, or it is linked already; lines: bluepill.",
        ),
        (
            [pty("a", "usart1"), pty("b", "bluepill.usart1")],
            FREE,
            "--pty bluepill.usart1=: bluepill.usart1 has an endpoint of this kind already",
        ),
        ([pty("a")] * 4, FREE, "--pty: more of them than lines (bluepill.usart1, "),
        ([TcpDoor(port=0)], [], "--tcp: more of them than lines (none is free)"),
        ([pty("a", "usart1")], ["a.usart1", "b.usart1"], "several boards have it; write one of a.usart1, b.usart1"),
    ],
)
def test_doors_that_lead_nowhere(wishes, free, said):
    with pytest.raises(UsageError) as raised:
        assigned(*wishes, free=free)
    assert said in str(raised.value)


# --- as a process


class Served:
    def __init__(self, process):
        self.process = process
        self.said = ""

    def has_said(self, words, times=1):
        self.said = self.process.hear(words, times)
        return self

    def end(self, number=signal.SIGINT):
        self.process.send_signal(number)
        return self.wait()

    def wait(self):
        self.said += self.process.communicate()[1]
        return self.process.returncode


@pytest.fixture
def serve(forkable, tmp_path):
    with contextlib.ExitStack() as stack:

        def start(*words):
            return Served(stack.enter_context(forkable.start("serve", *map(str, words), cwd=tmp_path)))

        yield start


def exchange(descriptor, data):
    """Send data and wait for as much."""
    got = b""
    os.write(descriptor, data)
    while len(got) < len(data):
        assert select.select((descriptor,), (), (), PATIENCE_S)[0], got
        got += os.read(descriptor, 4096)
    return got


def open_pty(path, baud=None):
    descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
    if baud is not None:
        attributes = termios.tcgetattr(descriptor)
        attributes[4] = attributes[5] = baud
        termios.tcsetattr(descriptor, termios.TCSANOW, attributes)
    return descriptor


def echoes(path):
    """Ask until the firmware is up: before that the line is deaf. Then nothing is under way any more."""
    descriptor, got = open_pty(path), b""
    try:
        for _ in range(PATIENCE_S * 20):
            os.write(descriptor, b"?")
            if select.select((descriptor,), (), (), 0.05)[0]:
                break
        os.write(descriptor, b"!")
        while not got.endswith(b"!"):
            assert select.select((descriptor,), (), (), PATIENCE_S)[0], got
            got += os.read(descriptor, 4096)
        return set(got) == set(b"?!")
    finally:
        os.close(descriptor)


@SERVED
def test_an_echo_on_a_pty_and_a_hundred_clients(serve, tmp_path):
    served = serve(f"bluepill:{IMAGES / 'echo-irq.elf'}", "--pty", "./u1", "--journal", "j").has_said("stop with")
    assert "serving bluepill.usart1 at u1 (/dev/pts/" in served.said
    assert "at the rate the firmware sets" in served.said
    assert echoes(tmp_path / "u1")
    served.has_said("a client left", 1)  # to find that out it lets go of a descriptor for a moment
    before = len(os.listdir(f"/proc/{served.process.pid}/fd"))
    for number in range(100):
        client = open_pty(tmp_path / "u1", termios.B115200)
        # What a client leaves unread is thrown away when the next one opens, so the first bytes are fresh.
        assert exchange(client, bytes([number])) == bytes([number])
        os.close(client)
    served.has_said("a client left", 101)
    assert len(os.listdir(f"/proc/{served.process.pid}/fd")) < before + 10
    assert served.end() == 0
    assert served.said.count("a client came") == served.said.count("a client left") == 101
    assert not (tmp_path / "u1").is_symlink()
    journal = (tmp_path / "j").read_text()
    assert '"kind":"tx"' in journal
    assert journal.count('"kind":"reset"') == 1  # at power-on: it is the same board for all of them


@SERVED
def test_of_a_board_with_a_virtual_com_port_that_one_is_served(serve, tmp_path):
    served = serve(f"nucleo-f767zi:{IMAGES / 'f767-demo.elf'}").has_said("stop with")
    assert served.said.count("serving ") == 1
    assert "serving nucleo-f767zi.usart3 at nucleo-f767zi-usart3 (/dev/pts/" in served.said
    client, got = open_pty(tmp_path / "nucleo-f767zi-usart3"), b""
    while not got.endswith(b"?"):  # what it says of itself comes first
        os.write(client, b"?")
        assert select.select((client,), (), (), PATIENCE_S)[0], got
        got += os.read(client, 4096)
    os.close(client)
    assert served.end() == 0


@SERVED
def test_a_part_is_soldered_to_it(serve, tmp_path):
    """The program says so at each frame that its display has acknowledged, and nothing without a display."""
    served = serve(f"bluepill:{IMAGES / 'style-display.elf'}", "--part", "display=ssd1306@I2C1").has_said("stop with")
    client, got = open_pty(tmp_path / "bluepill-usart1"), b""
    while b"frame" not in got:
        assert select.select((client,), (), (), PATIENCE_S)[0], got
        got += os.read(client, 4096)
    os.close(client)
    assert served.end() == 0


def test_a_part_that_is_none_is_refused(serve):
    served = serve(f"bluepill:{IMAGES / 'style-display.elf'}", "--part", "display=ssd1306")
    assert served.wait() == 2
    assert served.said.startswith("hilbench: --part: display: its bus 'i2c' leads nowhere; write ")


@SERVED
def test_each_usart_on_a_door_of_its_own(serve, tmp_path):
    served = serve(f"bluepill:{IMAGES / 'echo-all.elf'}", "--tcp", "usart2=0", "--pty", "usart1=a", "--pty", "usart3=c")
    served.has_said("stop with")
    assert echoes(tmp_path / "a")
    with socket.create_connection(("127.0.0.1", int(re.search(r"usart2 at tcp .*:(\d+),", served.said)[1]))) as client:
        client.setblocking(False)
        assert exchange(client.fileno(), b"over tcp") == b"over tcp"
    assert echoes(tmp_path / "c")
    assert served.end(signal.SIGTERM) == 0


@SERVED
def test_the_newest_client_of_a_usart_takes_over(serve):
    served = serve(f"bluepill:{IMAGES / 'echo-irq.elf'}", "--tcp", "0", "--clients", "newest").has_said("stop with")
    address = ("127.0.0.1", int(re.search(r"tcp .*:(\d+),", served.said)[1]))
    with socket.create_connection(address, timeout=PATIENCE_S) as first:
        served.has_said("a client came")
        with socket.create_connection(address) as second:
            assert first.recv(1) == b""
            for _ in range(PATIENCE_S * 20):  # before the firmware is up the line is deaf
                second.sendall(b"?")
                if select.select((second,), (), (), 0.05)[0]:
                    break
            assert second.recv(1) == b"?"
    served.has_said("another client came and took over; the one before it was disconnected")
    assert served.end() == 0


@SERVED
def test_a_client_at_a_wrong_rate_gets_garbage_and_is_told(serve, tmp_path):
    served = serve(f"bluepill:{IMAGES / 'echo-irq.elf'}").has_said("stop with")
    assert echoes(tmp_path / "bluepill-usart1")
    served.has_said("a client left")
    client = open_pty(tmp_path / "bluepill-usart1", termios.B9600)
    os.write(client, b"UUUU")
    served.has_said("the client at bluepill-usart1 set 9600 baud, the line runs at 115200; bytes are garbled")
    os.close(client)
    assert served.end() == 0


def test_firmware_that_cannot_run_on_ends_serving(serve):
    served = serve(f"bluepill:{IMAGES / 'bad-lockup.elf'}")
    assert served.wait() == 1
    assert "hilbench: bluepill: lockup in " in served.said


def test_a_refused_one_has_touched_nothing(serve, tmp_path):
    (tmp_path / "mine").write_text("mine")
    served = serve(f"bluepill:{IMAGES / 'echo-irq.elf'}", "--pty", "a", "--pty", "usart2=mine", "--journal", "j")
    assert served.wait() == 2
    assert "mine: something is there already" in served.said
    assert sorted(path.name for path in tmp_path.iterdir()) == ["mine"]
