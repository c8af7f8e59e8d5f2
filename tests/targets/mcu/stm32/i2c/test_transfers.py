"""The I2C master against a memory: what is sent, which flags come, what ends a transfer (RM0410 section 33.4.9)."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from tests.each import each

START, STOP, RELOAD, AUTOEND, PECBYTE = 1 << 13, 1 << 14, 1 << 24, 1 << 25, 1 << 26
ADD10, HEAD10R = 1 << 11, 1 << 12
READ = 1 << 10
PE, PECEN = 1, 1 << 23
CLEAR_ALL = 0x3F38


def messages(rig):
    """What the bus has seen: direction and bytes of each message, by transaction."""
    return [[("R" if one.read else "W", one.data.hex()) for one in told.messages] for told in rig.told]


class TestWriting:
    def test_with_automatic_end(self, rig, memory):
        rig.send(0x10, 0xAA, 0xBB)
        rig.until("STOPF")
        assert rig.flags() == {"STOPF"}
        assert memory.data[0x10:0x12] == b"\xaa\xbb"
        assert messages(rig) == [[("W", "10aabb")]]
        assert not rig.peek("CR2") & START

    def test_with_software_end(self, rig):
        rig.send(0x10, 0xAA, more=0)
        rig.until("TC")
        assert rig.flags() == {"TC", "BUSY"}
        rig.clocks(5000)
        assert not rig.told
        rig.poke("CR2", rig.peek("CR2") | STOP)
        assert rig.flags() == {"BUSY"}
        rig.until("STOPF")
        assert rig.flags() == {"STOPF"}
        assert not rig.peek("CR2") & STOP

    def test_txis_is_one_byte_ahead(self, rig):
        rig.begin(count=2)
        assert rig.isr("TXE", "TXIS") == [True, False]
        rig.until("TXIS")
        rig.poke("TXDR", 1)
        assert rig.isr("TXE", "TXIS") == [True, True]  # it is in the shift register already
        rig.poke("TXDR", 2)
        assert rig.isr("TXE", "TXIS") == [False, False]
        rig.until("TC")
        assert rig.isr("TXE", "TXIS") == [True, False]

    def test_scl_is_stretched_while_txdr_is_empty(self, rig, memory):
        rig.begin(count=2, more=AUTOEND)
        rig.until("TXIS")
        rig.poke("TXDR", 0x20)
        rig.clocks(50_000)
        assert [call[0] for call in memory.calls] == ["address", "write"]
        rig.poke("TXDR", 0x21)
        rig.until("STOPF")
        assert memory.data[0x20] == 0x21

    def test_no_bytes_at_all(self, rig, memory):
        rig.begin(count=0, more=AUTOEND)
        rig.until("STOPF")
        assert rig.flags() == {"STOPF"}
        assert [call[0] for call in memory.calls] == ["address", "end"]
        rig.poke("ICR", CLEAR_ALL)
        rig.begin(count=0)
        rig.until("TC")

    def test_preloaded_byte_goes_without_txis(self, rig, memory):
        rig.poke("TXDR", 0x44)
        rig.begin(count=1, more=AUTOEND)
        while not rig.isr("STOPF")[0]:
            assert not rig.isr("TXIS")[0]
            rig.clocks(1)
        assert memory.pointer == 0x44

    def test_stop_in_the_middle(self, rig):
        rig.begin(count=10)
        rig.until("TXIS")
        rig.poke("TXDR", 0x33)
        rig.clocks(100)
        rig.poke("CR2", rig.peek("CR2") | STOP)
        rig.until("STOPF")
        assert messages(rig) == [[("W", "33")]]


class TestReading:
    def test_last_byte_is_not_acknowledged(self, rig, memory):
        assert rig.fetch(3) == bytes([0, 1, 2])
        rig.until("STOPF")
        assert rig.flags() == {"STOPF"}
        assert [call[0] for call in memory.calls] == ["address", "read", "read", "read", "end"]

    def test_scl_is_stretched_while_rxdr_is_full(self, rig, memory):
        rig.begin(count=3, read=True, more=AUTOEND)
        rig.clocks(50_000)
        assert [call[0] for call in memory.calls] == ["address", "read", "read"]
        assert rig.peek("RXDR") == 0
        assert rig.isr("RXNE") == [True]  # the one that waited
        assert rig.peek("RXDR") == 1
        rig.until("RXNE")
        assert rig.peek("RXDR") == 2
        rig.until("STOPF")

    def test_register_read_by_repeated_start(self, rig):
        rig.send(0x42, more=0)
        rig.until("TC")
        assert rig.fetch(2) == bytes([0x42, 0x43])
        rig.until("STOPF")
        assert messages(rig) == [[("W", "42"), ("R", "4243")]]

    def test_start_that_was_set_early_makes_a_repeated_start(self, rig):
        rig.begin(count=1)
        rig.until("TXIS")
        rig.poke("TXDR", 7)
        rig.poke("CR2", 0x50 << 1 | READ | START | 1 << 16)
        rig.until("RXNE")
        assert rig.peek("RXDR") == 7

    def test_autoend_at_tc_stops(self, rig):
        rig.send(0x42, more=0)
        rig.until("TC")
        rig.poke("CR2", rig.peek("CR2") | AUTOEND)
        rig.until("STOPF")
        assert messages(rig) == [[("W", "42")]]

    def test_start_and_autoend_at_tc_start(self, rig):
        rig.send(0x42, more=0)
        rig.until("TC")
        rig.begin(count=1, read=True, more=AUTOEND)
        rig.until("STOPF")
        assert messages(rig) == [[("W", "42"), ("R", "42")]]

    def test_stop_in_the_middle(self, rig, memory):
        rig.begin(count=10, read=True)
        rig.until("RXNE")
        rig.clocks(100)
        rig.poke("CR2", rig.peek("CR2") | STOP)
        assert rig.peek("RXDR") == 0
        rig.until("STOPF")
        assert [call[0] for call in memory.calls] == ["address", "read", "read", "end"]


class TestReload:
    @given(sizes=st.lists(st.integers(1, 6), min_size=1, max_size=4), read=st.booleans())
    def test_blocks_are_one_message(self, make_rig, make_memory, sizes, read):
        memory = make_memory()
        rig = make_rig(memory)
        rig.enable()
        data = iter(range(200))
        sent = []
        for number, size in enumerate(sizes):
            last = number == len(sizes) - 1
            more = (AUTOEND if last else RELOAD) | size << 16
            if number:
                assert rig.until("TCR") < 5000
                rig.poke("CR2", 0x50 << 1 | read << 10 | more)
                assert not rig.isr("TCR")[0]
            else:
                rig.poke("CR2", 0x50 << 1 | read << 10 | START | more)
            for _ in range(size):
                rig.until("RXNE" if read else "TXIS")
                if read:
                    sent.append(rig.peek("RXDR"))
                else:
                    sent.append(next(data))
                    rig.poke("TXDR", sent[-1])
        rig.until("STOPF")
        assert messages(rig) == [[("R" if read else "W", bytes(sent).hex())]]
        assert len(sent) == sum(sizes)

    def test_nbytes_of_zero_leaves_it(self, rig):
        rig.send(1, 2, more=RELOAD)
        rig.until("TCR")
        rig.poke("CR2", 0x50 << 1 | RELOAD)
        assert rig.flags() == {"TCR", "BUSY"}
        rig.poke("CR2", 0x50 << 1 | STOP)
        rig.until("STOPF")
        assert rig.flags() == {"STOPF"}


class TestRefused:
    def test_address_of_nobody(self, rig):
        rig.begin(0x22, 3)
        rig.until("NACKF")
        assert rig.flags() == {"NACKF", "BUSY"}
        assert not rig.peek("CR2") & START
        rig.until("STOPF")
        assert rig.flags() == {"NACKF", "STOPF"}
        rig.poke("ICR", 1 << 4)
        assert rig.flags() == {"STOPF"}
        (told,) = rig.told
        assert not told.messages[0].acknowledged

    def test_data(self, rig, memory):
        memory.write = lambda byte, _ns: byte != 3
        rig.begin(count=5)
        for byte in (1, 2, 3, 4):
            rig.until("TXIS")
            rig.poke("TXDR", byte)
        rig.until("NACKF")
        assert rig.isr("TXE", "TXIS", "TC") == [False, False, False]
        rig.until("STOPF")
        assert messages(rig) == [[("W", "010203")]]
        rig.poke("ICR", CLEAR_ALL)
        rig.begin(count=1, more=AUTOEND)  # 4 is still in TXDR, and goes first
        rig.until("STOPF")
        assert messages(rig)[1:] == [[("W", "04")]]

    def test_txe_drops_what_is_left(self, rig, memory):
        rig.poke("TXDR", 0x55)
        assert not rig.isr("TXE")[0]
        rig.poke("ISR", 1)
        assert rig.isr("TXE")[0]
        rig.send(0x11)
        rig.until("STOPF")
        assert memory.pointer == 0x11

    def test_deaf(self, rig):
        rig.bus.deaf.add(0x50)
        rig.begin()
        rig.until("NACKF")


class TestTenBits:
    """Section 33.4.9; the bytes are those of UM10204 section 3.1.11."""

    def test_writing(self, make_rig, make_memory):
        memory = make_memory(0x7A)
        rig = make_rig(memory)
        rig.enable()
        rig.poke("CR2", 0x2A5 | ADD10 | START | AUTOEND | 1 << 16)
        rig.until("TXIS")
        assert memory.calls[-1][:2] == ("write", 0xA5)
        rig.poke("TXDR", 1)
        rig.until("STOPF")
        assert messages(rig) == [[("W", "a501")]]

    def test_reading(self, make_rig, make_memory):
        memory = make_memory(0x7A)
        rig = make_rig(memory)
        rig.enable()
        rig.poke("CR2", 0x2A5 | ADD10 | READ | START | AUTOEND | 1 << 16)
        rig.until("RXNE")
        assert rig.peek("RXDR") == 0xA5  # the memory took the second byte of the address for its pointer
        rig.until("STOPF")
        assert messages(rig) == [[("W", "a5"), ("R", "a5")]]

    def test_header_only(self, make_rig, make_memory):
        rig = make_rig(make_memory(0x7A))
        rig.enable()
        rig.poke("CR2", 0x2A5 | ADD10 | HEAD10R | READ | START | AUTOEND | 1 << 16)
        rig.until("STOPF")
        assert messages(rig) == [[("R", "00")]]

    def test_first_byte_is_sent_again_until_addrcf(self, rig):
        rig.poke("CR2", 0x2A5 | ADD10 | START | AUTOEND | 1 << 16)
        rig.clocks(10_000)
        assert rig.flags() == {"NACKF", "BUSY"}
        rig.poke("ICR", 1 << 3)
        rig.until("STOPF")
        (told,) = rig.told
        assert len(told.messages) > 3
        assert {one.address for one in told.messages} == {0x7A}


class TestPacketErrorCode:
    """SMBus: CRC-8 over all bytes, addresses too (section 33.4.12)."""

    @staticmethod
    def crc(*data):
        """Divide bit by bit."""
        register = 0
        for byte in data:
            for bit in range(7, -1, -1):
                feedback = register >> 7 ^ byte >> bit & 1
                register = register << 1 & 0xFF ^ (7 if feedback else 0)
        return register

    def test_known_value(self):
        assert self.crc(*b"123456789") == 0xF4  # CRC-8/SMBUS

    @given(data=st.binary(min_size=1, max_size=5))
    def test_is_sent_by_itself(self, make_rig, make_memory, data):
        rig = make_rig(make_memory())
        rig.enable(PECEN)
        rig.begin(count=len(data) + 1, more=PECBYTE | AUTOEND)
        for byte in data:
            rig.until("TXIS")
            rig.poke("TXDR", byte)
        rig.until("STOPF")
        assert messages(rig) == [[("W", (data + bytes([self.crc(0xA0, *data)])).hex())]]
        assert not rig.peek("CR2") & PECBYTE

    @each("wrong", [0, 1])
    def test_is_checked(self, make_rig, make_memory, wrong):
        memory = make_memory(data=bytes([5, 6, self.crc(0xA0, 0, 0xA1, 5, 6) ^ wrong]) + bytes(253))
        rig = make_rig(memory)
        rig.enable(PECEN)
        rig.send(0, more=0)
        rig.until("TC")
        assert rig.fetch(3, more=PECBYTE | AUTOEND)[:2] == bytes([5, 6])
        rig.until("STOPF")
        assert rig.flags() == {"STOPF"} | ({"PECERR"} if wrong else set())


@given(
    data=st.binary(min_size=1, max_size=12),
    start=st.integers(0, 255),
    pauses=st.lists(st.integers(0, 600), min_size=30),
)
def test_no_pace_of_software_changes_what_is_transferred(make_rig, make_memory, data, start, pauses):
    """Polling with any pauses writes and reads back the same bytes."""
    memory = make_memory(data=bytes(256))
    rig = make_rig(memory)
    rig.enable()
    pause = iter(pauses)
    rig.begin(count=len(data) + 1, more=AUTOEND)
    for byte in (start, *data):
        rig.until("TXIS")
        rig.clocks(next(pause))
        rig.poke("TXDR", byte)
    rig.until("STOPF")
    rig.poke("ICR", CLEAR_ALL)
    rig.send(start, more=0)
    rig.until("TC")
    rig.begin(count=len(data), read=True, more=AUTOEND)
    back = []
    for _ in data:
        rig.until("RXNE")
        rig.clocks(next(pause))
        back.append(rig.peek("RXDR"))
    rig.until("STOPF")
    assert bytes(back) == data
    assert rig.flags() == {"STOPF"}
