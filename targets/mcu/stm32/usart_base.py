"""What every USART has, whatever its registers: a line with a transmitter and a receiver, its rate and its format."""

from __future__ import annotations

import abc
from collections.abc import Callable
from fractions import Fraction
from typing import ClassVar

from targets.mcu.registers import Peripheral
from targets.mcu.serial_line import Sampled, SerialFormat, SerialFrame
from targets.mcu.services import InputSignal, Services
from targets.mcu.stm32.usart_receiver import Receiver
from targets.mcu.stm32.usart_transmitter import Transmitter

__all__ = ["UsartBase", "listen"]

# Bits that stand at the same place in all generations: of the flags, of CR1, CR2 and CR3.
TC, TXE, LBD, CTS = 1 << 6, 1 << 7, 1 << 8, 1 << 9
RE, TE, PS, PCE = 1 << 2, 1 << 3, 1 << 9, 1 << 10
LBDL, LINEN = 1 << 5, 1 << 14
HDSEL, CTSE = 1 << 3, 1 << 9

_STOP_HALF_BITS = (2, 1, 4, 3)
"""By CR2.STOP."""
_LIN_BREAK_BITS = 13


class UsartBase(Peripheral, abc.ABC):
    """A USART without its registers.

    Args:
        name: ``USART1``.
        base: address of its first register.
        services: what the chip offers. Used: output signals NAME_TX, NAME_RTS; input signals NAME_RX, NAME_TX (half
            duplex), NAME_CTS; DMA requests NAME_TX, NAME_RX.
        irq: number of its interrupt.

    Attributes:
        STATUS: offset of the register with the flags.
        CR1, CR2, CR3: offsets of the control registers.
        on_frame: called with every frame that leaves the chip, at the cycle at which its start bit begins.
        on_format_change: called when `baud_hz` or `format` have changed.
        on_word: called with the data of every word that was read and is not muted, and bits that say what was wrong
            with it: 1 parity, 2 framing, 4 noise, 8 overrun (it was lost).
    """

    STATUS: ClassVar[int]
    CR1: ClassVar[int]
    CR2: ClassVar[int]
    CR3: ClassVar[int]

    def __init__(self, name: str, base: int, services: Services, *, irq: int) -> None:
        super().__init__(name, base, services)
        self.on_frame: Callable[[SerialFrame], None] = lambda _frame: None
        self.on_format_change: Callable[[], None] = lambda: None
        self.on_word: Callable[[int, int], None] = lambda _data, _errors: None
        self._line_tx = services.output(f"{name}_TX")
        self._line_rts = services.output(f"{name}_RTS")
        self._line_rx = services.input(f"{name}_RX")
        self._line_single = services.input(f"{name}_TX")
        self._line_cts = services.input(f"{name}_CTS")
        self._irq = services.irq(irq)
        self._dma_tx = services.dma(f"{name}_TX")
        self._dma_rx = services.dma(f"{name}_RX")
        self._levels = (False, False, False)
        self._setting: tuple[str, Fraction] | None = None
        self._format = SerialFormat()
        self._idle_armed = False
        self._tx = self._make_transmitter()
        self._rx = self._make_receiver()

    def _make_transmitter(self) -> Transmitter:
        tx = Transmitter(self.time, self._line_tx)
        tx.on_load = self._loaded
        tx.on_frame = self._sent
        tx.on_complete = self._complete
        tx.on_break_sent = self._break_sent
        tx.on_cut = self._cut
        return tx

    def _make_receiver(self) -> Receiver:
        rx = Receiver(self.time)
        rx.on_word = self._word
        rx.on_idle = self._idle
        rx.on_break = self._lin_break
        rx.idle_wanted = self._wants_idle
        return rx

    # --- for people and for what is at the other end of the line

    @property
    def baud_hz(self) -> Fraction:
        """Bits a second; 0 while the bit clock stands still."""
        cycles = self._bit_cycles()
        return self.time.hclk_hz / cycles if cycles else Fraction(0)

    @property
    def format(self) -> SerialFormat:
        """How words are framed; ``str()`` of it is like ``8N1``."""
        return self._format

    def receive(self, frame: SerialFrame) -> None:
        """Take a frame from outside, at the cycle at which its start bit begins (the first not before it)."""
        if not self._heard_at().at_pin():
            self.note("misuse", "RX", f"a frame came in, but {self._why_deaf()}")
        elif self.clocked:
            self._rx.receive(frame)

    # --- what the chip calls

    def reset(self) -> None:
        """Go to the state after reset; a frame that is being sent stays on the wire as it was announced."""
        super().reset()
        self._tx.reset()
        self._rx.reset()
        self._idle_armed = False
        self._configure()

    def before_clock_change(self) -> None:
        """Bring line and samples up to the present cycle."""
        self._tx.refresh()
        self._rx.before_change()

    def after_clock_change(self) -> None:
        """Go on at the new rate."""
        cycles = self._bit_cycles()
        if cycles:
            self._tx.set_rate(cycles, cycles / self.time.hclk_hz)
            self._rx.set_rate(cycles)
        self._run()
        self._tell_setting()

    # --- what a subclass uses

    def _take_frame(self, word_bits: int) -> None:
        """Let frames, breaks and flow control follow the control registers."""
        cr1, cr2, cr3 = self[self.CR1], self[self.CR2], self[self.CR3]
        tx, rx = self._tx, self._rx
        parity = ("O" if cr1 & PS else "E") if cr1 & PCE else "N"
        stop_half_bits = _STOP_HALF_BITS[cr2 >> 12 & 3]
        self._format = SerialFormat(data_bits=word_bits - (parity != "N"), parity=parity, stop_half_bits=stop_half_bits)
        tx.word_bits = rx.word_bits = word_bits
        tx.stop_half_bits = rx.stop_half_bits = stop_half_bits
        tx.break_bits = _LIN_BREAK_BITS if cr2 & LINEN else word_bits + 2
        rx.lin_break_bits = (11 if cr2 & LBDL else 10) if cr2 & LINEN else 0
        tx.half_duplex = bool(cr3 & HDSEL)
        tx.clear_to_send = not (cr3 & CTSE and self._line_cts.level())

    def _switch_halves(self, wanted: int) -> bool:
        """Start and stop transmitter and receiver by bits TE and RE; return whether the receiver runs."""
        if wanted and not self._bit_cycles():
            # Its clock stands still: Stop. Pins keep their levels (RM0008 section 4.3.4), nothing is sampled.
            if not self._tx.quiet:
                what = "Stop began while a frame was being sent: silicon breaks off, here it was sent to its end"
                self.note("misuse", f"{self.registers[self.STATUS].name}.TC", what)
            wanted &= ~RE
        self._rx.switch(bool(wanted & RE))
        self._tx.enable(bool(wanted & TE))
        self._tx.show_idle()
        self._tx.proceed()
        listen(self._line_cts, self._cts_changed if self[self.CR3] & CTSE else None)
        return bool(wanted & RE)

    def _half_duplex(self) -> bool:
        """Say whether sender and receiver share one line."""
        return bool(self[self.CR3] & HDSEL)

    def _loaded(self) -> None:
        self[self.STATUS] |= TXE
        self._update()

    def _complete(self) -> None:
        self[self.STATUS] |= TC
        self._update()

    def _cut(self) -> None:
        if not self[self.CR1] & TE:
            text = "TE was cleared while a frame was being sent: silicon may lose it, here it was sent to its end"
            self.note("misuse", "CR1.TE", text)

    def _cts_changed(self, level: bool) -> None:
        self[self.STATUS] |= CTS
        self._tx.clear_to_send = not level
        self._tx.proceed()
        self._update()

    def _lin_break(self) -> None:
        self[self.STATUS] |= LBD
        self._update()

    def _tell_setting(self) -> None:
        setting = (str(self._format), self.baud_hz)
        if setting != self._setting:
            self._setting = setting
            self.on_format_change()

    def _drive_lines(self, irq: bool, dma_tx: bool, dma_rx: bool) -> None:
        levels = (irq, dma_tx, dma_rx)
        if levels != self._levels:
            before, self._levels = self._levels, levels
            if irq is not before[0]:
                self._irq.set(irq)
            if dma_tx is not before[1]:
                self._dma_tx.set(dma_tx)
            if dma_rx is not before[2]:
                self._dma_rx.set(dma_rx)

    def _sent(self, frame: SerialFrame) -> None:
        if self._half_duplex():
            self._rx.receive(frame)
        if self._sends_at_pin():
            self.on_frame(frame)
        else:
            self.note("misuse", "TX", f"{self.name} sends, but {self._why_unseen()}")

    def _single_changed(self, level: bool) -> None:
        # What is sent here has come in as a frame.
        if self._tx.quiet:
            self._rx.drive(level)

    # --- what a subclass is

    @abc.abstractmethod
    def _configure(self) -> None:
        """Let everything follow the control registers."""

    @abc.abstractmethod
    def _update(self) -> None:
        """Drive interrupt, DMA requests and RTS from flags and enables."""

    @abc.abstractmethod
    def _bit_cycles(self) -> int | Fraction:
        """Return HCLK cycles of a bit; 0 while the bit clock stands still."""

    @abc.abstractmethod
    def _run(self) -> None:
        """Start and stop transmitter and receiver, and listen to the pins that matter."""

    @abc.abstractmethod
    def _heard_at(self) -> InputSignal:
        """Return the signal at which the receiver listens."""

    @abc.abstractmethod
    def _sends_at_pin(self) -> bool:
        """Say whether a pin carries what is sent."""

    @abc.abstractmethod
    def _why_deaf(self) -> str:
        """Say in words what the pin lacks at which frames come in."""

    @abc.abstractmethod
    def _why_unseen(self) -> str:
        """Say in words what the pin lacks at which frames ought to go out."""

    @abc.abstractmethod
    def _break_sent(self) -> None:
        """The stop bit of a break begins."""

    @abc.abstractmethod
    def _word(self, sampled: Sampled) -> None:
        """A word was read."""

    @abc.abstractmethod
    def _wants_idle(self) -> bool:
        """Say whether an idle line is to be told of after this word."""

    @abc.abstractmethod
    def _idle(self) -> None:
        """The line is idle."""


def listen(signal: InputSignal, callback: Callable[[bool], None] | None) -> None:
    """Have `callback` listen to a signal, or nobody; setting it has others find out anew who listens to the pin."""
    if signal.on_change != callback:
        signal.on_change = callback
