"""The rover's images on the emulated board: what `rover/board` makes of registers, pins and lines."""

from __future__ import annotations

import functools
import struct
from fractions import Fraction
from itertools import pairwise

import pytest

from protocols.pkt import FrameReader, decode_report, encode_frame
from targets.boards import built_in_board
from targets.firmware import image_path
from targets.mcu.image import limits_for, load_image
from targets.mcu.machine import Machine
from targets.mcu.pins import Source
from targets.mcu.serial_line import SerialFormat
from tests.each import each

BOARD = built_in_board("nucleo-f767zi")
FORMAT = SerialFormat.parse("8N1")
NS_PER_S = 1_000_000_000
TICK_NS = 10_000_000
LED_ON = encode_frame(b"\x01")
REQUEST = encode_frame(b"\0")
DMA1_S1CR = 0x4002_6000 + 0x10 + 0x18  # RM0410 section 8.5.5
TACHOMETERS = ("PE7", "PE8", "PG9", "PG14")


@functools.cache
def image(name):
    return load_image(image_path(name), limits_for(BOARD.chip))


class Imu:
    """An MPU-9250 that lies still, with an AK8963, as far as the rover reads them."""

    def __init__(self):
        self.registers = {0x75: 0x71, 0x3A: 0x01, 0x3F: 0x40}
        self.field = {0x00: 0x48, 0x02: 0x01, 0x10: 128, 0x11: 128, 0x12: 128, 0x06: 1}
        self._at = 0
        self._device = None
        self._begun = False

    def address(self, address, read, _now_ns):
        self._device = {0x68: self.registers, 0x0C: self.field}.get(address)
        self._begun = read
        return self._device is not None

    def write(self, byte, _now_ns):
        if self._begun:
            self._device[self._at] = byte
            self._at += 1
        else:
            self._at, self._begun = byte, True
        return True

    def read(self, _now_ns):
        value = self._device.get(self._at, 0)
        self._at += 1
        return value

    def end(self, _now_ns):
        pass


class OnBoard:
    """A board with an image: bytes on its lines, levels at its pins.

    Attributes:
        machine: the board.
        sent: bytes to the host, and the times in ns at which they ended.
    """

    def __init__(self, name="rover", *, imu=True, baud=115200):
        self.machine = Machine(BOARD, image(name))
        self.baud = baud
        self.sent = bytearray()
        self.sent_ns = []
        self.resets = []
        self.machine.on_reset = self.resets.append
        self.machine.chip.usarts["USART3"].on_frame = self._take
        if imu:
            self.machine.chip.i2cs["I2C1"].bus.attach(Imu())

    def _take(self, frame):
        assert 1 / frame.bit_s == pytest.approx(self.baud, rel=0.002)
        self.sent.append(frame.bits & 0xFF)
        self.sent_ns.append(self.machine.now_ns)

    def run(self, seconds):
        self.machine.run_to(self.machine.now_ns + round(seconds * NS_PER_S))
        assert self.machine.ended is None
        return self

    def say(self, data, *, usart="USART3", baud=None):
        """Bytes begin to come in now, one directly after the other."""
        bit_s = Fraction(1, baud or self.baud)
        start_s = Fraction(self.machine.now_ns, NS_PER_S) + Fraction(1, 1_000_000)
        for index, byte in enumerate(data):
            frame = FORMAT.frame(byte, start_s + 10 * index * bit_s, bit_s)
            receive = self.machine.chip.usarts[usart].receive
            self.machine.at_ns(int(frame.start_s * NS_PER_S), functools.partial(receive, frame))
        return self

    def payloads(self):
        """Of the frames that were sent since the last call."""
        found = FrameReader().receive(bytes(self.sent), 0)
        self.sent.clear()
        return [frame.payload for frame in found]

    def report(self, number):
        """The last report of this kind that was sent."""
        return decode_report([payload for payload in self.payloads() if payload[0] == number][-1])

    def level(self, pin):
        return self.machine.chip.pins[pin].level

    def mean(self, pin, seconds=0.1):
        """How much of the time the pin is high from now on."""
        edges = self.machine.chip.pins[pin]
        edges.record()
        edges.take_edges()
        begin_ns, level = self.machine.now_ns, self.level(pin)
        self.run(seconds)
        high_ns, since_ns = 0, begin_ns
        for _cycle, ns, now in (*edges.take_edges(), (0, self.machine.now_ns, None)):
            high_ns += (ns - since_ns) * level
            since_ns, level = ns, now
        return high_ns / (self.machine.now_ns - begin_ns)

    def turn(self, pin, period_s, slots):
        """Let slots pass a tachometer from now on."""
        half_ns = round(period_s * NS_PER_S / 2)
        source = self.machine.chip.pins[pin]
        for index in range(2 * slots):
            level = 3.3 * (index % 2)
            at_ns = self.machine.now_ns + 1000 + index * half_ns
            self.machine.at_ns(at_ns, functools.partial(source.set_source, "disc", Source(level, 100.0)))
        return self


