"""The far end of the line of an emulated USART, as a port of the bench.

What is written here stands on the USART's RX line frame by frame, at the rate of this end; what the USART sends is read
as a receiver at this end would read it. An end without a rate of its own follows that of the USART, and its format too.

In real time, where nobody here answers at once, bytes that end within `REAL_TIME_GROUP_NS` are reported together, and
words come from the chip when a run of it ends. Bytes go to the chip by the block, too, at most `AHEAD_NS` of them; what
has not begun is taken back when anything changes.
"""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from functools import partial
from typing import NamedTuple

from hilbench.bench import Bench
from hilbench.clock import NS_PER_MS, NS_PER_S
from hilbench.links.memory import REAL_TIME_GROUP_NS
from hilbench.links.port import Line, PortBase, Refused, raise_it
from hilbench.links.uart import Injector, Transmitter
from hilbench.mcu.group import ChipTime, MachineGroup
from hilbench.mcu.seams import Machine, Usart
from targets.mcu.serial_line import LineReceiver, SerialFormat, SerialFrame, Words

__all__ = ["AHEAD_NS", "UsartPort"]

AHEAD_NS = NS_PER_MS
"""How long a block of bytes for the chip lasts (choice: as long as the chip runs at once)."""

UNSET_BAUD = 115_200
"""What an end that follows a USART sends with while the firmware has set no rate; the USART is deaf then (choice)."""
_USUAL_BAUDS = (
    300, 600, 1200, 2400, 4800, 9600, 14_400, 19_200, 28_800, 38_400, 57_600, 76_800, 115_200, 230_400, 250_000,
    256_000, 460_800, 500_000, 576_000, 921_600, 1_000_000, 1_500_000, 2_000_000, 2_250_000, 3_000_000, 4_000_000,
    4_500_000,
)  # fmt: skip
_NEAR = Fraction(2, 100)
"""A receiver 2 % off reads everything right, whatever its first sample (RM0008 section 27.3.5: 3.4 % and more)."""
_BREAK_BITS = 14
_BYTES = tuple(bytes((value,)) for value in range(256))


class _Byte(NamedTuple):
    """A byte that the USART has sent, as this end reads it."""

    start_ns: int
    end_ns: int
    value: int
    wrong: bool


