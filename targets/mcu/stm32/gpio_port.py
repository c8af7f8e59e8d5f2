"""What the ports of all generations have in common: levels and latches of their pins, which are in C (``port.c``).

A port lends its pads to peripherals, to the debug port and to oscillators; what a pad then does is decided in
`targets.mcu.pins`.
"""

from __future__ import annotations

import abc
import ctypes
import enum
import functools
from array import array
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from targets.mcu.block import BlockInC, PeripheralInC
from targets.mcu.core.library import structure, with_lock_held
from targets.mcu.pins import Bank, Pin, Pins
from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.stm32.port_lock import PortLock

__all__ = ["GpioPort"]

_ASK = ctypes.PYFUNCTYPE(ctypes.c_uint32, ctypes.c_uint32, ctypes.c_uint32)


class _Question(enum.IntEnum):
    """``enum hil_port_question``."""

    READS = 0
    SETS = 1


class _Bank(Bank, BlockInC):
    """A port in C, as its pins see it.

    Args:
        services: what the chip offers.
        base: address of the first register.
        registers: by offset.
        idr: offset of IDR; ODR, BSRR and perhaps BRR follow.
        on_ahb: a byte or half-word leaves the rest of its word alone.
        set_latches: called with what the latches are to be, if C leaves that to Python.

    Attributes:
        pins: bit n is pin n.
    """

    def __init__(
        self,
        services: Services,
        base: int,
        registers: Mapping[int, Register],
        *,
        idr: int,
        on_ahb: bool,
        set_latches: Callable[[int], None],
    ) -> None:
        library = _library()
        self._asked = _ASK(self._ask)
        self._idr, self._odr = idr, idr + 4
        has_brr = registers[idr + 12].name == "BRR"
        block = library.hil_port_new(services.time.queue, idr >> 2, has_brr, on_ahb, self._asked)
        BlockInC.__init__(self, services.time, block, library.hil_port_free, base=base, registers=registers)
        self._in_c: Any = structure("hil_port_pins").from_address(library.hil_port_pins_of(self.block))
        self._take: Callable[[int], None] = functools.partial(library.hil_port_take, self.block)
        self._set_latches = set_latches
        self._lazy: tuple[Pin, ...] = ()
        self.pins: Sequence[Pin] = ()
        self.latches = 0

    @property
    def word(self) -> int:
        """Input levels, one bit for each pin."""
        return self.values[self._idr]

    @word.setter
    def word(self, word: int) -> None:
        self.values[self._idr] = word

    @property
    def lazy(self) -> tuple[Pin, ...]:
        """Pins whose level must be asked for before `word` is right."""
        return self._lazy

    @lazy.setter
    def lazy(self, lazy: tuple[Pin, ...]) -> None:
        self._lazy = lazy
        self._in_c.asked = bool(lazy)

    def leave_alone(self, mask: int, *, alone: bool, noted: bool) -> None:
        """See `Bank.leave_alone`."""
        pins = self._in_c
        pins.alone = pins.alone | mask if alone else pins.alone & ~mask
        pins.shown = pins.shown | mask if alone else pins.shown & ~mask
        pins.noted = pins.noted | mask if noted else pins.noted & ~mask

    def leave_absent(self, mask: int) -> None:
        """There are no such pins: their latches are kept, and that is all."""
        self._in_c.alone |= mask

    def catch_up(self) -> None:
        """See `Bank.catch_up`."""
        if not self._in_c.behind:
            return
        latches, changes = self.values[self._odr], array("Q", bytes(16 * self._in_c.changes))
        self._take(changes.buffer_info()[0])
        for cycle, noted in zip(changes[::2], changes[1::2], strict=True):
            self._tell(noted, cycle)
        self._tell(latches, None)

    def _tell(self, latches: int, cycle: int | None) -> None:
        changed, self.latches = latches ^ self.latches, latches
        for number, pin in enumerate(self.pins):
            if changed >> number & 1:
                pin.set_latch(bool(latches >> number & 1), cycle)

    def _ask(self, question: int, latches: int) -> int:
        try:
            if question == _Question.READS:
                return self.read()
            self._set_latches(latches)
        except BaseException as trouble:  # noqa: BLE001 - ctypes would swallow it
            self.keep(trouble)
        return 0


