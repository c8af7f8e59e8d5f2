"""What differs between the timers of the medium-density STM32F103, as data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

__all__ = ["KINDS", "Kind"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """One timer.

    Attributes:
        bus: the bus whose timer clock it runs on.
        irqs: interrupt number for masks of SR, which are those of DIER as well.
        internal_triggers: the timers behind ITR0 to ITR3, or None where this chip has none (RM0008 tables 82 and 86).
        advanced: whether it has repetition counter, complementary outputs, dead time and break.
    """

    bus: str
    irqs: Mapping[int, int]
    internal_triggers: tuple[str | None, ...]
    advanced: bool = False


def _general(irq: int, *internal_triggers: str | None) -> Kind:
    return Kind(bus="APB1", irqs=MappingProxyType({0x5F: irq}), internal_triggers=internal_triggers)


KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "TIM1": Kind(
            bus="APB2",
            irqs=MappingProxyType({0x80: 24, 0x01: 25, 0x60: 26, 0x1E: 27}),  # BRK, UP, TRG_COM, CC
            internal_triggers=(None, "TIM2", "TIM3", "TIM4"),
            advanced=True,
        ),
        "TIM2": _general(28, "TIM1", None, "TIM3", "TIM4"),
        "TIM3": _general(29, "TIM1", "TIM2", None, "TIM4"),
        "TIM4": _general(30, "TIM1", "TIM2", "TIM3", None),
    }
)
"""Every timer by its name."""
