"""Running our images on the emulated board, and keeping what comes out of them."""

from __future__ import annotations

import functools
import re
from fractions import Fraction

import pytest

from targets.boards import built_in_board
from targets.firmware import image_path
from targets.mcu.image import limits_for, load_image
from targets.mcu.machine import Machine
from targets.mcu.serial_line import SerialFormat

MS = 1_000_000
BOARD = built_in_board("bluepill")
FORMAT = SerialFormat.parse("8N1")


@functools.cache
def image(name):
    return load_image(image_path(name), limits_for(BOARD.chip))


class Run:
    """A machine with an image, and what it has said.

    Attributes:
        machine: the emulated board.
        sent: bytes that each USART has sent.
        console: what the program wrote to semihosting and ITM.
        resets: causes, in order.
    """

    def __init__(self, name, **options):
        self.machine = Machine(BOARD, image(name), **options)
        self.sent = {usart: bytearray() for usart in self.machine.chip.usarts}
        self.console = bytearray()
        self.resets = []
        self.machine.on_console = lambda text, _channel: self.console.extend(text)
        self.machine.on_reset = self.resets.append
        for usart, bytes_sent in self.sent.items():
            self.machine.chip.usarts[usart].on_frame = lambda frame, sent=bytes_sent: sent.append(frame.bits & 0xFF)

    def to(self, until_ms, *, step_ns=None):
        """Run until then or to the end, in steps if there is one given; return self."""
        machine, until_ns = self.machine, int(until_ms * MS)
        while machine.ended is None and machine.now_ns < until_ns:
            machine.run_to(until_ns if step_ns is None else min(until_ns, machine.now_ns + step_ns))
        return self

    def send(self, usart, data, *, baud, at_ms):
        """Let bytes come in, one directly after the other."""
        bit_s, start_s = Fraction(1, baud), Fraction(at_ms, 1000)
        for index, byte in enumerate(data):
            frame = FORMAT.frame(byte, start_s + 10 * index * bit_s, bit_s)
            receive = self.machine.chip.usarts[usart].receive
            self.machine.at_ns(int(frame.start_s * 10**9), functools.partial(receive, frame))
        return self

    def drive(self, pin, *changes):
        """Put levels on a pin: (ms, level)."""
        for at_ms, level in changes:
            self.machine.at_ns(int(at_ms * MS), functools.partial(self.machine.chip.pins[pin].drive, level))
        return self

    def record(self, *pins):
        for pin in pins:
            self.machine.chip.pins[pin].record()
        return self

    def edges_ms(self, pin):
        """Moments of the edges of a recorded pin."""
        return [ns / MS for _cycle, ns, _level in self.machine.chip.pins[pin].edges]

    @property
    def checks(self):
        """Names of the checks of a self-test: those that passed, those that failed."""
        lines = re.findall(r"^(ok|FAIL) (\S+)", self.console.decode(), re.MULTILINE)
        return [name for how, name in lines if how == "ok"], [name for how, name in lines if how == "FAIL"]

    @property
    def misuses(self):
        return [f"{note.kind} {note.where}" for note in self.machine.notes.all if note.kind in ("misuse", "clock-off")]


@pytest.fixture
def start():
    """Makes a `Run`: ``start(name, timing=..., skip_idle=...)``."""
    return Run
