"""Chips without a CPU: the real USARTs and pins, and a program that is a Python function."""

from __future__ import annotations

import struct
from dataclasses import dataclass
from types import SimpleNamespace

import pytest

from hilbench.bench import Bench
from hilbench.benchfile.reader import open_bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.mcu.emulated import EmulatedBench
from targets.mcu.fidelity import Notes
from targets.mcu.pins import PadMode, Pins
from targets.mcu.signals import Signals
from targets.mcu.stm32f1.usart import Usart
from targets.mcu.stm32f1.variants import VARIANTS
from targets.mcu.testing import FakeChip, peek, poke

HCLK_HZ = 72_000_000
UE_TE_RE_RXNEIE = 1 << 13 | 1 << 3 | 1 << 2 | 1 << 5


@dataclass
class FakeEnding:
    kind: str
    status: int
    ns: int
    cause: str = "as told"
    pc: int = 0x0800_0124
    place: str = "main (main.c:7)"


class FakeMachine:
    """Runs a program: a function that is called when power comes on, and may use what is here."""

    def __init__(self, program=lambda _machine: None):
        self.fake = FakeChip(HCLK_HZ)
        self.time = self.fake.time
        self.notes = Notes(lambda: (self.time.now, self.now_ns), lambda: None)
        pins = Pins(sorted(VARIANTS["STM32F103C8"].pins), self.time, self.notes)
        pins.deliver = self.at_ns
        usarts = {
            name: self.fake.add(Usart(name, base, self.fake.services, bus="AHB", irq=irq))
            for name, base, irq in (
                ("USART1", 0x4001_3800, 37),
                ("USART2", 0x4000_4400, 38),
                ("USART3", 0x4000_4800, 39),
            )
        }
        self.chip = SimpleNamespace(pins=pins, usarts=usarts, i2cs={}, signals=Signals(pins), starting={})
        self.chip.blocks = [*usarts.values()]
        self.waits_in = None
        self.asleep = None
        self.pc = 0x0800_0100
        self.writes = 0
        self.on_console = lambda _text, _channel: None
        self.on_reset = lambda _cause: None
        self.ended = None
        self.runs = []
        self._program = program
        self._limit_ns = 0

    # --- what the bench uses

    @property
    def now_ns(self):
        return self.time.ns(self.time.now)

    def run_to(self, limit_ns):
        self._limit_ns = limit_ns
        if self._program is not None:
            program, self._program = self._program, None
            program(self)
        while self.ended is None:
            limit = self.time.cycle_at_ns(self._limit_ns)
            due = self.time.next_cycle()
            if due is None or due > limit:
                self.time.run_due(max(limit, self.time.now))
                break
            self.time.run_due(due)
        self.runs.append(self.now_ns)

    def at_ns(self, ns, action):
        self.time.at(self.time.cycle_at_ns(ns), action)

    def horizon(self, ns):
        self._limit_ns = min(self._limit_ns, ns)

    def reset(self, cause="PIN"):
        self.at_ns(self.now_ns, lambda: self.on_reset(cause))

    def hang(self):
        pass

    def forget_resets(self):
        pass

    def function(self, pc):
        return f"f{pc & 0xFFF:X}"

    def place(self, pc):
        return f"0x{pc:08X}"

    # --- what a program uses

    def usart(self, name, baud=115_200, *, cr1=UE_TE_RE_RXNEIE, on_byte=None):
        usart, irq = self.chip.usarts[name], {"USART1": 37, "USART2": 38, "USART3": 39}[name]
        poke(usart, "BRR", round(HCLK_HZ / baud))
        if on_byte is not None:

            def interrupted(level):
                while level and peek(usart, "SR") & 0x20:
                    on_byte(peek(usart, "DR"))

            self.fake.irq(irq).on_set = interrupted
        poke(usart, "CR1", cr1)

        def send(text):
            for value in text:
                poke(usart, "DR", value)

        return send

    def send_all(self, name, data):
        """Send data byte by byte, as fast as the line takes it."""
        usart = self.chip.usarts[name]
        while data and usart[0] & 0x80:  # TXE
            poke(usart, "DR", data[0])
            data = data[1:]
        if data:
            self.time.at_time(self.time.seconds(self.time.now) + 4 / usart.baud_hz, lambda: self.send_all(name, data))

    def echo(self, name, baud=115_200):
        send = self.usart(name, baud, on_byte=lambda value: send((value,)))

    def output(self, pin, level=False):
        self.chip.pins[pin].configure(PadMode.PUSH_PULL, latch=level, pull=None)

    def every(self, period_ns, action):
        def again():
            action()
            self.every(period_ns, action)

        self.at_ns(self.now_ns + period_ns, again)

    def stop_all(self):
        """Let nothing happen any more."""
        for event in list(self.time._events.values()):
            self.time.cancel(event)

    def end(self, kind="exit", status=0):
        self.ended = FakeEnding(kind, status, self.now_ns)


IMAGE = struct.pack("<II", 0x2000_5000, 0x0800_0009) + b"\xfe\xe7"
ONE = 'version = 1\n[targets.brain]\nboard = "bluepill"\nfirmware = "a.bin"\n'
TWO = f'{ONE}[targets.other]\nboard = "bluepill"\nfirmware = "a.bin"\n'


@pytest.fixture
def bench():
    return Bench(Scheduler(), Journal())


@pytest.fixture
def fake_maker():
    """Return what makes machines that run these programs, one after the other."""

    def maker(*programs):
        waiting = iter(programs)
        return lambda _board, _image: FakeMachine(next(waiting))

    return maker


@pytest.fixture
def image(tmp_path):
    file = tmp_path / "a.bin"
    file.write_bytes(IMAGE)
    return file


@pytest.fixture
def bench_file(tmp_path, image):
    """Read a bench file: one board, or the text that is given after two."""

    def read(more="", *, boards=1):
        file = tmp_path / "my.toml"
        file.write_text((ONE if boards == 1 else TWO) + more)
        return open_bench(str(file))

    return read


@pytest.fixture
def emulate(bench_file, fake_maker):
    """Build a bench on which each board runs a program."""
    opened = []

    def build(*programs, more="", **options):
        machine_of = fake_maker(*programs)
        emulated = EmulatedBench(bench_file(more, boards=len(programs)), make_machine=machine_of, **options)
        opened.append(emulated)
        return emulated

    yield build
    for emulated in opened:
        emulated.close()
