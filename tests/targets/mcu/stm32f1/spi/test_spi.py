"""SPI by the manual (RM0008 section 25): words, flags and how they are cleared, NSS, CRC, requests, a slave."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.services import Watch
from targets.mcu.stm32.spi_crc import crc_of
from tests.each import each
from tests.targets.mcu.stm32.spi.slave import Promising

CPHA, CPOL, MSTR, SPE, LSBFIRST, SSI, SSM, RXONLY, DFF, CRCNEXT, CRCEN, BIDIOE, BIDIMODE = (
    1 << bit for bit in (0, 1, 2, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)
)
RXDMAEN, TXDMAEN, SSOE, ERRIE, RXNEIE, TXEIE = (1 << bit for bit in (0, 1, 2, 5, 6, 7))
MASTER = MSTR | SPE | SSI | SSM


def reversed_byte(byte):
    return int(f"{byte:08b}"[::-1], 2)


class TestWords:
    def test_after_reset(self, rig):
        assert rig.flags() == {"TXE"}
        assert rig.peek("CRCPR") == 7

    def test_a_byte_each_way(self, rig):
        slave = rig.slave(0x5A)
        rig.master()
        rig.poke("DR", 0xA7)
        assert rig.flags() == {"TXE", "BSY"}
        rig.clocks(7)
        assert rig.flags() == {"TXE", "BSY"}
        rig.clocks(1)
        assert rig.flags() == {"TXE", "RXNE"}
        assert rig.peek("DR") == 0x5A
        assert rig.flags() == {"TXE"}
        assert slave.bytes == b"\xa7"

    @given(br=st.integers(0, 7), divider=st.sampled_from((1, 2, 4)), wide=st.booleans())
    def test_how_long_it_takes(self, make_rig, br, divider, wide):
        """RM0008 section 25.5.1: fPCLK divided by 2 to 256, and 8 or 16 clocks."""
        rig = make_rig(APB2=divider)
        rig.master(DFF if wide else 0, br=br)
        rig.poke("DR", 1)
        cycles = (16 if wide else 8) * divider * (2 << br)
        rig.chip.advance(cycles - 1)
        assert "BSY" in rig.flags()
        rig.chip.advance(1)
        assert rig.flags() == {"TXE", "RXNE"}

    def test_one_waits_while_another_goes_out(self, rig):
        slave = rig.slave(1, 2, 3)
        rig.master()
        rig.poke("DR", 0x11)
        rig.poke("DR", 0x22)
        assert rig.flags() == {"BSY"}
        rig.clocks(8)
        assert rig.flags() == {"BSY", "TXE", "RXNE"}
        assert rig.peek("DR") == 1
        rig.clocks(8)
        assert rig.peek("DR") == 2
        assert rig.flags() == {"TXE"}
        assert [ns for _, ns in slave.taken] == [222, 444]

    def test_sixteen_bits_are_two_bytes_of_a_slave(self, rig):
        slave = rig.slave(0x12, 0x34)
        rig.master(DFF)
        assert rig.transfer(0xABCD, bits=16) == [0x1234]
        assert slave.bytes == b"\xab\xcd"

    @given(
        words=st.lists(st.integers(0, 255), min_size=1, max_size=5), answers=st.lists(st.integers(0, 255), max_size=5)
    )
    def test_the_other_way_round(self, make_rig, words, answers):
        rig = make_rig()
        slave = rig.slave(*answers)
        rig.master(LSBFIRST)
        padded = (answers + [0xFF] * 5)[: len(words)]
        assert rig.transfer(*words) == [reversed_byte(answer) for answer in padded]
        assert slave.bytes == bytes(map(reversed_byte, words))

    @pytest.mark.parametrize("level", [False, True])
    def test_where_nobody_answers_is_what_stands_at_the_pin(self, rig, level):
        rig.chip.input("SPI1_MISO").drive(level)
        rig.slave(1).on = False
        rig.master()
        assert rig.transfer(0x55) == [0xFF if level else 0]

    def test_of_several_low_wins(self, rig):
        rig.slave(0xF0)
        rig.slave(0x3C)
        rig.master()
        assert rig.transfer(0) == [0x30]

    @pytest.mark.parametrize("mode", [0, 1, 2, 3])
    def test_a_slave_in_another_mode_sees_bits_late(self, rig, mode):
        slave = rig.slave(0x80, 0x01, modes=(0, 3))
        rig.master(mode)  # CPHA and CPOL are the two lowest bits
        found = rig.transfer(0x03, 0x40)
        right = mode in (0, 3)
        # CPOL is bit 1 and CPHA bit 0, as in the number of the mode
        assert slave.bytes == (b"\x03\x40" if right else b"\x81\xa0")
        assert found == ([0x80, 0x01] if right else [0xC0, 0x00])

    def test_written_before_spe_it_waits(self, rig):
        slave = rig.slave()
        rig.poke("CR1", MASTER & ~SPE)
        rig.poke("DR", 7)
        rig.clocks(20)
        assert rig.flags() == set()
        rig.poke("CR1", MASTER)
        assert rig.flags() == {"TXE", "BSY"}
        rig.clocks(8)
        assert slave.bytes == b"\x07"

    def test_a_word_under_way_ends_after_spe_was_cleared(self, rig):
        rig.slave(9)
        rig.master()
        rig.poke("DR", 7)
        rig.clocks(3)
        rig.poke("CR1", MASTER & ~SPE)
        rig.clocks(5)
        assert rig.peek("DR") == 9

    def test_a_reset_forgets_it(self, rig):
        rig.master()
        rig.poke("DR", 7)
        rig.spi.reset()
        rig.clocks(50)
        assert rig.flags() == {"TXE"}

    @pytest.mark.parametrize("watch", Watch)
    def test_the_next_word_after_a_reset_in_the_middle_of_one_is_whole(self, rig, watch):
        slave = rig.slave(0x11)
        rig.watch(watch)
        rig.master()
        rig.poke("DR", 0xAA)
        rig.clocks(3)
        rig.spi.reset()
        rig.master()
        rig.poke("DR", 0x55)
        rig.clocks(7)
        assert rig.flags() == {"TXE", "BSY"}
        rig.clocks(8)
        assert rig.peek("DR") == 0x11
        assert slave.bytes == b"\x55"

    @pytest.mark.parametrize("watch", Watch)
    def test_pins_are_driven_until_the_end_of_the_word_in_which_spe_falls(self, rig, watch):
        rig.watch(watch)
        rig.poke("CR2", SSOE)
        rig.poke("CR1", MSTR | SPE)
        rig.poke("DR", 0xAA)
        rig.clocks(3)
        rig.poke("CR1", MSTR)
        signals = [rig.chip.output(f"SPI1_{name}") for name in ("SCK", "MOSI", "NSS")]
        assert None not in [signal.level for signal in signals]
        rig.clocks(5)
        assert rig.flags() == {"TXE", "RXNE"}
        rig.clocks(20)
        assert [signal.level for signal in signals] == [None] * 3

    @pytest.mark.parametrize("watch", Watch)
    @pytest.mark.parametrize("by_fault", [False, True])
    def test_a_word_in_which_mstr_falls_is_broken_off(self, rig, watch, by_fault):
        slave = rig.slave()
        rig.watch(watch)
        rig.poke("CR1", MSTR | SPE)
        rig.poke("DR", 0xAA)
        rig.clocks(3)
        if by_fault:
            rig.chip.input("SPI1_NSS").drive(False)
        else:
            rig.poke("CR1", SPE)
        assert "BSY" not in rig.flags()
        rig.clocks(20)
        assert "RXNE" not in rig.flags()
        assert rig.chip.output("SPI1_SCK").level is None
        assert not slave.taken

    def test_receive_only_clocks_until_spe_falls(self, rig):
        """RM0008 section 25.3.5: from SPE on, word after word."""
        slave = rig.slave(1, 2, 3)
        rig.master(RXONLY)
        for expected in (1, 2):
            rig.clocks(8)
            assert rig.peek("DR") == expected
        rig.poke("CR1", (MASTER | RXONLY) & ~SPE)
        rig.clocks(100)
        assert rig.peek("DR") == 3
        assert len(slave.taken) == 3

    def test_one_wire_out_and_in(self, rig):
        slave = rig.slave(0x77)
        rig.master(BIDIMODE | BIDIOE)
        rig.poke("DR", 0x12)
        rig.clocks(8)
        assert rig.flags() == {"TXE"}
        assert slave.bytes == b"\x12"
        slave.answers[:] = [0x77]
        rig.poke("CR1", MASTER | BIDIMODE)
        rig.clocks(7)
        assert rig.flags() == {"TXE"}  # BSY stays low (RM0008 section 25.3.7)
        rig.clocks(1)
        rig.poke("CR1", (MASTER | BIDIMODE) & ~SPE)
        assert rig.peek("DR") == 0x77


class TestPromises:
    """A slave that knows what it answers is not asked for each word, and hears all the same."""

    @pytest.mark.parametrize("more", [0, DFF])
    def test_what_was_promised_is_answered_and_what_was_sent_is_told(self, rig, more):
        slave = rig.slave(*range(100), kind=Promising)
        rig.master(more)
        bits, words = (16, range(0x100, 0x128)) if more else (8, range(80))
        found = rig.transfer(*words, bits=bits)
        rig.spi.bus.settle()
        size = bits // 8
        assert b"".join(word.to_bytes(size, "big") for word in found) == bytes(range(80))
        assert slave.bytes == b"".join(word.to_bytes(size, "big") for word in words)
        assert slave.asked < 80 // 2

    def test_chip_select_ends_it(self, rig):
        slave = rig.slave(1, 2, 3, 4, 5, kind=Promising)
        rig.master()
        assert rig.transfer(0x11, 0x22) == [1, 2]
        slave.select(False)
        assert slave.bytes == b"\x11\x22"
        assert rig.transfer(0x33) == [0]
        slave.select(True)
        assert rig.transfer(0x44) == [3]

    def test_nor_is_it_asked_while_it_is_not_selected(self, rig, monkeypatch):
        slave, asked = rig.slave(kind=Promising), []
        slave.on = False
        monkeypatch.setattr(slave, "selected", lambda now_ns: asked.append(now_ns) or slave.on)
        rig.master()
        rig.chip.input("SPI1_MISO").drive(True)
        assert rig.transfer(*range(9)) == [0xFF] * 9
        assert len(asked) == 1

    def test_another_mode_ends_it(self, rig):
        slave = rig.slave(*[0x81] * 9, kind=Promising)
        rig.master()
        assert rig.transfer(1, 2) == [0x81] * 2
        rig.master(CPHA)
        assert rig.transfer(3, 4) == [0xC0, 0xC0]
        assert slave.bytes == b"\x01\x02\x81\x82"

    def test_who_is_soldered_meanwhile_is_asked(self, rig):
        rig.slave(*[0xF0] * 9, kind=Promising)
        rig.master()
        assert rig.transfer(1) == [0xF0]
        rig.slave(*[0x3C] * 9)
        assert rig.transfer(2) == [0x30]

    def test_times_are_those_of_the_clock_of_then(self, rig):
        slave = rig.slave(*range(9), kind=Promising)
        told = []
        slave.take = lambda data, now_ns: told.append((data, now_ns))
        rig.master()
        rig.transfer(1, 2, 3)
        rig.chip.change_clock(8_000_000)
        rig.chip.advance(1000)
        rig.spi.bus.settle()
        assert told == [(b"\x02\x03", 666)]


class TestErrors:
    def test_overrun(self, rig):
        """What is in DR stays; the flag ends with a read of DR and then of SR."""
        rig.slave(1, 2, 3)
        rig.master()
        rig.poke("CR2", ERRIE)
        for word in (5, 6):
            rig.poke("DR", word)
            rig.clocks(8)
        assert rig.flags() == {"TXE", "RXNE", "OVR"}
        assert rig.irq.level
        assert rig.peek("DR") == 1
        assert "OVR" in rig.flags()  # this very read ends it
        assert rig.flags() == {"TXE"}
        assert not rig.irq.level

    def test_a_read_of_sr_alone_ends_no_overrun(self, rig):
        rig.master()
        rig.transfer(4)  # DR was read, but before it
        for word in (5, 6):
            rig.poke("DR", word)
            rig.clocks(8)
        for _ in range(3):
            assert "OVR" in rig.flags()

    @pytest.mark.parametrize("by_pin", [False, True])
    def test_mode_fault(self, rig, by_pin):
        """RM0008 section 25.3.10: SPE and MSTR fall, and cannot be set before SR was read and CR1 written."""
        rig.poke("CR2", ERRIE)
        rig.poke("CR1", MSTR | SPE | (0 if by_pin else SSM | SSI))
        assert rig.flags() == {"TXE"}
        if by_pin:
            rig.chip.input("SPI1_NSS").drive(False)
        else:
            rig.poke("CR1", MSTR | SPE | SSM)
        assert rig.irq.level
        assert not rig.peek("CR1") & (SPE | MSTR)
        rig.poke("CR1", MASTER)
        assert not rig.peek("CR1") & (SPE | MSTR)
        assert rig.flags() == {"TXE", "MODF"}
        rig.poke("CR1", MASTER)
        assert rig.peek("CR1") & (SPE | MSTR) == SPE | MSTR
        assert rig.flags() == {"TXE"}
        assert not rig.irq.level

    def test_with_nss_as_an_output_there_is_none(self, rig):
        rig.chip.input("SPI1_NSS").drive(False)
        rig.poke("CR2", SSOE)
        rig.poke("CR1", MSTR | SPE)
        assert rig.flags() == {"TXE"}
        assert rig.chip.output("SPI1_NSS").level is False
        rig.poke("CR1", MSTR)
        assert rig.chip.output("SPI1_NSS").level is None

    def test_what_a_driver_does_wrong_is_noted(self, rig):
        rig.master()
        for word in (1, 2, 3):
            rig.poke("DR", word)
        assert rig.chip.noted("misuse") == ["SPI1_DR"]
        rig.poke("CR1", MASTER | DFF)
        assert rig.chip.noted("misuse") == ["SPI1_DR", "SPI1_CR1"]


def test_that_nobody_clocks_a_slave_is_noted(rig):
    rig.poke("CR1", SPE)
    rig.poke("CR1", SPE | SSM)
    assert rig.chip.noted("unmodelled") == ["SPI1_CR1.MSTR"]


class TestCrc:
    def test_vectors(self):
        """CRC-8 and CRC-16/XMODEM of "123456789", catalogue of parametrised CRC algorithms."""
        crc = 0
        for byte in b"123456789":
            crc = crc_of(crc, byte, 0x07, 8)
        assert crc == 0xF4
        crc = 0
        for high, low in zip(b"12345678"[::2], b"12345678"[1::2], strict=True):
            crc = crc_of(crc, high << 8 | low, 0x1021, 16)
        assert crc == 0x9015

    @pytest.mark.parametrize("wrong", [0, 1])
    def test_it_follows_the_last_word_and_is_compared(self, rig, wrong):
        answer = crc_of(crc_of(0, 0x20, 7, 8), 0x30, 7, 8)
        slave = rig.slave(0x20, 0x30, answer ^ wrong)
        rig.master(CRCEN)
        rig.poke("CR2", ERRIE)
        assert rig.transfer(0x12) == [0x20]
        rig.poke("DR", 0x34)
        rig.poke("CR1", MASTER | CRCEN | CRCNEXT)
        rig.clocks(8)
        assert rig.peek("DR") == 0x30
        assert rig.peek("RXCRCR") == answer
        rig.clocks(8)
        sent = crc_of(crc_of(0, 0x12, 7, 8), 0x34, 7, 8)
        assert slave.bytes == bytes((0x12, 0x34, sent))
        assert rig.peek("TXCRCR") == sent
        assert not rig.peek("CR1") & CRCNEXT
        assert ("CRCERR" in rig.flags()) is bool(wrong)
        assert rig.irq.level is bool(wrong)
        rig.poke("SR", 0)
        assert "CRCERR" not in rig.flags()

    def test_crcnext_too_late_is_noted(self, rig):
        """RM0008 section 25.3.6: as soon as the last word was written. Who waits for the CRC waits for ever."""
        rig.slave()
        rig.master(CRCEN)
        rig.poke("DR", 1)
        rig.poke("CR1", MASTER | CRCEN | CRCNEXT)
        rig.clocks(16)
        assert rig.chip.noted("misuse") == []
        rig.poke("CR1", MASTER | CRCEN)
        rig.poke("CR1", MASTER | CRCEN | CRCNEXT)
        rig.clocks(16)
        assert rig.chip.noted("misuse") == ["SPI1_CR1.CRCNEXT"]

    def test_it_waits_for_the_word_that_waits(self, rig):
        slave = rig.slave()
        rig.master(CRCEN)
        rig.poke("DR", 1)
        rig.poke("DR", 2)
        rig.poke("CR1", MASTER | CRCEN | CRCNEXT)
        rig.clocks(40)
        assert slave.bytes == bytes((1, 2, crc_of(crc_of(0, 1, 7, 8), 2, 7, 8)))

    def test_one_wire_out_has_none_to_compare(self, rig):
        rig.slave(1, 2, 3)
        rig.master(CRCEN | BIDIMODE | BIDIOE)
        rig.poke("DR", 1)
        rig.poke("CR1", MASTER | CRCEN | BIDIMODE | BIDIOE | CRCNEXT)
        rig.clocks(40)
        assert rig.flags() == {"TXE"}

    def test_one_wire_out_has_one_of_what_stands_there(self, rig):
        rig.chip.input("SPI1_MISO").drive(True)
        rig.master()
        rig.transfer(1, 2)
        rig.master(CRCEN | BIDIMODE | BIDIOE)
        rig.poke("DR", 0x55)
        rig.clocks(8)
        assert rig.peek("RXCRCR") == 0, "MOSI is low"

    def test_crcen_begins_anew(self, rig):
        rig.slave()
        rig.master(CRCEN)
        rig.transfer(0x55)
        assert rig.peek("TXCRCR")
        rig.poke("CR1", 0)
        assert (rig.peek("TXCRCR"), rig.peek("RXCRCR")) == (0, 0)

    @pytest.mark.parametrize("wrong", [0, 1])
    def test_after_the_last_word_of_dma_it_comes_by_itself(self, rig, wrong):
        """RM0008 section 25.3.7; what comes back last stays in DR, with RXNE."""
        answer = crc_of(crc_of(0, 0x20, 7, 8), 0x30, 7, 8)
        slave = rig.slave(0x20, 0x30, answer ^ wrong)
        rig.master(CRCEN)
        rig.tx_left = 2
        rig.poke("CR2", TXDMAEN | ERRIE)
        for word in (0x12, 0x34):
            rig.tx_left -= 1
            rig.poke("DR", word)
            rig.clocks(8)
            rig.peek("DR")
        rig.clocks(8)
        sent = crc_of(crc_of(0, 0x12, 7, 8), 0x34, 7, 8)
        assert slave.bytes == bytes((0x12, 0x34, sent))
        assert ("CRCERR" in rig.flags()) is bool(wrong)
        assert "RXNE" in rig.flags()
        assert rig.peek("DR") == answer ^ wrong
        rig.clocks(16)
        assert len(slave.bytes) == 3

    def test_a_ring_of_dma_has_no_last_word(self, rig):
        slave = rig.slave()
        rig.master(CRCEN)
        rig.tx_left = 8
        rig.poke("CR2", TXDMAEN)
        rig.poke("DR", 0x12)
        rig.clocks(32)
        assert slave.bytes == b"\x12"


class TestLines:
    def test_interrupts(self, rig):
        rig.slave(1)
        rig.master()
        rig.poke("CR2", TXEIE)
        assert rig.irq.level
        rig.poke("CR2", RXNEIE)
        assert not rig.irq.level
        rig.poke("DR", 5)
        rig.clocks(8)
        assert rig.irq.level
        rig.peek("DR")
        assert not rig.irq.level

    def test_requests(self, rig):
        rig.slave(1, 2, 3)
        sent, got = [0x11, 0x22, 0x33], []
        tx, rx = rig.chip.dma("SPI1_TX"), rig.chip.dma("SPI1_RX")

        def fill(level):
            if level and sent:
                rig.chip.time.after(5, lambda: sent and rig.poke("DR", sent.pop(0)))

        def drain(level):
            if level:
                rig.chip.time.after(5, lambda: got.append(rig.peek("DR")) if rx.level else None)

        tx.on_set, rx.on_set = fill, drain
        rig.master(br=2)
        rig.poke("CR2", TXDMAEN | RXDMAEN)
        rig.clocks(40, br=2)
        assert got == [1, 2, 3]

    @each("watch", [Watch.RECORD, Watch.LIVE])
    @each("mode", [0, 1, 2, 3])
    def test_what_the_pins_do(self, make_rig, watch, mode):
        """RM0008 figure 240: MOSI is steady at the edges at which a slave samples."""
        rig = make_rig()
        rig.watch(watch)
        rig.master(mode, br=1)
        sck, mosi = rig.chip.output("SPI1_SCK"), rig.chip.output("SPI1_MOSI")
        idle = bool(mode & 2)
        assert sck.level is idle
        begin = rig.chip.time.now
        rig.poke("DR", 0b1011_0010)
        rig.clocks(8, br=1)
        edges = [
            (cycle - begin, level) for cycle, level in sck.edges if cycle >= begin and (cycle, level) != (begin, idle)
        ]
        assert len(edges) == 16
        sampled = []
        for number, (cycle, _) in enumerate(edges):
            if number % 2 == mode % 2:
                before = [level for at, level in mosi.edges if at - begin < cycle]
                sampled.append(before[-1])
        assert sampled == [bit == "1" for bit in "10110010"]
        assert sck.level is idle

    def test_who_looks_at_the_cycle_of_an_edge_moves_none(self, rig):
        rig.watch(Watch.LIVE)
        rig.master(br=1)
        sck, begin = rig.chip.output("SPI1_SCK"), rig.chip.time.now
        rig.chip.time.at(begin + 2, sck.look)  # before the edge, which is entered later
        rig.poke("DR", 0xAA)
        rig.clocks(8, br=1)
        assert [cycle - begin for cycle, _ in sck.edges[-16:]] == list(range(2, 34, 2))

    def test_a_wire_back_is_read_bit_by_bit(self, rig):
        rig.watch(Watch.LIVE)
        miso, mosi = rig.chip.input("SPI1_MISO"), rig.chip.output("SPI1_MOSI")
        rig.master(br=1)
        tell = mosi.set

        def both(level):
            tell(level)
            miso.drive(bool(level))

        mosi.set = both
        rig.poke("DR", 0xA6)
        rig.clocks(8, br=1)
        assert rig.peek("DR") == 0xA6


class TestSlave:
    def test_it_answers_what_was_written(self, rig):
        rig.poke("CR1", SPE | SSM)
        rig.poke("DR", 0x42)
        assert rig.flags() == set()
        assert rig.spi.exchange(0x99) == 0x42
        assert rig.flags() == {"TXE", "RXNE"}
        assert rig.peek("DR") == 0x99

    def test_with_nothing_new_it_answers_what_has_come(self, rig):
        rig.poke("CR1", SPE | SSM)
        assert [rig.spi.exchange(word) for word in (0x12, 0x34)] == [0, 0x12]

    def test_by_the_pin(self, rig):
        rig.poke("CR1", SPE)
        assert rig.spi.exchange(1) is None
        rig.chip.input("SPI1_NSS").drive(False)
        assert rig.spi.exchange(1) is not None

    @pytest.mark.parametrize("cr1", [0, MASTER, SPE | SSM | SSI])
    def test_who_is_none_does_not_answer(self, rig, cr1):
        rig.poke("CR1", cr1)
        assert rig.spi.exchange(1) is None
        assert "RXNE" not in rig.flags()

    def test_overrun(self, rig):
        rig.poke("CR1", SPE | SSM)
        for word in (1, 2):
            rig.spi.exchange(word)
        assert "OVR" in rig.flags()


@pytest.mark.parametrize("has_i2s", [False, True])
def test_drivers_of_spi_clear_i2smod_without_a_word(make_rig, has_i2s):
    rig = make_rig(has_i2s=has_i2s)
    rig.poke("I2SCFGR", rig.peek("I2SCFGR") & ~(1 << 11))
    assert not rig.chip.noted()


def test_i2s_is_said_to_be_missing(make_rig):
    rig = make_rig(has_i2s=True)
    rig.poke("I2SCFGR", 1 << 11)
    assert rig.chip.noted("unmodelled") == ["SPI1_I2SCFGR"]
    assert rig.peek("I2SPR") == 2


@given(
    writes=st.lists(
        st.tuples(st.sampled_from(("CR1", "CR2", "SR", "DR", "CRCPR")), st.integers(0, 0xFFFF), st.integers(0, 99))
    )
)
def test_no_writes_break_it(make_rig, writes):
    rig = make_rig()
    rig.slave(*range(50))
    for register, value, clocks in writes:
        rig.poke(register, value)
        rig.clocks(clocks)
        rig.flags()
    rig.spi.reset()
    rig.clocks(9999)
    assert rig.flags() == {"TXE"}
