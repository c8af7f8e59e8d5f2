"""SPI that moves packets, by the manual (RM0433 section 50): words, transfers, packets, SS, CRC, lines, a slave."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.stm32.spi_crc import crc_of
from tests.each import each
from tests.targets.mcu.stm32.spi.packet_rig import (
    CSTART,
    CSUSP,
    FULL,
    HALF,
    MASTER,
    RECEIVE,
    RXDR,
    SPE,
    SSI,
    SSM,
    TRANSMIT,
    TXDR,
)  # fmt: skip

MASRX, HDDIR, CRC33_17, RCRCINI, TCRCINI, IOLOCK = (1 << bit for bit in (8, 11, 13, 14, 15, 16))
RXDMAEN, TXDMAEN, CRCEN = 1 << 14, 1 << 15, 1 << 22
LSBFRST, CPHA, CPOL, SSIOP, SSOE, SSOM, AFCNTR = (1 << bit for bit in (23, 24, 25, 28, 29, 30, 31))
RXPIE, TXPIE, DXPIE, EOTIE, TXTFIE = (1 << bit for bit in range(5))


def bits_of(words, bits):
    return "".join(f"{word:0{bits}b}" for word in words)


class TestWords:
    def test_after_reset(self, packets):
        """RM0433 section 50.11."""
        assert packets.peek("SR") == 0x1002
        assert packets.peek("CFG1") == 0x7_0007
        assert packets.peek("CRCPOLY") == 0x107

    def test_a_transfer_of_one_byte(self, packets):
        slave = packets.slave(0x5A)
        packets.master(size=1)
        assert packets.flags() == {"TXP"}
        packets.write(0xA7)
        assert packets.flags() == {"TXP", "TXTF"}
        packets.clocks(7)
        assert packets.flags() == {"TXP", "TXTF"}
        assert packets.left == 1
        packets.clocks(1)
        assert packets.flags() == {"TXP", "RXP", "DXP", "EOT", "TXTF", "TXC"}
        assert packets.left == 0
        assert not packets.peek("CR1") & CSTART
        assert packets.read() == 0x5A
        assert slave.bytes == b"\xa7"
        packets.poke("IFCR", 0x18)
        assert packets.flags() == {"TXP"}

    @given(bits=st.integers(4, 32), mbr=st.integers(0, 7), kernel=st.fractions(1, 40))
    def test_how_long_it_takes(self, make_packets, bits, mbr, kernel):
        """Its own clock divided by 2 to 256, which need not know of that of the CPU."""
        packets = make_packets()
        packets.chip.clocks.kernels["SPI1"] = kernel
        packets.master(bits=bits, mbr=mbr, size=1)
        packets.write(1, 4)
        cycles = -(-(kernel * bits * (2 << mbr)) // 1)
        packets.chip.advance(cycles - 1)
        assert "EOT" not in packets.flags()
        packets.chip.advance(1)
        assert "EOT" in packets.flags()

    @given(data=st.data(), bits=st.integers(4, 32), lsb_first=st.booleans())
    def test_words_of_any_length_are_bits_of_the_slave(self, make_packets, data, bits, lsb_first):
        packets = make_packets()
        words = data.draw(st.lists(st.integers(0, 2**32 - 1), min_size=1, max_size=6))
        answers = data.draw(st.lists(st.integers(0, 255), min_size=24, max_size=24))
        slave = packets.slave(*answers)
        packets.master(bits=bits, cfg2=LSBFRST if lsb_first else 0)
        size, found = 1 if bits <= 8 else 2 if bits <= 16 else 4, []
        for word in words:
            packets.write(word & (1 << 8 * size) - 1, size)
            packets.clocks(bits)
            found.append(packets.read(size))
        way = -1 if lsb_first else 1
        out = "".join(f"{word & (1 << bits) - 1:0{bits}b}"[::way] for word in words)
        assert bits_of(slave.bytes, 8) == out[: len(out) // 8 * 8]
        came = bits_of(answers, 8)
        assert found == [int(came[bits * at : bits * (at + 1)][::way], 2) for at in range(len(words))]

    @each("way", ["OVRC", "SPE"])
    def test_what_comes_after_an_overrun_is_lost_until_it_is_cleared(self, make_packets, way):
        """By its flag, or by SPE: drivers that only send clear nothing else, and receive in the next transfer."""
        packets = make_packets()
        slave = packets.slave(*range(30))
        packets.master(cfg2=RECEIVE)
        packets.clocks(17 * 8)
        assert "OVR" in packets.flags()
        for expected in range(16):
            assert packets.read() == expected
        packets.clocks(8)
        assert "RXP" not in packets.flags()
        if way == "OVRC":
            packets.poke("IFCR", 1 << 6)
            assert "OVR" not in packets.flags()
        else:
            packets.poke("CR1", SSI)
            packets.poke("CR1", SSI | SPE)
            packets.start()
        packets.clocks(8)
        assert packets.read() == len(slave.taken) - 1

    def test_nothing_starts_without_spe(self, packets):
        packets.master(start=False)
        packets.poke("CR1", SSI | CSTART)
        assert packets.peek("CR1") == SSI
        assert packets.chip.noted("misuse") == ["SPI1_CR1.CSTART"]

    def test_one_write_switches_on_and_starts(self, packets):
        slave = packets.slave()
        packets.master(start=False)
        packets.poke("CR1", SSI)
        packets.poke("CR1", SSI | SPE | CSTART)
        packets.write(7)
        packets.clocks(8)
        assert slave.bytes == b"\x07"

    def test_its_clock_may_stand_still(self, packets):
        packets.chip.clocks.kernels["SPI1"] = Fraction(0)
        packets.master(size=1)
        packets.write(1)
        packets.clocks(100)
        assert "EOT" not in packets.flags()
        assert packets.chip.noted("misuse") == ["SPI1_CR1.CSTART"]
        packets.chip.clocks.kernels["SPI1"] = Fraction(2)
        packets.chip.change_clock()
        packets.chip.advance(8 * 2 * 2)
        assert "EOT" in packets.flags()


class TestTransfers:
    """Sections 50.4.10 to 50.4.12."""

    def test_nothing_goes_before_cstart(self, packets):
        slave = packets.slave()
        packets.master(size=2, start=False)
        packets.write(1)
        packets.write(2)
        packets.clocks(50)
        assert packets.flags() == {"TXP", "TXTF"}
        assert not slave.taken
        packets.start()
        packets.clocks(16)
        assert slave.bytes == b"\x01\x02"

    def test_without_a_size_it_waits_for_more(self, packets):
        packets.master(cfg2=TRANSMIT)
        assert packets.flags() == {"TXP", "TXC"}
        packets.write(1)
        assert packets.flags() == {"TXP"}
        packets.clocks(8)
        assert packets.flags() == {"TXP", "TXC"}
        assert packets.peek("CR1") & CSTART

    def test_more_than_its_size_is_not_sent(self, packets):
        slave = packets.slave()
        packets.master(size=2, cfg2=TRANSMIT)
        packets.write(0x0403_0201, 4)
        packets.clocks(50)
        assert slave.bytes == b"\x01\x02"
        packets.poke("CR1", SSI)
        packets.poke("CR1", SSI | SPE)
        assert packets.left == 2
        packets.start()
        packets.clocks(50)
        assert len(slave.taken) == 2, "what was left has gone with SPE"

    def test_receiving_only_needs_nothing_to_send(self, packets):
        packets.slave(1, 2, 3, 4)
        packets.master(size=3, cfg2=RECEIVE)
        packets.clocks(24)
        assert "EOT" in packets.flags()
        assert [packets.read() for _ in range(3)] == [1, 2, 3]
        packets.clocks(50)
        assert "RXP" not in packets.flags()

    def test_one_wire_out_and_in(self, packets):
        slave = packets.slave(0x77, 0x66)
        packets.master(size=1, cfg2=HALF, cr1=HDDIR)
        packets.write(0x12)
        packets.clocks(8)
        assert packets.flags() == {"TXP", "TXTF", "EOT", "TXC"}
        packets.master(size=1, cfg2=HALF)
        packets.clocks(8)
        assert packets.read() == 0x66
        assert slave.bytes[0] == 0x12

    def test_it_is_extended_by_tser(self, packets):
        slave = packets.slave()
        packets.master(size=1, cfg2=TRANSMIT)
        packets.poke("CR2", 2 << 16)
        packets.poke("CR2", 9 << 16)  # not while there is something
        packets.write(0x0302_0100 >> 8, 2)
        packets.write(3)
        assert "TXTF" in packets.flags()
        packets.clocks(8)
        assert packets.flags() == {"TXP", "TXTF", "TSERF"}
        assert packets.left == 2
        assert packets.peek("CR2") == 1
        packets.clocks(16)
        assert slave.bytes == b"\x01\x02\x03"
        assert "EOT" in packets.flags()

    def test_it_is_suspended(self, packets):
        """CSUSP: at the end of the word; SUSP says so."""
        packets.slave(1, 2, 3, 4, 5)
        packets.master(cfg2=RECEIVE)
        packets.clocks(4)
        packets.poke("CR1", packets.peek("CR1") | CSUSP)
        assert "SUSP" not in packets.flags()
        assert not packets.peek("CR1") & CSUSP
        packets.clocks(4)
        assert "SUSP" in packets.flags()
        assert not packets.peek("CR1") & CSTART
        packets.clocks(50)
        assert packets.read() == 1
        assert "RXP" not in packets.flags()

    @pytest.mark.parametrize("masrx", [0, MASRX])
    def test_a_master_may_wait_for_room(self, packets, masrx):
        packets.slave(*range(1, 30))
        packets.master(size=20, cfg2=RECEIVE, cr1=masrx)
        packets.clocks(200)
        assert (
            ("SUSP" in packets.flags())
            is ("EOT" not in packets.flags())
            is ("OVR" not in packets.flags())
            is bool(masrx)
        )
        assert [packets.read() for _ in range(16)] == list(range(1, 17))
        packets.poke("IFCR", 0x800 | 0x40)
        packets.clocks(32)
        assert [packets.read() for _ in range(4)] == ([17, 18, 19, 20] if masrx else [0] * 4)
        assert "EOT" in packets.flags()

    def test_settings_are_locked(self, packets):
        packets.master()
        before = {name: packets.peek(name) for name in ("CFG1", "CFG2", "CRCPOLY", "UDRDR", "CR2")}
        for name, value in before.items():
            packets.poke(name, value)
        assert not packets.chip.notes.all
        for name, value in before.items():
            packets.poke(name, value ^ 1)
        assert {name: packets.peek(name) for name in before} == before
        assert packets.chip.noted("misuse") == [f"SPI1_{name}" for name in (*list(before)[:4], "CR2.TSIZE")]

    def test_iolock(self, packets):
        packets.poke("CR1", IOLOCK)
        packets.poke("CFG2", MASTER)
        assert packets.peek("CFG2") == 0
        packets.poke("CR1", IOLOCK | SPE)
        packets.poke("CR1", IOLOCK)
        assert packets.peek("CR1") == 0, "it falls with SPE"


class TestPackets:
    """Sections 50.4.11 and 50.4.13."""

    @each(
        ("bits", "packet", "wide"),
        [(8, 1, True), (8, 8, True), (16, 4, True), (32, 2, True), (8, 4, False), (9, 2, False)],
    )
    def test_flags_are_of_whole_packets(self, make_packets, bits, packet, wide):
        packets = make_packets(wide=wide)
        packets.slave(*range(1, 100))
        width = (bits + 7) // 8
        room = (16 if wide else 8) // width
        packets.master(bits=bits, packet=packet, start=False)
        for count in range(room):
            assert ("TXP" in packets.flags()) is (room - count >= packet)
            packets.write(count, width)
        packets.write(0, width)
        assert packets.chip.noted("misuse") == ["SPI1_TXDR"]
        packets.start()
        for count in range(room):
            assert ("RXP" in packets.flags()) is (count >= packet)
            level = packets.peek("SR") >> 13 & 7
            assert level == (4 if count * width >= 4 else 0) | (count * width % 4 // width if width <= 2 else 0)
            packets.clocks(bits)
        assert "DXP" in packets.flags()

    @given(
        bits=st.sampled_from([5, 8, 12, 16, 20, 32]),
        packet=st.integers(1, 4),
        total=st.integers(1, 12),
        accesses=st.lists(st.sampled_from([1, 2, 4]), min_size=1, max_size=5),
    )
    def test_a_transfer_as_the_manual_has_it(self, make_packets, bits, packet, total, accesses):
        """By TXP and RXP until EOT, and then by RXPLVL and RXWNE, with accesses of any width that holds a word."""
        packets = make_packets()
        width = 1 if bits <= 8 else 2 if bits <= 16 else 4
        packet = min(packet, 8 // width)
        slave = packets.slave(*range(1, 100))
        packets.master(bits=bits, packet=packet, size=total)
        accesses = [size for size in accesses if size >= width] or [width]
        words, sent, found = list(range(10, 10 + total)), 0, []
        for turn in range(2 * total * bits):
            flags = packets.flags()
            if "EOT" in flags:
                break
            if "TXP" in flags and sent < total:
                for word in words[sent : sent + packet]:
                    packets.write(word, width)
                sent += packet
            if "RXP" in flags:
                size = accesses[turn % len(accesses)]
                count = size // width
                if count <= packet:
                    value = packets.read(size)
                    found += [value >> 8 * width * at & (1 << 8 * width) - 1 for at in range(count)]
                else:
                    found.append(packets.read(width))
            packets.clocks(1)
        unseen = 16 < bits <= 24  # neither RXWNE nor RXPLVL tells of a single word then
        while packets.peek("SR") & 0xE000 or "RXP" in packets.flags() or (unseen and len(found) < total):
            found.append(packets.read(width))
        came = bits_of(range(1, 100), 8)
        assert found == [int(came[bits * at : bits * (at + 1)], 2) for at in range(total)]
        out = bits_of([word & (1 << bits) - 1 for word in words], bits)
        assert bits_of(slave.bytes, 8) == out[: len(out) // 8 * 8]
        assert not packets.chip.notes.all

    @each("offset", [TXDR, RXDR])
    def test_no_access_is_narrower_than_a_word(self, make_packets, offset):
        packets = make_packets()
        packets.master(bits=17)
        (packets.write if offset == TXDR else packets.read)(*((1, 2) if offset == TXDR else (2,)))
        assert packets.chip.noted("misuse") == ["SPI1_TXDR" if offset == TXDR else "SPI1_RXDR"]

    def test_what_is_written_without_spe_is_lost(self, packets):
        packets.write(1)
        assert packets.chip.noted("misuse") == ["SPI1_TXDR"]
        packets.master(packet=16)
        assert packets.chip.noted("misuse") == ["SPI1_TXDR", "SPI1_CFG1.FTHLV"]


class TestSlaveSelect:
    """Section 50.4.7."""

    def edges(self, packets, begin):
        return [(cycle - begin, level) for cycle, level in packets.chip.output("SPI1_NSS").edges if cycle > begin]

    def test_active_from_start_to_end(self, packets):
        packets.chip.clocks.kernels["SPI1"] = Fraction(1)
        packets.master(size=1, cfg2=SSOE)
        packets.poke("CR1", 0)
        packets.poke("CFG2", MASTER | SSOE)
        packets.poke("CR1", SPE)
        nss = packets.chip.output("SPI1_NSS")
        assert nss.level is True
        packets.start()
        assert nss.level is False
        packets.write(1)
        packets.chip.advance(15)
        assert nss.level is False
        packets.chip.advance(1)
        assert nss.level is True
        packets.poke("CR1", 0)
        assert nss.level is None

    @pytest.mark.parametrize("polarity", [0, SSIOP])
    def test_pauses_before_and_between_words(self, packets, polarity):
        """MSSI clocks after SS, MIDI between two words, where SSOM has SS inactive."""
        packets.slave(1, 2)
        packets.chip.clocks.kernels["SPI1"] = Fraction(1)
        packets.master(start=False)
        packets.poke("CR1", 0)
        packets.poke("CFG2", MASTER | SSOE | SSOM | 3 << 4 | 2 | polarity)
        packets.poke("CR2", 2)
        packets.poke("CR1", SPE)
        packets.write(0x0102, 2)
        packets.start()
        begin = packets.chip.time.now
        packets.chip.advance(100)
        on = bool(polarity)
        words = 2 * 2 + 16
        assert self.edges(packets, begin) == [(words, not on), (words + 6, on), (words + 6 + 16, not on)]
        assert packets.read(2) == 0x0201

    def test_pins_that_are_kept(self, packets):
        """AFCNTR: while SPE is 0, too."""
        packets.poke("CFG2", MASTER | SSM | AFCNTR | CPOL)
        assert packets.chip.output("SPI1_SCK").level is True
        packets.poke("CFG2", MASTER | SSM | CPOL)
        assert packets.chip.output("SPI1_SCK").level is None

    @pytest.mark.parametrize("by_pin", [False, True])
    def test_mode_fault(self, packets, by_pin):
        packets.poke("IER", 1 << 9)
        packets.poke("CFG2", MASTER | (0 if by_pin else SSM))
        packets.poke("CR1", SPE | SSI)
        assert "MODF" not in packets.flags()
        if by_pin:
            packets.chip.input("SPI1_NSS").drive(False)
        else:
            packets.poke("CR1", SPE)
        assert packets.irq.level
        assert not packets.peek("CR1") & SPE
        assert not packets.peek("CFG2") & MASTER
        packets.poke("CR1", SPE | SSI)
        assert not packets.peek("CR1") & SPE
        packets.poke("IFCR", 1 << 9)
        assert not packets.irq.level


class TestCrc:
    """Section 50.5.3."""

    @pytest.mark.parametrize("wrong", [0, 1])
    @pytest.mark.parametrize(
        ("bits", "polynomial", "size", "init"),
        [(8, 0x107, 8, 0), (8, 0x1_1021, 16, 0), (16, 0x1_1021, 16, RCRCINI | TCRCINI), (8, 0x104C1_1DB7 >> 4, 24, 0)],
    )
    def test_it_follows_the_transfer(self, packets, bits, polynomial, size, init, wrong):
        width, step = polynomial.bit_length() - 1, bits // 8
        mask = (1 << width) - 1
        words, answers = [0x31, 0x32], [0x57, 0x21]
        own = came = mask if init else 0
        for word, answer in zip(words, answers, strict=True):
            own = crc_of(own, word, polynomial & mask, bits, width)
            came = crc_of(came, answer, polynomial & mask, bits, width)
        shift = max(width - size, 0)
        data = b"".join(answer.to_bytes(step, "big") for answer in answers)
        slave = packets.slave(*data, *(came >> shift ^ wrong).to_bytes(size // 8, "big"))
        packets.poke("CRCPOLY", polynomial)
        packets.master(bits=bits, size=2, cfg1=CRCEN | (size - 1) << 16, cr1=init)
        for word in words:
            packets.write(word, step)
        packets.clocks(2 * bits)
        assert packets.peek("TXCRC") == own
        assert packets.peek("RXCRC") == came
        assert "EOT" not in packets.flags(), "it is extended over the CRC"
        packets.clocks(size)
        assert "EOT" in packets.flags()
        assert ("CRCE" in packets.flags()) is bool(wrong)
        assert slave.bytes.endswith((own >> shift).to_bytes(size // 8, "big"))
        assert [packets.read(step) for _ in range(2)] == answers
        assert "RXP" not in packets.flags(), "what came as CRC is not there"
        packets.poke("IFCR", 0x80)
        assert "CRCE" not in packets.flags()

    def test_polynomials_of_33_bits(self, packets):
        packets.slave()
        packets.poke("CRCPOLY", 0x04C1_1DB7)
        packets.master(bits=32, size=1, cfg1=CRCEN | 31 << 16, cr1=CRC33_17 | TCRCINI)
        packets.write(0x3132_3334, 4)
        packets.clocks(32)
        assert packets.peek("TXCRC") == crc_of(0xFFFF_FFFF, 0x3132_3334, 0x04C1_1DB7, 32)

    @each(("size", "wires", "where"), [(0, 8, "CFG1.CRCEN"), (2, 12, "CFG1.CRCSIZE")])
    def test_what_no_crc_can_come_of_is_noted(self, make_packets, size, wires, where):
        """It needs TSIZE, and goes as whole words."""
        packets = make_packets()
        packets.master(size=size, cfg1=CRCEN | (wires - 1) << 16)
        assert packets.chip.noted("misuse") == [f"SPI1_{where}"]


class TestLines:
    def test_interrupts(self, packets):
        packets.slave(1, 2)
        packets.poke("IER", TXPIE)
        assert not packets.irq.level, "SPE is 0"
        packets.master(size=2)
        assert packets.irq.level
        packets.poke("IER", TXPIE | DXPIE | EOTIE)
        packets.write(1)
        packets.write(2)
        assert packets.peek("IER") == EOTIE, "TXTF takes them back"
        assert not packets.irq.level
        packets.clocks(16)
        assert packets.irq.level
        packets.poke("IFCR", 0x18)
        assert not packets.irq.level
        packets.poke("IER", RXPIE)
        assert packets.irq.level
        packets.read(2)
        assert not packets.irq.level

    @each("packet", [1, 3, 4])
    def test_requests_are_of_whole_packets_and_the_rest(self, make_packets, packet):
        packets = make_packets()
        slave = packets.slave(*range(1, 11))
        sent, got = list(range(20, 30)), []
        tx, rx = packets.chip.dma("SPI1_TX"), packets.chip.dma("SPI1_RX")

        def serve():
            if tx.level and sent:
                packets.write(sent.pop(0))
            if rx.level:
                got.append(packets.read())
            packets.chip.time.after(3, serve)

        packets.master(size=10, packet=packet, cfg1=TXDMAEN | RXDMAEN)
        serve()
        packets.clocks(100)
        assert slave.bytes == bytes(range(20, 30))
        assert got == list(range(1, 11))
        assert not rx.level

    def test_dma_brings_the_words_of_a_transfer_while_txtf_is_that_of_the_last(self, packets):
        """A flag that nobody has cleared says nothing of the next transfer."""
        tx = packets.chip.dma("SPI1_TX")
        packets.master(size=1, cfg1=TXDMAEN)
        packets.write(1)
        packets.clocks(8)
        assert not tx.level
        packets.poke("IFCR", EOTIE)
        packets.poke("CR1", SSI)
        packets.poke("CR1", SSI | SPE)
        assert "TXTF" in packets.flags()
        assert tx.level

    def test_dma_is_asked_for_packets_while_eot_is_that_of_the_last_transfer(self, packets):
        rx = packets.chip.dma("SPI1_RX")
        packets.master(size=4, packet=4, cfg1=RXDMAEN, cfg2=RECEIVE)
        packets.clocks(32)
        packets.poke("CR1", SSI)
        packets.poke("CR1", SSI | SPE)
        packets.start()
        packets.clocks(8)
        assert "EOT" in packets.flags()
        assert not rx.level, "one word is no packet"
        packets.clocks(24)
        assert rx.level


class TestSlave:
    def slave(self, packets, *, cfg1=0, cfg2=FULL, size=0):
        packets.poke("CFG1", 0x7_0007 | cfg1)
        packets.poke("CFG2", cfg2 | SSM)
        packets.poke("CR2", size)
        packets.poke("UDRDR", 0xE5)
        packets.poke("CR1", SPE)

    def test_a_word_each_way_and_its_end(self, packets):
        self.slave(packets, size=1)
        packets.write(0xAB)
        assert packets.spi.exchange(0x12) == 0xAB
        assert packets.flags() == {"TXP", "RXP", "DXP", "EOT", "TXTF", "TXC"}
        assert packets.read() == 0x12

    @each(("instead", "mode", "expected"), [(0, FULL, 0xE5), (1, FULL, 0x12), (1, TRANSMIT, 0), (2, FULL, 0xAB)])
    def test_what_it_says_when_it_has_nothing_to_say(self, make_packets, instead, mode, expected):
        """UDRCFG: a constant, what came last, what was sent last."""
        packets = make_packets()
        self.slave(packets, cfg1=instead << 9, cfg2=mode)
        packets.write(0xAB)
        packets.spi.exchange(0x12)
        assert "UDR" not in packets.flags()
        assert packets.spi.exchange(0x34) == expected
        assert "UDR" in packets.flags()
        packets.poke("IFCR", 1 << 5)
        assert "UDR" not in packets.flags()

    def test_not_selected(self, packets):
        self.slave(packets)
        packets.poke("CR1", SPE | SSI)
        assert packets.spi.exchange(1) is None
        assert packets.chip.noted("unmodelled") == ["SPI1_CFG2.MASTER"]


def test_what_is_not_there_of_the_smaller_ones(make_packets):
    """RM0433 section 50.3: SPI4 to SPI6 have words of 16 bits at most, and no I2S."""
    packets = make_packets(wide=False)
    for name in ("CFG1", "CRCPOLY", "I2SCFGR"):
        packets.poke(name, 0xFFFF_FFFF)
    assert packets.peek("CFG1") & 0x1F == 0xF
    assert packets.peek("CRCPOLY") == 0xFFFF
    assert packets.peek("I2SCFGR") == 0


def test_what_is_not_modelled_says_so(packets):
    packets.poke("CFG1", 1 << 11)
    packets.poke("CFG2", 1 << 15)
    packets.poke("I2SCFGR", packets.peek("I2SCFGR") & ~1)
    assert packets.chip.noted("unmodelled") == ["SPI1_CFG1", "SPI1_CFG2"], "drivers of SPI clear I2SMOD"
    packets.poke("I2SCFGR", 1)
    assert packets.chip.noted("unmodelled") == ["SPI1_CFG1", "SPI1_CFG2", "SPI1_I2SCFGR"]


def test_other_registers_get_parts_repeated(packets):
    packets.spi.write_part(0x40, 2, 0x1021)
    assert packets.peek("CRCPOLY") == 0x1021_1021
    assert packets.spi.read_part(0x41, 1) == 0x10


any_access = st.tuples(
    st.sampled_from([*range(0, 0x1C, 4), TXDR, RXDR, *range(0x40, 0x54, 4)]),
    st.sampled_from([0, 1, 2, 4]),
    st.one_of(st.integers(0, 2**32 - 1), st.sampled_from([SPE, SPE | CSTART | SSI, MASTER | SSM, MASTER | SSM | SSOE])),
)


@given(accesses=st.lists(any_access, max_size=40), wide=st.booleans())
def test_nothing_a_program_writes_breaks_it(make_packets, accesses, wide):
    packets = make_packets(wide=wide)
    packets.slave(1, 2, 3)
    for offset, size, value in accesses:
        if not size:
            packets.chip.advance(value & 0x3FF)
            packets.spi.read(offset)
        elif size == 4:
            packets.spi.write(offset, value)
        else:
            packets.spi.write_part(offset, size, value & (1 << 8 * size) - 1)
            packets.spi.read_part(offset, size)
    packets.spi.reset()
    assert packets.peek("SR") == 0x1002
    packets.master(size=1)
    packets.write(1)
    packets.clocks(8)
    assert "EOT" in packets.flags()
