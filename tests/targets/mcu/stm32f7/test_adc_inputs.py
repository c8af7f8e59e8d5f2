"""Channels and triggers of the ADCs of the STM32F767 against the manuals' tables in another form."""

from __future__ import annotations

from targets.mcu.stm32f7.adc_inputs import CHANNELS, INJECTED_TRIGGERS, REGULAR_TRIGGERS

# DS11532, pin definitions: which pin is which input, of which converters.
PINS = """
PA0 123_0|PA1 123_1|PA2 123_2|PA3 123_3|PA4 12_4|PA5 12_5|PA6 12_6|PA7 12_7|PB0 12_8|PB1 12_9|PC0 123_10|PC1 123_11
PC2 123_12|PC3 123_13|PC4 12_14|PC5 12_15|PF3 3_9|PF4 3_14|PF5 3_15|PF6 3_4|PF7 3_5|PF8 3_6|PF9 3_7|PF10 3_8
"""
# RM0410 section 15.13.3, CR2: by value of EXTSEL and of JEXTSEL.
REGULAR = """TIM1_CC1 TIM1_CC2 TIM1_CC3 TIM2_CC2 TIM5_TRGO TIM4_CC4 TIM3_CC4 TIM8_TRGO
TIM8_TRGO2 TIM1_TRGO TIM1_TRGO2 TIM2_TRGO TIM4_TRGO TIM6_TRGO - EXTI11"""
INJECTED = """TIM1_TRGO TIM1_CC4 TIM2_TRGO TIM2_CC1 TIM3_CC4 TIM4_TRGO - TIM8_CC4
TIM1_TRGO2 TIM8_TRGO TIM8_TRGO2 TIM3_CC3 TIM5_TRGO TIM3_CC1 TIM6_TRGO -"""


def test_each_pin_is_the_input_that_the_datasheet_says():
    expected = {"ADC1": {}, "ADC2": {}, "ADC3": {}}
    for pin, function in (entry.split() for line in PINS.split("\n") for entry in line.split("|") if entry):
        units, channel = function.split("_")
        for number in units:
            expected[f"ADC{number}"][int(channel)] = pin
    assert {unit: dict(pins) for unit, pins in CHANNELS.items()} == expected


def test_triggers_are_those_of_the_manual_that_are_modelled():
    """All but TRGO2."""
    for triggers, names in ((REGULAR_TRIGGERS, REGULAR), (INJECTED_TRIGGERS, INJECTED)):
        modelled = {number: name for number, name in enumerate(names.split()) if name != "-" and "TRGO2" not in name}
        assert triggers == {number: name.replace("EXTI11", "EXTI11_EDGE") for number, name in modelled.items()}
