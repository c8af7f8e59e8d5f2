"""The registers of a timer and their bits (RM0008 sections 14.4 and 15.4)."""

from __future__ import annotations

from targets.mcu.registers import Register

__all__ = ["ADVANCED", "GENERAL"]

CR1, CR2, SMCR, DIER, SR, EGR, CCMR1, CCMR2, CCER = range(0x00, 0x24, 4)
CNT, PSC, ARR, RCR, CCR1, CCR2, CCR3, CCR4, BDTR, DCR, DMAR = range(0x24, 0x50, 4)

CEN, UDIS, URS, OPM, DIR, ARPE, CKD = 1 << 0, 1 << 1, 1 << 2, 1 << 3, 1 << 4, 1 << 7, 3 << 8
CCPC, CCUS, CCDS, TI1S = 1 << 0, 1 << 2, 1 << 3, 1 << 7
ECE, ETP = 1 << 14, 1 << 15
UIF, CC_FLAGS, COMIF, TIF, BIF, OVER_FLAGS = 1 << 0, 0x1E, 1 << 5, 1 << 6, 1 << 7, 0x1E00
UDE, COMDE, TDE = 1 << 8, 1 << 13, 1 << 14
UG, COMG, TG, BG = 1 << 0, 1 << 5, 1 << 6, 1 << 7
OSSI, OSSR, BKE, BKP, AOE, MOE = 1 << 10, 1 << 11, 1 << 12, 1 << 13, 1 << 14, 1 << 15
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
"""Of TIM2 to TIM4."""
ADVANCED = _registers(advanced=True)
"""Of TIM1."""
