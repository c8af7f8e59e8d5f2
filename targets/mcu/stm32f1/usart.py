"""USART1 to USART3, UART4 and UART5: what their control registers set up (RM0008 section 27).

Flags, data and requests: ``usart_f1.c``.

Choices where the manual is silent, besides those of the transmitter and the receiver:

* In single-wire half-duplex mode the receiver hears what is sent, unless RE is off. Meanwhile it hears others as far as
  they come in as frames, but not what they do to the level of the pin.
* A BRR below 16 stops the bit clock.
* In synchronous mode (`usart_clock`) idle lines and errors of frames are not looked for. With SCEN there is none.
* Bits that UART4 and UART5 lack (flow control, synchronous clock, smartcard mode, stop bits of a half, DMA of UART5)
  read 0.
"""

from __future__ import annotations

from dataclasses import replace
from typing import ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import InputSignal, Services
from targets.mcu.stm32.usart_base import UsartBase, listen
from targets.mcu.stm32.usart_clock import CLKEN, CPHA, CPOL, LBCL, ClockPin
from targets.mcu.stm32.usart_line import Kind

__all__ = ["Uart4", "Uart5", "Usart", "ValueLineUart", "ValueLineUsart"]

SR, DR, BRR, CR1, CR2, CR3, GTPR = range(0, 0x1C, 4)

RXNE, TC, LBD, CTS = 1 << 5, 1 << 6, 1 << 8, 1 << 9

SBK, RE, TE, M, UE = 1 << 0, 1 << 2, 1 << 3, 1 << 12, 1 << 13

IREN, HDSEL, SCEN, RTSE = 1 << 1, 1 << 3, 1 << 5, 1 << 8
LINEN = 1 << 14  # of CR2
OVER8, ONEBIT = 1 << 15, 1 << 11  # of the value line: of CR1, of CR3
_LEAST_BRR = 16

_PINS = {
    "USART1": ("PA9 (or PB6)", "PA10 (or PB7)"),
    "USART2": ("PA2 (or PD5)", "PA3 (or PD6)"),
    "USART3": ("PB10 (or PC10, PD8)", "PB11 (or PC11, PD9)"),
    "UART4": ("PC10", "PC11"),
    "UART5": ("PC12", "PD2"),
}


