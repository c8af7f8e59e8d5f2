"""The transmitter of a USART: data register, shift register, idle preamble, break (RM0008 section 27.3.2).

A frame begins at the cycle at which its word enters the shift register; the next one begins at the cycle at which the
last stop bit ends. So frames follow each other without a gap, and one event a frame is enough.

Choices where the manual is silent or contradicts itself:

* A word written while nothing is being sent begins at the cycle of the write; on silicon the bit clock may run free.
* The preamble after TE is one bit (RM0008: "a 1 bit-time delay before the transmission starts") and one frame of ones.
* TE or UE cleared in mid-frame lets the frame end. (TE: "a 0 pulse sends a preamble after the current word"; but also
  "the current data will be lost". UE: "at the end of the current byte transfer".) What waits in the data register
  stays there.
* A change of the bit clock in mid-frame times the rest of the frame anew in the chip, while the frame on the wire stays
  as it was announced at its start.
"""

from __future__ import annotations

import enum
from collections.abc import Callable
from fractions import Fraction

from targets.mcu.serial_line import SerialFrame
from targets.mcu.services import OutputSignal, Watch
from targets.mcu.stm32.bit_clock import BitClock
from targets.mcu.timebase import Event, Timebase

__all__ = ["Transmitter"]


class _Sending(enum.Enum):
    NOTHING = enum.auto()
    PREAMBLE = enum.auto()
    BREAK = enum.auto()
    BREAK_STOP = enum.auto()
    DATA = enum.auto()