@pytest.fixture
def on_board():
    """Makes an `OnBoard`: ``on_board(image, imu=..., baud=...)``."""
    return OnBoard


def test_it_starts_and_touches_nothing_that_is_wrong(on_board):
    board = on_board().run(1.5)
    assert [note for note in board.machine.notes.all if note.kind in ("misuse", "clock-off")] == []
    assert board.resets == ["POR"] or board.resets == []


def test_its_clock_is_216_mhz(on_board):
    assert on_board().run(0.1).machine.time.hclk_hz == 216_000_000


def test_reports_come_at_their_ticks(on_board):
    board = on_board().run(3.0)
    counts = [payload[0] for payload in board.payloads()]
    assert {one: counts.count(one) for one in set(counts)} == {0x80: 10, 0x83: 12, 0x82: 3, 0x84: 3}


@each("name", ["rover", "rover-dma"])
def test_it_answers_and_lights_the_led(on_board, name):
    """At once, not at the next tick."""
    board = on_board(name).run(0.205)
    board.payloads()
    board.say(LED_ON).run(0.003)
    assert board.payloads() == [b"\x81\x01\x00"]
    assert board.level("PB0")
    board.say(REQUEST).run(0.003)
    assert board.payloads() == [b"\x80\x01\x00\x01\x00\x00"]


def test_after_the_start_of_mbed_it_answers_between_the_alarms_of_the_ticker(on_board):
    board = on_board("rover-mbed-start").run(1.99)
    assert board.payloads() == [], "it awaits the LSE"
    board.run(0.215)
    board.payloads()
    board.say(REQUEST).run(0.003)
    assert board.payloads() == [b"\x80\x00\x00\x00\x00\x00"]
    line, ticks = board.machine.chip.signals.input("EXTI23"), []
    line.on_change = lambda level: ticks.append(board.machine.now_ns) if level else None
    board.run(1.0)
    alarms = [one for one, before in zip(ticks[1:], ticks, strict=False) if one - before > TICK_NS]
    assert [round((later - one) / 1e6) for one, later in pairwise(alarms)] == [100] * (len(alarms) - 1)
    assert len(alarms) >= 8
    assert board.machine.notes.all == []


@pytest.mark.parametrize(
    ("name", "by_dma"),
    [
        pytest.param(
            "rover",
            False,
            marks=pytest.mark.exhaustive("the gate has the ring by DMA, and compares this image with its model"),
        ),
        ("rover-dma", True),
    ],
)
def test_a_line_without_a_pause(on_board, name, by_dma):
    """More than three times what the ring holds."""
    board = on_board(name).run(0.205)
    assert bool(board.machine.bus.read(DMA1_S1CR, 4) & 1) is by_dma
    count = 350
    board.say(LED_ON * count).run(len(LED_ON) * count * 10 / 115200 + 0.1)
    board.payloads()
    general = board.say(REQUEST).run(0.01).report(0x80)
    assert (general.accepted, general.rejected) == (count % 256, 0)


def test_it_sleeps_between(on_board):
    board = on_board().run(0.5)
    asleep = 0
    for _ in range(100):
        board.run(0.00137)
        asleep += board.machine.core.sleeping
    assert asleep > 80


def test_other_rates_and_other_frames(on_board):
    slow = on_board("rover-9600", baud=9600).run(0.405)
    slow.payloads()
    assert slow.say(LED_ON).run(0.03).payloads() == [b"\x81\x01\x00"]
    term = on_board("rover-term").run(0.2).say(bytes.fromhex("504B542100E1F00A")).run(0.005)
    assert bytes(term.sent) == bytes.fromhex("504B5421800000000033DC0A")


@each(("name", "first_s", "periodic"), [("rover", 0.0, 4), ("rover-slow-start", 0.955, 1), ("rover-g2", 0.955, 1)])
def test_the_first_word(on_board, name, first_s, periodic):
    """What comes before is kept, and answered then."""
    board = on_board(name).run(0.1).say(REQUEST).run(1.0)
    assert first_s <= board.sent_ns[0] / NS_PER_S <= first_s + 0.01
    assert [payload[0] for payload in board.payloads()].count(0x80) == periodic + 1


