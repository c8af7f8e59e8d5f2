"""Channels of the ADCs of the STM32H753 against the pin definitions in another form: which pin is which input."""

from __future__ import annotations

from targets.mcu.stm32h7.adc_inputs import CHANNELS, INJECTED_TRIGGERS, INSIDE, REGULAR_TRIGGERS
from tests.each import each

# DS12117, pin definitions, "additional functions"; ADC12 and ADC123 are those that share the channel.
PINS = """
PA0 ADC1_INP16
PA1 ADC1_INP17
PA2 ADC12_INP14
PA3 ADC12_INP15
PA4 ADC12_INP18
PA5 ADC12_INP19
PA6 ADC12_INP3
PA7 ADC12_INP7
PB0 ADC12_INP9
PB1 ADC12_INP5
PC0 ADC123_INP10
PC1 ADC123_INP11
PC2 ADC123_INP12
PC3 ADC12_INP13
PC4 ADC12_INP4
PC5 ADC12_INP8
PF3 ADC3_INP5
PF4 ADC3_INP9
PF5 ADC3_INP4
PF6 ADC3_INP8
PF7 ADC3_INP3
PF8 ADC3_INP7
PF9 ADC3_INP2
PF10 ADC3_INP6
PF11 ADC1_INP2
PF12 ADC1_INP6
PF13 ADC2_INP2
PF14 ADC2_INP6
PH2 ADC3_INP13
PH3 ADC3_INP14
PH4 ADC3_INP15
PH5 ADC3_INP16
PA0 ADC12_INP0
PA1 ADC12_INP1
PC2 ADC3_INP0
PC3 ADC3_INP1
"""


def test_each_pin_is_the_input_that_the_datasheet_says():
    expected = {"ADC1": {}, "ADC2": {}, "ADC3": {}}
    for line in PINS.split("\n")[1:-1]:
        pin, function = line.split()
        units, channel = function.removeprefix("ADC").split("_INP")
        for number in units:
            expected[f"ADC{number}"][int(channel)] = pin
    assert {unit: dict(pins) for unit, pins in CHANNELS.items()} == expected


@each(("unit", "count"), [("ADC1", 20), ("ADC2", 18), ("ADC3", 17)])
def test_pins_and_what_is_inside_make_twenty_channels(unit, count):
    assert len(CHANNELS[unit]) == count
    inside = INSIDE.get(unit, {})
    assert not set(inside) & set(CHANNELS[unit])
    assert set(inside) | set(CHANNELS[unit]) == set(range(20))


def test_low_power_timers_trigger_both_groups():
    for triggers in (REGULAR_TRIGGERS, INJECTED_TRIGGERS):
        assert [triggers[number] for number in (18, 19, 20)] == ["lptim1_out", "lptim2_out", "lptim3_out"]
