"""On which bit of which enable and reset register each peripheral of the STM32H743 and H753 hangs (RM0433 section 8.7).

Buses as the registers are called: ``APB1L`` is RCC_APB1LENR. Bits of memories, of parts of a peripheral that are not
modelled and of clocks for lines are left out; a peripheral without an entry is always clocked, as DMAMUX1 is with DMA1.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

__all__ = ["GATES"]

_BITS: Mapping[str, Mapping[int, str]] = {
    "AHB1": {0: "DMA1", 1: "DMA2", 5: "ADC12", 15: "ETH", 25: "USB1_OTG_HS", 27: "USB2_OTG_HS"},
    "AHB2": {0: "DCMI", 4: "CRYP", 5: "HASH", 6: "RNG", 9: "SDMMC2"},
    "AHB3": {0: "MDMA", 4: "DMA2D", 5: "JPEG", 12: "FMC", 14: "QUADSPI", 16: "SDMMC1"},
    "AHB4": {
        **{bit: f"GPIO{port}" for bit, port in enumerate("ABCDEFGHIJK")},
        19: "CRC",
        21: "BDMA",
        24: "ADC3",
        25: "HSEM",
        28: "BKPSRAM",
    },
    "APB1L": {
        **{bit: f"TIM{number}" for bit, number in enumerate((2, 3, 4, 5, 6, 7, 12, 13, 14))},
        9: "LPTIM1",
        14: "SPI2",
        15: "SPI3",
        16: "SPDIFRX",
        17: "USART2",
        18: "USART3",
        19: "UART4",
        20: "UART5",
        21: "I2C1",
        22: "I2C2",
        23: "I2C3",
        27: "CEC",
        29: "DAC",
        30: "UART7",
        31: "UART8",
    },
    "APB1H": {1: "CRS", 2: "SWPMI1", 4: "OPAMP", 5: "MDIOS", 8: "FDCAN1"},
    "APB2": {
        0: "TIM1",
        1: "TIM8",
        4: "USART1",
        5: "USART6",
        12: "SPI1",
        13: "SPI4",
        16: "TIM15",
        17: "TIM16",
        18: "TIM17",
        20: "SPI5",
        22: "SAI1",
        23: "SAI2",
        24: "SAI3",
        28: "DFSDM1",
        29: "HRTIM",
    },
    "APB3": {3: "LTDC", 6: "WWDG"},
    "APB4": {
        1: "SYSCFG",
        3: "LPUART1",
        5: "SPI6",
        7: "I2C4",
        9: "LPTIM2",
        10: "LPTIM3",
        11: "LPTIM4",
        12: "LPTIM5",
        14: "COMP",
        15: "VREFBUF",
        16: "RTC",
        21: "SAI4",
    },
}
_SHARED = {"FDCAN2": ("APB1H", 8), "CAN_CCU": ("APB1H", 8)}

GATES: Mapping[str, tuple[str, int]] = MappingProxyType(
    {**{name: (bus, bit) for bus, bits in _BITS.items() for bit, name in bits.items()}, **_SHARED}
)
"""Bus and bit by the name of the peripheral."""
