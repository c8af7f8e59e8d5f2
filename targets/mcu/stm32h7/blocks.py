"""The blocks that the STM32H753 has several of: addresses, interrupts and clocks (RM0433, memory map and vectors)."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial

from targets.mcu.pins import Pins
from targets.mcu.services import Services
from targets.mcu.stm32.adc16 import Adc16
from targets.mcu.stm32.dma import Dma
from targets.mcu.stm32.dma_requests import Requests
from targets.mcu.stm32.dmamux import DmaMux, Outlets
from targets.mcu.stm32.i2c import I2c
from targets.mcu.stm32.lpuart import LowPowerUart
from targets.mcu.stm32.tim import Timer
from targets.mcu.stm32.tim.h7_kinds import H7_KINDS
from targets.mcu.stm32.usart_fifo import FifoUsart
from targets.mcu.stm32h7 import adc_inputs, dma_map
from targets.mcu.stm32h7.dma_reach import DmaReach

__all__ = ["KernelHz", "adcs", "dma_controllers", "i2cs", "timers", "usarts"]

KernelHz = Callable[[str], Fraction]
"""Returns the rate of a peripheral's own clock by the peripheral's name; 0 while it stands still."""

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
    "I2C4": (0x5800_1C00, 95, 96),
}
_TIMERS = {
    "TIM1": 0x4001_0000,
    "TIM2": 0x4000_0000,
    "TIM3": 0x4000_0400,
    "TIM4": 0x4000_0800,
    "TIM5": 0x4000_0C00,
    "TIM6": 0x4000_1000,
    "TIM7": 0x4000_1400,
    "TIM8": 0x4001_0400,
    "TIM12": 0x4000_1800,
    "TIM13": 0x4000_1C00,
    "TIM14": 0x4000_2000,
    "TIM15": 0x4001_4000,
    "TIM16": 0x4001_4400,
    "TIM17": 0x4001_4800,
}
_DMA_IRQS = ((11, 12, 13, 14, 15, 16, 17, 47), (56, 57, 58, 59, 60, 68, 69, 70))


def usarts(services: Services, kernel_hz: KernelHz) -> tuple[FifoUsart, ...]:
    """Return the USARTs and UARTs; `kernel_hz` knows them by their names. The LPUART has no DMA, for BDMA is absent."""
    low_power = LowPowerUart("LPUART1", 0x5800_0C00, services, irq=142, kernel_hz=partial(kernel_hz, "LPUART1"))
    return (
        *(
            FifoUsart(
                name, base, services, irq=irq, kernel_hz=partial(kernel_hz, name), synchronous=name.startswith("USART")
            )
            for name, (base, irq) in _USARTS.items()
        ),
        low_power,
    )


def timers(services: Services) -> tuple[Timer, ...]:
    """Return the timers."""
    return tuple(Timer(name, base, services, H7_KINDS[name]) for name, base in _TIMERS.items())


def i2cs(services: Services, kernel_hz: KernelHz) -> tuple[I2c, ...]:
    """Return the I2C interfaces; `kernel_hz` knows them by their names."""
    return tuple(
        I2c(name, base, services, irq_event=event, irq_error=error, kernel_hz=partial(kernel_hz, name))
        for name, (base, event, error) in _I2CS.items()
    )


def dma_controllers(
    services: Services, requests: Requests, cached: Callable[[int], bool] = lambda _address: False
) -> tuple[DmaMux, Dma, Dma]:
    """Return the multiplexer and the two controllers behind it (RM0433 section 17.3.1: channels 0 to 7 are DMA1's).

    Args:
        services: what the chip offers.
        requests: the requests of the chip.
        cached: see `DmaReach`.
    """
    mux = DmaMux("DMAMUX1", 0x4002_0800, services, requests=requests, names=dma_map.DMAMUX1, channels=16)
    memory = DmaReach(services.bus, services.notes.add, cached=cached)
    first, second = (
        Dma(
            f"DMA{number + 1}",
            0x4002_0000 + 0x400 * number,
            services,
            sources=Outlets(mux, 8 * number),
            irqs=_DMA_IRQS[number],
            between_memories=True,
            control_bits=0x01FF_FFFF,  # with TRBUFF, without CHSEL
            memory=memory,
        )
        for number in range(2)
    )
    return mux, first, second


def adcs(services: Services, requests: Requests, pins: Pins, kernel_hz: KernelHz) -> tuple[Adc16, Adc16]:
    """Return ADC1 with ADC2, and ADC3; their reference VREF+ is the supply of the pads (UM2407, VREF+)."""
    first, second = (
        Adc16(
            name,
            base,
            services,
            units=units,
            requests=requests,
            irq=irq,
            kernel_hz=partial(kernel_hz, name),
            volts=lambda unit, channel: _volts(pins, unit, channel),
            inside=adc_inputs.INSIDE,
            reference_volts=pins.vdd_volts,
            triggers=adc_inputs.REGULAR_TRIGGERS,
            injected_triggers=adc_inputs.INJECTED_TRIGGERS,
        )
        for name, base, units, irq in (
            ("ADC12", 0x4002_2000, ("ADC1", "ADC2"), 18),
            ("ADC3", 0x5802_6000, ("ADC3",), 127),
        )
    )
    return first, second


def _volts(pins: Pins, unit: str, channel: int) -> float | None:
    pin = adc_inputs.CHANNELS[unit].get(channel)
    return None if pin is None else pins[pin].volts
