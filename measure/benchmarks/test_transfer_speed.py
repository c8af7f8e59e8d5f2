"""How fast an STM32F103 is while converters and SPI move items by DMA at their highest rates and its program sleeps.

The registers are written from outside, so that what is measured is the chip alone. The figures are of CPU time and are
printed; nothing is asserted on time. Run by `make bench`.
"""

from __future__ import annotations

import time

import pytest

from targets.firmware import image_path
from targets.mcu.image import limits_for, load_image
from targets.mcu.machine import Machine
from targets.mcu.nets import Net
from targets.parts.testing import PartBench
from targets.parts.w25q import W25q
from targets.parts.w25q.w25q import W25qSettings
from tests.targets.firmware.high_density import HIGH_DENSITY

MS = 1_000_000
UP_MS, BLOCK_MS, BLOCKS = 10, 5, 3
DMA1, DMA2, RCC, GPIOA, SPI1, ADC1 = 0x4002_0000, 0x4002_0400, 0x4002_1000, 0x4001_0800, 0x4001_3000, 0x4001_2400
TIM6, DAC = 0x4000_1000, 0x4000_7400
RING, ITEMS = 0x2000_4000, 1024  # above what the program has
TO_MEMORY, FROM_MEMORY = 0x0A1, 0x0B1  # CCR: enabled, round and round, along memory
BYTES, HALVES, WORDS = 0x000, 0x500, 0xA00


class Chip:
    """A chip of high density at 72 MHz, whose program sleeps but for a tick of 1 kHz."""

    def __init__(self):
        self.machine = Machine(HIGH_DENSITY, load_image(image_path("bench-tick-1khz"), limits_for(HIGH_DENSITY.chip)))
        self.machine.run_to(UP_MS * MS)
        self.poke((RCC + 4, self.machine.bus.read(RCC + 4, 4) | 2 << 14))  # ADCCLK is 12 MHz
        self.poke((RCC + 0x14, 0x17), (RCC + 0x18, 0x1205), (RCC + 0x1C, 0x2000_0010))  # both DMA, ADC1, SPI1, A, DAC

    def poke(self, *writes):
        for address, value in writes:
            self.machine.bus.write(address, 4, value)

    def channel(self, controller, number, register, control, memory=RING):
        at = controller + 0x14 * number - 0x14
        self.poke((at + 0x0C, ITEMS), (at + 0x10, register), (at + 0x14, memory), (at + 0x08, control))

    def wait(self, ns):
        self.machine.run_to(self.machine.now_ns + ns)


class Asked:
    """A slave that has to be asked for each byte."""

    modes = frozenset({0, 3})
    releases = 0

    def selected(self, _now_ns):
        return True

    def exchange(self, byte, _now_ns):
        return byte

    def answer(self):
        return 0xFF


class Display(Asked):
    """One that takes all and answers nothing."""

    def __init__(self):
        self.shown = bytearray()

    def exchange(self, byte, _now_ns):
        self.shown.append(byte)
        return 0xFF

    def promise(self, most):
        return b"\xff" * most

    def take(self, data, _now_ns):
        self.shown += data


def converts_to_memory(chip, way=""):
    """ADC1 at 12 MHz, 857 143 conversions a second, of two channels."""
    chip.poke((GPIOA, 0x4444_4400))
    for pin in ("PA0", "PA1"):
        if way == "ramp":
            chip.machine.chip.pins[pin].drive_ramp(0.0, 3.3, in_ns=1000 * MS)
        else:
            chip.machine.chip.pins[pin].drive_volts(1.0)
    chip.channel(DMA1, 1, ADC1 + 0x4C, TO_MEMORY | HALVES)
    chip.poke((ADC1 + 4, 1 << 8), (ADC1 + 0x2C, 1 << 20), (ADC1 + 0x34, 1 << 5), (ADC1 + 8, 1))
    chip.wait(2000)
    chip.poke((ADC1 + 8, 0x1E_0103), (ADC1 + 8, 0x5E_0103))


def shifts(chip, way=""):
    """SPI1 at 18 Mbit/s, 2 250 000 bytes a second each way."""
    chip.poke((GPIOA, 0xB4B4_4444))
    if way == "looped":
        Net("loop", (chip.machine.chip.pins["PA6"], chip.machine.chip.pins["PA7"]), None)
    elif way == "flash":
        bench = PartBench(W25q, W25qSettings())
        bench.wires["cs"].set(False, 0)
        slave = bench.part.spi_slave("spi")
        for byte in (0x03, 0, 0, 0):
            slave.selected(0)
            slave.exchange(byte, 0)
        chip.machine.chip.spis["SPI1"].bus.attach(slave)
    elif way == "asked":
        chip.machine.chip.spis["SPI1"].bus.attach(Asked())
    elif way == "display":
        chip.machine.chip.spis["SPI1"].bus.attach(Display())
    chip.channel(DMA1, 2, SPI1 + 0x0C, TO_MEMORY | BYTES)
    chip.channel(DMA1, 3, SPI1 + 0x0C, FROM_MEMORY | BYTES, RING + 0x1000)
    chip.poke((SPI1 + 4, 3), (SPI1, 0x34C))


def puts_out(chip, rate):
    """Channel 1 of the DAC, triggered by TIM6."""
    chip.poke((GPIOA, 0x4440_4444))
    chip.channel(DMA2, 3, DAC + 0x08, FROM_MEMORY | WORDS)
    chip.poke((DAC, 0x1005), (TIM6 + 0x2C, 72_000_000 // rate - 1), (TIM6 + 4, 0x20), (TIM6, 1))


@pytest.mark.parametrize(
    ("what", "how", "per_s"),
    [
        (converts_to_memory, "", 857_143),
        (converts_to_memory, "ramp", 857_143),
        (shifts, "", 2_250_000),
        (shifts, "asked", 2_250_000),
        (shifts, "flash", 2_250_000),
        (shifts, "display", 2_250_000),
        (shifts, "looped", 2_250_000),
        (puts_out, 32_000, 32_000),
        (puts_out, 500_000, 500_000),
    ],
)
def test_items_by_dma(what, how, per_s, say):
    chip = Chip()
    what(chip, how)
    best_s = 1e9
    for _ in range(BLOCKS):
        began = time.process_time()
        chip.wait(BLOCK_MS * MS)
        best_s = min(best_s, time.process_time() - began)
    factor = BLOCK_MS / 1000 / best_s
    say(f"{what.__name__} {how}: {factor:.3f} x real time, {factor * per_s:.0f} items a second")
    assert not chip.machine.notes.all
