"""A USART of the STM32F7 or H7 on a chip in a test tube, and the far end of its line."""

from __future__ import annotations

from fractions import Fraction
from functools import partial

import pytest

from targets.mcu.stm32.usart import Usart
from targets.mcu.stm32.usart_fifo import FifoUsart
from targets.mcu.testing import FakeChip
from tests.targets.mcu.stm32.usart.port import BasicPort

UE, RE, TE, OVER8 = 1 << 0, 1 << 2, 1 << 3, 1 << 15


class Port(BasicPort):
    """USART3 with its kernel clock from HCLK / `divider` or at `kernel_hz`, and what it has sent as (cycle, frame)."""

    make_usart = Usart

    def __init__(self, hclk_hz=216_000_000, divider=4, kernel_hz=None, name="USART3"):
        chip = FakeChip(hclk_hz, {"APB1": divider})
        self.chip, self.kernel_hz = chip, kernel_hz
        super().__init__(chip, self.make_usart(name, 0x4000_4800, chip.services, irq=39, kernel_hz=self.kernel), 39)
        self.words = []
        self.usart.on_word = lambda data, errors: self.words.append((data, errors))
        self.tx_at_rx = chip.output(f"{name}_RX")
        self.rx_at_tx = chip.input(f"{name}_TX")

    def kernel(self):
        if self.kernel_hz is not None:
            return Fraction(self.kernel_hz)
        divider = self.chip.clocks.dividers["APB1"]
        return self.chip.time.hclk_hz / divider if divider else Fraction(0)

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

    @property
    def bit(self):
        """HCLK cycles of a bit."""
        return self.chip.time.hclk_hz / self.usart.baud_hz

    def hear_all(self, *frames):
        """Let frames come in, each at its start, and pass."""
        for frame in frames:
            self.chip.advance_to(max(self.now, self.chip.time.cycle_at(frame.start_s)))
            self.usart.receive(frame)
        self.chip.advance_to(self.chip.time.cycle_at(frames[-1].end_s))


class FifoPort(Port):
    """A USART that could have FIFOs."""

    make_usart = FifoUsart


class PlainPort(FifoPort):
    """A UART that could have FIFOs; without smartcard mode its flags after a reset are those of the F7."""

    make_usart = staticmethod(partial(FifoUsart, synchronous=False))


@pytest.fixture(scope="session", params=[Port, PlainPort], ids=["F7", "H7"])
def make_port(request):
    """The class: ``make_port(hclk_hz, divider, kernel_hz)``; with FIFOEN clear both generations are alike."""
    return request.param


@pytest.fixture
def port(make_port):
    """At 216 MHz and a kernel clock of 54 MHz, just out of reset."""
    return make_port()


@pytest.fixture
def open_port(make_port):
    """At 3.375 MBaud, 8N1, past its preamble."""
    return make_port().open()


@pytest.fixture(scope="session")
def make_fifo_port():
    """The class of USARTs with FIFOs: ``make_fifo_port(hclk_hz, divider, kernel_hz)``."""
    return FifoPort
