"""What a chip offers to its peripherals: time, clocks, interrupt lines, DMA requests, pin signals, notes.

These are the narrow seams between peripherals, so that each can be tested alone, with `targets.mcu.testing` in place of
a whole chip.
"""

from __future__ import annotations

import ctypes
import enum
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import NamedTuple, Protocol

from targets.mcu.fidelity import Notes
from targets.mcu.timebase import Timebase

__all__ = [
    "BusMaster",
    "Clocks",
    "DmaRequest",
    "InputSignal",
    "IrqLine",
    "OutputSignal",
    "RequestInC",
    "Services",
    "Watch",
    "Wave",
    "drive_in_c",
]


class IrqLine(Protocol):
    """An interrupt request of a peripheral to the NVIC: a level, pended on its rising edge and while it stays high.

    Attributes:
        core: the core in C whose interrupt nobody else drives, so that a peripheral in C may do it there; else None.
        driven_in_c: that is done, and nobody else may drive it; see `drive_in_c`.
    """

    driven_in_c: bool

    @property
    def core(self) -> ctypes.c_void_p | None:
        """See the class."""

    def set(self, level: bool) -> None:
        """Drive the line."""


def drive_in_c(lines: Sequence[IrqLine]) -> ctypes.c_void_p | None:
    """Have all of these interrupts driven in C from now on, if that goes; return the core whose they are, else None."""
    cores = [line.core for line in lines]
    if None in cores:
        return None
    for line in lines:
        line.driven_in_c = True
    return cores[0]


class RequestInC(NamedTuple):
    """A request line in C, so that a peripheral in C may drive it there.

    Attributes:
        controller: ``struct hil_requests *``, where it leads.
        number: of the line.
    """

    controller: ctypes.c_void_p
    number: int


class DmaRequest(Protocol):
    """A request of a peripheral to a DMA controller: a level. The controller answers by reading or writing registers.

    `set(True)` and `pulse` may move a byte at once, before they return.

    Attributes:
        in_c: the line in C, for a peripheral that is there, too; else None.
    """

    @property
    def in_c(self) -> RequestInC | None:
        """See the class."""

    def set(self, level: bool) -> None:
        """Drive the request."""

    def pulse(self) -> None:
        """Ask for one transfer: the request is kept until it was served once, or until ``set(False)``.

        Timers ask like this: no register says that the transfer has happened, the controller's acknowledge does.
        """


class Clocks(Protocol):
    """How many HCLK cycles one tick of a derived clock takes; 0 while that clock stands still."""

    def pclk(self, bus: str) -> int:
        """Return HCLK cycles per tick of the bus clock; `bus` is ``AHB``, ``APB1`` or ``APB2``."""

    def timer(self, bus: str) -> int:
        """Return HCLK cycles per tick of the timers' clock on that bus (the bus clock, doubled if it is divided)."""

    def kernel(self, peripheral: str) -> Fraction:
        """Return HCLK cycles per tick of the clock that a peripheral with a choice of clocks, as ``USART3``, runs on.

        It may be an oscillator that knows nothing of HCLK, so it is exact and need not be whole. The peripheral is told
        of a change as of any other of its clock.

        Raises:
            KeyError: the chip gives that peripheral no choice.
        """


class Watch(enum.IntEnum):
    """Who looks at an output signal, and so how promptly its changes must be told.

    NOBODY: nobody; `OutputSignal.refresh` is called before anybody looks once.
    RECORD: its edges are written down, and looked at later, after `OutputSignal.refresh`.
    LIVE: something may react to an edge; each must be told at its cycle.
    """

    NOBODY = 0
    RECORD = 1
    LIVE = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class Wave:
    """A signal that changes too often for its edges to be told.

    Attributes:
        hz: periods in a second.
        duty: the part of a period for which it is high.
    """

    hz: Fraction
    duty: Fraction


