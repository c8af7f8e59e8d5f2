"""The STM32F103 and STM32F100 by part number: memory, and what the package brings out.

DS5944 (STM32F100), DS6087 (x4, x6), DS5319 (x8, xB) and DS5792 (xC, xD, xE): device features, pin definitions.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal, get_args

from targets.mcu.variant import Variant

__all__ = ["VARIANTS", "ChipName", "Variant"]

ChipName = Literal[
    "STM32F100C4",
    "STM32F100C6",
    "STM32F100C8",
    "STM32F100CB",
    "STM32F100R4",
    "STM32F100R6",
    "STM32F100R8",
    "STM32F100RB",
    "STM32F100V8",
    "STM32F100VB",
    "STM32F100RC",
    "STM32F100RD",
    "STM32F100RE",
    "STM32F100VC",
    "STM32F100VD",
    "STM32F100VE",
    "STM32F100ZC",
    "STM32F100ZD",
    "STM32F100ZE",
    "STM32F103T4",
    "STM32F103T6",
    "STM32F103T8",
    "STM32F103TB",
    "STM32F103C4",
    "STM32F103C6",
    "STM32F103C8",
    "STM32F103CB",
    "STM32F103R4",
    "STM32F103R6",
    "STM32F103R8",
    "STM32F103RB",
    "STM32F103RC",
    "STM32F103RD",
    "STM32F103RE",
    "STM32F103V8",
    "STM32F103VB",
    "STM32F103VC",
    "STM32F103VD",
    "STM32F103VE",
    "STM32F103ZC",
    "STM32F103ZD",
    "STM32F103ZE",
]

_KB = 1024
_ALL = range(16)


def _pins(**ports: range) -> frozenset[str]:
    return frozenset(f"P{port}{number}" for port, numbers in ports.items() for number in numbers)


_PACKAGES = {
    "T": _pins(A=_ALL, B=range(8), D=range(2)),  # VFQFPN36: 26 I/Os
    "C": _pins(A=_ALL, B=_ALL, C=range(13, 16), D=range(2)),  # LQFP48: 37
    "R": _pins(A=_ALL, B=_ALL, C=_ALL, D=range(3)),  # LQFP64: 51
    "V": _pins(A=_ALL, B=_ALL, C=_ALL, D=_ALL, E=_ALL),  # LQFP100: 80
    "Z": _pins(A=_ALL, B=_ALL, C=_ALL, D=_ALL, E=_ALL, F=_ALL, G=_ALL),  # LQFP144: 112
}
_SIZES_KB = {"4": (16, 6), "6": (32, 10), "8": (64, 20), "B": (128, 20), "C": (256, 48), "D": (384, 64), "E": (512, 64)}
_VALUE_LINE_KB = {
    "4": (16, 4),
    "6": (32, 4),
    "8": (64, 8),
    "B": (128, 8),
    "C": (256, 24),
    "D": (384, 32),
    "E": (512, 32),
}


def _variant(name: ChipName) -> Variant:
    package, size = name[-2], name[-1]
    flash_kb, ram_kb = (_VALUE_LINE_KB if name.startswith("STM32F100") else _SIZES_KB)[size]
    usarts: tuple[str, ...] = ("USART1", "USART2")
    i2cs: tuple[str, ...] = ("I2C1",)
    spis: tuple[str, ...] = ("SPI1",)
    if package != "T" and size not in "46":
        usarts, i2cs, spis = (*usarts, "USART3"), (*i2cs, "I2C2"), (*spis, "SPI2")
    if size in "CDE":
        usarts, spis = (*usarts, "UART4", "UART5"), (*spis, "SPI3")
    return Variant(
        name=name,
        family="stm32f1",
        flash_bytes=flash_kb * _KB,
        ram_bytes=ram_kb * _KB,
        pins=_PACKAGES[package],
        usarts=usarts,
        i2cs=i2cs,
        spis=spis,
        boot1_pin="PB2",
    )


VARIANTS: Mapping[str, Variant] = MappingProxyType({name: _variant(name) for name in get_args(ChipName)})
"""Every variant by its name."""
