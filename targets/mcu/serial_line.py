"""Asynchronous serial frames as they stand on a wire, and how a receiver that oversamples reads them.

A frame is a waveform: it has a start, a length of one bit and levels, all exact, and knows nothing of who will read it.
A receiver with another bit time or another format reads from it what silicon would: up to 3 or 4 % of mismatch nothing
is wrong, beyond that there are noise, parity and framing errors and finally other data (RM0008 section 27.3.5).

The receiver samples 16 times a bit (RM0008 section 27.3.3). Sample k of bit n is taken n + k/16 bit times after the
falling edge of the start bit; the tolerances in RM0008 table "USART receiver's tolerance when DIV_Fraction is 0" follow
from exactly this. Of each bit the samples 8, 9 and 10 decide by majority, and noise is flagged unless they agree.

Newer ones sample 8 times a bit if told so, and then the samples 4, 5 and 6 decide; or the one in the middle alone, and
noise is never flagged (RM0410 section 34.5.5). Sample k of bit n is at n + k/8 then: that gives the tolerances of
RM0410 table "Tolerance of the USART receiver when BRR[3:0] = 0000". Choice: of a start bit the samples 1, 2, 3 stand in
for 3, 5, 7 there, for which eight samples have no place.
"""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

__all__ = [
    "LineHistory",
    "LineReceiver",
    "Received",
    "Sampled",
    "SamplingPlan",
    "SerialFormat",
    "SerialFrame",
    "StartBit",
    "Words",
    "edge_bits",
    "sampling_plan",
]


_NS_PER_S = 1_000_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class SerialFrame:
    """A start bit and what follows it.

    A frame with a wrong stop bit, or a break, is a frame with more bits, the last of them low: after `bits` the line is
    high in any case.

    Attributes:
        start_s: bench time of the falling edge of the start bit, in seconds.
        bit_s: length of a bit, in seconds.
        bits: levels of the bits after the start bit, the first in bit 0.
        bit_count: how many these are: data and parity.
        stop_half_bits: how long the sender keeps the line high before anything else, in halves of a bit.
        is_break: the sender means a break; on the wire it is a word of zeros that may be longer than others.
    """

    start_s: Fraction
    bit_s: Fraction
    bits: int
    bit_count: int
    stop_half_bits: int = 2
    is_break: bool = False

    @property
    def end_s(self) -> Fraction:
        """When the last stop bit ends and the next frame may begin."""
        start_s, bit_s = self.start_s, self.bit_s
        # One fraction made at once costs a third of three; every byte on every line asks for this.
        halves = bit_s.numerator * (2 * (1 + self.bit_count) + self.stop_half_bits)
        denominator = 2 * bit_s.denominator
        return Fraction(
            start_s.numerator * denominator + halves * start_s.denominator, start_s.denominator * denominator
        )

    @property
    def start_ns(self) -> int:
        """`start_s` in nanoseconds, rounded down."""
        return self.start_s.numerator * _NS_PER_S // self.start_s.denominator

    @property
    def end_ns(self) -> int:
        """`end_s` in nanoseconds, rounded down; no fraction is made for it."""
        start_s, bit_s = self.start_s, self.bit_s
        halves = bit_s.numerator * (2 * (1 + self.bit_count) + self.stop_half_bits)
        denominator, start_denominator = 2 * bit_s.denominator, start_s.denominator
        whole = start_s.numerator * denominator + halves * start_denominator
        return whole * _NS_PER_S // (start_denominator * denominator)

    def edge_bits(self) -> Sequence[tuple[int, bool]]:
        """Return each change of level as (bits after the start, new level); it begins with ``(0, False)``."""
        return edge_bits(self.bits, self.bit_count)

    def edges(self) -> list[tuple[Fraction, bool]]:
        """Return each change of level as (bench time in seconds, new level); it begins with the start bit."""
        return [(self.start_s + index * self.bit_s, level) for index, level in self.edge_bits()]


