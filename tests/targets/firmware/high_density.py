"""The images for an STM32F103 of high density, and a board with nothing but a crystal around one; that for an F100."""

from __future__ import annotations

from targets.boards import Board, built_in_board

__all__ = ["HIGH_DENSITY", "IMAGES"]

HIGH_DENSITY = Board.from_mapping(
    {"name": "High density", "chip": "STM32F103ZE", "hse_hz": 8_000_000, "hse_startup_us": 500}
)
IMAGES = {
    **dict.fromkeys(("selftest-dac", "selftest-high-density", "style-dac-dma"), HIGH_DENSITY),
    "style-value-line": built_in_board("stm32vldiscovery"),
}
