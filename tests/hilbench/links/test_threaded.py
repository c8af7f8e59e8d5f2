"""Ports without a descriptor: two threads do the waiting."""

from __future__ import annotations

import io
import os
import threading

import pytest
import serial

from hilbench.links import SerialPort

from .conftest import until

S = 10**9


class Stub:
    """Something of pyserial's kind: bytes wait until `gate` is open, and it may break."""

    port = "stub://"
    in_waiting = 0

    def __init__(self):
        self.written = bytearray()
        self.gate = threading.Event()
        self.gate.set()
        self.broken = False
        self.closed = threading.Event()
        self.to_read = []

    def fileno(self):
        raise io.UnsupportedOperation

    def read(self, size):
        if self.to_read:
            return self.to_read.pop(0)
        if self.closed.wait(0.01):
            raise TypeError("closed under its hands")
        return b""

    def write(self, data):
        self.gate.wait()
        if self.broken:
            raise serial.SerialException("gone")
        self.written += data

    def close(self):
        self.gate.set()
        self.closed.set()


@pytest.fixture
def stub(opens):
    return opens(Stub())


def test_all_is_written_in_order_and_nobody_waits(locked, stub):
    port = SerialPort(locked, "stub://x")
    data = os.urandom(20_000)
    port.write(data)
    assert port.pending == len(data)
    until(locked, lambda: not port.pending)
    assert stub.written == data
    port.close()
    assert port.counters.lost == 0


def test_what_cannot_be_written_is_lost_after_the_timeout_and_counted(locked, stub):
    stub.gate.clear()
    port = SerialPort(locked, "stub://x", write_timeout_s=0.02)
    port.write(bytes(10_000))
    until(locked, lambda: port.counters.lost > 0)
    assert port.counters.lost == 10_000 - 4096
    assert port.pending == 4096
    port.close()
    assert port.counters.lost == 10_000


def test_last_words_are_written_before_it_is_closed(locked, stub):
    port = SerialPort(locked, "stub://x")
    port.write(b"last words")
    port.close()
    assert stub.written == b"last words"
    assert port.counters.lost == 0


def test_a_port_that_breaks_takes_the_line_down(locked, stub):
    stub.broken = True
    port = SerialPort(locked, "stub://x")
    port.write(b"!")
    until(locked, lambda: not port.line_is_up)
    port.close()


def test_what_came_before_the_end_is_delivered(locked, stub):
    stub.to_read = [b"one", b"two"]
    port = SerialPort(locked, "stub://x")
    got = bytearray()
    port.on_receive = lambda data, at_ns: got.extend(data)
    until(locked, lambda: got == b"onetwo")
    stub.closed.set()
    until(locked, lambda: not port.line_is_up)
    port.close()
