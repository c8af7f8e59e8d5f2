"""The STM32H743 and H753 by part number: memory, and what its package brings out (DS12110, DS12117).

The two differ in CRYP and HASH, which only the H753 has; neither is modelled. Parts with 1 MB of flash, whose banks do
not follow each other, are left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal

from targets.mcu.variant import Variant

__all__ = ["MORE_RAM", "VARIANTS", "ChipName", "Variant"]

ChipName = Literal[
    "STM32H743VI",
    "STM32H743ZI",
    "STM32H743II",
    "STM32H743XI",
    "STM32H753VI",
    "STM32H753ZI",
    "STM32H753II",
    "STM32H753XI",
]

_KB = 1024

MORE_RAM = (
    (0x2400_0000, 512 * _KB),  # AXI SRAM
    (0x3000_0000, 288 * _KB),  # SRAM1 128 KB, SRAM2 128 KB and SRAM3 32 KB follow each other
    (0x3800_0000, 64 * _KB),  # SRAM4
)
"""First address and bytes of the RAM behind the interconnect."""


def _pins(whole: str, **more: range) -> frozenset[str]:
    """Return all pins of some ports, and some of others."""
    ranges = dict.fromkeys(whole, range(16)) | more
    return frozenset(f"P{port}{number}" for port, numbers in ranges.items() for number in numbers)


_PACKAGES = {
    "V": _pins("ABCDE", H=range(2)),  # LQFP100: 82 I/Os
    "Z": _pins("ABCDEFG", H=range(2)),  # LQFP144: 114
    "I": _pins("ABCDEFGH", I=range(12)),  # LQFP176 and UFBGA176: 140
    "X": _pins("ABCDEFGHIJ", K=range(8)),  # TFBGA240: 168
}


def _variant(name: str) -> Variant:
    return Variant(
        name=name,
        family="stm32h7",
        flash_bytes=2048 * _KB,
        ram_bytes=128 * _KB,  # DTCM
        more_ram=MORE_RAM,
        pins=_PACKAGES[name[-2]],
        usarts=("USART1", "USART2", "USART3", "UART4", "UART5", "USART6", "UART7", "UART8", "LPUART1"),
        i2cs=("I2C1", "I2C2", "I2C3", "I2C4"),
        spis=("SPI1", "SPI2", "SPI3", "SPI4", "SPI5", "SPI6"),
        itcm_bytes=64 * _KB,
        fastest_hse_hz=50_000_000,  # of a clock; a crystal has 4 to 48 MHz
    )


_NAMES: tuple[ChipName, ...] = (
    *("STM32H743VI", "STM32H743ZI", "STM32H743II", "STM32H743XI"),
    *("STM32H753VI", "STM32H753ZI", "STM32H753II", "STM32H753XI"),
)
VARIANTS: Mapping[str, Variant] = MappingProxyType({name: _variant(name) for name in _NAMES})
"""Every variant by its name."""
