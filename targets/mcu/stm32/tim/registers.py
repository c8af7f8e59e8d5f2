"""The registers of a timer and their bits (RM0008 sections 14.4 and 15.4; RM0410 sections 25.4 to 28.4)."""

from __future__ import annotations

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register

__all__ = [
    "ADVANCED",
    "BASIC",
    "F7_ADVANCED",
    "F7_BASIC",
    "F7_GENERAL_16",
    "F7_GENERAL_32",
    "F7_ONE_CHANNEL",
    "F7_TWO_CHANNELS",
    "GENERAL",
    "TIM2_OPTIONS",
    "TIM5_OPTIONS",
    "TIM11_OPTIONS",
]

CR1, CR2, SMCR, DIER, SR, EGR, CCMR1, CCMR2, CCER = range(0x00, 0x24, 4)
CNT, PSC, ARR, RCR, CCR1, CCR2, CCR3, CCR4, BDTR, DCR, DMAR = range(0x24, 0x50, 4)
OR, CCMR3, CCR5, CCR6, AF1, AF2 = range(0x50, 0x68, 4)
MODES = (CCMR1, CCMR2, CCMR3)
"""Where the modes of a pair of channels are."""
COMPARES = (CCR1, CCR2, CCR3, CCR4, CCR5, CCR6)
EVERY_OFFSET = range(0x00, 0x68, 4)

CEN, UDIS, URS, OPM, DIR, ARPE, CKD = 1 << 0, 1 << 1, 1 << 2, 1 << 3, 1 << 4, 1 << 7, 3 << 8
UIFREMAP, UIFCPY = 1 << 11, 1 << 31
CCPC, CCUS, CCDS, TI1S = 1 << 0, 1 << 2, 1 << 3, 1 << 7
ECE, ETP = 1 << 14, 1 << 15
UIF, CC_FLAGS, COMIF, TIF, BIF, OVER_FLAGS = 1 << 0, 0x1E, 1 << 5, 1 << 6, 1 << 7, 0x1E00
B2IF, CC56_FLAGS = 1 << 8, 3 << 16
UDE, COMDE, TDE = 1 << 8, 1 << 13, 1 << 14
UG, COMG, TG, BG, B2G = 1 << 0, 1 << 5, 1 << 6, 1 << 7, 1 << 8
OSSI, OSSR, BKE, BKP, AOE, MOE = 1 << 10, 1 << 11, 1 << 12, 1 << 13, 1 << 14, 1 << 15
BKF, BK2F, BK2E, BK2P = 0xF << 16, 0xF << 20, 1 << 24, 1 << 25
MMS_RESET, MMS_ENABLE, MMS_UPDATE, MMS_COMPARE = range(4)

_TRIGGERS = "triggers take effect at once, with MSM or without; encoder mode 1 counts edges of TI2, mode 2 of TI1"
_INPUTS = "an edge takes effect at its cycle: the two or three clocks of resynchronisation are left out"


def _registers(*, advanced: bool) -> tuple[Register, ...]:
    common = (
        Register("CR1", CR1, writable=0x03FF),
        Register("CR2", CR2, writable=0x7FFD if advanced else 0x00F8),
        Register("SMCR", SMCR, writable=0xFFF7, note=_TRIGGERS),
        Register("DIER", DIER, writable=0x7FFF if advanced else 0x5F5F),
        Register("SR", SR, writable=0x1EFF if advanced else 0x1E5F),
        Register("EGR", EGR, writable=0xFF if advanced else 0x5F),
        Register("CCMR1", CCMR1, writable=0xFFFF, note=_INPUTS),
        Register("CCMR2", CCMR2, writable=0xFFFF, note=_INPUTS),
        Register("CCER", CCER, writable=0x3FFF if advanced else 0x3333),
        Register("CNT", CNT, writable=0xFFFF, live=True),
        Register("PSC", PSC, writable=0xFFFF),
        Register("ARR", ARR, reset=0xFFFF, writable=0xFFFF),
        Register("CCR1", CCR1, writable=0xFFFF),
        Register("CCR2", CCR2, writable=0xFFFF),
        Register("CCR3", CCR3, writable=0xFFFF),
        Register("CCR4", CCR4, writable=0xFFFF),
        Register("DCR", DCR, writable=0x1F1F),
        Register("DMAR", DMAR, writable=0xFFFF),
    )
    if not advanced:
        return common
    more = (Register("RCR", RCR, writable=0xFF), Register("BDTR", BDTR, writable=0xFFFF))
    return tuple(sorted(common + more, key=lambda register: register.offset))


GENERAL = _registers(advanced=False)
"""Of TIM2 to TIM5."""
ADVANCED = _registers(advanced=True)
"""Of TIM1 and TIM8."""
BASIC = (
    Register("CR1", CR1, writable=0x008F),
    Register("CR2", CR2, writable=0x0070),
    Register("DIER", DIER, writable=0x0101),
    Register("SR", SR, writable=0x0001),
    Register("EGR", EGR, writable=0x0001),
    Register("CNT", CNT, writable=0xFFFF, live=True),
    Register("PSC", PSC, writable=0xFFFF),
    Register("ARR", ARR, reset=0xFFFF, writable=0xFFFF),
)
"""Of TIM6 and TIM7 (RM0008 section 17.4)."""


# --- STM32F7

_TRGO2 = "MMS2 is remembered without effect: there is no TRGO2"
_FILTERS = "the break inputs are not filtered (BKF, BK2F)"
_DFSDM = "breaks by the DFSDM and the polarity of the pin are not modelled"


