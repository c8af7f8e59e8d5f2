"""The blocks that the STM32H753 has several of: addresses, interrupts and clocks (RM0433, memory map and vectors)."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from types import MappingProxyType

from targets.mcu.pins import Pins
from targets.mcu.services import Services
from targets.mcu.stm32.adc16 import Adc16
from targets.mcu.stm32.adc_noise import QUIET, AdcNoise
from targets.mcu.stm32.dma import Dma
from targets.mcu.stm32.dma_requests import Requests
from targets.mcu.stm32.dmamux import DmaMux, Outlets
from targets.mcu.stm32.i2c import I2c
from targets.mcu.stm32.lptim import LowPowerTimer, LptimKind, inside
from targets.mcu.stm32.lpuart import LowPowerUart
from targets.mcu.stm32.spi_packets import PacketSpi
from targets.mcu.stm32.tim import Timer
from targets.mcu.stm32.tim.h7_kinds import H7_KINDS
from targets.mcu.stm32.usart_fifo import FifoUsart
from targets.mcu.stm32h7 import adc_inputs, dma_map
from targets.mcu.stm32h7.dma_reach import BARRED, DmaReach

__all__ = ["KernelHz", "adcs", "dma_controllers", "i2cs", "low_power_timers", "spis", "timers", "usarts"]

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
_SPIS = {
    "SPI1": (0x4001_3000, 35),
    "SPI2": (0x4000_3800, 36),
    "SPI3": (0x4000_3C00, 51),
    "SPI4": (0x4001_3400, 84),
    "SPI5": (0x4001_5000, 85),
    "SPI6": (0x5800_1400, 86),
}
_WIDE_SPIS = ("SPI1", "SPI2", "SPI3")  # RM0433 section 50.3: FIFOs of 16 bytes, words of 32 bits, I2S
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
# RM0433 section 43.3.2, inputs and triggers; 19.1.2, vectors; 20.4, event inputs of EXTI: the line that wakes up, and
# for two of them one of the output. The triggers of LPTIM3 to LPTIM5 are from memory.
_TRIGGERS = MappingProxyType({1: "RTC_ALRA", 2: "RTC_ALRB"})
_MISSING = MappingProxyType({3: "RTC_TAMP1", 4: "RTC_TAMP2", 5: "RTC_TAMP3", 6: "COMP1_OUT", 7: "COMP2_OUT"})
_FROM_SAI = MappingProxyType({4: "SAI4_FS_A", 5: "SAI4_FS_B"})


def _lptim(number: int, irq: int, output_line: str = "") -> LptimKind:
    """Return what LPTIM1 or LPTIM2 has."""
    return LptimKind(
        irq=irq,
        bus="APB1" if number == 1 else "APB4",
        reset_bits=True,
        inputs=0xFF,
        triggers=MappingProxyType({0: f"LPTIM{number}_ETR", **_TRIGGERS}),
        missing=_MISSING,
        output_line=output_line,
    )


def _small_lptim(number: int, irq: int, output_line: str = "") -> LptimKind:
    """Return what LPTIM3, LPTIM4 or LPTIM5 has: no pins but its output, and the others' outputs as triggers."""
    others = {index: inside(f"LPTIM{other}") for index, other in enumerate((2, 3, 4, 5)) if other != number}
    return LptimKind(
        irq=irq,
        bus="APB4",
        encoder=False,
        reset_bits=True,
        inputs=0xF if number == 3 else 0,
        pin_input=False,
        triggers=MappingProxyType(others),
        missing=_FROM_SAI,
        output_line=output_line,
    )


_LPTIMS = {
    "LPTIM1": (0x4000_2400, 47, _lptim(1, 93)),
    "LPTIM2": (0x5800_2400, 48, _lptim(2, 138, "EXTI49")),
    "LPTIM3": (0x5800_2800, 50, _small_lptim(3, 139, "EXTI51")),
    "LPTIM4": (0x5800_2C00, 52, _small_lptim(4, 140)),
    "LPTIM5": (0x5800_3000, 53, _small_lptim(5, 141)),
}
"""Address, the line of EXTI that wakes up, and what it has."""


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


def low_power_timers(
    services: Services, kernel_hz: KernelHz, unmasked: Callable[[int], bool]
) -> tuple[LowPowerTimer, ...]:
    """Return the low-power timers; `unmasked` says of a direct line of EXTI whether it wakes the CPU up."""
    return tuple(
        LowPowerTimer(name, base, services, kind, kernel_hz=partial(kernel_hz, name), wakes=partial(unmasked, line))
        for name, (base, line, kind) in _LPTIMS.items()
    )


def i2cs(services: Services, kernel_hz: KernelHz) -> tuple[I2c, ...]:
    """Return the I2C interfaces; `kernel_hz` knows them by their names."""
    return tuple(
        I2c(name, base, services, irq_event=event, irq_error=error, kernel_hz=partial(kernel_hz, name))
        for name, (base, event, error) in _I2CS.items()
    )


def spis(services: Services) -> tuple[PacketSpi, ...]:
    """Return the SPI interfaces; SPI6 has no DMA, for BDMA is absent."""
    return tuple(
        PacketSpi(name, base, services, irq=irq, wide=name in _WIDE_SPIS) for name, (base, irq) in _SPIS.items()
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
            barred=BARRED,
        )
        for number in range(2)
    )
    return mux, first, second


def adcs(
    services: Services, requests: Requests, pins: Pins, kernel_hz: KernelHz, noise: AdcNoise = QUIET
) -> tuple[Adc16, Adc16]:
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
            noise=noise,
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
