"""Timers, UARTs and the DAC of a whole high-density device, and how they are connected.

RM0008 tables 63 (interrupts), 82 and 86 (internal triggers), sections 9.3 (pins), 9.4.2 (TIM5CH4_IREMAP), 27 (UARTs).
"""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import pytest

from targets.boards import Board
from targets.firmware import image_path
from targets.mcu.image import limits_for, load_image
from targets.mcu.machine import Machine
from targets.mcu.serial_line import SerialFormat
from targets.mcu.testing import peek, poke

IMAGE = load_image(image_path("selftest-crc"), limits_for("STM32F103C8"))
AF, ANALOG = 0xB, 0x0
# From master to the slave's ITRx.
TRIGGERS = {
    "TIM1": ("TIM5", "TIM2", "TIM3", "TIM4"),
    "TIM2": ("TIM1", "TIM8", "TIM3", "TIM4"),
    "TIM3": ("TIM1", "TIM2", "TIM5", "TIM4"),
    "TIM4": ("TIM1", "TIM2", "TIM3", "TIM8"),
    "TIM5": ("TIM2", "TIM3", "TIM4", "TIM8"),
    "TIM8": ("TIM1", "TIM2", "TIM4", "TIM5"),
}


class Rig:
    """A device whose gates are all open, and whose program does not run."""

    def __init__(self, chip="STM32F103ZE"):
        self.machine = Machine(Board.from_mapping({"name": "big", "chip": chip, "hse_hz": 8_000_000}), IMAGE)
        self.chip = self.machine.chip
        poke(self.chip.rcc, "AHBENR", 0x557)
        poke(self.chip.rcc, "APB1ENR", 0x3AFE_C83F)
        poke(self.chip.rcc, "APB2ENR", 0xFFFD)

    def poke(self, where, value):
        name, register = where.split("_", 1)
        poke(self.chip.peripherals[name], register, value)

    def peek(self, where):
        name, register = where.split("_", 1)
        return peek(self.chip.peripherals[name], register)

    def mode(self, pin, nibble):
        port, number = self.chip.peripherals[f"GPIO{pin[1]}"], int(pin[2:])
        offset, shift = 4 * (number >= 8), 4 * (number & 7)
        port.write(offset, (port.read(offset) & ~(0xF << shift)) | nibble << shift)

    def advance(self, cycles):
        self.machine.time.run_due(self.machine.time.now + cycles)

    def pending(self):
        words = [self.machine.bus.read(0xE000_E200 + 4 * index, 4) for index in range(2)]
        return {32 * index + bit for index, word in enumerate(words) for bit in range(32) if word >> bit & 1}


@pytest.fixture
def rig():
    return Rig()


# --- timers


@pytest.mark.parametrize(
    ("slave", "select", "master"),
    [(slave, select, master) for slave, masters in TRIGGERS.items() for select, master in enumerate(masters)],
)
def test_internal_triggers(rig, slave, select, master):
    rig.poke(f"{slave}_SMCR", select << 4 | 7)
    rig.poke(f"{slave}_CR1", 1)
    for other in ("TIM1", "TIM2", "TIM3", "TIM4", "TIM5", "TIM8"):
        if other != slave:
            rig.poke(f"{other}_EGR", 1)  # MMS = 000: UG is put out
            rig.advance(4)
            assert rig.peek(f"{slave}_CNT") == (other == master)
            rig.poke(f"{slave}_CNT", 0)


@pytest.mark.parametrize(
    ("timer", "enable", "event", "number"),
    [
        ("TIM8", 0x80, 0x80, 43),
        ("TIM8", 0x01, 0x01, 44),
        ("TIM8", 0x40, 0x40, 45),
        ("TIM8", 0x20, 0x20, 45),
        ("TIM8", 0x02, 0x02, 46),
        ("TIM8", 0x10, 0x10, 46),
        ("TIM5", 0x01, 0x01, 50),
        ("TIM5", 0x10, 0x10, 50),
        ("TIM6", 0x01, 0x01, 54),
        ("TIM7", 0x01, 0x01, 55),
    ],
)
def test_interrupts(rig, timer, enable, event, number):
    rig.poke(f"{timer}_DIER", enable)
    rig.poke(f"{timer}_EGR", event)
    rig.advance(4)
    assert rig.pending() == {number}


