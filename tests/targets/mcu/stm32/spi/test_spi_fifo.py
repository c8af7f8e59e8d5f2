"""SPI with FIFOs by the manual (RM0410 section 35): word sizes, packing, levels, errors, NSS, CRC, lines, a slave."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.spi_bus import SpiBus
from targets.mcu.stm32.spi_crc import crc_of
from tests.each import each
from tests.targets.mcu.stm32.spi.slave import Slave

CPHA, MSTR, SPE, LSBFIRST, SSI, SSM, RXONLY, CRCL, CRCNEXT, CRCEN, BIDIOE, BIDIMODE = (
    1 << bit for bit in (0, 2, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)
)
RXDMAEN, TXDMAEN, SSOE, NSSP, FRF, ERRIE, RXNEIE, TXEIE, FRXTH, LDMA_RX, LDMA_TX = (
    1 << bit for bit in (0, 1, 2, 3, 4, 5, 6, 7, 12, 13, 14)
)
MASTER = MSTR | SPE | SSI | SSM


def bits_of(words, bits):
    return "".join(f"{word:0{bits}b}" for word in words)


class TestWords:
    def test_after_reset(self, rig):
        """RM0410 section 35.9."""
        assert rig.peek("SR") == 2
        assert rig.peek("CR2") == 0x700
        assert rig.peek("CRCPR") == 7
        assert rig.peek("I2SPR") == 2

    @each("length", [0, 1, 2])
    def test_lengths_that_are_not_used_are_eight_bits(self, make_rig, length):
        rig = make_rig()
        rig.poke("CR2", length << 8)
        assert rig.peek("CR2") == 0x700

    def test_a_byte_each_way(self, rig):
        slave = rig.slave(0x5A)
        rig.master()
        rig.write(0xA7)
        assert rig.flags() == {"TXE", "BSY"}
        rig.clocks(7)
        assert rig.flags() == {"TXE", "BSY"}
        rig.clocks(1)
        assert rig.flags() == {"TXE", "RXNE"}
        assert rig.read() == 0x5A
        assert rig.flags() == {"TXE"}
        assert slave.bytes == b"\xa7"

    @given(bits=st.integers(4, 16), br=st.integers(0, 7))
    def test_how_long_it_takes(self, make_rig, bits, br):
        rig = make_rig()
        rig.master(bits=bits, br=br)
        rig.write(1, 2 if bits > 8 else 1)
        rig.chip.advance(bits * 2 * (2 << br) - 1)
        assert "BSY" in rig.flags()
        rig.chip.advance(1)
        assert rig.flags() == {"TXE", "RXNE"}

    @given(data=st.data(), bits=st.integers(4, 16), lsb_first=st.booleans())
    def test_words_of_any_length_are_bits_of_the_slave(self, make_rig, data, bits, lsb_first):
        """What a slave sees are bytes, wherever the words end; unused bits of DR are ignored, and read 0."""
        rig = make_rig()
        words = data.draw(st.lists(st.integers(0, 0xFFFF), min_size=1, max_size=8))
        answers = data.draw(st.lists(st.integers(0, 255), min_size=17, max_size=17))
        slave = rig.slave(*answers)
        rig.master(LSBFIRST if lsb_first else 0, bits=bits)
        size, found = 1 if bits <= 8 else 2, []
        for word in words:
            rig.write(word & (1 << 8 * size) - 1, size)
            rig.clocks(bits)
            found.append(rig.read(size))
        turned = [f"{word & (1 << bits) - 1:0{bits}b}"[:: -1 if lsb_first else 1] for word in words]
        out = "".join(turned)
        assert bits_of(slave.bytes, 8) == out[: len(out) // 8 * 8]
        came = bits_of(answers, 8)
        expected = [came[bits * at : bits * (at + 1)][:: -1 if lsb_first else 1] for at in range(len(words))]
        assert found == [int(one, 2) for one in expected]

    @pytest.mark.parametrize("released", [False, True])
    def test_a_byte_that_was_begun_ends_with_chip_select(self, released):
        """Two words of 12 bits are three bytes, unless chip select rises in between."""
        bus, slave = SpiBus(), Slave()
        bus.attach(slave)
        bus.exchange(0xABC, 12, 0, 0)
        slave.releases += released
        bus.exchange(0xDEF, 12, 0, 0)
        assert slave.bytes == (b"\xab\xde" if released else b"\xab\xcd\xef")

    def test_a_word_that_gets_shorter_on_its_way(self, rig):
        rig.slave(0xAB, 0xCD)
        rig.master(bits=16)
        rig.write(0x1234, 2)
        rig.clocks(3)
        rig.poke("CR2", FRXTH | 7 << 8)
        rig.clocks(13)
        assert rig.read() == 0xCD
        assert rig.chip.noted("misuse") == ["SPI1_CR2.DS"]

    @each("missing", ["modes", "releases", "selected", "exchange", "answer"])
    def test_what_is_no_slave_is_told_so(self, missing):
        members = dict.fromkeys({"modes", "releases", "selected", "exchange", "answer"} - {missing})
        with pytest.raises(TypeError, match=f"^Odd is no SpiSlave: it has no {missing}$"):
            SpiBus().attach(type("Odd", (), members)())

    def test_receive_only_and_one_wire(self, rig):
        slave = rig.slave(1, 2, 3)
        rig.master(RXONLY)
        rig.clocks(17)
        rig.poke("CR1", (MASTER | RXONLY) & ~SPE)
        rig.clocks(100)
        assert [rig.read() for _ in range(3)] == [1, 2, 3]
        assert len(slave.taken) == 3
        slave.answers[:] = [9]
        rig.master(BIDIMODE | BIDIOE)
        rig.write(0x12)
        rig.clocks(8)
        assert rig.flags() == {"TXE"}
        assert slave.bytes[-1] == 0x12

    def test_what_waits_is_kept_without_spe_and_lost_with_a_reset(self, rig):
        slave = rig.slave()
        rig.master()
        rig.poke("CR1", MASTER & ~SPE)
        rig.write(7)
        rig.clocks(20)
        assert rig.levels() == (1, 0)
        rig.poke("CR1", MASTER)
        rig.clocks(8)
        assert slave.bytes == b"\x07"
        rig.write(8)
        rig.write(9)
        rig.spi.reset()
        rig.clocks(50)
        assert rig.peek("SR") == 2


class TestPacking:
    """RM0410 section 35.5.9 and its figure on packing data in the FIFOs."""

    def test_one_access_each_way_for_two_words(self, rig):
        slave = rig.slave(0x0A, 0x04)
        rig.master(cr2=0)
        rig.write(0x040A, 2)
        rig.clocks(8)
        assert rig.flags() == {"TXE", "BSY"}, "half of what is wanted"
        assert rig.levels() == (0, 1)
        rig.clocks(8)
        assert rig.flags() == {"TXE", "RXNE"}
        assert rig.read(2) == 0x040A
        assert slave.bytes == b"\x0a\x04", "the lower half first"

    def test_a_word_access_is_one_of_16_bits(self, rig):
        slave = rig.slave(0x11, 0x22)
        rig.master(cr2=0)
        rig.poke("DR", 0xAABB_0201)
        rig.clocks(16)
        assert slave.bytes == b"\x01\x02"
        assert rig.peek("DR") == 0x2211

    def test_the_last_of_an_odd_number_takes_the_other_threshold(self, rig):
        rig.slave(1, 2, 3)
        rig.master(cr2=0)
        rig.write(0x0201, 2)
        rig.write(3)
        rig.clocks(24)
        assert rig.read(2) == 0x0201
        assert rig.flags() == {"TXE"}
        assert rig.levels() == (0, 1)
        rig.poke("CR2", 0x700 | FRXTH)
        assert rig.flags() == {"TXE", "RXNE"}
        assert rig.read() == 3

    @each(("writes", "level", "txe"), [((1,), 1, True), ((2,), 2, True), ((2, 1), 3, False), ((2, 2), 3, False)])
    def test_levels_of_what_is_to_be_sent(self, make_rig, writes, level, txe):
        rig = make_rig()
        rig.poke("CR2", 0x700)
        for size in writes:
            rig.write(0, size)
        assert rig.levels() == (level, 0)
        assert ("TXE" in rig.flags()) is txe

    def test_what_finds_no_room_is_lost(self, rig):
        slave = rig.slave()
        rig.poke("CR2", 0x700 | FRXTH)
        for word in (1, 2, 3, 4):
            rig.write(word)
        assert rig.chip.noted("misuse") == ["SPI1_DR"]
        rig.poke("CR1", MASTER)
        rig.clocks(100)
        assert slave.bytes == b"\x01\x02\x03"

    def test_a_byte_is_no_word_of_more(self, rig):
        rig.master(bits=12)
        rig.write(1)
        assert rig.chip.noted("misuse") == ["SPI1_DR"]

    @given(
        bits=st.sampled_from([4, 8, 9, 16]),
        threshold=st.booleans(),
        steps=st.lists(st.sampled_from(["send", "send two", "read", "read two", "clock"]), max_size=40),
    )
    def test_any_order_of_accesses(self, make_rig, bits, threshold, steps):
        """Against lists: what goes in comes out in order, flags are the levels, and nothing is lost but by OVR."""
        rig = make_rig()
        slave = rig.slave(*range(1, 200))
        rig.master(bits=bits, cr2=FRXTH if threshold else 0)
        width = 1 if bits <= 8 else 2
        sending, arrived, number = [], [], 0
        overrun = under_way = False
        stream = bits_of(range(1, 200), 8)
        taken = 0

        def begin():
            nonlocal under_way
            if not under_way and sending:
                sending.pop(0)
                under_way = True

        for step in steps:
            if step.startswith("send"):
                count = 2 if step == "send two" and width == 1 else 1
                if len(sending) * width <= 2:
                    sending += [0] * count
                number += 1
                rig.write(number & 0xFF if width == count == 1 else number, width * count)
                begin()
            elif step.startswith("read"):
                count = 2 if step == "read two" and width == 1 else 1
                got = rig.read(width * count)
                expected, arrived = arrived[:count], arrived[count:]
                assert got == sum(word << 8 * at for at, word in enumerate(expected))
            else:
                rig.clocks(bits)
                if under_way:
                    under_way = False
                    word = int(stream[taken * bits : (taken + 1) * bits], 2)
                    taken += 1
                    if overrun or (len(arrived) + 1) * width > 4:
                        overrun = True
                    else:
                        arrived.append(word)
                begin()
            level = rig.spi.read(0x08)
            if overrun and step.startswith("read"):
                overrun = False  # DR and then SR were read
            assert bool(level & 2) is (len(sending) * width <= 2)
            assert bool(level & 1) is (len(arrived) * width >= (1 if threshold else 2))
            assert (level >> 11 & 3, level >> 9 & 3) == (min(len(sending) * width, 3), min(len(arrived) * width, 3))
            assert bool(level & 0x80) is under_way
        assert len(slave.bytes) == taken * bits // 8


class TestErrors:
    def test_overrun(self, rig):
        """Section 35.5.11: what is in the FIFO stays, what comes then is lost until DR and SR were read."""
        rig.slave(1, 2, 3, 4, 5, 6, 7)
        rig.master()
        rig.poke("CR2", 0x700 | FRXTH | ERRIE)
        for word in range(5):
            assert "OVR" not in rig.flags()
            rig.write(word)
            rig.clocks(8)
        assert rig.irq.level
        assert rig.levels() == (0, 3)
        assert [rig.read() for _ in range(2)] == [1, 2]
        rig.write(0)
        rig.clocks(8)  # lost, too
        assert "OVR" in rig.flags()
        assert rig.read() == 3
        assert "OVR" in rig.flags()  # this very read ends it
        assert not rig.irq.level
        rig.write(0)
        rig.clocks(8)
        assert [rig.read() for _ in range(2)] == [4, 7]

    def test_mode_fault(self, rig):
        rig.poke("CR2", 0x700 | ERRIE)
        rig.poke("CR1", MSTR | SPE)
        rig.chip.input("SPI1_NSS").drive(False)
        assert rig.irq.level
        assert rig.flags() == {"TXE", "MODF"}
        rig.poke("CR1", MASTER)
        assert rig.flags() == {"TXE"}
        assert rig.peek("CR1") & (SPE | MSTR) == SPE | MSTR

    def test_what_is_not_modelled_says_so(self, rig):
        rig.poke("I2SCFGR", rig.peek("I2SCFGR") & ~(1 << 11))
        assert not rig.chip.noted(), "drivers of SPI clear I2SMOD"
        rig.poke("I2SCFGR", 1 << 11)
        rig.poke("I2SCFGR", 0)
        rig.poke("CR1", SPE)
        assert rig.chip.noted("unmodelled") == ["SPI1_I2SCFGR", "SPI1_CR1.MSTR"]


class TestNss:
    def test_low_while_it_is_on(self, rig):
        rig.poke("CR2", 0x700 | SSOE)
        rig.poke("CR1", MSTR | SPE)
        nss = rig.chip.output("SPI1_NSS")
        assert nss.level is False
        rig.poke("CR1", MSTR)
        assert nss.level is None

    def test_a_pulse_between_words(self, rig):
        """Section 35.5.12: high for one clock at least between two words, if CPHA is 0."""
        rig.slave(1, 2)
        rig.poke("CR2", 0x700 | FRXTH | SSOE | NSSP)
        rig.poke("CR1", MSTR | SPE)
        nss = rig.chip.output("SPI1_NSS")
        assert nss.level is True
        begin = rig.chip.time.now
        rig.write(0x0102, 2)
        rig.clocks(8)
        assert "BSY" in rig.flags()
        rig.clocks(20)
        clock = 2 * 2
        assert [(cycle - begin, level) for cycle, level in nss.edges if cycle >= begin][-4:] == [
            (0, False), (8 * clock, True), (9 * clock, False), (17 * clock, True),
        ]  # fmt: skip
        assert [rig.read(), rig.read()] == [1, 2]
        assert "BSY" not in rig.flags()

    def test_no_pulse_with_the_other_phase(self, rig):
        rig.slave(1, 2, modes=(1,))
        rig.poke("CR2", 0x700 | FRXTH | SSOE | NSSP)
        rig.poke("CR1", MSTR | SPE | CPHA)
        rig.write(0x0102, 2)
        rig.clocks(16)
        assert rig.levels() == (0, 2)
        assert rig.chip.output("SPI1_NSS").level is False


class TestTiMode:
    """Section 35.5.13."""

    def test_a_pulse_of_nss_announces_each_word(self, rig):
        """CPOL, CPHA, LSBFIRST and what is said of NSS do not matter."""
        slave = rig.slave(0x12, 0x34, modes=(1,))
        rig.poke("CR2", 0x700 | FRXTH | FRF)
        rig.poke("CR1", MSTR | SPE | 1 << 1 | LSBFIRST)
        nss = rig.chip.output("SPI1_NSS")
        assert nss.level is False
        rig.chip.input("SPI1_NSS").drive(False)  # its own level, which is no mode fault
        assert rig.chip.output("SPI1_SCK").level is False
        begin = rig.chip.time.now
        rig.write(0x2301, 2)
        assert "BSY" in rig.flags()
        rig.clocks(18)
        clock = 2 * 2
        assert [(cycle - begin, level) for cycle, level in nss.edges][-4:] == [
            (0, True), (clock, False), (9 * clock, True), (10 * clock, False),
        ]  # fmt: skip
        assert slave.bytes == b"\x01\x23"
        assert [rig.read(), rig.read()] == [0x12, 0x34]
        assert rig.flags() == {"TXE"}

    def test_a_slave_flags_a_pulse_within_a_word(self, rig):
        rig.poke("CR2", 0x700 | FRXTH | FRF | ERRIE)
        rig.poke("CR1", SPE)
        rig.write(0x55)
        assert rig.spi.exchange(0x5, 3) is None
        assert rig.irq.level
        assert "FRE" in rig.flags()
        assert rig.flags() == {"TXE"}, "a read of SR clears it"
        assert not rig.irq.level
        assert rig.spi.exchange(0xA1, 8) == 0x55
        assert rig.read() == 0xA1

    def test_it_is_chosen_while_spe_is_0(self, rig):
        rig.master()
        rig.poke("CR2", 0x700 | FRXTH | FRF)
        assert rig.chip.noted("misuse") == ["SPI1_CR2.FRF"]


class TestCrc:
    """Section 35.5.14."""

    @pytest.mark.parametrize("wrong", [0, 1])
    @pytest.mark.parametrize(("bits", "wide"), [(8, False), (8, True), (16, True), (16, False)])
    def test_it_follows_the_last_word(self, rig, bits, wide, wrong):
        width, polynomial = (16, 0x1021) if wide else (8, 0x07)
        size = bits // 8
        words, answers = [0x12, 0x9A34 >> 16 - bits], [0x57, 0x21]
        own = came = 0
        for word, answer in zip(words, answers, strict=True):
            own, came = crc_of(own, word, polynomial, bits, width), crc_of(came, answer, polynomial, bits, width)
        crc_bytes = max(width // 8, size)
        slave = rig.slave(
            *b"".join(a.to_bytes(size, "big") for a in answers), *(came ^ wrong).to_bytes(crc_bytes, "big")
        )
        rig.poke("CRCPR", polynomial)
        rig.master(CRCEN | (CRCL if wide else 0), bits=bits)
        more = rig.peek("CR1")
        for number, word in enumerate(words):
            rig.write(word, size)
            if number:
                rig.poke("CR1", more | CRCNEXT)
            rig.clocks(bits)
            assert rig.read(size) == answers[number]
        assert rig.peek("TXCRCR") == own
        assert rig.peek("RXCRCR") == came
        for _ in range(crc_bytes // size):
            assert "CRCERR" not in rig.flags()
            rig.clocks(bits)
            rig.read(size)
        assert ("CRCERR" in rig.flags()) is bool(wrong)
        assert slave.bytes.endswith(own.to_bytes(crc_bytes, "big"))
        rig.poke("SR", 0)
        assert "CRCERR" not in rig.flags()
        rig.write(5, size)
        rig.clocks(bits)
        assert rig.peek("TXCRCR") == crc_of(0, 5, polynomial, bits, width), "a new block begins at 0"

    @given(word=st.integers(0, 0xFFFF), crc=st.integers(0, 0xFFFF), polynomial=st.integers(0, 0xFFFF))
    def test_sixteen_bits_are_two_bytes(self, word, crc, polynomial):
        by_bytes = crc_of(crc_of(crc, word >> 8, polynomial, 8, 16), word & 0xFF, polynomial, 8, 16)
        assert crc_of(crc, word, polynomial, 16) == by_bytes

    def test_known_vector(self):
        crc = 0
        for byte in b"123456789":
            crc = crc_of(crc, byte, 0x1021, 8, 16)
        assert crc == 0x31C3, "CRC-16/XMODEM"

    def test_other_lengths_have_none(self, rig):
        rig.master(CRCEN, bits=12)
        rig.write(1, 2)
        rig.clocks(12)
        assert rig.chip.noted("misuse") == ["SPI1_CR1.CRCEN"]

    def test_by_dma_it_follows_by_itself(self, rig):
        slave = rig.slave()
        rig.master(CRCEN, cr2=FRXTH | TXDMAEN)
        for left in (2, 1):
            rig.left["tx"] = left
            rig.write(0x11 * left)
        rig.left["tx"] = 0
        rig.clocks(50)
        assert slave.bytes == bytes((0x22, 0x11, crc_of(crc_of(0, 0x22, 7, 8), 0x11, 7, 8)))

    def test_receiving_only_the_word_under_way_is_it(self, rig):
        rig.slave(0x10, 0x20, crc_of(crc_of(0, 0x10, 7, 8), 0x20, 7, 8))
        rig.master(CRCEN | RXONLY, cr2=FRXTH | RXDMAEN)
        for left in (2, 1):
            rig.clocks(8)
            rig.left["rx"] = left
            rig.read()
        rig.clocks(8)
        assert "CRCERR" not in rig.flags()
        assert rig.peek("RXCRCR")


class TestLines:
    def test_interrupts(self, rig):
        rig.slave(1)
        rig.master()
        rig.poke("CR2", 0x700 | FRXTH | TXEIE)
        assert rig.irq.level
        rig.poke("CR2", 0x700 | FRXTH | RXNEIE)
        assert not rig.irq.level
        rig.write(5)
        rig.clocks(8)
        assert rig.irq.level
        rig.read()
        assert not rig.irq.level

    @pytest.mark.parametrize("last", [0, LDMA_TX])
    def test_the_last_access_of_dma_may_send_one_word(self, rig, last):
        slave = rig.slave()
        rig.master(cr2=TXDMAEN | last)
        for left, words in ((2, 0x0201), (1, 0x0403)):
            rig.left["tx"] = left
            rig.write(words, 2)
            rig.left["tx"] = left - 1
        rig.clocks(40)
        assert slave.bytes == (b"\x01\x02\x03" if last else b"\x01\x02\x03\x04")

    @pytest.mark.parametrize("last", [0, LDMA_RX])
    def test_the_last_access_of_dma_may_receive_one_word(self, rig, last):
        rig.slave(1, 2, 3)
        request = rig.chip.dma("SPI1_RX")
        rig.master(cr2=RXDMAEN | last)
        rig.write(0, 2)
        rig.write(0)
        rig.left["rx"] = 2
        rig.clocks(16)
        assert request.level
        rig.clocks(8)
        assert rig.read(2) == 0x0201
        rig.left["rx"] = 1  # counted after the access
        assert not request.level
        rig.chip.advance(1)
        assert request.level is bool(last)
        assert rig.read(2) == 3

    def test_ldma_is_locked(self, rig):
        rig.master()
        rig.poke("CR2", 0x700 | LDMA_RX)
        assert rig.chip.noted("misuse") == ["SPI1_CR2"]


class TestSlave:
    def test_a_word_each_way(self, rig):
        rig.poke("CR2", 0xF00)
        rig.poke("CR1", SPE)
        rig.chip.input("SPI1_NSS").drive(False)
        rig.write(0xABCD, 2)
        assert rig.spi.exchange(0x1234) == 0xABCD
        assert rig.read(2) == 0x1234
        assert rig.spi.exchange(0x5678) == 0xABCD, "once more what was sent last"

    def test_not_selected(self, rig):
        rig.poke("CR1", SPE)
        assert rig.spi.exchange(1) is None


def test_bytes_of_other_registers_are_repeated(rig):
    """As on any APB; what DR has is in the tests above."""
    rig.spi.write_part(0x10, 1, 0x21)
    assert rig.peek("CRCPR") == 0x2121
    assert rig.spi.read_part(0x11, 1) == 0x21
    rig.spi.write_part(0x10, 2, 0x1021)
    assert rig.spi.read_part(0x10, 2) == 0x1021


@given(
    accesses=st.lists(
        st.tuples(st.sampled_from(range(0, 0x24, 4)), st.sampled_from([0, 1, 2, 4]), st.integers(0, 0xFFFF)),
        max_size=30,
    )
)
def test_nothing_a_program_writes_breaks_it(make_rig, accesses):
    rig = make_rig()
    rig.slave(1, 2, 3)
    for offset, size, value in accesses:
        if not size:
            rig.clocks(value & 0x3F)
            rig.spi.read(offset)
        elif size == 4:
            rig.spi.write(offset, value)
        else:
            rig.spi.write_part(offset, size, value & (1 << 8 * size) - 1)
            rig.spi.read_part(offset, size)
    rig.spi.reset()
    assert rig.peek("SR") == 2
