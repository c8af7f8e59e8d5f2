"""The STM32F767 by part number: memory, and what its package brings out (DS11532 tables 2 and 10)."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal

from targets.mcu.variant import Variant

__all__ = ["VARIANTS", "ChipName", "Variant"]

ChipName = Literal[
    "STM32F767VG",
    "STM32F767VI",
    "STM32F767ZG",
    "STM32F767ZI",
    "STM32F767IG",
    "STM32F767II",
    "STM32F767BG",
    "STM32F767BI",
    "STM32F767NG",
    "STM32F767NI",
]

_KB = 1024


def _pins(whole: str, **more: int) -> frozenset[str]:
    """Return all pins of some ports, and the first ones of others."""
    counts = dict.fromkeys(whole, 16) | more
    return frozenset(f"P{port}{number}" for port, count in counts.items() for number in range(count))


_PACKAGES = {
    "V": _pins("ABCDE", H=2),  # LQFP100 and TFBGA100: 82 I/Os
    "Z": _pins("ABCDEFG", H=2),  # LQFP144: 114
    "I": _pins("ABCDEFGH", I=12),  # LQFP176 and UFBGA176: 140
    "B": _pins("ABCDEFGHIJ", K=8),  # LQFP208: 168
    "N": _pins("ABCDEFGHIJ", K=8),  # TFBGA216: 168
}
_FLASH_BYTES = {"G": 1024 * _KB, "I": 2048 * _KB}


def _variant(package: str, size: str) -> Variant:
    return Variant(
        name=f"STM32F767{package}{size}",
        family="stm32f7",
        flash_bytes=_FLASH_BYTES[size],
        ram_bytes=512 * _KB,  # DTCM 128 KB, SRAM1 368 KB and SRAM2 16 KB follow each other
        pins=_PACKAGES[package],
        usarts=("USART1", "USART2", "USART3", "UART4", "UART5", "USART6", "UART7", "UART8"),
        i2cs=("I2C1", "I2C2", "I2C3", "I2C4"),
        spis=("SPI1", "SPI2", "SPI3", "SPI4", *(("SPI5", "SPI6") if package != "V" else ())),
        itcm_bytes=16 * _KB,
        flash_alias=0x0020_0000,
        fastest_hse_hz=50_000_000,  # of a clock; a crystal has 4 to 26 MHz
    )


VARIANTS: Mapping[str, Variant] = MappingProxyType(
    {f"STM32F767{package}{size}": _variant(package, size) for package in _PACKAGES for size in _FLASH_BYTES}
)
"""Every variant by its name."""
