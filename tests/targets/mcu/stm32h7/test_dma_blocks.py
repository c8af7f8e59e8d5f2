"""DMA1, DMA2 and DMAMUX1 of the STM32H753 as the chip has them: numbers of requests, interrupts, what they reach."""

from __future__ import annotations

import pytest

from targets.mcu.stm32.dma_requests import Requests
from targets.mcu.stm32h7.blocks import dma_controllers
from targets.mcu.stm32h7.dma_map import DMAMUX1
from targets.mcu.testing import FakeChip, peek, poke

PORT = 0x4000_4824
EN, TEIE, MINC = 1 << 0, 1 << 2, 1 << 10
TEIF, TCIF = 1 << 3, 1 << 5
# stm32h7xx_ll_dma.h: LL_DMAMUX1_REQ_...
NUMBERS = {
    "ADC1": 9,
    "ADC2": 10,
    "TIM1_CH1": 11,
    "TIM1_COM": 17,
    "TIM2_UP": 22,
    "TIM3_TRIG": 28,
    "TIM4_UP": 32,
    "I2C1_RX": 33,
    "I2C2_TX": 36,
    "USART1_RX": 41,
    "USART2_RX": 43,
    "USART2_TX": 44,
    "USART3_RX": 45,
    "USART3_TX": 46,
    "TIM8_COM": 53,
    "TIM5_TRIG": 60,
    "UART4_RX": 63,
    "UART5_TX": 66,
    "TIM6_UP": 69,
    "TIM7_UP": 70,
    "USART6_RX": 71,
    "I2C3_TX": 74,
    "UART7_RX": 79,
    "UART8_TX": 82,
    "TIM15_CH1": 105,
    "TIM17_UP": 112,
    "ADC3": 115,
}


@pytest.fixture
def rig():
    chip = FakeChip(480_000_000, {"AHB": 2})
    requests = Requests()
    for peripheral in dma_controllers(chip.services, requests):
        chip.add(peripheral).reset()
    for base in (0x0000_0000, 0x2000_0000, 0x2400_0000, 0x3000_0000, 0x3800_0000, PORT):
        chip.bus.load(base, b"\x11" * 0x20)
    chip.requests = requests
    chip.mux, *chip.dmas = chip._peripherals
    return chip


def test_numbers_of_requests():
    assert {name: number for number, name in DMAMUX1.items() if name in NUMBERS} == NUMBERS
    assert len(set(DMAMUX1.values())) == len(DMAMUX1)
    assert min(DMAMUX1) == 9
    assert max(DMAMUX1) == 115


def move(chip, controller, stream, memory, name="USART3_RX"):
    dma = chip.dmas[controller]
    poke(chip.mux, f"C{8 * controller + stream}CR", NUMBERS[name])
    poke(dma, f"S{stream}NDTR", 1)
    poke(dma, f"S{stream}PAR", PORT)
    poke(dma, f"S{stream}M0AR", memory)
    poke(dma, f"S{stream}CR", EN | TEIE | MINC)
    chip.requests.line(name).pulse()
    chip.advance(100)
    flags = peek(dma, "LISR" if stream < 4 else "HISR") >> (0, 6, 16, 22)[stream & 3]
    return flags & (TEIF | TCIF)


@pytest.mark.parametrize("memory", [0x2400_0000, 0x3000_0000, 0x3800_0000])
@pytest.mark.parametrize(("controller", "stream"), [(0, 0), (1, 2), (1, 7)])
def test_both_reach_the_memories_of_every_domain(rig, memory, controller, stream):
    assert move(rig, controller, stream, memory) == TCIF
    assert rig.bus.dump(memory, 2) == b"\x11\x11"
    assert not rig.noted("misuse")


@pytest.mark.parametrize(("memory", "name"), [(0x0000_0010, "ITCM"), (0x2000_0010, "DTCM")])
@pytest.mark.parametrize(("controller", "irq"), [(0, 12), (1, 57)])
def test_neither_reaches_the_memories_of_the_core(rig, memory, name, controller, irq):
    assert move(rig, controller, 1, memory) == TEIF
    assert rig.irq(irq).level
    assert not peek(rig.dmas[controller], "S1CR") & EN
    assert rig.noted("misuse") == [name]


def test_trbuff_is_kept_and_chsel_is_not_there(rig):
    poke(rig.dmas[0], "S0CR", 0xFFFF_FFFE)
    assert peek(rig.dmas[0], "S0CR") == 0x01FF_FFFE
