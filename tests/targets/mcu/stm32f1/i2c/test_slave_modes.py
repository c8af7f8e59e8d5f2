"""Own addresses, NOSTRETCH, packet error code, DMA and SMBus of I2C v1 as a slave (RM0008 26.3.2 to 26.3.8)."""

from __future__ import annotations

import crcmod.predefined
from hypothesis import given
from hypothesis import strategies as st

from tests.each import each

SMBUS, SMBTYPE, ENARP, ENPEC, ENGC, NOSTRETCH = (1 << bit for bit in (1, 3, 4, 5, 6, 7))
START, STOP, ACK, POS, PEC, ALERT = (1 << bit for bit in range(8, 14))
DMAEN, LAST = 1 << 11, 1 << 12
TEN, ADDMODE = 0x2A5, 0x8000
HEADER = 0xF4
BIT, MS = 720, 72_000

pec_of = crcmod.predefined.mkPredefinedCrcFun("crc-8")


class TestAddresses:
    @each(
        ("control", "oar2", "byte", "state"),
        [
            (0, 0x35 << 1 | 1, 0x35 << 1, {"DUALF"}),
            (0, 0x35 << 1 | 1, 0x35 << 1 | 1, {"DUALF", "TRA"}),
            (0, 0x35 << 1 | 1, 0x21 << 1, set()),
            (0, 0x35 << 1, 0x35 << 1, None),  # without ENDUAL
            (ENGC, 0, 0, {"GENCALL"}),
            (ENGC, 0, 1, None),  # a START byte
            (0, 0, 0, None),
            (SMBUS | ENARP, 0, 0x61 << 1, {"SMBDEFAULT"}),
            (SMBUS | ENARP | SMBTYPE, 0, 0x61 << 1, None),
            (SMBUS | ENARP | SMBTYPE, 0, 0x08 << 1, {"SMBHOST"}),
            (SMBUS | ENARP, 0, 0x08 << 1, None),
            (SMBUS, 0, 0x61 << 1, None),
            (ENARP, 0, 0x61 << 1, None),
            (SMBUS | ALERT, 0, 0x0C << 1 | 1, {"TRA"}),
            (SMBUS | ALERT, 0, 0x0C << 1, None),
            (SMBUS, 0, 0x0C << 1 | 1, None),
            (ALERT, 0, 0x0C << 1 | 1, None),
        ],
    )
    def test_which_are_its_own(self, make_pair, control, oar2, byte, state):
        pair = make_pair(control=control, oar2=oar2)
        pair.begin(byte)
        assert pair.master.flags() == ({"AF"} if state is None else {"ADDR"})
        assert pair.slave.state() - {"BUSY"} == (state or set())
        if state is not None:
            assert pair.slave.flags() - {"SMBALERT"} == {"ADDR"}
            pair.clear_both()
            if not byte & 1:
                pair.stop()
                assert pair.slave.state() == set()

    def test_the_alert_response(self, make_pair):
        pair = make_pair(control=SMBUS | ALERT)
        pair.begin(0x0C << 1 | 1)
        assert pair.slave.flags() == {"ADDR", "SMBALERT"}

    def test_ten_bits(self, make_pair):
        """Always a receiver first; a repeated START with the header makes it a transmitter."""
        pair = make_pair(oar1=0x4000 | ADDMODE | TEN)
        master, slave = pair.master, pair.slave
        pair.begin(HEADER)
        assert master.flags() == {"ADD10"}
        assert slave.flags() == set()
        master.poke("DR", TEN & 0xFF)
        master.until("ADDR")
        assert slave.flags() == {"ADDR"}
        assert slave.state() == {"BUSY"}
        pair.clear_both()
        pair.begin(HEADER | 1)
        assert slave.flags() == {"ADDR"}
        assert slave.state() == {"BUSY", "TRA"}
        pair.clear_both()
        slave.poke("DR", 0x77)
        master.until("RXNE")
        assert master.peek("DR") == 0x77
        pair.stop()
        pair.begin(HEADER | 1)  # a STOP ends that it was addressed
        assert master.flags() == {"AF"}

    @each("header", [HEADER ^ 2, HEADER ^ 4, 0xA4])
    def test_ten_bits_of_another(self, make_pair, header):
        pair = make_pair(oar1=0x4000 | ADDMODE | TEN)
        pair.begin(header)
        assert pair.master.flags() == {"AF"}

    def test_the_second_byte_of_another(self, make_pair):
        pair = make_pair(oar1=0x4000 | ADDMODE | TEN)
        pair.begin(HEADER)
        pair.master.poke("DR", 0xA4)
        pair.master.until("AF")
        assert pair.slave.flags() == set()
        pair.begin(HEADER | 1)
        assert "AF" in pair.master.flags()
        assert pair.slave.flags() == set()

    def test_with_seven_bits_no_header_is_answered(self, pair):
        pair.begin(HEADER)
        assert pair.master.flags() == {"AF"}


