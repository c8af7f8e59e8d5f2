from __future__ import annotations

import socket

import pytest

from hilbench.errors import UnavailableError, UsageError
from hilbench.links import Line, TcpDoor
from hilbench.links.tcp import parse_tcp_address

from .conftest import HURRY, until

S = 10**9


@pytest.fixture
def pace():
    return HURRY


@pytest.fixture
def make_door(locked):
    doors = []

    def make(address="0", baud=460_800):
        doors.append(TcpDoor(locked, address, Line(baud=baud)))
        return doors[-1]

    yield make
    for door in doors:
        door.close()


def connect(door):
    client = socket.create_connection((door.host, door.port))
    client.setblocking(False)
    return client


def receive(client):
    try:
        return client.recv(4096)
    except BlockingIOError:
        return None


def test_a_second_client_is_turned_away(locked, make_door):
    door, said = make_door(), []
    door.on_turned_away = lambda: said.append("turned away")
    first = connect(door)
    until(locked, lambda: door.line_is_up)
    second = connect(door)
    until(locked, lambda: door.counters.refused == 1)
    assert said == ["turned away"]
    assert receive(second) == b""
    door.write(b"still yours")
    received = []
    until(locked, lambda: received.append(receive(first) or b"") or b"".join(received) == b"still yours")
    first.close()
    second.close()
    until(locked, lambda: not door.line_is_up)


def test_end_of_file_hangs_up_after_the_last_byte_and_the_next_client_may_come(locked, make_door):
    door = make_door(baud=9600)
    order = []
    door.on_receive = lambda data, at_ns: order.append(data)
    door.on_line = lambda up, at_ns: order.append(up)
    first = connect(door)
    first.send(b"bye")
    first.close()
    second = connect(door)
    until(locked, lambda: order.count(True) == 2)
    assert order == [True, b"b", b"y", b"e", False, True]
    assert door.counters.refused == 0
    second.close()
    until(locked, lambda: not door.line_is_up)


def test_a_reset_hangs_up(locked, make_door):
    door = make_door()
    client = connect(door)
    until(locked, lambda: door.line_is_up)
    client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, b"\x01\x00\x00\x00\x00\x00\x00\x00")
    client.close()
    door.write(b"into the void")
    until(locked, lambda: not door.line_is_up)


def test_a_client_that_does_not_read_never_blocks_the_bench(locked, make_door):
    door = make_door(baud=0)
    client = socket.socket()
    client.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    client.connect((door.host, door.port))
    until(locked, lambda: door.line_is_up)
    for _ in range(100):
        door.write(bytes(10_000))
        locked.run_for(0)
    assert 500_000 < door.counters.lost < door.counters.sent == 1_000_000
    client.close()
    until(locked, lambda: not door.line_is_up)


def test_a_client_that_asks_and_reads_now_and_then_loses_nothing(locked, make_door):
    """Every byte is a segment of its own, and a client that talks acknowledges late: memory is no measure of bytes."""
    door = make_door(baud=9600)
    client = connect(door)
    until(locked, lambda: door.line_is_up)
    received = bytearray()
    for number in range(12):
        client.send(b"PULSE")
        locked.run_for(S // 50)
        door.write(bytes([number]) * 80)
        locked.run_for(S // 10)
        received += receive(client) or b""
    until(locked, lambda: received.extend(receive(client) or b"") or len(received) == 12 * 80)
    assert door.counters.lost == 0
    client.close()


def test_what_was_meant_for_a_client_that_left_does_not_reach_the_next(locked, make_door):
    door = make_door(baud=9600)
    first = connect(door)
    until(locked, lambda: door.line_is_up)
    door.write(bytes(100))
    first.shutdown(socket.SHUT_WR)
    second = connect(door)
    until(locked, lambda: not door.line_is_up)
    until(locked, lambda: door.line_is_up)
    door.write(b"hello")
    locked.run_for(S // 5)
    assert receive(second) == b"hello"
    # On a busy host the first may get a byte or two before its leaving is seen.
    assert door.counters.lost + len(receive(first) or b"") == 100
    first.close()
    second.close()


def test_closing_the_door_is_told_to_the_client(locked, make_door):
    door = make_door()
    client = connect(door)
    until(locked, lambda: door.line_is_up)
    door.close()
    assert receive(client) == b""
    client.close()
    again = make_door(f"{door.port}")
    assert again.port == door.port


def test_a_port_in_use_is_one_line(make_door):
    door = make_door()
    with pytest.raises(UnavailableError, match=f"127.0.0.1:{door.port}: cannot listen") as caught:
        make_door(str(door.port))
    assert "\n" not in str(caught.value)
    with pytest.raises(UnavailableError):
        make_door("192.0.2.1:8101")


@pytest.mark.parametrize(
    ("text", "address"),
    [
        ("8101", ("127.0.0.1", 8101)),
        ("0.0.0.0:0", ("0.0.0.0", 0)),
        ("[::1]:8101", ("::1", 8101)),
        (":1", ("127.0.0.1", 1)),
    ],
)
def test_addresses(text, address):
    assert parse_tcp_address(text) == address


@pytest.mark.parametrize("text", ["", "host", "host:", "host:x", "65536", "-1", "1:²"])
def test_not_addresses(text):
    with pytest.raises(UsageError):
        parse_tcp_address(text)