class Words(NamedTuple):
    """Frames on a line, one after the other, that are alike but for what they carry.

    Attributes:
        starts_ns: bench times at which their start bits begin, ascending, rounded down.
        bits: of each, the levels after the start bit, the first in bit 0.
        bit_s: length of a bit, in seconds.
        bit_count: how many bits each has, data and parity.
        stop_half_bits: how long the line is high after each at least, in halves of a bit.
        parity: what the last of these bits is; see `SerialFormat`.
    """

    starts_ns: Sequence[int]
    bits: Sequence[int]
    bit_s: Fraction
    bit_count: int
    stop_half_bits: int = 2
    parity: str = "N"

    @property
    def format(self) -> SerialFormat:
        """How they are framed."""
        data_bits = self.bit_count - (self.parity != "N")
        return SerialFormat(data_bits=data_bits, parity=self.parity, stop_half_bits=self.stop_half_bits)

    @property
    def frame_ns(self) -> int:
        """How long a frame lasts, in nanoseconds, rounded down."""
        half_bits = 2 * (1 + self.bit_count) + self.stop_half_bits
        return self.bit_s.numerator * half_bits * _NS_PER_S // (2 * self.bit_s.denominator)

    def part(self, begin: int, end: int) -> Words:
        """Return those from one to before another."""
        return self._replace(starts_ns=self.starts_ns[begin:end], bits=self.bits[begin:end])

    def frame(self, index: int) -> SerialFrame:
        """Return one of them."""
        return SerialFrame(
            start_s=Fraction(self.starts_ns[index], _NS_PER_S),
            bit_s=self.bit_s,
            bits=self.bits[index],
            bit_count=self.bit_count,
            stop_half_bits=self.stop_half_bits,
        )

    def frames(self) -> list[SerialFrame]:
        """Return all of them."""
        return [self.frame(index) for index in range(len(self.bits))]


@lru_cache(maxsize=1024)
def edge_bits(bits: int, bit_count: int) -> tuple[tuple[int, bool], ...]:
    """Return each change of level of a frame as (bits after the start, new level); it begins with ``(0, False)``."""
    edges = []
    high = True
    for index, level in enumerate([False, *(bool(bits >> n & 1) for n in range(bit_count)), True]):
        if level is not high:
            edges.append((index, level))
            high = level
    return tuple(edges)


_FORMAT = re.compile(r"([5-9])([NEO])(1\.5|0\.5|1|2)", re.IGNORECASE)


@dataclass(frozen=True, slots=True, kw_only=True)
class SerialFormat:
    """How words are framed.

    Attributes:
        data_bits: 5 to 9, without parity.
        parity: ``N`` none, ``E`` even, ``O`` odd.
        stop_half_bits: 1 to 4.
    """

    data_bits: int = 8
    parity: str = "N"
    stop_half_bits: int = 2

    @classmethod
    def parse(cls, text: str) -> SerialFormat:
        """Return the format that is written like ``8N1`` or ``7E1.5``. Raises ValueError otherwise."""
        match = _FORMAT.fullmatch(text)
        if match is None:
            raise ValueError(f"{text!r} is no serial format: write it like 8N1, 7E1 or 8O2")
        data, parity, stop = match.groups()
        return cls(data_bits=int(data), parity=parity.upper(), stop_half_bits=int(2 * float(stop)))

    def __str__(self) -> str:
        whole, half = divmod(self.stop_half_bits, 2)
        return f"{self.data_bits}{self.parity}{whole}{'.5' if half else ''}"

    @property
    def word_bits(self) -> int:
        """Bits between start and stop: data and parity."""
        return self.data_bits + (self.parity != "N")

    @property
    def frame_half_bits(self) -> int:
        """Length of a whole frame in halves of a bit."""
        return 2 * (1 + self.word_bits) + self.stop_half_bits

    def word(self, value: int) -> int:
        """Return `value`, cut to the data bits, with its parity bit as the most significant one."""
        value &= (1 << self.data_bits) - 1
        if self.parity == "N":
            return value
        odd = value.bit_count() & 1
        return value | (odd ^ (self.parity == "O")) << self.data_bits

    def value(self, word: int) -> int:
        """Return the data bits of a word."""
        return word & (1 << self.data_bits) - 1

    def parity_wrong(self, word: int) -> bool:
        """Say whether the parity bit of a word does not fit its data."""
        return self.parity != "N" and (word.bit_count() & 1) is not int(self.parity == "O")

    def frame(self, value: int, start_s: Fraction, bit_s: Fraction) -> SerialFrame:
        """Return the frame that carries `value`."""
        return SerialFrame(
            start_s=start_s,
            bit_s=bit_s,
            bits=self.word(value),
            bit_count=self.word_bits,
            stop_half_bits=self.stop_half_bits,
        )