@pytest.mark.parametrize("name", ["TIM6", "TIM7"])
def test_a_basic_timer_has_no_channels(rig, name):
    """Section 17.4."""
    for register, kept in (("CR1", 0x8F), ("CR2", 0x70), ("DIER", 0x101), ("PSC", 0xFFFF), ("ARR", 0xFFFF)):
        rig.poke(f"{name}_{register}", 0)
        rig.poke(f"{name}_{register}", 0xFFFF_FFFE)
        assert rig.peek(f"{name}_{register}") == kept & ~1, register
    assert {one.name for one in rig.chip.peripherals[name].registers.values()} == {
        *("CR1", "CR2", "DIER", "SR", "EGR", "CNT", "PSC", "ARR"),
    }


@pytest.mark.parametrize(
    ("signal", "pin"),
    [
        *((f"TIM5_CH{number}", f"PA{number - 1}") for number in range(1, 5)),
        *((f"TIM8_CH{number}", f"PC{number + 5}") for number in range(1, 5)),
        ("TIM8_CH1N", "PA7"),
        ("TIM8_CH2N", "PB0"),
        ("TIM8_CH3N", "PB1"),
    ],
)
def test_outputs_at_their_pins(rig, signal, pin):
    timer, channel = signal.split("_")
    number, complement = int(channel[2]) - 1, channel.endswith("N")
    mode = "CCMR1" if number < 2 else "CCMR2"
    rig.mode(pin, AF)
    rig.poke(f"{timer}_{mode}", 0x5050)  # OCxREF is high
    rig.poke(f"{timer}_CCER", (4 if complement else 1) << 4 * number)
    if timer == "TIM8":
        rig.poke("TIM8_BDTR", 0x8000)
    rig.advance(4)
    assert rig.chip.pins[pin].level is True
    rig.poke(f"{timer}_{mode}", 0x4040)
    rig.advance(4)
    assert rig.chip.pins[pin].level is False


@pytest.mark.parametrize(("timer", "pin"), [("TIM5", "PA3"), ("TIM8", "PC9")])
def test_inputs_at_their_pins(rig, timer, pin):
    rig.chip.pins[pin].drive(False)
    rig.poke(f"{timer}_CCMR2", 0x0100)
    rig.poke(f"{timer}_CCER", 0x1000)
    rig.poke(f"{timer}_CNT", 1234)
    rig.chip.pins[pin].drive(True)
    assert (rig.peek(f"{timer}_SR") & 0x10, rig.peek(f"{timer}_CCR4")) == (0x10, 1234)


def test_break_of_tim8(rig):
    """PA6; and the clock security system (section 14.3.12)."""
    rig.chip.pins["PA6"].drive(False)
    for broken in (lambda: rig.chip.pins["PA6"].drive(True), rig.chip.rcc.on_clock_failure):
        rig.poke("TIM8_BDTR", 0xB000)  # BKE, BKP high, MOE
        assert rig.peek("TIM8_BDTR") & 0x8000
        broken()
        assert not rig.peek("TIM8_BDTR") & 0x8000
        rig.chip.pins["PA6"].drive(False)


# --- TIM5 and the LSI


