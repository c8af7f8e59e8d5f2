"""Which chip a family of microcontrollers is; its blocks are loaded when it is asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from targets.mcu.variant import Family

if TYPE_CHECKING:
    from targets.mcu.chip import Chip

__all__ = ["chip_of"]


def chip_of(family: Family) -> type[Chip]:
    """Return the chip of a family."""
    if family == "stm32f1":
        from targets.mcu.stm32f1.chip import Stm32f103

        return Stm32f103
    if family == "stm32h7":
        from targets.mcu.stm32h7.chip import Stm32h753

        return Stm32h753
    from targets.mcu.stm32f7.chip import Stm32f767

    return Stm32f767
