"""The STM32H743 and H753: which peripherals there are, where, and how they are connected.

Addresses: RM0433 section 2.3, memory map. Interrupts: section 19.1.2. Clock gates: `targets.mcu.stm32h7.gates`.

RAM: ITCM at 0, DTCM at 0x20000000, AXI SRAM at 0x24000000, SRAM1 to 3 at 0x30000000 and again at 0x10000000, SRAM4 at
0x38000000; all of it answers whatever the gates in AHB2ENR say, and all of it at the same pace (choices). Caches hold
nothing: what DMA writes is seen at once, and what a program stores is there for DMA, which on silicon takes a clean or
an invalidation of the data cache, or memory that is not cached.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from targets.mcu.chip import Boot, Memory
from targets.mcu.cortexm.kinds import CORTEX_M7_R1P1
from targets.mcu.registers import Peripheral
from targets.mcu.stm32.backup_sram import BackupSram
from targets.mcu.stm32.crc import Crc
from targets.mcu.stm32.gpio import ANALOG_RESETS, Gpio
from targets.mcu.stm32.m7_chip import M7Chip
from targets.mcu.stm32.rng import Rng
from targets.mcu.stm32.rtc import Rtc
from targets.mcu.stm32.unique_id import unique_id
from targets.mcu.stm32.wwdg import Wwdg
from targets.mcu.stm32h7.absent import absent_peripherals
from targets.mcu.stm32h7.af_table import ALTERNATE_FUNCTIONS
from targets.mcu.stm32h7.blocks import adcs, dma_controllers, i2cs, low_power_timers, spis, timers, usarts
from targets.mcu.stm32h7.clocks import HSI_HZ, ClockTree
from targets.mcu.stm32h7.dbgmcu import Dbgmcu
from targets.mcu.stm32h7.exti import Exti
from targets.mcu.stm32h7.flash import Flash
from targets.mcu.stm32h7.gates import GATES
from targets.mcu.stm32h7.hsem import Hsem
from targets.mcu.stm32h7.pwr import WAKE_UP_PINS, Pwr
from targets.mcu.stm32h7.rcc import Rcc
from targets.mcu.stm32h7.signature import SYSTEM_MEMORY_BASE, diagnose, system_memory
from targets.mcu.stm32h7.syscfg import Syscfg

if TYPE_CHECKING:
    from targets.boards import Board

__all__ = ["Stm32h753"]

D2_RAM_ALIAS = 0x1000_0000


class Stm32h753(M7Chip):
    """The STM32H743 or H753; see `targets.mcu.chip.Chip`."""

    START_HZ = int(HSI_HZ)
    CORE = CORTEX_M7_R1P1
    REGISTER_WINDOWS = (
        (0x3880_0000, 0x1000),  # backup SRAM
        (0x4000_0000, 0xE000),  # APB1
        (0x4001_0000, 0x7800),  # APB2
        (0x4002_0000, 0xA_0000),  # AHB1
        (0x4802_0000, 0x3400),  # AHB2
        (0x5000_0000, 0x4000),  # APB3
        (0x5100_0000, 0x10_0000),  # AXI interconnect
        (0x5200_0000, 0x9400),  # AHB3
        (0x5800_0000, 0x5800),  # APB4
        (0x5802_0000, 0x7400),  # AHB4
        (0x5C00_1000, 0x400),  # DBGMCU
        (0xE000_0000, 0x10_0000),  # the private peripheral bus
    )
    FUNCTIONS = ALTERNATE_FUNCTIONS
    GATES = GATES
    WAKE_UP_PINS = WAKE_UP_PINS
    APB = ((0x4000_0000, 0xE000), (0x4001_0000, 0x7800), (0x5000_0000, 0x4000), (0x5800_0000, 0x5800))

    rcc: Rcc
    pwr: Pwr
    dbgmcu: Dbgmcu
    exti: Exti
    _flash: Flash
    _tree: ClockTree

    def _make_tree(self) -> ClockTree:
        return ClockTree()

    def _make_core_parts(self, board: Board) -> tuple[Peripheral, ...]:
        """Clocks, power, flash, and what depends on them."""
        services = self.services
        self.pwr = Pwr(0x5802_4800, services)
        self.rcc = Rcc(
            0x5802_4400,
            services,
            self._tree,
            scale=self.pwr.scale,
            **self._board_clocks(board),
        )
        self.pwr.on_scale = self.rcc.scale_changed
        self._flash = Flash(
            0x5200_2000,
            services,
            self._tree,
            size=board.variant.flash_bytes,
            scale=self.pwr.scale,
            pc=lambda: self.core.pc,
        )
        self.iwdg = self._make_iwdg(0x5800_4800, window=True)
        self.wwdg = Wwdg(0x5000_3000, services, bus="APB3")
        self.rtc = Rtc(
            0x5800_4000,
            services,
            rtc_hz=self.rcc.rtc_hz,
            backup_writable=self.pwr.backup_writable,
            exti_lines=("EXTI17", "EXTI18", "EXTI19"),  # alarm, tamper and time stamp, wake-up (RM0433 section 20.4)
        )
        self.rcc.on_rtc_clock = self.rtc.clock_changed
        self.rtc.on_wake = self.pwr.wake_by_rtc
        self.dbgmcu = Dbgmcu(0x5C00_1000, services)
        return self.rcc, self._flash, self.pwr, self.iwdg, self.wwdg, self.rtc, self.dbgmcu

    def _map(self, board: Board) -> tuple[Memory, ...]:
        dtcm, itcm, axi, d2, d3 = self._map_ram()
        system = system_memory(board.variant.flash_bytes // 1024, unique_id(board.name))
        return (
            *(dtcm, itcm, axi, d2, Memory(base=D2_RAM_ALIAS, data=d2.data, writable=True), d3),
            Memory(base=self.FLASH_BASE, data=self._flash.memory),
            Memory(base=SYSTEM_MEMORY_BASE, data=system),
        )

    def _make_peripherals(self, board: Board) -> tuple[Peripheral, ...]:
        """Everything else."""
        services = self.services
        ports = [
            Gpio(f"GPIO{port}", 0x5802_0000 + 0x400 * index, services, self.pins, self._functions, resets=ANALOG_RESETS)
            for index, port in enumerate("ABCDEFGHIJK")
        ]
        self.exti = Exti(0x5800_0000, services)
        syscfg = Syscfg(0x5800_0400, services, self.pins, self.signals)
        self.pwr.over_drive, syscfg.on_over_drive = syscfg.over_drive, self.pwr.over_drive_changed
        self.usarts = {usart.name: usart for usart in usarts(services, self._tree.kernel_hz)}
        self.i2cs = {i2c.name: i2c for i2c in i2cs(services, self._tree.kernel_hz)}
        self.spis = {spi.name: spi for spi in spis(services)}
        self._timers = {timer.name: timer for timer in timers(services)}
        return (
            *ports,
            syscfg,
            self.exti,
            BackupSram(0x3880_0000, services, writable=self.pwr.backup_writable),
            Crc(0x5802_4C00, services, data_bits=32),
            Rng(0x4802_1800, services, seed=board.name, slowest=32, may_ignore=True),
            Hsem(0x5802_6400, services),
            *self.usarts.values(),
            *self._timers.values(),
            *low_power_timers(services, self._tree.low_power_hz, self.exti.unmasks),
            *dma_controllers(services, self._requests, self.core.data_may_be_cached),
            *adcs(services, self._requests, self.pins, self._tree.kernel_hz, self._adc_noise(board)),
            *self.i2cs.values(),
            *self.spis.values(),
            *absent_peripherals(services, crypto=board.variant.name.startswith("STM32H753")),
        )

    # --- for the machine

    @property
    def flash(self) -> Flash:
        """The flash with its interface."""
        return self._flash

    def boot(self, image_table: int) -> Boot:
        """Follow the address that the option bytes have for the level of the BOOT0 pin (RM0433 section 2.6).

        The beginning of the flash is where the image begins, if that stands behind a boot loader.
        """
        pin = self._straps.boot0
        table = self._flash.settings.boot_address(pin)
        if not any(memory.holds(table) for memory in self._memories):
            table = SYSTEM_MEMORY_BASE if pin else self.FLASH_BASE  # what lies outside stands for these (choice)
        if diagnose(table) is not None:
            what = f"BOOT_ADD{pin} chooses system memory (0x{table:08X}), whose boot loader is not modelled"
            return Boot(table=table, refusal=what)
        return Boot(table=image_table if table == self.FLASH_BASE else table)

    def diagnose(self, pc: int) -> str | None:
        """Tell of the boot loader that is not there."""
        return diagnose(pc)
