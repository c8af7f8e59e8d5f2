"""What an STM32F7 and an STM32H7 are made of alike: a Cortex-M7, its RAM, pads, clocks, and a bus behind bridges.

A family says which pads, gates and bridges there are, makes its own parts and maps its own memory; here they are put
together, in the order in which they need each other.
"""

from __future__ import annotations

import abc
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, cast

from targets.mcu.bus import Bus
from targets.mcu.chip import AskReset, MakeCore, Memory
from targets.mcu.fidelity import Notes
from targets.mcu.irq_lines import IrqLines
from targets.mcu.pins import Pins
from targets.mcu.registers import Peripheral
from targets.mcu.services import Services
from targets.mcu.signals import Signals
from targets.mcu.stm32.adc_noise import ADC_STEPS, AdcNoise
from targets.mcu.stm32.chip import BasicChip, Power
from targets.mcu.stm32.clock_tree import KernelClockTree
from targets.mcu.stm32.dma_requests import Requests
from targets.mcu.stm32.gpio import thresholds
from targets.mcu.stm32.pin_functions import PinFunctions
from targets.mcu.stm32.rtc import Rtc
from targets.mcu.stm32.tim import Timer
from targets.mcu.timebase import Timebase

if TYPE_CHECKING:
    from targets.boards import Board
    from targets.boards.board import Straps

__all__ = ["ITCM_RAM", "M7Chip"]

ITCM_RAM, RAM_BASE = 0x0000_0000, 0x2000_0000
TIME_STAMP_PIN = "PC13"  # RTC_TS (DS11532 and DS12117, additional functions)


class _Power(Power, Protocol):
    """PWR, with what it has to do with Stop and Standby."""

    def enter_stop(self) -> None:
        """The clocks stand still."""

    def may_wake(self) -> bool:
        """Say whether a WKUP pin or the RTC may end Standby."""


class M7Chip(BasicChip):
    """An STM32F7 or STM32H7; see `targets.mcu.chip.Chip`.

    Attributes:
        FUNCTIONS: the alternate functions of every pad of the die; see `PinFunctions`.
        GATES: bus and bit of the clock gate of each peripheral.
        WAKE_UP_PINS: the pins WKUP1, WKUP2 and so on.
        APB: address and size of what lies behind the APB bridges. On AHB a byte leaves the other lanes of its word
            alone; behind these it is repeated over the word.
        rtc: the real-time clock.
    """

    FUNCTIONS: ClassVar[Mapping[str, Mapping[int, tuple[str, ...]]]]
    GATES: ClassVar[Mapping[str, tuple[str, int]]]
    WAKE_UP_PINS: ClassVar[tuple[str, ...]]
    APB: ClassVar[tuple[tuple[int, int], ...]]

    pwr: _Power
    rtc: Rtc
    _tree: KernelClockTree[Any]
    _timers: dict[str, Timer]

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
        # One block for all RAM, so that whoever asks whether anything has changed sees all of it: 0x20000000 first.
        self._ram_parts = ((RAM_BASE, variant.ram_bytes), (ITCM_RAM, variant.itcm_bytes), *variant.more_ram)
        self.ram = bytearray(sum(size for _, size in self._ram_parts))
        self.pins = Pins(tuple(self.FUNCTIONS), time, notes, bonded=variant.pins, thresholds=thresholds(3.3))
        self.signals = Signals(self.pins)
        self._functions = PinFunctions(self.FUNCTIONS, self.signals, time, notes)
        self._tree = self._make_tree()
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
        for number, pin in enumerate(self.WAKE_UP_PINS, 1):
            self.signals.route(f"WKUP{number}", pin)
        self.signals.route("RTC_TS", TIME_STAMP_PIN)
        core_parts = self._make_core_parts(board)
        self._memories = self._map(board)
        everything = (*core_parts, *self._make_peripherals(board))
        self.peripherals = {peripheral.name: peripheral for peripheral in everything}
        self._put_on(bus)
        self._tie(self.GATES, backup=(self.rtc,))
        self.rcc.on_clock_failure = self._clock_failed
        self._pull_pins(board, straps)

    # --- what a family says

    @abc.abstractmethod
    def _make_tree(self) -> KernelClockTree[Any]:
        """Return the clock tree as it is after a reset."""

    @abc.abstractmethod
    def _make_core_parts(self, board: Board) -> tuple[Peripheral, ...]:
        """Make clocks, power, flash, and what depends on them; return them in the order in which they are reset."""

    @abc.abstractmethod
    def _map(self, board: Board) -> tuple[Memory, ...]:
        """Return all memory at all its addresses, once the core parts are there."""

    @abc.abstractmethod
    def _make_peripherals(self, board: Board) -> tuple[Peripheral, ...]:
        """Make everything else."""

    # --- what a family needs for that

    def _map_ram(self) -> list[Memory]:
        """Return the RAM from 0x20000000 on, that beside the core, and then the rest as the variant has it."""
        whole, offset, ram = memoryview(self.ram), 0, []
        for base, size in self._ram_parts:
            # A view of a part of it has all that a bytearray is asked for here and in the engine.
            part = cast("bytearray", whole[offset : offset + size])
            ram.append(Memory(base=base, data=part, writable=True))
            offset += size
        return ram

    def _adc_noise(self, board: Board) -> AdcNoise:
        return AdcNoise(board.adc_noise_lsb * self.pins.vdd_volts / ADC_STEPS, board.name)

    def _put_on(self, bus: Bus) -> None:
        for peripheral in self.peripherals.values():
            behind_bridge = any(start <= peripheral.base < start + size for start, size in self.APB)
            bus.add(peripheral, ahb=not behind_bridge)
        for base, size in self.APB:
            bus.add_quiet(base, size)

    def _clock_failed(self) -> None:
        for name in ("TIM1", "TIM8"):
            self._timers[name].clock_failed()

    # --- for the machine

    def stop_clocks(self) -> None:
        """Let all but LSE and LSI stand still, and tell PWR."""
        super().stop_clocks()
        self.pwr.enter_stop()

    def standby_may_end(self) -> bool:
        """Say whether a WKUP pin or the RTC may end Standby."""
        return self.pwr.may_wake()
