"""Running our images on the emulated board, and keeping what comes out of them."""

from __future__ import annotations

import functools
import inspect
import re
from fractions import Fraction

import pytest

from targets.boards import built_in_board
from targets.firmware import image_path
from targets.mcu.image import limits_of, load_image
from targets.mcu.machine import Machine
from targets.mcu.serial_line import SerialFormat
from tests.targets.firmware.high_density import IMAGES as HIGH_DENSITY_IMAGES
from tests.targets.firmware.wires import put_wires

MS = 1_000_000
BOARDS = {
    "f767": built_in_board("nucleo-f767zi"),
    "h753": built_in_board("nucleo-h753zi"),
    "style-hse-bypass": built_in_board("nucleo-f103rb"),
    **HIGH_DENSITY_IMAGES,
}
BLUE_PILL = built_in_board("bluepill")
FORMAT = SerialFormat.parse("8N1")


def board_of(name):
    return BOARDS.get(name) or BOARDS.get(name[:4], BLUE_PILL)


@functools.cache
def image(name):
    return load_image(image_path(name), limits_of(board_of(name).variant))


class Run:
    """A machine with an image, and what it has said.

    Attributes:
        machine: the emulated board that the image is for.
        sent: bytes that each USART has sent.
        console: what the program wrote to semihosting and ITM.
        resets: causes, in order.
    """

    def __init__(self, name, **options):
        self.machine = Machine(board_of(name), image(name), **options)
        put_wires(self.machine, name)
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


@pytest.fixture
def put_in(monkeypatch):
    """Replaces a method by one with a defect: it has an owner, a method, and words that are right and wrong."""

    def put(defect):
        source = defect.source()
        function, is_property = defect.function()
        names = dict(vars(inspect.getmodule(function)))
        # a class of its own, so that super() works
        code = source.replace(defect.right, defect.wrong, 1).replace("super()", f"super({defect.owner.__name__}, self)")
        exec(compile(f"from __future__ import annotations\n{code}", f"<{defect.what}>", "exec"), names)
        wrong = names[defect.method]
        monkeypatch.setattr(defect.owner, defect.method, property(wrong) if is_property else wrong)

    return put
