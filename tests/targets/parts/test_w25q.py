"""A W25Q64 by its data sheet: identities, reading, programming, erasing, protection, being busy, power-down."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from targets.mcu.spi_bus import SpiBus
from targets.parts.testing import PartBench
from targets.parts.w25q import W25q
from targets.parts.w25q.array import Array
from targets.parts.w25q.w25q import FlashChanged, FlashIgnored, W25qSettings
from tests.each import each
from tests.share import examples

WREN, READ, PROGRAM, STATUS, SECTOR = 0x06, 0x03, 0x02, 0x05, 0x20
BYTE_NS = 1000
MS = 1_000_000


class Rig:
    """A flash, and a master that clocks a byte in each microsecond."""

    def __init__(self, **settings):
        self.bench = PartBench(W25q, W25qSettings(**settings))
        self.flash = self.bench.part
        self.slave = self.flash.spi_slave("spi")
        self.cs = self.bench.wires["cs"]
        self.cs.set(True, 0)
        self.now_ns = 0

    def wait(self, ns):
        self.now_ns += ns
        self.bench.run_to(self.now_ns)

    def transfer(self, *command, read=0):
        """One command between two edges of chip select; return what was read behind it."""
        self.wait(BYTE_NS)
        self.cs.set(False, self.now_ns)
        found = []
        for byte in (*command, *(0,) * read):
            self.wait(BYTE_NS)
            assert self.slave.selected(self.now_ns)
            found.append(self.slave.exchange(byte, self.now_ns))
        self.wait(BYTE_NS)
        self.cs.set(True, self.now_ns)
        self.wait(BYTE_NS)
        assert not self.slave.selected(self.now_ns)
        return bytes(found[len(command) :])

    def nibbles(self, bus, *words):
        """Send words of four bits over a bus between two edges of chip select; return what came back."""
        self.wait(BYTE_NS)
        self.cs.set(False, self.now_ns)
        found = []
        for word in words:
            self.wait(BYTE_NS)
            found.append(bus.exchange(word, 4, 0, self.now_ns))
        self.wait(BYTE_NS)
        self.cs.set(True, self.now_ns)
        return found

    def status(self):
        return self.transfer(STATUS, read=1)[0]

    def write(self, *command):
        self.transfer(WREN)
        self.transfer(*command)

    def ready(self):
        while self.status() & 1:
            self.wait(MS)

    def read(self, address, count):
        return self.transfer(READ, *address.to_bytes(3, "big"), read=count)

    def told(self, kind):
        return [event for _, event in self.bench.events if isinstance(event, kind)]


@pytest.fixture
def rig():
    return Rig()


@each(("megabits", "identity"), [(32, "ef4016"), (64, "ef4017"), (128, "ef4018")])
def test_who_it_is(megabits, identity):
    rig = Rig(megabits=megabits)
    assert rig.transfer(0x9F, read=3).hex() == identity
    device = int(identity[-2:], 16) - 1
    assert rig.transfer(0x90, 0, 0, 0, read=2) == bytes((0xEF, device))
    assert rig.transfer(0x90, 0, 0, 1, read=2) == bytes((device, 0xEF))
    assert rig.transfer(0xAB, 0, 0, 0, read=1) == bytes((device,))
    assert len(rig.transfer(0x4B, 0, 0, 0, 0, read=8)) == 8
    assert len(rig.flash.array.data) == megabits * 131_072


def test_erased_it_reads_ones_to_its_end_and_goes_on_at_its_beginning(rig):
    rig.flash.array.data[:2] = b"\x12\x34"
    assert rig.read(0x7FFFFE, 4) == b"\xff\xff\x12\x34"
    assert rig.transfer(0x0B, 0, 0, 0, 0, read=2) == b"\x12\x34"


def test_programming_clears_bits_and_takes_its_time(rig):
    rig.write(PROGRAM, 0, 0x10, 0, 0xF0, 0x55)
    begin_ns = rig.now_ns
    assert rig.status() == 1  # busy, and WEL has fallen
    rig.ready()
    assert rig.now_ns - begin_ns >= 399_000
    assert rig.read(0x1000, 3) == b"\xf0\x55\xff"
    rig.write(PROGRAM, 0, 0x10, 0, 0x3C)
    rig.ready()
    assert rig.read(0x1000, 1) == b"\x30"
    assert rig.told(FlashChanged)[0] == FlashChanged(what="program", address=0x1000, size=2, at_ns=begin_ns - BYTE_NS)


def test_a_page_wraps_and_its_last_256_bytes_count(rig):
    rig.write(PROGRAM, 0, 0, 0xFE, 1, 2, 3)
    rig.ready()
    assert rig.read(0, 1) + rig.read(0xFE, 2) == b"\x03\x01\x02"
    rig.write(PROGRAM, 0, 1, 0, *range(256), 0xAA, 0xBB)
    rig.ready()
    assert rig.read(0x100, 3) == b"\xaa\xbb\x02"


@pytest.mark.parametrize(("code", "size"), [(0x20, 4096), (0x52, 32_768), (0xD8, 65_536)])
def test_erasing(rig, code, size):
    data = rig.flash.array.data
    data[:] = bytes(len(data))
    address = 3 * size + 17
    rig.write(code, *address.to_bytes(3, "big"))
    rig.ready()
    assert data[3 * size : 4 * size] == b"\xff" * size
    assert data[3 * size - 1] == data[4 * size] == 0


@each("code", [0xC7, 0x60])
def test_erasing_all_takes_its_seconds(code):
    rig = Rig(megabits=32, chip_erase_s=10.0)
    rig.flash.array.data[:] = bytes(len(rig.flash.array.data))
    rig.write(code)
    rig.wait(9_999 * MS)
    assert rig.status() & 1
    rig.wait(2 * MS)
    assert not rig.status() & 1
    assert not rig.flash.array.data.strip(b"\xff")


def test_without_wel_nothing_happens(rig):
    rig.transfer(PROGRAM, 0, 0, 0, 1)
    rig.write(0x04)
    rig.transfer(SECTOR, 0, 0, 0)
    assert not rig.status() & 1
    assert [event.command for event in rig.told(FlashIgnored)] == [PROGRAM, SECTOR]


def test_busy_it_hears_nothing_but_status(rig):
    rig.write(SECTOR, 0, 0, 0)
    assert rig.read(0, 2) == b"\xff\xff"
    rig.transfer(WREN)
    assert rig.status() == 1
    assert [event.why for event in rig.told(FlashIgnored)] == ["the flash is busy"] * 2


def test_what_ends_too_early_or_too_late_is_ignored(rig):
    for command in ((PROGRAM, 0, 0, 0), (SECTOR, 0, 0), (SECTOR, 0, 0, 0, 0), (0xC7, 0)):
        rig.write(*command)
        assert not rig.status() & 1
    assert len(rig.told(FlashIgnored)) == 4


@pytest.mark.parametrize(
    ("status", "address", "kept"),
    [
        (0x04, 0x7E0000, True), (0x04, 0x7DF000, False), (0x1C, 0, True), (0x24, 0x01F000, True),
        (0x24, 0x020000, False), (0x44, 0x7FF000, True), (0x44, 0x7FE000, False), (0x54, 0x7F8000, True),
        (0x54, 0x7F7000, False), (0x64, 0, True), (0x64, 0x1000, False),
    ],
)  # fmt: skip
def test_protected_places(rig, status, address, kept):
    """The data sheet's table of status register memory protection (CMP = 0)."""
    rig.write(0x01, status)
    rig.ready()
    assert rig.status() == status
    rig.write(PROGRAM, *address.to_bytes(3, "big"), 0)
    rig.ready()
    assert rig.read(address, 1) == (b"\xff" if kept else b"\x00")


