"""GPIO ports of the STM32F1 (RM0008 section 9.2).

The output speed (MODE 01, 10, 11) is kept and has no effect: edges are ideal.
"""

from __future__ import annotations

from typing import ClassVar

from targets.mcu.pins import PadMode, Pin, Pins
from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.stm32.gpio_port import GpioPort

__all__ = ["PADS", "PADS_OF_HIGH_DENSITY", "Gpio"]

PADS_OF_HIGH_DENSITY = tuple(f"P{port}{number}" for port in "ABCDEFG" for number in range(16))
"""The pads of the high-density die, bonded or not."""
PADS = PADS_OF_HIGH_DENSITY[: 5 * 16]
"""Those of the medium-density die; of the low-density one, too, where nothing moves the pins of port E (choice)."""

_RESET_CONFIGURATION = 0x4444_4444
_SPEED = "the output speed (MODE) is kept and has no effect: edges are ideal"
_INPUT_PULL = 0b1000
_OUTPUTS = (PadMode.PUSH_PULL, PadMode.OPEN_DRAIN, PadMode.AF_PUSH_PULL, PadMode.AF_OPEN_DRAIN)


class Gpio(GpioPort):
    """One port; see `GpioPort`."""

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
        super().__init__(name, base, services, pins, idr=0x08, on_ahb=False)

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
                if value >> 4 * index & 0xF == _INPUT_PULL or value >> 4 * index & 0b11:
                    self._check_use(self.pins[first + index])

    def _without_locked(self, first: int, old: int, value: int) -> int:
        for index in range(8):
            if self._lock.pins >> (first + index) & 1:
                nibble = 0xF << 4 * index
                value = (value & ~nibble) | (old & nibble)
        return value

    def _configure(self, number: int) -> None:
        nibble = self._nibble(number)
        latch = bool(self[0x0C] >> number & 1)
        self.pins[number].configure(_mode_of(nibble), latch=latch, pull=latch if nibble == _INPUT_PULL else None)

    def _set_latch(self, number: int, pin: Pin, level: bool) -> None:
        """Set the level of an output, or the direction of an input's pull."""
        if self._nibble(number) == _INPUT_PULL:
            self._configure(number)
        else:
            super()._set_latch(number, pin, level)

    def _nibble(self, number: int) -> int:
        return self[0x04 if number >= 8 else 0x00] >> 4 * (number & 7) & 0xF


def _mode_of(nibble: int) -> PadMode:
    # CNF[1:0] MODE[1:0]; the reserved input configuration 11 is taken as floating (choice)
    if nibble & 0b11:
        return _OUTPUTS[nibble >> 2]
    return PadMode.ANALOG if nibble == 0 else PadMode.INPUT
