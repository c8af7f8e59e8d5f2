"""`hilbench serve xrce-agent`, and clients that are none of ours: their bytes are put together here, by hand."""

from __future__ import annotations

import os
import re
import select
import signal
import socket
import struct

import pytest

from hilbench.journal import Journal
from tests.hilbench.forked import PATIENCE_S

SERVED = pytest.mark.real_time("a process that serves; its bytes are waited for, and nothing is timed")
TOPIC, TYPE = "rt/speed", "std_msgs::msg::dds_::Float32_"


def crc(payload):
    value = 0
    for byte in payload:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
    return value


class SerialFrames:
    """7E, addresses 1 and 0, length, payload, CRC; 7E and 7D escaped."""

    def __init__(self, path):
        self.descriptor = os.open(path, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        self.close = lambda: os.close(self.descriptor)
        self._came = b""

    def send(self, payload):
        body = struct.pack("<BBH", 1, 0, len(payload)) + payload + struct.pack("<H", crc(payload))
        os.write(self.descriptor, b"\x7e" + body.replace(b"\x7d", b"\x7d\x5d").replace(b"\x7e", b"\x7d\x5e"))

    def receive(self):
        while True:
            at = self._came.find(b"\x7e")
            body = re.sub(
                rb"\x7d(.)", lambda found: bytes((found[1][0] ^ 0x20,)), self._came[at + 1 :], flags=re.DOTALL
            )
            length = int.from_bytes(body[2:4], "little") if at >= 0 and len(body) >= 4 else 0xFFFF
            if len(body) >= 4 + length + 2:
                payload = body[4 : 4 + length]
                assert body[:2] == bytes((0, 1))
                assert body[4 + length : 6 + length] == struct.pack("<H", crc(payload))
                end = self._came.find(b"\x7e", at + 1)
                self._came = b"" if end < 0 else self._came[end:]
                return payload
            self._came += read(self.descriptor)


class Lengths:
    """The length, and the payload."""

    def __init__(self, port):
        self.socket = socket.create_connection(("127.0.0.1", port))
        self.socket.setblocking(False)
        self.close = self.socket.close
        self._came = self.sent = b""

    def send(self, payload):
        data = struct.pack("<H", len(payload)) + payload
        self.sent += data
        self.socket.sendall(data)

    def receive(self):
        while len(self._came) < 2 or len(self._came) < 2 + int.from_bytes(self._came[:2], "little"):
            self._came += read(self.socket.fileno())
        length = int.from_bytes(self._came[:2], "little")
        payload, self._came = self._came[2 : 2 + length], self._came[2 + length :]
        return payload


def read(descriptor):
    assert select.select((descriptor,), (), (), PATIENCE_S)[0], "nothing came"
    data = os.read(descriptor, 4096)
    assert data, "hung up"
    return data


def text(words):
    data = words.encode() + b"\0"
    return struct.pack("<I", len(data)) + data


def padded(data):
    return data + bytes(-len(data) % 4)


class Client:
    """Session 81, a reliable stream each way; asks, and waits for the answer."""

    def __init__(self, line, key):
        self.line, self.key = line, key
        self._sent = 0
        self._request = 9

    def say(self, number, payload, *, flags=1, reliable=True):
        header = struct.pack("<BBH", 0x81, 0x80 if reliable else 0, self._sent if reliable else 0)
        self._sent += reliable
        self.line.send(header + struct.pack("<BBH", number, flags, len(payload)) + payload)

    def hear(self, number):
        """The payload of the next submessage of this number."""
        while True:
            kind, payload = self.hear_any()
            if kind == number:
                return payload

    def hear_any(self):
        """The next message, whose submessage is acknowledged if the stream is reliable: its number and payload."""
        message = self.line.receive()
        session, stream, sequence = struct.unpack("<BBH", message[:4])
        assert session == 0x81
        if stream >= 0x80:
            self.say(10, struct.pack("<HHB", sequence + 1, 0, stream), reliable=False)
        kind, flags, length = struct.unpack("<BBH", message[4:8])
        assert flags & 1 or kind == 9  # data are in the order of who wrote them
        return kind, message[8 : 8 + length]

    def connect(self):
        self._sent = 0
        asked = b"XRCE\x01\x00\x01\x0f" + self.key + b"\x81\x00" + struct.pack("<H", 512)
        self.line.send(b"\x80\0\0\0" + struct.pack("<BBH", 0, 1, len(asked)) + asked)
        assert self.hear(4)[:10] == b"\0\0XRCE\x01\x00\x01\x0f"

    def create(self, object_id, kind, variant):
        """CREATE in binary; the status."""
        self._request += 1
        asked = struct.pack(">HH", self._request, object_id) + bytes((kind, 3))
        self.say(1, padded(asked) + struct.pack("<I", len(variant[0])) + variant[0] + variant[1])
        answer = self.hear(5)
        assert answer[:4] == struct.pack(">HH", self._request, object_id)
        return answer[4]

    def create_all(self):
        there = struct.pack(">H", 0x0011)
        topic = padded(text(TOPIC) + b"\0\1") + text(TYPE)
        return [
            self.create(0x0011, 1, (b"\0\0", struct.pack("<h", 0))),
            self.create(0x0012, 2, (topic, there)),
            self.create(0x0013, 3, (b"\0\0", there)),
            self.create(0x0014, 4, (b"\0\0", there)),
            self.create(0x0015, 5, (struct.pack(">H", 0x0012) + b"\0", struct.pack(">H", 0x0013))),
            self.create(0x0016, 6, (struct.pack(">H", 0x0012) + b"\0", struct.pack(">H", 0x0014))),
        ]


@pytest.fixture
def serve(forkable, tmp_path):
    process = forkable.start("serve", "xrce-agent", "--pty", str(tmp_path / "board"), "--tcp", "0")
    with process:
        said = process.hear("stop with")
        assert re.search(r"agent.line1 at \S+board ", said)
        assert re.search(r"agent.line2 at tcp ", said)
        yield process, tmp_path / "board", int(re.search(r"tcp .*:(\d+),", said)[1])
        process.send_signal(signal.SIGINT)
        said = process.communicate()[1]
        assert process.returncode == 0, said


@SERVED
def test_a_board_at_a_pty_and_a_program_at_a_socket_hear_each_other(serve):
    _, path, port = serve
    board, program = Client(SerialFrames(path), b"\xaa\xbb\xcc\x7e"), Client(Lengths(port), b"\x01\x02\x03\x04")
    for client in (board, program):
        client.connect()
        assert client.create_all() == [0] * 6
        assert client.create(0x0012, 2, (padded(text("x") + b"\0\1") + text("y"), b"\0\x11")) == 0x82
    unlimited = struct.pack("<HHHH", 0xFFFF, 0, 0, 0)
    for client in (board, program):
        client.say(8, struct.pack(">HH", 0x0020, 0x0016) + b"\x80\0\0\1" + unlimited)
    for number in range(5):
        data = struct.pack("<f", number / 2)
        board.say(7, struct.pack(">HH", 0x0030, 0x0015) + data)
        for client in (board, program):
            assert client.hear(9) == struct.pack(">HH", 0x0020, 0x0016) + data
    board.say(14, struct.pack("<iI", 5, 6), reliable=False)
    reply = struct.unpack("<iIiIiI", board.hear(15))
    assert reply[4:] == (5, 6)
    assert reply[0] > 1_700_000_000  # the host's clock
    board.line.send(b"\x80\0\0\0" + struct.pack("<BBH", 2, 1, 8) + b"\0\x0a\xff\xfd" + struct.pack("<I", 2))
    assert board.line.receive()[:4] == b"\x80\0\0\0"
    board.say(3, struct.pack(">HH", 2, 0xFFFE), reliable=False)
    assert board.hear(5) == struct.pack(">HH", 2, 0xFFFE) + b"\0\0"
    for client in (board, program):
        client.line.close()


@SERVED
def test_a_board_that_is_plugged_in_again_begins_anew(serve):
    _, path, _ = serve
    for _ in range(3):
        board = Client(SerialFrames(path), b"\xaa\xbb\xcc\xdd")
        board.connect()
        assert board.create_all() == [0] * 6
        board.line.close()


@SERVED
def test_a_second_client_at_a_socket_is_turned_away_and_the_first_goes_on(serve):
    process, _, port = serve
    first, second = Client(Lengths(port), b"\1\2\3\4"), socket.create_connection(("127.0.0.1", port))
    assert select.select((second,), (), (), PATIENCE_S)[0]
    assert second.recv(1) == b""
    process.hear("a client was refused: another one is connected")
    first.connect()
    assert first.create_all() == [0] * 6
    second.close()
    first.line.close()


@SERVED
def test_the_journal_has_what_came_at_each_line(forkable, tmp_path):
    path = tmp_path / "j.jsonl"
    with forkable.start("serve", "xrce-agent", "--tcp", "0", "--tcp", "0", "--journal", str(path)) as process:
        ports = re.findall(r"tcp .*:(\d+),", process.hear("stop with"))
        clients = [Client(Lengths(int(port)), bytes((1, 2, 3, number))) for number, port in enumerate(ports)]
        for client in clients:
            client.connect()
            assert client.create(0x0011, 1, (b"\0\0", struct.pack("<h", 0))) == 0
            client.say(3, struct.pack(">HH", 2, 0xFFFE), reliable=False)
            client.hear(5)
        process.send_signal(signal.SIGINT)
        said = process.communicate()[1]
        assert process.returncode == 0, said
    came = {"line1": b"", "line2": b""}
    for event in Journal.read(path).events:
        if event["kind"] == "rx":
            assert event["source"] == "agent"
            came[event["line"]] += bytes.fromhex(event["data"])
    assert [*came.values()] == [client.line.sent for client in clients]
    for client in clients:
        client.line.close()
