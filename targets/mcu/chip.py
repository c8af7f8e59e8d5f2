"""What a machine needs of the chip that it runs, whatever the family; and the chip of a family by its name.

A chip has memories, blocks of registers with their peripherals, pins, and a core, and knows what a boot pin or an
option byte means. How a machine makes time, instructions and events of it is no business of the chip's.
"""

from __future__ import annotations

import abc
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, ClassVar, Protocol

from targets.mcu.cortexm.core import Core
from targets.mcu.cortexm.kinds import CoreKind
from targets.mcu.fidelity import Notes
from targets.mcu.pins import Pins
from targets.mcu.registers import Peripheral
from targets.mcu.services import Services
from targets.mcu.signals import Signals
from targets.mcu.timebase import Timebase

if TYPE_CHECKING:
    from targets.boards import Board
    from targets.boards.board import Straps
    from targets.mcu.bus import Bus
    from targets.mcu.stm32.i2c import I2c
    from targets.mcu.stm32.spi_fifo import FifoSpi
    from targets.mcu.stm32.spi_packets import PacketSpi
    from targets.mcu.stm32.usart_base import UsartBase
    from targets.mcu.stm32f1.i2c import I2c as I2cV1
    from targets.mcu.stm32f1.spi import Spi

__all__ = ["AskReset", "Boot", "Chip", "DeepSleep", "FlashMemory", "MakeCore", "Memory"]