class TestWithoutStretching:
    def test_overrun(self, make_pair):
        pair = make_pair(control=NOSTRETCH)
        master, slave = pair.master, pair.slave
        pair.address()
        master.clear_addr()
        for byte in (1, 2):
            master.poke("DR", byte)
            master.until("BTF")
        assert slave.flags() == {"ADDR", "RXNE", "OVR"}
        slave.clear_addr()
        assert slave.peek("DR") == 1  # the byte that came last is lost
        slave.poke("SR1", 0)
        master.poke("DR", 3)
        master.until("BTF")
        assert slave.flags() == {"RXNE"}
        assert slave.peek("DR") == 3

    def test_underrun(self, make_pair):
        pair = make_pair(control=NOSTRETCH)
        master, slave = pair.master, pair.slave
        pair.address(read=True)
        slave.clear_addr()
        slave.poke("DR", 0xAB)
        master.clear_addr()
        pair.wait(9.1)
        assert slave.flags() == {"TXE", "OVR"}  # the next byte has begun
        pair.wait(9)
        assert [master.peek("DR"), master.peek("DR")] == [0xAB, 0xAB]

    @given(data=st.lists(st.integers(0, 255), min_size=1, max_size=6))
    def test_a_slave_that_is_in_time_loses_nothing(self, make_pair, data):
        pair, got = make_pair(control=NOSTRETCH), []
        pair.address()
        pair.clear_both()
        for byte in data:
            pair.master.poke("DR", byte)
            pair.master.until("BTF")
            got.append(pair.slave.peek("DR"))
        assert got == data
        assert pair.slave.flags() == set()


class TestPacketErrorCode:
    @each("error", [0, 4])
    def test_of_a_slave_that_receives(self, make_pair, error):
        pair = make_pair(control=ENPEC)
        master, slave = pair.master, pair.slave
        pair.address()
        pair.clear_both()
        master.poke("DR", 0x11)
        master.until("BTF")
        assert slave.peek("DR") == 0x11
        slave.ask(PEC)
        pec = pec_of(bytes([pair.OWN << 1, 0x11]))
        assert slave.peek("SR2") >> 8 == pec
        master.poke("DR", pec ^ error)
        while not master.flags() & {"BTF", "AF"}:
            pair.chip.advance(4)
        assert ("AF" in master.flags()) is ("PECERR" in slave.flags()) is bool(error)
        assert slave.peek("DR") == pec ^ error
        pair.stop()
        assert ("STOPF" in slave.flags()) is not bool(error)

    def test_of_a_slave_that_sends(self, make_pair):
        pair = make_pair(control=ENPEC)
        master, slave = pair.master, pair.slave
        pair.address(read=True)
        pair.clear_both()
        slave.poke("DR", 0x3C)
        slave.ask(PEC)
        master.until("BTF")
        assert slave.flags() == {"TXE", "BTF"}
        assert [master.peek("DR"), master.peek("DR")] == [0x3C, pec_of(bytes([pair.OWN << 1 | 1, 0x3C]))]
        assert not slave.peek("CR1") & PEC

    def test_of_ten_bits(self, make_pair):
        pair = make_pair(control=ENPEC, oar1=0x4000 | ADDMODE | TEN)
        pair.begin(HEADER)
        pair.master.poke("DR", TEN & 0xFF)
        pair.master.until("ADDR")
        pair.clear_both()
        assert pair.slave.peek("SR2") >> 8 == pec_of(bytes([HEADER, TEN & 0xFF]))


class TestDma:
    def serve(self, rig, name, data, *, sends):
        """Play a channel; it has its transfer two cycles after the request, as the controller does."""
        request, done = rig.chip.dma(name), []
        if sends:
            rig.tx_left = len(data)
        else:
            rig.left = len(data)

        def act():
            left = rig.tx_left if sends else rig.left
            if not request.level or not left:
                return
            if sends:
                rig.poke("DR", data[-left])
                rig.tx_left -= 1
            else:
                done.append(rig.peek("DR"))
                rig.left -= 1
            rig.chip.time.after(2, act)

        request.on_set = lambda level: rig.chip.time.after(2, act) if level else None
        return done

    def test_received(self, make_pair):
        pair = make_pair(slave_cr2=DMAEN, control=ENPEC)
        master, data = pair.master, [1, 2, 3]
        got = self.serve(pair.slave, "I2C2_RX", bytes(4), sends=False)
        pair.address()
        pair.clear_both()
        for byte in (*data, pec_of(bytes([pair.OWN << 1, *data]))):
            master.poke("DR", byte)
            master.until("BTF")
        pair.wait(1)
        assert got == [*data, pec_of(bytes([pair.OWN << 1, *data]))]
        assert pair.slave.flags() == set()  # the last byte of the channel was the PEC
        pair.stop()
        assert pair.slave.flags() == {"STOPF"}

    def test_sent(self, make_pair):
        pair = make_pair(slave_cr2=DMAEN, control=ENPEC)
        master, data, got = pair.master, [7, 8, 9], []
        self.serve(pair.slave, "I2C2_TX", data, sends=True)
        pair.address(read=True)
        pair.clear_both()
        for left in range(len(data), -1, -1):
            master.until("RXNE")
            if left == 1:
                master.drop(ACK)
            got.append(master.peek("DR"))
        assert got == [*data, pec_of(bytes([pair.OWN << 1 | 1, *data]))]
        assert "AF" in pair.slave.flags()

    def test_last_is_for_masters(self, make_pair):
        pair = make_pair(slave_cr2=DMAEN | LAST)
        got = self.serve(pair.slave, "I2C2_RX", bytes(2), sends=False)
        pair.address()
        pair.clear_both()
        for byte in (1, 2):
            pair.master.poke("DR", byte)
            pair.master.until("BTF")
        pair.wait(1)
        assert got == [1, 2]


