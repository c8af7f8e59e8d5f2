"""The timers of the STM32F100 of low and medium density: registers, interrupts and masters (RM0041).

TIM15 to TIM17 have a complementary output and a break, and share interrupts with TIM1. Internal triggers are partly
from memory: TIM15 stands where larger chips have TIM8, and behind ITR0 of TIM1 and ITR2 of TIM3.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.stm32.tim.kinds import HIGH_DENSITY_KINDS, KINDS, Kind
from targets.mcu.stm32.tim.registers import (
    ARR,
    BDTR,
    CCER,
    CCMR1,
    CCR1,
    CCR2,
    CNT,
    CR1,
    CR2,
    DCR,
    DIER,
    DMAR,
    EGR,
    PSC,
    RCR,
    SMCR,
    SR,
)

__all__ = ["VALUE_LINE_KINDS"]

_NO_DMA = "requests to DMA of TIM15 to TIM17 are not modelled"


def _enables(writable: int, requests: int) -> Register:
    return Register("DIER", DIER, 0, writable, requests, fidelity=Fidelity.PARTLY, note=_NO_DMA)


_COMMON = (
    Register("CR1", CR1, writable=0x038F),
    Register("CNT", CNT, writable=0xFFFF, live=True),
    Register("PSC", PSC, writable=0xFFFF),
    Register("ARR", ARR, reset=0xFFFF, writable=0xFFFF),
    Register("RCR", RCR, writable=0x00FF),
    Register("CCR1", CCR1, writable=0xFFFF),
    Register("BDTR", BDTR, writable=0xFFFF),
    Register("DCR", DCR, writable=0x1F1F),
    Register("DMAR", DMAR, writable=0xFFFF),
)
_TIM15 = (
    *_COMMON,
    Register("CR2", CR2, writable=0x077D),
    Register("SMCR", SMCR, writable=0x00F7),
    _enables(0x47E7, 0x4700),
    Register("SR", SR, writable=0x06E7),
    Register("EGR", EGR, writable=0x00E7),
    Register("CCMR1", CCMR1, writable=0xFFFF),
    Register("CCER", CCER, writable=0x00BF),
    Register("CCR2", CCR2, writable=0xFFFF),
)
_TIM16 = (
    *_COMMON,
    Register("CR2", CR2, writable=0x030D),
    _enables(0x43E3, 0x4300),
    Register("SR", SR, writable=0x02E3),
    Register("EGR", EGR, writable=0x00E3),
    Register("CCMR1", CCMR1, writable=0x00FF),
    Register("CCER", CCER, writable=0x000F),
)


def _one_channel(irq: int) -> Kind:
    return Kind(
        bus="APB2",
        irqs=MappingProxyType({0xE3: irq}),
        registers=_TIM16,
        advanced=True,
        channels=1,
        compares=1,
        complements=1,
        requests=False,
        master_modes=0,
        master_mode=4,
        both_edges=True,
    )


VALUE_LINE_KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "TIM1": replace(KINDS["TIM1"], internal_triggers=("TIM15", "TIM2", "TIM3", "TIM4")),
        "TIM2": replace(KINDS["TIM2"], internal_triggers=("TIM1", "TIM15", "TIM3", "TIM4")),
        "TIM3": replace(KINDS["TIM3"], internal_triggers=("TIM1", "TIM2", "TIM15", "TIM4")),
        "TIM4": replace(KINDS["TIM4"], internal_triggers=("TIM1", "TIM2", "TIM3", "TIM15")),
        "TIM6": HIGH_DENSITY_KINDS["TIM6"],
        "TIM7": HIGH_DENSITY_KINDS["TIM7"],
        "TIM15": Kind(
            bus="APB2",
            irqs=MappingProxyType({0xE7: 24}),
            registers=_TIM15,
            internal_triggers=("TIM2", "TIM3", "TIM16", "TIM17"),
            advanced=True,
            channels=2,
            compares=2,
            complements=1,
            requests=False,
            master_modes=6,
            both_edges=True,
        ),
        "TIM16": _one_channel(25),
        "TIM17": _one_channel(26),
    }
)
"""Every timer of the STM32F100 of low and medium density by its name."""
