"""On which bit of which enable and reset register each peripheral of the STM32F767 hangs (RM0410 5.3.10 to 5.3.14)."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

__all__ = ["GATES"]

_AHB1 = {12: "CRC", 18: "BKPSRAM", 21: "DMA1", 22: "DMA2", 23: "DMA2D", 25: "ETH", 29: "USB_OTG_HS"}
_AHB2 = {0: "DCMI", 1: "JPEG", 6: "RNG", 7: "USB_OTG_FS"}
_AHB3 = {0: "FMC", 1: "QUADSPI"}
_APB1 = {
    **{bit: f"TIM{number}" for bit, number in enumerate((2, 3, 4, 5, 6, 7, 12, 13, 14))},
    9: "LPTIM1",
    10: "RTC",
    11: "WWDG",
    13: "CAN3",
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
    24: "I2C4",
    25: "CAN1",
    26: "CAN2",
    27: "CEC",
    28: "PWR",
    29: "DAC",
    30: "UART7",
    31: "UART8",
}
_APB2 = {
    0: "TIM1",
    1: "TIM8",
    4: "USART1",
    5: "USART6",
    7: "SDMMC2",
    8: "ADC",
    11: "SDMMC1",
    12: "SPI1",
    13: "SPI4",
    14: "SYSCFG",
    16: "TIM9",
    17: "TIM10",
    18: "TIM11",
    20: "SPI5",
    21: "SPI6",
    22: "SAI1",
    23: "SAI2",
    26: "LTDC",
    29: "DFSDM1",
    30: "MDIOS",
}

GATES: Mapping[str, tuple[str, int]] = MappingProxyType(
    {
        **{f"GPIO{port}": ("AHB1", bit) for bit, port in enumerate("ABCDEFGHIJK")},
        **{
            name: (bus, bit)
            for bus, names in (("AHB1", _AHB1), ("AHB2", _AHB2), ("AHB3", _AHB3), ("APB1", _APB1), ("APB2", _APB2))
            for bit, name in names.items()
        },
    }
)
"""Bus and bit by the name of the peripheral."""
