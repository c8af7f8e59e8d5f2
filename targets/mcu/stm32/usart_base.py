"""What every USART has, whatever its registers: a line with a transmitter and a receiver, its rate and its format."""

from __future__ import annotations

import abc
from collections.abc import Callable
from fractions import Fraction
from typing import ClassVar

from targets.mcu.block import PeripheralInC
from targets.mcu.serial_line import SerialFormat, SerialFrame, Words
from targets.mcu.services import InputSignal, Services, drive_in_c
from targets.mcu.stm32.usart_expected import Expected
from targets.mcu.stm32.usart_line import Kind, News, Tell, UsartLine
from targets.mcu.stm32.usart_receiver import Receiver
from targets.mcu.stm32.usart_transmitter import Transmitter

__all__ = ["UsartBase", "listen"]

# Bits that stand at the same place in all generations: of the flags, of CR1, CR2 and CR3.
LBD, CTS = 1 << 8, 1 << 9
RE, TE, PS, PCE = 1 << 2, 1 << 3, 1 << 9, 1 << 10
LBDL, LINEN = 1 << 5, 1 << 14
HDSEL, RTSE, CTSE = 1 << 3, 1 << 8, 1 << 9

_STOP_HALF_BITS = (2, 1, 4, 3)
"""By CR2.STOP."""
_LIN_BREAK_BITS = 13


