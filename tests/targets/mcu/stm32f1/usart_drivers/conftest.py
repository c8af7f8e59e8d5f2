"""A chip with USARTs and DMA1, and a CPU that is Python: each access to a register takes time, interrupts interrupt."""

from __future__ import annotations

import dataclasses
from fractions import Fraction

import pytest

from targets.mcu.serial_line import SerialFormat
from targets.mcu.stm32f1.dma import Dma
from targets.mcu.stm32f1.usart import Usart
from targets.mcu.testing import FakeChip, peek, poke

RAM = 0x2000_0000
SITES = {"USART1": (0x4001_3800, "APB2", 37), "USART2": (0x4000_4400, "APB1", 38), "USART3": (0x4000_4800, "APB1", 39)}


class Cpu:
    """Runs drivers written as Python functions on a chip in a test tube.

    Attributes:
        access_cycles: what an access to a register costs, with the instructions around it.
        handlers: interrupt handlers by number; they do not nest.
    """

    def __init__(self, hclk_hz=72_000_000, apb1=2, access_cycles=8):
        self.chip = FakeChip(hclk_hz, {"APB1": apb1})
        self.dma = Dma("DMA1", 0x4002_0000, self.chip.services)
        self.chip.add(self.dma)
        services = dataclasses.replace(self.chip.services, dma=self.dma.request)
        self.usarts = {
            name: self.chip.add(Usart(name, base, services, bus=bus, irq=irq))
            for name, (base, bus, irq) in SITES.items()
        }
        for peripheral in (self.dma, *self.usarts.values()):
            peripheral.reset()
        self.chip.bus.load(RAM, bytes(0x4000))
        self.access_cycles = access_cycles
        self.handlers = {}
        self._in_handler = False

    def wait(self, cycles):
        """Let cycles pass, in the way that a loop of instructions does."""
        end = self.chip.time.now + cycles
        while self.chip.time.now < end:
            self.chip.advance(min(self.access_cycles, end - self.chip.time.now))
            self._take_interrupts()

    def wait_for(self, condition, cycles=5_000_000):
        end = self.chip.time.now + cycles
        while not condition():
            assert self.chip.time.now < end, "waited too long"
            self.wait(self.access_cycles)

    def read(self, peripheral, register):
        self.wait(self.access_cycles)
        return peek(peripheral, register)

    def write(self, peripheral, register, value):
        self.wait(self.access_cycles)
        poke(peripheral, register, value)

    def _take_interrupts(self):
        if self._in_handler:
            return
        self._in_handler = True
        for number in sorted(self.handlers):
            if self.chip.irq(number).level:
                self.chip.advance(12)
                self.handlers[number]()
        self._in_handler = False


class Registers:
    """``registers.SR``: a peripheral as a driver in C sees it."""

    def __init__(self, cpu, peripheral):
        object.__setattr__(self, "_cpu", cpu)
        object.__setattr__(self, "_peripheral", peripheral)

    def __getattr__(self, name):
        return self._cpu.read(self._peripheral, name)

    def __setattr__(self, name, value):
        self._cpu.write(self._peripheral, name, value & 0xFFFF_FFFF)


class FarEnd:
    """What is at the other end of the line: it keeps what it hears, and talks at its own pace.

    Attributes:
        heard: the bytes, by what the frames carry.
        breaks: how many breaks there were among them.
        last_end: the cycle at which the last frame ends.
    """

    def __init__(self, cpu, usart, baud, line_format):
        self.chip, self.usart = cpu.chip, usart
        self.format = SerialFormat.parse(line_format)
        self.bit_s = Fraction(1, baud)
        self.heard = bytearray()
        self.breaks = 0
        self.last_end = 0
        self.echoes = False
        usart.on_frame = self._hear

    def _hear(self, frame):
        assert frame.start_s == self.chip.time.seconds(self.chip.time.now)
        self.last_end = self.chip.time.cycle_at(frame.end_s)
        if frame.is_break:
            self.breaks += 1
            return
        assert (frame.bit_count, frame.stop_half_bits) == (self.format.word_bits, self.format.stop_half_bits)
        assert not self.format.parity_wrong(frame.bits)
        self.heard.append(self.format.value(frame.bits) & 0xFF)
        if self.echoes:
            self.chip.time.at(self.last_end + 1, lambda: self.say(bytes([self.format.value(frame.bits)])))

    def say(self, data, *, pause_bits=0, after_bits=0):
        """Send bytes back to back or with pauses, from now (or a little later) on."""
        at_s = self.chip.time.seconds(self.chip.time.now) + after_bits * self.bit_s
        for value in data:
            frame = self.format.frame(value, at_s, self.bit_s)
            self.chip.time.at(self.chip.time.cycle_at(at_s), lambda frame=frame: self.usart.receive(frame))
            at_s = frame.end_s + pause_bits * self.bit_s
        return self.chip.time.cycle_at(at_s)


@pytest.fixture(scope="session")
def make_board():
    """``make_board(name, baud, format)``: a CPU, the registers of a USART and of DMA1, and the far end of the line."""

    def make(name="USART1", baud=115200, line_format="8N1", **how):
        cpu = Cpu(**how)
        usart = cpu.usarts[name]
        return cpu, Registers(cpu, usart), Registers(cpu, cpu.dma), FarEnd(cpu, usart, baud, line_format)

    return make
