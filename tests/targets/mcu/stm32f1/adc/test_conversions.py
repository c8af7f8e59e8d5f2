"""Single, scanned, continuous, discontinuous, injected conversions; when they end, what they give (RM0008 11.3)."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

EOCIE, AWDIE, JEOCIE, SCAN, AWDSGL, JAUTO, DISCEN, JDISCEN = (1 << bit for bit in range(5, 13))
JAWDEN, AWDEN = 1 << 22, 1 << 23
ADON, CONT, CAL, RSTCAL, DMA, ALIGN, TSVREFE = 1, 2, 4, 8, 1 << 8, 1 << 11, 1 << 23
SHORTEST = 14  # 1.5 clocks of sampling and 12.5 of conversion
SAMPLING = ("1.5", "7.5", "13.5", "28.5", "41.5", "55.5", "71.5", "239.5")


class TestSingle:
    def test_one_channel(self, rig, expected):
        rig.on()
        rig.sequence(5)
        rig.start()
        assert rig.flags() == {"STRT"}
        assert not rig.peek("CR2") >> 22 & 1
        rig.clocks(SHORTEST)
        assert rig.flags() == {"STRT", "EOC"}
        assert rig.peek("DR") == expected(5)
        assert rig.flags() == {"STRT"}
        rig.clocks(1000)
        assert rig.flags() == {"STRT"}

    @given(channel=st.integers(0, 15), time=st.integers(0, 7), cycles=st.sampled_from((2, 4, 6, 8, 16, 32)))
    def test_how_long_it_takes(self, make_rig, channel, time, cycles):
        """RM0008 section 11.6: the sampling time and 12.5 clocks."""
        rig = make_rig()
        rig.chip.clocks.kernels["ADC"] = Fraction(cycles)
        rig.chip.change_clock()
        rig.on()
        rig.sequence(channel)
        rig.poke("SMPR1" if channel > 9 else "SMPR2", time << 3 * (channel % 10))
        rig.start()
        all_of_it = (Fraction(SAMPLING[time]) + Fraction(25, 2)) * cycles
        rig.chip.advance(int(all_of_it) - 1)
        assert "EOC" not in rig.flags()
        rig.chip.advance(1)
        assert "EOC" in rig.flags()

    def test_the_voltage_counts_at_the_end_of_sampling(self, rig, expected):
        rig.on()
        rig.sequence(4)
        rig.poke("SMPR2", 1 << 12)
        rig.start()
        rig.clocks(7)
        rig.volts(4, 0.8)
        rig.clocks(0.5)
        rig.volts(4, 1.6)
        rig.clocks(12.5)
        assert rig.peek("DR") == expected(8)

    def test_adon_once_more_starts_the_regular_group(self, rig, expected):
        """RM0008 section 11.12.3, ADON: if nothing else in CR2 is changed by the same write."""
        rig.poke("CR2", ADON)
        rig.chip.advance(56)
        rig.sequence(3)
        rig.poke("CR2", ADON | CONT)
        rig.clocks(50)
        assert rig.flags() == set()
        rig.poke("CR2", ADON)
        rig.clocks(50)
        assert rig.flags() == set()
        rig.poke("CR2", ADON)
        rig.clocks(SHORTEST)
        assert rig.flags() == {"STRT", "EOC"}
        assert rig.peek("DR") == expected(3)

    def test_off_nothing_happens(self, rig):
        rig.poke("CR2", 1 << 22)
        rig.clocks(1000)
        assert rig.flags() == set()
        rig.on()
        rig.sequence(1)
        rig.start()
        rig.clocks(5)
        rig.poke("CR2", 0)
        rig.clocks(1000)
        assert rig.flags() == {"STRT"}

    def test_too_soon_is_noted(self, rig):
        rig.on(settle=False)
        rig.start()
        assert rig.chip.noted("misuse") == ["ADC1_CR2.ADON"]

    @pytest.mark.parametrize("cr2", [7 << 17, 1 << 20, 1 << 20 | 4 << 17])
    def test_software_starts_nothing_unless_it_is_the_trigger(self, rig, cr2):
        rig.poke("CR2", ADON | cr2)
        rig.chip.advance(56)
        rig.poke("CR2", ADON | cr2 | 1 << 22)
        rig.clocks(50)
        assert rig.flags() == set()
        assert "ADC1_CR2.SWSTART" in rig.chip.noted("misuse")

    def test_flags_are_cleared_by_writing_zero_alone(self, rig):
        rig.on()
        rig.start()
        rig.clocks(SHORTEST)
        rig.poke("SR", 0x1F)
        assert rig.flags() == {"STRT", "EOC"}
        rig.poke("SR", ~(1 << 1) & 0x1F)
        assert rig.flags() == {"STRT"}
        rig.poke("SR", 0)
        assert rig.flags() == set()


class TestFormat:
    @pytest.mark.parametrize(("volts", "value"), [(0, 0), (3.3 / 8192 * 0.99, 0), (3.3 / 8192 * 1.01, 1),
                                                  (1.65, 2048), (3.3, 4095), (5.0, 4095)])  # fmt: skip
    def test_ends_and_steps(self, rig, volts, value):
        rig.volts(0, volts)
        rig.on()
        rig.start()
        rig.clocks(SHORTEST)
        assert rig.peek("DR") == value

    def test_alignment(self, rig):
        rig.volts(0, 3.3 * 0xA00 / 0x1000)
        for align, value in ((0, 0xA00), (ALIGN, 0xA000)):
            rig.on(cr2=align)
            rig.start()
            rig.clocks(SHORTEST)
            assert rig.peek("DR") == value

    @pytest.mark.parametrize(("align", "value"), [(0, 0xFF00), (ALIGN, 0xF800)])
    def test_injected_is_signed(self, rig, align, value):
        """0xA00 less 0xB00, with its sign; RM0008 figures 25 and 26."""
        rig.volts(0, 3.3 * 0xA00 / 0x1000)
        rig.poke("JOFR1", 0xB00)
        rig.on(cr2=align)
        rig.injected(0)
        rig.start_injected()
        rig.clocks(SHORTEST)
        assert rig.peek("JDR1") == value

    def test_inside_the_chip(self, rig):
        """1.43 V of the sensor at 25 degrees and 1.20 V of the reference, of ADC1 and with TSVREFE alone."""
        rig.on(cr1=SCAN, cr2=TSVREFE | DMA)
        rig.poke("SMPR1", 7 << 18 | 7 << 21)
        found = rig.drain()
        rig.sequence(16, 17)
        rig.start()
        rig.clocks(600)
        assert [value for _, value in found] == [round(1.43 / 3.3 * 4096), round(1.2 / 3.3 * 4096)]
        rig.on(cr2=0)
        rig.start()
        rig.clocks(600)
        assert rig.peek("DR") == 0
        assert rig.chip.noted("misuse") == ["ADC1_IN16"]
        rig.on(unit=2, cr2=TSVREFE)
        rig.sequence(17, unit=2)
        rig.start(unit=2)
        rig.clocks(600)
        assert rig.peek("DR", unit=2) == 0

    def test_the_third_has_pins_of_its_own(self, rig):
        rig.volts(4, 1.65, unit=3)
        rig.on(unit=3)
        rig.sequence(4, unit=3)
        rig.start(unit=3)
        rig.clocks(SHORTEST)
        assert rig.peek("DR", unit=3) == 2048


class TestScan:
    @given(channels=st.lists(st.integers(0, 15), min_size=1, max_size=16))
    def test_each_goes_by_dma(self, make_rig, expected, channels):
        rig = make_rig()
        rig.on(cr1=SCAN, cr2=DMA)
        rig.sequence(*channels)
        found = rig.drain()
        rig.start()
        rig.clocks(SHORTEST * len(channels) + 100)
        assert found == [(SHORTEST * number, expected(channel)) for number, channel in enumerate(channels, 1)]

    def test_with_a_flag_at_the_end(self, rig, expected):
        rig.on(cr1=SCAN)
        rig.sequence(1, 2, 3)
        rig.start()
        rig.clocks(3 * SHORTEST - 1)
        assert rig.flags() == {"STRT"}
        rig.clocks(1)
        assert rig.flags() == {"STRT", "EOC"}
        assert rig.peek("DR") == expected(3)

    def test_without_scan_the_first_alone(self, rig, expected):
        rig.on()
        rig.sequence(7, 2, 3)
        rig.start()
        rig.clocks(100)
        assert rig.peek("DR") == expected(7)

    def test_continuous(self, rig, expected):
        rig.on(cr1=SCAN, cr2=CONT | DMA)
        rig.sequence(1, 2)
        found = rig.drain()
        rig.start()
        rig.clocks(5 * SHORTEST + 1)
        assert found == [(SHORTEST * n, expected(1 if n % 2 else 2)) for n in range(1, 6)]
        rig.poke("CR2", rig.peek("CR2") & ~CONT)
        rig.clocks(1000)
        assert len(found) == 6

    def test_what_nobody_fetches_is_written_over(self, rig, expected):
        """There is no overrun flag: DR has the last value, and one request is made for it."""
        rig.on(cr1=SCAN, cr2=DMA)
        rig.sequence(1, 2, 3)
        rig.start()
        rig.clocks(100)
        request = rig.chip.dma("ADC1")
        assert len(request.rises) == 1
        assert rig.peek("DR") == expected(3)
        assert not request.level

    def test_no_request_for_what_was_converted_before(self, rig):
        """RM0008 section 11.8: the end of a regular conversion makes a request, and nothing else."""
        rig.on()
        rig.start()
        rig.clocks(20)
        rig.poke("CR2", rig.peek("CR2") | DMA)
        assert not rig.chip.dma("ADC1").level
        rig.start()
        rig.clocks(20)
        rig.poke("CR2", rig.peek("CR2") & ~DMA)
        rig.poke("CR2", rig.peek("CR2") | DMA)
        assert len(rig.chip.dma("ADC1").rises) == 1

    def test_another_sequence_begins_anew(self, rig, expected):
        """RM0008 section 11.3.3: the current conversion is reset, and a new start pulse is sent."""
        rig.on(cr2=CONT)
        rig.sequence(1)
        rig.start()
        rig.clocks(SHORTEST + 5)
        rig.peek("DR")
        rig.sequence(2)
        rig.clocks(SHORTEST - 1)
        assert "EOC" not in rig.flags()
        rig.clocks(1)
        assert rig.peek("DR") == expected(2)

    def test_the_same_sequence_does_not(self, rig, expected):
        rig.on()
        rig.sequence(1)
        rig.start()
        rig.clocks(5)
        rig.sequence(1)
        rig.clocks(SHORTEST - 5)
        assert rig.peek("DR") == expected(1)

    def test_a_start_meanwhile_is_ignored(self, rig):
        rig.on(cr1=SCAN)
        rig.sequence(1, 2)
        rig.start()
        rig.clocks(SHORTEST)
        rig.start()
        rig.clocks(SHORTEST)
        assert "EOC" in rig.flags()

    def test_discontinuous(self, rig, expected):
        """The example of RM0008 section 11.3.10: n = 3, channels 0, 1, 2, 3, 6, 7, 9, 10."""
        rig.on(cr1=SCAN | DISCEN | 2 << 13)
        rig.sequence(0, 1, 2, 3, 6, 7, 9, 10)
        for group in ((0, 1, 2), (3, 6, 7), (9, 10), (0, 1, 2)):
            rig.start()
            for channel in group:
                rig.clocks(SHORTEST)
                assert "EOC" in rig.flags()
                assert rig.peek("DR") == expected(channel)
            rig.clocks(200)
            assert "EOC" not in rig.flags()

    def test_the_second_has_no_request(self, rig):
        rig.on(cr2=DMA, unit=2)
        rig.start(unit=2)
        rig.clocks(SHORTEST)
        assert rig.flags(unit=2) == {"STRT", "EOC"}
        assert not rig.chip.dma("ADC2").level


class TestInjected:
    @pytest.mark.parametrize("channels", [(9,), (9, 8), (9, 8, 7), (9, 8, 7, 6)])
    def test_a_sequence(self, rig, expected, channels):
        rig.on(cr1=SCAN)
        rig.injected(*channels)
        rig.start_injected()
        rig.clocks(len(channels) * SHORTEST - 1)
        assert rig.flags() == {"JSTRT"}
        rig.clocks(1)
        assert rig.flags() == {"JSTRT", "JEOC", "EOC"}
        found = [rig.peek(f"JDR{number}") for number in range(1, 5)]
        assert found == [expected(channel) for channel in channels] + [0] * (4 - len(channels))
        assert not rig.peek("CR2") >> 21 & 1

    def test_it_breaks_off_a_regular_one_which_begins_anew(self, rig, expected):
        rig.on(cr1=SCAN, cr2=DMA)
        found = rig.drain()
        rig.sequence(1, 2)
        rig.injected(5)
        rig.start()
        rig.clocks(2 * SHORTEST - 1)
        rig.start_injected()
        rig.clocks(SHORTEST)
        assert rig.peek("JDR1") == expected(5)
        assert len(found) == 1
        rig.clocks(SHORTEST + 1)
        assert found == [(SHORTEST, expected(1)), (4 * SHORTEST - 1, expected(2))]

    def test_another_sequence_begins_it_anew(self, rig, expected):
        rig.on()
        rig.injected(1)
        rig.start_injected()
        rig.clocks(5)
        rig.injected(2)
        rig.clocks(SHORTEST - 1)
        assert "JEOC" not in rig.flags()
        rig.clocks(1)
        assert "JEOC" in rig.flags()
        assert rig.peek("JDR1") == expected(2)

    def test_a_regular_start_waits_for_it(self, rig, expected):
        rig.on(cr2=DMA)
        found = rig.drain()
        rig.sequence(2)
        rig.start_injected()
        rig.clocks(5)
        rig.start()
        rig.clocks(30)
        assert found == [(2 * SHORTEST, expected(2))]

    def test_automatically_after_the_regular_group(self, rig, expected):
        rig.on(cr1=SCAN | JAUTO, cr2=CONT)
        rig.sequence(1, 2)
        rig.injected(5, 6)
        rig.start()
        rig.clocks(2 * SHORTEST)
        assert rig.flags() == {"STRT", "EOC", "JSTRT"}
        rig.clocks(2 * SHORTEST)
        assert "JEOC" in rig.flags()
        assert (rig.peek("JDR1"), rig.peek("JDR2")) == (expected(5), expected(6))
        rig.poke("SR", 0)
        rig.clocks(2 * SHORTEST)
        assert "EOC" in rig.flags()

    def test_discontinuous(self, rig, expected):
        rig.on(cr1=SCAN | JDISCEN)
        rig.injected(3, 2, 1)
        for number, channel in enumerate((3, 2, 1), 1):
            rig.start_injected()
            rig.clocks(SHORTEST)
            assert rig.peek(f"JDR{number}") == expected(channel)
            rig.clocks(3 * SHORTEST)
            assert ("JEOC" in rig.flags()) is (number == 3)


class TestWatchdog:
    LOW, HIGH = 1000, 2000

    @pytest.fixture(autouse=True)
    def _thresholds(self, rig):
        rig.poke("LTR", self.LOW)
        rig.poke("HTR", self.HIGH)
        for channel, value in enumerate((999, 1000, 2000, 2001), 1):
            rig.volts(channel, 3.3 * value / 4096)

    @pytest.mark.parametrize(("channel", "barks"), [(1, True), (2, False), (3, False), (4, True)])
    @pytest.mark.parametrize("align", [0, ALIGN])
    def test_thresholds(self, rig, channel, barks, align):
        rig.on(cr1=AWDEN | AWDIE, cr2=align)
        rig.sequence(channel)
        rig.start()
        rig.clocks(SHORTEST)
        assert ("AWD" in rig.flags()) is barks
        assert rig.irq.level is barks

    @pytest.mark.parametrize(
        ("enable", "regular", "barks"),
        [(AWDEN, True, True), (AWDEN, False, False), (JAWDEN, True, False), (JAWDEN, False, True)],
    )
    def test_groups(self, rig, enable, regular, barks):
        rig.on(cr1=enable)
        rig.sequence(1)
        rig.injected(1)
        (rig.start if regular else rig.start_injected)()
        rig.clocks(SHORTEST)
        assert ("AWD" in rig.flags()) is barks

    def test_single_channel(self, rig):
        rig.on(cr1=AWDEN | AWDSGL | SCAN | 4)
        for channels, barks in (((1, 2), False), ((1, 4), True)):
            rig.sequence(*channels)
            rig.start()
            rig.clocks(100)
            assert ("AWD" in rig.flags()) is barks


class TestInterrupts:
    @pytest.mark.parametrize(
        ("enable", "regular"), [(EOCIE, True), (JEOCIE, False), (EOCIE, False), (JEOCIE, True), (0, True)]
    )
    def test_of_each_group(self, rig, enable, regular):
        """EOC is the end of a regular or an injected group (RM0008 section 11.12.1)."""
        rig.on(cr1=enable)
        (rig.start if regular else rig.start_injected)()
        rig.clocks(SHORTEST)
        assert rig.irq.level is bool(enable == EOCIE or (enable and not regular))
        rig.poke("SR", 0)
        assert not rig.irq.level

    def test_two_converters_share_a_line_and_the_third_has_its_own(self, rig):
        for unit in (1, 2, 3):
            rig.on(cr1=EOCIE, unit=unit)
            rig.start(unit=unit)
        rig.clocks(SHORTEST)
        assert (rig.irq.level, rig.irq3.level) == (True, True)
        rig.peek("DR", unit=1)
        rig.peek("DR", unit=3)
        assert (rig.irq.level, rig.irq3.level) == (True, False)
        rig.peek("DR", unit=2)
        assert not rig.irq.level


class TestCalibration:
    def test_it_takes_its_time(self, rig):
        rig.on()
        for bit, clocks in ((RSTCAL, 2), (CAL, 83)):
            rig.poke("CR2", rig.peek("CR2") | bit)
            rig.clocks(clocks - 1)
            assert rig.peek("CR2") & bit
            rig.clocks(1)
            assert not rig.peek("CR2") & bit
        assert rig.chip.noted("misuse") == []

    def test_a_reset_ends_it(self, rig):
        rig.on()
        rig.poke("CR2", rig.peek("CR2") | CAL)
        rig.clocks(40)
        rig.adcs[0].reset()
        rig.on()
        rig.poke("CR2", rig.peek("CR2") | CAL)
        rig.clocks(82)
        assert rig.peek("CR2") & CAL
        rig.clocks(1)
        assert not rig.peek("CR2") & CAL

    def test_of_a_converter_that_is_off_is_noted(self, rig):
        rig.poke("CR2", CAL)
        rig.clocks(83)
        assert not rig.peek("CR2") & CAL
        assert rig.chip.noted("misuse") == ["ADC1_CR2.CAL"]

    def test_a_start_meanwhile_is_noted(self, rig):
        rig.on()
        rig.poke("CR2", rig.peek("CR2") | CAL)
        rig.start()
        rig.clocks(200)
        assert rig.flags() == set()
        assert rig.chip.noted("misuse") == ["ADC1_CR2.CAL"]


class TestClock:
    def test_another_rate_in_the_middle(self, rig):
        rig.on()
        rig.start()
        rig.clocks(4)
        rig.chip.clocks.kernels["ADC"] = Fraction(8)
        rig.chip.change_clock()
        rig.chip.advance(8 * 10 - 1)
        assert "EOC" not in rig.flags()
        rig.chip.advance(1)
        assert "EOC" in rig.flags()

    def test_it_waits_while_the_clock_stands_still(self, rig):
        rig.on()
        rig.start()
        rig.clocks(4)
        rig.chip.clocks.kernels["ADC"] = Fraction(0)
        rig.chip.change_clock()
        rig.clocks(1000)
        rig.chip.clocks.kernels["ADC"] = Fraction(4)
        rig.chip.change_clock()
        rig.clocks(9)
        assert "EOC" not in rig.flags()
        rig.clocks(1)
        assert "EOC" in rig.flags()


@given(
    writes=st.lists(st.tuples(st.integers(1, 3), st.integers(0, 18), st.integers(0, 0xFFFF_FFFF), st.integers(0, 99)))
)
def test_no_writes_break_it(make_rig, writes):
    rig = make_rig()
    rig.on()
    registers = list(rig.adcs[0].registers.values())
    for unit, number, value, clocks in writes:
        rig.poke(registers[number].name, value, unit)
        rig.clocks(clocks)
    for unit in (1, 2, 3):
        for register in registers:
            assert 0 <= rig.peek(register.name, unit) < 1 << 32
