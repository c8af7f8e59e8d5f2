"""Where the channels and the triggers of the ADCs of the STM32F76x come from.

Channels: DS11532, pin definitions. Triggers: RM0410 sections 15.6 and 15.13.3 (CR2.EXTSEL and JEXTSEL); those that are
TRGO2 are not modelled.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

__all__ = ["CHANNELS", "INJECTED_TRIGGERS", "REGULAR_TRIGGERS"]

_ALL = ["PA0", "PA1", "PA2", "PA3", "-", "-", "-", "-", "-", "-", "PC0", "PC1", "PC2", "PC3", "-", "-"]
_FIRST_TWO = ["-", "-", "-", "-", "PA4", "PA5", "PA6", "PA7", "PB0", "PB1", "-", "-", "-", "-", "PC4", "PC5"]
_THIRD = ["-", "-", "-", "-", "PF6", "PF7", "PF8", "PF9", "PF10", "PF3", "-", "-", "-", "-", "PF4", "PF5"]


def _pins(*rows: list[str]) -> Mapping[int, str]:
    return MappingProxyType({channel: pin for row in rows for channel, pin in enumerate(row) if pin != "-"})


CHANNELS: Mapping[str, Mapping[int, str]] = MappingProxyType(
    {"ADC1": _pins(_ALL, _FIRST_TWO), "ADC2": _pins(_ALL, _FIRST_TWO), "ADC3": _pins(_ALL, _THIRD)}
)
"""The pin of each channel, by converter."""

_REGULAR = (
    *("TIM1_CC1", "TIM1_CC2", "TIM1_CC3", "TIM2_CC2", "TIM5_TRGO", "TIM4_CC4", "TIM3_CC4", "TIM8_TRGO"),
    *("", "TIM1_TRGO", "", "TIM2_TRGO", "TIM4_TRGO", "TIM6_TRGO", "", "EXTI11_EDGE"),
)
_INJECTED = (
    *("TIM1_TRGO", "TIM1_CC4", "TIM2_TRGO", "TIM2_CC1", "TIM3_CC4", "TIM4_TRGO", "", "TIM8_CC4"),
    *("", "TIM8_TRGO", "", "TIM3_CC3", "TIM5_TRGO", "TIM3_CC1", "TIM6_TRGO"),
)

REGULAR_TRIGGERS: Mapping[int, str] = MappingProxyType({number: name for number, name in enumerate(_REGULAR) if name})
"""Signals by EXTSEL."""
INJECTED_TRIGGERS: Mapping[int, str] = MappingProxyType({number: name for number, name in enumerate(_INJECTED) if name})
"""Signals by JEXTSEL."""
