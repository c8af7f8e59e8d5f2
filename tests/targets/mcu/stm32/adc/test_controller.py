"""What the converters share, and where their channels and triggers come from (RM0410 sections 15.10 to 15.13)."""

from __future__ import annotations

from dataclasses import replace

import pytest

from targets.mcu.stm32f7.adc_inputs import CHANNELS, INJECTED_TRIGGERS, REGULAR_TRIGGERS
from tests.each import each

VBATE, TSVREFE = 1 << 22, 1 << 23
DIV4 = 1 << 16


def test_reset_values(rig):
    rig.adc.reset()
    for offset, register in rig.adc.registers.items():
        assert rig.adc.read(offset) == (0xFFF if register.name.endswith("HTR") else 0)


@pytest.mark.parametrize("unit", [1, 2, 3])
@pytest.mark.parametrize(
    ("name", "offset", "mask"),
    [
        ("SR", 0x00, 0),
        ("CR1", 0x04, 0x07C0_FFFF),
        ("SMPR1", 0x0C, 0x07FF_FFFF),
        ("SMPR2", 0x10, 0x3FFF_FFFF),
        ("JOFR4", 0x20, 0xFFF),
        ("HTR", 0x24, 0xFFF),
        ("LTR", 0x28, 0xFFF),
        ("SQR1", 0x2C, 0x00FF_FFFF),
        ("SQR2", 0x30, 0x3FFF_FFFF),
        ("SQR3", 0x34, 0x3FFF_FFFF),
        ("JSQR", 0x38, 0x003F_FFFF),
        ("JDR4", 0x48, 0),
        ("DR", 0x4C, 0),
    ],
)
def test_places_and_reserved_bits(rig, unit, name, offset, mask):
    """RM0410 section 15.13.18, ADC register map."""
    rig.adc.write(0x100 * (unit - 1) + offset, 0xFFFF_FFFF)
    assert rig.peek(f"ADC{unit}_{name}") == mask


def test_common_flags_and_interrupt(rig):
    for unit in (1, 3):
        rig.poke(f"ADC{unit}_CR1", 1 << 5)
        rig.poke(f"ADC{unit}_CR2", 1)
    rig.chip.advance(1000)
    for unit in (1, 3):
        rig.poke(f"ADC{unit}_CR2", 1 | 1 << 30)
    rig.clocks(15)
    assert rig.peek("CSR") == 0x12 << 16 | 0x12
    assert rig.irq.level
    rig.peek("ADC1_DR")
    assert rig.irq.level
    rig.peek("ADC3_DR")
    assert not rig.irq.level


def test_each_has_a_clock_gate(rig):
    rig.enabled.discard(1)
    rig.poke("ADC2_HTR", 5)
    assert rig.peek("ADC2_HTR") == 0
    assert rig.chip.noted("clock-off") == ["ADC2"]
    rig.enabled.add(1)
    assert rig.peek("ADC2_HTR") == 0xFFF
    rig.enabled.discard(0)
    rig.poke("ADC2_CR2", 1)
    rig.chip.advance(1000)
    rig.poke("ADC2_CR2", 1 | 1 << 30)
    rig.clocks(15)
    assert rig.flags(2) == {"STRT", "EOC"}


def test_multiple_modes_are_said_to_be_missing(rig):
    rig.poke("CCR", 6)
    rig.peek("CDR")
    assert rig.chip.noted("unmodelled") == ["ADC_CCR", "ADC_CDR"]


class TestInside:
    def convert(self, rig, channel, unit=1):
        rig.poke(f"ADC{unit}_CR2", 1)
        rig.chip.advance(1000)
        rig.poke(f"ADC{unit}_SQR3", channel)
        rig.poke(f"ADC{unit}_CR2", 1 | 1 << 30)
        rig.clocks(15)
        return rig.peek(f"ADC{unit}_DR")

    @pytest.mark.parametrize(
        ("ccr", "channel", "volts"),
        [
            (0, 17, 0),
            (0, 18, 0),
            (TSVREFE, 17, 1.21),
            (TSVREFE, 18, 0.76),
            (VBATE, 17, 0),
            (VBATE, 18, 3.3 / 4),
            (VBATE | TSVREFE, 18, 3.3 / 4),
            (VBATE | TSVREFE, 16, 0),
        ],
    )
    def test_channels(self, rig, ccr, channel, volts):
        rig.poke("CCR", DIV4 | ccr)
        assert self.convert(rig, channel) == round(volts / 3.3 * 4096)

    def test_temperature(self, rig):
        rig.poke("CCR", DIV4 | TSVREFE)
        rig.adc.internal = replace(rig.adc.internal, temperature_c=65.0)
        assert self.convert(rig, 18) == round((0.76 + 40 * 0.0025) / 3.3 * 4096)

    def test_the_others_have_none(self, rig):
        rig.poke("CCR", DIV4 | TSVREFE)
        assert self.convert(rig, 18, unit=2) == 0
        assert rig.chip.noted("misuse") == ["ADC2.IN18"]

    def test_a_pin_that_floats(self, rig):
        rig.volts[3] = None
        assert self.convert(rig, 3) == 0
        assert rig.chip.noted("misuse") == ["ADC1.IN3"]


class TestInputs:
    """DS11532, pin definitions: functions ADC123_INx, ADC12_INx and ADC3_INx."""

    @each(
        ("unit", "channel", "pin"),
        [
            ("ADC1", 0, "PA0"),
            ("ADC2", 3, "PA3"),
            ("ADC3", 13, "PC3"),
            ("ADC1", 9, "PB1"),
            ("ADC2", 15, "PC5"),
            ("ADC3", 4, "PF6"),
            ("ADC3", 9, "PF3"),
            ("ADC3", 14, "PF4"),
        ],
    )
    def test_channels(self, unit, channel, pin):
        assert CHANNELS[unit][channel] == pin

    def test_each_channel_has_a_pin_of_its_own(self):
        for channels in CHANNELS.values():
            assert sorted(channels) == list(range(16))
            assert len(set(channels.values())) == 16

    def test_triggers(self):
        assert REGULAR_TRIGGERS[13] == INJECTED_TRIGGERS[14] == "TIM6_TRGO"
