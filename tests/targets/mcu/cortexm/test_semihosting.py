"""Semihosting calls as newlib and other libraries make them."""

from __future__ import annotations

import pytest

from targets.mcu.cortexm.semihosting import Exit, Semihosting
from targets.mcu.engine.api import Reg

FAILED = 0xFFFF_FFFF


class Debugger:
    def __init__(self, rig, command_line=""):
        self.rig = rig
        self.services = rig.chip.services
        self.host = Semihosting(rig.cpu, self.services.bus, self.services.time, self.services.notes, command_line)
        self.output = []
        self.exits = []
        self.host.on_output = self.output.append
        self.host.on_exit = self.exits.append

    def call(self, operation, parameter=0):
        self.rig.cpu.set(Reg.R0, operation)
        self.rig.cpu.set(Reg.R1, parameter)
        self.host.call()
        return self.rig.cpu.get(Reg.R0)

    def block(self, *words):
        for index, word in enumerate(words):
            self.rig.memory.write(self.rig.RAM + 4 * index, 4, word)
        return self.rig.RAM

    def text(self, text):
        self.rig.memory.load(self.rig.RAM + 0x80, text)
        return self.rig.RAM + 0x80

    def open(self, name=b":tt", mode=4):
        return self.call(0x01, self.block(self.text(name + b"\0"), mode, len(name)))


@pytest.fixture
def host(rig):
    return Debugger(rig)


def test_goes_on_after_the_breakpoint(host):
    pc, cycle = host.rig.cpu.get(Reg.PC), host.rig.cpu.cycle
    host.call(0x03, host.text(b"A"))
    assert host.rig.cpu.get(Reg.PC) == pc + 2
    assert host.rig.cpu.cycle == cycle + 1


def test_characters_and_texts(host):
    host.call(0x03, host.text(b"A"))
    host.call(0x04, host.text(b"hello\n\0 no more"))
    assert host.output == [b"A", b"hello\n"]


def test_console_as_newlib_uses_it(host):
    handles = [host.open(mode=mode) for mode in (0, 4, 8)]
    assert len(set(handles)) == 3
    assert FAILED not in handles
    assert host.call(0x09, host.block(handles[1])) == 1
    assert host.call(0x0C, host.block(handles[1])) == 0
    assert host.call(0x05, host.block(handles[1], host.text(b"abc"), 3)) == 0
    assert host.output == [b"abc"]
    assert host.call(0x06, host.block(handles[0], host.rig.RAM + 0x100, 16)) == 16  # nothing was read
    assert host.call(0x07) == FAILED
    assert host.call(0x02, host.block(handles[1])) == 0
    assert host.call(0x02, host.block(handles[1])) == FAILED
    assert host.call(0x13) == 9
    assert host.call(0x05, host.block(handles[1], host.text(b"abc"), 3)) == 3
    assert host.call(0x09, host.block(99)) == FAILED


def test_the_extensions_as_newlib_looks_for_them(host):
    """Without the first, newlib ends a program with status 0 whatever it gave to exit()."""
    handle = host.open(b":semihosting-features", 0)
    assert host.call(0x09, host.block(handle)) == 0
    assert host.call(0x0C, host.block(handle)) == 5
    assert host.call(0x06, host.block(handle, host.rig.RAM + 0x200, 4)) == 0
    assert host.call(0x0A, host.block(handle, 4)) == 0
    assert host.call(0x06, host.block(handle, host.rig.RAM + 0x204, 3)) == 2
    assert host.rig.memory.dump(host.rig.RAM + 0x200, 5) == b"SHFB\x03"
    assert host.call(0x06, host.block(handle, host.rig.RAM + 0x204, 1)) == 1
    assert host.call(0x0A, host.block(handle, 6)) == FAILED
    assert host.call(0x05, host.block(handle, host.text(b"abc"), 3)) == 3
    assert host.call(0x02, host.block(handle)) == 0
    assert host.call(0x0C, host.block(handle)) == FAILED


def test_there_are_no_other_files(host):
    assert host.open(b"result.txt", 0) == FAILED
    assert host.call(0x13) == 2
    assert host.rig.chip.notes.all == []


def test_is_error(host):
    assert host.call(0x08, host.block(FAILED)) == 1
    assert host.call(0x08, host.block(3)) == 0


def test_clocks_are_bench_time(host):
    host.rig.advance(72_000_000 * 3 // 2)
    assert host.call(0x10) == 150
    assert host.call(0x11) == 1


def test_command_line(rig):
    host = Debugger(rig, "test -v")
    block = host.block(rig.RAM + 0x200, 8)
    assert host.call(0x15, block) == 0
    assert rig.memory.dump(rig.RAM + 0x200, 8) == b"test -v\0"
    assert rig.memory.read(block + 4, 4) == 7
    assert host.call(0x15, host.block(rig.RAM + 0x200, 7)) == FAILED


def test_heap_is_the_programs_own_business(host):
    host.rig.memory.load(host.rig.RAM + 0x200, b"\xff" * 16)
    host.call(0x16, host.block(host.rig.RAM + 0x200))
    assert host.rig.memory.dump(host.rig.RAM + 0x200, 16) == bytes(16)


@pytest.mark.parametrize(
    ("operation", "parameter", "expected"),
    [
        (0x18, 0x20026, Exit(0, 0x20026)),
        (0x18, 0x20023, Exit(1, 0x20023)),
        (0x20, (0x20026, 7), Exit(7, 0x20026)),
        (0x20, (0x20026, 0), Exit(0, 0x20026)),
        (0x20, (0x20024, 0), Exit(1, 0x20024)),
    ],
)
def test_exits(host, operation, parameter, expected):
    host.call(operation, host.block(*parameter) if isinstance(parameter, tuple) else parameter)
    assert host.exits == [expected]


def test_what_is_not_there_is_noted(host):
    assert host.call(0x0E, host.block(1, 0)) == FAILED
    assert host.call(0x13) == 38
    assert host.rig.chip.noted("unmodelled") == ["semihosting 0xE"]


def test_parameters_that_cannot_be_read(host):
    assert host.call(0x04, 0x3000_0000) == FAILED
    assert host.rig.chip.noted("misuse") == ["semihosting SYS_WRITE0"]
