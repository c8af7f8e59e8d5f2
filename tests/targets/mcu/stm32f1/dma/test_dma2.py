"""DMA2 of high-density devices: five channels, an interrupt that two of them share, and who asks for what.

RM0008 tables 63 and 79; what both controllers do alike is in `test_dma`.
"""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.boards import Board
from targets.firmware import image_path
from targets.mcu.image import limits_for, load_image
from targets.mcu.machine import Machine
from targets.mcu.stm32f1.dma import CONTROLLERS, Dma
from targets.mcu.testing import FakeChip, peek, poke

RAM, PORT = 0x2000_0000, 0x4001_0000
EN, TCIE, MINC, MEM2MEM = 1 << 0, 1 << 1, 1 << 7, 1 << 14
TABLE = {
    1: "SPI3_RX TIM5_CH4 TIM5_TRIG TIM8_CH3 TIM8_UP",
    2: "SPI3_TX TIM5_CH3 TIM5_UP TIM8_CH4 TIM8_TRIG TIM8_COM",
    3: "UART4_RX TIM6_UP DAC_CH1 TIM8_CH1",
    4: "SDIO TIM5_CH2 TIM7_UP DAC_CH2",
    5: "ADC3 UART4_TX TIM5_CH1 TIM8_CH2",
}


class Rig:
    def __init__(self):
        self.chip = FakeChip(72_000_000)
        self.dma = self.chip.add(Dma("DMA2", 0x4002_0400, self.chip.services))
        self.dma.reset()
        self.chip.bus.load(RAM, bytes(0x100))
        self.chip.bus.load(PORT, bytes(range(1, 0x81)))

    def channel(self, number, control, count=2):
        for name, value in (("CNDTR", count), ("CPAR", PORT), ("CMAR", RAM + 16 * number), ("CCR", control)):
            poke(self.dma, f"{name}{number}", value)

    def levels(self):
        return [self.chip.irq(number).level for number in range(55, 62)]


@pytest.fixture
def rig():
    return Rig()


def test_there_are_five_channels(rig):
    names = {register.name for register in rig.dma.registers.values()}
    assert names == {"ISR", "IFCR"} | {f"{name}{n}" for n in range(1, 6) for name in ("CCR", "CNDTR", "CPAR", "CMAR")}
    rig.dma[0x00] = 0xE_EEEE
    assert peek(rig.dma, "ISR") == 0xF_FFFF
    poke(rig.dma, "IFCR", 0xFFFF_FFFF)
    assert peek(rig.dma, "ISR") == 0
    rig.dma.write(0x6C, 0xFFFF_FFFF)  # where a sixth would be
    assert rig.dma.read(0x6C) == 0
    assert rig.chip.noted("reserved") == ["DMA2_0x6C"]


@pytest.mark.parametrize(("number", "name"), [(n, name) for n, names in TABLE.items() for name in names.split()])
def test_a_request_moves_the_data_of_its_channel_alone(rig, number, name):
    for one in TABLE:
        rig.channel(one, EN | MINC)
    rig.dma.request(name).pulse()
    rig.chip.advance(20)
    assert [peek(rig.dma, f"CNDTR{one}") for one in TABLE] == [1 if one == number else 2 for one in TABLE]
    assert rig.dma.serves(name)


def test_no_request_is_at_both_controllers():
    names = [name for one in CONTROLLERS.values() for at_channel in one.requests.values() for name in at_channel]
    assert len(names) == len(set(names))


@pytest.mark.parametrize(("number", "line"), [(1, 1), (2, 2), (3, 3), (4, 4), (5, 4)])
def test_each_channel_has_its_interrupt(rig, number, line):
    """Table 63: 56 to 59, of which the last is for channels 4 and 5."""
    rig.channel(number, EN | TCIE | MEM2MEM)
    rig.chip.advance(20)
    assert rig.levels() == [index == line for index in range(7)]
    poke(rig.dma, "IFCR", 0xF << 4 * (number - 1))
    assert not any(rig.levels())


@given(flags=st.integers(0, 7), enables=st.integers(0, 7), others=st.integers(0, 7), cleared=st.booleans())
def test_the_shared_interrupt_is_high_while_either_asks(flags, enables, others, cleared):
    rig = Rig()
    poke(rig.dma, "CCR4", enables << 1)
    poke(rig.dma, "CCR5", 7 << 1)
    rig.dma[0x00] = flags << 13 | others << 17
    poke(rig.dma, "CCR5", 7 << 1)
    assert rig.chip.irq(59).level is bool(flags & enables or others)
    poke(rig.dma, "IFCR", 0xF0000 if cleared else 0xF000)
    assert rig.chip.irq(59).level is bool(flags & enables if cleared else others)


def test_requests_of_the_chip_reach_their_controller():
    """Each request of a peripheral goes to the controller that serves it; on a real core the interrupt is in C."""
    image = load_image(image_path("selftest-crc"), limits_for("STM32F103C8"))
    machine = Machine(Board.from_mapping({"name": "big", "chip": "STM32F103ZE"}), image)
    chip = machine.chip
    poke(chip.rcc, "AHBENR", 0x17)
    dma1, dma2 = chip.peripherals["DMA1"], chip.peripherals["DMA2"]
    for dma in (dma1, dma2):
        for number in (3, 4):
            for name, value in (("CNDTR", 2), ("CPAR", RAM), ("CMAR", RAM + 64), ("CCR", EN | TCIE)):
                poke(dma, f"{name}{number}", value)
    for name in ("UART4_RX", "SPI1_TX", "DAC_CH2", "USART1_TX"):
        chip.services.dma(name).pulse()
        machine.time.run_due(machine.time.now + 100)
    assert [peek(dma, f"CNDTR{number}") for dma in (dma1, dma2) for number in (3, 4)] == [1, 1, 1, 1]
    chip.services.dma("DAC_CH2").pulse()
    machine.time.run_due(machine.time.now + 100)
    assert machine.bus.read(0xE000_E204, 4) == 1 << 59 - 32  # pending: 59
