"""How a 16-bit ADC wakes up: deep power-down, regulator, calibration and ADRDY, each after its time (RM0433 25.4)."""

from __future__ import annotations

from fractions import Fraction

ADEN, ADDIS, ADSTART, ADSTP = 1 << 0, 1 << 1, 1 << 2, 1 << 4
ADCALLIN, ADVREGEN, DEEPPWD, ADCAL = 1 << 16, 1 << 28, 1 << 29, 1 << 31
LINCALRDYW = 0x3F << 22
ADRDY, LDORDY = 1 << 0, 1 << 12
US = Fraction(1, 1_000_000)


def supplied(rig):
    rig.poke("CR", 0)
    rig.poke("CR", ADVREGEN)
    rig.chip.advance_s(10 * US)
    return rig


def test_reset_values(rig):
    assert rig.peek("CR") == DEEPPWD
    assert rig.peek("CFGR") == 0x8000_0000
    assert (rig.peek("LTR1"), rig.peek("HTR1"), rig.peek("HTR3")) == (0, 0x03FF_FFFF, 0x03FF_FFFF)
    assert rig.peek("ISR") == rig.peek("ADC2_ISR") == rig.peek("CSR") == rig.peek("CCR") == 0


def test_the_regulator_is_ready_after_its_time(rig):
    rig.poke("CR", 0)
    rig.poke("CR", ADVREGEN)
    rig.chip.advance_s(5 * US - Fraction(1, 480_000_000))
    assert not rig.peek("ISR") & LDORDY
    rig.chip.advance(1)
    assert rig.peek("ISR") & LDORDY
    rig.poke("ISR", LDORDY)
    assert rig.peek("ISR") & LDORDY, "software cannot clear it"
    rig.poke("CR", 0)
    assert not rig.peek("ISR") & LDORDY


def test_deep_power_down_keeps_the_regulator_off(rig):
    rig.poke("CR", DEEPPWD | ADVREGEN)
    assert rig.peek("CR") == DEEPPWD
    rig.poke("CR", DEEPPWD | ADEN)
    assert rig.peek("CR") == DEEPPWD
    assert rig.chip.noted("misuse") == ["ADC1_CR.ADEN"]


def test_adrdy_after_ten_clocks(rig):
    supplied(rig).poke("CR", ADVREGEN | ADEN)
    rig.clocks(10 - Fraction(1, 16))
    assert not rig.peek("ISR") & ADRDY
    rig.chip.advance(1)
    assert rig.peek("ISR") & ADRDY
    rig.poke("IER", ADRDY)
    assert rig.irq.level
    rig.poke("ISR", ADRDY)
    assert not rig.irq.level


def test_without_a_clock_nothing_is_ever_ready(rig):
    rig.kernel_hz = Fraction(0)
    rig.adc.after_clock_change()
    supplied(rig).poke("CR", ADVREGEN | ADEN)
    rig.chip.advance(10_000_000)
    assert not rig.peek("ISR") & ADRDY
    assert rig.chip.noted("misuse") == ["ADC1_CR.ADEN"]
    rig.kernel_hz = Fraction(60_000_000)
    rig.adc.after_clock_change()
    rig.clocks(10)
    assert rig.peek("ISR") & ADRDY


def test_addis_is_over_at_once_unless_conversions_are_asked_for(rig):
    rig.on()
    rig.start()
    rig.set("CR", ADDIS)
    assert rig.peek("CR") & (ADEN | ADDIS | ADSTART) == ADEN | ADSTART
    rig.set("CR", ADSTP)
    assert rig.peek("CR") & (ADSTART | ADSTP) == 0
    rig.set("CR", ADDIS)
    assert rig.peek("CR") & (ADEN | ADDIS) == 0
    assert not rig.peek("ISR") & ADRDY


def test_calibration_of_the_offset_takes_1280_clocks(rig):
    supplied(rig).poke("CR", ADVREGEN | ADCAL)
    rig.clocks(1280 - Fraction(1, 16))
    assert rig.peek("CR") == ADVREGEN | ADCAL
    rig.chip.advance(1)
    assert rig.peek("CR") == ADVREGEN


def test_calibration_of_linearity_takes_165010_clocks_and_gives_six_words(rig):
    supplied(rig).poke("CR", ADVREGEN | ADCALLIN | ADCAL)
    rig.clocks(165_010 - Fraction(1, 16))
    assert rig.peek("CR") & ADCAL
    rig.chip.advance(1)
    assert rig.peek("CR") == ADVREGEN | ADCALLIN | LINCALRDYW


def test_words_of_the_linearity_factor_are_written_and_read_one_by_one(rig):
    supplied(rig)
    for word in range(6):
        rig.poke("CALFACT2", 0x1000 + word)
        rig.set("CR", 1 << 22 + word)
    rig.poke("CALFACT2", 0)
    for word in range(6):
        rig.poke("CR", rig.peek("CR") & ~(1 << 22 + word))
        assert rig.peek("CALFACT2") == 0x1000 + word
    assert not rig.peek("CR") & LINCALRDYW


def test_no_calibration_while_it_is_enabled_and_no_enable_while_it_calibrates(rig):
    rig.on()
    rig.set("CR", ADCAL)
    assert not rig.peek("CR") & ADCAL
    supplied_rig = type(rig)()
    supplied(supplied_rig).poke("CR", ADVREGEN | ADCAL)
    supplied_rig.set("CR", ADEN)
    assert not supplied_rig.peek("CR") & ADEN
    assert supplied_rig.chip.noted("misuse") == ["ADC1_CR.ADEN"]


def test_switching_the_supply_off_stops_everything(rig):
    rig.on()
    rig.sequence(1)
    rig.start()
    rig.poke("CR", DEEPPWD)
    assert rig.peek("CR") == DEEPPWD
    rig.clocks(100)
    assert not rig.flags()


def test_conversions_before_adrdy_are_noted(rig):
    supplied(rig).poke("CR", ADVREGEN | ADEN)
    rig.set("CR", ADSTART)
    assert "ADC1_CR.ADSTART" in rig.chip.noted("misuse")


def test_a_converter_that_is_not_enabled_converts_nothing(rig):
    supplied(rig).poke("CR", ADVREGEN | ADSTART)
    assert rig.peek("CR") == ADVREGEN
    assert rig.chip.noted("misuse") == ["ADC1_CR.ADSTART"]
