"""The RTC by RM0008 section 18: counting, what is written when, flags at their ticks, clocks, resets, years."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.stm32f1.rtc import Rtc
from targets.mcu.testing import FakeChip, peek, poke

SECF, ALRF, OWF, RSF, CNF, RTOFF = (1 << bit for bit in range(6))
HZ = 32_768
WORD = 0xFFFF_FFFF


class Rig:
    """The RTC on a crystal, HCLK 8 MHz."""

    def __init__(self, hz=HZ):
        self.chip = FakeChip(8_000_000)
        self.hz = Fraction(hz)
        self.open, self.left_out = True, 0
        self.alarms = []
        self.rtc = self.chip.add(
            Rtc(
                0x4000_2800,
                self.chip.services,
                rtc_hz=lambda: self.hz,
                backup_writable=lambda: self.open,
                calibration=lambda: self.left_out,
            )
        )
        self.rtc.on_alarm = lambda: self.alarms.append(self.chip.time.now)
        self.rtc.reset_backup()
        self.rtc.clock_changed()
        self.irq = self.chip.irq(3)

    def peek(self, register):
        return peek(self.rtc, register)

    def poke(self, register, value):
        poke(self.rtc, register, value)

    def configure(self, *, ticks=5, **values):
        """Write as the manual's procedure says, and wait."""
        self.poke("CRL", self.peek("CRL") | CNF)
        for name, value in values.items():
            self.poke(f"{name}H", value >> 16)
            self.poke(f"{name}L", value & 0xFFFF)
        self.poke("CRL", self.peek("CRL") & ~CNF)
        self.ticks(ticks)

    def ticks(self, count):
        self.chip.advance_to(-(-(self.chip.time.now * HZ // 8_000_000 + count) * 8_000_000 // HZ))

    def seconds(self, count):
        self.chip.advance(round(count * 8_000_000))

    @property
    def count(self):
        return self.peek("CNTH") << 16 | self.peek("CNTL")

    @property
    def left(self):
        return self.peek("DIVH") << 16 | self.peek("DIVL")

    def flags(self):
        names = ("SECF", "ALRF", "OWF", "RSF", "CNF", "RTOFF")
        return {name for bit, name in enumerate(names) if self.peek("CRL") >> bit & 1}


@pytest.fixture
def rig():
    return Rig()


@pytest.fixture(scope="session")
def make_rig():
    """The class."""
    return Rig


def test_after_a_reset_of_the_backup_domain(rig):
    assert rig.flags() == {"RTOFF"}
    assert (rig.count, rig.left) == (0, 0x8000)
    assert [rig.peek(name) for name in ("PRLH", "PRLL", "ALRH", "ALRL")] == [0] * 4  # write-only


def test_it_counts_seconds(rig):
    rig.configure(PRL=HZ - 1, ticks=3)
    assert (rig.count, rig.left) == (0, HZ - 1)
    rig.seconds(0.5)
    assert (rig.count, rig.left) == (0, HZ - 1 - HZ // 2)
    rig.seconds(0.5)
    assert (rig.count, rig.left) == (1, HZ - 1)
    rig.seconds(59)
    assert rig.count == 60


def test_what_is_written_counts_three_ticks_after_cnf_was_cleared(rig):
    rig.configure(CNT=0x1234_5678, ticks=2)
    assert rig.flags() == {"RSF"}  # the operation goes on
    assert rig.count == 0
    rig.ticks(1)
    assert rig.flags() == {"RTOFF", "RSF"}
    assert rig.count == 0x1234_5678


def test_a_half_alone_may_be_written(rig):
    rig.configure(CNT=0x1234_5678)
    rig.poke("CRL", CNF)
    rig.poke("CNTL", 0xAAAA)
    rig.poke("CRL", 0)
    rig.ticks(5)
    assert rig.count == 0x1234_AAAA


def test_outside_of_configuration_mode_nothing_is_written(rig):
    rig.poke("CNTL", 5)
    rig.configure(CNT=7, ticks=1)
    rig.poke("CRL", CNF)
    rig.poke("CNTL", 9)
    rig.ticks(10)
    assert rig.count == 7
    assert rig.chip.noted("misuse") == ["RTC_CNTL"]


def test_the_backup_domain_has_to_be_open(rig):
    rig.open = False
    rig.poke("CRH", 7)
    rig.configure(CNT=7)
    assert (rig.peek("CRH"), rig.count) == (0, 0)
    assert "RTC_CRH" in rig.chip.noted("misuse")


def test_a_second_is_told_a_tick_before_it_is_counted(rig):
    """Figure 180, with PRL = 3: flags on the last RTCCLK cycle before the counter changes."""
    rig.configure(PRL=3, ALR=4, ticks=3)
    rig.poke("CRL", 0)
    seen = []
    for _ in range(24):
        rig.ticks(1)
        seen.append((rig.count, rig.flags() & {"SECF", "ALRF"}))
        if "SECF" in rig.flags():
            rig.poke("CRL", ~SECF & 0x1F & ~CNF)
    assert [count for count, _ in seen] == [(n + 1) // 4 for n in range(24)]
    assert [n % 4 for n, (_, flags) in enumerate(seen) if "SECF" in flags] == [2] * 6
    assert next(n for n, (_, flags) in enumerate(seen) if "ALRF" in flags) == 18  # the end of second 4


def test_an_alarm(rig):
    edges = rig.chip.output("EXTI17").edges
    rig.configure(PRL=HZ - 1, ALR=9)
    rig.poke("CRH", ALRF)
    rig.seconds(9.9)
    assert "ALRF" not in rig.flags()
    rig.seconds(0.2)
    assert "ALRF" in rig.flags()
    assert rig.irq.level
    assert len(rig.alarms) == 1
    assert [level for _, level in edges] == [True, False]
    rig.poke("CRL", 0)
    assert not rig.irq.level
    rig.seconds(100)
    assert len(rig.alarms) == 1


def test_an_overflow(rig):
    rig.configure(PRL=HZ - 1, CNT=WORD - 1)
    rig.poke("CRH", OWF)
    rig.seconds(1.9)
    assert not rig.irq.level
    assert rig.count == WORD
    rig.seconds(0.2)
    assert rig.irq.level
    assert rig.count == 0


@pytest.mark.parametrize("enable", [0, SECF, ALRF, OWF, 7])
def test_interrupts(rig, enable):
    rig.configure(PRL=HZ - 1, ALR=0, CNT=0)
    rig.poke("CRH", enable)
    rig.seconds(2)
    assert rig.irq.level is bool(enable & (SECF | ALRF))


def test_flags_are_cleared_by_zero_and_cannot_be_set(rig):
    rig.configure(PRL=HZ - 1)
    rig.seconds(1.5)
    rig.poke("CRL", 0xF)
    assert "SECF" in rig.flags()
    assert "OWF" not in rig.flags()
    rig.poke("CRL", 0xF & ~SECF)
    assert "SECF" not in rig.flags()


def test_synchronisation(rig):
    rig.ticks(2)
    assert "RSF" in rig.flags()
    rig.poke("CRL", 0)
    assert "RSF" not in rig.flags()
    rig.ticks(1)
    assert "RSF" in rig.flags()


def test_a_reset_of_the_chip_reaches_the_control_registers_alone(rig):
    rig.configure(PRL=HZ - 1, CNT=100, ALR=105)
    rig.poke("CRH", 7)
    rig.seconds(2)
    rig.rtc.reset()
    assert (rig.peek("CRH"), rig.flags(), rig.count) == (0, {"RTOFF"}, 102)
    rig.seconds(5)
    assert "ALRF" in rig.flags()


def test_without_a_clock_it_stands_still_and_nothing_is_ever_written(rig):
    rig.configure(PRL=HZ - 1, CNT=5)
    rig.seconds(3)
    rig.hz = None
    rig.rtc.clock_changed()
    rig.seconds(1000)
    assert rig.count == 8
    rig.poke("CRL", CNF)
    rig.poke("CNTL", 1)
    rig.poke("CRL", 0)
    rig.seconds(1)
    assert "RTOFF" not in rig.flags()
    rig.hz = Fraction(HZ)
    rig.rtc.clock_changed()
    rig.seconds(0.001)
    assert "RTOFF" in rig.flags()


def test_calibration_leaves_pulses_out(rig):
    rig.configure(PRL=HZ - 1)
    rig.left_out = 127
    rig.rtc.clock_changed()
    rig.seconds(1_000_000)
    assert rig.count == int(1_000_000 * (1 - Fraction(127, 1 << 20)))


def test_a_year_costs_next_to_nothing(rig):
    """Seconds are exact, whatever else; the flag of the second is set once and stays."""
    rig.configure(PRL=HZ - 1, ALR=365 * 86_400 - 1, CNT=0)
    events = 0
    end = rig.chip.time.now + 365 * 86_400 * 8_000_000
    while (due := rig.chip.time.next_cycle()) is not None and due <= end:
        rig.chip.advance_to(due)
        events += 1
    rig.chip.advance_to(end)
    assert rig.count == 365 * 86_400
    assert len(rig.alarms) == 1
    assert events < 10


def test_an_alarm_136_years_away_comes(rig):
    rig.configure(PRL=HZ - 1, ALR=WORD, CNT=0)
    while not rig.alarms:
        rig.chip.advance_to(rig.chip.time.next_cycle())
    assert rig.alarms[0] // 8_000_000 == WORD + 1  # with the end of that second


@given(
    prescaler=st.integers(1, 0xF_FFFF),
    count=st.integers(0, WORD),
    alarm_in=st.integers(0, 50),
    look=st.integers(0, 1 << 22),
)
def test_the_counter_is_arithmetic(make_rig, prescaler, count, alarm_in, look):
    rig = make_rig()
    rig.configure(PRL=prescaler, CNT=count, ALR=count + alarm_in & WORD, ticks=3)
    rig.ticks(look)
    period = prescaler + 1
    assert rig.count == count + look // period & WORD
    assert rig.left == prescaler - look % period
    assert bool(rig.alarms) is (look >= (alarm_in + 1) * period - 1)


@given(writes=st.lists(st.tuples(st.integers(0, 9), st.integers(0, 0xFFFF), st.integers(0, 9))))
def test_no_writes_break_it(make_rig, writes):
    rig = make_rig()
    names = [register.name for register in Rtc.REGISTERS]
    for number, value, ticks in writes:
        rig.poke(names[number], value)
        rig.ticks(ticks)
        for name in names:
            assert 0 <= rig.peek(name) <= 0xFFFF
