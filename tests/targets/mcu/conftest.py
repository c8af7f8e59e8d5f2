"""Slaves for an I2C bus."""

from __future__ import annotations

import pytest


class Memory:
    """A 24C02 without its write cycle: a pointer, 256 bytes, both go round. It logs every call with its time."""

    def __init__(self, address=0x50, data=bytes(range(256))):
        self.own = address
        self.data = bytearray(data)
        self.pointer = 0
        self.fresh = False
        self.calls = []

    def address(self, address, read, now_ns):
        self.calls.append(("address", address, read, now_ns))
        self.fresh = not read
        return address == self.own

    def write(self, byte, now_ns):
        self.calls.append(("write", byte, now_ns))
        if self.fresh:
            self.pointer, self.fresh = byte, False
        else:
            self.data[self.pointer] = byte
            self.pointer = self.pointer + 1 & 0xFF
        return True

    def read(self, now_ns):
        self.calls.append(("read", now_ns))
        self.pointer = self.pointer + 1 & 0xFF
        return self.data[self.pointer - 1 & 0xFF]

    def end(self, now_ns):
        self.calls.append(("end", now_ns))


@pytest.fixture(scope="session")
def make_memory():
    """The class: ``make_memory(address, data)``."""
    return Memory
