"""GPIO ports with a multiplexer for each pin, from the STM32F2 on (RM0410 section 6).

What a pad does is decided in `targets.mcu.pins`, which signals it carries in `pin_functions`. The output speed is kept
and has no effect: edges are ideal. Choice: the reserved value 11 of PUPDR is no pull. The analog functions of a pin see
it in mode 11 only; EXTI sees every pin that is not analog, whatever its mode (RM0410 section 6.3.9).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from types import MappingProxyType
from typing import ClassVar

from targets.mcu.pins import PadMode, Pins
from targets.mcu.registers import Register
from targets.mcu.services import Services
from targets.mcu.stm32.gpio_port import GpioPort
from targets.mcu.stm32.pin_functions import PinFunctions

__all__ = ["ANALOG_RESETS", "DEBUG_RESETS", "Gpio", "thresholds"]

MODER, OTYPER, OSPEEDR, PUPDR, IDR, ODR, BSRR, LCKR, AFRL, AFRH = range(0x00, 0x28, 4)
_INPUT, _OUTPUT, _ALTERNATE, _ANALOG = range(4)
_PULLS = (None, True, False, None)

DEBUG_RESETS: Mapping[str, Mapping[int, int]] = MappingProxyType(
    {
        "A": MappingProxyType({MODER: 0xA800_0000, OSPEEDR: 0x0C00_0000, PUPDR: 0x6400_0000}),
        "B": MappingProxyType({MODER: 0x0000_0280, OSPEEDR: 0x0000_00C0, PUPDR: 0x0000_0100}),
    }
)
"""Reset values other than 0 by port: the debug pins PA13 to PA15, PB3 and PB4 are in AF0 with their pulls (RM0410
sections 6.4.1 to 6.4.4; the same on the F4)."""

ANALOG_RESETS: Mapping[str, Mapping[int, int]] = MappingProxyType(
    {
        **{port: MappingProxyType({MODER: 0xFFFF_FFFF}) for port in "CDEFGHIJK"},
        "A": MappingProxyType({**DEBUG_RESETS["A"], MODER: 0xABFF_FFFF}),
        "B": MappingProxyType({**DEBUG_RESETS["B"], MODER: 0xFFFF_FEBF}),
    }
)
"""The same where all other pins are analog (RM0433 sections 11.4.1 to 11.4.4; the same on the L4)."""


def thresholds(vdd_volts: float) -> tuple[float, float]:
    """Return VIL and VIH of FT pins: 0.35 VDD - 0.04 V and 0.45 VDD + 0.3 V (DS11532, I/O static characteristics)."""
    return 0.35 * vdd_volts - 0.04, 0.45 * vdd_volts + 0.3


class Gpio(GpioPort):
    """One port; see `GpioPort`.

    Args:
        name: ``GPIOA``.
        base: address.
        services: what the chip offers.
        pins: the pins of the chip.
        functions: the multiplexers of the pins.
        resets: reset values other than 0, by port letter and offset.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("MODER", MODER),
        Register("OTYPER", OTYPER, writable=0xFFFF),
        Register("OSPEEDR", OSPEEDR, note="is kept and has no effect: edges are ideal"),
        Register("PUPDR", PUPDR),
        Register("IDR", IDR, writable=0, note="shows a level at once: the clock of its synchroniser is left out"),
        Register("ODR", ODR, writable=0xFFFF),
        Register("BSRR", BSRR),
        Register("LCKR", LCKR, writable=0x1_FFFF),
        Register("AFRL", AFRL),
        Register("AFRH", AFRH),
    )

    def __init__(
        self,
        name: str,
        base: int,
        services: Services,
        pins: Pins,
        functions: PinFunctions,
        *,
        resets: Mapping[str, Mapping[int, int]] = DEBUG_RESETS,
    ) -> None:
        self._resets = resets.get(name[-1], {})
        self._functions = functions
        super().__init__(name, base, services, pins, idr=IDR, on_ahb=True)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers with the reset values of this port."""
        return (
            Register(
                register.name,
                register.offset,
                self._resets.get(register.offset, 0),
                register.writable,
                note=register.note,
            )
            for register in self.REGISTERS
        )

    # --- configuration

    def write_MODER(self, value: int) -> None:
        """Choose input, output, alternate function or analog."""
        self._write_fields(MODER, 2, 0, value)

    def write_OTYPER(self, value: int) -> None:
        """Choose push-pull or open-drain."""
        self._write_fields(OTYPER, 1, 0, value)

    def write_OSPEEDR(self, value: int) -> None:
        """Keep the output speed, but for pins that are locked."""
        self[OSPEEDR] = self._unlocked(OSPEEDR, 2, 0, value)

    def write_PUPDR(self, value: int) -> None:
        """Choose the pulls."""
        self._write_fields(PUPDR, 2, 0, value)

    def write_AFRL(self, value: int) -> None:
        """Choose the alternate functions of pins 0 to 7."""
        self._write_fields(AFRL, 4, 0, value)

    def write_AFRH(self, value: int) -> None:
        """Choose the alternate functions of pins 8 to 15."""
        self._write_fields(AFRH, 4, 8, value)

    def _write_fields(self, offset: int, width: int, first: int, value: int) -> None:
        """Write a register of fields `width` bits wide, that of pin `first` the lowest."""
        old = self[offset]
        value = self[offset] = self._unlocked(offset, width, first, value)
        changed, field = old ^ value, (1 << width) - 1
        while changed:
            index = ((changed & -changed).bit_length() - 1) // width
            changed &= ~(field << width * index)
            if first + index < len(self.pins):
                self._configure(first + index)
                if value >> width * index & field and self._mode(first + index) != _ANALOG:
                    self._check_use(self.pins[first + index])

    def _unlocked(self, offset: int, width: int, first: int, value: int) -> int:
        """Return what a write leaves: the fields of locked pins stay."""
        locked = self._lock.pins >> first
        if not locked:
            return value
        kept = sum((1 << width) - 1 << width * index for index in range(32 // width) if locked >> index & 1)
        return value & ~kept | self[offset] & kept

    def _configure(self, number: int) -> None:
        pin, mode = self.pins[number], self._mode(number)
        if mode == _ALTERNATE:
            # Before the pad changes over and after it has: so it has no level in between that nobody meant.
            self._functions.choose(pin.name, self[AFRH if number >= 8 else AFRL] >> 4 * (number & 7) & 0xF)
        pull = _PULLS[self[PUPDR] >> 2 * number & 3]
        pin.configure(self._pad_mode(number, mode), latch=bool(self[ODR] >> number & 1), pull=pull)
        if mode != _ALTERNATE:
            self._functions.choose(pin.name, None)

    def _mode(self, number: int) -> int:
        return self[MODER] >> 2 * number & 3

    def _pad_mode(self, number: int, mode: int) -> PadMode:
        open_drain = self[OTYPER] >> number & 1
        if mode == _OUTPUT:
            return PadMode.OPEN_DRAIN if open_drain else PadMode.PUSH_PULL
        if mode == _ALTERNATE:
            return PadMode.AF_OPEN_DRAIN if open_drain else PadMode.AF_PUSH_PULL
        return PadMode.ANALOG if mode == _ANALOG else PadMode.INPUT
