"""What tells one part number of a family of microcontrollers from another: memory, package, what is brought out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

__all__ = ["Family", "Variant"]

Family = Literal["stm32f1", "stm32f7", "stm32h7"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Variant:
    """One part number.

    Attributes:
        name: the part number, without package material and temperature range.
        family: which chip it is one of.
        flash_bytes: main flash memory, from 0x08000000.
        ram_bytes: RAM from 0x20000000.
        more_ram: first address and size of other RAM that programs are linked for.
        pins: names of the I/O pins of the package, ``PA0`` and so on.
        usarts: the USARTs and UARTs whose pins the package brings out.
        i2cs: the I2C interfaces whose pins the package brings out.
        spis: the same of the SPI interfaces that are modelled.
        boot1_pin: the port pin that is BOOT1 at a reset; None where option bytes say where to boot from.
        itcm_bytes: RAM from 0 on, beside the core; 0 where there is none.
        fastest_hse_hz: the highest rate of a clock at OSC_IN.
        flash_alias: where else the flash is seen by a program; None for nowhere that a program is linked for.
    """

    name: str
    family: Family
    flash_bytes: int
    ram_bytes: int
    pins: frozenset[str]
    usarts: tuple[str, ...]
    i2cs: tuple[str, ...] = ()
    spis: tuple[str, ...] = ()
    boot1_pin: str | None = None
    more_ram: tuple[tuple[int, int], ...] = ()
    itcm_bytes: int = 0
    flash_alias: int | None = None
    fastest_hse_hz: int = 25_000_000
