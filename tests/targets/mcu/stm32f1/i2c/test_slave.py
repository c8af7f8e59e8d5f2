"""I2C v1 as a slave, in the order of events of RM0008 section 26.3.2, with I2C1 of the same chip as the master."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

PE, START, STOP, ACK = 1, 1 << 8, 1 << 9, 1 << 10
ITERREN, ITEVTEN, ITBUFEN = 1 << 8, 1 << 9, 1 << 10
BIT = 720


class TestReceiving:
    def test_event_by_event(self, pair):
        master, slave = pair.master, pair.slave
        master.ask(START)
        master.until("SB")
        assert slave.state() == {"BUSY"}
        master.poke("DR", pair.OWN << 1)
        pair.wait(9)
        assert slave.flags() == {"ADDR"}  # EV1
        assert slave.state() == {"BUSY"}
        assert master.flags() == {"ADDR"}
        master.clear_addr()
        master.poke("DR", 0x11)
        pair.wait(50)
        assert slave.flags() == {"ADDR"}  # which holds SCL low until it is cleared
        assert master.flags() == {"TXE"}  # nor has the master sent its byte
        slave.clear_addr()
        assert slave.flags() == set()
        pair.wait(8.9)
        assert slave.flags() == set()
        pair.wait(0.2)
        assert slave.flags() == {"RXNE"}  # EV2
        assert slave.peek("DR") == 0x11
        assert slave.flags() == set()
        master.until("BTF")
        pair.stop()
        assert slave.flags() == {"STOPF"}  # EV4
        assert slave.state() == set()
        slave.peek("SR1")
        assert slave.flags() == {"STOPF"}
        slave.poke("CR1", PE | ACK)
        assert slave.flags() == set()
        assert master.told[0].messages[0].data == b"\x11"

    def test_stopf_needs_a_read_of_sr1_before_the_write(self, pair):
        pair.address()
        pair.clear_both()
        pair.stop()
        pair.slave.poke("CR1", PE | ACK)
        assert pair.slave.flags() == {"STOPF"}
        pair.slave.clear_addr()
        pair.slave.poke("CR1", PE | ACK)
        assert pair.slave.flags() == set()

    def test_addr_needs_both_reads(self, pair):
        pair.address()
        pair.slave.peek("SR2")
        assert pair.slave.flags() == {"ADDR"}
        pair.slave.peek("SR1")
        pair.slave.peek("SR2")
        assert pair.slave.flags() == set()

    def test_addr_that_came_between_both_reads_is_cleared(self, pair):
        """Section 26.6.7: reading SR2 after SR1 clears ADDR, even if it was set after SR1 was read."""
        pair.slave.peek("SR1")
        pair.address()
        pair.slave.peek("SR2")
        assert pair.slave.flags() == set()

    def test_two_bytes_that_are_not_read_hold_scl(self, pair):
        master, slave = pair.master, pair.slave
        pair.address()
        pair.clear_both()
        for byte in (1, 2):
            master.poke("DR", byte)
            master.until("BTF")
        assert slave.flags() == {"RXNE", "BTF"}
        master.poke("DR", 3)
        pair.wait(50)
        assert "BTF" not in master.flags()
        assert slave.peek("DR") == 1
        assert slave.flags() == {"RXNE"}
        assert slave.peek("DR") == 2
        master.until("BTF")
        assert slave.peek("DR") == 3

    def test_without_ack_a_byte_is_refused(self, pair):
        master, slave = pair.master, pair.slave
        pair.address()
        pair.clear_both()
        slave.drop(ACK)
        master.poke("DR", 7)
        master.until("AF")
        assert slave.flags() == {"RXNE"}
        assert slave.peek("DR") == 7
        pair.stop()
        assert slave.flags() == set()  # no STOPF after a NACK
        assert master.told[0].messages[0].refused

    def test_a_repeated_start_ends_a_message_without_stopf(self, pair):
        master, slave = pair.master, pair.slave
        pair.address()
        pair.clear_both()
        master.poke("DR", 7)
        master.until("BTF")
        assert slave.peek("DR") == 7
        pair.address()
        assert slave.flags() == {"ADDR"}
        pair.clear_both()
        pair.stop()
        assert slave.flags() == {"STOPF"}

    @given(data=st.lists(st.integers(0, 255), min_size=1, max_size=6), late=st.integers(0, 30))
    def test_any_bytes_and_a_slave_that_takes_its_time(self, make_pair, data, late):
        pair, got = make_pair(), []
        master, slave, left = pair.master, pair.slave, list(data)
        pair.address()
        pair.clear_both()
        while len(got) < len(data):
            if left and "TXE" in master.flags():
                master.poke("DR", left.pop(0))
            pair.wait(late)
            if "RXNE" in slave.flags():
                got.append(slave.peek("DR"))
            pair.chip.advance(BIT // 2)
        assert got == data


class TestSending:
    def test_event_by_event(self, pair):
        master, slave = pair.master, pair.slave
        pair.address(read=True)
        assert slave.flags() == {"ADDR"}
        assert slave.state() == {"BUSY", "TRA"}
        pair.clear_both()
        assert slave.flags() == {"TXE"}  # EV3_1
        pair.wait(50)
        assert master.flags() == set()  # SCL is held low until DR is filled
        slave.poke("DR", 0xA1)
        assert slave.flags() == {"TXE"}  # EV3: it went to the shift register at once
        slave.poke("DR", 0xA2)
        assert slave.flags() == set()
        pair.wait(9.1)
        assert slave.flags() == {"TXE"}
        assert master.peek("DR") == 0xA1
        pair.wait(9)
        assert slave.flags() == {"TXE", "BTF"}
        assert master.peek("DR") == 0xA2
        pair.wait(50)
        assert master.flags() == set()
        master.drop(ACK)
        slave.peek("SR1")
        slave.poke("DR", 0xA3)
        assert slave.flags() == {"TXE"}
        master.until("RXNE")
        assert slave.flags() == {"TXE", "AF"}  # EV3_2
        slave.poke("SR1", 0)
        assert slave.flags() == {"TXE"}
        pair.stop()
        assert slave.flags() == set()  # no STOPF after a NACK, and TXE is cleared by the STOP
        assert slave.state() == set()
        assert master.told[0].messages[0].data == b"\xa1\xa2\xa3"

    def test_what_was_not_sent_is_forgotten(self, pair):
        master, slave = pair.master, pair.slave
        pair.address(read=True, acknowledge=False)
        pair.clear_both()
        slave.poke("DR", 1)
        slave.poke("DR", 2)
        master.until("RXNE")
        assert master.peek("DR") == 1
        pair.stop()
        slave.poke("SR1", 0)
        pair.address(read=True, acknowledge=False)
        pair.clear_both()
        assert slave.flags() == {"TXE"}
        slave.poke("DR", 3)
        master.until("RXNE")
        assert master.peek("DR") == 3
        pair.stop()
        assert [one.messages[0].data for one in master.told] == [b"\1", b"\3"]

    def test_written_before_addr_is_cleared(self, pair):
        master, slave = pair.master, pair.slave
        pair.address(read=True, acknowledge=False)
        slave.poke("DR", 0x33)
        pair.clear_both()
        master.until("RXNE")
        assert master.peek("DR") == 0x33

    def test_a_register_of_a_slave(self, pair):
        """Write its number, repeated START, read two bytes with POS: what sensors are read with."""
        master, slave = pair.master, pair.slave
        pair.address()
        pair.clear_both()
        master.poke("DR", 0x10)
        master.until("BTF")
        assert slave.peek("DR") == 0x10
        master.ask(1 << 11)
        pair.address(read=True)
        pair.clear_both()
        master.drop(ACK)
        slave.poke("DR", 0x11)
        slave.poke("DR", 0x12)
        master.until("BTF")
        assert "AF" in slave.flags()
        pair.stop()
        assert [master.peek("DR"), master.peek("DR")] == [0x11, 0x12]
        assert [message.data for message in master.told[0].messages] == [b"\x10", b"\x11\x12"]


class TestAddresses:
    @pytest.mark.parametrize("address", [0x20, 0x22, 0, 0x61])
    def test_others_are_ignored(self, pair, address):
        pair.begin(address << 1)
        assert pair.master.flags() == {"AF"}
        assert pair.slave.flags() == set()
        assert pair.slave.state() == {"BUSY"}
        pair.stop()
        assert pair.slave.state() == set()

    def test_without_ack_none_is_answered(self, pair):
        pair.slave.drop(ACK)
        pair.address()
        assert pair.master.flags() == {"AF"}
        assert pair.slave.flags() == set()

    def test_without_pe_none_is_answered(self, pair):
        pair.slave.poke("CR1", 0)
        pair.address()
        assert pair.master.flags() == {"AF"}

    def test_parts_of_the_other_bus_are_reached(self, pair):
        """An EEPROM that is soldered to I2C2, from I2C1: the buses are the same two wires."""
        pair.master.eeprom.data[0] = 0x55
        pair.slave.i2c.reset()
        pair.slave.enable()
        pair.slave.write(0x07, 0x77, address=0x50)
        assert pair.master.eeprom.data[7] == pair.slave.eeprom.data[7] == 0x77

    def test_a_bus_that_is_stuck_is_stuck_for_both(self, pair):
        pair.master.bus.stick()
        assert pair.slave.state() == pair.master.state() == {"BUSY"}
        pair.master.bus.unstick()
        assert pair.slave.state() == pair.master.state() == set()


class TestBothRoles:
    def test_start_of_a_slave_waits_for_the_stop(self, pair):
        master, slave = pair.master, pair.slave
        pair.address()
        slave.ask(START)
        pair.clear_both()
        pair.wait(20)
        assert slave.peek("CR1") & START
        pair.stop()
        begin = pair.chip.time.now
        slave.until("SB")
        assert BIT // 2 <= pair.chip.time.now - begin <= BIT + 16  # t_BUF, and the START
        assert master.state() == {"BUSY"}
        assert slave.state() == {"BUSY", "MSL"}
        assert slave.flags() == {"SB", "STOPF"}

    def test_they_change_roles(self, pair):
        master, slave = pair.master, pair.slave
        master.poke("OAR1", 0x4000 | 0x33 << 1)
        master.ask(ACK)
        pair.address()
        pair.clear_both()
        pair.stop()
        slave.clear_addr()
        slave.ask(START)
        slave.until("SB")
        slave.poke("DR", 0x33 << 1)
        slave.until("ADDR")
        assert master.flags() == {"ADDR"}
        slave.clear_addr()
        master.clear_addr()
        slave.poke("DR", 9)
        master.until("RXNE")
        assert master.peek("DR") == 9

    def test_a_slave_leaves_by_stop(self, pair):
        """Section 26.6.1, STOP in slave mode: release the lines after the current byte."""
        master, slave = pair.master, pair.slave
        pair.address()
        pair.clear_both()
        master.poke("DR", 1)
        pair.wait(2)
        slave.ask(STOP)
        master.until("BTF")
        master.poke("DR", 2)
        master.until("AF")
        assert slave.flags() == {"RXNE"}
        pair.stop()
        assert not slave.peek("CR1") & STOP
        assert slave.flags() == {"RXNE"}

    def test_a_slave_that_is_switched_off_lets_go_of_scl(self, pair):
        master, slave = pair.master, pair.slave
        pair.address()
        master.clear_addr()
        master.poke("DR", 1)
        pair.wait(20)
        assert "AF" not in master.flags()
        slave.poke("CR1", 0)
        master.until("AF")
        assert slave.flags() == set()

    def test_a_slave_that_is_switched_off_still_sees_that_the_bus_is_busy(self, pair):
        """Section 26.6.7, BUSY: it is updated while PE is 0, too."""
        master, slave = pair.master, pair.slave
        pair.address()
        slave.poke("CR1", 0)
        assert slave.state() == {"BUSY"}
        slave.poke("CR1", PE)
        slave.ask(START)
        pair.wait(30)
        assert slave.flags() == set()
        pair.stop()
        slave.until("SB")
        slave.poke("CR1", 0)
        assert slave.state() == set()
        pair.wait(3)
        master.ask(START)
        master.until("SB")
        assert slave.state() == {"BUSY"}

    def test_without_its_clock_no_address_is_answered(self, pair):
        pair.slave.i2c.clocked = False
        pair.address()
        assert pair.master.flags() == {"AF"}

    def test_a_master_that_is_switched_off_frees_the_bus(self, pair):
        pair.address()
        pair.master.poke("CR1", 0)
        assert pair.slave.state() == set()

    def test_a_busy_bus_is_waited_for(self, pair):
        pair.slave.ask(START)
        pair.slave.until("SB")
        pair.master.ask(START)
        pair.wait(50)
        assert pair.master.flags() == set()
        assert pair.master.peek("CR1") & START


class TestLines:
    def test_events_and_errors(self, make_pair):
        pair = make_pair(slave_cr2=ITEVTEN | ITERREN)
        slave = pair.slave
        pair.address(read=True, acknowledge=False)
        assert slave.event.level
        pair.clear_both()
        assert not slave.event.level  # TXE asks by ITBUFEN alone
        slave.poke("CR2", 36 | ITEVTEN | ITBUFEN | ITERREN)
        assert slave.event.level
        slave.poke("DR", 1)
        slave.poke("DR", 2)
        assert not slave.event.level
        pair.master.until("RXNE")
        assert slave.error.level
        slave.poke("SR1", 0)
        assert not slave.error.level
        pair.stop()
        pair.address()
        pair.clear_both()
        pair.stop()
        assert slave.event.level  # STOPF

    def test_a_part_is_no_interface(self, pair):
        """The EEPROM of the bus and the slave do not disturb each other."""
        pair.master.write(1, 2)
        assert pair.slave.flags() == set()
        assert pair.master.eeprom.data[1] == 2
