"""The STM32F767: which peripherals there are, where, and how they are tied together.

Addresses: RM0410 table 1. Interrupts: RM0410 table 46. Clock gates: RM0410 sections 5.3.10 to 5.3.14.

Address 0 is RAM of the core (ITCM); the flash is seen from 0x08000000 on by AXI and from 0x00200000 on by ITCM. Choice:
code runs at the same pace from both. Caches hold nothing: what DMA writes is seen at once, and what a program stores is
there for DMA, which on silicon takes a clean or an invalidation of the data cache, or memory that is not cached.
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING, cast

from targets.mcu.bus import Bus
from targets.mcu.chip import AskReset, Boot, MakeCore, Memory
from targets.mcu.cortexm.kinds import CORTEX_M7
from targets.mcu.fidelity import Notes
from targets.mcu.irq_lines import IrqLines
from targets.mcu.pins import Pins
from targets.mcu.registers import Peripheral
from targets.mcu.services import Services
from targets.mcu.signals import Signals
from targets.mcu.stm32.backup_sram import BackupSram
from targets.mcu.stm32.chip import BasicChip
from targets.mcu.stm32.crc import Crc
from targets.mcu.stm32.dma_requests import Requests
from targets.mcu.stm32.exti import STM32F7, Exti
from targets.mcu.stm32.gpio import Gpio, thresholds
from targets.mcu.stm32.iwdg import Iwdg
from targets.mcu.stm32.pin_functions import PinFunctions
from targets.mcu.stm32.rng import Rng
from targets.mcu.stm32.rtc import Rtc
from targets.mcu.stm32.unique_id import unique_id
from targets.mcu.stm32.wwdg import Wwdg
from targets.mcu.stm32f7.absent import absent_peripherals
from targets.mcu.stm32f7.af_table import ALTERNATE_FUNCTIONS, PADS
from targets.mcu.stm32f7.blocks import adcs, dma_controllers, i2cs, timers, usarts
from targets.mcu.stm32f7.clocks import ClockTree
from targets.mcu.stm32f7.dbgmcu import Dbgmcu
from targets.mcu.stm32f7.flash import Flash
from targets.mcu.stm32f7.gates import GATES
from targets.mcu.stm32f7.options import OPTIONS_BASE
from targets.mcu.stm32f7.pwr import WAKE_UP_PINS, Pwr
from targets.mcu.stm32f7.rcc import Rcc
from targets.mcu.stm32f7.signature import SYSTEM_MEMORY_BASE, SYSTEM_MEMORY_ITCM, diagnose, system_memory
from targets.mcu.stm32f7.syscfg import Syscfg
from targets.mcu.timebase import Timebase

if TYPE_CHECKING:
    from targets.boards import Board
    from targets.boards.board import Straps

__all__ = ["Stm32f767"]

ITCM_RAM, RAM_BASE, RAM_END, BOOT_END = 0x0000_0000, 0x2000_0000, 0x2008_0000, 0x2005_0000
# On AHB a byte leaves the other lanes of its word alone; behind the APB bridges it is repeated over the word.
APB = ((0x4000_0000, 0x8000), (0x4001_0000, 0x7C00))
TIME_STAMP_PIN = "PC13"  # RTC_TS (DS11532, additional functions)

_US_PER_S = 1_000_000


class Stm32f767(BasicChip):
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
        variant = board.variant
        self._straps = straps
        # One block for all RAM, so that whoever asks whether anything has changed sees all of it: the ITCM RAM last.
        self.ram = bytearray(variant.ram_bytes + variant.itcm_bytes)
        self._main_bytes = variant.ram_bytes
        self.pins = Pins(PADS, time, notes, bonded=variant.pins, thresholds=thresholds(3.3))
        self.signals = Signals(self.pins)
        self._functions = PinFunctions(ALTERNATE_FUNCTIONS, self.signals, time, notes)
        self._tree = ClockTree()
        self._requests = Requests()
        self._irq_lines = IrqLines(self._irq)
        self.services = Services(
            time=time,
            clocks=self._tree,
            notes=notes,
            irq=self._irq_lines.line,
            dma=self._requests.line,
            output=self.signals.output,
            input=self.signals.input,
            bus=bus,
            chip_reset=ask_reset,
        )
        self.core = make_core(self.services)
        self._system_memory = system_memory(variant.flash_bytes // 1024, unique_id(board.name))
        self._make_core_parts(board)
        self._memories = self._map()
        self._make_peripherals(board.name)
        everything = (self.rcc, self._flash, self.pwr, self.iwdg, self.wwdg, self.rtc, self.dbgmcu, *self._others)
        self.peripherals = {peripheral.name: peripheral for peripheral in everything}
        for peripheral in self.peripherals.values():
            behind_bridge = any(start <= peripheral.base < start + size for start, size in APB)
            bus.add(peripheral, ahb=not behind_bridge)
        for base, size in APB:
            bus.add_quiet(base, size)
        self._tie(GATES, backup=(self.rtc,))
        self.rcc.on_clock_failure = self._clock_failed
        self.rcc.on_pll = self.pwr.pll_switched
        self.pwr.on_supply = self.rcc.supply_changed
        self._pull_pins(board, straps)

    def _make_core_parts(self, board: Board) -> None:
        """Clocks, power, flash, and what depends on them."""
        services = self.services
        for number, pin in enumerate(WAKE_UP_PINS, 1):
            self.signals.route(f"WKUP{number}", pin)
        self.pwr = Pwr(0x4000_7000, services)
        self.rcc = Rcc(
            0x4002_3800,
            services,
            self._tree,
            hse_hz=board.hse_hz,
            hse_is_clock=board.hse_bypass,
            hse_start_s=Fraction(board.hse_startup_us, _US_PER_S),
            lse=board.lse_hz is not None,
            lse_start_s=Fraction(board.lse_startup_us, _US_PER_S),
            backup_writable=self.pwr.backup_writable,
            supply=self.pwr.supply,
        )
        self._flash = Flash(0x4002_3C00, services, self._tree, size=board.variant.flash_bytes)
        self.iwdg = Iwdg(
            0x4000_3000,
            services,
            lsi_hz=self.rcc.lsi_hz,
            start_lsi=self.rcc.force_lsi,
            lsi_on=self.rcc.lsi_on,
            starts_by_itself=lambda: self._flash.settings.hardware_watchdog,
            window=True,
        )
        self.wwdg = Wwdg(0x4000_2C00, services)
        self.signals.route("RTC_TS", TIME_STAMP_PIN)
        self.rtc = Rtc(0x4000_2800, services, rtc_hz=self.rcc.rtc_hz, backup_writable=self.pwr.backup_writable)
        self.rcc.on_rtc_clock = self.rtc.clock_changed
        self.rtc.on_wake = self.pwr.wake_by_rtc
        self.dbgmcu = Dbgmcu(0xE004_2000, services)

    def _map(self) -> tuple[Memory, ...]:
        flash, system = self._flash, self._system_memory
        whole = memoryview(self.ram)
        # A view of a part of it has all that a bytearray is asked for here and in the engine.
        main, itcm = (cast("bytearray", part) for part in (whole[: self._main_bytes], whole[self._main_bytes :]))
        return (
            Memory(base=ITCM_RAM, data=itcm, writable=True),
            Memory(base=SYSTEM_MEMORY_ITCM, data=system),
            Memory(base=0x0020_0000, data=flash.memory),
            Memory(base=self.FLASH_BASE, data=flash.memory),
            Memory(base=SYSTEM_MEMORY_BASE, data=system),
            Memory(base=OPTIONS_BASE, data=flash.options),
            Memory(base=RAM_BASE, data=main, writable=True),
        )

    def _make_peripherals(self, board_name: str) -> None:
        """Everything else."""
        services = self.services
        ports = [
            Gpio(f"GPIO{port}", 0x4002_0000 + 0x400 * index, services, self.pins, self._functions)
            for index, port in enumerate("ABCDEFGHIJK")
        ]
        self.exti = Exti("EXTI", 0x4001_3C00, services, STM32F7)
        self.usarts = {usart.name: usart for usart in usarts(services, self._tree)}
        self.i2cs = {i2c.name: i2c for i2c in i2cs(services, self._tree)}
        self._timers = {timer.name: timer for timer in timers(services)}
        self._others: tuple[Peripheral, ...] = (
            *ports,
            Syscfg(0x4001_3800, services, self.pins, self.signals, boot_pin=self._straps.boot0),
            self.exti,
            BackupSram(0x4002_4000, services, writable=self.pwr.backup_writable),
            Crc(0x4002_3000, services),
            Rng(0x5006_0800, services, seed=board_name),
            *self.usarts.values(),
            *self.i2cs.values(),
            *self._timers.values(),
            *dma_controllers(services, self._requests),
            adcs(services, self._requests, self.pins, self.rcc.adc_enabled),
            *absent_peripherals(services),
        )

    def _clock_failed(self) -> None:
        for name in ("TIM1", "TIM8"):
            self._timers[name].clock_failed()

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

    def stop_clocks(self) -> None:
        """Let all but LSE and LSI stand still, and end over-drive."""
        super().stop_clocks()
        self.pwr.enter_stop()

    def standby_may_end(self) -> bool:
        """Say whether a WKUP pin or the RTC may end Standby."""
        return self.pwr.may_wake()

    def diagnose(self, pc: int) -> str | None:
        """Tell of the boot loader that is not there."""
        return diagnose(pc)
