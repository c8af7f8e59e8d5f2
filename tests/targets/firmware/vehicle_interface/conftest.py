"""The vehicle interface's images on the emulated board, and the behavioural model, under the same stimuli.

A stimulus is something that happens at a time; what comes of it is what the two lines, the lights and the lamps say.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass, field
from fractions import Fraction

import pytest

from protocols import autoware, carla
from targets.boards import built_in_board
from targets.firmware import image_path
from targets.mcu.image import limits_of, load_image
from targets.mcu.machine import Machine
from targets.mcu.pins import Source
from targets.mcu.serial_line import SerialFormat
from targets.robots.vehicle_interface import VehicleInterface, VehicleSettings

BOARD = built_in_board("nucleo-h753zi")
FORMAT = SerialFormat.parse("8N1")
BIT_S = Fraction(1, carla.BAUD)
MS = 1_000_000
S = 1000 * MS
SUPPLY_V, CODES = 3.3, 65_536
PRESS_MS = 30
CLOSE_MS = 2.2
BOOT_MS = 0.45  # until the first tick of the kernel begins
LIGHTS = {"PB0": "green", "PE1": "amber", "PB14": "red"}
LAMPS = {"PE7": "left", "PE8": "right"}


@functools.cache
def image(name):
    return load_image(image_path(name), limits_of(BOARD.variant))


@dataclass(frozen=True)
class Said:
    """Something that the board said: frame `what` of `who`, begun at `ms`."""

    ms: float
    who: str
    what: object

    def agrees_with(self, other):
        """The same, NaN being the same as NaN, within two ticks and a bit."""
        return abs(self.ms - other.ms) <= CLOSE_MS and (self.what == other.what or repr(self.what) == repr(other.what))


@dataclass
class Stimuli:
    """What happens, in any order.

    Attributes:
        simulator: bytes on the simulator's line, by when they begin in ms.
        stack: messages on the driving stack's line.
        stick: counts of X and Y from then on.
        presses: when the joystick's switch is let go.
        noise: when a byte with a framing error comes on the simulator's line.
    """

    simulator: list = field(default_factory=list)
    stack: list = field(default_factory=list)
    stick: list = field(default_factory=list)
    presses: list = field(default_factory=list)
    noise: list = field(default_factory=list)

    def status(self, *times_ms, **values):
        data = carla.encode_status(carla.StatusFrame(**values))
        self.simulator += [(ms, data) for ms in times_ms]
        return self

    def raw(self, ms, data):
        self.simulator.append((ms, data))
        return self

    def online(self, ms):
        return self.message(ms, autoware.AgentOnline())

    def message(self, ms, message):
        self.stack.append((ms, message))
        return self

    def command(self, *times_ms, **values):
        message = autoware.AckermannControlCommand(**values)
        self.stack += [(ms, message) for ms in times_ms]
        return self

    def request(self, ms, mode, sequence=0):
        return self.message(ms, autoware.ControlModeRequest(mode=mode, sequence=sequence))

    def press(self, ms):
        self.presses.append(ms)
        return self

    @property
    def on_stack_line(self):
        """The bytes on the driving stack's line, by when they begin in ms."""
        return [(ms, frame_of(message)) for ms, message in self.stack]

    def move(self, ms, x, y):
        self.stick.append((ms, x, y))
        return self


def frame_of(message):
    return autoware.encode_frame(autoware.encode_message(message))


def shown(data):
    """A frame to the simulator as what it says, where it is whole."""
    if len(data) < carla.COMMAND_BYTES:
        return bytes(data)
    try:
        return carla.decode_command(bytes(data))
    except carla.RemoteProtocolError:
        return bytes(data)


