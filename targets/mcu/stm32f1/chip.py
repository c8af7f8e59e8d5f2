"""The STM32F103 and the STM32F100: where the peripherals are, and how they are connected.

Addresses: RM0008 table 3. Interrupts: RM0008 table 63. Which peripherals there are: `targets.mcu.stm32f1.densities`.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING, ClassVar

from targets.mcu.bus import BIT_BAND, Bus
from targets.mcu.chip import AskReset, Boot, MakeCore, Memory
from targets.mcu.cortexm.kinds import CORTEX_M3
from targets.mcu.fidelity import Notes
from targets.mcu.irq_lines import IrqLines
from targets.mcu.pins import Pins
from targets.mcu.registers import Peripheral
from targets.mcu.services import DmaRequest, InputSignal, IrqLine, Services
from targets.mcu.signals import Signals
from targets.mcu.stm32 import exti
from targets.mcu.stm32.adc_noise import ADC_STEPS, AdcNoise
from targets.mcu.stm32.chip import BasicChip
from targets.mcu.stm32.tim import Timer
from targets.mcu.stm32.tim.kinds import HIGH_DENSITY_KINDS, KINDS, Kind
from targets.mcu.stm32.tim.value_line_kinds import HIGH_VALUE_LINE_KINDS, VALUE_LINE_KINDS
from targets.mcu.stm32.unique_id import unique_id
from targets.mcu.stm32.wwdg import Wwdg
from targets.mcu.stm32f1.absent import Fsmc, absent_peripherals
from targets.mcu.stm32f1.adc import Adc
from targets.mcu.stm32f1.afio import FIXED, MISC_REMAP, MOVED_REQUESTS, Afio
from targets.mcu.stm32f1.bkp import Bkp
from targets.mcu.stm32f1.clocks import ClockTree
from targets.mcu.stm32f1.crc import Crc
from targets.mcu.stm32f1.dac import Dac
from targets.mcu.stm32f1.dbgmcu import Dbgmcu
from targets.mcu.stm32f1.densities import HIGH, HIGH_VALUE, LOW, LOW_VALUE, MEDIUM, MEDIUM_VALUE, Density, density_of
from targets.mcu.stm32f1.dma import (
    CONTROLLERS,
    HIGH_VALUE_LINE_CONTROLLERS,
    MOVED,
    VALUE_LINE_CONTROLLERS,
    Controller,
    Dma,
)
from targets.mcu.stm32f1.flash import Flash
from targets.mcu.stm32f1.gpio import PADS, PADS_OF_HIGH_DENSITY, Gpio
from targets.mcu.stm32f1.i2c import I2c
from targets.mcu.stm32f1.i2c_joined import join
from targets.mcu.stm32f1.input_choice import InputChoice
from targets.mcu.stm32f1.options import OPTIONS_BASE
from targets.mcu.stm32f1.pwr import Pwr
from targets.mcu.stm32f1.rcc import Rcc
from targets.mcu.stm32f1.request_choice import RequestChoice
from targets.mcu.stm32f1.rtc import Rtc
from targets.mcu.stm32f1.sdio import Sdio
from targets.mcu.stm32f1.signature import SYSTEM_MEMORY_BASE, diagnose, system_memory
from targets.mcu.stm32f1.spi import Spi
from targets.mcu.stm32f1.usart import Uart4, Uart5, Usart, ValueLineUart, ValueLineUsart
from targets.mcu.timebase import Timebase
from targets.mcu.variant import Variant

if TYPE_CHECKING:
    from targets.boards import Board
    from targets.boards.board import Straps

__all__ = ["Stm32f103", "chip_of"]

TIMERS = {
    "TIM1": 0x4001_2C00,
    "TIM2": 0x4000_0000,
    "TIM3": 0x4000_0400,
    "TIM4": 0x4000_0800,
    "TIM5": 0x4000_0C00,
    "TIM6": 0x4000_1000,
    "TIM7": 0x4000_1400,
    "TIM8": 0x4001_3400,
    "TIM12": 0x4000_1800,
    "TIM13": 0x4000_1C00,
    "TIM14": 0x4000_2000,
    "TIM15": 0x4001_4000,
    "TIM16": 0x4001_4400,
    "TIM17": 0x4001_4800,
}
ADCS = {"ADC1": (0x4001_2400, 18), "ADC2": (0x4001_2800, 18), "ADC3": (0x4001_3C00, 47)}
I2CS = {"I2C1": (0x4000_5400, 31), "I2C2": (0x4000_5800, 33)}
SPIS = {"SPI1": (0x4001_3000, "APB2", 35), "SPI2": (0x4000_3800, "APB1", 36), "SPI3": (0x4000_3C00, "APB1", 51)}
USARTS: Mapping[str, tuple[type[Usart], int, str, int]] = {
    "USART1": (Usart, 0x4001_3800, "APB2", 37),
    "USART2": (Usart, 0x4000_4400, "APB1", 38),
    "USART3": (Usart, 0x4000_4800, "APB1", 39),
    "UART4": (Uart4, 0x4000_4C00, "APB1", 52),
    "UART5": (Uart5, 0x4000_5000, "APB1", 53),
}
AHB_PERIPHERALS = frozenset({"DMA1", "DMA2", "SDIO", "FSMC", "RCC", "FLASH", "CRC"})
# Behind the bridges an address without a peripheral reads 0 (a choice: the manual is silent); on AHB it is a bus error.
BRIDGES = ((0x4000_0000, 0x1_0000), (0x4001_0000, 0x8000))
RAM_BASE = 0x2000_0000
_SHARED_IRQS = (24, 25, 26, 54)  # of the value line
# Where MISC_REMAP of the value line of high density lets TIM5 in for TIM15 (RM0041 section 7.4.7).
_TRIGGERED_BY_EITHER = ("TIM1", "TIM3")


class Stm32f103(BasicChip):
    """An STM32F103 of medium density; see `targets.mcu.chip.Chip`.

    Attributes:
        DENSITY: what devices of its density have.
        TIMER_KINDS: its timers.
        USART_KINDS: its USARTs, for those of the STM32F103.
        DMA_KINDS: its DMA controllers.
    """

    START_HZ = 8_000_000  # HSI
    CORE = CORTEX_M3
    DENSITY: ClassVar[Density] = MEDIUM
    TIMER_KINDS: ClassVar[Mapping[str, Kind]] = KINDS
    USART_KINDS: ClassVar[Mapping[type[Usart], type[Usart]]] = {}
    DMA_KINDS: ClassVar[Mapping[str, Controller]] = CONTROLLERS
    # The last is the private peripheral bus.
    REGISTER_WINDOWS: ClassVar[tuple[tuple[int, int], ...]] = (
        (0x4000_0000, 0x1_8000),
        (0x4002_0000, 0x4000),
        (0xE000_0000, 0x10_0000),
    )
    BIT_BAND: ClassVar[Mapping[int, int]] = BIT_BAND

    rcc: Rcc
    pwr: Pwr
    dbgmcu: Dbgmcu
    _flash: Flash

    def __init__(
        self,
        board: Board,
        straps: Straps,
        time: Timebase,
        notes: Notes,
        bus: Bus,
        make_core: MakeCore,
        ask_reset: AskReset,
    ) -> None:
        self._straps = straps
        self.ram = bytearray(board.variant.ram_bytes)
        pads = PADS_OF_HIGH_DENSITY if "GPIOG" in self.DENSITY.gates else PADS
        self.pins = Pins(pads, time, notes, bonded=board.variant.pins)
        self.signals = Signals(self.pins)
        self._tree = ClockTree()
        self.services = Services(
            time=time,
            clocks=self._tree,
            notes=notes,
            irq=self._irq,
            dma=self._dma_request,
            output=self.signals.output,
            input=self.signals.input,
            bus=bus,
            chip_reset=ask_reset,
        )
        self.core = make_core(self.services)
        self.system_memory = system_memory(board.variant.flash_bytes // 1024, unique_id(board.name))
        self._make_core_parts(board)
        self._memories = self._map(from_ram=straps.boot0 == straps.boot1 == 1)
        self._make_peripherals(board)
        everything = (self.rcc, self._flash, self.pwr, self.bkp, self.rtc, self.iwdg, self.dbgmcu, *self._others)
        self.peripherals: dict[str, Peripheral] = {peripheral.name: peripheral for peripheral in everything}
        for name, peripheral in self.peripherals.items():
            bus.add(peripheral, ahb=name in AHB_PERIPHERALS)
        for base, size in BRIDGES:
            bus.add_quiet(base, size)
        if isinstance(fsmc := self.peripherals.get("FSMC"), Fsmc):
            bus.add_quiet(*Fsmc.MEMORY, fsmc.answers)
        self._tie(self.DENSITY.gates, backup=(self.bkp, self.rtc))
        self.rcc.on_clock_failure = self._clock_failed
        self._pull_pins(board, straps)

    def _make_core_parts(self, board: Board) -> None:
        """Clocks, power, flash, and what depends on them."""
        services = self.services
        self.pwr = Pwr(0x4000_7000, services)
        self.rcc = Rcc(
            0x4002_1000,
            services,
            self._tree,
            self.DENSITY,
            **self._board_clocks(board),
        )
        self._flash = Flash(
            0x4002_2000,
            services,
            self._tree,
            size=board.variant.flash_bytes,
            page=self.DENSITY.page_bytes,
            hsi_on=self.rcc.hsi_on,
            waits=not self.DENSITY.value_line,
        )
        self.bkp = Bkp(
            0x4000_6C00,
            services,
            backup_writable=self.pwr.backup_writable,
            density=self.DENSITY,
            rtc_hz=self.rcc.rtc_hz,
        )
        self.rtc = Rtc(
            0x4000_2800,
            services,
            rtc_hz=self.rcc.rtc_hz,
            backup_writable=self.pwr.backup_writable,
            calibration=self.bkp.rtc_calibration,
        )
        self.rcc.on_rtc_clock, self.bkp.on_calibration = self._rtc_clock_changed, self.rtc.clock_changed
        self.rtc.on_pulse, self.bkp.on_output = self.bkp.pulse, self._rtc_puts_out
        self.rtc.on_alarm = self.pwr.wake
        self.iwdg = self._make_iwdg(0x4000_3000)
        self.wwdg = Wwdg(0x4000_2C00, services)
        self.dbgmcu = Dbgmcu(0xE004_2000, services, self.DENSITY)

    def _map(self, *, from_ram: bool) -> tuple[Memory, ...]:
        flash = self._flash
        return (
            Memory(base=0, data=self.ram if from_ram else flash.memory, writable=from_ram),
            Memory(base=self.FLASH_BASE, data=flash.memory),
            Memory(base=SYSTEM_MEMORY_BASE, data=self.system_memory),
            Memory(base=RAM_BASE, data=self.ram, writable=True),
            Memory(base=OPTIONS_BASE, data=flash.options),
        )

    def _make_peripherals(self, board: Board) -> None:
        """Everything else."""
        services, pins, there = self.services, self.pins, self.DENSITY.gates
        addresses = {"DMA1": 0x4002_0000, "DMA2": 0x4002_0400}
        value_line = self.DENSITY.value_line
        self._dmas = [
            Dma(name, base, services, self.DMA_KINDS[name]) for name, base in addresses.items() if name in there
        ]
        self.exti = exti.Exti("EXTI", 0x4001_0400, services, exti.STM32F1)
        addresses = {f"GPIO{port}": 0x4001_0800 + 0x400 * index for index, port in enumerate("ABCDEFG")}
        ports = [Gpio(name, base, services, pins) for name, base in addresses.items() if name in there]
        # After the ports: it takes the pins of the debug port away from them.
        self.afio = Afio(
            "AFIO",
            0x4001_0000,
            services,
            pins,
            self.signals,
            shared_oscillator_pins="PE0" not in board.variant.pins,
            there=there,
            value_line=value_line,
        )
        usarts = [
            self.USART_KINDS.get(kind, kind)(name, base, services, bus=bus, irq=irq)
            for name, (kind, base, bus, irq) in USARTS.items()
            if name in there
        ]
        self.usarts = {usart.name: usart for usart in usarts}
        self._timers = self._make_timers()
        noise = AdcNoise(board.adc_noise_lsb * pins.vdd_volts / ADC_STEPS, board.name)
        self.adcs: dict[str, Adc] = {}
        for name, (base, irq) in ADCS.items():
            if name in there:
                master = self.adcs["ADC1"] if name == "ADC2" else None
                moved = self.afio.trigger_moved
                adc = Adc(name, base, services, pins=pins, irq=irq, master=master, remapped=moved, noise=noise)
                self.adcs[name] = adc
        self.spis = {
            name: Spi(
                name,
                base,
                services,
                bus=bus,
                irq=irq,
                has_i2s="SPI3" in there and name != "SPI1" and not value_line,
                tx_left=partial(self._dma_of(f"{name}_TX").left, f"{name}_TX"),
            )
            for name, (base, bus, irq) in SPIS.items()
            if name in there
        }
        self.i2cs = {
            name: I2c(
                name,
                base,
                services,
                irq=irq,
                rx_left=partial(self._dma_of(f"{name}_RX").left, f"{name}_RX"),
                tx_left=partial(self._dma_of(f"{name}_TX").left, f"{name}_TX"),
            )
            for name, (base, irq) in I2CS.items()
            if name in there
        }
        join(self.i2cs.values(), self.signals)
        self._others: tuple[Peripheral, ...] = (
            *ports,
            self.afio,
            self.exti,
            self.wwdg,
            *self._dmas,
            Crc(0x4002_3000, services),
            *usarts,
            *self._timers,
            *([Dac(0x4000_7400, self._services_of("DAC"), pins, value_line=value_line)] if "DAC" in there else []),
            *self.adcs.values(),
            *self.spis.values(),
            *self.i2cs.values(),
            *([Sdio(0x4001_8000, services)] if "SDIO" in there else []),
            *absent_peripherals(services, self.DENSITY),
        )

    def _make_timers(self) -> list[Timer]:
        """Return the timers; AFIO may tie channel 4 of TIM5 to the LSI."""
        services, kinds = self.services, self.TIMER_KINDS
        addresses = {name: base for name, base in TIMERS.items() if name in self.DENSITY.gates}
        if "TIM5" not in addresses:
            return [Timer(name, base, self._services_of(name), kinds[name]) for name, base in addresses.items()]
        channel_4 = InputChoice(self.signals.input("TIM5_CH4"), self.signals.input("LSI"))
        self.afio.on_tim5_ch4 = lambda inside: channel_4.choose(inside=inside)

        def tied(name: str) -> InputSignal:
            return channel_4 if name == "TIM5_CH4" else self.signals.input(name)

        of_tim5 = replace(services, input=tied)
        return [
            Timer(name, base, of_tim5 if name == "TIM5" else self._services_of(name), kinds[name])
            for name, base in addresses.items()
        ]

    def _services_of(self, _name: str) -> Services:
        """Return what the chip offers to a timer or to the DAC."""
        return self.services

    def _clock_failed(self) -> None:
        for timer in self._timers:
            if timer.kind.advanced:
                timer.clock_failed()

    def _rtc_clock_changed(self) -> None:
        self.rtc.clock_changed()
        self.bkp.rtc_clock_changed()

    def _rtc_puts_out(self, on: bool, flag: int) -> None:
        """The RTC takes the pin TAMPER as an output, or gives it back to its port."""
        pin = self.pins[FIXED["TAMPER"]]
        if on:
            pin.claim("the RTC", carries=True)
        else:
            pin.unclaim()
        self.rtc.tell(flag)

    def _dma_request(self, name: str) -> DmaRequest:
        return self._dma_of(name).request(name)

    def _dma_of(self, name: str) -> Dma:
        return next((dma for dma in self._dmas if dma.serves(name)), self._dmas[0])

    # --- for the machine

    @property
    def flash(self) -> Flash:
        """The flash with its interface."""
        return self._flash

    def boot(self, image_table: int) -> Boot:
        """Follow the BOOT pins (RM0008 section 3.4) first, then what the image says."""
        if self._straps.boot0 == 0:
            return Boot(table=0 if image_table == self.FLASH_BASE else image_table)
        refusal = (
            "" if self._straps.boot1 else "the boot straps choose system memory, whose boot loader is not modelled"
        )
        return Boot(table=RAM_BASE, refusal=refusal)

    def standby_may_end(self) -> bool:
        """Say whether WKUP or an alarm of the RTC ends Standby."""
        return self.pwr.wakes_by_pin() or self.rtc.alarm_comes

    def diagnose(self, pc: int) -> str | None:
        """Tell of the boot loader that is not there."""
        return diagnose(pc)


class LowDensity(Stm32f103):
    """An STM32F103 of low density; see `targets.mcu.chip.Chip`."""

    DENSITY = LOW


class HighDensity(Stm32f103):
    """An STM32F103 of high density; see `targets.mcu.chip.Chip`."""

    CORE = replace(CORTEX_M3, irq_count=HIGH.irq_count)
    # With SDIO, and with the banks and registers of FSMC.
    REGISTER_WINDOWS = (
        (0x4000_0000, 0x1_8400),
        (0x4002_0000, 0x4000),
        (Fsmc.MEMORY[0], Fsmc.MEMORY[1] + 0x1000),
        (0xE000_0000, 0x10_0000),
    )
    DENSITY = HIGH
    TIMER_KINDS = HIGH_DENSITY_KINDS


class MediumValueLine(Stm32f103):
    """An STM32F100 of medium density; see `targets.mcu.chip.Chip`.

    TIM1 shares interrupts with TIM15 to TIM17, and TIM6 with the DAC (RM0041 table 50).
    """

    CORE = replace(CORTEX_M3, irq_count=MEDIUM_VALUE.irq_count)
    DENSITY = MEDIUM_VALUE
    TIMER_KINDS = VALUE_LINE_KINDS
    USART_KINDS = MappingProxyType({Usart: ValueLineUsart})
    DMA_KINDS = VALUE_LINE_CONTROLLERS

    @functools.cached_property
    def _shared(self) -> IrqLines:
        return IrqLines(super()._irq)

    def _irq(self, number: int) -> IrqLine:
        return self._shared.line(number) if number in _SHARED_IRQS else super()._irq(number)

    def _make_peripherals(self, board: Board) -> None:
        """Everything else; AFIO_MAPR2 moves requests to DMA."""
        self._moved: list[tuple[RequestChoice, int]] = []
        super()._make_peripherals(board)
        self.afio.on_mapr2 = self._connect

    def _dma_request(self, name: str) -> DmaRequest:
        moved = name + MOVED
        dma = self._dma_of(moved)
        if name not in MOVED_REQUESTS or not dma.serves(moved):
            return super()._dma_request(name)
        choice = RequestChoice(super()._dma_request(name), dma.request(moved))
        self._moved.append((choice, MOVED_REQUESTS[name]))
        return choice

    def _connect(self, mapr2: int) -> None:
        for choice, bit in self._moved:
            choice.choose(moved=bool(mapr2 & bit))


class LowValueLine(MediumValueLine):
    """An STM32F100 of low density; see `targets.mcu.chip.Chip`."""

    DENSITY = LOW_VALUE


class HighValueLine(MediumValueLine):
    """An STM32F100 of high density; see `targets.mcu.chip.Chip`."""

    CORE = replace(CORTEX_M3, irq_count=HIGH_VALUE.irq_count)
    REGISTER_WINDOWS = HighDensity.REGISTER_WINDOWS
    DENSITY = HIGH_VALUE
    TIMER_KINDS = HIGH_VALUE_LINE_KINDS
    USART_KINDS = MappingProxyType({Usart: ValueLineUsart, Uart4: ValueLineUart, Uart5: ValueLineUart})
    DMA_KINDS = HIGH_VALUE_LINE_CONTROLLERS

    def _make_peripherals(self, board: Board) -> None:
        self._either: list[InputChoice] = []
        super()._make_peripherals(board)

    def _services_of(self, name: str) -> Services:
        """Return what the chip offers; TIM15 triggers TIM1, TIM3 and the DAC only if MISC_REMAP is set, else TIM5."""
        if name not in _TRIGGERED_BY_EITHER and name != "DAC":
            return self.services

        def tied(signal: str) -> InputSignal:
            if signal != "TIM15_TRGO":
                return self.signals.input(signal)
            choice = InputChoice(self.signals.input("TIM5_TRGO"), self.signals.input(signal))
            self._either.append(choice)
            return choice

        return replace(self.services, input=tied)

    def _connect(self, mapr2: int) -> None:
        super()._connect(mapr2)
        misc = bool(mapr2 & MISC_REMAP)
        for choice in self._either:
            choice.choose(inside=misc)
        for dma in self._dmas:
            dma.part(misc)


_CHIPS = (LowDensity, Stm32f103, HighDensity, LowValueLine, MediumValueLine, HighValueLine)


def chip_of(variant: Variant) -> type[Stm32f103]:
    """Return the chip that a part number is."""
    density = density_of(variant.flash_bytes, value_line=variant.name.startswith("STM32F100"))
    return next(chip for chip in _CHIPS if chip.DENSITY is density)
