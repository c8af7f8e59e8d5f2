"""The medium-density STM32F103: which peripherals there are, where, and how they are tied together.

Addresses: RM0008 table 3. Interrupts: RM0008 table 63. Clock gates: RM0008 sections 7.3.6 to 7.3.8.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar

from targets.mcu.bus import BIT_BAND, Bus
from targets.mcu.chip import AskReset, Boot, MakeCore, Memory
from targets.mcu.cortexm.kinds import CORTEX_M3
from targets.mcu.fidelity import Notes
from targets.mcu.pins import Pins
from targets.mcu.registers import Peripheral
from targets.mcu.services import DmaRequest, Services
from targets.mcu.signals import Signals
from targets.mcu.stm32 import exti
from targets.mcu.stm32.chip import BasicChip
from targets.mcu.stm32.tim import Timer
from targets.mcu.stm32.unique_id import unique_id
from targets.mcu.stm32.wwdg import Wwdg
from targets.mcu.stm32f1.absent import Rtc, absent_peripherals
from targets.mcu.stm32f1.afio import Afio
from targets.mcu.stm32f1.bkp import Bkp
from targets.mcu.stm32f1.clocks import ClockTree
from targets.mcu.stm32f1.crc import Crc
from targets.mcu.stm32f1.dbgmcu import Dbgmcu
from targets.mcu.stm32f1.dma import Dma
from targets.mcu.stm32f1.flash import Flash
from targets.mcu.stm32f1.gpio import Gpio
from targets.mcu.stm32f1.options import OPTIONS_BASE
from targets.mcu.stm32f1.pwr import Pwr
from targets.mcu.stm32f1.rcc import Rcc
from targets.mcu.stm32f1.signature import SYSTEM_MEMORY_BASE, diagnose, system_memory
from targets.mcu.stm32f1.usart import Usart
from targets.mcu.timebase import Timebase

if TYPE_CHECKING:
    from targets.boards import Board
    from targets.boards.board import Straps

__all__ = ["Stm32f103"]

GATES = {
    "DMA1": ("AHB", 0),
    "CRC": ("AHB", 6),
    "AFIO": ("APB2", 0),
    "GPIOA": ("APB2", 2),
    "GPIOB": ("APB2", 3),
    "GPIOC": ("APB2", 4),
    "GPIOD": ("APB2", 5),
    "GPIOE": ("APB2", 6),
    "ADC1": ("APB2", 9),
    "ADC2": ("APB2", 10),
    "TIM1": ("APB2", 11),
    "SPI1": ("APB2", 12),
    "USART1": ("APB2", 14),
    "TIM2": ("APB1", 0),
    "TIM3": ("APB1", 1),
    "TIM4": ("APB1", 2),
    "WWDG": ("APB1", 11),
    "SPI2": ("APB1", 14),
    "USART2": ("APB1", 17),
    "USART3": ("APB1", 18),
    "I2C1": ("APB1", 21),
    "I2C2": ("APB1", 22),
    "USB": ("APB1", 23),
    "CAN": ("APB1", 25),
    "BKP": ("APB1", 27),
    "PWR": ("APB1", 28),
}
TIMERS = {"TIM1": 0x4001_2C00, "TIM2": 0x4000_0000, "TIM3": 0x4000_0400, "TIM4": 0x4000_0800}
AHB_PERIPHERALS = frozenset({"DMA1", "RCC", "FLASH", "CRC"})
# Behind the bridges an address without a peripheral reads 0 (a choice: the manual is silent); on AHB it is a bus error.
BRIDGES = ((0x4000_0000, 0x1_0000), (0x4001_0000, 0x8000))
RAM_BASE = 0x2000_0000


class Stm32f103(BasicChip):
    """The STM32F103; see `targets.mcu.chip.Chip`."""

    START_HZ = 8_000_000  # HSI
    CORE = CORTEX_M3
    # The last is the private peripheral bus.
    REGISTER_WINDOWS = ((0x4000_0000, 0x1_8000), (0x4002_0000, 0x4000), (0xE000_0000, 0x10_0000))
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
        names = [f"P{port}{number}" for port in "ABCDE" for number in range(16)]
        self.pins = Pins(names, time, notes, bonded=board.variant.pins)
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
        self._make_peripherals()
        everything = (self.rcc, self._flash, self.pwr, self.bkp, self.iwdg, self.dbgmcu, *self._others)
        self.peripherals: dict[str, Peripheral] = {peripheral.name: peripheral for peripheral in everything}
        for name, peripheral in self.peripherals.items():
            bus.add(peripheral, ahb=name in AHB_PERIPHERALS)
        for base, size in BRIDGES:
            bus.add_quiet(base, size)
        self._tie(GATES, backup=(self.bkp, self._rtc))
        self.rcc.on_clock_failure = self._timers[0].clock_failed
        self._pull_pins(board, straps)

    def _make_core_parts(self, board: Board) -> None:
        """Clocks, power, flash, and what depends on them."""
        services = self.services
        self.pwr = Pwr(0x4000_7000, services)
        self.rcc = Rcc(
            0x4002_1000,
            services,
            self._tree,
            **self._board_clocks(board),
        )
        size = board.variant.flash_bytes
        self._flash = Flash(0x4002_2000, services, self._tree, size=size, hsi_on=self.rcc.hsi_on)
        self.bkp = Bkp(0x4000_6C00, services, backup_writable=self.pwr.backup_writable)
        self.iwdg = self._make_iwdg(0x4000_3000)
        self.wwdg = Wwdg(0x4000_2C00, services)
        self.dbgmcu = Dbgmcu(0xE004_2000, services)

    def _map(self, *, from_ram: bool) -> tuple[Memory, ...]:
        flash = self._flash
        return (
            Memory(base=0, data=self.ram if from_ram else flash.memory, writable=from_ram),
            Memory(base=self.FLASH_BASE, data=flash.memory),
            Memory(base=SYSTEM_MEMORY_BASE, data=self.system_memory),
            Memory(base=RAM_BASE, data=self.ram, writable=True),
            Memory(base=OPTIONS_BASE, data=flash.options),
        )

    def _make_peripherals(self) -> None:
        """Everything else."""
        services, pins = self.services, self.pins
        self.dma = Dma("DMA1", 0x4002_0000, services)
        self.exti = exti.Exti("EXTI", 0x4001_0400, services, exti.STM32F1)
        ports = [Gpio(f"GPIO{port}", 0x4001_0800 + 0x400 * index, services, pins) for index, port in enumerate("ABCDE")]
        # After the ports: it takes the pins of the debug port away from them.
        self.afio = Afio("AFIO", 0x4001_0000, services, pins, self.signals)
        usarts = (
            Usart("USART1", 0x4001_3800, services, bus="APB2", irq=37),
            Usart("USART2", 0x4000_4400, services, bus="APB1", irq=38),
            Usart("USART3", 0x4000_4800, services, bus="APB1", irq=39),
        )
        self.usarts = {usart.name: usart for usart in usarts}
        self._timers = [Timer(name, base, services) for name, base in TIMERS.items()]
        absent = absent_peripherals(services)
        self._rtc = next(peripheral for peripheral in absent if isinstance(peripheral, Rtc))
        self._others: tuple[Peripheral, ...] = (
            *ports,
            self.afio,
            self.exti,
            self.wwdg,
            self.dma,
            Crc(0x4002_3000, services),
            *usarts,
            *self._timers,
            *absent,
        )

    def _dma_request(self, name: str) -> DmaRequest:
        return self.dma.request(name)

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
        """Say whether WKUP ends Standby."""
        return self.pwr.wakes_by_pin()

    def diagnose(self, pc: int) -> str | None:
        """Tell of the boot loader that is not there."""
        return diagnose(pc)