class UsartBase(PeripheralInC, abc.ABC):
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
        KIND: which registers; flags and data, and what comes of them, are C's (``usart_f1.c``, ``usart_isr.c``).
        on_frame: called with every frame that leaves the chip, at the cycle at which its start bit begins; or None.
        on_format_change: called when `baud_hz` or `format` have changed.
        on_word: called with the data of every word that was read and is not muted, and bits that say what was wrong
            with it: 1 parity, 2 framing, 4 noise, 8 overrun (it was lost); or None.
    """

    STATUS: ClassVar[int]
    CR1: ClassVar[int]
    CR2: ClassVar[int]
    CR3: ClassVar[int]
    KIND: ClassVar[Kind]

    def __init__(self, name: str, base: int, services: Services, *, irq: int) -> None:
        registers = {register.offset: register for register in self.registers_of()}
        self._line = self.in_c = UsartLine(services.time, base, registers, self.KIND)
        self._kept = self._line.line
        super().__init__(name, base, services)
        self._values = self._line.values
        for offset, register in registers.items():
            self._values[offset] = register.reset
        self.on_format_change: Callable[[], None] = lambda: None
        self._on_frame: Callable[[SerialFrame], None] | None = None
        self._on_word: Callable[[int, int], None] | None = None
        self._line_tx = services.output(f"{name}_TX")
        self._line_rts = services.output(f"{name}_RTS")
        self._line_rx = services.input(f"{name}_RX")
        self._line_single = services.input(f"{name}_TX")
        self._line_cts = services.input(f"{name}_CTS")
        self._irq = services.irq(irq)
        self._dma_tx = services.dma(f"{name}_TX")
        self._dma_rx = services.dma(f"{name}_RX")
        self._sent: list[Words] = []
        self._setting: tuple[str, Fraction] | None = None
        self._format = SerialFormat()
        self._tx = Transmitter(self.time, self._line_tx, self._line)
        self._rx = self._make_receiver()
        self._expected = Expected(self.time, self._line, self._receive)
        self._rx.expected_heard = self._expected.heard
        for signal in (self._line_rx, self._line_single):
            signal.on_reach = self._rx.look_again
        handlers = self._line.handlers
        handlers[News.FRAME] = lambda _value, _more: self._frame_begins()
        handlers[News.CUT] = lambda _value, _more: self._cut()
        handlers[News.DATA] = self._data
        handlers[News.RTS] = lambda full, _more: self._line_rts.set(bool(full) or not self._rx.running)
        handlers[News.DMA_TX] = lambda level, _more: self._dma_tx.set(bool(level))
        handlers[News.DMA_RX] = lambda level, _more: self._dma_rx.set(bool(level))
        handlers[News.IRQ] = lambda level, _more: self._irq.set(bool(level))
        core = drive_in_c([self._irq])
        if core is not None:
            self._line.interrupts(core, irq)
        to_send, received = self._dma_tx.in_c, self._dma_rx.in_c
        if to_send is not None and received is not None:
            self._line.transfers(to_send.controller, to_send.number, received.number)

    def _make_receiver(self) -> Receiver:
        rx = Receiver(self.time, self._line)
        rx.on_word = lambda word: self._line.take_word(word.word, word.noise, word.framing_error)
        rx.on_break = self._lin_break
        rx.idle_wanted = self._line.wants_idle
        return rx

    @property
    def on_frame(self) -> Callable[[SerialFrame], None] | None:
        """See the class."""
        return self._on_frame

    @on_frame.setter
    def on_frame(self, listener: Callable[[SerialFrame], None] | None) -> None:
        self._on_frame = listener
        self._tx.wants_frames = listener is not None
        self._tx.tell_frames()

    @property
    def on_word(self) -> Callable[[int, int], None] | None:
        """See the class."""
        return self._on_word

    @on_word.setter
    def on_word(self, listener: Callable[[int, int], None] | None) -> None:
        self._on_word = listener
        self._kept.tells = Tell(self._kept.tells) & ~Tell.DATA | (Tell.DATA if listener else 0)

    @property
    def keeps_words(self) -> bool:
        """Whether words that are sent are kept for `take_words`, as far as nobody has to know of them at once.

        `on_frame` is then called with the other frames alone: breaks, frames to a pin that somebody watches.
        """
        return self._tx.keeps_words

    @keeps_words.setter
    def keeps_words(self, keeps: bool) -> None:
        self._take_kept()
        self._tx.keeps_words = keeps
        self._tx.tell_frames()

    def take_words(self) -> list[Words]:
        """Return the words that were sent and kept since this was called last."""
        self._take_kept()
        taken, self._sent = self._sent, []
        return taken

    def _take_kept(self) -> None:
        """Take over what C has kept: cycles are those of the present clock, and bits those of the present format."""
        if not self._kept.kept:
            return
        ns, both = self.time.ns, self._line.take_kept()
        starts_ns, kept = [ns(cycle) for cycle in both[::2]], self._kept
        form = self._tx.bit_s, kept.word_bits, kept.stop_half_bits, self._format.parity
        self._sent.append(Words(starts_ns, both[1::2].tolist(), *form))

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
        self._receive(frame)

    def expect(self, words: Words) -> None:
        """Take frames from outside as each begins, behind those that are expected already; the past is now.

        Raises:
            MemoryError: there is no memory left.
        """
        self._expected.add(words)

    @property
    def expected(self) -> int:
        """How many of these have not begun yet."""
        return self._expected.count

    def expect_only(self, count: int) -> None:
        """Expect no more than the next so many."""
        self._expected.keep(count)

    def _receive(self, frame: SerialFrame) -> bool:
        """Take a frame that begins now; return whether C hears it."""
        if not self._heard_at().at_pin():
            self.note("misuse", "RX", f"a frame came in, but {self._why_deaf()}")
            return False
        return self.clocked and self._rx.receive(frame)

    # --- what the chip calls

    def reset(self) -> None:
        """Go to the state after reset; a frame that is being sent stays on the wire as it was announced."""
        super().reset()
        self._tx.reset()
        self._rx.reset()
        self._kept.idle_armed = self._kept.received = self._kept.seen = 0
        self._configure()

    def before_clock_change(self) -> None:
        """Bring line and samples up to the present cycle."""
        self._take_kept()
        self._expected.before_clock_change()
        self._tx.refresh()
        self._rx.before_change()

    def after_clock_change(self) -> None:
        """Go on at the new rate."""
        cycles = self._bit_cycles()
        if cycles:
            in_frame = self._line.set_rate(cycles)
            self._tx.rate_changed(cycles / self.time.hclk_hz, in_frame=in_frame)
            self._rx.set_rate(cycles)
        self._expected.after_clock_change()
        self._run()
        self._tell_setting()

    # --- what a subclass uses

    def _take_frame(self, word_bits: int) -> None:
        """Let frames, breaks and flow control follow the control registers."""
        self._take_kept()
        self._rx.look_again()
        cr1, cr2, cr3 = self[self.CR1], self[self.CR2], self[self.CR3]
        kept, rx = self._kept, self._rx
        parity = ("O" if cr1 & PS else "E") if cr1 & PCE else "N"
        stop_half_bits = _STOP_HALF_BITS[cr2 >> 12 & 3]
        self._format = SerialFormat(data_bits=word_bits - (parity != "N"), parity=parity, stop_half_bits=stop_half_bits)
        self._line.frame(self._format)
        rx.word_bits, rx.stop_half_bits = word_bits, stop_half_bits
        kept.break_bits = _LIN_BREAK_BITS if cr2 & LINEN else word_bits + 2
        rx.lin_break_bits = (11 if cr2 & LBDL else 10) if cr2 & LINEN else 0
        kept.half_duplex = bool(cr3 & HDSEL)
        kept.clear_to_send = not (cr3 & CTSE and self._line_cts.level())
        self._tx.tell_frames()

    def _switch_halves(self, wanted: int) -> bool:
        """Start and stop transmitter and receiver by bits TE and RE; return whether the receiver runs."""
        if wanted and not self._bit_cycles():
            # Its clock stands still: Stop. Pins keep their levels (RM0008 section 4.3.4), nothing is sampled.
            if not self._kept.quiet:
                what = "Stop began while a frame was being sent: silicon breaks off, here it was sent to its end"
                self.note("misuse", f"{self.registers[self.STATUS].name}.TC", what)
            wanted &= ~RE
        self._rx.switch(bool(wanted & RE))
        self._tx.enable(bool(wanted & TE))
        self._tx.show_idle()
        self._line.proceed()
        listen(self._line_cts, self._cts_changed if self[self.CR3] & CTSE else None)
        return bool(wanted & RE)

    def _half_duplex(self) -> bool:
        """Say whether sender and receiver share one line."""
        return bool(self[self.CR3] & HDSEL)

    def _cut(self) -> None:
        if not self[self.CR1] & TE:
            text = "TE was cleared while a frame was being sent: silicon may lose it, here it was sent to its end"
            self.note("misuse", "CR1.TE", text)

    def _cts_changed(self, level: bool) -> None:
        self[self.STATUS] |= CTS
        self._kept.clear_to_send = not level
        self._line.proceed()
        self._update()

    def _lin_break(self) -> None:
        self[self.STATUS] |= LBD
        self._update()

    def _tell_setting(self) -> None:
        setting = (str(self._format), self.baud_hz)
        if setting != self._setting:
            self._setting = setting
            self.on_format_change()

    def _frame_begins(self) -> None:
        self._tx.begin()
        if self._on_frame is None and not self._half_duplex() and self._sends_at_pin():
            return
        frame = self._tx.frame()
        if self._half_duplex():
            self._rx.receive(frame)
        if not self._sends_at_pin():
            self.note("misuse", "TX", f"{self.name} sends, but {self._why_unseen()}")
        elif self._on_frame is not None:
            self._on_frame(frame)

    def _single_changed(self, level: bool) -> None:
        # What is sent here has come in as a frame.
        if self._kept.quiet:
            self._rx.drive(level)

    def _data(self, data: int, errors: int) -> None:
        if self._on_word is not None:
            self._on_word(data, errors)

    def _update(self) -> None:
        """Drive interrupt, DMA requests and RTS from flags and enables."""
        if not self[self.CR3] & RTSE:
            self._line_rts.set(None)
        self._line.update()

    # --- what a subclass is

    @abc.abstractmethod
    def _configure(self) -> None:
        """Let everything follow the control registers."""

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


def listen(signal: InputSignal, callback: Callable[[bool], None] | None) -> None:
    """Have `callback` listen to a signal, or nobody; setting it has others find out anew who listens to the pin."""
    if signal.on_change != callback:
        signal.on_change = callback