class TestTimeouts:
    def test_a_slave_may_hold_scl_for_25_ms_of_a_message(self, make_pair):
        pair = make_pair(control=SMBUS)
        master, slave = pair.master, pair.slave
        pair.address()
        master.clear_addr()
        pair.chip.advance(20 * MS)
        assert slave.flags() == {"ADDR"}
        slave.clear_addr()
        for byte in (1, 2, 3):
            master.poke("DR", byte)
            pair.wait(10)
        begin = pair.chip.time.now
        assert slave.flags() == {"RXNE", "BTF"}
        slave.until("TIMEOUT", limit=6 * MS)
        assert abs(pair.chip.time.now - begin - 5 * MS) < 16 * BIT
        assert slave.flags() == {"RXNE", "TIMEOUT"}
        master.until("AF")  # the lines are let go
        assert slave.state() == {"BUSY"}
        pair.stop()
        assert slave.flags() == {"RXNE", "TIMEOUT"}

    def test_each_message_has_its_own(self, make_pair):
        pair = make_pair(control=SMBUS)
        for _ in range(3):
            pair.address()
            pair.master.clear_addr()
            pair.chip.advance(20 * MS)
            pair.slave.clear_addr()
        assert "TIMEOUT" not in pair.slave.flags()

    def test_i2c_has_none(self, pair):
        pair.address()
        pair.chip.advance(100 * MS)
        assert pair.slave.flags() == {"ADDR"}

    @each("own", [True, False])
    def test_a_master_that_holds_scl_for_25_ms(self, make_pair, own):
        """Whether the slave is addressed or not: the lines are released, and the communication is over for it."""
        pair = make_pair(control=SMBUS)
        pair.begin((pair.OWN if own else 0x50) << 1)
        if own:
            pair.slave.clear_addr()
        pair.chip.advance(25 * MS - 100)
        assert pair.slave.flags() == set()
        pair.chip.advance(200)
        assert pair.slave.flags() == {"TIMEOUT"}
        pair.master.clear_addr()
        pair.master.poke("DR", 1)
        pair.master.until("AF" if own else "BTF")
        assert pair.slave.flags() == {"TIMEOUT"}

    def test_one_that_goes_on_after_24_ms(self, make_pair):
        pair = make_pair(control=SMBUS)
        pair.address()
        pair.slave.clear_addr()
        for byte in (1, 2, 3):
            pair.chip.advance(24 * MS)
            pair.master.clear_addr()
            pair.master.poke("DR", byte)
            pair.master.until("BTF")
            assert pair.slave.peek("DR") == byte
        assert pair.slave.flags() == set()


class TestBeside:
    def test_a_master_is_not_its_own_slave(self, pair):
        pair.master.poke("OAR1", 0x4000 | 0x44 << 1)
        pair.begin(0x44 << 1)
        assert pair.master.flags() == {"AF"}

    @given(
        writes=st.lists(
            st.tuples(
                st.sampled_from(("master", "slave")),
                st.sampled_from(("CR1", "CR2", "OAR1", "OAR2", "DR", "SR1")),
                st.integers(0, 0xFFFF),
                st.integers(0, 9),
            ),
            max_size=20,
        )
    )
    def test_no_writes_break_it(self, make_pair, writes):
        pair = make_pair()
        pair.address()
        for who, register, value, bits in writes:
            rig = getattr(pair, who)
            rig.poke(register, value)
            pair.wait(bits)
            for name in ("SR1", "SR2", "DR"):
                assert 0 <= rig.peek(name) <= 0xFFFF
        for rig in (pair.master, pair.slave):
            rig.poke("CR1", 1 << 15)
            rig.poke("CR1", 0)
            rig.enable()
        pair.slave.poke("OAR1", 0x4000 | pair.OWN << 1)
        pair.slave.ask(ACK)
        pair.address()
        assert pair.slave.flags() == {"ADDR"}
