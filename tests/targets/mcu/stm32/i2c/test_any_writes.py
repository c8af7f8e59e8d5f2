"""Whatever a program writes and whenever, the interface keeps its own rules, and the bus those of UM10204."""

from __future__ import annotations

from fractions import Fraction

from hypothesis import given
from hypothesis import strategies as st

START, STOP = 1 << 13, 1 << 14
REGISTERS = ("CR1", "CR2", "TIMINGR", "TIMEOUTR", "ISR", "ICR", "TXDR", "OAR1")
TXIS, TC, TCR, BUSY = 1 << 1, 1 << 6, 1 << 7, 1 << 15

likely = st.one_of(
    st.tuples(
        st.just("CR2"),
        st.builds(
            lambda n, more: 0xA0 | START | n << 16 | more << 24 | more << 10, st.integers(0, 3), st.integers(0, 7)
        ),
    ),
    st.tuples(
        st.just("CR2"), st.sampled_from([STOP, 0xA0 | 3 << 16, 0xA0 | 1 << 16 | 1 << 25, 0xF2 | 1 << 11 | START])
    ),
    st.tuples(st.just("TXDR"), st.integers(0, 255)),
    st.tuples(st.just("ICR"), st.just(0x3F38)),
    st.tuples(st.just("CR1"), st.sampled_from([0, 1, 1 | 1 << 23, 1 | 1 << 12 | 3 << 8])),
    st.tuples(st.just("RXDR"), st.none()),
    st.tuples(st.just("TIMEOUTR"), st.sampled_from([0, 1 << 15, 1 << 15 | 5])),
)
anything = st.tuples(st.sampled_from(REGISTERS), st.integers(0, 0xFFFF_FFFF))
outside = st.tuples(st.sampled_from(["stick", "unstick", "BERR", "ARLO", "OVR", "clock", "stop", "hclk"]), st.just(0))
steps = st.lists(st.tuples(st.one_of(likely, likely, likely, anything, outside), st.integers(0, 3000)), max_size=30)


class Grammar:
    """A slave that holds the master to the order of an I2C transaction."""

    def __init__(self):
        self.state = "idle"
        self.last_ns = 0

    def _at(self, now_ns):
        assert now_ns >= self.last_ns
        self.last_ns = now_ns

    def address(self, address, read, now_ns):
        self._at(now_ns)
        assert 0 <= address <= 0x7F
        assert self.state == "idle"
        if address not in (0x50, 0x79):
            return False
        self.state = "read" if read else "write"
        return True

    def write(self, byte, now_ns):
        self._at(now_ns)
        assert self.state == "write"
        assert 0 <= byte <= 0xFF
        return byte != 0x77

    def read(self, now_ns):
        self._at(now_ns)
        assert self.state == "read"
        return 0x5A

    def end(self, now_ns):
        self._at(now_ns)
        assert self.state in ("read", "write")
        self.state = "idle"


def act(rig, name, value):
    """Write or read a register, or do something to the bus or the clock."""
    if name in ("stick", "unstick"):
        getattr(rig.bus, name)()
    elif name in ("BERR", "ARLO", "OVR"):
        rig.i2c.disturb(name)
    elif name in ("clock", "stop"):
        rig.kernel = Fraction(16_000_000 if name == "clock" else 0)
        rig.chip.change_clock()
    elif name == "hclk":
        rig.kernel = Fraction(54_000_000)
        rig.chip.change_clock(108_000_000 if rig.chip.time.hclk_hz == 216_000_000 else 216_000_000)
    elif value is None:
        rig.peek(name)
    else:
        rig.poke(name, value)


@given(steps=steps, stretch=st.sampled_from([0, 0, 3000]))
def test_rules_hold(make_rig, steps, stretch):
    rig = make_rig(Grammar())
    rig.bus.stretch_ns[0x50] = stretch
    rig.enable()
    for (name, value), cycles in steps:
        act(rig, name, value)
        rig.chip.advance(cycles)
        isr = rig.peek("ISR")
        assert isr & (TC | TCR) != TC | TCR
        if isr & (TXIS | TC | TCR):
            assert isr & BUSY
        assert rig.event.level is bool(isr & rig.peek("CR1") & 0x7E or (isr & TCR and rig.peek("CR1") & TC))
    for told in rig.told:
        assert told.begin_ns <= told.end_ns
        assert all(told.begin_ns <= message.at_ns <= told.end_ns for message in told.messages)
    rig.kernel = Fraction(54_000_000)
    rig.chip.change_clock(216_000_000)
    rig.bus.unstick()
    rig.bus.stretch_ns.clear()
    rig.enable()
    rig.poke("TIMEOUTR", 0)
    rig.told.clear()
    rig.poke("CR2", 0)
    rig.send(1, 2)
    rig.until("STOPF")
    assert [message.data for message in rig.told[0].messages] == [b"\1\2"]