class Transmitter:
    """Sends words.

    Args:
        time: the chip's cycles and events.
        output: where the line's level goes.

    Attributes:
        word_bits: bits between start and stop, of the frames to come.
        stop_half_bits: stop bits, in halves.
        break_bits: low bits of a break, with the start bit.
        break_wanted: a break follows the present frame.
        half_duplex: the line is released while nothing is sent.
        inverted: the output has the inverse levels.
        clear_to_send: False holds back the next word.
        holding: the word in the data register, or None.
        quiet: False from the start of a frame until the line has its idle level again.
        on_load: called when the word has moved from the data register into the shift register.
        on_frame: called with what begins on the line.
        on_complete: called when the last frame of data has ended and nothing follows.
        on_break_sent: called when the stop bit of a break begins.
        on_cut: called when a frame has ended after the transmitter was disabled.
    """

    def __init__(self, time: Timebase, output: OutputSignal) -> None:
        self.word_bits = 8
        self.stop_half_bits = 2
        self.break_bits = 10
        self.break_wanted = False
        self.half_duplex = False
        self.inverted = False
        self.clear_to_send = True
        self.holding: int | None = None
        self.quiet = True
        self.on_load: Callable[[], None] = lambda: None
        self.on_frame: Callable[[SerialFrame], None] = lambda _frame: None
        self.on_complete: Callable[[], None] = lambda: None
        self.on_break_sent: Callable[[], None] = lambda: None
        self.on_cut: Callable[[], None] = lambda: None
        self._time = time
        self._output = output
        self._clock = BitClock()
        self._bit_cycles: int | Fraction = 0
        self._bit_s = Fraction(1)
        self._enabled = False
        self._sending = _Sending.NOTHING
        self._preamble_due = False
        self._data_sent = False
        self._end = 0
        self._end_event: Event | None = None
        self._frame: SerialFrame | None = None  # whose edges nobody has asked for yet
        self._edges: list[tuple[int, bool]] = []
        self._edge_event: Event | None = None
        self._connect()

    def _connect(self) -> None:
        self._output.refresh = self.refresh
        self._output.on_watch = self._follow_edges

    # --- what the registers do

    def move(self, output: OutputSignal) -> None:
        """Let the level go to another output; not in mid-frame."""
        if output is self._output:
            return
        self._output.refresh = self._output.on_watch = None
        self._output.set(None)
        self._output = output
        self._connect()
        self.show_idle()

    def reset(self) -> None:
        """Stop in mid-frame and forget everything."""
        self.refresh()
        self._time.cancel(self._end_event)
        self._time.cancel(self._edge_event)
        self.holding = self._frame = None
        self._edges = []
        self._sending = _Sending.NOTHING
        self._preamble_due = self.break_wanted = self._data_sent = self._enabled = False
        self._output.set(None)
        self.quiet = True

    def write(self, word: int) -> None:
        """Put a word into the data register; it goes on into the shift register at once if that is free."""
        self.holding = word
        self.proceed()

    def enable(self, on: bool) -> None:
        """Let the transmitter run: it begins with a preamble."""
        if on is self._enabled:
            return
        self._enabled = on
        self._preamble_due = on
        if not on and self._sending is _Sending.PREAMBLE:
            self._time.cancel(self._end_event)
            self._sending = _Sending.NOTHING
        self.show_idle()
        self.proceed()

    def proceed(self) -> None:
        """Begin with what is due, if nothing is under way."""
        if self._sending is _Sending.NOTHING and self._enabled:
            self._begin_next()

    def show_idle(self) -> None:
        """Put the level on the line that it has between frames."""
        if self._sending in (_Sending.NOTHING, _Sending.PREAMBLE):
            self._output.set(not self.inverted if self._enabled and not self.half_duplex else None)

    # --- the clock

    def set_rate(self, bit_cycles: int | Fraction, bit_s: Fraction) -> None:
        """Set the length of a bit from now on, in cycles and in seconds; the rest of a frame follows.

        Level and record of the output must be up to date: `refresh` before the change.
        """
        self._bit_cycles, self._bit_s = bit_cycles, bit_s
        if self._sending is _Sending.NOTHING or bit_cycles == self._clock.bit_cycles:
            return
        self._clock.change(self._time.now, bit_cycles)
        self._enter_end()
        self._follow_edges()

    # --- one frame after the other

    def _begin_next(self) -> None:
        if self._preamble_due:
            self._preamble_due = False
            self._begin(_Sending.PREAMBLE, 16 * (2 + self.word_bits) + 8 * self.stop_half_bits)
        elif self.break_wanted:
            self._begin(_Sending.BREAK, 16 * self.break_bits)
            self._announce(0, self.break_bits - 1, self._break_stop_half_bits, is_break=True)
        elif self.holding is not None and self.clear_to_send:
            word, self.holding = self.holding, None
            self._begin(_Sending.DATA, 16 * (1 + self.word_bits) + 8 * self.stop_half_bits)
            self.on_load()
            self._announce(word, self.word_bits, self.stop_half_bits)

    def _begin(self, sending: _Sending, sixteenths: int) -> None:
        self._sending = sending
        self._clock.start(self._time.now, self._bit_cycles)
        self._end = sixteenths
        self._enter_end()

    def _enter_end(self) -> None:
        self._time.cancel(self._end_event)
        self._end_event = self._time.at(self._clock.cycle(self._end), self._ended)

    def _announce(self, bits: int, bit_count: int, stop_half_bits: int, *, is_break: bool = False) -> None:
        frame = SerialFrame(
            start_s=self._time.seconds(self._time.now),
            bit_s=self._bit_s,
            bits=bits,
            bit_count=bit_count,
            stop_half_bits=stop_half_bits,
            is_break=is_break,
        )
        self.quiet = False
        self._frame, self._edges = frame, []
        self._follow_edges()
        self.on_frame(frame)

    def _ended(self) -> None:
        ended = self._sending
        if ended is _Sending.BREAK:
            self._sending = _Sending.BREAK_STOP
            self._end += 8 * self._break_stop_half_bits
            self._enter_end()
            self.break_wanted = False
            self.on_break_sent()
            return
        self._finish_edges()
        self._sending = _Sending.NOTHING
        self._data_sent = self._data_sent or ended is _Sending.DATA
        if not self._enabled and ended is _Sending.DATA:
            self.on_cut()
        self.proceed()
        if self._sending is _Sending.NOTHING:
            self._fell_quiet()

    def _fell_quiet(self) -> None:
        self.show_idle()
        self.quiet = True
        if self._data_sent and self.holding is None:
            self._data_sent = False
            self.on_complete()

    @property
    def _break_stop_half_bits(self) -> int:
        return max(2, self.stop_half_bits)

    # --- the level of the line

    def refresh(self) -> None:
        """Bring level and record of the output up to the present cycle."""
        if self._frame is not None:
            self._edges = [(16 * bit, level) for bit, level in self._frame.edge_bits()]
            self._frame = None
        elif not self._edges:
            return
        now = self._time.now
        while self._edges and (cycle := self._clock.cycle(self._edges[0][0])) <= now:
            self._output.set_at(cycle, self._edges.pop(0)[1] is not self.inverted)

    def _follow_edges(self) -> None:
        if self._edge_event is not None:
            self._time.cancel(self._edge_event)
        if self._output.watch() is Watch.LIVE and (self._frame or self._edges):
            self.refresh()
            if self._edges:
                self._edge_event = self._time.at(self._clock.cycle(self._edges[0][0]), self._follow_edges)

    def _finish_edges(self) -> None:
        if self._output.watch() is Watch.NOBODY:
            # All edges are past, and the last has left the line high.
            self._frame, self._edges = None, []
            self._output.set(not self.inverted)
        else:
            self.refresh()
