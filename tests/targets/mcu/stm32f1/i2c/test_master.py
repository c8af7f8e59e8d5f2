"""I2C v1 as a master, in the order of events of RM0008 section 26.3.3; errors; lines; the bus."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from tests.each import each

PE, START, STOP, ACK, POS, SWRST = 1, 1 << 8, 1 << 9, 1 << 10, 1 << 11, 1 << 15
ITERREN, ITEVTEN, ITBUFEN, DMAEN, LAST = (1 << bit for bit in range(8, 13))
BIT = 720


class TestSending:
    def test_event_by_event(self, rig):
        rig.ask(START)
        assert rig.flags() == set()
        rig.until("SB")
        assert rig.state() == {"MSL", "BUSY"}
        assert not rig.peek("CR1") & START
        rig.poke("DR", 0xA0)
        assert rig.flags() == set()
        assert 9 * BIT <= rig.until("ADDR") < 9 * BIT + 8
        assert rig.state() == {"MSL", "BUSY", "TRA"}
        rig.chip.advance(100 * BIT)
        assert rig.flags() == {"ADDR"}  # SCL is held low until it is cleared
        rig.clear_addr()
        assert rig.flags() == {"TXE"}  # EV8_1
        rig.poke("DR", 0x10)
        assert rig.flags() == {"TXE"}  # it went to the shift register at once
        rig.poke("DR", 0x42)
        assert rig.flags() == set()
        rig.until("TXE")
        assert 9 * BIT - 8 <= rig.until("BTF") <= 9 * BIT + 8
        assert rig.flags() == {"TXE", "BTF"}
        rig.ask(STOP)
        rig.until_free()
        assert not rig.peek("CR1") & STOP
        assert rig.flags() == set()
        assert rig.eeprom.data[0x10] == 0x42
        assert [(m.address, m.read, m.data, m.acknowledged) for m in rig.told[0].messages] == [
            (0x50, False, b"\x10\x42", True)
        ]

    def test_stop_waits_for_the_byte_under_way(self, rig):
        rig.start(0x50)
        rig.clear_addr()
        rig.poke("DR", 0x10)
        rig.poke("DR", 0x42)
        rig.until("TXE")
        rig.ask(STOP)
        rig.until_free()
        assert rig.eeprom.data[0x10] == 0x42

    def test_btf_is_cleared_by_the_next_byte(self, rig):
        rig.start(0x50)
        rig.clear_addr()
        rig.poke("DR", 1)
        rig.until("BTF")
        rig.poke("DR", 2)
        assert rig.flags() == {"TXE"}

    @each(("ccr", "cycles"), [(180, 720), (30 | 1 << 15, 180), (4 | 3 << 14, 200), (0xFFF, 16_380), (4, 16)])
    def test_how_long_a_bit_takes(self, make_rig, ccr, cycles):
        """CCR in standard mode twice, in fast mode three or 25 times, in clocks of PCLK1."""
        rig = make_rig().enable(ccr)
        rig.ask(START)
        rig.until("SB")
        rig.poke("DR", 0xA0)
        begin = rig.chip.time.now
        while "ADDR" not in rig.flags():
            rig.chip.advance(1)
        assert rig.chip.time.now - begin == 9 * cycles


class TestReceiving:
    @given(count=st.integers(1, 9), place=st.integers(0, 255))
    def test_any_number_of_bytes_by_the_manual(self, make_rig, count, place):
        rig = make_rig().enable()
        rig.eeprom.data[:] = bytes(range(256))
        rig.write(place, stop=False)
        assert rig.read(count) == bytes((place + n) % 256 for n in range(count))
        messages = rig.told[0].messages
        assert [(m.read, len(m.data)) for m in messages] == [(False, 1), (True, count)]

    def test_scl_stays_low_while_two_bytes_wait(self, rig):
        rig.eeprom.data[:4] = b"abcd"
        rig.write(0, stop=False)
        rig.start(0x50, read=True, acknowledge=True)
        rig.clear_addr()
        rig.until("BTF")
        assert rig.flags() == {"RXNE", "BTF"}
        rig.chip.advance(50 * BIT)
        assert rig.flags() == {"RXNE", "BTF"}
        assert rig.peek("DR") == ord("a")
        assert rig.flags() == {"RXNE"}
        assert rig.peek("DR") == ord("b")
        assert rig.flags() == set()

    def test_a_repeated_start(self, rig):
        rig.eeprom.data[5] = 0x77
        rig.write(5, stop=False)
        assert rig.read(1) == b"\x77"
        assert len(rig.told) == 1

    def test_without_one_a_stop_between_two_transfers(self, rig):
        rig.eeprom.data[5] = 0x77
        rig.write(5)
        assert rig.read(1) == b"\x77"
        assert len(rig.told) == 2


class TestTenBits:
    class Slave:
        def __init__(self):
            self.taken, self.on = [], False

        def address(self, address, read, now_ns):
            del now_ns
            self.taken.append((address, read))
            return address == 0x79

        def write(self, byte, now_ns):
            del now_ns
            self.taken.append(byte)
            return True

        def read(self, now_ns):
            del now_ns
            return 0x3C

        def end(self, now_ns):
            pass

    def test_both_ways(self, rig):
        """Address 0x155: EV9 between its bytes; to read, the header once more."""
        slave = self.Slave()
        rig.bus.attach(slave)
        rig.ask(START)
        rig.until("SB")
        rig.poke("DR", 0xF2)
        rig.until("ADD10")
        assert rig.flags() == {"ADD10"}
        rig.poke("DR", 0x55)
        rig.until("ADDR")
        rig.clear_addr()
        assert rig.flags() == {"TXE"}
        rig.ask(START)
        rig.until("SB")
        rig.poke("DR", 0xF3)
        rig.until("ADDR")
        rig.clear_addr()
        rig.ask(STOP)
        rig.until("RXNE")
        assert rig.peek("DR") == 0x3C
        assert slave.taken == [(0x79, False), 0x55, (0x79, True)]


class TestErrors:
    def test_nobody_answers(self, make_rig):
        rig = make_rig().enable(cr2=ITERREN)
        rig.ask(START)
        rig.until("SB")
        rig.poke("DR", 0x20)
        rig.until("AF")
        assert rig.flags() == {"AF"}
        assert rig.state() == {"MSL", "BUSY", "TRA"}
        assert rig.error.level
        rig.ask(STOP)
        rig.until_free()
        rig.poke("SR1", 0)
        assert rig.flags() == set()
        assert not rig.error.level

    def test_a_byte_is_refused(self, rig):
        rig.eeprom.write = lambda _byte, _now_ns: False
        rig.start(0x50)
        rig.clear_addr()
        rig.poke("DR", 1)
        rig.until("AF")
        rig.chip.advance(100 * BIT)
        assert "BTF" not in rig.flags()
        rig.ask(STOP)
        rig.until_free()

    def test_busy_writing_it_answers_nothing_until_it_is_through(self, rig):
        """Acknowledge polling, as the data sheet of the EEPROM has it."""
        rig.write(3, 0xAA)
        tries = 0
        while True:
            rig.ask(START)
            rig.until("SB")
            rig.poke("DR", 0xA0)
            while not rig.flags() & {"ADDR", "AF"}:
                rig.chip.advance(4)
            rig.peek("SR1")
            if "ADDR" in rig.flags():
                break
            rig.poke("SR1", 0)
            rig.ask(STOP)
            rig.until_free()
            tries += 1
        assert 20 < tries < 50

    def test_sda_held_low_makes_the_bus_busy(self, rig):
        rig.bus.stick()
        assert rig.state() == {"BUSY"}
        rig.ask(START)
        rig.chip.advance(100 * BIT)
        assert rig.flags() == set()
        rig.bus.unstick()
        rig.until("SB")

    def test_sda_held_low_in_the_middle_is_arbitration_lost(self, rig):
        rig.start(0x50)
        rig.clear_addr()
        rig.bus.stick()
        rig.poke("DR", 0xFF)
        rig.until("ARLO")
        assert rig.state() == {"BUSY"}
        assert not rig.peek("CR1") & START

    def test_what_disturbs(self, rig):
        rig.start(0x50)
        rig.i2c.disturb("BERR")
        assert rig.flags() == {"ADDR", "BERR"}
        rig.i2c.disturb("ARLO")
        assert "ARLO" in rig.flags()
        assert rig.state() == set()

    def test_a_slave_stretches(self, rig):
        rig.bus.stretch_ns[0x50] = 1_000_000
        rig.start(0x50)
        rig.clear_addr()
        rig.poke("DR", 1)
        assert rig.until("BTF") > 72_000

    def test_reset_by_software(self, rig):
        rig.start(0x50)
        rig.ask(SWRST)
        assert (rig.flags(), rig.state(), rig.peek("CCR")) == (set(), set(), 0)
        rig.poke("CR1", 0)
        rig.enable()
        rig.write(1, 2)

    def test_switched_off_in_the_middle(self, rig):
        rig.start(0x50)
        rig.poke("CR1", 0)
        assert (rig.flags(), rig.state()) == (set(), set())
        rig.chip.advance(100 * BIT)
        rig.poke("CR1", PE)
        rig.write(1, 2)


class TestLines:
    def test_interrupts(self, make_rig):
        rig = make_rig().enable(cr2=ITEVTEN)
        rig.ask(START)
        rig.until("SB")
        assert rig.event.level
        rig.poke("DR", 0xA0)
        assert not rig.event.level
        rig.until("ADDR")
        assert rig.event.level
        rig.clear_addr()
        assert not rig.event.level  # TXE asks by ITBUFEN alone
        rig.poke("CR2", 36 | ITEVTEN | ITBUFEN)
        assert rig.event.level
        rig.poke("DR", 1)
        rig.poke("DR", 2)
        assert not rig.event.level

    def test_requests(self, make_rig):
        rig = make_rig().enable(cr2=DMAEN)
        tx, rx = rig.chip.dma("I2C1_TX"), rig.chip.dma("I2C1_RX")
        rig.start(0x50)
        assert not tx.level
        rig.clear_addr()
        assert tx.level
        rig.poke("DR", 5)
        assert tx.level
        rig.until("BTF")
        rig.start(0x50, read=True, acknowledge=True)
        rig.clear_addr()
        rig.until("RXNE")
        assert rx.level
        rig.peek("DR")
        assert not rx.level

    def test_the_last_byte_of_dma_is_not_acknowledged(self, make_rig):
        rig = make_rig().enable(cr2=DMAEN | LAST)
        rig.eeprom.data[:5] = b"12345"
        rig.left, got = 4, []
        rx = rig.chip.dma("I2C1_RX")

        def fetch(level):
            if level and rig.left:
                got.append(rig.peek("DR"))
                rig.left -= 1

        rx.on_set = fetch
        rig.write(0, stop=False)
        rig.start(0x50, read=True, acknowledge=True)
        rig.clear_addr()
        rig.chip.advance(100 * BIT)
        assert bytes(got) == b"1234"
        rig.ask(STOP)
        rig.until_free()
        assert len(rig.told[0].messages[-1].data) == 4

    def test_what_is_missing_or_wrong_is_noted(self, rig):
        rig.poke("OAR1", 0x4060)
        assert rig.chip.noted() == []
        rig.ask(ACK)
        assert rig.chip.noted("unmodelled") == ["I2C1_OAR1"]
        rig.poke("DR", 5)
        rig.poke("CCR", 7)
        rig.poke("CR1", 0)
        rig.poke("CR2", 8)
        rig.poke("CR1", PE)
        assert rig.chip.noted("misuse") == ["I2C1_DR", "I2C1_CCR", "I2C1_CR2.FREQ"]

    def test_pins_that_are_not_there(self, rig):
        rig.chip.output("I2C1_SCL").connected = False
        rig.ask(START)
        rig.chip.advance(100 * BIT)
        assert rig.flags() == set()
        assert rig.chip.noted("misuse") == ["I2C1_CR1.START"]

    def test_levels_are_drawn(self, rig):
        edges = []
        rig.i2c.draw(lambda line, ns, level: edges.append((ns, line, level)))
        rig.write(0x10, 0x42)
        assert [level for _, line, level in edges if line == "scl"].count(False) == 28
        assert edges == sorted(edges, key=lambda edge: edge[0])


@given(
    writes=st.lists(
        st.tuples(
            st.sampled_from(("CR1", "CR2", "OAR1", "DR", "SR1", "SR2", "CCR")),
            st.integers(0, 0xFFFF),
            st.integers(0, 9),
        )
    )
)
def test_no_writes_break_it(make_rig, writes):
    rig = make_rig().enable()
    for register, value, bits in writes:
        rig.poke(register, value)
        rig.chip.advance(bits * BIT)
        for name in ("SR1", "SR2", "DR"):
            assert 0 <= rig.peek(name) <= 0xFFFF
    rig.poke("CR1", SWRST)
    rig.poke("CR1", 0)
    rig.settle_eeprom()
    rig.enable()
    rig.write(1, 2)
