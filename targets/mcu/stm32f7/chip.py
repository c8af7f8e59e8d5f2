"""The STM32F767."""

from __future__ import annotations

from targets.mcu.chip import Chip

__all__ = ["Stm32f767"]


class Stm32f767(Chip):
    """The STM32F767; see `targets.mcu.chip.Chip`."""

    START_HZ = 16_000_000  # HSI
    INTERRUPTS = 110