def test_channel_4_of_tim5_measures_the_lsi(rig):
    """40 kHz: 200 cycles of HSI between rising edges, whatever PA3 does."""
    rig.poke("RCC_CSR", 1)
    rig.advance(2000)
    rig.poke("AFIO_MAPR", 1 << 16)
    rig.poke("TIM5_CCMR2", 0x0100)
    rig.poke("TIM5_CCER", 0x1000)
    rig.poke("TIM5_CR1", 1)
    captures = []
    for _ in range(5):
        while not rig.peek("TIM5_SR") & 0x10:
            rig.chip.pins["PA3"].drive(bool(len(captures) & 1))
            rig.advance(10)
        captures.append(rig.peek("TIM5_CCR4"))
    assert {later - before for before, later in pairwise(captures)} == {200}
    rig.poke("RCC_CSR", 0)
    rig.advance(1000)
    rig.peek("TIM5_CCR4")
    rig.advance(1000)
    assert not rig.peek("TIM5_SR") & 0x10


def test_channel_4_of_tim5_comes_back_to_its_pin(rig):
    rig.chip.pins["PA3"].drive(False)
    rig.poke("AFIO_MAPR", 1 << 16)
    rig.poke("TIM5_CCMR2", 0x0100)
    rig.poke("TIM5_CCER", 0x1000)
    rig.chip.pins["PA3"].drive(True)
    assert not rig.peek("TIM5_SR") & 0x10
    rig.chip.pins["PA3"].drive(False)
    rig.poke("AFIO_MAPR", 0)
    rig.chip.pins["PA3"].drive(True)
    assert rig.peek("TIM5_SR") & 0x10


def test_the_remap_gives_the_level_that_is_there(rig):
    """An edge by the remap alone is one for who listens."""
    rig.chip.pins["PA3"].drive(True)
    rig.poke("TIM5_CCMR2", 0x0100)
    rig.poke("TIM5_CCER", 0x1000)
    rig.poke("AFIO_MAPR", 1 << 16)
    assert not rig.peek("TIM5_SR") & 0x10
    rig.poke("AFIO_MAPR", 0)
    assert rig.peek("TIM5_SR") & 0x10


# --- UART4, UART5


@pytest.mark.parametrize(("name", "pin", "number"), [("UART4", "PC10", 52), ("UART5", "PC12", 53)])
def test_a_uart_sends_and_receives_at_its_pins(rig, name, pin, number):
    usart = rig.chip.usarts[name]
    frames = []
    usart.on_frame = frames.append
    rig.mode(pin, AF)
    rig.poke(f"{name}_BRR", 16)
    rig.poke(f"{name}_CR1", 0x202C)  # UE, RXNEIE, TE, RE
    rig.advance(16 * 15)
    rig.poke(f"{name}_DR", 0xA5)
    rig.advance(16 * 12)
    assert [frame.bits & 0xFF for frame in frames] == [0xA5]
    now_s = rig.machine.time.seconds(rig.machine.time.now)
    usart.receive(SerialFormat.parse("8N1").frame(0x5A, now_s, Fraction(1, 500_000)))
    rig.advance(16 * 12)
    assert rig.pending() == {number}
    assert rig.peek(f"{name}_DR") == 0x5A


def test_bits_that_uarts_lack(rig):
    """Sections 27.2 and 27.6: no flow control, clock, smartcard mode, 0.5 and 1.5 stop bits; no DMA of UART5."""
    for name, cr3 in (("USART2", 0x7FF), ("UART4", 0xCF), ("UART5", 0x0F)):
        for register in ("CR2", "CR3", "GTPR"):
            rig.poke(f"{name}_{register}", 0xFFFF)
        kept = [rig.peek(f"{name}_{register}") for register in ("CR2", "CR3", "GTPR")]
        assert kept == ([0x7F6F, cr3, 0xFFFF] if name == "USART2" else [0x606F, cr3, 0x00FF])


def test_dma_serves_uart4(rig):
    """Table 79: channel 5 sends, channel 3 receives."""
    sent = []
    rig.chip.usarts["UART4"].on_frame = lambda frame: sent.append(frame.bits & 0xFF)
    rig.mode("PC10", AF)
    for index, byte in enumerate(b"dma2"):
        rig.machine.bus.write(0x2000_0000 + index, 1, byte)
    rig.poke("UART4_BRR", 16)
    rig.poke("UART4_CR3", 0x80)
    rig.poke("UART4_CR1", 0x2008)
    for register, value in (("CNDTR5", 4), ("CPAR5", 0x4000_4C04), ("CMAR5", 0x2000_0000), ("CCR5", 0x93)):
        rig.poke(f"DMA2_{register}", value)
    rig.advance(16 * 70)
    assert bytes(sent) == b"dma2"
    assert rig.pending() == {59}


