"""The DAC by RM0008 section 12, one test for each rule; waves and formats against a naive model."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.nets import Nets
from targets.mcu.pins import PadMode
from tests.share import examples

EN, BOFF, TEN, DMAEN = 1 << 0, 1 << 1, 1 << 2, 1 << 12
NOISE, TRIANGLE = 1 << 6, 2 << 6
SOFTWARE = 7 << 3 | TEN
TRIGGERS = ["TIM6_TRGO", "TIM8_TRGO", "TIM7_TRGO", "TIM5_TRGO", "TIM2_TRGO", "TIM4_TRGO", "EXTI9_EDGE"]
TWELVE = st.integers(0, 0xFFF)


def mamp(value):
    return value << 8


class TestRegisters:
    def test_reset_values(self, rig):
        """Table 76: all are 0."""
        assert all(rig.dac.read(offset) == 0 for offset in rig.dac.registers)

    def test_places(self, rig):
        names = "CR SWTRIGR DHR12R1 DHR12L1 DHR8R1 DHR12R2 DHR12L2 DHR8R2 DHR12RD DHR12LD DHR8RD DOR1 DOR2"
        assert {one.offset: one.name for one in rig.dac.registers.values()} == {
            4 * index: name for index, name in enumerate(names.split())
        }

    def test_reserved_bits(self, rig):
        rig.poke("CR", 0xFFFF_FFFF)
        assert rig.peek("CR") == 0x1FFF_1FFF
        rig.poke("DOR1", 0xFFF)
        assert rig.peek("DOR1") == 0

    @given(first=TWELVE, second=TWELVE)
    def test_formats(self, make_rig, first, second):
        """Section 12.3.3: right and left aligned, 8 bits, alone and both at once."""
        rig = make_rig()
        for one, other in ((first, second), (second, first)):
            rig.poke("DHR12R1", one | 0xFFFF_F000)
            rig.poke("DHR12L2", other << 4 | 0xF)
            rig.ticks(1)
            assert (rig.peek("DOR1"), rig.peek("DOR2")) == (one, other)
            rig.poke("DHR8R1", other >> 4 | 0xF00)
            rig.poke("DHR12R2", one)
            rig.ticks(1)
            assert (rig.peek("DOR1"), rig.peek("DOR2")) == (other & 0xFF0, one)
            rig.poke("DHR12RD", other << 16 | one)
            assert (rig.peek("DHR12R1"), rig.peek("DHR12L2"), rig.peek("DHR8R2")) == (one, other << 4, other >> 4)
            assert (rig.peek("DHR12LD"), rig.peek("DHR8RD")) == (other << 20 | one << 4, (other >> 4) << 8 | one >> 4)
            rig.poke("DHR12LD", one << 20 | other << 4)
            rig.ticks(1)
            assert (rig.peek("DOR1"), rig.peek("DOR2")) == (other, one)
            rig.poke("DHR8RD", (other >> 4) << 8 | one >> 4)
            rig.ticks(1)
            assert (rig.peek("DOR1"), rig.peek("DOR2")) == (one & 0xFF0, other & 0xFF0)

    def test_reset_from_anywhere(self, rig):
        rig.poke("CR", EN | NOISE | TEN | DMAEN)
        rig.poke("DHR12R1", 0x123)
        rig.trigger("TIM6_TRGO")
        rig.dac.reset()
        assert all(rig.dac.read(offset) == 0 for offset in rig.dac.registers)
        rig.triggered()
        assert rig.peek("DOR1") == 0
        assert rig.volts() is None
        assert len(rig.requests()) == 1


class TestConversion:
    def test_without_a_trigger_dor_follows_one_cycle_of_apb1_later(self, rig):
        """Section 12.3.4."""
        rig.poke("CR", EN)
        rig.poke("DHR12R1", 0x321)
        rig.chip.advance(1)
        assert rig.peek("DOR1") == 0
        rig.chip.advance(1)
        assert rig.peek("DOR1") == 0x321

    @pytest.mark.parametrize(("select", "signal"), list(enumerate(TRIGGERS)))
    def test_a_trigger_takes_three_cycles_of_apb1(self, rig, select, signal):
        """Table 74 and section 12.3.6."""
        rig.poke("CR", EN | TEN | select << 3)
        rig.poke("DHR12R1", 0x456)
        for other in TRIGGERS:
            if other != signal:
                rig.triggered(other)
        assert rig.peek("DOR1") == 0
        rig.trigger(signal)
        rig.chip.advance(5)
        assert rig.peek("DOR1") == 0
        rig.chip.advance(1)
        assert rig.peek("DOR1") == 0x456

    def test_a_software_trigger_takes_one(self, rig):
        rig.poke("CR", EN | SOFTWARE)
        rig.poke("DHR12R1", 0x456)
        rig.ticks(10)
        assert rig.peek("DOR1") == 0
        rig.poke("SWTRIGR", 1)
        assert rig.peek("SWTRIGR") == 0
        rig.chip.advance(1)
        assert rig.peek("DOR1") == 0
        rig.chip.advance(1)
        assert rig.peek("DOR1") == 0x456

    def test_software_triggers_only_who_waits_for_it(self, rig):
        rig.poke("CR", (EN | SOFTWARE) << 16 | EN | TEN)
        rig.poke("DHR12RD", 0x222_0111)
        rig.poke("SWTRIGR", 3)
        rig.ticks(5)
        assert (rig.peek("DOR1"), rig.peek("DOR2")) == (0, 0x222)

    def test_both_channels_at_the_same_cycle(self, rig):
        """Section 12.4.6: simultaneous software start."""
        rig.poke("CR", (EN | SOFTWARE) << 16 | EN | SOFTWARE)
        rig.poke("DHR12RD", 0x222_0111)
        rig.poke("SWTRIGR", 3)
        rig.ticks(1)
        assert (rig.peek("DOR1"), rig.peek("DOR2")) == (0x111, 0x222)

    def test_both_channels_by_one_timer(self, rig):
        """Section 12.4.7."""
        rig.poke("CR", (EN | TEN) << 16 | EN | TEN)
        rig.poke("DHR12RD", 0x222_0111)
        rig.triggered()
        assert (rig.peek("DOR1"), rig.peek("DOR2")) == (0x111, 0x222)

    def test_a_falling_trigger_does_nothing(self, rig):
        rig.signals.output("TIM6_TRGO").set(True)
        rig.poke("CR", EN | TEN)
        rig.poke("DHR12R1", 7)
        rig.signals.output("TIM6_TRGO").set(False)
        rig.ticks(5)
        assert rig.peek("DOR1") == 0

    def test_the_digital_half_works_without_en(self, rig):
        """Section 12.3.1, note."""
        rig.poke("DHR12R1", 5)
        rig.ticks(1)
        assert rig.peek("DOR1") == 5
        assert rig.volts() is None

    def test_a_word_written_under_way_is_for_the_next_trigger(self, rig):
        rig.poke("CR", EN | TEN)
        rig.poke("DHR12R1", 1)
        rig.trigger("TIM6_TRGO")
        rig.poke("DHR12R1", 2)
        rig.ticks(3)
        assert rig.peek("DOR1") == 1
        rig.triggered()
        assert rig.peek("DOR1") == 2

    def test_a_second_trigger_under_way_is_lost(self, rig):
        rig.poke("CR", EN | TEN | TRIANGLE | mamp(3))
        for _ in range(3):
            rig.trigger("TIM6_TRGO")
            rig.trigger("TIM6_TRGO")
            rig.ticks(3)
        assert rig.peek("DOR1") == 2

    def test_what_is_held_goes_on_when_ten_falls(self, rig):
        rig.poke("CR", EN | TEN)
        rig.poke("DHR12R1", 9)
        rig.ticks(5)
        rig.poke("CR", EN)
        rig.ticks(1)
        assert rig.peek("DOR1") == 9

    @pytest.mark.parametrize(("field", "bits"), [("TSEL", 5 << 3), ("MAMP", mamp(6))])
    def test_tsel_and_mamp_stay_while_en_is_set(self, rig, field, bits):
        """Sections 12.3.6 (note) and 12.5.1."""
        rig.poke("CR", bits)
        rig.poke("CR", EN | bits)
        rig.poke("CR", EN)
        assert rig.peek("CR") == EN | bits, field
        assert rig.chip.noted("misuse") == ["DAC_CR.EN1"]
        rig.poke("CR", 0)
        assert rig.peek("CR") == 0

    def test_a_load_stands_still_with_its_clock(self, rig):
        rig.poke("CR", EN | TEN)
        rig.poke("DHR12R1", 4)
        rig.trigger("TIM6_TRGO")
        rig.ticks(1)
        rig.chip.change_clock(APB1=0)
        rig.chip.advance(100)
        assert rig.peek("DOR1") == 0
        rig.trigger("TIM6_TRGO")
        rig.chip.change_clock(APB1=8)
        rig.chip.advance(15)
        assert rig.peek("DOR1") == 0
        rig.chip.advance(1)
        assert rig.peek("DOR1") == 4

    def test_with_the_gate_shut_no_trigger_comes(self, rig):
        rig.poke("CR", EN | TEN | DMAEN)
        rig.poke("DHR12R1", 4)
        rig.dac.clocked = False
        rig.dac.after_clock_change()
        rig.triggered()
        assert rig.requests() == []
        rig.dac.clocked = True
        rig.dac.after_clock_change()
        rig.ticks(10)
        assert rig.peek("DOR1") == 0


class TestDma:
    def test_a_trigger_asks_at_once(self, rig):
        """Section 12.3.7."""
        rig.poke("CR", (EN | TEN | DMAEN) << 16 | EN | TEN)
        rig.chip.advance(100)
        rig.triggered()
        assert (rig.requests(1), rig.requests(2)) == ([], [100])

    def test_a_software_trigger_does_not(self, rig):
        rig.poke("CR", EN | SOFTWARE | DMAEN)
        rig.poke("SWTRIGR", 1)
        rig.ticks(5)
        assert rig.requests() == []

    def test_a_request_is_dropped_with_dmaen(self, rig):
        rig.poke("CR", EN | TEN | DMAEN)
        dropped = []
        rig.chip.dma("DAC_CH1").on_set = dropped.append
        rig.poke("CR", EN | TEN)
        assert dropped == [False]


class TestWaves:
    def test_noise_begins_as_in_the_figure(self, rig):
        """Section 12.3.8, figure of the timing: 0xAAA, then 0xD55."""
        rig.poke("CR", EN | TEN | NOISE | mamp(11))
        seen = []
        for _ in range(3):
            rig.triggered()
            seen.append(rig.peek("DOR1"))
        assert seen == [0xAAA, 0xD55, 0xEAA]

    def test_noise_has_its_full_period(self, rig):
        """Taps 12, 6, 4 and 1 are a primitive polynomial: 4095 words, none of them 0."""
        rig.poke("CR", SOFTWARE | NOISE | mamp(15))
        seen = set()
        for _ in range(4095):
            rig.poke("SWTRIGR", 1)
            rig.ticks(1)
            seen.add(rig.peek("DOR1"))
        assert len(seen) == 4095
        assert 0 not in seen

    @given(base=TWELVE, amplitude=st.integers(0, 15), count=st.integers(1, 20))
    def test_noise_is_masked_and_added(self, make_rig, base, amplitude, count):
        rig = make_rig()
        rig.poke("CR", EN | SOFTWARE | NOISE | mamp(amplitude))
        rig.poke("DHR12R1", base)
        word = 0xAAA
        for _ in range(count):
            rig.poke("SWTRIGR", 1)
            rig.ticks(1)
            assert rig.peek("DOR1") == min(base + (word & (2 << min(amplitude, 11)) - 1), 0xFFF)
            bit = (word ^ word >> 1 ^ word >> 4 ^ word >> 6) & 1
            word = word >> 1 | bit << 11

    @given(base=TWELVE, amplitude=st.integers(0, 15), begin=st.integers(0, 4000), count=st.integers(1, 30))
    def test_triangle(self, make_rig, base, amplitude, begin, count):
        """Section 12.3.9: up to the amplitude, down to 0, and again."""
        rig = make_rig()
        rig.poke("CR", EN | SOFTWARE | TRIANGLE | mamp(amplitude))
        rig.poke("DHR12R1", base)
        top, level, up = (2 << min(amplitude, 11)) - 1, 0, True
        for number in range(min(begin, 2 * top + 2) + count):
            rig.poke("SWTRIGR", 1)
            rig.ticks(1)
            assert rig.peek("DOR1") == min(base + level, 0xFFF), number
            up = level == 0 or (up and level < top)
            level += 1 if up else -1

    def test_waves_begin_anew_when_wave_is_cleared(self, rig):
        for wave, expected in ((NOISE, 0xAAA), (TRIANGLE, 0)):
            for _ in range(2):
                rig.poke("CR", EN | TEN | wave | mamp(11))
                rig.triggered()
                assert rig.peek("DOR1") == expected
                rig.triggered()
                rig.poke("CR", 0)


class TestOutput:
    @given(word=TWELVE)
    def test_volts(self, make_rig, word):
        """Section 12.3.5: VREF+ DOR / 4095, at the pin of each channel."""
        rig = make_rig()
        rig.poke("CR", EN << 16 | EN)
        rig.poke("DHR12RD", word << 16 | 0xFFF - word)
        rig.ticks(1)
        assert rig.volts("PA5") == pytest.approx(3.3 * word / 4095)
        assert rig.volts("PA4") == pytest.approx(3.3 * (0xFFF - word) / 4095)

    def test_en_connects_the_pin(self, rig):
        rig.poke("DHR12R1", 0xFFF)
        rig.ticks(1)
        rig.poke("CR", EN)
        assert rig.volts() == pytest.approx(3.3)
        rig.poke("CR", 0)
        assert rig.volts() is None

    @pytest.mark.parametrize(("bits", "ohms"), [(EN, 1.0), (EN | BOFF, 15_000.0)])
    def test_a_load_outside(self, rig, bits, ohms):
        """DS5792, DAC characteristics: 15 kOhm without the buffer."""
        rig.pins["PA4"].drive_volts(0.0, ohms=5_000.0)
        rig.poke("CR", bits)
        rig.poke("DHR12R1", 0xFFF)
        rig.ticks(1)
        assert rig.volts() == pytest.approx(3.3 * 5_000 / (5_000 + ohms))

    def test_a_digital_input_at_the_pin_sees_it(self, rig):
        pin = rig.pins["PA4"]
        pin.configure(PadMode.INPUT, latch=False, pull=True)
        rig.poke("CR", EN)
        assert not pin.reads_high
        edges = []
        pin.on_edge(lambda _cycle, _ns, level: edges.append(level))
        for word in (0x800, 0xF00, 0x800, 0x100):
            rig.poke("DHR12R1", word)
            rig.ticks(1)
        assert edges == [True, False]

    def test_a_pin_that_the_port_drives_stays_with_the_port(self, rig):
        pin = rig.pins["PA4"]
        rig.poke("CR", EN)
        pin.configure(PadMode.PUSH_PULL, latch=True, pull=None)
        assert pin.level
        assert pin.volts == pytest.approx(3.3)
        pin.configure(PadMode.ANALOG, latch=True, pull=None)
        assert pin.volts == 0


@given(st.lists(st.tuples(st.sampled_from(["write", "soft", "hard", "wait"]), TWELVE), max_size=40))
def test_it_is_the_same_however_time_is_cut(make_rig, story):
    """DOR at each cycle does not depend on how many cycles pass at once."""
    by_one, at_once = make_rig(), make_rig()
    for rig in (by_one, at_once):
        rig.poke("CR", (EN | SOFTWARE | TRIANGLE | mamp(5)) << 16 | EN | TEN)
    for what, value in story[: examples(40)]:
        for rig in (by_one, at_once):
            if what == "write":
                rig.poke("DHR12RD", value << 16 | value)
            elif what == "soft":
                rig.poke("SWTRIGR", 3)
            elif what == "hard":
                rig.trigger("TIM6_TRGO")
        for _ in range(value % 9):
            by_one.chip.advance(1)
        at_once.chip.advance(value % 9)
        for name in ("DOR1", "DOR2"):
            assert by_one.peek(name) == at_once.peek(name)


def test_a_wire_takes_it_to_other_pins(rig):
    """What reads volts there sees it: another pin of the chip, as ADC_IN8 does at PB0."""
    other = rig.pins["PB0"]
    other.configure(PadMode.ANALOG, latch=False, pull=None)
    Nets().wire("loop", rig.pins["PA4"], other)
    rig.poke("CR", EN)
    for word in (0, 0x400, 0xFFF):
        rig.poke("DHR12R1", word)
        rig.ticks(1)
        assert other.volts == pytest.approx(3.3 * word / 4095)
    rig.poke("CR", 0)
    assert other.volts is None
