"""What the test tubes of USARTs of all generations have in common: registers, time, and the far end of the line."""

from __future__ import annotations

from fractions import Fraction

from targets.mcu.serial_line import SerialFormat, SerialFrame
from targets.mcu.testing import peek, poke


class BasicPort:
    """A USART on a chip, what it has sent as (cycle, frame), and its lines.

    A subclass has `bit`: HCLK cycles of a bit.
    """

    def __init__(self, chip, usart, irq):
        self.chip = chip
        self.usart = chip.add(usart)
        self.usart.reset()
        self.sent = []
        self.usart.on_frame = lambda frame: self.sent.append((self.chip.time.now, frame))
        name = usart.name
        self.irq = chip.irq(irq)
        self.dma_tx, self.dma_rx = chip.dma(f"{name}_TX"), chip.dma(f"{name}_RX")
        self.tx, self.rts = chip.output(f"{name}_TX"), chip.output(f"{name}_RTS")
        self.rx, self.cts = chip.input(f"{name}_RX"), chip.input(f"{name}_CTS")

    # --- registers

    def peek(self, register):
        return peek(self.usart, register)

    def poke(self, register, value):
        poke(self.usart, register, value)

    def set(self, register, bits):
        self.poke(register, self.peek(register) | bits)

    def clear(self, register, bits):
        self.poke(register, self.peek(register) & ~bits)

    # --- time

    @property
    def now(self):
        return self.chip.time.now

    def bits(self, count):
        """Let so many bit times pass."""
        self.chip.advance(Fraction(count) * self.bit // 1)

    # --- the far end

    @property
    def values(self):
        """The bits that were sent."""
        return [frame.bits for _, frame in self.sent]

    def frame(self, value, *, bit_s=None, like=None, start_s=None, **changes):
        """Return a frame that starts now, as this USART would send it unless said otherwise."""
        bit_s = Fraction(bit_s or self.bit / self.chip.time.hclk_hz)
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
