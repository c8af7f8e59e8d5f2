"""The RTC: what a program sees of it, at exact bench times of its own clock."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from targets.mcu.stm32.rtc import Rtc
from targets.mcu.stm32.rtc_calendar import DAY, Alarm, date_of, date_register, seconds_of, time_register
from targets.mcu.testing import FakeChip, peek, poke
from tests.share import examples

LSE = Fraction(32_768)
TICK = 1 / LSE
INIT, INITF, RSF, INITS, SHPF, WUTWF, ALRBWF, ALRAWF = 0x80, 0x40, 0x20, 0x10, 8, 4, 2, 1
ALRAF, ALRBF, WUTF, TSF, TSOVF, RECALPF = 1 << 8, 1 << 9, 1 << 10, 1 << 11, 1 << 12, 1 << 16
BYPSHAD, FMT, ALRAE, ALRBE, WUTE, TSE = 1 << 5, 1 << 6, 1 << 8, 1 << 9, 1 << 10, 1 << 11
ALRAIE, ALRBIE, WUTIE, TSIE, ADD1H, SUB1H = (1 << bit for bit in range(12, 18))
EVERY_SECOND = 0x8080_8080


class Bench:
    """An RTC on a crystal, 32 cycles of HCLK to a tick."""

    def __init__(self):
        self.chip = FakeChip(hclk_hz=1_048_576)
        self.hz = LSE
        self.open = True
        self.woken = 0
        rtc = Rtc(0x4000_2800, self.chip.services, rtc_hz=lambda: self.hz, backup_writable=lambda: self.open)
        self.rtc = self.chip.add(rtc)
        rtc.on_wake = self._wake
        rtc.reset()

    def _wake(self):
        self.woken += 1

    def peek(self, name):
        return peek(self.rtc, name)

    def poke(self, name, value):
        poke(self.rtc, name, value)

    def unlock(self):
        self.poke("WPR", 0xCA)
        self.poke("WPR", 0x53)

    def ticks(self, count):
        self.chip.advance_s(count * TICK)

    def begin(self, time, date=0x2101, control=0):
        """Set time and date as drivers do; the calendar counts from now on."""
        self.unlock()
        self.poke("ISR", 0xFFFF_FFFF)
        self.ticks(2)
        assert self.peek("ISR") & INITF
        self.poke("CR", control)
        self.poke("TR", time)
        self.poke("DR", date)
        self.poke("ISR", 0xFFFF_FF7F)
        self.ticks(4)

    def now(self):
        """Return time and date, without shadow registers."""
        self.poke("CR", self.peek("CR") | BYPSHAD)
        return self.peek("TR"), self.peek("DR")

    @property
    def seconds(self):
        return self.chip.time.seconds(self.chip.time.now)


@pytest.fixture
def bench():
    return Bench()


class TestProtection:
    def test_reset_values(self, bench):
        bench.ticks(2)
        assert bench.peek("ISR") == 0x27
        names = ("TR", "SSR", "DR", "CR", "PRER", "WUTR", "ALRMAR", "CALR", "WPR", "TSTR")
        assert [bench.peek(name) for name in names] == [0, 0xFF, 0x2101, 0, 0x7F_00FF, 0xFFFF, 0, 0, 0, 0]

    def test_it_is_locked(self, bench):
        bench.poke("CR", ALRAE)
        bench.poke("ISR", INIT)
        bench.ticks(10)
        assert bench.peek("CR") == 0
        assert not bench.peek("ISR") & (INIT | INITF)
        assert bench.chip.noted("misuse") == ["RTC_WPR"]

    @pytest.mark.parametrize(
        "keys", [[0xCA], [0x53], [0x53, 0xCA], [0xCA, 0x53, 0xFF], [0xCA, 0x00, 0x53], [0xCA, 0x53, 0xCA]]
    )
    def test_other_keys(self, bench, keys):
        for key in keys:
            bench.poke("WPR", key)
        bench.poke("CR", FMT)
        assert bench.peek("CR") == 0

    def test_the_keys(self, bench):
        bench.unlock()
        bench.poke("CR", FMT)
        assert bench.peek("CR") == FMT
        bench.poke("WPR", 0xFF)
        bench.poke("CR", 0)
        assert bench.peek("CR") == FMT

    def test_backup_registers_need_no_key_but_the_domain_open(self, bench):
        bench.poke("BKP31R", 0xDEAD_BEEF)
        assert bench.peek("BKP31R") == 0xDEAD_BEEF
        bench.open = False
        bench.poke("BKP31R", 0)
        assert bench.peek("BKP31R") == 0xDEAD_BEEF
        assert bench.chip.noted("misuse") == ["RTC_DBP"]

    def test_time_only_in_initialization_mode(self, bench):
        bench.unlock()
        for name in ("TR", "DR", "PRER"):
            bench.poke(name, 0x12)
        assert bench.now() == (0, 0x2101)
        assert bench.peek("PRER") == 0x7F_00FF
        assert bench.chip.noted("misuse") == ["RTC_TR", "RTC_DR", "RTC_PRER"]

    def test_what_is_enabled_cannot_be_written(self, bench):
        bench.unlock()
        bench.poke("CR", ALRAE | WUTE)
        assert bench.peek("ISR") & 7 == ALRBWF
        bench.poke("ALRMAR", 1)
        bench.poke("ALRMASSR", 1)
        bench.poke("WUTR", 1)
        bench.poke("ALRMBR", 5)
        assert [bench.peek(name) for name in ("ALRMAR", "ALRMASSR", "WUTR", "ALRMBR")] == [0, 0, 0xFFFF, 5]
        bench.poke("CR", 0)
        assert bench.peek("ISR") & 7 == ALRBWF
        bench.ticks(2)
        assert bench.peek("ISR") & 7 == 7


class TestCalendar:
    def test_initialization_takes_two_ticks(self, bench):
        bench.unlock()
        bench.poke("ISR", 0xFFFF_FFFF)
        bench.ticks(Fraction(19, 10))
        assert bench.peek("ISR") & (INIT | INITF) == INIT
        bench.ticks(Fraction(2, 10))
        assert bench.peek("ISR") & (INIT | INITF | RSF) == INIT | INITF

    def test_it_stands_still_meanwhile(self, bench):
        bench.unlock()
        bench.poke("ISR", 0xFFFF_FFFF)
        bench.chip.advance_s(Fraction(5))
        bench.poke("TR", 0x12_3456)
        bench.chip.advance_s(Fraction(5))
        assert bench.now()[0] == 0x12_3456

    def test_seconds(self, bench):
        bench.begin(0x23_5958, 0x99_B231)
        bench.chip.advance_s(Fraction(1))
        assert bench.now() == (0x23_5959, 0x99_B231)
        assert bench.peek("ISR") & INITS
        bench.chip.advance_s(Fraction(1) - TICK)
        assert (bench.now(), bench.peek("SSR")) == ((0x23_5959, 0x99_B231), 0)
        bench.ticks(1)
        assert (bench.now(), bench.peek("SSR")) == ((0, 0xC101), 0xFF)

    def test_sub_seconds_count_down(self, bench):
        bench.begin(0)
        bench.now()
        bench.chip.advance_s(Fraction(1, 4))
        assert bench.peek("SSR") == 255 - 64

    def test_other_prescalers(self, bench):
        bench.unlock()
        bench.poke("ISR", 0xFFFF_FFFF)
        bench.ticks(2)
        bench.poke("PRER", 0x7FFF)
        bench.poke("PRER", 0x00_7FFF)
        bench.poke("ISR", 0xFFFF_FF7F)
        bench.ticks(4 + 100)
        bench.now()
        assert bench.peek("SSR") == 0x7FFF - 100

    @pytest.mark.parametrize(
        ("register", "later", "expected"),
        [
            (0x12_0000, 0, 0x12_0000),  # midnight: 12 AM
            (0x52_0000, 0, 0x52_0000),  # noon: 12 PM
            (0x11_5959, 1, 0x52_0000),
            (0x51_5959, 1, 0x12_0000),
            (0x52_5959, 1, 0x41_0000),
        ],
    )
    def test_half_days(self, bench, register, later, expected):
        bench.begin(register, control=FMT)
        bench.chip.advance_s(Fraction(later))
        assert bench.now()[0] == expected

    def test_summer_time(self, bench):
        bench.begin(0x23_3000, 0x24_6228)
        bench.poke("CR", ADD1H | 1 << 18)
        assert bench.now() == (0x00_3000, 0x24_8229)
        bench.poke("CR", SUB1H)
        assert bench.now() == (0x23_3000, 0x24_6228)

    def test_shadow_registers_stand_still_until_the_date_is_read(self, bench):
        bench.begin(0x10_0000)
        assert bench.peek("ISR") & RSF
        assert bench.peek("SSR") == 0xFF
        bench.chip.advance_s(Fraction(DAY))
        assert (bench.peek("TR"), bench.peek("DR")) == (0x10_0000, 0x2101)
        assert (bench.peek("TR"), bench.peek("DR")) == (0x10_0000, 0x4102)

    def test_rsf(self, bench):
        bench.ticks(10)
        bench.poke("ISR", 0xFFFF_FFFF & ~RSF & ~INIT)
        assert not bench.peek("ISR") & RSF
        bench.ticks(2)
        assert bench.peek("ISR") & RSF

    def test_a_reset_of_the_chip(self, bench):
        bench.begin(0x10_0000, 0x24_0708)
        bench.rtc.reset()
        assert not bench.peek("ISR") & RSF
        assert (bench.peek("TR"), bench.peek("SSR"), bench.peek("DR")) == (0, 0, 0x2101)
        bench.chip.advance_s(Fraction(10))
        assert bench.peek("ISR") & RSF
        assert bench.peek("TR") == 0x10_0010

    def test_a_reset_of_the_backup_domain(self, bench):
        bench.begin(0x10_0000, 0x24_0708, control=ALRAE)
        bench.poke("BKP0R", 7)
        bench.rtc.reset_backup()
        assert bench.now() == (0, 0x2101)
        assert (bench.peek("CR"), bench.peek("BKP0R"), bench.peek("ISR")) == (0, 0, 7)
        bench.chip.advance_s(Fraction(2))
        assert bench.peek("ISR") & ALRAF == 0

    def test_its_clock_may_stop_and_change(self, bench):
        bench.begin(0)
        bench.chip.advance_s(Fraction(5, 2))
        bench.hz = None
        bench.rtc.clock_changed()
        bench.chip.advance_s(Fraction(100))
        assert bench.now()[0] == 2
        bench.hz = LSE / 2
        bench.rtc.clock_changed()
        bench.chip.advance_s(Fraction(1) - TICK)
        assert bench.now()[0] == 2
        bench.ticks(2)
        assert bench.now()[0] == 3

    def test_hclk_is_all_the_same(self, bench):
        bench.begin(0)
        bench.chip.advance_s(Fraction(1, 2))
        bench.chip.change_clock(hclk_hz=32_000_000)
        bench.chip.advance_s(Fraction(1, 2) - TICK)
        assert bench.now()[0] == 0
        bench.ticks(1)
        assert bench.now()[0] == 1

    def test_without_a_clock_nothing_is_ever_ready(self, bench):
        bench.hz = None
        bench.rtc.clock_changed()
        bench.unlock()
        bench.poke("ISR", 0xFFFF_FFFF)
        bench.chip.advance_s(Fraction(10))
        assert not bench.peek("ISR") & INITF
        bench.hz = LSE
        bench.rtc.clock_changed()
        bench.ticks(2)
        assert bench.peek("ISR") & INITF


class TestAlarms:
    def alarm(self, bench, value, sub_seconds=0, control=ALRAE | ALRAIE):
        bench.poke("ALRMAR", value)
        bench.poke("ALRMASSR", sub_seconds)
        bench.poke("CR", control)

    def seconds_to(self, bench, flag, limit=Fraction(400 * DAY)):
        began, end = bench.seconds, bench.seconds + limit
        while not bench.peek("ISR") & flag:
            due = bench.chip.time.next_cycle()
            if due is None or bench.chip.time.seconds(due) > end:
                return None
            bench.chip.advance_to(due)
        return bench.seconds - began

    @pytest.mark.parametrize(
        ("value", "expected"),
        [
            (0x8010_0030, 30),
            (0x8010_0000, DAY),
            (EVERY_SECOND, 1),
            (0x8080_8005, 5),
            (0x8080_0100, 60),
            (0x0211_0000, DAY + 3600),  # on the second
            (0x4111_0000, 3600),  # Mondays
            (0x4311_0000, 2 * DAY + 3600),  # Wednesdays
            (0x3110_0000, 30 * DAY),
            (0x0080_8080, None),
        ],
    )
    def test_when(self, bench, value, expected):
        bench.begin(0x10_0000)
        self.alarm(bench, value)
        assert self.seconds_to(bench, ALRAF) == expected

    def test_the_half_of_the_day_counts(self, bench):
        bench.begin(0x10_0000, control=FMT)
        self.alarm(bench, 0x8051_0000, control=FMT | ALRAE)
        assert self.seconds_to(bench, ALRAF) == 13 * 3600

    @pytest.mark.parametrize(
        ("sub_seconds", "expected"),
        [(15 << 24 | 127, Fraction(1, 2)), (15 << 24 | 255, 1), (6 << 24 | 63, Fraction(1, 4)), (15 << 24 | 999, None)],
    )
    def test_sub_seconds(self, bench, sub_seconds, expected):
        bench.begin(0x10_0000)
        self.alarm(bench, EVERY_SECOND, sub_seconds)
        assert self.seconds_to(bench, ALRAF, Fraction(5)) == expected

    def test_it_comes_again(self, bench):
        bench.begin(0)
        self.alarm(bench, EVERY_SECOND, 8 << 24)
        times = []
        for _ in range(3):
            times.append(self.seconds_to(bench, ALRAF))
            bench.poke("ISR", 0xFFFF_FFFF & ~ALRAF & ~INIT)
        assert times == [Fraction(255, 256), 1, 1]

    def test_interrupts(self, bench):
        bench.begin(0)
        bench.poke("ALRMBR", EVERY_SECOND)
        self.alarm(bench, 0x8080_8002, control=ALRAE | ALRAIE | ALRBE)
        line = bench.chip.output("EXTI17")
        bench.chip.advance_s(Fraction(1))
        assert bench.peek("ISR") & (ALRAF | ALRBF) == ALRBF
        assert (line.level, bench.woken) == (False, 0)
        bench.poke("CR", bench.peek("CR") | ALRBIE)
        assert line.level
        bench.poke("ISR", 0xFFFF_FFFF & ~ALRBF & ~INIT)
        assert not line.level
        bench.chip.advance_s(Fraction(1))
        assert line.level
        assert bench.peek("ISR") & (ALRAF | ALRBF) == ALRAF | ALRBF
        assert bench.woken == 2

    def test_disabled_it_never_comes(self, bench):
        bench.begin(0)
        self.alarm(bench, EVERY_SECOND)
        bench.poke("CR", 0)
        assert self.seconds_to(bench, ALRAF, Fraction(5)) is None

    def test_setting_the_time_looks_for_it_anew(self, bench):
        bench.begin(0x10_0000)
        self.alarm(bench, 0x8012_0000)
        bench.begin(0x11_5950, control=ALRAE)
        assert self.seconds_to(bench, ALRAF) == 10


class TestWakeUp:
    @pytest.mark.parametrize(
        ("choice", "reload", "period"),
        [
            (0, 0, 16 * TICK),
            (0, 2047, Fraction(1)),
            (1, 9, 80 * TICK),
            (2, 9, 40 * TICK),
            (3, 9, 20 * TICK),
            (4, 0, Fraction(1)),
            (5, 9, Fraction(10)),
            (6, 0, Fraction(65_537)),
        ],
    )
    def test_period(self, bench, choice, reload, period):
        bench.begin(0)
        bench.poke("WUTR", reload)
        bench.poke("CR", choice | WUTE | WUTIE)
        line = bench.chip.output("EXTI22")
        for _ in range(3):
            bench.chip.advance_s(period - TICK / 2)
            assert not bench.peek("ISR") & WUTF
            bench.chip.advance_s(TICK / 2)
            assert bench.peek("ISR") & WUTF
            assert line.level
            bench.poke("ISR", 0xFFFF_FFFF & ~WUTF & ~INIT)
            assert not line.level
        assert bench.woken == 3

    def test_disabled_it_never_comes(self, bench):
        bench.begin(0)
        for choice in (0, 4):
            bench.poke("CR", choice | WUTE)
            bench.poke("CR", choice)
        bench.chip.advance_s(Fraction(100_000))
        assert not bench.peek("ISR") & WUTF
        assert bench.peek("ISR") & WUTWF

    def test_setting_the_time_changes_nothing(self, bench):
        bench.begin(0)
        bench.poke("WUTR", 9)
        bench.poke("CR", 4 | WUTE)
        bench.chip.advance_s(Fraction(5))
        bench.begin(0x20_0000, control=4 | WUTE)
        bench.chip.advance_s(Fraction(4))
        assert not bench.peek("ISR") & WUTF
        bench.chip.advance_s(Fraction(1))
        assert bench.peek("ISR") & WUTF


class TestCorrection:
    def test_a_shift_backwards(self, bench):
        """SUBFS delays the clock: SS can then have more than it begins with."""
        bench.begin(0)
        bench.poke("SHIFTR", 128)
        assert bench.peek("ISR") & (SHPF | RSF) == SHPF
        bench.poke("SHIFTR", 5)
        bench.ticks(128)
        assert not bench.peek("ISR") & SHPF
        bench.now()
        assert bench.peek("SSR") == 254 + 128
        bench.chip.advance_s(Fraction(3, 2) - 129 * TICK)
        assert bench.peek("TR") == 0
        bench.ticks(1)
        assert bench.peek("TR") == 1
        assert bench.chip.noted("misuse") == ["RTC_SHIFTR"]

    def test_a_shift_forwards(self, bench):
        """ADD1S less a part of a second."""
        bench.begin(0)
        bench.poke("SHIFTR", 1 << 31 | 256 - 64)
        bench.ticks(128)
        bench.chip.advance_s(Fraction(3, 4) - 128 * TICK)
        assert bench.now()[0] == 1
        bench.chip.advance_s(Fraction(1) - TICK)
        assert bench.now()[0] == 1
        bench.ticks(1)
        assert bench.now()[0] == 2

    @pytest.mark.parametrize(("calibration", "ppm"), [(0x8000, 488.5), (0x01FF, -487.1), (0x8100, 244.2), (0, 0)])
    def test_calibration(self, bench, calibration, ppm):
        """The figures of the manual: from -487.1 to 488.5 parts in a million."""
        bench.begin(0)
        bench.poke("CALR", calibration)
        assert bench.peek("ISR") & RECALPF
        bench.ticks(3 * 128)
        assert not bench.peek("ISR") & RECALPF
        bench.chip.advance_s(Fraction(1_000_000))
        time, date = bench.now()
        seconds, _weekday = seconds_of(date, time, half_days=False)
        fraction = seconds + Fraction(255 - bench.peek("SSR"), 256)
        assert float(fraction - 1_000_000) == pytest.approx(ppm, abs=0.1)

    def test_no_other_calibration_while_one_is_pending(self, bench):
        bench.begin(0)
        bench.poke("CALR", 5)
        bench.poke("CALR", 6)
        assert bench.peek("CALR") == 5
        assert bench.chip.noted("misuse") == ["RTC_CALR"]


class TestTimeStamps:
    @pytest.mark.parametrize("falling", [False, True])
    def test_an_edge(self, bench, falling):
        bench.begin(0x12_0000, 0x24_6203)
        pin = bench.chip.input("RTC_TS")
        pin.drive(falling)
        bench.poke("CR", TSE | TSIE | falling << 3)
        bench.chip.advance_s(Fraction(5, 2))
        pin.drive(not falling)
        assert bench.chip.output("EXTI21").level
        bench.chip.advance_s(Fraction(1))
        pin.drive(falling)
        assert [bench.peek(name) for name in ("TSTR", "TSDR", "TSSSR")] == [0x12_0002, 0x6203, 127]
        assert bench.peek("ISR") & (TSF | TSOVF) == TSF
        pin.drive(not falling)
        assert bench.peek("ISR") & (TSF | TSOVF) == TSF | TSOVF
        assert bench.peek("TSTR") == 0x12_0002
        bench.poke("ISR", 0xFFFF_FFFF & ~(TSF | TSOVF | INIT))
        assert not bench.chip.output("EXTI21").level
        assert bench.woken == 1


class TestArithmetic:
    def test_days(self):
        days = 0
        for year in range(100):
            for month, length in enumerate((31, 28 + (year % 4 == 0), 31, 30, 31, 30, 31, 31, 30, 31, 30, 31), 1):
                for day in (1, length):
                    assert date_of(days + day - 1) == (year, month, day)
                days += length

    @given(st.integers(0, 36_525 * DAY - 1), st.booleans(), st.integers(0, 6))
    def test_registers_and_back(self, seconds, half_days, weekday):
        date, time = date_register(seconds, weekday), time_register(seconds, half_days=half_days)
        assert seconds_of(date, time, half_days=half_days) == (seconds, weekday)

    @settings(max_examples=examples(60))
    @given(data=st.data())
    def test_alarms_as_found_second_by_second(self, data):
        masks = data.draw(st.sampled_from([0x80, 0x8080, 0x0080_8080, 0x8080_8080, 0x8000_0080, 0x8080_8000, 0]))
        begin = data.draw(st.integers(0, 20 * DAY))
        target = begin + data.draw(st.integers(1, 4000))
        value = time_register(target, half_days=False)
        day = date_of(target // DAY)[2]
        value |= (day // 10 << 4 | day % 10) << 24 | masks
        bits, wanted = data.draw(st.integers(0, 4)), data.draw(st.integers(0, 15))
        alarm, reload = Alarm(value, bits << 24 | wanted, False, 0), 7
        count = data.draw(st.integers(0, reload))
        assert alarm.after(begin, count, reload) == self.search(value, bits, wanted, begin, count, reload)

    @staticmethod
    def search(value, bits, wanted, seconds, count, reload):
        for _ in range(4100 * (reload + 1)):
            count -= 1
            if count < 0:
                seconds, count = seconds + 1, reload
            time, day = time_register(seconds, half_days=False), date_of(seconds // DAY)[2]
            now = (day // 10 << 4 | day % 10) << 24 | time
            care = sum(0xFF << 8 * place for place in range(4) if not value >> 8 * place + 7 & 1) & 0x3F3F_7F7F
            if (now ^ value) & care:
                continue
            if count == reload if not bits else not (count ^ wanted) & (1 << bits) - 1:
                return seconds, count
        return None
