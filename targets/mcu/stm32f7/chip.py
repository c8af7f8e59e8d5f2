"""The STM32F767: which peripherals there are, where, and how they are connected.

Addresses: RM0410 table 1. Interrupts: RM0410 table 46. Clock gates: RM0410 sections 5.3.10 to 5.3.14.

Address 0 is RAM of the core (ITCM); the flash is seen from 0x08000000 on by AXI and from 0x00200000 on by ITCM. Choice:
code runs at the same pace from both. Caches hold nothing: what DMA writes is seen at once, and what a program stores is
there for DMA, which on silicon takes a clean or an invalidation of the data cache, or memory that is not cached.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from targets.mcu.chip import Boot, Memory
from targets.mcu.cortexm.kinds import CORTEX_M7
from targets.mcu.registers import Peripheral
from targets.mcu.stm32.backup_sram import BackupSram
from targets.mcu.stm32.crc import Crc
from targets.mcu.stm32.exti import STM32F7, Exti
from targets.mcu.stm32.gpio import Gpio
from targets.mcu.stm32.m7_chip import ITCM_RAM, M7Chip
from targets.mcu.stm32.rng import Rng
from targets.mcu.stm32.rtc import Rtc
from targets.mcu.stm32.unique_id import unique_id
from targets.mcu.stm32.wwdg import Wwdg
from targets.mcu.stm32f7.absent import absent_peripherals
from targets.mcu.stm32f7.af_table import ALTERNATE_FUNCTIONS
from targets.mcu.stm32f7.blocks import adcs, dma_controllers, i2cs, low_power_timer, spis, timers, usarts
from targets.mcu.stm32f7.clocks import ClockTree
from targets.mcu.stm32f7.dbgmcu import Dbgmcu
from targets.mcu.stm32f7.flash import Flash
from targets.mcu.stm32f7.gates import GATES
from targets.mcu.stm32f7.options import OPTIONS_BASE
from targets.mcu.stm32f7.pwr import WAKE_UP_PINS, Pwr
from targets.mcu.stm32f7.rcc import Rcc
from targets.mcu.stm32f7.signature import SYSTEM_MEMORY_BASE, SYSTEM_MEMORY_ITCM, diagnose, system_memory
from targets.mcu.stm32f7.syscfg import Syscfg

if TYPE_CHECKING:
    from targets.boards import Board

__all__ = ["Stm32f767"]

BOOT_END = 0x2005_0000


class Stm32f767(M7Chip):
    """The STM32F767; see `targets.mcu.chip.Chip`."""

    START_HZ = 16_000_000  # HSI
    CORE = CORTEX_M7
    REGISTER_WINDOWS = (
        (0x4000_0000, 0x8000),  # APB1
        (0x4001_0000, 0x7C00),  # APB2
        (0x4002_0000, 0xC000),  # AHB1
        (0x4004_0000, 0x4_0000),  # OTG HS
        (0x5000_0000, 0x6_0C00),  # AHB2
        (0xA000_0000, 0x2000),  # FMC and QUADSPI
        (0xE000_0000, 0x10_0000),  # the private peripheral bus
    )
    FUNCTIONS = ALTERNATE_FUNCTIONS
    GATES = GATES
    WAKE_UP_PINS = WAKE_UP_PINS
    APB = ((0x4000_0000, 0x8000), (0x4001_0000, 0x7C00))

    rcc: Rcc
    pwr: Pwr
    dbgmcu: Dbgmcu
    _flash: Flash
    _tree: ClockTree

    def _make_tree(self) -> ClockTree:
        return ClockTree()

    def _make_core_parts(self, board: Board) -> tuple[Peripheral, ...]:
        """Clocks, power, flash, and what depends on them."""
        services = self.services
        self.pwr = Pwr(0x4000_7000, services)
        self.rcc = Rcc(
            0x4002_3800,
            services,
            self._tree,
            supply=self.pwr.supply,
            **self._board_clocks(board),
        )
        self.rcc.on_pll = self.pwr.pll_switched
        self.pwr.on_supply = self.rcc.supply_changed
        self._flash = Flash(0x4002_3C00, services, self._tree, size=board.variant.flash_bytes)
        self.iwdg = self._make_iwdg(0x4000_3000, window=True)
        self.wwdg = Wwdg(0x4000_2C00, services)
        self.rtc = Rtc(0x4000_2800, services, rtc_hz=self.rcc.rtc_hz, backup_writable=self.pwr.backup_writable)
        self.rcc.on_rtc_clock = self.rtc.clock_changed
        self.rtc.on_wake = self.pwr.wake_by_rtc
        self.dbgmcu = Dbgmcu(0xE004_2000, services)
        return self.rcc, self._flash, self.pwr, self.iwdg, self.wwdg, self.rtc, self.dbgmcu

    def _map(self, board: Board) -> tuple[Memory, ...]:
        flash, (main, itcm) = self._flash, self._map_ram()
        system = system_memory(board.variant.flash_bytes // 1024, unique_id(board.name))
        return (
            itcm,
            Memory(base=SYSTEM_MEMORY_ITCM, data=system),
            Memory(base=0x0020_0000, data=flash.memory),
            Memory(base=self.FLASH_BASE, data=flash.memory),
            Memory(base=SYSTEM_MEMORY_BASE, data=system),
            Memory(base=OPTIONS_BASE, data=flash.options),
            main,
        )

    def _make_peripherals(self, board: Board) -> tuple[Peripheral, ...]:
        """Everything else."""
        services = self.services
        ports = [
            Gpio(f"GPIO{port}", 0x4002_0000 + 0x400 * index, services, self.pins, self._functions)
            for index, port in enumerate("ABCDEFGHIJK")
        ]
        self.exti = Exti("EXTI", 0x4001_3C00, services, STM32F7)
        self.usarts = {usart.name: usart for usart in usarts(services, self._tree)}
        self.i2cs = {i2c.name: i2c for i2c in i2cs(services, self._tree)}
        self.spis = {spi.name: spi for spi in spis(services, self._requests)}
        self._timers = {timer.name: timer for timer in timers(services)}
        return (
            *ports,
            Syscfg(0x4001_3800, services, self.pins, self.signals, boot_pin=self._straps.boot0),
            self.exti,
            BackupSram(0x4002_4000, services, writable=self.pwr.backup_writable),
            Crc(0x4002_3000, services),
            Rng(0x5006_0800, services, seed=board.name),
            *self.usarts.values(),
            *self.i2cs.values(),
            *self.spis.values(),
            *self._timers.values(),
            low_power_timer(services, self._tree),
            *dma_controllers(services, self._requests),
            adcs(services, self._requests, self.pins, self.rcc.adc_enabled, self._adc_noise(board)),
            *absent_peripherals(services),
        )

    # --- for the machine

    @property
    def flash(self) -> Flash:
        """The flash with its interface."""
        return self._flash

    def boot(self, image_table: int) -> Boot:
        """Follow the address that the option bytes have for the level of the BOOT pin (RM0410 section 2.5).

        The beginning of the flash is where the image begins, if that stands behind a boot loader.
        """
        pin = self._straps.boot0
        settings = self._flash.settings
        if settings.dual_bank and settings.dual_boot:
            return Boot(
                table=SYSTEM_MEMORY_ITCM, refusal="nDBOOT has the boot loader choose a bank; it is not modelled"
            )
        table = settings.boot_address(pin)
        if table >= BOOT_END or not any(memory.holds(table) for memory in self._memories):
            table = ITCM_RAM if pin else 0x0020_0000  # what lies outside stands for these
        if diagnose(table) is not None:
            what = f"BOOT_ADD{pin} chooses system memory (0x{table:08X}), whose boot loader is not modelled"
            return Boot(table=table, refusal=what)
        if table in (0x0020_0000, self.FLASH_BASE) and image_table != self.FLASH_BASE:
            table = image_table
        return Boot(table=table)

    def reset(self, cause: str) -> None:
        """Reset everything that a reset with this cause resets."""
        super().reset(cause)
        if self._flash.settings.hardware_window_watchdog:
            text = "the window watchdog would start by itself; it starts by WWDG_CR only"
            self.services.notes.add("unmodelled", "FLASH_OPTCR.WWDG_SW", text)

    def diagnose(self, pc: int) -> str | None:
        """Tell of the boot loader that is not there."""
        return diagnose(pc)
