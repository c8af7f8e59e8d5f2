"""A USART on a chip in a test tube, and the far end of its line."""

from __future__ import annotations

from fractions import Fraction

import pytest

from targets.mcu.serial_line import SerialFormat, SerialFrame
from targets.mcu.stm32f1.usart import Usart
from targets.mcu.testing import FakeChip, peek, poke

SITES = {"USART1": (0x4001_3800, "APB2", 37), "USART2": (0x4000_4400, "APB1", 38), "USART3": (0x4000_4800, "APB1", 39)}


class Port:
    """A USART, what it has sent as (cycle, frame), and its lines."""

    def __init__(self, hclk_hz=72_000_000, dividers=None, name="USART1", chip=None):
        base, bus, irq = SITES[name]
        self.chip = chip or FakeChip(hclk_hz, dividers)
        self.usart = self.chip.add(Usart(name, base, self.chip.services, bus=bus, irq=irq))
        self.usart.reset()
        self.divider = self.chip.clocks.dividers[bus]
        self.sent = []
        self.usart.on_frame = lambda frame: self.sent.append((self.chip.time.now, frame))
        self.irq = self.chip.irq(irq)
        self.dma_tx, self.dma_rx = self.chip.dma(f"{name}_TX"), self.chip.dma(f"{name}_RX")
        self.tx, self.rts = self.chip.output(f"{name}_TX"), self.chip.output(f"{name}_RTS")
        self.rx, self.cts = self.chip.input(f"{name}_RX"), self.chip.input(f"{name}_CTS")

    # --- registers

    def peek(self, register):
        return peek(self.usart, register)

    def poke(self, register, value):
        poke(self.usart, register, value)

    def set(self, register, bits):
        self.poke(register, self.peek(register) | bits)

    def clear(self, register, bits):
        self.poke(register, self.peek(register) & ~bits)

    @property
    def flags(self):
        """SR without the side effect of reading it."""
        return self.usart[0x00]

    def open(self, brr=16, cr1=0x200C, cr2=0, cr3=0, *, past_preamble=True):
        """Enable it (8N1 and both directions unless said otherwise), and let the preamble pass."""
        self.poke("BRR", brr)
        self.poke("CR2", cr2)
        self.poke("CR3", cr3)
        self.poke("CR1", cr1)
        if past_preamble:
            self.bits(15)
        return self

    # --- time

    @property
    def now(self):
        return self.chip.time.now

    @property
    def bit(self):
        """HCLK cycles of a bit."""
        return self.peek("BRR") * self.divider

    def bits(self, count):
        """Let so many bit times pass."""
        self.chip.advance(Fraction(count) * self.bit // 1)

    # --- the far end

    @property
    def values(self):
        """The data that was sent."""
        return [frame.bits for _, frame in self.sent]

    def frame(self, value, *, bit_s=None, like=None, **changes):
        """Return a frame that starts now, as this USART would send it unless said otherwise."""
        bit_s = bit_s or self.bit / self.chip.time.hclk_hz
        line_format = SerialFormat.parse(like) if like else self.usart.format
        frame = line_format.frame(value, self.chip.time.seconds(self.now), Fraction(bit_s))
        if not changes:
            return frame
        fields = {name: getattr(frame, name) for name in ("start_s", "bit_s", "bits", "bit_count", "stop_half_bits")}
        return SerialFrame(**(fields | changes))

    def hear(self, value, *, wait=True, **how):
        """Let a frame come in, and pass unless told not to wait."""
        frame = self.frame(value, **how)
        self.usart.receive(frame)
        if wait:
            self.chip.advance_to(self.chip.time.cycle_at(frame.end_s))
        return frame


@pytest.fixture(scope="session")
def make_port():
    """The class: ``make_port(hclk_hz, dividers, name)``."""
    return Port


@pytest.fixture
def port():
    """USART1 at 72 MHz, just out of reset."""
    return Port()


@pytest.fixture
def open_port():
    """USART1 at 72 MHz, 4.5 MBaud, 8N1, past its preamble."""
    return Port().open()
