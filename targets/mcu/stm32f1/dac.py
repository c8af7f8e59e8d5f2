"""The converters to analog: registers and data formats (RM0008 sections 12.3.3, 12.4 and 12.5).

High-density devices have them, and the value line (RM0041 section 11), which knows when DMA comes too late.

Choices where the manual is silent:

* A data register reads as what its channel holds now, whichever register has put it there; after DHR8R the lowest four
  bits are 0.
* TSEL and MAMP keep their values while EN was set before and stays set. SWTRIGR reads 0.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial

from targets.mcu.fidelity import Fidelity
from targets.mcu.pins import Pins
from targets.mcu.registers import Peripheral, Register
from targets.mcu.services import Services
from targets.mcu.stm32f1.dac_channel import CHANNEL_BITS, EN, FULL, MAMP, TRIGGERS, TSEL, VALUE_LINE_TRIGGERS, Channel

__all__ = ["Dac"]

CR, SWTRIGR = 0x00, 0x04
RIGHT, LEFT, BYTE, RIGHT_DUAL, LEFT_DUAL, BYTE_DUAL = range(6)
_DATA = {
    0x08: ("DHR12R1", RIGHT, 0x0FFF),
    0x0C: ("DHR12L1", LEFT, 0xFFF0),
    0x10: ("DHR8R1", BYTE, 0x00FF),
    0x14: ("DHR12R2", RIGHT, 0x0FFF),
    0x18: ("DHR12L2", LEFT, 0xFFF0),
    0x1C: ("DHR8R2", BYTE, 0x00FF),
    0x20: ("DHR12RD", RIGHT_DUAL, 0x0FFF_0FFF),
    0x24: ("DHR12LD", LEFT_DUAL, 0xFFF0_FFF0),
    0x28: ("DHR8RD", BYTE_DUAL, 0xFFFF),
}
DOR1, DOR2 = 0x2C, 0x30

_PINS = ("PA4", "PA5")
SR = 0x34
DMAUDR = 1 << 13  # of SR, and DMAUDRIE of CR; those of channel 2 are 16 bits higher
BOTH_DMAUDR = DMAUDR << 16 | DMAUDR
_ANALOG = "the output follows DOR and EN at once, and the buffer reaches both rails (choice)"


class Dac(Peripheral):
    """The DAC.

    Args:
        base: address of CR.
        services: what the chip offers. Used: inputs ``TIMx_TRGO`` and ``EXTI9_EDGE``, DMA requests ``DAC_CH1`` and
            ``DAC_CH2``, the clock of APB1, and of the value line interrupt 54.
        pins: the pins of the chip, whose supply is VREF+.
        value_line: with the triggers and registers of the value line.
    """

    REGISTERS = (
        Register("CR", CR, 0, CHANNEL_BITS << 16 | CHANNEL_BITS, fidelity=Fidelity.PARTLY, note=_ANALOG),
        Register("SWTRIGR", SWTRIGR, 0, 0x3),
        *(Register(name, offset, 0, writable) for offset, (name, _, writable) in _DATA.items()),
        Register("DOR1", DOR1, 0, 0),
        Register("DOR2", DOR2, 0, 0),
    )

    def __init__(self, base: int, services: Services, pins: Pins, *, value_line: bool = False) -> None:
        self._value_line = value_line
        super().__init__("DAC", base, services)
        triggers = VALUE_LINE_TRIGGERS if value_line else TRIGGERS
        self._channels = tuple(Channel(number, services, pins[pin], triggers) for number, pin in enumerate(_PINS))
        self._irq = services.irq(54) if value_line else None
        if value_line:
            for channel in self._channels:
                channel.on_underrun = partial(self._underrun, DMAUDR << 16 * channel.number)
        for offset, (name, form, _) in _DATA.items():
            both = form >= RIGHT_DUAL
            channels = self._channels if both else (self._channels[name.endswith("2")],)
            self._readers[offset] = partial(self._read_data, channels, form)
            self._writers[offset] = partial(self._write_data, channels, form)

    def registers_of(self) -> Iterable[Register]:
        """Return the registers of this chip."""
        if not self._value_line:
            return self.REGISTERS
        control, *others = self.REGISTERS
        return (replace(control, writable=control.writable | BOTH_DMAUDR), *others, Register("SR", SR, 0, BOTH_DMAUDR))

    # --- what the chip calls

    def reset(self) -> None:
        """Go to the state after reset: outputs off, nothing held."""
        super().reset()
        for channel in self._channels:
            channel.reset()
        self._update()

    def after_clock_change(self) -> None:
        """Go on at the new rate of APB1."""
        cycles = self.services.clocks.pclk("APB1") if self.clocked else 0
        for channel in self._channels:
            channel.set_clock(cycles)

    # --- registers

    def write_CR(self, value: int) -> None:
        """Set up both channels."""
        for channel in self._channels:
            shift, old = 16 * channel.number, self[CR]
            frozen = TSEL | MAMP if old >> shift & value >> shift & EN else 0
            if (old ^ value) >> shift & frozen:
                text = f"TSEL{channel.number + 1} and MAMP{channel.number + 1} keep their values while EN is set"
                self.note("misuse", f"CR.EN{channel.number + 1}", text)
            value = value & ~(frozen << shift) | old & frozen << shift
        self[CR] = value
        for channel in self._channels:
            channel.set_up(value >> 16 * channel.number & CHANNEL_BITS)
        self._update()

    def write_SR(self, value: int) -> None:
        """A flag of an underrun is cleared by a one."""
        self[SR] &= ~value
        self._update()

    def read_SWTRIGR(self) -> int:
        """Write-only."""
        return 0

    def write_SWTRIGR(self, value: int) -> None:
        """Trigger the channels that wait for software; at once, for both at the same cycle."""
        for channel in self._channels:
            if value >> channel.number & 1:
                channel.trigger_by_software()

    def read_DOR1(self) -> int:
        """What channel 1 puts out."""
        return self._channels[0].put_out

    def read_DOR2(self) -> int:
        """What channel 2 puts out."""
        return self._channels[1].put_out

    def _underrun(self, flag: int) -> None:
        self[SR] |= flag
        self._update()

    def _update(self) -> None:
        if self._irq is not None:
            self._irq.set(bool(self[SR] & self[CR] & BOTH_DMAUDR))

    def _read_data(self, channels: Iterable[Channel], form: int) -> int:
        held = [channel.held for channel in channels]
        shift = 8 if form == BYTE_DUAL else 16
        return sum(_shown(word, form) << shift * index for index, word in enumerate(held))

    def _write_data(self, channels: Iterable[Channel], form: int, value: int) -> None:
        shift = 8 if form == BYTE_DUAL else 16
        for index, channel in enumerate(channels):
            channel.hold(_taken(value >> shift * index, form))


def _taken(value: int, form: int) -> int:
    """Return the 12 bits that a write gives to a channel."""
    if form in (BYTE, BYTE_DUAL):
        return (value & 0xFF) << 4
    return value >> 4 & FULL if form in (LEFT, LEFT_DUAL) else value & FULL


def _shown(word: int, form: int) -> int:
    """Return how a register shows 12 bits."""
    if form in (BYTE, BYTE_DUAL):
        return word >> 4
    return word << 4 if form in (LEFT, LEFT_DUAL) else word
