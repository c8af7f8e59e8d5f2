"""Which chip a part number is; its blocks are loaded when it is asked for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from targets.mcu.variant import Variant

if TYPE_CHECKING:
    from targets.mcu.chip import Chip

__all__ = ["chip_of"]


def chip_of(variant: Variant) -> type[Chip]:
    """Return the chip that a part number is."""
    if variant.family == "stm32f1":
        from targets.mcu.stm32f1 import chip as stm32f1

        return stm32f1.chip_of(variant)
    if variant.family == "stm32h7":
        from targets.mcu.stm32h7.chip import Stm32h753

        return Stm32h753
    from targets.mcu.stm32f7.chip import Stm32f767

    return Stm32f767
