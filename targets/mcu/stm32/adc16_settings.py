"""What the registers of a 16-bit ADC ask for: sequences, sampling times, resolution, offsets, watchdogs (RM0433 25.5).

Each function takes the values of the registers by offset.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from targets.mcu.stm32.adc16_data import BITS, SAMPLING_CLOCKS, outside, with_offset
from targets.mcu.stm32.adc16_registers import (
    AWD1,
    AWD1SGL,
    AWD2,
    AWD2CR,
    AWD3,
    AWD3CR,
    CFGR,
    CFGR2,
    DISCEN,
    HTR1,
    HTR2,
    HTR3,
    JSQR,
    LTR1,
    LTR2,
    LTR3,
    OFR1,
    ROVSE,
    SMPR1,
    SMPR2,
    SQR1,
    SQR2,
    SQR3,
    SQR4,
    SSATE,
    TROVS,
)

__all__ = ["injected_sequence", "less_offset", "resolution", "sampling", "sequence", "steps", "watch"]

_SUM_BITS = 26  # of 1024 results of 16 bits
_OFFSET = 0x03FF_FFFF

Values = Mapping[int, int]


def sequence(values: Values) -> list[int]:
    """Return the channels of the regular group by rank."""
    fields = [values[SQR1] >> 6 * place & 0x1F for place in range(1, 5)]
    fields += [values[register] >> 6 * place & 0x1F for register in (SQR2, SQR3, SQR4) for place in range(5)]
    return fields[: (values[SQR1] & 0xF) + 1]


def injected_sequence(values: Values) -> list[int]:
    """Return the channels of the injected group by rank."""
    return [values[JSQR] >> 9 + 6 * rank & 0x1F for rank in range((values[JSQR] & 3) + 1)]


def steps(values: Values) -> int:
    """Return how many conversions of the sequence a regular trigger makes; 0 for all of them."""
    if values[CFGR2] & ROVSE and values[CFGR2] & TROVS:
        return 1
    return (values[CFGR] >> 17 & 7) + 1 if values[CFGR] & DISCEN else 0


def sampling(values: Values, channel: int) -> Fraction:
    """Return the sampling time of a channel in clocks."""
    register, place = (SMPR1, channel) if channel < 10 else (SMPR2, channel - 10)
    return SAMPLING_CLOCKS[values[register] >> 3 * place & 7]


def resolution(values: Values) -> int:
    """Return the bits of a conversion."""
    return BITS[values[CFGR] >> 2 & 7]


def less_offset(values: Values, channel: int, value: int) -> int:
    """Return a result less the offset of its channel, if one of the four is for it; the first of them counts."""
    bits = _SUM_BITS if values[CFGR2] & ROVSE else resolution(values)
    for number in range(4):
        register = values[OFR1 + 4 * number]
        if register & _OFFSET and register >> 26 & 0x1F == channel:
            return with_offset(value, register & _OFFSET, bits, saturate=bool(register & SSATE))
    return value


def watch(values: Values, channel: int, value: int, enable: int) -> int:
    """Return the flags of the analog watchdogs that a result sets off.

    Args:
        values: of the registers.
        channel: that was converted.
        value: of the conversion, before an offset is subtracted.
        enable: the bit of CFGR that has watchdog 1 look at the group.
    """
    cfgr = values[CFGR]
    first = cfgr & enable and not (cfgr & AWD1SGL and channel != cfgr >> 26 & 0x1F)
    bits = _SUM_BITS if values[CFGR2] & ROVSE else resolution(values)
    flags = 0
    for flag, watches, low, high in (
        (AWD1, first, LTR1, HTR1),
        (AWD2, values[AWD2CR] >> channel & 1, LTR2, HTR2),
        (AWD3, values[AWD3CR] >> channel & 1, LTR3, HTR3),
    ):
        if watches and outside(value, bits, values[low], values[high]):
            flags |= flag
    return flags