def _f7(name: str, offset: int, writable: int, reset: int = 0, ignored: int = 0, note: str = "") -> Register:
    partly = Fidelity.PARTLY if ignored else Fidelity.MODELLED
    return Register(name, offset, reset, writable, ignored, live=name == "CNT", fidelity=partly, note=note)


def _f7_full(bits: int) -> tuple[Register, ...]:
    """What TIM1 to TIM5 and TIM8 have in common."""
    word = (1 << bits) - 1
    return (
        _f7("CR1", CR1, 0x0BFF),
        _f7("SMCR", SMCR, 0x1_FFF7, note=_TRIGGERS),
        _f7("CCMR1", CCMR1, 0x0101_FFFF, note=_INPUTS),
        _f7("CCMR2", CCMR2, 0x0101_FFFF, note=_INPUTS),
        _f7("CNT", CNT, word),
        _f7("PSC", PSC, 0xFFFF),
        _f7("ARR", ARR, word, reset=word),
        *(_f7(f"CCR{number + 1}", CCR1 + 4 * number, word) for number in range(4)),
        _f7("DCR", DCR, 0x1F1F),
        _f7("DMAR", DMAR, 0xFFFF_FFFF),
    )


def _f7_general(bits: int) -> tuple[Register, ...]:
    return (
        *_f7_full(bits),
        _f7("CR2", CR2, 0x00F8),
        _f7("DIER", DIER, 0x5F5F),
        _f7("SR", SR, 0x1E5F),
        _f7("EGR", EGR, 0x5F),
        _f7("CCER", CCER, 0xBBBB),
    )


F7_GENERAL_16 = _f7_general(16)
"""Of TIM3 and TIM4 (RM0410 section 26.4)."""
F7_GENERAL_32 = _f7_general(32)
"""Of TIM2 and TIM5."""
F7_ADVANCED = (
    *_f7_full(16),
    _f7("CR2", CR2, 0x00F5_7FFD, ignored=0x00F0_0000, note=_TRGO2),
    _f7("DIER", DIER, 0x7FFF),
    _f7("SR", SR, 0x3_1FFF),
    _f7("EGR", EGR, 0x1FF),
    _f7("CCER", CCER, 0x33_BFFF),
    _f7("RCR", RCR, 0xFFFF),
    _f7("BDTR", BDTR, 0x03FF_FFFF, ignored=BKF | BK2F, note=_FILTERS),
    _f7("CCMR3", CCMR3, 0x0101_FCFC),
    _f7("CCR5", CCR5, 0xE000_FFFF),
    _f7("CCR6", CCR6, 0xFFFF),
    _f7("AF1", AF1, 0x0101, reset=0x1, ignored=0x100, note=_DFSDM),
    _f7("AF2", AF2, 0x0101, reset=0x1, ignored=0x100, note=_DFSDM),
)
"""Of TIM1 and TIM8 (RM0410 section 25.4)."""
F7_BASIC = (
    _f7("CR1", CR1, 0x088F),
    _f7("CR2", CR2, 0x0070),
    _f7("DIER", DIER, 0x0101),
    _f7("SR", SR, 0x0001),
    _f7("EGR", EGR, 0x0001),
    _f7("CNT", CNT, 0xFFFF),
    _f7("PSC", PSC, 0xFFFF),
    _f7("ARR", ARR, 0xFFFF, reset=0xFFFF),
)
"""Of TIM6 and TIM7 (RM0410 section 28.4)."""
F7_ONE_CHANNEL = (
    _f7("CR1", CR1, 0x0B8F),
    _f7("DIER", DIER, 0x0003),
    _f7("SR", SR, 0x0203),
    _f7("EGR", EGR, 0x0003),
    _f7("CCMR1", CCMR1, 0x1_00FF, note=_INPUTS),
    _f7("CCER", CCER, 0x000B),
    _f7("CNT", CNT, 0xFFFF),
    _f7("PSC", PSC, 0xFFFF),
    _f7("ARR", ARR, 0xFFFF, reset=0xFFFF),
    _f7("CCR1", CCR1, 0xFFFF),
)
"""Of TIM10, TIM11, TIM13 and TIM14 (RM0410 section 27.5)."""
F7_TWO_CHANNELS = (
    _f7("CR1", CR1, 0x0B8F),
    _f7("SMCR", SMCR, 0x1_00F7, note=_TRIGGERS),
    _f7("DIER", DIER, 0x0047),
    _f7("SR", SR, 0x0647),
    _f7("EGR", EGR, 0x0047),
    _f7("CCMR1", CCMR1, 0x0101_FFFF, note=_INPUTS),
    _f7("CCER", CCER, 0x00BB),
    _f7("CNT", CNT, 0xFFFF),
    _f7("PSC", PSC, 0xFFFF),
    _f7("ARR", ARR, 0xFFFF, reset=0xFFFF),
    _f7("CCR1", CCR1, 0xFFFF),
    _f7("CCR2", CCR2, 0xFFFF),
)
"""Of TIM9 and TIM12 (RM0410 section 27.4)."""


def _options(field: int, note: str) -> tuple[Register, ...]:
    return (_f7("OR", OR, field, ignored=field, note=note),)


TIM2_OPTIONS = _options(0x0C00, "ITR1 is the trigger of TIM8: other sources (ITR1_RMP) are not modelled")
TIM5_OPTIONS = _options(0x00C0, "TI4 is the pin: oscillators and the RTC (TI4_RMP) are not modelled")
TIM11_OPTIONS = _options(0x0003, "TI1 is the pin: SPDIFRX, HSE and MCO1 (TI1_RMP) are not modelled")