class UsartPort(PortBase):
    """See the module. The line is up from the start.

    Args:
        bench: the bench.
        group: who lets the chip run.
        machine: the chip.
        usart: the USART.
        name: for the journal and for messages.
        baud: bit/s of this end; 0 to follow the USART.
        line_format: of this end, unless it follows the USART.

    Attributes:
        reacts: whether anybody here may answer at once to what the USART sends, so that the chip waits for that.
        on_follow: called when the USART's rate or format have changed, or this end's rate.
        each_frame: whether somebody has to know of each frame when it begins.
        on_heard: called with frames that are put on the RX line, and the bench time at which the first begins; with
            those of a block when a run of the chip ends.
        frame_taps: called with each frame that the USART sends, when its start bit begins; in real time, unless
            `each_frame` is set, with the last of several alone.
        taps: called with the bytes that this end reads and the bench time of them, before `on_receive`: with each byte,
            but for a bench in real time.
        heard_taps: called with each byte that is put on the RX line, in real time with several, and the bench time at
            which the first begins.
        joined: the far ends that are USARTs themselves; see `join`.
        chip_time: the time of the chip.
    """

    def __init__(
        self,
        bench: Bench,
        group: MachineGroup,
        machine: Machine,
        usart: Usart,
        name: str,
        *,
        baud: int = 0,
        line_format: SerialFormat | None = None,
    ) -> None:
        super().__init__(name)
        self.line_is_up = True
        self.reacts = True
        self.on_follow: Callable[[], None] = lambda: None
        self.each_frame = False
        self.on_heard: Callable[[Words, int], None] = lambda _words, _at_ns: None
        self._block: Words | None = None  # what the chip knows of beforehand, as far as nobody was told of it
        self.frame_taps: list[Callable[[SerialFrame], None]] = []
        self.taps: list[Callable[[bytes, int], None]] = []
        self.heard_taps: list[Callable[[bytes, int], None]] = []
        self._bench = bench
        self._group = group
        self._machine = machine
        self._usart = usart
        self._own_baud = baud
        self._own_format = line_format or SerialFormat()
        self.joined: list[UsartPort] = []
        self._receiver: LineReceiver | None = None
        self._judged_bit_s: Fraction | None = None
        self._is_near = False
        self.chip_time = ChipTime(bench, machine)
        self._together: list[_Byte] = []  # read by this end, in real time, and not reported yet
        group.after_round.append(self._end_round)
        self._baud = baud or _usual(usart.baud_hz)
        self._bit_s = Fraction(1, self._baud)
        self._transmitter = Transmitter(
            self.chip_time, name, Line(baud=self._baud), self.begin, on_break=self._begin_break, at_start=True
        )
        self._senders: list[Transmitter] = []
        self.add_sender(self._transmitter)
        usart.on_frame = self._sent
        usart.on_format_change = self._follow

    # --- rate and format

    @property
    def baud(self) -> int:
        """Bits per second at this end. Following a USART, the usual rate that is nearest to its own."""
        return self._baud

    @baud.setter
    def baud(self, baud: int) -> None:
        self._own_baud = baud
        self._follow()

    @property
    def usart_baud_hz(self) -> Fraction:
        """The rate that the firmware has set; 0 while it has not."""
        return self._usart.baud_hz

    @property
    def line_format(self) -> SerialFormat:
        """How words are framed at this end."""
        return self._own_format if self._own_baud else self._usart.format

    @property
    def bits_per_byte(self) -> int:
        """Bit times from one start bit to the next at this end, rounded up."""
        return -(-self.line_format.frame_half_bits // 2)

    def _follow(self) -> None:
        self._baud = self._own_baud or _usual(self._usart.baud_hz)
        self._bit_s = Fraction(1, self._baud)
        self._transmitter.set_frame(self._baud, self.bits_per_byte)
        self._receiver = self._judged_bit_s = None
        self.on_follow()

    # --- to the USART

    @property
    def pending(self) -> int:
        """Bytes written that are not out yet."""
        return self._transmitter.pending

    def write(self, data: bytes) -> None:
        """Queue bytes behind those that are not out yet."""
        self._take_to_send(data, self._bench.now_ns)
        self._transmitter.write(data)

    def withdraw(self, keep: int) -> None:
        """Take back what is not out yet, but for the next `keep` bytes and the one that is on the line."""
        self.counters.withdrawn += self._transmitter.withdraw(keep)

    def strike_with(self, injector: Injector | None) -> None:
        """Have an injector decide what becomes of each byte that is written here, when it begins."""
        self._transmitter.strike_with(injector)

    def lose(self) -> None:
        """Lose what is not on the line yet."""
        self.counters.lost += self._transmitter.withdraw(0, judged=True)

    def begin(self, data: bytes, at_ns: int) -> None:
        """Put bytes on the RX line, the first of which begins at `at_ns`, now in the time of the chip."""
        form = self.line_format
        if len(data) == 1:
            self._hear(form.frame(data[0], Fraction(at_ns, NS_PER_S), self._bit_s))
            return
        frame_bits_ns = self.bits_per_byte * NS_PER_S
        starts_ns = [at_ns + number * frame_bits_ns // self._baud for number in range(len(data))]
        bits = [form.word(value) for value in data]
        words = Words(starts_ns, bits, self._bit_s, form.word_bits, form.stop_half_bits)
        self._tell_begun()
        self._block = words
        self._machine.forget_resets()
        self._usart.expect(words)

    def add_sender(self, sender: Transmitter) -> None:
        """Have `begin` called by a transmitter in the time of the chip, in real time by the block."""
        sender.recall = self._recall
        sender.group_ns = AHEAD_NS if self._usart.keeps_words else 0
        self._senders.append(sender)

    def _recall(self, count: int) -> int:
        """Take back what of a block of so many bytes has not begun, but for the first: that one begins now."""
        waiting = self._usart.expected
        first = waiting == count
        self._usart.expect_only(first)
        if self._block is not None:
            self._block = self._block.part(0, len(self._block.bits) - (waiting - first))
        return waiting - first

    def _tell_begun(self) -> None:
        """Tell of what has begun of a block."""
        block = self._block
        if block is None:
            return
        begun = len(block.bits) - self._usart.expected
        if begun:
            self.on_heard(block.part(0, begun), block.starts_ns[0])
        self._block = block.part(begun, len(block.bits)) if begun < len(block.bits) else None

    def send_break(self, duration_ns: int, _refused: Refused = raise_it) -> None:
        """Hold the RX line low for `duration_ns`, after the bytes written so far."""
        self._take_to_send(b"", self._bench.now_ns)
        duration_ns = max(duration_ns, (_BREAK_BITS + 3) * NS_PER_S // self._baud)
        self._transmitter.send_break(duration_ns)

    def join(self, other: UsartPort) -> None:
        """Make this the far end of `other`, and that of this: what one USART sends stands on the other's RX line."""
        for port, peer in ((self, other), (other, self)):
            port.joined.append(peer)
            port.reacts = False

    def close(self) -> None:
        """Let go of the line; a second call does nothing."""
        if not self.closed:
            self.closed = True
            self.line_is_up = False
            self.counters.lost += self._transmitter.clear()

    def hear(self, frame: SerialFrame) -> None:
        """Put a frame on the RX line as soon as the chip has reached its start."""
        self._machine.at_ns(frame.start_ns, lambda: self._hear(frame))

    def _begin_break(self, at_ns: int) -> None:
        bit_s = self._bit_s
        # The line is high for a moment before anything else is sent.
        bits = max(_BREAK_BITS, int(Fraction(self._transmitter.break_ns, NS_PER_S) / bit_s) - 3)
        self._hear(SerialFrame(start_s=Fraction(at_ns, NS_PER_S), bit_s=bit_s, bits=0, bit_count=bits))

    def _hear(self, frame: SerialFrame) -> None:
        words = Words([frame.start_ns], [frame.bits], frame.bit_s, frame.bit_count, frame.stop_half_bits)
        self._tell_begun()
        self.on_heard(words, self.chip_time.now_ns)
        self._machine.forget_resets()
        self._usart.receive(frame)

    def output(self, ns: int, action: Callable[[], None]) -> None:
        """Have `action` happen on the bench at `ns`, called while the chip runs, which may be ahead of the bench."""
        self._group.output(ns, action, source=self.name, reacts=self.reacts)

    # --- from the USART

    def _end_round(self, reached_ns: int) -> None:
        if not self._bench.scheduler.locked:
            return
        self._tell_begun()
        self._take_kept()
        self._tell_together(reached_ns)
        keeps = not (self.reacts or self.each_frame or self.joined)
        if keeps is not self._usart.keeps_words:
            self._usart.keeps_words = keeps
            for sender in self._senders:
                sender.group_ns = AHEAD_NS if keeps else 0

    def _take_kept(self) -> None:
        """Read what the chip has kept."""
        for words in self._usart.take_words():
            if self._receiver is not None or not self._fits(words.bit_s, words.bit_count):
                for frame in words.frames():
                    self._misread(frame)
                continue
            for tap in self.frame_taps:
                tap(words.frame(-1))
            # The firmware may have chosen another format since.
            form, frame_ns = self._own_format if self._own_baud else words.format, words.frame_ns
            for start_ns, bits in zip(words.starts_ns, words.bits, strict=True):
                self._collect(_Byte(start_ns, start_ns + frame_ns, *_judged(bits, form)))

    def _sent(self, frame: SerialFrame) -> None:
        self._take_kept()
        for tap in self.frame_taps:
            tap(frame)
        for port in self.joined:
            port.hear(frame)
        if not frame.is_break and self._receiver is None and self._fits(frame.bit_s, frame.bit_count):
            self._read(frame)
            return
        self._tell_together(frame.start_ns)
        if frame.is_break:
            self.output(frame.end_ns, self._take_break)
        else:
            self._misread(frame)

    def _read(self, frame: SerialFrame) -> None:
        """Read a frame as it was meant."""
        if self.reacts or not self._bench.scheduler.locked:
            self._tell_together(frame.start_ns)
            value, wrong = _judged(frame.bits, self.line_format)
            self.output(frame.end_ns, partial(self._take, _BYTES[value], wrong))
            return
        if self._group.breathe(frame.start_ns):
            self._tell_together(frame.start_ns)
        self._collect(_Byte(frame.start_ns, frame.end_ns, *_judged(frame.bits, self.line_format)))

    def _collect(self, byte: _Byte) -> None:
        """Take a byte that is reported together with those beside it."""
        if self._together and byte.end_ns - self._together[0].start_ns > REAL_TIME_GROUP_NS:
            self._tell_together(byte.start_ns)
        self._together.append(byte)

    def _tell_together(self, reached_ns: int) -> None:
        """Tell of all that was complete by `reached_ns`."""
        complete = [byte for byte in self._together if byte.end_ns <= reached_ns]
        if complete:
            del self._together[: len(complete)]
            data = bytes(byte.value for byte in complete)
            wrong = sum(byte.wrong for byte in complete)
            self.output(complete[-1].end_ns, partial(self._take, data, wrong))

    def _fits(self, bit_s: Fraction, bit_count: int) -> bool:
        """Say whether this end reads a frame as it was meant."""
        if not self._own_baud:
            return True
        if bit_s is not self._judged_bit_s:
            self._judged_bit_s = bit_s
            self._is_near = abs(bit_s * self._own_baud - 1) <= _NEAR
        return self._is_near and bit_count == self._own_format.word_bits

    def _misread(self, frame: SerialFrame) -> None:
        """Read a frame of another rate or format, bit by bit."""
        if self._receiver is None:
            self._receiver = LineReceiver(self.line_format, Fraction(1, self._baud))
        idle = self._receiver.next_s() is None
        self._receiver.receive(frame)
        if idle:
            self._await_word(self._receiver)

    def _await_word(self, receiver: LineReceiver) -> None:
        done_s = receiver.next_s()
        if done_s is not None:
            self.output(_ns(done_s), lambda: self._take_words(receiver, done_s))

    def _take_words(self, receiver: LineReceiver, done_s: Fraction) -> None:
        for word in receiver.advance(done_s):
            self._take(_BYTES[word.value & 0xFF], word.framing_error or word.parity_error)
        self._await_word(receiver)

    def _take(self, data: bytes, wrong: int) -> None:
        if self.closed:
            return
        self.counters.framing_errors += wrong
        now_ns = self._bench.now_ns
        for tap in self.taps:
            tap(data, now_ns)
        self._deliver(data, now_ns)

    def _take_break(self) -> None:
        if not self.closed:
            self.counters.breaks += 1
            self.on_break(self._bench.now_ns)


def _judged(bits: int, form: SerialFormat) -> tuple[int, bool]:
    """Return a byte, and whether its parity is wrong."""
    return form.value(bits) & 0xFF, form.parity_wrong(bits)


def _ns(time_s: Fraction) -> int:
    return time_s.numerator * NS_PER_S // time_s.denominator


def _usual(baud_hz: Fraction) -> int:
    """Return the usual rate near `baud_hz`; where there is none, the rate itself, rounded."""
    if not baud_hz:
        return UNSET_BAUD
    nearest = min(_USUAL_BAUDS, key=lambda usual: abs(usual - baud_hz))
    return nearest if abs(nearest - baud_hz) <= _NEAR * baud_hz else max(1, round(baud_hz))
