"""Every part number that can be emulated, of all families."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Literal

from targets.mcu.stm32f1.variants import VARIANTS as STM32F1
from targets.mcu.stm32f1.variants import ChipName as Stm32f1Name
from targets.mcu.stm32f7.variants import VARIANTS as STM32F7
from targets.mcu.stm32f7.variants import ChipName as Stm32f7Name
from targets.mcu.stm32h7.variants import VARIANTS as STM32H7
from targets.mcu.stm32h7.variants import ChipName as Stm32h7Name
from targets.mcu.variant import Variant

__all__ = ["VARIANTS", "ChipName", "Variant"]

ChipName = Literal[Stm32f1Name, Stm32f7Name, Stm32h7Name]

VARIANTS: Mapping[str, Variant] = MappingProxyType({**STM32F1, **STM32F7, **STM32H7})
"""Every variant by its name."""
