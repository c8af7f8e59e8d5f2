"""GPIO ports of the STM32F1 (RM0008 section 9.2).

A port lends its pads to peripherals (mode AF), to the debug port and to oscillators; what the pad then does is decided
in `targets.mcu.pins`. The output speed (MODE 01, 10, 11) is kept and has no effect: edges are ideal.
"""

from __future__ import annotations

from typing import ClassVar

from targets.mcu.pins import Bank, PadMode, Pin, Pins
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.stm32.port_lock import PortLock

__all__ = ["PADS", "PADS_OF_HIGH_DENSITY", "Gpio"]

PADS_OF_HIGH_DENSITY = tuple(f"P{port}{number}" for port in "ABCDEFG" for number in range(16))
"""The pads of the high-density die, bonded or not."""
PADS = PADS_OF_HIGH_DENSITY[: 5 * 16]
"""Those of the medium-density die; of the low-density one, too, where nothing moves the pins of port E (choice)."""

_RESET_CONFIGURATION = 0x4444_4444
_SPEED = "the output speed (MODE) is kept and has no effect: edges are ideal"
_INPUT_PULL = 0b1000
_OUTPUTS = (PadMode.PUSH_PULL, PadMode.OPEN_DRAIN, PadMode.AF_PUSH_PULL, PadMode.AF_OPEN_DRAIN)


class Gpio(Peripheral):
    """One port.

    Args:
        name: ``GPIOA``.
        base: address.
        services: what the chip offers.
        pins: the pins of the chip.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("CRL", 0x00, reset=_RESET_CONFIGURATION, note=_SPEED),
        Register("CRH", 0x04, reset=_RESET_CONFIGURATION, note=_SPEED),
        Register("IDR", 0x08, writable=0, note="shows a level at once: the clock of its synchroniser is left out"),
        Register("ODR", 0x0C, writable=0xFFFF),
        Register("BSRR", 0x10),
        Register("BRR", 0x14, writable=0xFFFF),
        Register("LCKR", 0x18, writable=0x1_FFFF),
    )

    def __init__(self, name: str, base: int, services: Services, pins: Pins) -> None:
        super().__init__(name, base, services)
        self.bank = Bank()
        self.pins = tuple(pins[f"P{name[-1]}{number}"] for number in range(16))
        for number, pin in enumerate(self.pins):
            pin.bank, pin.mask = self.bank, 1 << number
        self._lock = PortLock()
        self.reset()

    def reset(self) -> None:
        """All pins become floating inputs and the lock is gone."""
        super().reset()
        self._lock.reset()
        for number in range(16):
            self._configure(number)

    def is_live(self, offset: int) -> bool:
        """IDR changes without an event while a pin carries a timer's output that nobody watches."""
        return offset == 0x08 and bool(self.bank.lazy)

    def changing(self, offset: int) -> int:
        """Return those pins, for IDR."""
        return sum(pin.mask for pin in self.bank.lazy) if offset == 0x08 else 0

    # --- configuration

    def write_CRL(self, value: int) -> None:
        """Configure pins 0 to 7, but for those that are locked."""
        self._write_configuration(0x00, 0, value)

    def write_CRH(self, value: int) -> None:
        """Configure pins 8 to 15, but for those that are locked."""
        self._write_configuration(0x04, 8, value)

    def _write_configuration(self, offset: int, first: int, value: int) -> None:
        old = self[offset]
        if self._lock.pins:
            value = self._without_locked(first, old, value)
        self[offset] = value
        changed = old ^ value
        for index in range(8):
            if changed >> 4 * index & 0xF:
                self._configure(first + index)
                self._check_use(self.pins[first + index], value >> 4 * index & 0xF)

    def _without_locked(self, first: int, old: int, value: int) -> int:
        for index in range(8):
            if self._lock.pins >> (first + index) & 1:
                nibble = 0xF << 4 * index
                value = (value & ~nibble) | (old & nibble)
        return value

    def _configure(self, number: int) -> None:
        nibble = self[0x04 if number >= 8 else 0x00] >> 4 * (number & 7) & 0xF
        latch = bool(self[0x0C] >> number & 1)
        self.pins[number].configure(_mode_of(nibble), latch=latch, pull=latch if nibble == _INPUT_PULL else None)

    def _check_use(self, pin: Pin, nibble: int) -> None:
        if nibble & 0b11 == 0b00 and nibble != _INPUT_PULL:
            return
        if pin.claimed_by is not None:
            self.services.notes.add("misuse", pin.name, f"configured by the program while {pin.claimed_by} has the pin")
        elif not pin.bonded:
            self.services.notes.add("misuse", pin.name, "configured by the program, but this package has no such pin")

    # --- levels

    def read_IDR(self) -> int:
        """Return the level of each pin; analog and floating pins read 0."""
        return self.bank.read()

    def write_ODR(self, value: int) -> None:
        """Set the output latches: the level of an output, the direction of an input's pull."""
        changed = self[0x0C] ^ value
        self[0x0C] = value
        while changed:
            bit = changed & -changed
            changed ^= bit
            number = bit.bit_length() - 1
            nibble = self[0x04 if number >= 8 else 0x00] >> 4 * (number & 7) & 0xF
            if nibble == _INPUT_PULL:
                self._configure(number)
            else:
                self.pins[number].set_latch(bool(value & bit))

    def read_BSRR(self) -> int:
        """Write-only: reads 0."""
        return 0

    def write_BSRR(self, value: int) -> None:
        """Reset by the upper half, set by the lower; set wins."""
        self.write_ODR((self[0x0C] & ~(value >> 16)) | (value & 0xFFFF))

    def read_BRR(self) -> int:
        """Write-only: reads 0."""
        return 0

    def write_BRR(self, value: int) -> None:
        """Reset."""
        self.write_ODR(self[0x0C] & ~value)

    # --- the lock

    def write_LCKR(self, value: int) -> None:
        """Take one step of the lock sequence, or begin anew."""
        self._lock.write(value)

    def read_LCKR(self) -> int:
        """Return the lock; a read ends its sequence."""
        return self._lock.read()


def _mode_of(nibble: int) -> PadMode:
    # CNF[1:0] MODE[1:0]; the reserved input configuration 11 is taken as floating (choice)
    if nibble & 0b11:
        return _OUTPUTS[nibble >> 2]
    return PadMode.ANALOG if nibble == 0 else PadMode.INPUT
