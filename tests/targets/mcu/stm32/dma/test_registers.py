"""Registers, flags, interrupts and requests of the streams (RM0410 sections 8.3.3 and 8.5)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.stm32.dma import Dma
from targets.mcu.stm32.dma_requests import Channels, Requests
from targets.mcu.stm32f7.dma_map import DMA1, DMA2
from targets.mcu.testing import FakeChip, peek, poke
from tests.each import each

RAM, PORT = 0x2000_0000, 0x4001_0000
EN, DMEIE, TEIE, HTIE, TCIE, PFCTRL = (1 << bit for bit in range(6))
M2P, M2M, CIRC, PINC, MINC = 1 << 6, 2 << 6, 1 << 8, 1 << 9, 1 << 10
DBM, CT = 1 << 18, 1 << 19
FIFO = 0x25
ACCESS = 5 + 4  # cycles of AHB in the peripheral's access and the memory's


def test_reset_values(rig):
    for offset, register in rig.dma.registers.items():
        assert rig.dma.read(offset) == (0x21 if register.name.endswith("FCR") and register.name[0] == "S" else 0)


def test_it_is_made_as_it_is_after_a_reset():
    chip, requests = FakeChip(dividers={"AHB": 2}), Requests()
    sources = Channels(requests, {(0, 0): ("X",)})
    dma = Dma("DMA2", 0x4002_6400, chip.services, sources=sources, irqs=range(8), between_memories=True)
    chip.bus.load(RAM, bytes(4))
    assert peek(dma, "S0FCR") == 0x21
    for register, value in (("NDTR", 1), ("PAR", RAM), ("M0AR", RAM + 2), ("CR", EN | TCIE)):
        poke(dma, f"S0{register}", value)
    requests.line("X").pulse()
    chip.advance(100)
    assert chip.irq(0).rises == [2 * ACCESS]


@pytest.mark.parametrize("number", range(8))
def test_places_and_reserved_bits(rig, number):
    """RM0410 section 8.5.11, DMA register map."""
    base = 0x10 + 0x18 * number
    for offset, mask in ((4, 0xFFFF), (8, 0xFFFF_FFFF), (12, 0xFFFF_FFFF), (16, 0xFFFF_FFFF), (0, 0x1FEF_FFFE)):
        rig.dma.write(base + offset, 0xFFFF_FFFE)
        assert rig.dma.read(base + offset) == 0xFFFF_FFFE & mask
    rig.dma.write(base, 0)
    rig.dma.write(base + 20, 0xFFFF_FFFF)
    assert rig.dma.read(base + 20) == 0xA7


@given(
    number=st.integers(0, 7),
    flags=st.sets(st.sampled_from([0, 2, 3, 4, 5])),
    cleared=st.sets(st.sampled_from([0, 2, 3, 4, 5])),
)
def test_flags_stand_and_are_cleared_at_their_places(make_rig, number, flags, cleared):
    rig = make_rig()
    word, mask = (sum(1 << bit for bit in bits) for bits in (flags, cleared))
    for stream in range(8):
        rig.raise_flags(stream, 0x3D)
    for stream in range(8):
        rig.clear(stream, 0x3D & ~word)
    shift = (0, 6, 16, 22)[number % 4]
    low, high = rig.peek("LISR"), rig.peek("HISR")
    assert low == high == word | word << 6 | word << 16 | word << 22
    register, other = ("LIFCR", "HISR") if number < 4 else ("HIFCR", "LISR")
    rig.poke(register, mask << shift)
    assert rig.peek(register) == 0
    assert rig.peek("LISR" if number < 4 else "HISR") == low & ~(mask << shift)
    assert rig.peek(other) == low


@given(
    flag=st.sampled_from([(0, None), (2, 1), (3, 2), (4, 3), (5, 4)]),
    enables=st.integers(0, 15),
    fifo=st.booleans(),
)
def test_interrupts_are_levels(make_rig, flag, enables, fifo):
    rig = make_rig()
    bit, enable = flag
    rig.raise_flags(5, 1 << bit)
    rig.poke("S5CR", enables << 1)
    rig.poke("S5FCR", fifo << 7)
    assert rig.irq(5).level is (fifo if enable is None else bool(enables << 1 >> enable & 1))
    rig.poke("S5CR", 0)
    rig.poke("S5FCR", 0)
    assert not rig.irq(5).level


class TestProtection:
    @pytest.mark.parametrize("name", ["NDTR", "PAR", "M0AR", "M1AR"])
    def test_while_enabled(self, rig, name):
        rig.stream(3, EN, 7)
        before = rig.peek(f"S3{name}")
        rig.poke(f"S3{name}", 0x1234)
        assert rig.peek(f"S3{name}") == before
        assert rig.chip.noted("misuse") == [f"DMA2_S3{name}"]
        rig.poke("S3CR", 0)
        rig.poke(f"S3{name}", 0x1234)
        assert rig.peek(f"S3{name}") == 0x1234

    def test_of_control_bits(self, rig):
        rig.stream(3, EN, 7)
        rig.poke("S3CR", 0x1FEF_FFFF)
        assert rig.peek("S3CR") == EN | DMEIE | TEIE | HTIE | TCIE | 3 << 25
        rig.poke("S3FCR", 0x86)
        assert rig.peek("S3FCR") == 0xA1
        assert rig.chip.noted("misuse") == ["DMA2_S3CR", "DMA2_S3FCR"]

    def test_clearing_all_of_cr_is_no_misuse(self, rig):
        rig.stream(3, EN | MINC, 7)
        rig.poke("S3CR", 0)
        assert not rig.peek("S3CR") & EN
        assert rig.chip.noted() == []

    def test_what_hardware_forces(self, rig):
        """Direct mode has no bursts and one width; between memories there is no direct mode and no circle."""
        rig.stream(0, EN | 1 << 11 | 2 << 13 | 5 << 21, 4)
        assert rig.peek("S0CR") == EN | 1 << 11 | 1 << 13 | 3 << 25
        rig.stream(1, EN | DBM, 4)
        assert rig.peek("S1CR") & CIRC
        rig.stream(2, EN | PFCTRL | CIRC, 4)
        assert not rig.peek("S2CR") & CIRC
        rig.stream(4, EN | M2M | PFCTRL | CIRC, 4)
        assert rig.peek("S4CR") == EN | M2M | 3 << 25
        assert rig.peek("S4FCR") & 4


class TestRequests:
    def test_only_the_channel_that_is_selected(self, rig):
        rig.stream(2, EN | MINC, 10)
        rig.requests.line("X").set(True)
        rig.chip.advance(100)
        assert rig.peek("S2NDTR") == 10
        rig.serve(2, 3)
        assert rig.peek("S2NDTR") == 7

    def test_several_of_a_channel_are_ored(self, rig):
        rig.stream(2, EN | MINC, 10, channel=4)
        rig.requests.line("X").pulse()
        rig.chip.advance(100)
        rig.requests.line("Y").pulse()
        rig.chip.advance(100)
        assert rig.peek("S2NDTR") == 8

    def test_a_pulse_is_kept_until_it_is_served(self, rig):
        rig.serve(2)
        rig.stream(2, EN | MINC, 10)
        rig.chip.advance(100)
        assert rig.peek("S2NDTR") == 9
        rig.line(2).pulse()
        rig.line(2).set(False)
        rig.chip.advance(100)
        assert rig.peek("S2NDTR") == 9

    def test_a_level_is_served_while_it_lasts(self, rig):
        rig.stream(2, EN | MINC, 100)
        rig.line(2).set(True)
        rig.chip.advance(3 * 5)
        rig.line(2).set(False)
        rig.chip.advance(100)
        assert rig.peek("S2NDTR") == 97

    def test_of_nobody(self, rig):
        rig.requests.line("TIM9_UP").set(True)
        rig.requests.line("TIM9_UP").pulse()
        rig.requests.line("TIM9_UP").end()

    def test_nothing_without_a_clock(self, rig):
        rig.stream(2, EN | MINC, 10)
        rig.dma.clocked = False
        rig.serve(2)
        assert rig.peek("S2NDTR") == 10
        rig.dma.clocked = True
        rig.serve(2)
        assert rig.peek("S2NDTR") == 9


class TestMap:
    """RM0410 tables 27 and 28, and what rests on them: drivers that are known to work."""

    @each(
        ("table", "stream", "channel", "name"),
        [
            (DMA1, 1, 4, "USART3_RX"),
            (DMA1, 3, 4, "USART3_TX"),
            (DMA1, 4, 7, "USART3_TX"),
            (DMA1, 5, 4, "USART2_RX"),
            (DMA1, 6, 4, "USART2_TX"),
            (DMA1, 0, 1, "I2C1_RX"),
            (DMA1, 5, 1, "I2C1_RX"),
            (DMA1, 6, 1, "I2C1_TX"),
            (DMA1, 7, 1, "I2C1_TX"),
            (DMA1, 1, 3, "TIM2_UP"),
            (DMA1, 7, 3, "TIM2_UP"),
            (DMA1, 5, 2, "I2C4_TX"),
            (DMA2, 0, 0, "ADC1"),
            (DMA2, 4, 0, "ADC1"),
            (DMA2, 2, 1, "ADC2"),
            (DMA2, 0, 2, "ADC3"),
            (DMA2, 7, 4, "USART1_TX"),
            (DMA2, 5, 6, "TIM1_UP"),
            (DMA2, 2, 11, "QUADSPI"),
        ],
    )
    def test_places(self, table, stream, channel, name):
        assert name in table[stream, channel]

    def test_places_by_channel(self):
        """How many streams have a request on each channel."""
        by_channel = [[channel for _, channel in table].count for table in (DMA1, DMA2)]
        assert [by_channel[0](channel) for channel in range(12)] == [8, 7, 6, 6, 8, 8, 6, 7, 4, 2, 0, 0]
        assert [by_channel[1](channel) for channel in range(12)] == [8, 7, 7, 7, 7, 6, 7, 7, 8, 6, 4, 3]
        assert {stream for stream, _ in (*DMA1, *DMA2)} == set(range(8))
