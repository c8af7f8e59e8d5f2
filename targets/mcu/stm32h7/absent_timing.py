"""The high-resolution timer of the STM32H743 and H753, of which only registers are there (RM0433 section 37.5)."""

from __future__ import annotations

from targets.mcu.stm32.absent import Absent, registers

__all__ = ["HighResolutionTimer"]

_OF_ONE = (
    "CR ISR: ICR DIER CNTR PER=FFDF REP CMP1R CMP1CR CMP2R CMP3R CMP4R CPT1R: CPT2R: DTR SETR1 RSTR1 SETR2 RSTR2 EEFR1 "
    "EEFR2 RSTR CHPR CPT1CR CPT2CR OUTR FLTR"
)


def _timer(index: int, letter: str) -> str:
    return f"@{0x80 + 0x80 * index:X} " + " ".join(f"TIM{letter}{name}" for name in _OF_ONE.split())


class HighResolutionTimer(Absent):
    """The high-resolution timer: nothing counts."""

    MISSING = "nothing counts"
    REGISTERS = registers(
        "MCR MISR: MICR MDIER MCNTR MPER=FFDF MREP MCMP1R @24 MCMP2R MCMP3R MCMP4R "
        + " ".join(_timer(index, letter) for index, letter in enumerate("ABCDE"))
        + " @380 CR1 CR2 ISR: ICR IER OENR ODISR ODSR: BMCR BMTRGR BMCMPR BMPER EECR1 EECR2 EECR3 ADC1R ADC2R ADC3R "
        "ADC4R @3D0 FLTINR1 FLTINR2 BDMUPR BDTAUPR BDTBUPR BDTCUPR BDTDUPR BDTEUPR BDMADR"
    )
