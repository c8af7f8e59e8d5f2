"""The medium-density STM32F103 by part number: memory, and what its package brings out (DS5319 tables 2 and 5)."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal

from targets.mcu.variant import Variant

__all__ = ["VARIANTS", "ChipName", "Variant"]

ChipName = Literal[
    "STM32F103T8",
    "STM32F103TB",
    "STM32F103C8",
    "STM32F103CB",
    "STM32F103R8",
    "STM32F103RB",
    "STM32F103V8",
    "STM32F103VB",
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
}
_FLASH_BYTES = {"8": 64 * _KB, "B": 128 * _KB}


def _variant(package: str, size: str) -> Variant:
    usarts = ("USART1", "USART2") if package == "T" else ("USART1", "USART2", "USART3")
    return Variant(
        name=f"STM32F103{package}{size}",
        family="stm32f1",
        flash_bytes=_FLASH_BYTES[size],
        ram_bytes=20 * _KB,
        pins=_PACKAGES[package],
        usarts=usarts,
        boot1_pin="PB2",
    )


VARIANTS: Mapping[str, Variant] = MappingProxyType(
    {f"STM32F103{package}{size}": _variant(package, size) for package in _PACKAGES for size in _FLASH_BYTES}
)
"""Every variant by its name."""
