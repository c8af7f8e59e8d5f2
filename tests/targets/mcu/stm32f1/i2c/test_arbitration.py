"""Two masters of one bus whose START comes at the same cycle (RM0008 26.3.4, UM10204 3.1.7 and 3.1.8)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.each import each

START, STOP, ACK = 1 << 8, 1 << 9, 1 << 10
PE, SWRST = 1, 1 << 15
BIT = 720
MEMORY = 0x50


@pytest.fixture
def both(make_pair):
    """Two masters, which have both made a START."""
    return begun(make_pair())


def begun(pair, first="master"):
    """Let both make a START at once; which of them is heard first makes no difference to anybody."""
    rigs = [pair.master, pair.slave]
    for rig in rigs if first == "master" else reversed(rigs):
        rig.ask(START)
    for rig in rigs:
        rig.until("SB")
        assert rig.state() == {"MSL", "BUSY"}
    return pair


def until(rig, *flags):
    while not rig.flags() & {*flags, "ARLO"}:
        rig.chip.advance(4)
    rig.peek("SR1")
    return not rig.flags() & {"ARLO"}


def sends(rig, data):
    """Return whether all of this, the address first, has gone out."""
    address, *rest = data
    yield rig.poke("DR", address)
    if not until(rig, "ADDR", "AF"):
        return
    rig.clear_addr()
    for byte in rest:
        rig.poke("DR", byte)
        yield
        if not until(rig, "BTF", "AF"):
            return


class TestBytes:
    def test_who_lets_sda_go_where_it_is_low_loses(self, both):
        """0xA0 against 0xA8: the fifth bit. The loser leaves in the middle of its high, the other notices nothing."""
        winner, loser = both.master, both.slave
        winner.poke("DR", 0xA0)
        loser.poke("DR", 0xA8)
        begin = both.chip.time.now
        both.chip.advance(4 * BIT + BIT // 2 - 1)
        assert loser.flags() == set()
        both.chip.advance(1)
        assert loser.flags() == {"ARLO"}
        assert loser.state() == {"BUSY"}
        winner.until("ADDR")
        assert 9 * BIT <= both.chip.time.now - begin <= 9 * BIT + 8
        assert winner.state() == {"MSL", "BUSY", "TRA"}

    @each("first", ["master", "slave"])
    @each("better", ["master", "slave"])
    def test_the_winner_writes_the_memory(self, make_pair, first, better):
        pair = begun(make_pair(), first)
        winner = getattr(pair, better)
        loser = pair.slave if winner is pair.master else pair.master
        loser.poke("DR", MEMORY << 1 | 2)
        winner.poke("DR", MEMORY << 1)
        winner.until("ADDR")
        winner.clear_addr()
        for byte in (7, 0x77):
            winner.poke("DR", byte)
            winner.until("BTF")
        winner.ask(STOP)
        winner.until_free()
        assert loser.state() == set()
        assert loser.flags() == {"ARLO"}
        assert pair.master.eeprom.data[7] == 0x77
        (ended,) = [one for one in winner.told if one.complete]
        assert ended.messages[0].data == b"\x07\x77"

    def test_data_is_arbitrated_as_well(self, both):
        for rig in (both.master, both.slave):
            rig.poke("DR", MEMORY << 1)
        for rig in (both.master, both.slave):
            rig.until("ADDR")
            rig.clear_addr()
        both.master.poke("DR", 0x11)
        both.slave.poke("DR", 0x10)
        both.slave.until("BTF")
        assert both.master.flags() == {"ARLO"}
        assert both.master.state() == {"BUSY"}
        both.slave.poke("DR", 0x55)
        both.slave.until("BTF")
        both.slave.ask(STOP)
        both.slave.until_free()
        assert both.master.eeprom.data[0x10] == 0x55

    def test_the_same_from_both_is_one_message(self, both):
        for rig in (both.master, both.slave):
            rig.poke("DR", MEMORY << 1)
        for byte in (0x20, 0x99):
            for rig in (both.master, both.slave):
                until(rig, "ADDR", "BTF")
                rig.clear_addr()
            for rig in (both.master, both.slave):
                rig.poke("DR", byte)
        for rig in (both.master, both.slave):
            rig.until("BTF")
            rig.ask(STOP)
        for rig in (both.master, both.slave):
            rig.until_free()
            assert rig.flags() == set()
        assert both.master.eeprom.data[0x20] == 0x99
        assert [one.messages[0].data for one in both.master.told + both.slave.told] == [b"\x20\x99"]

    def test_who_is_ready_waits_for_who_is_not(self, both):
        both.master.poke("DR", 0xA0)
        both.wait(100)
        assert both.master.flags() == set()
        both.slave.poke("DR", 0xA0)
        assert 9 * BIT <= both.master.until("ADDR") <= 9 * BIT + 8

    @given(messages=st.tuples(*(st.lists(st.integers(0, 255), min_size=3, max_size=3),) * 2), swap=st.booleans())
    def test_the_lower_one_is_sent_whole(self, make_pair, messages, swap):
        pair = begun(make_pair(), "slave" if swap else "master")
        written = []
        pair.master.eeprom.address = lambda _address, _read, _ns: True
        pair.master.eeprom.write = lambda byte, _ns: written.append(byte) or True
        data = [[first & 0xFE, *rest] for first, *rest in messages]
        data = [[0xA0 if first >> 3 == 0x1E else first, *rest] for first, *rest in data]  # no 10 bits
        under_way = [sends(rig, one) for rig, one in zip((pair.master, pair.slave), data, strict=True)]
        while under_way:
            under_way = [one for one in under_way if next(one, 0) is None]
        lost = ["ARLO" in rig.flags() for rig in (pair.master, pair.slave)]
        assert lost == [data[0] > data[1], data[1] > data[0]]
        assert written == min(data)[1:]


class TestReading:
    def test_both_read_and_one_wants_no_more(self, both):
        """The acknowledge of the other wins over a NACK."""
        both.master.eeprom.data[:] = bytes(range(256))
        both.slave.ask(ACK)
        for rig in (both.master, both.slave):
            rig.poke("DR", MEMORY << 1 | 1)
        for rig in (both.master, both.slave):
            rig.until("ADDR")
            rig.clear_addr()
        both.wait(9.2)
        assert both.slave.flags() == {"RXNE"}
        assert both.master.flags() == {"ARLO"}  # it had no ACK set
        assert both.slave.peek("DR") == 0


class TestConditions:
    @pytest.mark.parametrize(
        ("master", "slave", "loses"),
        [
            ("stop", 0x00, "master"),
            ("stop", 0x80, "slave"),
            ("restart", 0x00, "master"),
            ("restart", 0x80, "slave"),
            ("stop", "restart", "slave"),
            ("restart", "restart", None),
        ],
    )
    def test_one_against_another(self, both, master, slave, loses):
        rigs = {"master": both.master, "slave": both.slave}
        for rig in rigs.values():
            rig.poke("DR", MEMORY << 1)
        for rig in rigs.values():
            rig.until("ADDR")
            rig.clear_addr()
        for rig, what in zip(rigs.values(), (master, slave), strict=True):
            if isinstance(what, int):
                rig.poke("DR", what)
            else:
                rig.ask(STOP if what == "stop" else START)
        both.wait(12)
        assert {name for name, rig in rigs.items() if "ARLO" in rig.flags()} == ({loses} if loses else set())


class TestAfterwards:
    def test_the_loser_answers_after_a_repeated_start(self, both):
        """Not in the same transfer (section 26.3.4)."""
        winner, loser = both.master, both.slave
        winner.poke("DR", both.OWN << 1)
        loser.poke("DR", 0x7E << 1)
        until(winner, "AF", "ADDR")
        assert winner.flags() == {"AF"}
        assert loser.flags() == {"ARLO"}
        winner.ask(START)
        winner.until("SB")
        winner.poke("DR", both.OWN << 1)
        until(winner, "ADDR")
        assert loser.flags() == {"ARLO", "ADDR"}

    def test_it_may_begin_anew_after_the_stop(self, both):
        winner, loser = both.master, both.slave
        winner.poke("DR", 0xA0)
        loser.poke("DR", 0xA2)
        winner.until("ADDR")
        loser.ask(START)
        both.wait(30)
        assert loser.flags() == {"ARLO"}
        winner.ask(STOP)
        loser.until("SB")
        assert loser.state() == {"MSL", "BUSY"}

    @pytest.mark.parametrize("leaves", ["master", "slave"])
    @pytest.mark.parametrize("late", [0, 3])
    def test_one_is_switched_off(self, both, leaves, late):
        rigs = {"master": both.master, "slave": both.slave}
        stays = rigs["slave" if leaves == "master" else "master"]
        for rig in rigs.values():
            rig.poke("DR", 0xA0)
            both.wait(late)
        rigs[leaves].poke("CR1", 0)
        stays.until("ADDR")
        stays.clear_addr()
        stays.poke("DR", 5)
        stays.until("BTF")
        stays.ask(STOP)
        stays.until_free()


def test_the_slower_clock_counts(make_pair):
    """SCL is low for the longest time, and high for the shortest (UM10204 section 3.1.7)."""
    pair = make_pair()
    pair.slave.poke("CR1", 0)
    pair.slave.enable(ccr=30 | 1 << 15)  # 120 cycles low, 60 high
    begun(pair)
    for rig in (pair.master, pair.slave):
        rig.poke("DR", 0xA0)
    begin = pair.chip.time.now
    while "ADDR" not in pair.master.flags():
        pair.chip.advance(1)
    assert pair.chip.time.now - begin == 9 * (360 + 60)
    assert "ADDR" in pair.slave.flags()


def test_a_start_a_cycle_later_is_too_late(pair):
    pair.master.ask(START)
    pair.chip.advance(1)
    pair.slave.ask(START)
    pair.master.until("SB")
    pair.wait(20)
    assert pair.slave.flags() == set()
    assert pair.slave.state() == {"BUSY"}