class GpioPort(PeripheralInC, abc.ABC):
    """A port without the registers that configure it.

    Args:
        name: ``GPIOA``.
        base: address.
        services: what the chip offers.
        pins: the pins of the chip.
        idr: offset of IDR; ODR, BSRR and perhaps BRR follow, and LCKR after these.
        on_ahb: a byte or half-word leaves the rest of its word alone.

    Attributes:
        pins: its own, by number.
        bank: what it reads of them.
    """

    def __init__(self, name: str, base: int, services: Services, pins: Pins, *, idr: int, on_ahb: bool) -> None:
        registers = {register.offset: register for register in self.registers_of()}
        self.bank = self.in_c = _Bank(
            services, base, registers, idr=idr, on_ahb=on_ahb, set_latches=self._set_latches_of_pins
        )
        super().__init__(name, base, services)
        self._values = self.bank.values
        self._idr, self._odr = idr, idr + 4
        letter = name[-1]
        self.pins = tuple(pins[f"P{letter}{number}"] for number in range(16) if f"P{letter}{number}" in pins)
        self.bank.pins = self.pins
        self.bank.leave_absent(0xFFFF & ~((1 << len(self.pins)) - 1))
        for number, pin in enumerate(self.pins):
            pin.bank, pin.mask = self.bank, 1 << number
        pins.banks.append(self.bank)
        self._lock = PortLock()
        self.reset()

    def reset(self) -> None:
        """Go to the state after reset: the latches are 0 and the lock is gone."""
        self.bank.catch_up()
        word = self.bank.word
        super().reset()
        self.bank.word, self.bank.latches = word, self[self._odr]
        self._lock.reset()
        for number in range(len(self.pins)):
            self._configure(number)

    def before_clock_change(self) -> None:
        """Tell pins of all changes so far: their cycles are those of the present clock."""
        self.bank.catch_up()

    def is_live(self, offset: int) -> bool:
        """IDR changes without an event while a pin carries a timer's output that nobody watches."""
        return offset == self._idr and bool(self.bank.lazy)

    def changing(self, offset: int) -> int:
        """Return those pins, for IDR."""
        return sum(pin.mask for pin in self.bank.lazy) if offset == self._idr else 0

    def _set_latches_of_pins(self, latches: int) -> None:
        """Set the output latches, of which some are of pins that somebody looks at."""
        self.bank.catch_up()
        changed = self[self._odr] ^ latches
        self[self._odr] = self.bank.latches = latches
        for number, pin in enumerate(self.pins):
            if changed >> number & 1:
                self._set_latch(number, pin, bool(latches >> number & 1))

    def _set_latch(self, _number: int, pin: Pin, level: bool) -> None:
        pin.set_latch(level)

    @abc.abstractmethod
    def _configure(self, number: int) -> None:
        """Have a pin follow its registers."""

    def _check_use(self, pin: Pin) -> None:
        if pin.claimed_by is not None:
            self.services.notes.add("misuse", pin.name, f"configured by the program while {pin.claimed_by} has the pin")
        elif not pin.bonded:
            self.services.notes.add("misuse", pin.name, "configured by the program, but this package has no such pin")

    # --- the lock

    def write_LCKR(self, value: int) -> None:
        """Take one step of the lock sequence, or begin anew."""
        self._lock.write(value)

    def read_LCKR(self) -> int:
        """Return the lock; a read ends its sequence."""
        return self._lock.read()


@functools.cache
def _library() -> Any:
    """Return the library, with the functions of ports declared, called with Python's lock held."""
    library: Any = with_lock_held()
    pointer, word, flag = ctypes.c_void_p, ctypes.c_uint32, ctypes.c_bool
    library.hil_port_new.argtypes, library.hil_port_new.restype = (pointer, word, flag, flag, _ASK), pointer
    library.hil_port_free.argtypes, library.hil_port_free.restype = (pointer,), None
    library.hil_port_pins_of.argtypes, library.hil_port_pins_of.restype = (pointer,), pointer
    library.hil_port_take.argtypes, library.hil_port_take.restype = (pointer, pointer), None
    return library
