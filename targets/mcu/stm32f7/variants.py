"""The STM32F767 by part number (DS11532 tables 2 and 10)."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal

from targets.mcu.variant import Variant

__all__ = ["VARIANTS", "ChipName", "Variant"]

ChipName = Literal["STM32F767ZG", "STM32F767ZI"]

_KB = 1024
_LQFP144 = frozenset({f"P{port}{number}" for port in "ABCDEFG" for number in range(16)} | {"PH0", "PH1"})  # 114 I/Os
_FLASH_BYTES = {"G": 1024 * _KB, "I": 2048 * _KB}


def _variant(size: str) -> Variant:
    return Variant(
        name=f"STM32F767Z{size}",
        family="stm32f7",
        flash_bytes=_FLASH_BYTES[size],
        ram_bytes=512 * _KB,  # DTCM 128 KB, SRAM1 368 KB and SRAM2 16 KB follow each other
        pins=_LQFP144,
        usarts=("USART1", "USART2", "USART3", "UART4", "UART5", "USART6", "UART7", "UART8"),
        i2cs=("I2C1", "I2C2", "I2C3", "I2C4"),
        itcm_bytes=16 * _KB,
        flash_alias=0x0020_0000,
    )


VARIANTS: Mapping[str, Variant] = MappingProxyType({f"STM32F767Z{size}": _variant(size) for size in _FLASH_BYTES})
"""Every variant by its name."""