class Usart(UsartBase):
    """A USART; see `UsartBase`.

    Args:
        name: ``USART1``.
        base: address of SR.
        services: what the chip offers.
        bus: whose clock it runs on, ``APB1`` or ``APB2``.
        irq: number of its interrupt.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register("SR", SR, 0xC0, CTS | LBD | TC | RXNE),
        Register("DR", DR, 0, 0x1FF),
        Register("BRR", BRR, 0, 0xFFFF),
        Register("CR1", CR1, 0, 0x3FFF),
        Register("CR2", CR2, 0, 0x7F6F),
        Register(
            "CR3",
            CR3,
            0,
            0x7FF,
            IREN | SCEN,
            fidelity=Fidelity.PARTLY,
            note="IrDA and smartcard mode are not modelled; frames are those of asynchronous mode, without a clock",
        ),
        Register("GTPR", GTPR, 0, 0xFFFF, fidelity=Fidelity.PARTLY, note="is remembered without effect"),
    )

    STATUS, CR1, CR2, CR3 = SR, CR1, CR2, CR3
    KIND = Kind.F1

    def __init__(self, name: str, base: int, services: Services, *, bus: str, irq: int) -> None:
        super().__init__(name, base, services, irq=irq)
        self._bus = bus
        self._ck = ClockPin(
            self.time,
            services.output(f"{name}_CK"),
            self._line_rx,
            self._line,
            lambda word: self._line.take_word(word, False, False),
        )

    # --- registers that C leaves to Python

    def write_BRR(self, value: int) -> None:
        """Set the bit clock; a frame under way goes on at the new rate."""
        self.before_clock_change()
        self[BRR] = value
        self.after_clock_change()

    def write_CR1(self, value: int) -> None:
        """Enable, disable, frame; ask for a break, a preamble, mute mode."""
        self._set_up(CR1, value)

    def write_CR2(self, value: int) -> None:
        """Set stop bits, LIN mode, the synchronous clock and the address in mute mode."""
        if (value ^ self[CR2]) & (LBCL | CPHA | CPOL) and self[CR1] & TE:
            self.note("misuse", "CR2", "LBCL, CPHA and CPOL may be changed only while TE is 0")
        self._set_up(CR2, value)

    def write_CR3(self, value: int) -> None:
        """Set DMA requests, flow control and half-duplex mode."""
        self._set_up(CR3, value)

    def _set_up(self, offset: int, value: int) -> None:
        changes = value != self[offset]
        self[offset] = value
        if changes:
            self._configure()

    def _configure(self) -> None:
        """Let everything follow the control registers."""
        self._take_frame(9 if self[CR1] & M else 8)
        self._kept.break_wanted = bool(self[CR1] & SBK)
        self._run()
        self._update()
        self._tell_setting()

    def _run(self) -> None:
        """Start and stop transmitter and receiver, and listen to the pins that matter."""
        cr1, cr3 = self[CR1], self[CR3]
        wanted = cr1 & (TE | RE) if cr1 & UE else 0
        if wanted and not self._divider():
            what = f"0x{self[BRR]:X} is no baud rate (16 is the least): {self.name} does nothing"
            self.note("misuse", "BRR", what)
            wanted = 0
        clocked = bool(self[CR2] & CLKEN) and not cr3 & SCEN
        if clocked and wanted and (self[CR2] & LINEN or cr3 & (HDSEL | IREN)):
            self.note("misuse", "CR2.CLKEN", "LINEN, HDSEL and IREN must be clear in synchronous mode")
        self._samples = clocked and bool(wanted & RE)
        self._ck.set(self[CR2] if clocked and wanted & TE else 0)
        self._tx.clocked = clocked
        hears = self._switch_halves(wanted & ~RE if clocked else wanted)
        self._tx.tell_frames()
        listen(self._line_rx, self._rx.drive if hears and not cr3 & HDSEL else None)
        listen(self._line_single, self._single_changed if hears and cr3 & HDSEL else None)

    def before_clock_change(self) -> None:
        """Bring lines and samples up to the present cycle."""
        super().before_clock_change()
        self._ck.refresh()

    def after_clock_change(self) -> None:
        """Go on at the new rate."""
        super().after_clock_change()
        self._ck.rate_changed()

    def _frame_begins(self) -> None:
        super()._frame_begins()
        if not self._kept.frame_is_break:
            self._ck.begin(self._rx.word_bits, receives=self._samples)

    def _divider(self) -> int:
        """Return ticks of the bus in a bit; 0 if BRR is no rate."""
        return self[BRR] if self[BRR] >= _LEAST_BRR else 0

    def _bit_cycles(self) -> int:
        return self._divider() * self.services.clocks.pclk(self._bus)

    def _heard_at(self) -> InputSignal:
        return self._line_single if self._half_duplex() else self._line_rx

    def _sends_at_pin(self) -> bool:
        return self._line_tx.at_pin()

    def _why_deaf(self) -> str:
        pin = _PINS.get(self.name, ("its pin", "its pin"))[0 if self._half_duplex() else 1]
        return f"{pin} is not configured to let {self.name} see it"

    def _why_unseen(self) -> str:
        return f"{_PINS.get(self.name, ('its pin',))[0]} is not an alternate-function output"


def _without(cr3: int) -> tuple[Register, ...]:
    """Return the registers of a UART, with those bits of CR3 (sections 27.2, 27.6)."""
    writable = {"SR": LBD | TC | RXNE, "CR2": 0x606F, "CR3": cr3, "GTPR": 0xFF}
    remarks = {"CR3": "IrDA is not modelled; frames are those of asynchronous mode"}
    return tuple(
        replace(
            register,
            writable=writable.get(register.name, register.writable),
            ignored=register.ignored & writable.get(register.name, register.ignored),
            note=remarks.get(register.name, register.note),
        )
        for register in Usart.REGISTERS
    )


def _of_value_line(register: Register) -> Register:
    more = {"CR1": OVER8, "CR3": ONEBIT}.get(register.name, 0)
    return replace(register, writable=register.writable | more)


class ValueLineUsart(Usart):
    """A USART of the STM32F100 (RM0041 section 23), which may sample a bit 8 times, or once."""

    REGISTERS = tuple(_of_value_line(register) for register in Usart.REGISTERS)

    def write_BRR(self, value: int) -> None:
        """As of every USART; with OVER8 the lowest four bits are three."""
        super().write_BRR(value)
        self._check_fraction()

    def write_CR1(self, value: int) -> None:
        """As of every USART, and choose how often a bit is sampled, on which its length depends."""
        if self._wants_16():
            value &= ~OVER8
        if not (value ^ self[CR1]) & OVER8:
            super().write_CR1(value)
            return
        self.before_clock_change()
        super().write_CR1(value)
        self.after_clock_change()
        self._check_fraction()

    def write_CR2(self, value: int) -> None:
        """As of every USART; LIN wants 16 samples."""
        super().write_CR2(value)
        self.write_CR1(self[CR1])

    def write_CR3(self, value: int) -> None:
        """As of every USART; IrDA and smartcards want 16 samples."""
        super().write_CR3(value)
        self.write_CR1(self[CR1])

    def _wants_16(self) -> bool:
        """Say whether hardware forces OVER8 to 0 (RM0041 section 23.3.3, from memory)."""
        return bool(self[CR2] & LINEN or self[CR3] & (IREN | SCEN))

    def _check_fraction(self) -> None:
        if self[CR1] & OVER8 and self[BRR] & 0x8:
            self.note("misuse", "BRR", "bit 3 must be kept clear with OVER8; it is not looked at")

    def _configure(self) -> None:
        self._rx.oversampling = 8 if self[CR1] & OVER8 else 16
        self._rx.one_sample = bool(self[CR3] & ONEBIT)
        super()._configure()

    def _divider(self) -> int:
        brr = super()._divider()
        return (brr >> 4) * 8 + (brr & 7) if self[CR1] & OVER8 else brr


class Uart4(Usart):
    """UART4, which has no flow control, no synchronous clock and no smartcard mode."""

    REGISTERS = _without(0x00CF)


class Uart5(Usart):
    """UART5, which asks for no DMA besides."""

    REGISTERS = _without(0x000F)


class ValueLineUart(ValueLineUsart):
    """UART4 and UART5 of the STM32F100, which both ask for DMA."""

    REGISTERS = tuple(_of_value_line(register) for register in Uart4.REGISTERS)
