"""When each flag comes, in clocks of the kernel, against the formulas of RM0410 sections 33.4.5 and 33.4.9."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.stm32.i2c_timing import Timing

AUTOEND, RELOAD, START, STOP = 1 << 25, 1 << 24, 1 << 13, 1 << 14
READ = 1 << 10
ANFOFF = 1 << 12
KERNEL = 54_000_000


class Clocks:
    """The formulas, in whole clocks of the kernel, without the analog filter."""

    def __init__(self, presc, scldel, sdadel, sclh, scll, dnf=0):
        self.register = presc << 28 | scldel << 20 | sdadel << 16 | sclh << 8 | scll
        self.cr1 = dnf << 8
        tick, sync = presc + 1, 2 + dnf
        self.low = sync + max((scll + 1) * tick, sdadel * tick + 1 + (scldel + 1) * tick)
        self.high = sync + (sclh + 1) * tick
        self.bit = self.low + self.high
        self.hold = (sclh + 1) * tick
        self.free = (scll + 1) * tick
        self.byte = 9 * self.bit
        self.restart = self.low + sync + (scll + 1) * tick


FAST = Clocks(0, 3, 0, 28, 52)

settings = st.builds(
    Clocks,
    st.integers(0, 15),
    st.integers(0, 15),
    st.integers(0, 15),
    st.integers(0, 255),
    st.integers(0, 255),
    st.integers(0, 15),
)


@given(clocks=settings)
def test_formulas(clocks):
    timing = Timing.of(clocks.register, clocks.cr1 | ANFOFF, Fraction(KERNEL), Fraction(4 * KERNEL))
    expected = (4, clocks.low, clocks.high, clocks.hold, clocks.restart, clocks.free)
    assert (timing.cycles, timing.low, timing.high, timing.hold, timing.restart, timing.free) == expected


def test_analog_filter_adds_to_both_halves():
    with_it = Timing.of(0x0010_2030, 0, Fraction(KERNEL), Fraction(KERNEL))
    without = Timing.of(0x0010_2030, ANFOFF, Fraction(KERNEL), Fraction(KERNEL))
    assert with_it.low - without.low == with_it.high - without.high == 6  # 100 ns are 5.4 clocks of 54 MHz
    assert with_it.hold == without.hold


def test_a_register_for_400_khz_gives_that():
    """TIMINGR as boards with this chip use it for 400 kHz at 54 MHz; it leaves room for slopes, which are none here."""
    timing = Timing.of(0x6000_030D, 0, Fraction(KERNEL), Fraction(KERNEL))
    assert KERNEL / timing.bit == pytest.approx(400_000, rel=0.05)


@given(clocks=settings)
def test_when_the_flags_of_a_write_come(make_rig, make_memory, clocks):
    rig = make_rig(make_memory())
    rig.enable(clocks.cr1, clocks.register)
    rig.begin(count=2, more=AUTOEND)
    assert rig.until("BUSY") == 0
    assert rig.until("TXIS") == clocks.hold + clocks.byte
    rig.poke("TXDR", 1)
    rig.poke("TXDR", 2)
    assert rig.until("TXE") == clocks.byte
    assert rig.until("STOPF") == clocks.byte + clocks.bit


@given(clocks=settings)
def test_when_the_flags_of_a_read_come(make_rig, make_memory, clocks):
    rig = make_rig(make_memory())
    rig.enable(clocks.cr1, clocks.register)
    rig.begin(count=2, read=True)
    assert rig.until("RXNE") == clocks.hold + clocks.byte + 8 * clocks.bit
    rig.peek("RXDR")
    assert rig.until("RXNE") == clocks.byte
    assert rig.until("TC") == clocks.bit


def test_slaves_are_called_at_the_ninth_clock(rig, memory):
    begun = rig.chip.time.now
    rig.send(1, 2)
    rig.until("STOPF")

    def at(clocks):
        return rig.chip.time.ns(begun + 4 * clocks)

    times = [call[-1] for call in memory.calls]
    byte = FAST.byte
    assert times == [at(FAST.hold + n * byte) for n in (1, 2, 3)] + [at(FAST.hold + 3 * byte + FAST.bit)]
    (told,) = rig.told
    assert (told.begin_ns, told.end_ns) == (at(0), times[-1])


def test_repeated_start(rig):
    rig.send(1, more=0)
    rig.until("TC")
    rig.begin(count=1, read=True)
    assert rig.until("RXNE") == FAST.restart + FAST.hold + FAST.byte + 8 * FAST.bit


def test_next_start_waits_for_the_bus_to_be_free(rig):
    rig.send(1)
    rig.until("STOPF")
    rig.begin()
    assert not rig.isr("BUSY")[0]
    assert rig.until("BUSY") == FAST.free


def test_start_that_waits_for_the_stop(rig):
    rig.begin(count=0, more=AUTOEND)
    rig.clocks(FAST.hold + FAST.byte)
    rig.begin(count=0)
    assert rig.until("STOPF") == FAST.bit
    assert not rig.isr("BUSY")[0]
    assert rig.until("BUSY") == FAST.free
    rig.until("TC")


def test_edges_fall_on_the_first_cycle_not_before_them(make_rig, make_memory):
    """A kernel clock of 16 MHz beside an HCLK of 216 MHz: 13.5 cycles a clock, and nothing adds up."""
    rig = make_rig(make_memory())
    rig.kernel = Fraction(16_000_000)
    rig.enable()
    rig.begin(count=3, more=AUTOEND)
    begun = rig.chip.time.now
    rig.until("TXIS")
    for byte in (1, 2):
        rig.poke("TXDR", byte)
    rig.until("TXE")
    rig.poke("TXDR", 3)
    rig.until("STOPF")
    clocks = FAST.hold + 4 * FAST.byte + FAST.bit
    # TXDR was written within the cycle of TXIS: what follows begins at that cycle, later by less than one
    late = rig.chip.time.now - begun - Fraction(27, 2) * clocks
    assert 0 <= late < 2


class TestChangesOfTheClock:
    def test_what_is_left_goes_on_at_the_new_rate(self, rig):
        rig.begin(count=0)
        rig.clocks(FAST.hold + 100)
        rig.chip.change_clock()
        rig.kernel /= 2
        rig.chip.change_clock()
        assert rig.until("TC") == 2 * (FAST.byte - 100)

    def test_it_waits_while_the_clock_stands_still(self, rig):
        rig.begin(count=0)
        rig.clocks(FAST.hold + 100)
        rig.kernel = Fraction(0)
        rig.chip.change_clock()
        rig.clocks(100_000)
        assert rig.flags() == {"BUSY"}
        rig.kernel = Fraction(KERNEL)
        rig.chip.change_clock()
        assert rig.until("TC") == FAST.byte - 100

    def test_nothing_begins_while_it_stands_still(self, rig):
        rig.kernel = Fraction(0)
        rig.chip.change_clock()
        rig.begin(count=0)
        rig.clocks(100_000)
        assert rig.flags() == set()
        rig.kernel = Fraction(KERNEL)
        rig.chip.change_clock()
        assert rig.until("TC") == FAST.hold + FAST.byte

    def test_hclk_is_nothing_to_it(self, rig):
        rig.begin(count=0)
        rig.clocks(FAST.hold + 100)
        begun_s = rig.chip.time.seconds(rig.chip.time.now)
        rig.chip.change_clock(108_000_000)
        while not rig.isr("TC")[0]:
            rig.chip.advance(1)
        took_s = rig.chip.time.seconds(rig.chip.time.now) - begun_s
        assert took_s == Fraction(FAST.byte - 100, KERNEL)


class TestSlaveThatStretches:
    def test_each_byte_begins_later(self, rig):
        rig.bus.stretch_ns[0x50] = 10_000  # 540 clocks
        rig.send(1, 2, more=0)
        assert rig.isr("TXE")[0] is False
        rig.until("TC")
        begun = rig.told
        assert begun == []
        rig.poke("CR2", STOP)
        assert rig.until("STOPF") == 540 + FAST.bit

    def test_software_that_is_slower_hides_it(self, rig):
        rig.bus.stretch_ns[0x50] = 10_000
        rig.begin(count=1)
        rig.until("TXIS")
        rig.clocks(1000)
        rig.poke("TXDR", 1)
        assert rig.until("TC") == FAST.byte