@pytest.mark.exhaustive("at the full rate of the line; the gate compares the image with its model")
def test_256_frames_without_a_gap(on_board):
    board = on_board().run(0.205).say(LED_ON * 256).run(0.5)
    counts = [payload[0] for payload in board.payloads()]
    assert counts.count(0x81) == 256
    board.say(REQUEST).run(0.01)
    assert board.report(0x80).accepted == 0


def test_the_gps_receiver_is_heard(on_board):
    sentence = b"$GPGGA,092725.00,3437.05000,S,05822.09800,W,1,08,1.01,499.6,M,48.0,M,,*4E\r\n"
    total = functools.reduce(lambda a, b: a ^ b, sentence[1 : sentence.index(b"*")])
    sentence = sentence[: sentence.index(b"*") + 1] + f"{total:02X}\r\n".encode()
    board = on_board().run(0.2).say(sentence, usart="USART2", baud=9600).run(1.0)
    position = board.report(0x84)
    assert (position.first_deg, position.second_deg) == pytest.approx((-34.6175, -58.3683), abs=1e-5)


def test_the_imu_is_read(on_board):
    board = on_board().run(2.1)
    report = board.report(0x82)
    assert report.validity == 3
    assert report.acceleration == pytest.approx((0.0, 0.0, 9.80665))
    assert report.field_mgauss == pytest.approx((384.0, 0.0, 0.0))


def test_without_an_imu(on_board):
    board = on_board(imu=False).run(1.0)
    assert board.report(0x80).status == 1


@pytest.mark.exhaustive("test_imu.py has a bus that hangs, in the gate")
def test_a_bus_that_is_held_stops_nothing(on_board):
    board = on_board().run(1.5)
    bus = board.machine.chip.i2cs["I2C1"].bus
    bus.stick()
    board.payloads()
    counts = [payload[0] for payload in board.run(2.0).payloads()]
    assert counts.count(0x83) == 8
    bus.unstick()
    board.run(2.5)
    assert board.report(0x80).status & 1 == 0


def throttles(left, right):
    return encode_frame(struct.pack("<BffB", 3, left, right, 3))


def test_throttles_at_the_pins(on_board):
    board = on_board().run(0.1)
    for left, right in ((0.5, -0.25), (-1.0, 1.0), (0.0, 0.05)):
        board.say(throttles(left, right)).run(0.05)
        assert (board.level("PB10"), board.level("PE15")) == (left >= 0, left < 0)
        assert (board.level("PE14"), board.level("PE12")) == (right >= 0, right < 0)
        assert board.mean("PB11") == pytest.approx(abs(left), abs=0.001)
        board.say(throttles(left, right)).run(0.05)
        assert board.mean("PE10") == pytest.approx(abs(right), abs=0.001)


@each(("name", "period_s"), [("rover", 0.02), ("rover-pwm-1khz", 0.001)])
def test_the_period_of_the_motors(on_board, name, period_s):
    board = on_board(name).run(0.1).say(throttles(0.5, 0.5)).run(0.05)
    for pin in ("PB11", "PE10"):
        wire = board.machine.chip.pins[pin]
        wire.record()
        wire.take_edges()
        board.run(0.1)
        rises = [ns for _cycle, ns, level in wire.take_edges() if level]
        assert rises[1] - rises[0] == pytest.approx(period_s * NS_PER_S, abs=20)


def test_silence_stops_the_motors_at_the_pins(on_board):
    board = on_board().run(0.1).say(throttles(0.5, 0.5)).run(0.95)
    assert board.mean("PB11", 0.04) > 0.4
    board.run(0.1)
    assert board.mean("PB11", 0.1) == 0.0
    assert board.level("PB14")


def test_tachometers(on_board):
    """Slots of 60 Hz are 180 rpm."""
    board = on_board().run(0.1)
    for number, pin in enumerate(TACHOMETERS):
        board.turn(pin, 1 / 60, 60 - number)
    report = board.run(0.93).report(0x83)
    assert report.rpm == pytest.approx((180.0,) * 4, rel=1e-4)
    assert board.run(0.3).report(0x83).ticks == (60, 59, 58, 57)


def test_a_program_that_hangs_is_reset(on_board, code):
    """Its interrupts go on, its thread waits 0.8 s for a tick."""
    board = on_board().run(0.9).say(throttles(0.5, 0.5)).run(0.05)
    at = code("rover").symbols["first_tick"] - 0x2000_0000
    board.machine.ram[at] += 80
    board.resets.clear()
    board.run(0.6)
    assert board.resets == ["IWDG"]
    assert board.mean("PB11", 0.1) == 0.0
