"""Packet error code, timeouts and alert of I2C v1 as a master (RM0008 sections 26.3.6, 26.3.8, 26.6)."""

from __future__ import annotations

import crcmod.predefined
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.each import each

PE, SMBUS, SMBTYPE, ENPEC, START, STOP, ACK, POS, PEC, ALERT = (1 << b for b in (0, 1, 3, 5, 8, 9, 10, 11, 12, 13))
ITERREN, DMAEN, LAST = 1 << 8, 1 << 11, 1 << 12
BIT = 720
MS = 72_000  # HCLK cycles
HERE = 0x5A

pec_of = crcmod.predefined.mkPredefinedCrcFun("crc-8")


class Thermometer:
    """A slave that keeps what is written to it and sends what it was given."""

    def __init__(self):
        self.taken, self.sends = [], []

    def address(self, address, read, now_ns):
        del read, now_ns
        return address == HERE

    def write(self, byte, now_ns):
        del now_ns
        self.taken.append(byte)
        return True

    def read(self, now_ns):
        del now_ns
        return self.sends.pop(0)

    def end(self, now_ns):
        pass


@pytest.fixture
def slave(rig):
    slave = Thermometer()
    rig.bus.attach(slave)
    rig.ask(ENPEC)
    return slave


def pec(rig):
    return rig.peek("SR2") >> 8


def send(rig, *data, stop=True):
    """As a polling driver: PEC is set after the last byte has gone to DR."""
    rig.start(HERE)
    rig.clear_addr()
    for byte in data:
        rig.until("TXE")
        rig.poke("DR", byte)
    if stop:
        rig.ask(PEC)
    rig.until("BTF")
    if stop:
        rig.ask(STOP)
        rig.until_free()


class TestKnownAnswers:
    def test_the_check_value_of_the_polynomial(self):
        assert pec_of(b"123456789") == 0xF4

    def test_a_read_word_of_an_infrared_thermometer(self, rig, slave):
        """B4 07 B5 D2 3A gives 30: data sheet of the MLX90614, section 8.4.3.1.1."""
        slave.sends = [0xD2, 0x3A, 0x30]
        send(rig, 0x07, stop=False)
        assert pec(rig) == pec_of(bytes([0xB4, 0x07]))
        rig.start(HERE, read=True, acknowledge=True)
        rig.clear_addr()
        rig.until("BTF")
        assert pec(rig) == 0x30
        rig.drop(ACK)
        rig.ask(PEC)
        assert [rig.peek("DR"), rig.peek("DR")] == [0xD2, 0x3A]
        rig.until("RXNE")
        assert rig.flags() == {"RXNE"}  # no PECERR
        assert rig.peek("DR") == 0x30
        assert not rig.peek("CR1") & PEC
        rig.ask(STOP)
        rig.until_free()

    @given(data=st.lists(st.integers(0, 255), min_size=1, max_size=6))
    def test_what_is_sent_is_what_another_library_computes(self, make_rig, data):
        rig, slave = make_rig().enable(), Thermometer()
        rig.bus.attach(slave)
        rig.ask(ENPEC)
        send(rig, *data)
        assert slave.taken == [*data, pec_of(bytes([HERE << 1, *data]))]


