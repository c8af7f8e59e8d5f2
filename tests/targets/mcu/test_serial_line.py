"""Frames on a wire: formats, edges, and sampling against a receiver that looks at the line tick by tick."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from targets.mcu.serial_line import LineHistory, LineReceiver, SerialFormat, SerialFrame
from tests.each import each
from tests.share import examples

FORMATS = st.builds(
    SerialFormat,
    data_bits=st.integers(5, 9),
    parity=st.sampled_from("NEO"),
    stop_half_bits=st.sampled_from((1, 2, 3, 4)),
)


# samples of the stop bit, when the word is complete, after which a start bit may come; by halves of a stop bit
STOP_BITS = {1: ((), 8, 8), 2: ((8, 9, 10), 10, 9), 3: ((16, 17, 18), 24, 17), 4: ((8, 9, 10), 16, 9)}


class TickingReceiver:
    """The oracle: a state machine that goes through the levels tick by tick."""

    def __init__(self, line_format, ticks_per_sixteenth, levels):
        self.format = line_format
        self.unit = ticks_per_sixteenth
        self.levels = [True] * (4 * ticks_per_sixteenth) + levels
        self.start = None
        self.words = []

    def run(self):
        tick = 4 * self.unit
        while tick < len(self.levels):
            if self.start is None:
                if self.is_start(tick):
                    self.start, self.samples = tick, {}
            elif (tick - self.start) % self.unit == 0:
                tick = self.sample((tick - self.start) // self.unit, tick)
            tick += 1
        return self.words

    def is_start(self, tick):
        before = [self.levels[tick - n * self.unit] for n in (1, 2, 3)]
        return self.levels[tick - 1] and not self.levels[tick] and all(before)

    def sample(self, number, tick):
        """Take a sample; return the tick after which to look for a start bit, if that is what comes next."""
        self.samples[number] = self.levels[tick]
        tried = {7: (3, 5, 7), 10: (8, 9, 10)}.get(number)
        if tried and sum(self.samples[n] for n in tried) >= 2:
            self.start = None
            return tick
        stop = 16 * (self.format.word_bits + 1)
        samples, done, resume = STOP_BITS[self.format.stop_half_bits]
        if number < stop + done:
            return tick
        self.finish([self.samples[stop + n] for n in samples])
        self.start = None
        return tick - (done - resume) * self.unit

    def finish(self, stop):
        word, noise = 0, any(self.samples[n] for n in (3, 5, 7, 8, 9, 10))
        for bit in range(1, self.format.word_bits + 1):
            high = [self.samples[16 * bit + n] for n in (8, 9, 10)]
            word |= (sum(high) >= 2) << (bit - 1)
            noise = noise or len(set(high)) == 2
        noise = noise or len(set(stop)) == 2
        self.words.append((word, noise, bool(stop) and sum(stop) < 2))


def ticked(frames, line_format, unit, length):
    """Return what the oracle reads; frames are (start, bit, bits, bit_count) in ticks."""
    low = [0] * (length + 1)
    for start, bit, bits, count in frames:
        levels = [0, *((bits >> n) & 1 for n in range(count))]
        for index, level in enumerate(levels):
            if not level:
                for tick in range(start + index * bit, min(length, start + (index + 1) * bit)):
                    low[tick] = 1
    return TickingReceiver(line_format, unit, [not tick for tick in low]).run()


@st.composite
def traffic(draw):
    """Frames in ticks: mostly back to back, of a bit time near or far from the receiver's."""
    unit = draw(st.integers(1, 4))
    own = 16 * unit
    bit = draw(st.one_of(st.integers(max(1, own * 94 // 100), own * 106 // 100 + 1), st.integers(1, 4 * own)))
    at = draw(st.integers(1, 50))
    frames = []
    for _ in range(draw(st.integers(1, 5))):
        count = draw(st.integers(5, 12))
        bits = draw(st.integers(0, (1 << count) - 1))
        frames.append((at, bit, bits, count))
        at += bit * (1 + count) + draw(st.sampled_from((bit, 2 * bit, bit + bit // 2, 9 * own)))
    return unit, frames, at + 40 * own


@settings(max_examples=examples(300))
@given(traffic=traffic(), line_format=FORMATS)
def test_reads_what_a_receiver_sees_tick_by_tick(traffic, line_format):
    unit, frames, length = traffic
    receiver = LineReceiver(line_format, Fraction(16 * unit))
    words = []
    for start, bit, bits, count in frames:
        receiver.receive(SerialFrame(start_s=Fraction(start), bit_s=Fraction(bit), bits=bits, bit_count=count))
        words += receiver.advance(Fraction(start))
    words += receiver.advance(Fraction(length))
    expected = [
        (line_format.value(word), noise, framing, line_format.parity_wrong(word))
        for word, noise, framing in ticked(frames, line_format, unit, length)
    ]
    assert [(word.value, word.noise, word.framing_error, word.parity_error) for word in words] == expected


@each("known_first", [True, False])
def test_a_start_bit_at_the_last_sample_is_noise_if_it_is_known(known_first):
    line_format = SerialFormat.parse("8N1")
    receiver = LineReceiver(line_format, Fraction(16))
    receiver.receive(line_format.frame(0x55, Fraction(0), Fraction(16)))
    done_s = Fraction(16 * 9 + 10)
    late = line_format.frame(0x55, done_s, Fraction(16))
    if known_first:
        receiver.receive(late)
    (word,) = receiver.advance(done_s)
    if not known_first:
        receiver.receive(late)
    assert (word.value, word.noise) == (0x55, known_first)
    assert [word.value for word in receiver.advance(2 * done_s)] == [0x55]


@given(line_format=FORMATS, value=st.integers(0, 511))
def test_what_was_framed_is_read(line_format, value):
    receiver = LineReceiver(line_format, Fraction(1, 9600))
    frame = line_format.frame(value, Fraction(1, 3), Fraction(1, 9600))
    receiver.receive(frame)
    (word,) = receiver.advance(frame.end_s)
    assert word.value == value & (1 << line_format.data_bits) - 1
    assert (word.noise, word.framing_error, word.parity_error) == (False, False, False)
    assert receiver.next_s() is None


@given(line_format=FORMATS)
def test_a_format_is_written_and_read(line_format):
    assert SerialFormat.parse(str(line_format)) == line_format
    assert SerialFormat.parse(str(line_format).lower()) == line_format


@each("text", ["", "8", "8N", "8X1", "4N1", "10N1", "8N3", "8N1 "])
def test_a_wrong_format_is_refused(text):
    with pytest.raises(ValueError, match="no serial format"):
        SerialFormat.parse(text)


@each(
    ("text", "value", "word"),
    [("8N1", 0x155, 0x55), ("7E1", 0x03, 0x03), ("7E1", 0x07, 0x87), ("8O1", 0x00, 0x100), ("9N2", 0x1FF, 0x1FF)],
)
def test_the_parity_bit_is_the_most_significant_one(text, value, word):
    assert SerialFormat.parse(text).word(value) == word


def test_the_edges_of_a_frame():
    frame = SerialFormat.parse("8N1").frame(0x0F, Fraction(10), Fraction(2))
    assert frame.edges() == [(10, False), (12, True), (20, False), (28, True)]
    assert frame.end_s == 30
    assert SerialFrame(start_s=Fraction(0), bit_s=Fraction(1), bits=0, bit_count=9).edges() == [(0, False), (10, True)]


@each(
    ("word_bits", "clean_percent", "readable_percent"),
    # RM0008, "USART receiver's tolerance when DIV_Fraction is 0": noise is an error, noise does not matter
    [(8, "3.75", "4.375"), (9, "3.41", "3.97")],
)
def test_tolerates_as_much_as_the_manual_says(word_bits, clean_percent, readable_percent):
    line_format = SerialFormat(data_bits=word_bits)

    def read(fast_percent):
        bit_s = 1 - Fraction(fast_percent) / 100
        receiver = LineReceiver(line_format, Fraction(1))
        frames = [
            line_format.frame(value, index * (word_bits + 2) * bit_s, bit_s) for index, value in enumerate((0x55, 0))
        ]
        for frame in frames:
            receiver.receive(frame)
        return receiver.advance(Fraction(100))[0]

    margin = Fraction(1, 100)
    clean, readable = Fraction(clean_percent), Fraction(readable_percent)
    assert not read(clean - margin).noise
    assert read(clean + margin).noise
    assert not read(readable - margin).framing_error
    assert read(readable + margin).framing_error


def test_two_senders_at_a_time_are_anded():
    line = LineHistory()
    line.add(SerialFrame(start_s=Fraction(0), bit_s=Fraction(1), bits=0xFF, bit_count=8))
    line.add(SerialFrame(start_s=Fraction(3), bit_s=Fraction(1), bits=0xFF, bit_count=8))
    line.drive(Fraction(6), level=False)
    line.drive(Fraction(7), level=True)
    assert [line.level(Fraction(2 * n + 1, 2)) for n in range(8)] == [False, True, True, False, True, True, False, True]
    assert line.next_edge(Fraction(0), level=False) == 3
    assert line.next_edge(Fraction(3), level=False) == 6
    line.forget(Fraction(20))
    assert line.empty


def test_a_line_driven_low_stays_low_when_the_past_is_forgotten():
    line = LineHistory()
    line.drive(Fraction(1), level=False)
    line.drive(Fraction(2), level=True)
    line.drive(Fraction(3), level=False)
    line.forget(Fraction(10))
    assert not line.level(Fraction(10))
    line.undrive()
    assert line.empty