def test_status_registers(rig):
    rig.write(0x31, 0xFF)
    rig.ready()
    assert rig.transfer(0x35, read=1) == b"\x43"
    rig.transfer(0x50)
    rig.transfer(0x01, 0x04)
    assert rig.status() == 0x04  # at once, and not for good
    rig.transfer(0x66)
    rig.transfer(0x99)
    rig.wait(MS)
    assert rig.status() == 0


def test_powered_down_it_answers_nothing_but_its_release(rig):
    rig.transfer(0xB9)
    assert rig.transfer(0x9F, read=3) == b"\xff\xff\xff"
    assert rig.transfer(0xAB, 0, 0, 0, read=1) == b"\x16"
    assert rig.transfer(0x9F, read=1) == b"\xef"


def test_what_is_not_modelled_is_said(rig):
    rig.transfer(0x5A, 0, 0, 0, 0, read=1)
    assert [event.why for event in rig.told(FlashIgnored)] == ["SFDP is not modelled"]


def test_chip_select_that_rises_long_before_anybody_looks_is_known_exactly(rig):
    rig.write(SECTOR, 0, 0, 0)
    rose_ns = rig.told(FlashChanged)[0].at_ns if rig.told(FlashChanged) else rig.now_ns - BYTE_NS
    rig.wait(3_000 * MS)
    assert rig.told(FlashChanged)[0].at_ns == rose_ns
    assert not rig.status() & 1


