"""What differs between timers, of the same family and between families, as data; those of the H7 are `h7_kinds`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

from targets.mcu.registers import Register
from targets.mcu.stm32.tim.registers import (
    ADVANCED,
    BASIC,
    F7_ADVANCED,
    F7_BASIC,
    F7_GENERAL_16,
    F7_GENERAL_32,
    F7_ONE_CHANNEL,
    F7_TWO_CHANNELS,
    GENERAL,
    TIM2_OPTIONS,
    TIM5_OPTIONS,
    TIM11_OPTIONS,
)

__all__ = ["F7_KINDS", "HIGH_DENSITY_KINDS", "KINDS", "Kind"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Kind:
    """One timer.

    Attributes:
        bus: the bus whose timer clock it runs on.
        irqs: interrupt number for masks of SR, which are those of DIER as well.
        registers: what it has.
        internal_triggers: the timers behind ITR0 to ITR3, or None where there is none.
        advanced: whether it has repetition counter, complementary outputs, dead time and break.
        second_break: whether it has a second break input.
        bits: of the counter.
        channels: how many have pins, and
        compares: how many compare units there are.
        complements: how many of the channels of an advanced timer have a complementary output.
        requests: whether it asks for DMA.
        master_modes: how many values of MMS there are.
        master_mode: the mode that it always has as a master, if it has no MMS: 4 is OC1REF, None is no master.
        both_edges: whether CCxP and CCxNP together choose both edges of an input.
        extended: whether SMS and OCxM have a fourth bit.
    """

    bus: str
    irqs: Mapping[int, int]
    registers: tuple[Register, ...]
    internal_triggers: tuple[str | None, ...] = (None, None, None, None)
    advanced: bool = False
    second_break: bool = False
    bits: int = 16
    channels: int = 4
    compares: int = 4
    complements: int = 3
    requests: bool = True
    master_modes: int = 8
    master_mode: int | None = None
    both_edges: bool = False
    extended: bool = False


# --- STM32F1: RM0008 tables 63 (interrupts), 82 and 86 (internal triggers)


def _general(irq: int, *internal_triggers: str | None) -> Kind:
    return Kind(bus="APB1", irqs=MappingProxyType({0x5F: irq}), registers=GENERAL, internal_triggers=internal_triggers)


def _basic(irq: int) -> Kind:
    return Kind(bus="APB1", irqs=MappingProxyType({0x01: irq}), registers=BASIC, channels=0, compares=0, master_modes=3)


KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "TIM1": Kind(
            bus="APB2",
            irqs=MappingProxyType({0x80: 24, 0x01: 25, 0x60: 26, 0x1E: 27}),  # BRK, UP, TRG_COM, CC
            registers=ADVANCED,
            internal_triggers=(None, "TIM2", "TIM3", "TIM4"),
            advanced=True,
        ),
        "TIM2": _general(28, "TIM1", None, "TIM3", "TIM4"),
        "TIM3": _general(29, "TIM1", "TIM2", None, "TIM4"),
        "TIM4": _general(30, "TIM1", "TIM2", "TIM3", None),
    }
)
"""Every timer of the medium-density STM32F103 by its name."""

HIGH_DENSITY_KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "TIM1": replace(KINDS["TIM1"], internal_triggers=("TIM5", "TIM2", "TIM3", "TIM4")),
        "TIM2": _general(28, "TIM1", "TIM8", "TIM3", "TIM4"),
        "TIM3": _general(29, "TIM1", "TIM2", "TIM5", "TIM4"),
        "TIM4": _general(30, "TIM1", "TIM2", "TIM3", "TIM8"),
        "TIM5": _general(50, "TIM2", "TIM3", "TIM4", "TIM8"),
        "TIM6": _basic(54),
        "TIM7": _basic(55),
        "TIM8": Kind(
            bus="APB2",
            irqs=MappingProxyType({0x80: 43, 0x01: 44, 0x60: 45, 0x1E: 46}),
            registers=ADVANCED,
            internal_triggers=("TIM1", "TIM2", "TIM4", "TIM5"),
            advanced=True,
        ),
    }
)
"""Every timer of the high-density STM32F103 by its name."""


# --- STM32F7: RM0410 table of the vectors; internal triggers in sections 25.4.3, 26.4.3, 27.4.3 (SMCR)


def _f7_advanced(irqs: tuple[int, int, int, int], *internal_triggers: str) -> Kind:
    return Kind(
        bus="APB2",
        irqs=MappingProxyType(dict(zip((0x80, 0x01, 0x60, 0x1E), irqs, strict=True))),
        registers=F7_ADVANCED,
        internal_triggers=internal_triggers,
        advanced=True,
        second_break=True,
        compares=6,
        both_edges=True,
        extended=True,
    )


def _f7_general(irq: int, bits: int, options: tuple[Register, ...], *internal_triggers: str) -> Kind:
    return Kind(
        bus="APB1",
        irqs=MappingProxyType({0x5F: irq}),
        registers=(F7_GENERAL_32 if bits == 32 else F7_GENERAL_16) + options,
        internal_triggers=internal_triggers,
        bits=bits,
        both_edges=True,
        extended=True,
    )


def _f7_basic(irq: int) -> Kind:
    return Kind(
        bus="APB1", irqs=MappingProxyType({0x01: irq}), registers=F7_BASIC, channels=0, compares=0, master_modes=3
    )


def _f7_two_channels(bus: str, irq: int, *internal_triggers: str) -> Kind:
    return Kind(
        bus=bus,
        irqs=MappingProxyType({0x47: irq}),
        registers=F7_TWO_CHANNELS,
        internal_triggers=internal_triggers,
        channels=2,
        compares=2,
        requests=False,
        master_modes=0,
        both_edges=True,
        extended=True,
    )


def _f7_one_channel(bus: str, irq: int, options: tuple[Register, ...] = ()) -> Kind:
    return Kind(
        bus=bus,
        irqs=MappingProxyType({0x03: irq}),
        registers=F7_ONE_CHANNEL + options,
        channels=1,
        compares=1,
        requests=False,
        master_modes=0,
        master_mode=4,
        both_edges=True,
        extended=True,
    )


F7_KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "TIM1": _f7_advanced((24, 25, 26, 27), "TIM5", "TIM2", "TIM3", "TIM4"),
        "TIM2": _f7_general(28, 32, TIM2_OPTIONS, "TIM1", "TIM8", "TIM3", "TIM4"),
        "TIM3": _f7_general(29, 16, (), "TIM1", "TIM2", "TIM5", "TIM4"),
        "TIM4": _f7_general(30, 16, (), "TIM1", "TIM2", "TIM3", "TIM8"),
        "TIM5": _f7_general(50, 32, TIM5_OPTIONS, "TIM2", "TIM3", "TIM4", "TIM8"),
        "TIM6": _f7_basic(54),
        "TIM7": _f7_basic(55),
        "TIM8": _f7_advanced((43, 44, 45, 46), "TIM1", "TIM2", "TIM4", "TIM5"),
        "TIM9": _f7_two_channels("APB2", 24, "TIM2", "TIM3", "TIM10", "TIM11"),
        "TIM10": _f7_one_channel("APB2", 25),
        "TIM11": _f7_one_channel("APB2", 26, TIM11_OPTIONS),
        "TIM12": _f7_two_channels("APB1", 43, "TIM4", "TIM5", "TIM13", "TIM14"),
        "TIM13": _f7_one_channel("APB1", 44),
        "TIM14": _f7_one_channel("APB1", 45),
    }
)
"""Every timer of the STM32F7 by its name; TIM9 to TIM14 share interrupts with TIM1 and TIM8."""
