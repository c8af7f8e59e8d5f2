"""Where the channels and the triggers of the ADCs of the STM32H753 come from.

Channels: DS12117, pin definitions (the positive inputs INP). PA0_C, PA1_C, PC2_C and PC3_C are joined to PA0, PA1, PC2
and PC3 by switches that are closed after a reset (SYSCFG_PMCR), and stand for them here. Triggers: RM0433, external
triggers for regular and injected channels; those that are compare channels, TRGO2, lines of EXTI and HRTIM are not
modelled.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from targets.mcu.stm32.lptim import inside

__all__ = ["CHANNELS", "INJECTED_TRIGGERS", "INSIDE", "REGULAR_TRIGGERS"]

_COMMON = "PC0 PC1 PC2"  # channels 10 to 12 of all three
_FIRST_TWO = f"PA6 PC4 PB1 - PA7 PC5 PB0 {_COMMON} PC3 PA2 PA3"  # channels 3 to 15 but for 6
_ADC1 = ["PA0", "PA1", "PF11", *_FIRST_TWO.replace("-", "PF12").split(), "PA0", "PA1", "PA4", "PA5"]
_ADC2 = ["PA0", "PA1", "PF13", *_FIRST_TWO.replace("-", "PF14").split(), "-", "-", "PA4", "PA5"]
_ADC3 = f"PC2 PC3 PF9 PF7 PF5 PF3 PF10 PF8 PF6 PF4 {_COMMON} PH2 PH3 PH4 PH5 - - -".split()


def _pins(row: list[str]) -> Mapping[int, str]:
    return MappingProxyType({channel: pin for channel, pin in enumerate(row) if pin != "-"})


CHANNELS: Mapping[str, Mapping[int, str]] = MappingProxyType(
    {"ADC1": _pins(_ADC1), "ADC2": _pins(_ADC2), "ADC3": _pins(_ADC3)}
)
"""The pin of each channel, by converter."""
INSIDE: Mapping[str, Mapping[int, str]] = MappingProxyType(
    {
        "ADC2": MappingProxyType({16: "DAC1_OUT1", 17: "DAC1_OUT2"}),  # 0 V: the DAC is not modelled
        "ADC3": MappingProxyType({17: "VBAT", 18: "SENSE", 19: "VREFINT"}),
    }
)
"""What else stands at channels; see `adc16.Inside`."""

_LPTIM = {18: inside("LPTIM1"), 19: inside("LPTIM2"), 20: inside("LPTIM3")}  # in both tables

REGULAR_TRIGGERS: Mapping[int, str] = MappingProxyType(
    {
        4: "TIM3_TRGO",
        7: "TIM8_TRGO",
        9: "TIM1_TRGO",
        11: "TIM2_TRGO",
        12: "TIM4_TRGO",
        13: "TIM6_TRGO",
        14: "TIM15_TRGO",
        **_LPTIM,
    }
)
"""Signals by EXTSEL."""
INJECTED_TRIGGERS: Mapping[int, str] = MappingProxyType(
    {
        0: "TIM1_TRGO",
        2: "TIM2_TRGO",
        5: "TIM4_TRGO",
        9: "TIM8_TRGO",
        12: "TIM3_TRGO",
        14: "TIM6_TRGO",
        15: "TIM15_TRGO",
        **_LPTIM,
    }
)
"""Signals by JEXTSEL."""
