"""Timers of the STM32F1: `timer.Timer` is TIM1 to TIM4."""

from __future__ import annotations

from targets.mcu.stm32.tim.timer import Timer

__all__ = ["Timer"]
