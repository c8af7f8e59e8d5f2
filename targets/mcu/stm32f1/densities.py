"""What low-, medium- and high-density devices of the STM32F103 have (RM0008 section 2.2: by the size of their flash).

Besides those of the value line, the STM32F100: RM0041 sections 2.2, 6.3 and 25.6.1, DS5944; of high density, its
freeze bits and the number of its backup registers are from memory.

Clock gates, and so which peripherals there are: RM0008 sections 7.3.6 to 7.3.8, datasheets DS6087 (x4, x6), DS5319
(x8, xB) and DS5792 (xC, xD, xE). Interrupts: RM0008 table 63. Pages of the flash: PM0075 section 1.2. Backup registers:
RM0008 section 6.4. DEV_ID: RM0008 section 31.6.1, with the latest REV_ID that stands there.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

__all__ = ["HIGH", "HIGH_VALUE", "LOW", "LOW_VALUE", "MEDIUM", "MEDIUM_VALUE", "Density", "Limits", "density_of"]

KB = 1024


@dataclass(frozen=True, slots=True, kw_only=True)
class Limits:
    """The fastest clocks, in MHz (DS5319 section 5.3.1, PLL and ADC characteristics; DS5944 for the value line).

    Attributes:
        sysclk: of SYSCLK and PCLK2, and of the PLL.
        pclk1: of PCLK1.
        adc: of the converters.
    """

    sysclk: int = 72
    pclk1: int = 36
    adc: int = 14


@dataclass(frozen=True, slots=True, kw_only=True)
class Density:
    """What devices of a density have in common.

    Attributes:
        gates: bus and bit of the clock gate of every peripheral that has one.
        irq_count: interrupts.
        page_bytes: of the flash.
        backup_registers: half-words in the backup domain.
        idcode: of DBGMCU.
        freezes: bits of DBGMCU_CR that stop a peripheral while a debugger halts the core.
        value_line: it is one of the value line: a divider before the PLL in RCC_CFGR2, no USB.
        limits: its fastest clocks.
    """

    gates: Mapping[str, tuple[str, int]]
    irq_count: int = 43
    page_bytes: int = 1 * KB
    backup_registers: int = 10
    idcode: int
    freezes: int = 0x1_FF00
    value_line: bool = False
    limits: Limits = Limits()

    def bits(self, bus: str) -> int:
        """Return the bits of a bus's enable register that are gates of peripherals."""
        return sum(1 << bit for on, bit in self.gates.values() if on == bus)


_GATES = {
    "DMA1": ("AHB", 0),
    "CRC": ("AHB", 6),
    "AFIO": ("APB2", 0),
    "GPIOA": ("APB2", 2),
    "GPIOB": ("APB2", 3),
    "GPIOC": ("APB2", 4),
    "GPIOD": ("APB2", 5),
    "ADC1": ("APB2", 9),
    "ADC2": ("APB2", 10),
    "TIM1": ("APB2", 11),
    "SPI1": ("APB2", 12),
    "USART1": ("APB2", 14),
    "TIM2": ("APB1", 0),
    "TIM3": ("APB1", 1),
    "WWDG": ("APB1", 11),
    "USART2": ("APB1", 17),
    "I2C1": ("APB1", 21),
    "USB": ("APB1", 23),
    "CAN": ("APB1", 25),
    "BKP": ("APB1", 27),
    "PWR": ("APB1", 28),
}
_FROM_MEDIUM = {
    "GPIOE": ("APB2", 6),
    "TIM4": ("APB1", 2),
    "SPI2": ("APB1", 14),
    "USART3": ("APB1", 18),
    "I2C2": ("APB1", 22),
}
_FROM_HIGH = {
    "DMA2": ("AHB", 1),
    "FSMC": ("AHB", 8),
    "SDIO": ("AHB", 10),
    "GPIOF": ("APB2", 7),
    "GPIOG": ("APB2", 8),
    "TIM8": ("APB2", 13),
    "ADC3": ("APB2", 15),
    "TIM5": ("APB1", 3),
    "TIM6": ("APB1", 4),
    "TIM7": ("APB1", 5),
    "SPI3": ("APB1", 15),
    "UART4": ("APB1", 19),
    "UART5": ("APB1", 20),
    "DAC": ("APB1", 29),
}

LOW = Density(gates=MappingProxyType(_GATES), idcode=0x1000_6412)
MEDIUM = Density(gates=MappingProxyType(_GATES | _FROM_MEDIUM), idcode=0x2003_6410)
HIGH = Density(
    gates=MappingProxyType(_GATES | _FROM_MEDIUM | _FROM_HIGH),
    irq_count=60,
    page_bytes=2 * KB,
    backup_registers=42,
    idcode=0x1003_6414,
    freezes=0x1E_0000 | 0x1_FF00,
)


_LACKS_OF_VALUE_LINE = ("ADC2", "USB", "CAN")
_OF_VALUE_LINE = {
    "TIM15": ("APB2", 16),
    "TIM16": ("APB2", 17),
    "TIM17": ("APB2", 18),
    "TIM6": ("APB1", 4),
    "TIM7": ("APB1", 5),
    "DAC": ("APB1", 29),
    "CEC": ("APB1", 30),
}


def _value_line(more: Mapping[str, tuple[str, int]]) -> Density:
    gates = {name: gate for name, gate in _GATES.items() if name not in _LACKS_OF_VALUE_LINE}
    return Density(
        gates=MappingProxyType({**gates, **_OF_VALUE_LINE, **more}),
        irq_count=56,
        idcode=0x1001_6420,
        freezes=0x01D9_BF00,
        value_line=True,
        limits=Limits(sysclk=24, pclk1=24, adc=12),
    )


LOW_VALUE = _value_line({})
MEDIUM_VALUE = _value_line(_FROM_MEDIUM)
_LACKS_OF_HIGH_VALUE = ("SDIO", "TIM8", "ADC3")
_OF_HIGH_VALUE = {"TIM12": ("APB1", 6), "TIM13": ("APB1", 7), "TIM14": ("APB1", 8)}
HIGH_VALUE = replace(
    _value_line(
        {
            **_FROM_MEDIUM,
            **{name: gate for name, gate in _FROM_HIGH.items() if name not in _LACKS_OF_HIGH_VALUE},
            **_OF_HIGH_VALUE,
        }
    ),
    irq_count=61,
    page_bytes=2 * KB,
    backup_registers=42,
    idcode=0x1000_6428,
    freezes=0x0FDD_BF00,
)


def density_of(flash_bytes: int, *, value_line: bool = False) -> Density:
    """Return the density of a device by the size of its flash."""
    if value_line:
        return LOW_VALUE if flash_bytes <= 32 * KB else MEDIUM_VALUE if flash_bytes <= 128 * KB else HIGH_VALUE
    return LOW if flash_bytes <= 32 * KB else MEDIUM if flash_bytes <= 128 * KB else HIGH
