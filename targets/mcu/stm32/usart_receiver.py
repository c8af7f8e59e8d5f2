"""The receiver of a USART: start bit, oversampling, idle line, timeout, LIN break (RM0008 section 27.3.3).

A word is read when it is complete, from all that is known of the line by then; so a word costs one event, and frames
may overlap, come at any rate or begin before the receiver was switched on. A frame that comes alone, and every sample
lies within the bit that it is meant for, is left to C (``usart.c``), unless something disturbs it before its end.

Choices where the manual is silent:

* The clock of the samples begins with the falling edge of the start bit; samples are rounded up to whole cycles.
* The word is complete at the last sample of the stop bit; with other than one stop bit, as the manual says.
* The line is idle one frame after the end of the last stop bit, or after its rising edge if it was low then; a timeout
  begins to count at the same time. Its length is taken at the end of the word.
* A LIN break is complete at the last sample of the first high bit after it.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from fractions import Fraction

from targets.mcu.serial_line import LineHistory, Sampled, SamplingPlan, SerialFrame, sampling_plan
from targets.mcu.stm32.bit_clock import BitClock
from targets.mcu.stm32.quiet_line import QuietLine
from targets.mcu.stm32.usart_line import UsartLine
from targets.mcu.timebase import Event, Timebase

__all__ = ["Receiver"]


class Receiver:
    """Reads words.

    Args:
        time: the chip's cycles and events.
        line: reads frames that nothing disturbs, and waits for an idle line.

    Attributes:
        word_bits: bits between start and stop, of the words to come.
        stop_half_bits: stop bits, in halves.
        oversampling: samples in a bit, 16 or 8.
        one_sample: one sample decides a bit, and there is no noise.
        lin_break_bits: low bits, with the start bit, that make a LIN break; 0 for none.
        timeout_bits: after so many bits without a start bit there is a timeout; None for none.
        running: False while it is switched off; it still keeps what is on the line.
        on_word: called with every word that was sampled, when it is complete.
        on_timeout: called when the line was high for `timeout_bits` after a word.
        on_break: called when a LIN break was detected.
        idle_wanted: asked after every word.
        expected_heard: returns the frame that C has heard last of those that it was told to expect.
    """

    def __init__(self, time: Timebase, line: UsartLine) -> None:
        self.word_bits = 8
        self.stop_half_bits = 2
        self.oversampling = 16
        self.one_sample = False
        self.lin_break_bits = 0
        self.timeout_bits: int | None = None
        self.running = False
        self.on_word: Callable[[Sampled], None] = lambda _sampled: None
        self.on_timeout: Callable[[], None] = lambda: None
        self.on_break: Callable[[], None] = lambda: None
        self.idle_wanted: Callable[[], bool] = lambda: False
        self.expected_heard: Callable[[], SerialFrame | None] = lambda: None
        self._time = time
        self._undisturbed = line
        self._heard: SerialFrame | None = None  # by C, the last of them
        self._line = LineHistory()
        self._bit_cycles: int | Fraction = 16
        self._hears_from_s = Fraction(0)
        # the word under way
        self._edge_s: Fraction | None = None
        self._clock = BitClock()
        self._plan: SamplingPlan = sampling_plan(8, 2)
        self._taken: list[bool] = []
        self._done_event: Event | None = None
        # what comes after it
        self._word_end = 0
        self._timeout = QuietLine(time, self._timeout_over)
        self._timeout_due = False
        self._break_event: Event | None = None
        self._low_since_s: Fraction | None = None
        # the verdict of `_takes_as_sent`, for a bit time that is mostly the same
        self._checked: tuple[Fraction, int | Fraction, SamplingPlan] | None = None
        self._fits = False

    # --- what the registers do

    def reset(self) -> None:
        """Switch off and forget everything."""
        self.switch(False)
        self._line.clear()

    def switch(self, on: bool) -> None:
        """Begin to listen, or lose what is coming in."""
        if on is self.running:
            return
        self.running = on
        self.look_again()
        self._undisturbed.line.listening = on
        if on:
            self._hears_from_s = self._now_s()
            self._search()
        else:
            self._time.cancel(self._done_event)
            self._undisturbed.unhear()
            self._undisturbed.forget_quiet()
            self._timeout.stop()
            self._time.cancel(self._break_event)
            self._edge_s = self._low_since_s = None
            self._timeout_due = False
            self._line.undrive()

    @property
    def busy(self) -> bool:
        """True from the edge of a start bit until the word is complete."""
        heard = self._undisturbed.line
        return bool(heard.hears) or (self._edge_s is not None and self._clock.cycle(0) <= self._time.now)

    def look_again(self) -> None:
        """Look at the next frame that is expected before C hears it: something has changed."""
        self._undisturbed.line.plain = False

    # --- the clock

    def before_change(self) -> None:
        """Take the samples up to the present cycle: the length of a bit or of a cycle is about to change."""
        self._take_over()
        if self._edge_s is not None:
            self._take(self._time.now)

    def set_rate(self, bit_cycles: int | Fraction) -> None:
        """Set the length of a bit from now on; `before_change` comes first, also if just HCLK changes.

        The wait for an idle line is C's.
        """
        now = self._time.now
        self._bit_cycles = bit_cycles
        self._checked = None
        self.look_again()
        self._timeout.set_rate(bit_cycles)
        if self._edge_s is None:
            return
        if self._clock.cycle(0) > now:
            self._hears_from_s = self._now_s()
            self._abandon()
            self._search()
        else:
            self._clock.change(now, bit_cycles)
            self._enter_done()

    # --- what comes in

    def receive(self, frame: SerialFrame) -> bool:
        """Put a frame on the line, at the cycle at which its start bit begins, or later, but before its stop bit.

        Returns:
            Whether C hears it.
        """
        if self._line.driven_low:
            # It begins with a falling edge, so the line was high: the pin floats, which reads as low.
            self._line.undrive()
        if self._comes_alone() and self._takes_as_sent(frame):
            self._heard = frame
            self._plan = self._next_plan()
            self._undisturbed.line.read_at = self._plan.done
            self._undisturbed.hear(min(self._time.now, self._time.cycle_at(frame.start_s)), frame.bits)
            return True
        self._take_over()
        self.look_again()
        self._line.add(frame)
        if self.running:
            self._search_anew()
        else:
            self._line.forget(self._now_s())
        return False

    def drive(self, level: bool) -> None:
        """Let the line have `level` from the present cycle on, apart from frames."""
        self._take_over()
        self.look_again()
        self._line.drive(self._now_s(), level)
        if not self.running:
            self._line.forget(self._now_s())
            return
        if level and self._low_since_s is not None:
            self._check_break(self._low_since_s)
        self._search_anew()
        if level and self._edge_s is None:
            self._schedule_idle()

    def _search_anew(self) -> None:
        """Something was added to the line from the present cycle on."""
        if self._edge_s is not None and self._clock.cycle(0) > self._time.now:
            self._abandon()
        if self._edge_s is None:
            self._search()

    # --- a word

    def _comes_alone(self) -> bool:
        """Say whether nothing is known of the line but that it is high, and nobody waits for more than an idle line."""
        return (
            self.running
            and self._edge_s is None
            and not self._undisturbed.line.hears
            and self._line.empty
            and not self.lin_break_bits
            and self.timeout_bits is None
        )

    def _take_over(self) -> None:
        """Something disturbs the frame that C reads, if it does: sample it."""
        if not self._undisturbed.line.hears:
            return
        self._undisturbed.unhear()
        heard = self.expected_heard() if self._undisturbed.line.expected else self._heard
        assert heard is not None
        self._line.add(heard)
        self._start(heard.start_s, self._undisturbed.line.heard_from)

    def _takes_as_sent(self, frame: SerialFrame) -> bool:
        plan = self._next_plan()
        if frame.bit_count != plan.word_bits:
            return False
        if self._checked != (frame.bit_s, self._bit_cycles, plan):
            self._checked = (frame.bit_s, self._bit_cycles, plan)
            self._fits = self._samples_fit(frame.bit_s, plan.last_sample)
        return self._fits

    def _next_plan(self) -> SamplingPlan:
        return sampling_plan(self.word_bits, self.stop_half_bits, self.oversampling, self.one_sample)

    def _samples_fit(self, bit_s: Fraction, last_sample: int) -> bool:
        """Say whether all samples lie in their bits, with a cycle to spare for rounding at either end."""
        sent, own, last = bit_s * self._time.hclk_hz, self._bit_cycles, self.word_bits
        stop = last + 1
        not_early = stop * own + Fraction(own, 2) >= stop * sent
        not_late = all(bit * own + Fraction(last_sample * own, 16) + 2 <= (bit + 1) * sent for bit in (0, last))
        return not_early and not_late

    def _search(self) -> None:
        """Look for a start bit in what is known of the line."""
        edge_s = self._line.next_start(self._hears_from_s, self._sixteenth_s() * 16 / self.oversampling)
        if edge_s is not None:
            self._line.forget(edge_s - 8 * self._sixteenth_s())
            self._begin(edge_s, self._time.cycle_at(edge_s))
        elif self._line.level(self._now_s()) and self._line.next_edge(self._now_s(), level=False) is None:
            self._line.clear()

    def _begin(self, edge_s: Fraction, edge_cycle: int) -> None:
        self._plan = self._next_plan()
        self._undisturbed.break_quiet(edge_cycle)
        self._timeout.broken_at(edge_cycle)
        self._start(edge_s, edge_cycle)

    def _start(self, edge_s: Fraction, edge_cycle: int) -> None:
        self._edge_s = edge_s
        self._clock.start(edge_cycle, self._bit_cycles)
        self._taken = []
        self._enter_done()

    def _abandon(self) -> None:
        self._time.cancel(self._done_event)
        self._edge_s = None

    def _enter_done(self) -> None:
        self._time.cancel(self._done_event)
        self._done_event = self._time.at(self._clock.cycle(self._plan.done), self._done)

    def _take(self, until_cycle: int) -> None:
        times, levels = self._line.edges()
        # At a cycle an edge has passed if the first cycle not before the edge is this one or an earlier one.
        edges = [self._time.cycle_at(time_s) for time_s in times]
        for position in self._plan.positions[len(self._taken) :]:
            cycle = self._clock.cycle(position)
            if cycle > until_cycle:
                return
            index = bisect_right(edges, cycle)
            self._taken.append(levels[index - 1] if index else True)

    def _done(self) -> None:
        edge_s = self._edge_s
        assert edge_s is not None
        self._edge_s = None
        self._word_end = self._clock.cycle(self._frame_sixteenths())
        self._take(self._time.now)
        start = self._plan.judge_start(self._taken)
        self._hears_from_s = self._time.seconds(self._clock.cycle(self._plan.resume if start.valid else start.abort))
        if start.valid:
            sampled = self._plan.judge(self._taken)
            self._tell_word(sampled)
            self._look_for_break(edge_s, sampled)
        else:
            self._word_end = self._clock.cycle(start.abort)
        self._search()
        self._schedule_idle()

    def _tell_word(self, sampled: Sampled) -> None:
        self._timeout_due = self.timeout_bits is not None
        self.on_word(sampled)

    # --- idle line and timeout

    def _schedule_idle(self) -> None:
        """After a word: have the line become idle, unless the next word comes first; so for the timeout."""
        idle_wanted = self.running and self.idle_wanted()
        if not idle_wanted and not self._timeout_due:
            return
        begin = self._high_from()
        if begin is None:
            return
        begin = max(begin, self._word_end)
        if idle_wanted:
            self._undisturbed.await_quiet(begin)
        if self._timeout_due and self.timeout_bits is not None:
            self._timeout_due = False
            self._timeout.start(begin, 16 * self.timeout_bits, self._bit_cycles)
        if self._edge_s is not None:
            self._undisturbed.break_quiet(self._clock.cycle(0))
            self._timeout.broken_at(self._clock.cycle(0))

    def _timeout_over(self) -> None:
        self.on_timeout()

    def _frame_sixteenths(self) -> int:
        return 16 * (1 + self.word_bits) + 8 * self.stop_half_bits

    def _high_from(self) -> int | None:
        """Return the first cycle from the present one on at which the line is high, if that is known."""
        if self._line.empty or self._line.level(now_s := self._now_s()):
            return self._time.now
        rise_s = self._line.next_edge(now_s, level=True)
        return None if rise_s is None else self._time.cycle_at(rise_s)

    # --- LIN break

    def _look_for_break(self, edge_s: Fraction, sampled: Sampled) -> None:
        self._low_since_s = None
        if not self.lin_break_bits or sampled.word & (1 << min(self.word_bits, self.lin_break_bits - 1)) - 1:
            return
        if sampled.framing_error:
            self._low_since_s = edge_s
            self._check_break(edge_s)
        elif self.word_bits + 1 >= self.lin_break_bits:
            self.on_break()

    def _check_break(self, edge_s: Fraction) -> None:
        """The line has been low since `edge_s`, over a whole frame; see when it goes high, if that is known."""
        rise_s = self._line.next_edge(self._hears_from_s, level=True)
        if rise_s is None:
            return
        self._low_since_s = None
        sixteenth_s = self._sixteenth_s()
        # Two of the samples 8, 9 and 10 must be high.
        high_bit = -int((9 - (rise_s - edge_s) / sixteenth_s) // 16)
        if high_bit >= self.lin_break_bits:
            self._break_event = self._time.at_time(edge_s + (16 * high_bit + 10) * sixteenth_s, self.on_break)

    # --- times

    def _now_s(self) -> Fraction:
        return self._time.seconds(self._time.now)

    def _sixteenth_s(self) -> Fraction:
        return self._bit_cycles / (16 * self._time.hclk_hz)