# --- DAC


def test_tim6_and_dma2_play_a_table_on_pa4(rig):
    """What a sine by DMA is: TIM6 triggers, channel 3 of DMA2 brings the next word."""
    table = [0, 1000, 2000, 4095]
    for index, word in enumerate(table):
        rig.machine.bus.write(0x2000_0000 + 2 * index, 2, word)
    rig.mode("PA4", ANALOG)
    for register, value in (("CNDTR3", 4), ("CPAR3", 0x4000_7408), ("CMAR3", 0x2000_0000), ("CCR3", 0x5B1)):
        rig.poke(f"DMA2_{register}", value)
    rig.poke("DAC_CR", 0x1005)
    rig.poke("TIM6_CR2", 0x20)
    rig.poke("TIM6_ARR", 99)
    rig.poke("TIM6_CR1", 1)
    rig.advance(50)
    seen = []
    for _ in range(9):
        rig.advance(100)
        seen.append(round(rig.chip.pins["PA4"].volts * 4095 / 3.3))
    assert seen == [0, *table, *table]


def test_reset_of_the_peripheral_reaches_them(rig):
    rig.poke("DAC_DHR12R1", 5)
    rig.poke("TIM7_ARR", 5)
    rig.poke("UART5_BRR", 5)
    rig.poke("RCC_APB1RSTR", 1 << 29 | 1 << 5 | 1 << 20)
    assert [rig.peek(name) for name in ("DAC_DHR12R1", "TIM7_ARR", "UART5_BRR")] == [0, 0xFFFF, 0]


def test_a_converter_reads_what_the_dac_puts_out(rig):
    """PA4 is channel 4 of ADC1, PA5 channel 5."""
    rig.mode("PA4", ANALOG)
    rig.mode("PA5", ANALOG)
    rig.poke("DAC_CR", 1 << 16 | 1)
    rig.poke("ADC1_CR2", 1)
    for channel, word in ((4, 0), (5, 1), (4, 2048), (5, 4095)):
        rig.poke(f"DAC_DHR12R{channel - 3}", word)
        rig.advance(10_000)
        rig.poke("ADC1_SQR3", channel)
        rig.poke("ADC1_CR2", 0x001E_0001)
        rig.poke("ADC1_CR2", 0x005E_0001)
        rig.advance(1000)
        assert abs(rig.peek("ADC1_DR") - word) <= 1


def test_adc3_asks_dma2(rig):
    """Table 79: channel 5."""
    for register, value in (("CNDTR5", 4), ("CPAR5", 0x4001_3C4C), ("CMAR5", 0x2000_0000), ("CCR5", 0x581)):
        rig.poke(f"DMA2_{register}", value)
    rig.poke("ADC3_CR2", 0x101)
    rig.advance(10_000)
    rig.poke("ADC3_CR2", 0x001E_0101)
    rig.poke("ADC3_CR2", 0x005E_0101)
    rig.advance(1000)
    assert rig.peek("DMA2_CNDTR5") == 3


def test_spi3_asks_dma2(rig):
    """Table 79: channel 2 sends."""
    for register, value in (("CNDTR2", 3), ("CPAR2", 0x4000_3C0C), ("CMAR2", 0x2000_0000), ("CCR2", 0x91)):
        rig.poke(f"DMA2_{register}", value)
    rig.poke("SPI3_CR2", 2)
    rig.poke("SPI3_CR1", 0x344)
    rig.advance(1000)
    assert rig.peek("DMA2_CNDTR2") == 0
