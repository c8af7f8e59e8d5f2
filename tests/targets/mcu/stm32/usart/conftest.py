"""A USART of the STM32F7 on a chip in a test tube, and the far end of its line."""

from __future__ import annotations

from fractions import Fraction

import pytest

from targets.mcu.serial_line import SerialFormat, SerialFrame
from targets.mcu.stm32.usart import Usart
from targets.mcu.testing import FakeChip, peek, poke

UE, RE, TE, OVER8 = 1 << 0, 1 << 2, 1 << 3, 1 << 15


class Port:
    """USART3 with its kernel clock from HCLK / `divider` or at `kernel_hz`, and what it has sent as (cycle, frame)."""

    def __init__(self, hclk_hz=216_000_000, divider=4, kernel_hz=None, name="USART3"):
        self.chip = FakeChip(hclk_hz, {"APB1": divider})
        self.kernel_hz = kernel_hz
        self.usart = self.chip.add(Usart(name, 0x4000_4800, self.chip.services, irq=39, kernel_hz=self.kernel))
        self.usart.reset()
        self.sent = []
        self.words = []
        self.usart.on_frame = lambda frame: self.sent.append((self.chip.time.now, frame))
        self.usart.on_word = lambda data, errors: self.words.append((data, errors))
        self.irq = self.chip.irq(39)
        self.dma_tx, self.dma_rx = self.chip.dma(f"{name}_TX"), self.chip.dma(f"{name}_RX")
        self.tx, self.rts = self.chip.output(f"{name}_TX"), self.chip.output(f"{name}_RTS")
        self.tx_at_rx = self.chip.output(f"{name}_RX")
        self.rx, self.cts = self.chip.input(f"{name}_RX"), self.chip.input(f"{name}_CTS")
        self.rx_at_tx = self.chip.input(f"{name}_TX")

    def kernel(self):
        if self.kernel_hz is not None:
            return Fraction(self.kernel_hz)
        divider = self.chip.clocks.dividers["APB1"]
        return self.chip.time.hclk_hz / divider if divider else Fraction(0)

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
        """ISR without CTS, TEACK and REACK."""
        return self.peek("ISR") & ~0x0060_0400

    def open(self, brr=16, cr1=TE | RE, cr2=0, cr3=0, *, rtor=0, past_preamble=True):
        """Enable it (8N1 and both directions unless said otherwise), and let the preamble pass."""
        self.poke("BRR", brr)
        self.poke("CR2", cr2)
        self.poke("CR3", cr3)
        self.poke("RTOR", rtor)
        self.poke("CR1", cr1 & ~(TE | RE))
        self.poke("CR1", cr1 | UE)
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
        return self.chip.time.hclk_hz / self.usart.baud_hz

    def bits(self, count):
        """Let so many bit times pass."""
        self.chip.advance(int(Fraction(count) * self.bit))

    # --- the far end

    @property
    def values(self):
        """The bits that were sent."""
        return [frame.bits for _, frame in self.sent]

    def frame(self, value, *, bit_s=None, like=None, start_s=None, **changes):
        """Return a frame that starts now, as this USART would send it unless said otherwise."""
        bit_s = Fraction(bit_s or 1 / self.usart.baud_hz)
        line_format = SerialFormat.parse(like) if like else self.usart.format
        start_s = self.chip.time.seconds(self.now) if start_s is None else start_s
        frame = line_format.frame(value, start_s, bit_s)
        fields = {name: getattr(frame, name) for name in ("start_s", "bit_s", "bits", "bit_count", "stop_half_bits")}
        return SerialFrame(**(fields | changes))

    def hear(self, value, *, wait=True, **how):
        """Let a frame come in, and pass unless told not to wait."""
        frame = self.frame(value, **how)
        self.usart.receive(frame)
        if wait:
            self.chip.advance_to(self.chip.time.cycle_at(frame.end_s))
        return frame

    def hear_all(self, *frames):
        """Let frames come in, each at its start, and pass."""
        for frame in frames:
            self.chip.advance_to(max(self.now, self.chip.time.cycle_at(frame.start_s)))
            self.usart.receive(frame)
        self.chip.advance_to(self.chip.time.cycle_at(frames[-1].end_s))


@pytest.fixture(scope="session")
def make_port():
    """The class: ``make_port(hclk_hz, divider, kernel_hz)``."""
    return Port


@pytest.fixture
def port():
    """At 216 MHz and a kernel clock of 54 MHz, just out of reset."""
    return Port()


@pytest.fixture
def open_port():
    """At 3.375 MBaud, 8N1, past its preamble."""
    return Port().open()
