"""The blocks that the STM32F767 has several of: addresses, interrupts and clocks (RM0410 tables 1 and 46)."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from types import MappingProxyType

from targets.mcu.pins import Pins
from targets.mcu.services import Services
from targets.mcu.stm32.adc import Adc
from targets.mcu.stm32.adc_noise import QUIET, AdcNoise
from targets.mcu.stm32.dma import Dma
from targets.mcu.stm32.dma_requests import Channels, Requests
from targets.mcu.stm32.i2c import I2c
from targets.mcu.stm32.lptim import LowPowerTimer, LptimKind
from targets.mcu.stm32.spi_fifo import FifoSpi
from targets.mcu.stm32.tim import Timer
from targets.mcu.stm32.tim.kinds import F7_KINDS
from targets.mcu.stm32.usart import Usart
from targets.mcu.stm32f7 import adc_inputs, dma_map
from targets.mcu.stm32f7.clocks import ClockTree

__all__ = ["adcs", "dma_controllers", "i2cs", "low_power_timer", "spis", "timers", "usarts"]

_USARTS = {
    "USART1": (0x4001_1000, 37),
    "USART2": (0x4000_4400, 38),
    "USART3": (0x4000_4800, 39),
    "UART4": (0x4000_4C00, 52),
    "UART5": (0x4000_5000, 53),
    "USART6": (0x4001_1400, 71),
    "UART7": (0x4000_7800, 82),
    "UART8": (0x4000_7C00, 83),
}
_I2CS = {
    "I2C1": (0x4000_5400, 31, 32),
    "I2C2": (0x4000_5800, 33, 34),
    "I2C3": (0x4000_5C00, 72, 73),
    "I2C4": (0x4000_6000, 95, 96),
}
_SPIS = {
    "SPI1": (0x4001_3000, "APB2", 35),
    "SPI2": (0x4000_3800, "APB1", 36),
    "SPI3": (0x4000_3C00, "APB1", 51),
    "SPI4": (0x4001_3400, "APB2", 84),
    "SPI5": (0x4001_5000, "APB2", 85),
    "SPI6": (0x4001_5400, "APB2", 86),
}
_WITH_I2S = ("SPI1", "SPI2", "SPI3")  # RM0410 section 35.4
_TIMERS = {
    "TIM1": 0x4001_0000,
    "TIM2": 0x4000_0000,
    "TIM3": 0x4000_0400,
    "TIM4": 0x4000_0800,
    "TIM5": 0x4000_0C00,
    "TIM6": 0x4000_1000,
    "TIM7": 0x4000_1400,
    "TIM8": 0x4001_0400,
    "TIM9": 0x4001_4000,
    "TIM10": 0x4001_4400,
    "TIM11": 0x4001_4800,
    "TIM12": 0x4000_1800,
    "TIM13": 0x4000_1C00,
    "TIM14": 0x4000_2000,
}
# RM0410 section 26: LPTIM1 external trigger connection; table 46 and section 11.3: line 23 of EXTI.
_LPTIM1 = LptimKind(
    irq=93,
    triggers=MappingProxyType({0: "LPTIM1_ETR", 1: "RTC_ALRA", 2: "RTC_ALRB"}),
    missing=MappingProxyType({3: "RTC_TAMP1", 4: "RTC_TAMP2", 5: "RTC_TAMP3"}),
    wake_line="EXTI23",
)


def timers(services: Services) -> tuple[Timer, ...]:
    """Return the timers."""
    return tuple(Timer(name, base, services, F7_KINDS[name]) for name, base in _TIMERS.items())


def low_power_timer(services: Services, tree: ClockTree) -> LowPowerTimer:
    """Return LPTIM1. Its interrupt comes out of Stop mode only by its line of EXTI (RM0410 section 11.3)."""
    name = "LPTIM1"
    return LowPowerTimer(name, 0x4000_2400, services, _LPTIM1, kernel_hz=partial(tree.low_power_hz, name))


def usarts(services: Services, tree: ClockTree) -> tuple[Usart, ...]:
    """Return the USARTs and UARTs."""
    return tuple(
        Usart(name, base, services, irq=irq, kernel_hz=partial(tree.kernel_hz, name))
        for name, (base, irq) in _USARTS.items()
    )


def i2cs(services: Services, tree: ClockTree) -> tuple[I2c, ...]:
    """Return the I2C interfaces."""
    return tuple(
        I2c(name, base, services, irq_event=event, irq_error=error, kernel_hz=partial(tree.kernel_hz, name))
        for name, (base, event, error) in _I2CS.items()
    )


def spis(services: Services, requests: Requests) -> tuple[FifoSpi, ...]:
    """Return the SPI interfaces."""
    return tuple(
        FifoSpi(
            name,
            base,
            services,
            bus=bus,
            irq=irq,
            has_i2s=name in _WITH_I2S,
            tx_left=requests.line(f"{name}_TX").left,
            rx_left=requests.line(f"{name}_RX").left,
        )
        for name, (base, bus, irq) in _SPIS.items()
    )


def adcs(
    services: Services, requests: Requests, pins: Pins, enabled: Callable[[int], bool], noise: AdcNoise = QUIET
) -> Adc:
    """Return the three ADCs, whose reference VREF+ is the supply of the pads (UM1974, SB12)."""
    return Adc(
        0x4001_2000,
        services,
        requests=requests,
        irq=18,
        bus="APB2",
        most_hz=36_000_000,  # DS11532, ADC characteristics, at 2.4 to 3.6 V
        volts=lambda unit, channel: pins[adc_inputs.CHANNELS[unit][channel]].volts,
        reference_volts=pins.vdd_volts,
        triggers=adc_inputs.REGULAR_TRIGGERS,
        injected_triggers=adc_inputs.INJECTED_TRIGGERS,
        noise=noise,
        enabled=enabled,
    )


def dma_controllers(services: Services, requests: Requests) -> tuple[Dma, ...]:
    """Return the DMA controllers; only the second one reaches memory by its peripheral port (RM0410 section 8.3.1)."""
    return (
        Dma(
            "DMA1",
            0x4002_6000,
            services,
            sources=Channels(requests, dma_map.DMA1),
            irqs=(11, 12, 13, 14, 15, 16, 17, 47),
            between_memories=False,
        ),
        Dma(
            "DMA2",
            0x4002_6400,
            services,
            sources=Channels(requests, dma_map.DMA2),
            irqs=(56, 57, 58, 59, 60, 68, 69, 70),
            between_memories=True,
        ),
    )