# --- what a receiver samples


@dataclass(frozen=True, slots=True)
class StartBit:
    """What six samples of a start bit say.

    Attributes:
        valid: False if it was none: the receiver goes on waiting for a falling edge.
        noise: some sample was high.
        abort: sixteenths of a bit after the edge at which the receiver knows.
    """

    valid: bool
    noise: bool
    abort: int

    @classmethod
    def judge(cls, samples: Sequence[bool], aborts: tuple[int, int] = (7, 10)) -> StartBit:
        """Judge the samples 3, 5, 7 and 8, 9, 10: at least two of each three must be low (RM0008 section 27.3.3).

        Args:
            samples: these six.
            aborts: sixteenths of a bit after the edge at which the last of each three is taken.
        """
        first, second = sum(samples[:3]), sum(samples[3:6])
        return cls(valid=first < 2 and second < 2, noise=bool(first or second), abort=aborts[first < 2])


@dataclass(frozen=True, slots=True)
class Sampled:
    """What a receiver has read.

    Attributes:
        word: the bits between start and stop.
        noise: the samples of some bit did not agree.
        framing_error: the stop bit was low.
    """

    word: int
    noise: bool
    framing_error: bool


@dataclass(frozen=True, slots=True)
class SamplingPlan:
    """When a receiver samples, in sixteenths of a bit after the falling edge of the start bit.

    Attributes:
        word_bits: bits between start and stop.
        positions: of every sample: six of the start bit, three of each bit, those of the stop bit (none or three).
        done: when the word is complete.
        resume: edges after this may begin the next start bit.
        one_sample: the middle one of three samples decides alone, and there is no noise.
    """

    word_bits: int
    positions: tuple[int, ...]
    done: int
    resume: int
    one_sample: bool = False

    @property
    def last_sample(self) -> int:
        """Sixteenths from the beginning of a bit to the last sample in it."""
        return self.positions[5]

    def judge_start(self, samples: Sequence[bool]) -> StartBit:
        """Return what the first six samples say."""
        return StartBit.judge(samples, (self.positions[2], self.positions[5]))

    def judge(self, samples: Sequence[bool]) -> Sampled:
        """Return what the samples, one for each position, say; the start bit must be valid."""
        if self.one_sample:
            word = sum(samples[7 + 3 * bit] << bit for bit in range(self.word_bits))
            stop = samples[6 + 3 * self.word_bits :]
            return Sampled(word=word, noise=False, framing_error=bool(stop) and not stop[1])
        word = 0
        noise = any(samples[:6])
        for bit in range(self.word_bits):
            high = sum(samples[6 + 3 * bit : 9 + 3 * bit])
            word |= (high >= 2) << bit
            noise = noise or 0 < high < 3
        stop = samples[6 + 3 * self.word_bits :]
        high = sum(stop)
        return Sampled(word=word, noise=noise or 0 < high < len(stop), framing_error=bool(stop) and high < 2)


