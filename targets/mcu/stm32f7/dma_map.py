"""Which requests lead to which stream and channel of DMA1 and DMA2 in the STM32F76x and F77x (RM0410 tables 27 and 28).

A row is a channel and what its streams 0 to 7 listen to; a slash joins requests that share a place, a dash is none.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

__all__ = ["DMA1", "DMA2"]

_DMA1 = """
0  SPI3_RX  SPDIFRX_DT  SPI3_RX  SPI2_RX  SPI2_TX  SPI3_TX  SPDIFRX_CS  SPI3_TX
1  I2C1_RX  I2C3_RX  TIM7_UP  -  TIM7_UP  I2C1_RX  I2C1_TX  I2C1_TX
2  TIM4_CH1  -  I2C4_RX  TIM4_CH2  -  I2C4_TX  TIM4_UP  TIM4_CH3
3  -  TIM2_UP/TIM2_CH3  I2C3_RX  -  I2C3_TX  TIM2_CH1  TIM2_CH2/TIM2_CH4  TIM2_UP/TIM2_CH4
4  UART5_RX  USART3_RX  UART4_RX  USART3_TX  UART4_TX  USART2_RX  USART2_TX  UART5_TX
5  UART8_TX  UART7_TX  TIM3_CH4/TIM3_UP  UART7_RX  TIM3_CH1/TIM3_TRIG  TIM3_CH2  UART8_RX  TIM3_CH3
6  TIM5_CH3/TIM5_UP  TIM5_CH4/TIM5_TRIG  TIM5_CH1  TIM5_CH4/TIM5_TRIG  TIM5_CH2  -  TIM5_UP  -
7  -  TIM6_UP  I2C2_RX  I2C2_RX  USART3_TX  DAC1  DAC2  I2C2_TX
8  I2C3_TX  I2C4_RX  -  -  I2C2_TX  -  I2C4_TX  -
9  -  SPI2_RX  -  -  -  -  SPI2_TX  -
"""
_DMA2 = """
0  ADC1  SAI1_A  TIM8_CH1/TIM8_CH2/TIM8_CH3  SAI1_A  ADC1  SAI1_B  TIM1_CH1/TIM1_CH2/TIM1_CH3  SAI1_B
1  -  DCMI  ADC2  ADC2  SAI1_B  SPI6_TX  SPI6_RX  DCMI
2  ADC3  ADC3  -  SPI5_RX  SPI5_TX  CRYP_OUT  CRYP_IN  HASH_IN
3  SPI1_RX  -  SPI1_RX  SPI1_TX  SAI2_A  SPI1_TX  SAI2_B  QUADSPI
4  SPI4_RX  SPI4_TX  USART1_RX  SDMMC1  -  USART1_RX  SDMMC1  USART1_TX
5  -  USART6_RX  USART6_RX  SPI4_RX  SPI4_TX  -  USART6_TX  USART6_TX
6  TIM1_TRIG  TIM1_CH1  TIM1_CH2  TIM1_CH1  TIM1_CH4/TIM1_TRIG/TIM1_COM  TIM1_UP  TIM1_CH3  -
7  -  TIM8_UP  TIM8_CH1  TIM8_CH2  TIM8_CH3  SPI5_RX  SPI5_TX  TIM8_CH4/TIM8_TRIG/TIM8_COM
8  DFSDM1_FLT0  DFSDM1_FLT1  DFSDM1_FLT2  DFSDM1_FLT3  DFSDM1_FLT0  DFSDM1_FLT1  DFSDM1_FLT2  DFSDM1_FLT3
9  JPEG_IN  JPEG_OUT  SPI4_TX  JPEG_IN  JPEG_OUT  SPI5_RX  -  -
10 SAI1_B  SAI2_B  SAI2_A  -  -  -  SAI1_A  -
11 SDMMC2  -  QUADSPI  -  -  SDMMC2  -  -
"""


def _read(table: str) -> Mapping[tuple[int, int], tuple[str, ...]]:
    found = {}
    for line in table.strip().splitlines():
        channel, *streams = line.split()
        for stream, names in enumerate(streams):
            if names != "-":
                found[stream, int(channel)] = tuple(names.split("/"))
    return MappingProxyType(found)


DMA1 = _read(_DMA1)
"""Names of requests by stream and channel."""
DMA2 = _read(_DMA2)
"""As above."""
