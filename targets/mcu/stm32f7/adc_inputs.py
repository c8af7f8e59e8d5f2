"""Where the channels and the triggers of the ADCs of the STM32F76x come from.

Channels: DS11532, pin definitions. Triggers: RM0410 sections 15.6 and 15.13.3 (CR2.EXTSEL and JEXTSEL); those that are
events of compare channels, TRGO2 or a line of EXTI are not modelled.
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

REGULAR_TRIGGERS: Mapping[int, str] = MappingProxyType(
    {4: "TIM5_TRGO", 7: "TIM8_TRGO", 9: "TIM1_TRGO", 11: "TIM2_TRGO", 12: "TIM4_TRGO", 13: "TIM6_TRGO"}
)
"""Signals by EXTSEL."""
INJECTED_TRIGGERS: Mapping[int, str] = MappingProxyType(
    {0: "TIM1_TRGO", 2: "TIM2_TRGO", 5: "TIM4_TRGO", 9: "TIM8_TRGO", 12: "TIM5_TRGO", 14: "TIM6_TRGO"}
)
"""Signals by JEXTSEL."""