_STOP_BITS = {
    16: {1: ((), 8), 2: ((8, 9, 10), 10), 3: ((16, 17, 18), 24), 4: ((8, 9, 10), 16)},
    8: {1: ((), 8), 2: ((8, 10, 12), 12), 3: ((16, 18, 20), 24), 4: ((8, 10, 12), 16)},
}
"""Samples of the stop bit, and when the word is complete, by oversampling and halves of a stop bit (RM0008 section
27.3.3, configurable stop bits). Half a stop bit is not sampled; the end of it, and the middle of a single one, are a
choice."""
_START_SAMPLES = {16: (3, 5, 7, 8, 9, 10), 8: (2, 4, 6, 8, 10, 12)}


@lru_cache(maxsize=64)
def sampling_plan(
    word_bits: int, stop_half_bits: int, oversampling: int = 16, one_sample: bool = False
) -> SamplingPlan:
    """Return when a receiver samples.

    Args:
        word_bits: data and parity.
        stop_half_bits: 1 to 4.
        oversampling: samples in a bit, 16 or 8.
        one_sample: the middle one of three samples decides alone.
    """
    samples, done = _STOP_BITS[oversampling][stop_half_bits]
    start = _START_SAMPLES[oversampling]
    bits = (16 * bit + sample for bit in range(1, word_bits + 1) for sample in start[3:])
    stop = 16 * (word_bits + 1)
    positions = (*start, *bits, *(stop + sample for sample in samples))
    # A sender that is fast begins the next frame just before the last sample of the stop bit, which is then noisy.
    return SamplingPlan(word_bits, positions, stop + done, stop + (samples[1] if samples else done), one_sample)


# --- a line and its levels


class LineHistory:
    """The level of a line over time, from the frames on it and from whoever drives it by hand.

    Several senders at a time are wired-AND, as open-drain lines are: low wins. The line is high unless somebody has
    said otherwise.
    """

    __slots__ = ("_driven", "_frames", "_merged")

    def __init__(self) -> None:
        self._frames: list[SerialFrame] = []
        self._driven: list[tuple[Fraction, bool]] = []
        self._merged: tuple[list[Fraction], list[bool]] | None = ([], [])

    @property
    def empty(self) -> bool:
        """True if the line is known to have been high all the time, and nothing is under way."""
        return not self._frames and not self._driven

    def add(self, frame: SerialFrame) -> None:
        """Put a frame on the line."""
        self._frames.append(frame)
        self._merged = None

    def drive(self, time_s: Fraction, level: bool) -> None:
        """Let the line be driven to `level` from `time_s` on; never out of order."""
        self._driven.append((time_s, level))
        self._merged = None

    @property
    def driven_low(self) -> bool:
        """True if the line is driven low at the end of what is known, apart from frames."""
        return bool(self._driven) and not self._driven[-1][1]

    def undrive(self) -> None:
        """Forget whatever was driven apart from frames."""
        self._driven.clear()
        self._merged = None

    def clear(self) -> None:
        """Forget everything: the line is high, and has been."""
        self._frames.clear()
        self._driven.clear()
        self._merged = ([], [])

    def forget(self, before_s: Fraction) -> None:
        """Forget what ended before `before_s`, for good; who asks for earlier levels is told that the line was high."""
        self._frames = [frame for frame in self._frames if frame.end_s >= before_s]
        while self._driven and (len(self._driven) > 1 and self._driven[1][0] < before_s):
            del self._driven[0]
        if len(self._driven) == 1 and self._driven[0][1] and self._driven[0][0] < before_s:
            self._driven.clear()
        self._merged = None

    def level(self, time_s: Fraction) -> bool:
        """Return the level; at an edge, that after it."""
        times, levels = self.edges()
        index = bisect_right(times, time_s)
        return levels[index - 1] if index else True

    def next_edge(self, after_s: Fraction, level: bool) -> Fraction | None:
        """Return when the line changes to `level` next, later than `after_s`, as far as is known; or None."""
        times, levels = self.edges()
        for index in range(bisect_right(times, after_s), len(times)):
            if levels[index] is level:
                return times[index]
        return None

    def next_start(self, after_s: Fraction, sixteenth_s: Fraction) -> Fraction | None:
        """Return the next falling edge later than `after_s` before which three samples are high; or None."""
        while (edge_s := self.next_edge(after_s, level=False)) is not None:
            if all(self.level(edge_s - back * sixteenth_s) for back in (1, 2, 3)):
                return edge_s
            after_s = edge_s
        return None

    def edges(self) -> tuple[list[Fraction], list[bool]]:
        """Return when the level changes, and to what, as far as is known."""
        if self._merged is None:
            self._merged = _merge([frame.edges() for frame in self._frames] + [self._driven])
        return self._merged