class OutputSignal(Protocol):
    """An alternate-function output such as ``TIM2_CH1`` or ``USART1_TX``, or one inside the chip such as ``TIM2_TRGO``.

    Most peripherals just call `set` at the cycle of a change. One that makes many edges by itself may leave out those
    nobody watches: it asks `watch`, sets `on_watch` to be told when the answer changes, and offers `refresh`.

    Attributes:
        refresh: brings level and record up to the present cycle, by `set_at` and `set`; None while they always are.
        on_watch: called after a change of what `watch` or `at_pin` return, when level and record are up to the present
            cycle.
        pass_over: has the peripheral not tell of the edges of the serial frame that has just begun, unless `refresh` is
            called before its end; returns whether that goes. None where there are no frames.
    """

    refresh: Callable[[], None] | None
    on_watch: Callable[[], None] | None
    pass_over: Callable[[], bool] | None

    def set(self, level: bool | None) -> None:
        """Drive the signal from the present cycle on; None releases it."""

    def set_at(self, cycle: int, level: bool | None) -> None:
        """Drive the signal from `cycle` on, which may have passed if `watch` is not LIVE; never out of order."""

    def set_wave(self, wave: Wave | None) -> None:
        """Say that the signal is a wave from the present cycle on, or that its edges are told (again)."""

    def watch(self) -> Watch:
        """Say who looks at the signal."""

    def tell_late(self, catch_up: Callable[[], None], back: InputSignal | None = None) -> bool:
        """Say whether changes may be left out, until `refresh` or `catch_up` is called.

        They may while `watch` is NOBODY, but not where others drive the pad as well: that they contradict each other is
        noted. They also may where a wire leads to an input signal alone, `back`, at which nobody looks.
        """

    def at_pin(self) -> bool:
        """Say whether a pin is configured to carry the signal, so that anybody outside can see it."""

    def open_drain(self) -> bool:
        """Say whether that pin only pulls low, so that others may do so too."""


class InputSignal(Protocol):
    """An alternate-function input such as ``TIM2_CH1`` or ``USART1_RX``.

    Attributes:
        on_change: called with the new level, at the cycle of the change. None while nobody listens.
        on_reach: called after a change of what `at_pin` returns, if anybody wants to know.
    """

    on_change: Callable[[bool], None] | None
    on_reach: Callable[[], None] | None

    def level(self) -> bool:
        """Return the present level; a floating or analog pin reads as low."""

    def holds(self, forget: Callable[[], None]) -> bool:
        """Say whether the level stays as it is, until `forget` is called, or `on_reach`; False: nobody knows."""

    def at_pin(self) -> bool:
        """Say whether what is outside of a pin can reach the signal: it is not analog, nor driven by the chip."""


class BusMaster(Protocol):
    """Access to memory and registers, as a DMA controller has it."""

    def read(self, address: int, size: int) -> int:
        """Read 1, 2 or 4 bytes. Raises `BusFault`."""

    def write(self, address: int, size: int, value: int) -> None:
        """Write 1, 2 or 4 bytes. Raises `BusFault`."""

    def read_words(self, address: int, count: int) -> list[int]:
        """Read words from a multiple of 4 on. Raises `BusFault`."""

    def write_words(self, address: int, words: Sequence[int]) -> None:
        """Write words from a multiple of 4 on, up to the first that cannot be written. Raises `BusFault`."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Services:
    """Everything a peripheral may use.

    Attributes:
        time: the chip's cycles and events.
        clocks: rates of derived clocks.
        notes: where what is not modelled is noted.
        irq: interrupt line by number (position in the vector table less 16).
        dma: DMA request by the peripheral's own name for it, such as ``USART1_TX`` or ``TIM2_UP``.
        output: output signal by name.
        input: a listener to the input signal of that name, for the caller to keep.
        bus: memory and registers.
        chip_reset: asks for a reset of the chip with its cause, as RCC_CSR names it: ``IWDG``, ``WWDG``, ``SFT``,
            ``LPWR``, ``PIN``, ``POR``. It happens at the next instruction boundary.
    """

    time: Timebase
    clocks: Clocks
    notes: Notes
    irq: Callable[[int], IrqLine]
    dma: Callable[[str], DmaRequest]
    output: Callable[[str], OutputSignal]
    input: Callable[[str], InputSignal]
    bus: BusMaster
    chip_reset: Callable[[str], None]