MakeCore = Callable[[Services], Core]
"""Makes the CPU core from what the chip offers."""
AskReset = Callable[[str], None]
"""Asks for a reset of the chip with its cause; see `Services.chip_reset`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Memory:
    """Bytes that the CPU reads at an address, and may write there; several may show the same bytes.

    Attributes:
        base: first address.
        data: the contents, shared with the engine. The engine executes from whole kilobytes only; what is smaller is
            read through the bus.
        writable: RAM. A store into anything else goes to `FlashMemory.program`.
    """

    base: int
    data: bytearray
    writable: bool = False

    def holds(self, address: int) -> bool:
        """Say whether the address lies in it."""
        return self.base <= address < self.base + len(self.data)


@dataclass(frozen=True, slots=True, kw_only=True)
class Boot:
    """Where a chip begins after a reset.

    Attributes:
        table: address of the vector table.
        refusal: why no program is there, in a sentence; empty if there is one.
    """

    table: int
    refusal: str = ""


class DeepSleep(Protocol):
    """A mode in which the clocks stand still."""

    @property
    def wakeup_s(self) -> Fraction:
        """Seconds from the event that wakes up to the first instruction."""

    @property
    def is_standby(self) -> bool:
        """True if the mode is left by a reset alone."""


class FlashMemory(Protocol):
    """The flash with its interface.

    Attributes:
        memory: what is in it, from `Chip.FLASH_BASE` on.
        on_code_changed: called with address and size after the contents changed, for each place where they are seen.
        on_latency: called with the number of wait states when it changes.
        stall_until: called with a cycle before which no instruction in flash can begin.
    """

    memory: bytearray
    on_code_changed: Callable[[int, int], None]
    on_latency: Callable[[int], None]
    stall_until: Callable[[int], None]

    def load(self, address: int, data: bytes) -> None:
        """Put an image into flash or option bytes, as a programmer does before power-on. Raises `BusFault`."""

    def program(self, address: int, size: int, value: int) -> None:
        """A store by program or DMA into memory that is not RAM. Raises `BusFault`."""


class Chip(abc.ABC):
    """A CPU core and the peripherals around it.

    A subclass is made of board, straps, time, notes, bus, a maker of the core, and who is asked for a reset, in this
    order; it puts its peripherals on the bus itself, and the machine does so with the memories.

    Attributes:
        START_HZ: HCLK after a reset.
        CORE: what core it has.
        FLASH_BASE: where the flash begins, as images are linked and programmers see it.
        REGISTER_WINDOWS: address and size of where registers are.
        BIT_BAND: base of each bit-band alias region, and of the megabyte whose bits it shows; empty for none.
        core: the CPU core, without what executes instructions.
        services: what the peripherals use.
        pins: every pin by name.
        signals: every signal between peripherals and pins.
        peripherals: every peripheral by its name in the reference manual.
        usarts: the USARTs by name.
        i2cs: the I2C interfaces that are modelled, by name.
        spis: the SPI interfaces that are modelled, by name.
        flash: the flash with its interface.
        ram: all RAM, for whoever wants to know whether anything changed; from 0x20000000 on first.
    """

    START_HZ: ClassVar[int]
    CORE: ClassVar[CoreKind]
    FLASH_BASE: ClassVar[int] = 0x0800_0000
    REGISTER_WINDOWS: ClassVar[tuple[tuple[int, int], ...]]
    BIT_BAND: ClassVar[Mapping[int, int]] = {}

    core: Core
    services: Services
    pins: Pins
    signals: Signals
    peripherals: dict[str, Peripheral]
    usarts: dict[str, UsartBase]
    i2cs: Mapping[str, I2c] | Mapping[str, I2cV1] = {}
    spis: Mapping[str, Spi] | Mapping[str, FifoSpi] | Mapping[str, PacketSpi] = {}
    ram: bytearray

    @abc.abstractmethod
    def __init__(
        self,
        board: Board,
        straps: Straps,
        time: Timebase,
        notes: Notes,
        bus: Bus,
        make_core: MakeCore,
        ask_reset: AskReset,
    ) -> None: ...

    @property
    def blocks(self) -> Sequence[Peripheral]:
        """Every block of registers: the peripherals, and those of the core."""
        return (*self.peripherals.values(), *self.core.blocks)

    @property
    @abc.abstractmethod
    def flash(self) -> FlashMemory:
        """The flash with its interface."""

    @property
    @abc.abstractmethod
    def starting(self) -> Mapping[str, Fraction]:
        """When the clocks that start will be ready, by name, in seconds of bench time."""

    @property
    @abc.abstractmethod
    def memories(self) -> Sequence[Memory]:
        """All memory that a program sees, none above another."""

    # --- starting

    @abc.abstractmethod
    def boot(self, image_table: int) -> Boot:
        """Return where the chip begins, by boot pins and option bytes, and what the image says of its vector table."""

    @abc.abstractmethod
    def reset(self, cause: str) -> None:
        """Reset everything that a reset with this cause resets."""

    @abc.abstractmethod
    def watchdog_runs(self) -> bool:
        """Say whether a watchdog will reset the chip if the program does nothing more."""

    # --- deep sleep

    @abc.abstractmethod
    def deep_sleep(self) -> DeepSleep:
        """Return the mode that WFI and WFE lead to with SLEEPDEEP set."""

    @abc.abstractmethod
    def sleep_resets(self, mode: DeepSleep) -> bool:
        """Say whether the option bytes have the chip reset instead of entering the mode."""

    @abc.abstractmethod
    def enter_standby(self) -> bool:
        """Enter Standby; False if something wakes up at once."""

    @abc.abstractmethod
    def stop_clocks(self) -> None:
        """Let all clocks of the core stand still, but those that run through Stop and Standby."""

    @abc.abstractmethod
    def restart_clocks(self) -> None:
        """Leave Stop mode."""

    @abc.abstractmethod
    def standby_may_end(self) -> bool:
        """Say whether something may end Standby."""

    @abc.abstractmethod
    def sends_events(self) -> bool:
        """Say whether an edge from outside could be an event for WFE."""

    # --- for people

    @abc.abstractmethod
    def diagnose(self, pc: int) -> str | None:
        """Return what is to be said when the program executes at `pc`, or None for nothing."""

    def in_flash(self, address: int) -> bool:
        """Say whether an address lies in the flash, wherever that is seen."""
        return any(memory.holds(address) for memory in self.memories if memory.data is self.flash.memory)