class TestSending:
    def test_event_by_event(self, rig, slave):
        rig.start(HERE)
        rig.clear_addr()
        rig.poke("DR", 1)
        rig.poke("DR", 2)
        rig.ask(PEC)
        rig.chip.advance(9 * BIT + 8)
        assert rig.flags() == set()  # TXE is not set: the PEC is next
        assert rig.peek("CR1") & PEC
        rig.chip.advance(9 * BIT)
        assert rig.flags() == set()  # nor is BTF
        assert not rig.peek("CR1") & PEC
        rig.chip.advance(9 * BIT)
        assert rig.flags() == {"TXE", "BTF"}
        assert slave.taken == [1, 2, pec_of(b"\xb4\1\2")]

    def test_asked_for_while_scl_is_held(self, rig, slave):
        send(rig, 1, stop=False)
        rig.ask(PEC)
        assert rig.flags() == set()
        rig.until("BTF")
        assert slave.taken == [1, pec_of(b"\xb4\1")]

    def test_by_dma_it_follows_the_last_byte(self, make_rig):
        rig, slave, data = make_rig().enable(cr2=DMAEN), Thermometer(), [3, 4, 5]
        rig.bus.attach(slave)
        rig.ask(ENPEC)
        rig.tx_left = len(data)
        request = rig.chip.dma("I2C1_TX")

        def serve():
            if request.level and rig.tx_left:
                rig.poke("DR", data[-rig.tx_left])
                rig.tx_left -= 1

        rig.start(HERE)
        rig.clear_addr()
        for _ in range(300):
            serve()
            rig.chip.advance(BIT // 8)
        assert slave.taken == [*data, pec_of(bytes([0xB4, *data]))]
        assert rig.flags() == {"TXE", "BTF"}

    def test_stop_and_start_take_it_back(self, rig, slave):
        send(rig, 1, stop=False)
        rig.ask(STOP | PEC)
        rig.until_free()
        assert not rig.peek("CR1") & PEC
        assert slave.taken == [1]

    def test_each_message_begins_anew_but_not_after_a_repeated_start(self, rig, slave):
        send(rig, 1, stop=False)
        before = pec(rig)
        rig.ask(START)
        rig.until("SB")
        assert pec(rig) == before
        rig.ask(STOP)
        rig.until_free()
        assert pec(rig) == before
        rig.ask(START)
        rig.until("SB")
        assert pec(rig) == 0

    def test_without_enpec_there_is_none(self, rig, slave):
        send(rig, 1, stop=False)
        rig.drop(ENPEC)
        assert pec(rig) == 0
        rig.poke("DR", 9)
        rig.until("BTF")
        assert pec(rig) == 0


class TestReceiving:
    @pytest.mark.parametrize("error", [0, 1])
    def test_two_bytes_with_pos(self, rig, slave, error):
        """POS and PEC during the stretch of ADDR: the second byte is the PEC (section 26.6.1, POS)."""
        slave.sends = [0x42, pec_of(b"\xb5\x42") ^ error]
        rig.ask(POS)
        rig.start(HERE, read=True, acknowledge=True)
        rig.ask(PEC)
        rig.clear_addr()
        rig.drop(ACK)
        rig.until("BTF")
        assert ("PECERR" in rig.flags()) is bool(error)
        rig.ask(STOP)
        assert rig.peek("DR") == 0x42
        rig.until_free()

    def test_a_wrong_one_is_not_acknowledged_though_ack_is_set(self, make_rig):
        rig, slave = make_rig().enable(cr2=ITERREN), Thermometer()
        rig.bus.attach(slave)
        rig.ask(ENPEC)
        slave.sends = [0x00, 0x77]
        rig.start(HERE, read=True, acknowledge=True)
        rig.ask(PEC)
        rig.clear_addr()
        rig.until("RXNE")
        assert rig.flags() == {"RXNE", "PECERR"}
        assert rig.error.level
        rig.chip.advance(100 * BIT)
        assert rig.flags() == {"RXNE", "PECERR"}  # after a NACK nothing more is clocked
        rig.poke("SR1", 0)
        assert not rig.error.level

    def test_a_right_one_is_acknowledged_as_ack_says(self, rig, slave):
        slave.sends = [pec_of(b"\xb5"), 0x77]
        rig.start(HERE, read=True, acknowledge=True)
        rig.ask(PEC)
        rig.clear_addr()
        rig.until("BTF")
        assert rig.flags() == {"RXNE", "BTF"}

    @each("error", [0, 0x80])
    def test_by_dma_the_last_byte_is_one(self, make_rig, error):
        rig, slave, got = make_rig().enable(cr2=DMAEN | LAST), Thermometer(), []
        rig.bus.attach(slave)
        rig.ask(ENPEC)
        slave.sends = [1, 2, pec_of(b"\xb5\1\2") ^ error]
        rig.left = 3

        def fetch(level):
            if level and rig.left:
                got.append(rig.peek("DR"))
                rig.left -= 1

        rig.chip.dma("I2C1_RX").on_set = fetch
        rig.start(HERE, read=True, acknowledge=True)
        rig.clear_addr()
        rig.chip.advance(100 * BIT)
        assert got[:2] == [1, 2]
        assert len(got) == 3  # a request is made for it, too
        assert ("PECERR" in rig.flags()) is bool(error)


class TestTimeouts:
    @pytest.fixture
    def smbus(self, make_rig):
        rig = make_rig().enable(cr2=ITERREN)
        rig.bus.attach(Thermometer())
        rig.ask(SMBUS)
        return rig

    def test_a_master_that_holds_scl_for_10_ms_stops(self, smbus):
        smbus.ask(START)
        smbus.until("SB")
        smbus.chip.advance(10 * MS - 8)
        assert smbus.flags() == {"SB"}
        smbus.chip.advance(8)
        assert smbus.flags() == {"TIMEOUT"}
        assert smbus.error.level
        assert smbus.peek("CR1") & STOP
        smbus.until_free()
        assert not smbus.peek("CR1") & STOP
        smbus.poke("SR1", 0)
        assert smbus.flags() == set()

    def test_each_byte_has_its_own_10_ms(self, smbus):
        smbus.start(HERE)
        for _ in range(4):
            smbus.chip.advance(9 * MS)
            smbus.clear_addr()
            smbus.poke("DR", 1)
            smbus.until("BTF")
        assert "TIMEOUT" not in smbus.flags()

    def test_a_slave_that_holds_scl_for_25_ms(self, smbus):
        smbus.start(HERE)
        smbus.bus.stretch_ns[HERE] = 40_000_000
        smbus.clear_addr()
        smbus.poke("DR", 1)
        smbus.until("BTF")
        begin = smbus.chip.time.now
        smbus.poke("DR", 2)
        smbus.chip.advance(24 * MS)
        assert "TIMEOUT" not in smbus.flags()
        smbus.until("TIMEOUT", limit=2 * MS)
        assert abs(smbus.chip.time.now - begin - 25 * MS) < 16
        smbus.chip.advance(14 * MS)
        smbus.until_free()
        assert 40 * MS <= smbus.chip.time.now - begin <= 40 * MS + 3 * BIT

    def test_one_that_holds_it_for_24_ms_does_not(self, smbus):
        smbus.start(HERE)
        smbus.bus.stretch_ns[HERE] = 24_000_000
        smbus.clear_addr()
        for _ in range(2):
            smbus.poke("DR", 1)
            smbus.until("BTF", limit=60 * MS)
        assert "TIMEOUT" not in smbus.flags()

    def test_i2c_has_none(self, rig):
        rig.ask(START)
        rig.until("SB")
        rig.chip.advance(100 * MS)
        assert rig.flags() == {"SB"}

    def test_without_pe_there_is_none(self, smbus):
        smbus.ask(START)
        smbus.until("SB")
        smbus.poke("CR1", SMBUS)
        smbus.chip.advance(100 * MS)
        assert smbus.flags() == set()


class TestAlert:
    def test_a_device_pulls_smba_low(self, rig):
        pin = rig.chip.output("I2C1_SMBA")
        rig.ask(ALERT)
        assert pin.level is None  # not applicable without SMBUS
        rig.ask(SMBUS)
        assert pin.level is False
        rig.drop(ALERT)
        assert pin.level is True
        rig.ask(ALERT)
        rig.poke("CR1", SMBUS | ALERT)
        assert not rig.peek("CR1") & ALERT  # PE = 0 clears it
        assert pin.level is None

    @each(("control", "hears"), [(SMBUS | SMBTYPE, True), (SMBUS, False), (SMBTYPE, False)])
    def test_a_host_hears_it_fall(self, make_rig, control, hears):
        rig = make_rig().enable(cr2=ITERREN)
        pin = rig.chip.input("I2C1_SMBA")
        pin.drive(True)
        rig.ask(control)
        pin.drive(False)
        assert ("SMBALERT" in rig.flags()) is hears
        assert rig.error.level is hears
        rig.poke("SR1", 0)
        pin.drive(True)
        assert rig.flags() == set()


def test_what_pe_clears(rig):
    """Section 26.6.1: ALERT, PEC, POS, ACK and START are cleared by hardware when PE is 0."""
    rig.poke("CR1", PE | ACK | POS | PEC | ENPEC)
    rig.poke("CR1", ACK | POS | PEC | ENPEC | START)
    assert rig.peek("CR1") == ENPEC
