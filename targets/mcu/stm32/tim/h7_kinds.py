"""The timers of the STM32H7: registers, interrupts and masters (RM0433 sections 38 to 42).

What differs from the STM32F7: the inputs may come from elsewhere than pins (AF1, AF2, TISEL), there are more internal
triggers (the two upper bits of TS), TIM12 is a master, and TIM15 to TIM17 have a complementary output and a break.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.stm32.tim.kinds import Kind
from targets.mcu.stm32.tim.registers import (
    AF1,
    AF2,
    ARR,
    BDTR,
    BKF,
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
    F7_ADVANCED,
    F7_BASIC,
    F7_GENERAL_16,
    F7_GENERAL_32,
    F7_ONE_CHANNEL,
    F7_TWO_CHANNELS,
    PSC,
    RCR,
    SMCR,
    SR,
)

__all__ = ["H7_KINDS"]

TISEL = 0x68
_MORE_TRIGGERS = 0x0030_0000  # TS[4:3]

_TRIGGERS = "ITR4 and above (TS[4:3]) are not modelled: Ethernet, USB, CAN and HRTIM never trigger"
_INPUTS = "the inputs are the pins: other sources (TISEL, ETRSEL) are not modelled"
_BREAKS = "the break is the pin with its polarity: comparators and DFSDM, and BKINP, are not modelled"


def _register(name: str, offset: int, writable: int, reset: int = 0, ignored: int = 0, note: str = "") -> Register:
    partly = Fidelity.PARTLY if ignored else Fidelity.MODELLED
    return Register(name, offset, reset, writable, ignored, live=name == "CNT", fidelity=partly, note=note)


def _with(registers: Iterable[Register], *more: Register) -> tuple[Register, ...]:
    """Return registers with others in the place of those at the same offset, and besides."""
    by_offset = {register.offset: register for register in registers} | {register.offset: register for register in more}
    return tuple(by_offset.values())


def _smcr(writable: int) -> Register:
    return _register("SMCR", SMCR, writable | _MORE_TRIGGERS, ignored=_MORE_TRIGGERS, note=_TRIGGERS)


def _tisel(channels: int) -> Register:
    mask = sum(0xF << 8 * channel for channel in range(channels))
    return _register("TISEL", TISEL, mask, ignored=mask, note=_INPUTS)


def _break_sources(name: str, offset: int, *, etrsel: bool = False) -> Register:
    writable = 0x0F07 | (0x3_C000 if etrsel else 0)
    return _register(name, offset, writable, reset=1, ignored=writable & ~1, note=_BREAKS)


_ETRSEL = _register("AF1", AF1, 0x3_C000, ignored=0x3_C000, note=_INPUTS)
_ADVANCED = _with(
    F7_ADVANCED, _smcr(0x1_FFF7), _break_sources("AF1", AF1, etrsel=True), _break_sources("AF2", AF2), _tisel(4)
)
_GENERAL_16 = _with(F7_GENERAL_16, _smcr(0x1_FFF7), _ETRSEL, _tisel(4))
_GENERAL_32 = _with(F7_GENERAL_32, _smcr(0x1_FFF7), _ETRSEL, _tisel(4))
_ONE_CHANNEL = _with(F7_ONE_CHANNEL, _tisel(1))
_TWO_CHANNELS = _with(F7_TWO_CHANNELS, _register("CR2", CR2, 0x00F0), _smcr(0x1_00F7), _tisel(2))
_WITH_BREAK = (
    _register("CR1", CR1, 0x0B8F),
    _register("CNT", CNT, 0xFFFF),
    _register("PSC", PSC, 0xFFFF),
    _register("ARR", ARR, 0xFFFF, reset=0xFFFF),
    _register("RCR", RCR, 0x00FF),
    _register("CCR1", CCR1, 0xFFFF),
    _register("BDTR", BDTR, 0x000F_FFFF, ignored=BKF, note="the break input is not filtered (BKF)"),
    _register("DCR", DCR, 0x1F1F),
    _register("DMAR", DMAR, 0xFFFF),
    _break_sources("AF1", AF1),
)
_TIM15 = (
    *_WITH_BREAK,
    _register("CR2", CR2, 0x07FD),
    _smcr(0x1_00F7),
    _register("DIER", DIER, 0x67E7),
    _register("SR", SR, 0x06E7),
    _register("EGR", EGR, 0x00E7),
    _register("CCMR1", CCMR1, 0x0101_FFFF),
    _register("CCER", CCER, 0x00BF),
    _register("CCR2", CCR2, 0xFFFF),
    _tisel(2),
)
_TIM16 = (
    *_WITH_BREAK,
    _register("CR2", CR2, 0x030D),
    _register("DIER", DIER, 0x03A3),
    _register("SR", SR, 0x02A3),
    _register("EGR", EGR, 0x00A3),
    _register("CCMR1", CCMR1, 0x1_00FF),
    _register("CCER", CCER, 0x000F),
    _tisel(1),
)


def _kind(
    bus: str,
    irqs: Mapping[int, int],
    registers: tuple[Register, ...],
    *masters: str,
    advanced: bool = False,
    second_break: bool = False,
    bits: int = 16,
    channels: int = 4,
    compares: int | None = None,
    complements: int = 3,
    requests: bool = True,
    master_modes: int = 8,
    master_mode: int | None = None,
) -> Kind:
    """Return a kind with what all of them have."""
    return Kind(
        bus=bus,
        irqs=MappingProxyType(dict(irqs)),
        registers=registers,
        internal_triggers=masters or (None, None, None, None),
        advanced=advanced,
        second_break=second_break,
        bits=bits,
        channels=channels,
        compares=channels if compares is None else compares,
        complements=complements,
        requests=requests,
        master_modes=master_modes,
        master_mode=master_mode,
        both_edges=channels > 0,
        extended=channels > 0,
    )


def _advanced(irqs: tuple[int, int, int, int], *masters: str) -> Kind:
    """Break, update, trigger with commutation, and compare have an interrupt each."""
    by_mask = dict(zip((0x80, 0x01, 0x60, 0x1E), irqs, strict=True))
    return _kind("APB2", by_mask, _ADVANCED, *masters, advanced=True, second_break=True, compares=6)


def _general(irq: int, bits: int, *masters: str) -> Kind:
    return _kind("APB1", {0x5F: irq}, _GENERAL_32 if bits == 32 else _GENERAL_16, *masters, bits=bits)


def _basic(irq: int) -> Kind:
    return _kind("APB1", {0x01: irq}, F7_BASIC, channels=0, master_modes=3)


def _one_channel(irq: int) -> Kind:
    return _kind("APB1", {0x03: irq}, _ONE_CHANNEL, channels=1, requests=False, master_modes=0, master_mode=4)


def _with_break(irq: int) -> Kind:
    return _kind("APB2", {0xA3: irq}, _TIM16, advanced=True, channels=1, complements=1, master_modes=0, master_mode=4)


H7_KINDS: Mapping[str, Kind] = MappingProxyType(
    {
        "TIM1": _advanced((24, 25, 26, 27), "TIM15", "TIM2", "TIM3", "TIM4"),
        "TIM2": _general(28, 32, "TIM1", "TIM8", "TIM3", "TIM4"),
        "TIM3": _general(29, 16, "TIM1", "TIM2", "TIM15", "TIM4"),
        "TIM4": _general(30, 16, "TIM1", "TIM2", "TIM3", "TIM8"),
        "TIM5": _general(50, 32, "TIM1", "TIM8", "TIM3", "TIM4"),
        "TIM6": _basic(54),
        "TIM7": _basic(55),
        "TIM8": _advanced((43, 44, 45, 46), "TIM1", "TIM2", "TIM4", "TIM5"),
        "TIM12": _kind(
            "APB1",
            {0x47: 43},
            _TWO_CHANNELS,
            *("TIM4", "TIM5", "TIM13", "TIM14"),
            channels=2,
            requests=False,
            master_modes=6,
        ),
        "TIM13": _one_channel(44),
        "TIM14": _one_channel(45),
        "TIM15": _kind(
            "APB2",
            {0xE7: 116},
            _TIM15,
            *("TIM1", "TIM3", "TIM16", "TIM17"),
            advanced=True,
            channels=2,
            complements=1,
            master_modes=6,
        ),
        "TIM16": _with_break(117),
        "TIM17": _with_break(118),
    }
)
"""Every timer of the STM32H743 and H753 by its name; TIM12 to TIM14 share interrupts with TIM8."""