def _merge(sources: Sequence[Sequence[tuple[Fraction, bool]]]) -> tuple[list[Fraction], list[bool]]:
    """Return times and levels of the edges of the AND of several waveforms, each high before its first edge."""
    changes = sorted((time_s, number, level) for number, edges in enumerate(sources) for time_s, level in edges)
    times: list[Fraction] = []
    levels: list[bool] = []
    low: set[int] = set()
    for index, (time_s, number, level) in enumerate(changes):
        (low.discard if level else low.add)(number)
        if index + 1 < len(changes) and changes[index + 1][0] == time_s:
            continue
        if (not low) is not (levels[-1] if levels else True):
            times.append(time_s)
            levels.append(not low)
    return times, levels


# --- a receiver outside of the chip


@dataclass(frozen=True, slots=True, kw_only=True)
class Received:
    """A word that a receiver outside of the chip has read.

    Attributes:
        time_s: when it was complete: in the middle of the stop bit.
        value: the data bits.
        framing_error: the stop bit was low; with all bits low this is a break.
        noise: the samples of some bit did not agree.
        parity_error: the parity bit does not fit.
    """

    time_s: Fraction
    value: int
    framing_error: bool
    noise: bool
    parity_error: bool


class LineReceiver:
    """Reads words from frames of any bit time and format, as an adapter at the other end of a line does.

    Args:
        line_format: what it expects.
        bit_s: length of a bit as it expects it, in seconds.
    """

    def __init__(self, line_format: SerialFormat, bit_s: Fraction) -> None:
        self._format = line_format
        self._sixteenth_s = bit_s / 16
        self._plan = sampling_plan(line_format.word_bits, line_format.stop_half_bits)
        self._line = LineHistory()
        self._edge_s: Fraction | None = None
        self._from_s = Fraction(-1)

    def receive(self, frame: SerialFrame) -> None:
        """Put a frame on the line; those that come later must not begin earlier."""
        self._line.add(frame)
        if self._edge_s is None:
            self._search()

    def next_s(self) -> Fraction | None:
        """Return when the word under way will be complete, or None if the line is idle."""
        return None if self._edge_s is None else self._edge_s + self._plan.done * self._sixteenth_s

    def advance(self, now_s: Fraction) -> list[Received]:
        """Return the words that are complete by `now_s`; all frames that begin by then must have been received.

        A frame that begins at the very instant of the last sample, and is received only later, leaves no noise in it.
        """
        words = []
        while self._edge_s is not None and (done_s := self._edge_s + self._plan.done * self._sixteenth_s) <= now_s:
            samples = [self._line.level(self._edge_s + at * self._sixteenth_s) for at in self._plan.positions]
            start = StartBit.judge(samples)
            if start.valid:
                words.append(self._word(done_s, self._plan.judge(samples)))
            self._from_s = self._edge_s + (self._plan.resume if start.valid else start.abort) * self._sixteenth_s
            self._search()
        return words

    def _word(self, done_s: Fraction, sampled: Sampled) -> Received:
        return Received(
            time_s=done_s,
            value=self._format.value(sampled.word),
            framing_error=sampled.framing_error,
            noise=sampled.noise,
            parity_error=self._format.parity_wrong(sampled.word),
        )

    def _search(self) -> None:
        self._edge_s = self._line.next_start(self._from_s, self._sixteenth_s)
        self._line.forget((self._from_s if self._edge_s is None else self._edge_s) - 4 * self._sixteenth_s)
