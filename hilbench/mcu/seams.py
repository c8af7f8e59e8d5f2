"""What the bench needs of an emulated chip; `targets.mcu.machine.Machine` has it, and so may another.

A machine runs ahead of bench time: it is given a time to run to, and reports through callbacks what its firmware did at
exact times of that span.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from fractions import Fraction
from typing import Protocol

from targets.mcu.cortexm.faults import Fault
from targets.mcu.fidelity import Notes
from targets.mcu.i2c_bus import I2cBus
from targets.mcu.pins import Pins
from targets.mcu.registers import Peripheral
from targets.mcu.serial_line import SerialFormat, SerialFrame, Words
from targets.mcu.signals import Signals
from targets.mcu.spi_bus import SpiBus

__all__ = ["Ending", "I2c", "Machine", "Spi", "Usart"]


class Usart(Protocol):
    """One USART, as its line sees it.

    Attributes:
        on_frame: called with each frame that it sends, when its start bit begins.
        on_format_change: called when `baud_hz` or `format` have changed.
        keeps_words: have words kept for `take_words` instead, as far as nobody in the chip has to know of them at once.
    """

    on_frame: Callable[[SerialFrame], None] | None
    on_format_change: Callable[[], None]

    keeps_words: bool

    def take_words(self) -> list[Words]:
        """Return the words that were sent and kept since this was called last."""

    def receive(self, frame: SerialFrame) -> None:
        """Take a frame from the line, at the first cycle not before its start bit begins."""

    def expect(self, words: Words) -> None:
        """Take frames from the line as each begins, behind those that are expected already."""

    @property
    def expected(self) -> int:
        """How many of these have not begun yet."""

    def expect_only(self, count: int) -> None:
        """Expect no more than the next so many."""

    @property
    def baud_hz(self) -> Fraction:
        """Bits a second, as the firmware has set it; 0 while it has not."""

    @property
    def format(self) -> SerialFormat:
        """How words are framed, as the firmware has set it."""


class I2c(Protocol):
    """One I2C interface, as those outside see it."""

    @property
    def bus(self) -> I2cBus:
        """What slaves are soldered to."""

    def draw(self, on_edge: Callable[[str, int, bool], None]) -> None:
        """Have `on_edge` called with ``scl`` or ``sda``, bench time in ns and level of each edge, some time later."""

    def undrawn_ns(self) -> int | None:
        """Return the bench time from which on edges are still to come; None if there are none."""


class Spi(Protocol):
    """One SPI interface, as those outside see it."""

    @property
    def bus(self) -> SpiBus:
        """What slaves are soldered to."""


class Ending(Protocol):
    """Why a machine does not run on.

    Attributes:
        kind: ``exit`` if the firmware asked for it, ``stop`` if somebody wants to look; else what has gone wrong, such
            as ``lockup``.
        status: what the firmware gave with its exit.
        cause: what happened, in words.
        pc: address of the instruction.
        place: ``function (file.c:42)``, or empty if the image does not tell.
        ns: bench time.
    """

    @property
    def kind(self) -> str: ...  # noqa: D102
    @property
    def status(self) -> int: ...  # noqa: D102
    @property
    def cause(self) -> str: ...  # noqa: D102
    @property
    def pc(self) -> int: ...  # noqa: D102
    @property
    def place(self) -> str: ...  # noqa: D102
    @property
    def ns(self) -> int: ...  # noqa: D102


class Waiting(Protocol):
    """A loop that changes nothing.

    Attributes:
        pc: an instruction of it.
        polled: addresses of the registers that are read in it.
    """

    @property
    def pc(self) -> int: ...
    @property
    def polled(self) -> tuple[int, ...]: ...


class Chip(Protocol):
    """What of a chip its surroundings can touch."""

    @property
    def pins(self) -> Pins:
        """The pins, by name."""

    @property
    def signals(self) -> Signals:
        """Which pin carries which signal."""

    @property
    def usarts(self) -> Mapping[str, Usart]:
        """The USARTs, by name."""

    @property
    def i2cs(self) -> Mapping[str, I2c]:
        """The I2C interfaces that are modelled, by name."""

    @property
    def spis(self) -> Mapping[str, Spi]:
        """The SPI interfaces that are modelled, by name."""

    @property
    def blocks(self) -> Iterable[Peripheral]:
        """Every block of registers: the peripherals, and those of the core."""

    @property
    def starting(self) -> Mapping[str, Fraction]:
        """When the oscillators that start will be ready, by name, in seconds of bench time."""


class Machine(Protocol):
    """A chip that executes firmware.

    Attributes:
        notes: what the firmware touched that is not modelled, and what silicon would not have done for it.
        on_console: called with text of the firmware's console and the channel it came by.
        on_reset: called with the cause after each reset.
        on_fault: called with each fault.
    """

    notes: Notes
    on_console: Callable[[bytes, str], None]
    on_reset: Callable[[str], None]
    on_fault: Callable[[Fault], None]

    @property
    def chip(self) -> Chip:
        """Pins and peripherals."""

    @property
    def now_ns(self) -> int:
        """The present of the machine, in ns of bench time."""

    @property
    def ended(self) -> Ending | None:
        """Why it does not run on; None while it does."""

    @property
    def waits_in(self) -> Waiting | None:
        """The loop in which the program waits for something to happen, or None."""

    @property
    def pc(self) -> int:
        """Address of the instruction that is executed next."""

    @property
    def writes(self) -> int:
        """How many writes to registers of peripherals there have been."""

    @property
    def asleep(self) -> tuple[str, int] | None:
        """How the CPU sleeps, ``Sleep``, ``Stop`` or ``Standby``, and since which instruction; None if it does not."""

    def run_to(self, limit_ns: int) -> None:
        """Execute until `limit_ns`, or until it has ended."""

    def at_ns(self, ns: int, action: Callable[[], None]) -> None:
        """Have `action` happen at the first cycle not before `ns`, or now if that has passed."""

    def horizon(self, ns: int) -> None:
        """End the present `run_to` at `ns` already."""

    def reset(self, cause: str = "PIN") -> None:
        """Reset the chip."""

    def hang(self) -> None:
        """Have the program do nothing more until a reset; the rest of the chip goes on."""

    def forget_resets(self) -> None:
        """Take note that something has come from outside, so that resets from here on are no endless loop yet."""

    def cover(self) -> None:
        """Remember from now on what is executed."""

    def executed(self) -> Iterable[int]:
        """Return the addresses of all instructions executed since `cover`."""

    def stop_at(self, addresses: Iterable[int], written: Iterable[tuple[int, int]]) -> None:
        """End before an instruction at one of these addresses, or one that writes to these: address, size in bytes."""

    def function(self, pc: int) -> str:
        """Return the name of the function at an address, or the address."""

    def place(self, pc: int) -> str:
        """Return function and source line of an address, as far as the image tells, otherwise the address."""


def first_ending(machines: Sequence[Machine]) -> tuple[int, Ending] | None:
    """Return number and ending of the first of `machines` that has ended, by bench time; None if all run."""
    ended = [(machine.ended.ns, number, machine.ended) for number, machine in enumerate(machines) if machine.ended]
    if not ended:
        return None
    _, number, ending = min(ended, key=lambda item: item[:2])
    return number, ending
