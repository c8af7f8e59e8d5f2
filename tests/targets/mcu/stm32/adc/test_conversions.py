"""Single, scanned, continuous, discontinuous, injected conversions; when they end and what they give (RM0410 15.3)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

EOCIE, AWDIE, JEOCIE, SCAN, AWDSGL, JAUTO, DISCEN, JDISCEN = (1 << bit for bit in range(5, 13))
JAWDEN, AWDEN, OVRIE = 1 << 22, 1 << 23, 1 << 26
CONT, DMA, DDS, EOCS, ALIGN = 2, 1 << 8, 1 << 9, 1 << 10, 1 << 11
SWSTART, JSWSTART = 30, 22
SHORTEST = 15  # 3 clocks of sampling and 12 of conversion
SAMPLING = (3, 15, 28, 56, 84, 112, 144, 480)


class TestSingle:
    def test_one_channel(self, rig, expected):
        rig.on()
        rig.sequence(5)
        rig.start(SWSTART)
        assert rig.flags() == {"STRT"}
        assert not rig.peek("CR2") >> SWSTART & 1
        rig.clocks(SHORTEST)
        assert rig.flags() == {"STRT", "EOC"}
        assert rig.peek("DR") == expected(5)
        assert rig.flags() == {"STRT"}
        rig.clocks(1000)
        assert rig.flags() == {"STRT"}

    @given(channel=st.integers(0, 15), time=st.integers(0, 7), res=st.integers(0, 3), prescaler=st.integers(0, 3))
    def test_how_long_it_takes(self, make_rig, channel, time, res, prescaler):
        """RM0410 section 15.5: the sampling time and as many clocks as bits."""
        rig = make_rig()
        rig.poke("CCR", prescaler << 16)
        rig.on(cr1=res << 24)
        rig.sequence(channel)
        rig.poke("SMPR1" if channel > 9 else "SMPR2", time << 3 * (channel % 10))
        rig.start()
        cycles = (SAMPLING[time] + (12, 10, 8, 6)[res]) * 2 * (prescaler + 1) * 2
        rig.chip.advance(cycles - 1)
        assert "EOC" not in rig.flags()
        rig.chip.advance(1)
        assert "EOC" in rig.flags()

    def test_the_voltage_counts_at_the_end_of_sampling(self, rig, expected):
        rig.on()
        rig.sequence(4)
        rig.poke("SMPR2", 2 << 12)
        rig.start()
        rig.clocks(27)
        rig.volts[4] = 0.8
        rig.clocks(1)
        rig.volts[4] = 1.6
        rig.clocks(12)
        assert rig.peek("DR") == expected(8)

    def test_off_nothing_happens(self, rig):
        rig.poke("CR2", 1 << SWSTART)
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

    def test_too_fast_a_clock_is_noted(self, rig):
        rig.poke("CCR", 0)
        rig.on()
        assert rig.chip.noted("misuse") == ["ADC_CCR.ADCPRE"]


class TestFormat:
    @pytest.mark.parametrize(("volts", "value"), [(-0.1, 0), (0, 0), (3.3 / 8192 * 0.99, 0), (3.3 / 8192 * 1.01, 1),
                                                  (1.65, 2048), (3.3, 4095), (5.0, 4095)])  # fmt: skip
    def test_ends_and_steps(self, rig, volts, value):
        rig.volts[0] = volts
        rig.on()
        rig.start()
        rig.clocks(SHORTEST)
        assert rig.peek("DR") == value

    @pytest.mark.parametrize(("res", "right", "left"), [(0, 0xA00, 0xA000), (1, 0x280, 0xA000), (2, 0xA0, 0xA000),
                                                        (3, 0x28, 0x00A0)])  # fmt: skip
    def test_alignment(self, rig, res, right, left):
        """RM0410 figures "right alignment", "left alignment" and "left alignment of 6-bit data"."""
        rig.volts[0] = 3.3 * 0xA00 / 0x1000
        for align, value in ((0, right), (ALIGN, left)):
            rig.on(cr1=res << 24, cr2=align)
            rig.start()
            rig.clocks(SHORTEST)
            assert rig.peek("DR") == value

    @pytest.mark.parametrize(("res", "left", "value"), [(0, 0, 0xFF00), (0, 1, 0xF800), (3, 0, 0xFF24), (3, 1, 0xFE48)])
    def test_injected_is_signed(self, rig, res, left, value):
        """0xA00 less 0xB00, or 0x24 less 0x100."""
        rig.volts[0] = 3.3 * 0xA00 / 0x1000 if res == 0 else 3.3 * 0x24 / 0x40
        rig.poke("JOFR1", 0xB00 if res == 0 else 0x100)
        rig.on(cr1=res << 24, cr2=ALIGN if left else 0)
        rig.injected(0)
        rig.start(JSWSTART)
        rig.clocks(SHORTEST)
        assert rig.peek("JDR1") == value


class TestScan:
    @given(channels=st.lists(st.integers(0, 15), min_size=1, max_size=16))
    def test_with_a_flag_for_each(self, make_rig, expected, channels):
        rig = make_rig()
        rig.on(cr1=SCAN, cr2=EOCS)
        rig.sequence(*channels)
        rig.start()
        found = []
        for _ in channels:
            rig.clocks(SHORTEST - 1)
            assert "EOC" not in rig.flags()
            rig.clocks(1)
            found.append(rig.peek("DR"))
        assert found == [expected(channel) for channel in channels]
        rig.clocks(1000)
        assert rig.flags() == {"STRT"}

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
        rig.on(cr1=SCAN, cr2=EOCS | CONT)
        rig.sequence(1, 2)
        rig.start()
        found = []
        for _ in range(5):
            rig.clocks(SHORTEST)
            found.append(rig.peek("DR"))
        assert found == [expected(channel) for channel in (1, 2, 1, 2, 1)]
        rig.poke("CR2", rig.peek("CR2") & ~CONT)
        rig.clocks(1000)
        assert rig.flags() >= {"STRT", "EOC"}

    def test_a_start_meanwhile_is_ignored(self, rig):
        rig.on(cr1=SCAN)
        rig.sequence(1, 2)
        rig.start()
        rig.clocks(SHORTEST)
        rig.start()
        rig.clocks(SHORTEST)
        assert "EOC" in rig.flags()

    def test_discontinuous(self, rig, expected):
        """The example of RM0410 section 15.3.11: n = 3, channels 0, 1, 2, 3, 6, 7, 9, 10."""
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


class TestOverrun:
    @pytest.mark.parametrize("cr2", [EOCS, DMA])
    def test_is_seen_and_ends_the_group(self, rig, expected, cr2):
        rig.on(cr1=SCAN | OVRIE, cr2=cr2)
        rig.sequence(1, 2, 3)
        rig.start()
        rig.clocks(2 * SHORTEST)
        assert "OVR" in rig.flags()
        assert rig.irq.level
        assert not rig.requests.line("ADC1").level
        assert rig.peek("DR") == expected(1)
        rig.start()
        rig.clocks(1000)
        assert "EOC" not in rig.flags()
        rig.clear()
        assert not rig.irq.level
        rig.start()
        rig.clocks(SHORTEST)
        assert rig.peek("DR") == expected(1)

    def test_is_not_looked_for_otherwise(self, rig, expected):
        rig.on(cr1=SCAN)
        rig.sequence(1, 2, 3)
        rig.start()
        rig.clocks(3 * SHORTEST)
        assert rig.flags() == {"STRT", "EOC"}
        assert rig.peek("DR") == expected(3)


class TestDma:
    def test_each_value_is_asked_for(self, rig, expected):
        found = rig.drain()
        rig.on(cr1=SCAN, cr2=DMA)
        rig.sequence(1, 2, 3)
        rig.start()
        rig.clocks(100)
        assert found == [expected(channel) for channel in (1, 2, 3)]
        assert "OVR" not in rig.flags()

    @pytest.mark.parametrize("dds", [0, DDS])
    def test_after_the_last_transfer(self, rig, dds):
        """Without DDS nothing is asked for any more, and nothing overruns, until DMA was switched off and on."""
        found = rig.drain()
        request = rig.requests.line("ADC1")
        rig.on(cr1=SCAN, cr2=DMA | dds | CONT)
        rig.sequence(1, 2)
        rig.start()
        rig.clocks(2 * SHORTEST + 1)
        assert len(found) == 2
        request.on_last()
        rig.clocks(SHORTEST)
        assert len(found) == (3 if dds else 2)
        rig.clocks(5 * SHORTEST)
        assert "OVR" not in rig.flags()
        rig.poke("CR2", rig.peek("CR2") & ~DMA)
        rig.poke("CR2", rig.peek("CR2") | DMA)
        rig.clear()
        rig.clocks(2 * SHORTEST)
        assert len(found) >= 3


class TestInjected:
    @pytest.mark.parametrize("channels", [(9,), (9, 8), (9, 8, 7), (9, 8, 7, 6)])
    def test_a_sequence(self, rig, expected, channels):
        rig.on(cr1=SCAN)
        rig.injected(*channels)
        rig.start(JSWSTART)
        rig.clocks(len(channels) * SHORTEST - 1)
        assert rig.flags() == {"JSTRT"}
        rig.clocks(1)
        assert rig.flags() == {"JSTRT", "JEOC"}
        found = [rig.peek(f"JDR{number}") for number in range(1, 5)]
        assert found == [expected(channel) for channel in channels] + [0] * (4 - len(channels))
        assert not rig.peek("CR2") >> JSWSTART & 1

    def test_it_breaks_off_a_regular_one_which_begins_anew(self, rig, expected):
        rig.on(cr1=SCAN, cr2=EOCS)
        rig.sequence(1, 2)
        rig.injected(5)
        rig.start()
        rig.clocks(SHORTEST)
        assert rig.peek("DR") == expected(1)
        rig.clocks(SHORTEST - 1)
        rig.start(JSWSTART)
        rig.clocks(SHORTEST)
        assert rig.peek("JDR1") == expected(5)
        assert "EOC" not in rig.flags()
        rig.clocks(SHORTEST - 1)
        assert "EOC" not in rig.flags()
        rig.clocks(1)
        assert rig.peek("DR") == expected(2)

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
        rig.clear()
        rig.clocks(2 * SHORTEST)
        assert "EOC" in rig.flags()

    def test_discontinuous(self, rig, expected):
        rig.on(cr1=SCAN | JDISCEN)
        rig.injected(3, 2, 1)
        for number, channel in enumerate((3, 2, 1), 1):
            rig.start(JSWSTART)
            rig.clocks(SHORTEST)
            assert rig.peek(f"JDR{number}") == expected(channel)
            assert ("JEOC" in rig.flags()) is (number == 3)


class TestWatchdog:
    LOW, HIGH = 1000, 2000

    @pytest.fixture(autouse=True)
    def _thresholds(self, rig):
        rig.poke("LTR", self.LOW)
        rig.poke("HTR", self.HIGH)
        rig.volts.update({1: 3.3 * 999 / 4096, 2: 3.3 * 1000 / 4096, 3: 3.3 * 2000 / 4096, 4: 3.3 * 2001 / 4096})

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
        rig.start(SWSTART if regular else JSWSTART)
        rig.clocks(SHORTEST)
        assert ("AWD" in rig.flags()) is barks

    def test_single_channel(self, rig):
        rig.on(cr1=AWDEN | AWDSGL | SCAN | 4)
        rig.sequence(1, 2)
        rig.start()
        rig.clocks(100)
        assert "AWD" not in rig.flags()
        rig.sequence(1, 4)
        rig.start()
        rig.clocks(100)
        assert "AWD" in rig.flags()

    def test_fewer_bits_have_the_same_thresholds(self, rig):
        rig.on(cr1=AWDEN | 2 << 24)
        rig.volts.update({5: 3.3 * 62 / 256, 6: 3.3 * 125 / 256})  # 62 * 16 = 992 and 125 * 16 = 2000
        for channel, barks in ((5, True), (6, False)):
            rig.clear()
            rig.sequence(channel)
            rig.start()
            rig.clocks(SHORTEST)
            assert ("AWD" in rig.flags()) is barks


class TestTriggers:
    @pytest.mark.parametrize(("enable", "edges"), [(0, []), (1, [True]), (2, [False]), (3, [True, False])])
    def test_edges(self, rig, enable, edges):
        rig.on(cr2=enable << 28 | 11 << 24)
        rig.sequence(1)
        began = []
        for level in (True, False):
            rig.trigger("TIM2_TRGO", level)
            rig.clocks(SHORTEST)
            if "EOC" in rig.flags():
                began.append(level)
                rig.peek("DR")
        assert began == edges

    def test_injected(self, rig):
        rig.on(cr2=1 << 20 | 14 << 16)
        rig.injected(1)
        rig.trigger("TIM6_TRGO", True)
        rig.clocks(SHORTEST)
        assert "JEOC" in rig.flags()

    def test_nobody_listens_without_need(self, rig):
        rig.on(cr2=1 << 28 | 11 << 24)
        listeners = rig.listeners["TIM2_TRGO"]
        assert [listener.on_change is not None for listener in listeners].count(True) == 1
        rig.poke("CR2", 0)
        assert all(listener.on_change is None for listener in listeners)

    def test_those_that_are_missing_are_noted(self, rig):
        rig.on(cr2=1 << 28 | 8 << 24)
        rig.on(cr2=1 << 20 | 15 << 16)
        assert rig.chip.noted("unmodelled") == ["ADC1_CR2.EXTSEL", "ADC1_CR2.JEXTSEL"]


class TestClock:
    def test_another_prescaler_in_the_middle(self, rig):
        rig.on()
        rig.start()
        rig.clocks(5)
        rig.poke("CCR", 3 << 16)
        rig.clocks(2 * 10 - 1)
        assert "EOC" not in rig.flags()
        rig.clocks(1)
        assert "EOC" in rig.flags()

    def test_it_waits_while_the_clock_stands_still(self, rig):
        rig.on()
        rig.start()
        rig.clocks(5)
        rig.chip.change_clock(APB2=0)
        rig.clocks(1000)
        rig.chip.change_clock(APB2=2)
        rig.clocks(9)
        assert "EOC" not in rig.flags()
        rig.clocks(1)
        assert "EOC" in rig.flags()
