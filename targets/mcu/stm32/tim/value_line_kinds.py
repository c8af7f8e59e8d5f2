"""The timers of the STM32F100: registers, interrupts and masters (RM0041).

TIM15 to TIM17 have a complementary output and a break, and share interrupts with TIM1. Internal triggers are partly
from memory: TIM15 stands where the STM32F103 has TIM8, and behind ITR0 of TIM1 and ITR2 of TIM3, where those of high
density have TIM5 unless MISC_REMAP is set. TIM12 to TIM14 are of high density: registers as of TIM12 to TIM14 of the
STM32F103xG (RM0008 section 16), from memory.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType

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

__all__ = ["HIGH_VALUE_LINE_KINDS", "VALUE_LINE_KINDS"]

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
    Register("DIER", DIER, writable=0x47E7),
    Register("SR", SR, writable=0x06E7),
    Register("EGR", EGR, writable=0x00E7),
    Register("CCMR1", CCMR1, writable=0xFFFF),
    Register("CCER", CCER, writable=0x00BF),
    Register("CCR2", CCR2, writable=0xFFFF),
)
_TIM16 = (
    *_COMMON,
    Register("CR2", CR2, writable=0x030D),
    Register("DIER", DIER, writable=0x43E3),
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
            master_modes=6,
            both_edges=True,
        ),
        "TIM16": _one_channel(25),
        "TIM17": _one_channel(26),
    }
)
"""Every timer of the STM32F100 of low and medium density by its name."""

_SMALL = (
    Register("CNT", CNT, writable=0xFFFF, live=True),
    Register("PSC", PSC, writable=0xFFFF),
    Register("ARR", ARR, reset=0xFFFF, writable=0xFFFF),
    Register("CCR1", CCR1, writable=0xFFFF),
)
_TIM12 = (
    *_SMALL,
    Register("CR1", CR1, writable=0x038F),
    Register("CR2", CR2, writable=0x0070),
    Register("SMCR", SMCR, writable=0x00F7),
    Register("DIER", DIER, writable=0x0047),
    Register("SR", SR, writable=0x0647),
    Register("EGR", EGR, writable=0x0047),
    Register("CCMR1", CCMR1, writable=0xFFFF),
    Register("CCER", CCER, writable=0x00BB),
    Register("CCR2", CCR2, writable=0xFFFF),
)
_TIM13 = (
    *_SMALL,
    Register("CR1", CR1, writable=0x0387),
    Register("DIER", DIER, writable=0x0003),
    Register("SR", SR, writable=0x0203),
    Register("EGR", EGR, writable=0x0003),
    Register("CCMR1", CCMR1, writable=0x00FF),
    Register("CCER", CCER, writable=0x000B),
)


def _small(irq: int) -> Kind:
    return Kind(
        bus="APB1",
        irqs=MappingProxyType({0x03: irq}),
        registers=_TIM13,
        channels=1,
        compares=1,
        requests=False,
        master_modes=0,
        master_mode=4,
        both_edges=True,
    )


HIGH_VALUE_LINE_KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        **VALUE_LINE_KINDS,
        "TIM5": replace(HIGH_DENSITY_KINDS["TIM5"], internal_triggers=("TIM2", "TIM3", "TIM4", "TIM15")),
        "TIM12": Kind(
            bus="APB1",
            irqs=MappingProxyType({0x47: 43}),
            registers=_TIM12,
            internal_triggers=("TIM4", "TIM5", "TIM13", "TIM14"),
            channels=2,
            compares=2,
            requests=False,
            master_modes=6,
            both_edges=True,
        ),
        "TIM13": _small(44),
        "TIM14": _small(45),
    }
)
"""The same of high density."""