class OnBoard:
    """An image on the emulated board.

    Attributes:
        machine: the board.
        said: what it said so far.
        resets: causes of resets.
    """

    def __init__(self, name, **options):
        self.machine = Machine(BOARD, image(name), **options)
        self.said = []
        self.resets = []
        self._frame, self._begun_ms = bytearray(), 0.0
        self._reader = autoware.FrameReader()
        self.machine.on_reset = self.resets.append
        self.machine.chip.usarts["USART2"].on_frame = self._from_simulator_line
        self.machine.chip.usarts["USART3"].on_frame = self._from_stack_line
        for pin, name_of_light in (LIGHTS | LAMPS).items():
            self.machine.chip.pins[pin].on_edge(functools.partial(self._switched, name_of_light))
        self.stick(33_970, 33_580)

    def play(self, stimuli, until_ms):
        at = self.machine.at_ns
        for ms, data in stimuli.simulator:
            self._come("USART2", ms, data)
        for ms, data in stimuli.on_stack_line:
            self._come("USART3", ms, data)
        for ms, x, y in stimuli.stick:
            at(round(ms * MS), functools.partial(self.stick, x, y))
        for ms in stimuli.presses:
            at(round((ms - PRESS_MS) * MS), functools.partial(self.machine.chip.pins["PF13"].drive, False))
            at(round(ms * MS), functools.partial(self.machine.chip.pins["PF13"].drive, None))
        for ms in stimuli.noise:
            self._come("USART2", ms, b"\0", bit_s=BIT_S * 2)
        self.machine.run_to(round(until_ms * MS))
        assert self.machine.ended is None, self.machine.ended
        return self.said

    def stick(self, x, y):
        for pin, count in (("PF12", x), ("PF11", y)):
            self.machine.chip.pins[pin].set_source("stick", Source((count + 0.25) / CODES * SUPPLY_V, 100.0))

    def level(self, pin):
        return self.machine.chip.pins[pin].level

    def memory(self, symbol):
        """The bytes of a variable, to be looked at and written."""
        found = self.machine.image.symbols.find(symbol)
        memory = next(one for one in self.machine.chip.memories if one.writable and one.holds(found.address))
        return memoryview(memory.data)[found.address - memory.base :][: found.size]

    @property
    def misuses(self):
        return [note for note in self.machine.notes.all if note.kind in ("misuse", "clock-off", "unmodelled")]

    def _come(self, usart, ms, data, bit_s=BIT_S):
        start_s = Fraction(round(ms * MS), S)
        for index, byte in enumerate(data):
            frame = FORMAT.frame(byte, start_s + 10 * index * bit_s, bit_s)
            receive = self.machine.chip.usarts[usart].receive
            self.machine.at_ns(int(frame.start_s * S), functools.partial(receive, frame))

    def _from_simulator_line(self, frame):
        now_ms = self.machine.now_ns / MS
        if self._frame and now_ms - self._begun_ms > 1:
            self._end_frame()
        if not self._frame:
            self._begun_ms = now_ms
        self._frame.append(frame.bits & 0xFF)
        if len(self._frame) == carla.COMMAND_BYTES:
            self._end_frame()

    def _end_frame(self):
        self.said.append(Said(self._begun_ms, "simulator", shown(self._frame)))
        self._frame.clear()

    def _from_stack_line(self, frame):
        for found in self._reader.receive(bytes((frame.bits & 0xFF,))):
            message = autoware.decode_message(found.payload)
            self.said.append(Said(self.machine.now_ns / MS, "stack", message))

    def _switched(self, name, _cycle, ns, level):
        self.said.append(Said(ns / MS, "light", (name, level)))


class Model:
    """The behavioural model; it begins when the board's program does.

    Attributes:
        said: what it said so far.
    """

    def __init__(self, **settings):
        self._board = VehicleInterface(VehicleSettings(boot_s=BOOT_MS / 1000, **settings))
        self.said = []

    def play(self, stimuli, until_ms):
        byte_ms = float(10 * BIT_S * 1000)
        happens = [
            *((ms + len(data) * byte_ms, "receive", ("usart2", data)) for ms, data in stimuli.simulator),
            *(
                (ms + len(frame_of(what)) * byte_ms, "receive", ("usart3", frame_of(what)))
                for ms, what in stimuli.stack
            ),
            *((ms, "set_joystick", counts) for ms, *counts in stimuli.stick),
            *((ms, "press", ()) for ms in stimuli.presses),
            *((ms + 2 * byte_ms, "line_error", ()) for ms in stimuli.noise),
            *((ms + 2 * byte_ms, "receive", ("usart2", b"\0")) for ms in stimuli.noise),
        ]
        for ms, method, arguments in sorted(happens, key=lambda one: one[0]):
            if ms < until_ms:
                self._advance(ms)
                self._note(getattr(self._board, method)(*arguments, round(ms * MS)), ms)
        self._advance(until_ms)
        return self.said

    def _advance(self, until_ms):
        while (due_ns := self._board.next_deadline_ns()) is not None and due_ns <= until_ms * MS:
            self._note(self._board.advance(due_ns), due_ns / MS)

    def _note(self, sent, ms):
        for line, data in sent:
            if line == "usart2":
                self.said.append(Said(ms, "simulator", shown(data)))
            else:
                for found in autoware.FrameReader().receive(data):
                    self.said.append(Said(ms, "stack", autoware.decode_message(found.payload)))


@pytest.fixture
def stimuli():
    """What happens, to be filled."""
    return Stimuli()


@pytest.fixture
def on_board():
    """Makes an `OnBoard`: ``on_board(image)``."""
    return OnBoard


@pytest.fixture
def model():
    """Makes a `Model`: ``model(profile=..., defects=...)``."""
    return Model