@given(
    writes=st.lists(st.tuples(st.integers(0, 0x1FF), st.binary(min_size=1, max_size=300)), max_size=6),
)
def test_programming_is_and_within_pages(writes):
    array, expected = Array(0x400), [0xFF] * 0x400
    for address, data in writes:
        array.program(address, data)
        page = address & ~0xFF
        for number in range(max(0, len(data) - 256), len(data)):
            expected[page + (address + number) % 256] &= data[number]
    assert array.data == bytes(expected)


@given(commands=st.lists(st.binary(min_size=1, max_size=12), max_size=20))
def test_no_bytes_break_it(commands):
    rig = Rig(megabits=32)
    for command in commands:
        rig.transfer(*command)
    assert 0 <= rig.status() <= 0xFF


def test_words_may_end_within_a_byte():
    """A byte that chip select cuts short is none, also if nobody looks meanwhile."""
    rig, bus = Rig(), SpiBus()
    bus.attach(rig.slave)
    assert rig.nibbles(bus, 0x9, 0xF, *(0,) * 6) == [0xF, 0xF, 0xE, 0xF, 0x4, 0x0, 0x1, 0x7]
    assert rig.nibbles(bus, 0x9) == [0xF]
    assert rig.nibbles(bus, 0x0, 0x5, 0, 0) == [0xF, 0xF, 0, 0]


class Ahead(Rig):
    """A master that takes what the flash promises, and tells it what it has sent later."""

    def __init__(self, **settings):
        super().__init__(**settings)
        self.promised, self.sent, self.sent_ns = b"", bytearray(), 0
        self.slave.broken = self.tell

    def tell(self):
        if self.sent:
            self.slave.take(bytes(self.sent), self.sent_ns)
        self.promised = b""
        self.sent.clear()

    def transfer(self, *command, read=0):
        self.wait(BYTE_NS)
        self.cs.set(False, self.now_ns)
        found = bytearray()
        for byte in (*command, *(0,) * read):
            self.wait(BYTE_NS)
            if self.promised:
                found.append(self.promised[0])
                self.promised = self.promised[1:]
                self.sent.append(byte)
                self.sent_ns = self.now_ns
                continue
            self.tell()
            assert self.slave.selected(self.now_ns)
            found.append(self.slave.exchange(byte, self.now_ns))
            self.promised = self.slave.promise(5) or b""
        self.wait(BYTE_NS)
        self.cs.set(True, self.now_ns)
        self.wait(BYTE_NS)
        assert not self.slave.selected(self.now_ns)
        assert self.slave.promise(5) == b""
        return bytes(found[len(command) :])


READING = st.tuples(st.sampled_from((READ, 0x0B)), st.just(0), st.integers(0, 1), st.integers(0, 255))
WRITING = st.tuples(st.just(PROGRAM), st.just(0), st.integers(0, 1), st.integers(0, 255), st.integers(0, 255))
ANY = st.lists(st.integers(0, 255), min_size=1, max_size=6).map(tuple)
OTHER = st.sampled_from(((WREN,), (SECTOR, 0, 0, 0), (STATUS,), (0x9F,), (0xB9,), (0xAB,), (0x90, 0, 0, 0)))


@given(commands=st.lists(st.tuples(READING | WRITING | OTHER | ANY, st.integers(0, 40)), max_size=15))
@settings(max_examples=examples(50))
def test_it_keeps_what_it_promises(commands):
    rigs = [Rig(megabits=32), Ahead(megabits=32)]
    for rig in rigs:
        rig.flash.array.data[-50:] = range(50)
    for command, more in (((READ, 0x3F, 0xFF, 0xE0), 60), *commands, ((READ, 0, 0, 0), 300)):
        answers = [rig.transfer(*command, read=more) for rig in rigs]
        assert answers[0] == answers[1], command
    assert [event for _, event in rigs[0].bench.events] == [event for _, event in rigs[1].bench.events]
