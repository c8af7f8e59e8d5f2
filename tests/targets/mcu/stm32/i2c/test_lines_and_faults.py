"""Registers, interrupt and DMA lines, PE, faults of the bus, timeouts (RM0410 sections 33.4.6, 33.4.12 to 33.7)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

START, STOP, RELOAD, AUTOEND = 1 << 13, 1 << 14, 1 << 24, 1 << 25
TXIE, RXIE, NACKIE, STOPIE, TCIE, ERRIE = 2, 4, 16, 32, 64, 128
TXDMAEN, RXDMAEN = 1 << 14, 1 << 15
BIT, BYTE, HOLD = 86, 774, 29
"""Clocks of the kernel, with the standard TIMINGR of the rig; `test_timing` has the formulas."""


class TestRegisters:
    def test_reset_values(self, rig):
        """RM0410 section 33.7.12, I2C register map."""
        rig.i2c.reset()
        names = ["CR1", "CR2", "OAR1", "OAR2", "TIMINGR", "TIMEOUTR", "ISR", "ICR", "PECR", "RXDR", "TXDR"]
        assert [rig.peek(name) for name in names] == [0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0]
        assert list(rig.i2c.registers) == [4 * number for number in range(11)]

    @pytest.mark.parametrize(
        ("name", "mask"),
        [
            ("CR1", 0x00FB_DFFE),
            ("OAR1", 0x87FF),
            ("OAR2", 0x87FE),
            ("TIMINGR", 0xF0FF_FFFF),
            ("TIMEOUTR", 0x8FFF_9FFF),
            ("TXDR", 0xFF),
            ("PECR", 0),
            ("RXDR", 0),
            ("ICR", 0),
        ],
    )
    def test_reserved_bits(self, rig, name, mask):
        rig.i2c.reset()
        rig.poke(name, 0xFFFF_FFFE | mask & 1)
        assert rig.peek(name) == mask

    def test_start_and_stop_cannot_be_set_without_pe(self, rig):
        rig.poke("CR1", 0)
        rig.poke("CR2", 0x07FF_FFFF)
        assert rig.peek("CR2") == 0x03FF_1FFF

    def test_start_is_not_cleared_by_writing_0(self, rig):
        rig.begin()
        rig.poke("CR2", 0)
        assert rig.peek("CR2") == START

    def test_slave_mode_is_said_to_be_missing(self, rig):
        rig.poke("OAR1", 0x8000 | 0x30)
        rig.poke("CR1", 1 << 19 | 1)
        assert rig.chip.noted("unmodelled") == ["I2C1_OAR1", "I2C1_CR1"]

    @pytest.mark.parametrize(
        ("name", "value", "noted"),
        [
            ("OAR1", 0x8000, False),  # as drivers of a master leave it
            ("OAR1", 0x8400, False),  # in 10-bit mode too
            ("OAR1", 0x0030, False),
            ("OAR1", 0x8030, True),
            ("OAR1", 0x8500, True),
            ("OAR2", 0x8000, False),
            ("OAR2", 0x0730, False),
            ("OAR2", 0x8030, True),
            ("OAR2", 0x8700, True),  # every address
        ],
    )
    def test_only_an_own_address_asks_for_the_slave_mode(self, rig, name, value, noted):
        rig.poke(name, 0)
        rig.poke(name, value)
        assert rig.peek(name) == value
        assert rig.chip.noted() == ([f"I2C1_{name}"] if noted else [])

    def test_timing_may_only_change_without_pe(self, rig):
        rig.poke("TIMINGR", 0x1234)
        rig.poke("CR1", 1 | 1 << 8)
        assert rig.chip.noted("misuse") == ["I2C1_TIMINGR", "I2C1_CR1.DNF"]

    def test_clearing_all_of_cr1_is_no_misuse(self, rig):
        rig.poke("CR1", 0)
        assert rig.chip.noted() == []


class TestInterrupts:
    @pytest.mark.parametrize(
        ("enable", "flag", "bring"),
        [
            (TXIE, "TXIS", lambda rig: rig.begin()),
            (RXIE, "RXNE", lambda rig: rig.begin(read=True)),
            (NACKIE, "NACKF", lambda rig: rig.begin(0x11)),
            (STOPIE, "STOPF", lambda rig: rig.begin(count=0, more=AUTOEND)),
            (TCIE, "TC", lambda rig: rig.begin(count=0)),
            (TCIE, "TCR", lambda rig: rig.begin(count=0, more=RELOAD)),
        ],
    )
    def test_of_events(self, rig, enable, flag, bring):
        everything = TXIE | RXIE | NACKIE | STOPIE | TCIE | ERRIE
        rig.enable(everything & ~enable)
        bring(rig)
        rig.until(flag)
        assert not rig.event.level
        rig.enable(enable)
        bring(rig)
        rig.until(flag)
        assert rig.event.level
        assert rig.event.rises == [rig.chip.time.now]
        assert not rig.error.changes
        rig.poke("CR1", 1)
        assert not rig.event.level

    @pytest.mark.parametrize(("error", "bit"), [("BERR", 8), ("ARLO", 9), ("OVR", 10)])
    def test_of_errors(self, rig, error, bit):
        rig.i2c.disturb(error)
        assert rig.flags() == {error}
        assert not rig.error.level
        rig.poke("CR1", 1 | ERRIE)
        assert rig.error.level
        assert not rig.event.level
        rig.poke("ICR", 1 << bit)
        assert rig.flags() == set()
        assert not rig.error.level


class TestDma:
    def test_requests_of_a_write(self, rig, memory):
        rig.enable(TXDMAEN)
        request, data = rig.chip.dma("I2C1_TX"), [0x10, 1, 2, 3]

        def serve():
            rig.poke("TXDR", data.pop(0))
            if request.level:  # the byte went to the shift register at once
                rig.chip.time.after(5, serve)

        request.on_set = lambda level: level and rig.chip.time.after(5, serve)
        rig.begin(count=4, more=AUTOEND)
        rig.until("STOPF")
        assert (data, memory.data[0x10:0x13]) == ([], b"\1\2\3")
        assert not request.level
        assert not rig.chip.dma("I2C1_RX").changes

    def test_a_controller_that_answers_at_once(self, rig, memory):
        rig.enable(TXDMAEN)
        data = [0x10, 1, 2, 3]
        request = rig.chip.dma("I2C1_TX")

        def serve(_level):
            while request.level:
                rig.poke("TXDR", data.pop(0))

        request.on_set = serve
        rig.begin(count=4, more=AUTOEND)
        rig.until("STOPF")
        assert (data, memory.data[0x10:0x13]) == ([], b"\1\2\3")

    def test_requests_of_a_read(self, rig):
        rig.enable(RXDMAEN)
        found = []
        rig.chip.dma("I2C1_RX").on_set = lambda level: level and found.append(rig.peek("RXDR"))
        rig.begin(count=4, read=True, more=AUTOEND)
        rig.until("STOPF")
        assert found == [0, 1, 2, 3]
        assert not rig.chip.dma("I2C1_TX").changes


class TestSoftwareReset:
    @given(clocks=st.integers(0, 4 * BYTE))
    def test_at_any_moment(self, make_rig, make_memory, clocks):
        memory = make_memory()
        rig = make_rig(memory)
        rig.enable(TXIE | TCIE | STOPIE)
        rig.begin(count=3)
        rig.poke("TXDR", 5)
        rig.clocks(clocks)
        rig.poke("CR1", rig.peek("CR1") & ~1)
        assert rig.flags() == set()
        assert not rig.peek("CR2") & (START | STOP)
        assert not rig.event.level
        assert not rig.told or not rig.told[0].complete
        rig.told.clear()
        rig.chip.advance(10**6)
        assert not rig.told
        rig.enable()
        rig.send(0x77, 0xAB)
        rig.until("STOPF")
        assert memory.data[0x77] == 0xAB
        assert [told.complete for told in rig.told] == [True]

    def test_of_the_chip(self, rig):
        rig.begin(count=3)
        rig.clocks(1000)
        rig.i2c.reset()
        assert rig.peek("ISR") == 1
        rig.chip.advance(10**6)
        assert [told.complete for told in rig.told] == [False]


class TestPins:
    @pytest.mark.parametrize("pin", ["SCL", "SDA"])
    def test_without_both_nothing_begins(self, rig, memory, pin):
        rig.chip.output(f"I2C1_{pin}").connected = False
        rig.begin()
        rig.chip.advance(10**6)
        assert rig.flags() == set()
        assert rig.peek("CR2") & START
        assert memory.calls == []
        assert rig.chip.noted("misuse") == ["I2C1_CR2.START"]

    @pytest.mark.parametrize("pin", ["SCL", "SDA"])
    def test_push_pull_hears_no_acknowledge(self, rig, pin):
        rig.chip.output(f"I2C1_{pin}").only_low = False
        rig.begin()
        rig.until("STOPF")
        assert rig.flags() == {"NACKF", "STOPF"}
        assert rig.chip.noted("misuse") == ["I2C1_SDA"]


class TestStuck:
    def test_a_bus_that_is_idle_looks_busy(self, rig):
        rig.bus.stick()
        assert rig.flags() == {"BUSY"}
        rig.begin(count=0)
        rig.chip.advance(10**6)
        assert rig.flags() == {"BUSY"}
        rig.bus.unstick()
        rig.until("TC")

    def test_busy_comes_back_after_pe(self, rig):
        rig.bus.stick()
        rig.enable()
        assert rig.flags() == {"BUSY"}

    @given(byte=st.integers(0, 255))
    def test_a_byte_with_ones_loses_arbitration_at_the_first_of_them(self, make_rig, make_memory, byte):
        rig = make_rig(make_memory())
        rig.enable()
        rig.begin(count=2)
        rig.until("TXIS")
        rig.bus.stick()
        rig.poke("TXDR", byte)
        if byte:
            assert rig.until("ARLO") == (8 - byte.bit_length()) * BIT + 55
            assert rig.flags() == {"ARLO", "BUSY"}
            rig.bus.unstick()
            assert rig.flags() == {"ARLO"}
        else:
            rig.clocks(BYTE)
            assert rig.flags() == {"BUSY", "TXIS"}

    def test_reading_gives_zeros_and_no_nack(self, rig):
        rig.begin(count=2, read=True)
        rig.clocks(HOLD + BYTE - 1)
        rig.bus.stick()
        rig.until("RXNE")
        assert rig.peek("RXDR") == 0
        rig.until("RXNE")
        assert rig.until("ARLO") == BIT

    def test_a_stop_cannot_be_made(self, rig):
        rig.begin(count=0)
        rig.until("TC")
        rig.bus.stick()
        rig.poke("CR2", STOP)
        rig.until("ARLO")
        assert rig.flags() == {"ARLO", "BUSY"}


class TestArbitrationLost:
    def test_ends_the_transfer(self, rig):
        rig.begin(count=3)
        rig.until("TXIS")
        rig.i2c.disturb("ARLO")
        assert rig.flags() == {"ARLO"}
        rig.chip.advance(10**6)
        assert rig.flags() == {"ARLO"}
        assert [told.complete for told in rig.told] == [False]
        rig.poke("ICR", 1 << 9)
        rig.send(1)
        rig.until("STOPF")

    def test_bus_error_does_not(self, rig, memory):
        rig.begin(count=1, more=AUTOEND)
        rig.until("TXIS")
        rig.i2c.disturb("BERR")
        rig.poke("TXDR", 0x12)
        rig.until("STOPF")
        assert rig.flags() == {"BERR", "STOPF"}
        assert memory.pointer == 0x12


class TestTimeout:
    LIMIT = 2048 * 4
    ENABLE = 1 << 15 | 3

    @pytest.fixture(autouse=True)
    def _enabled(self, rig):
        rig.poke("TIMEOUTR", self.ENABLE)

    @pytest.mark.parametrize(
        ("flag", "options"),
        [
            ("TXIS", {"count": 1}),
            ("TC", {"count": 0}),
            ("TCR", {"count": 0, "more": RELOAD}),
        ],
    )
    def test_software_that_does_not_answer(self, rig, flag, options):
        rig.begin(**options)
        rig.until(flag)
        assert rig.until("TIMEOUT") == self.LIMIT
        assert rig.until("STOPF") == BIT
        assert rig.flags() == {"TIMEOUT", "STOPF"}

    def test_rxdr_that_is_not_read(self, rig):
        rig.begin(count=2, read=True)
        rig.until("RXNE")
        assert rig.until("TIMEOUT") == BYTE + self.LIMIT
        rig.until("STOPF")

    def test_slave_that_does_not_let_go(self, rig):
        rig.bus.stretch_ns[0x50] = 200_000  # 10800 clocks
        rig.begin(count=1, read=True)
        rig.clocks(HOLD + BYTE)
        assert rig.until("TIMEOUT") == self.LIMIT
        assert rig.until("STOPF") == 10_800 - self.LIMIT + BIT

    def test_software_that_answers_in_time(self, rig):
        rig.begin(count=3)
        for byte in (1, 2, 3):
            rig.until("TXIS")
            rig.clocks(self.LIMIT - 1)
            rig.poke("TXDR", byte)
        rig.until("TC")
        rig.clocks(self.LIMIT - 1)
        rig.poke("CR2", STOP)
        rig.until("STOPF")
        rig.chip.advance(10**6)
        assert rig.flags() == {"STOPF"}
