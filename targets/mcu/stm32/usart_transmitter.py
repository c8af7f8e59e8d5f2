"""What a USART that sends does to the level of its line; when frames begin and end is found in C (``usart.c``)."""

from __future__ import annotations

from fractions import Fraction

from targets.mcu.serial_line import SerialFrame, edge_bits
from targets.mcu.services import OutputSignal, Watch
from targets.mcu.stm32.usart_line import News, Sending, Tell, UsartLine
from targets.mcu.timebase import Event, Timebase

__all__ = ["Transmitter"]

_ENDS = int(Tell.ENDS)  # every frame sets it: flags of an enumeration take longer than the rest


class Transmitter:
    """Puts the levels of frames on an output.

    Args:
        time: the chip's cycles and events.
        output: where the line's level goes.
        line: sends.

    Attributes:
        inverted: the output has the inverse levels.
        wants_frames: somebody is to be told of every frame; `tell_frames` after a change, as of the next.
        keeps_words: instead, words of data are kept where nobody watches the pin.
        clocked: a clock goes beside each frame, so all are told as they begin.
        bit_s: length of a bit, in seconds.
    """

    def __init__(self, time: Timebase, output: OutputSignal, line: UsartLine) -> None:
        self.inverted = False
        self.wants_frames = False
        self.keeps_words = self.clocked = False
        self.bit_s = Fraction(1)
        self._time = time
        self._output = output
        self._line = line
        self._kept = line.line
        self._edges: list[tuple[int, bool]] = []
        self._passes_over = False  # the last frame, as far as nobody has asked
        self._edge_event: Event | None = None
        line.handlers[News.END] = lambda _value, _more: self._finish_edges()
        line.handlers[News.IDLE_LEVEL] = lambda _value, _more: self.show_idle()
        self._connect()

    def _connect(self) -> None:
        self._output.refresh = self.refresh
        self._output.on_watch = self._watch_changed
        self._output.pass_over = self._pass_over

    # --- what the registers do

    def move(self, output: OutputSignal) -> None:
        """Let the level go to another output; not in mid-frame."""
        if output is self._output:
            return
        self._output.refresh = self._output.on_watch = self._output.pass_over = None
        self._output.set(None)
        self._output = output
        self._connect()
        self.tell_frames()
        self.show_idle()

    def reset(self) -> None:
        """Stop in mid-frame and forget everything."""
        self.refresh()
        self._line.stop()
        self._time.cancel(self._edge_event)
        self._edges = []
        self._output.set(None)

    def enable(self, on: bool) -> None:
        """Let the transmitter run: it begins with a preamble."""
        if on is not bool(self._kept.enabled):
            self._line.enable(on)
            self.show_idle()
            self._line.proceed()

    def show_idle(self) -> None:
        """Put the level on the line that it has between frames."""
        kept = self._kept
        if kept.sending <= Sending.PREAMBLE:
            self._output.set(not self.inverted if kept.enabled and not kept.half_duplex else None)

    def rate_changed(self, bit_s: Fraction, *, in_frame: bool) -> None:
        """The length of a bit has changed, and with it perhaps the rest of a frame.

        Level and record of the output must be up to date: `refresh` before the change.
        """
        self.bit_s = bit_s
        if in_frame:
            self._follow_edges()

    # --- frames

    def tell_frames(self) -> None:
        """Say which frames somebody has to know of as they begin and end: who listens, and how, may have changed."""
        watched = self._output.watch() is not Watch.NOBODY or bool(self._kept.half_duplex)
        seen = watched or self.clocked or not self._output.at_pin()
        frames = Tell.WORDS if self.keeps_words and not seen else Tell.FRAMES if seen or self.wants_frames else 0
        tells = Tell(self._kept.tells) & Tell.DATA
        self._kept.tells = tells | frames | (Tell.ENDS if watched or self._edges else 0)

    def begin(self) -> None:
        """Follow a frame that begins."""
        self._edges = []
        if self._passes_over:
            self._passes_over = False
            self._kept.tells |= _ENDS
        self._follow_edges()

    def frame(self) -> SerialFrame:
        """Return the frame that has begun."""
        kept = self._kept
        return SerialFrame(
            start_s=self._time.seconds(self._time.now),
            bit_s=self.bit_s,
            bits=kept.frame_bits,
            bit_count=kept.frame_count,
            stop_half_bits=kept.frame_stop,
            is_break=bool(kept.frame_is_break),
        )

    # --- the level of the line

    def refresh(self) -> None:
        """Bring level and record of the output up to the present cycle."""
        kept = self._kept
        if kept.frame_is_new:
            kept.frame_is_new = False
            kept.tells |= _ENDS
            self._edges = [(16 * bit, level) for bit, level in edge_bits(kept.frame_bits, kept.frame_count)]
        elif not self._edges:
            return
        now = self._time.now
        while self._edges and (cycle := self._line.sent_at(self._edges[0][0])) <= now:
            self._output.set_at(cycle, self._edges.pop(0)[1] is not self.inverted)

    def _pass_over(self) -> bool:
        kept = self._kept
        if not kept.frame_is_new or kept.half_duplex:
            return False
        self._passes_over = True
        kept.tells &= ~_ENDS
        return True

    def _watch_changed(self) -> None:
        self.tell_frames()
        self._follow_edges()

    def _follow_edges(self) -> None:
        if self._edge_event is not None:
            self._time.cancel(self._edge_event)
        if self._output.watch() is Watch.LIVE and (self._kept.frame_is_new or self._edges):
            self.refresh()
            if self._edges:
                self._edge_event = self._time.at(self._line.sent_at(self._edges[0][0]), self._follow_edges)

    def _finish_edges(self) -> None:
        if self._output.watch() is Watch.NOBODY:
            # All edges are past, and the last has left the line high.
            self._kept.frame_is_new, self._edges = False, []
            self._output.set(not self.inverted)
            self.tell_frames()
        else:
            self.refresh()
