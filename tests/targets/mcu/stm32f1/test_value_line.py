"""The STM32F100: what it has, its clocks, and how TIM12 to TIM17 and the DAC are connected.

RM0041: tables 3 and 50, sections 6.3 (RCC), 7.4.7 (AFIO_MAPR2), 11 (DAC); DS5944.
"""

from __future__ import annotations

import pytest

from targets.boards import Board
from targets.firmware import image_path
from targets.mcu.errors import BusFault
from targets.mcu.fidelity import Fidelity
from targets.mcu.image import limits_for, load_image
from targets.mcu.machine import Machine
from targets.mcu.stm32f1.request_choice import RequestChoice
from targets.mcu.testing import peek, poke
from targets.mcu.variants import VARIANTS
from tests.each import each

IMAGE = load_image(image_path("selftest-crc"), limits_for("STM32F103C8"))
CHIPS = [name for name in VARIANTS if name.startswith("STM32F100")]
AF = 0xB


class Rig:
    """A device whose gates are all open, and whose program does not run."""

    def __init__(self, chip="STM32F100RB"):
        self.machine = Machine(Board.from_mapping({"name": "value", "chip": chip, "hse_hz": 8_000_000}), IMAGE)
        self.chip = self.machine.chip
        for register in ("AHBENR", "APB1ENR", "APB2ENR"):
            poke(self.chip.rcc, register, 0xFFFF_FFFF)

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

    def noted(self, kind):
        return [note.where for note in self.machine.notes.all if note.kind == kind]


@pytest.fixture
def rig():
    return Rig()


@pytest.fixture
def big():
    return Rig("STM32F100ZE")


@each("name", CHIPS)
def test_memory_and_package(name):
    """DS5944, device summary; RM0041 section 2.3.3."""
    variant, limits = VARIANTS[name], limits_for(name)
    low_and_medium = {"4": (16, 4), "6": (32, 4), "8": (64, 8), "B": (128, 8)}
    kb = (low_and_medium | {"C": (256, 24), "D": (384, 32), "E": (512, 32)})[name[-1]]
    assert (variant.flash_bytes, variant.ram_bytes) == tuple(1024 * size for size in kb)
    assert (limits.flash_size, limits.ram_size, limits.table_words) == (*(1024 * size for size in kb), 16 + 56)
    assert len(variant.pins) == {"C": 37, "R": 51, "V": 80, "Z": 112}[name[-2]]
    assert ("USART3" in variant.usarts) is (name[-1] not in "46")
    assert ("UART5" in variant.usarts) is ("SPI3" in variant.spis) is (name[-1] in "CDE")


@each(
    ("chip", "gates"),
    [
        ("STM32F100C4", (0x55, 0x7822_0833, 0x7_5A3D)),
        ("STM32F100RB", (0x55, 0x7866_4837, 0x7_5A7D)),
        ("STM32F100ZE", (0x157, 0x787E_C9FF, 0x7_5BFD)),
    ],
)
def test_gates_and_what_is_behind_them(chip, gates):
    """RM0041 sections 6.3.6 to 6.3.8."""
    made = Rig(chip).chip
    assert tuple(peek(made.rcc, register) for register in ("AHBENR", "APB1ENR", "APB2ENR")) == gates
    there = {"TIM1", "TIM2", "TIM3", "TIM6", "TIM7", "TIM15", "TIM16", "TIM17", "DAC", "CEC", "ADC1", "DMA1", "RTC"}
    assert there <= set(made.peripherals)
    assert not {"ADC2", "ADC3", "CAN", "USB", "USB_SRAM", "TIM8", "SDIO"} & set(made.peripherals)
    of_high = {"DMA2", "TIM5", "TIM12", "TIM13", "TIM14", "UART4", "UART5", "SPI3", "GPIOF", "GPIOG", "FSMC"}
    assert of_high & set(made.peripherals) == (of_high if chip[-1] == "E" else set())
    assert peek(made.dbgmcu, "IDCODE") & 0xFFF == (0x428 if chip[-1] == "E" else 0x420)


@each(("chip", "lines"), [("STM32F100RB", 56), ("STM32F100RE", 61)])
def test_interrupts_go_up_to_55_and_60(chip, lines):
    bus = Rig(chip).machine.bus
    bus.write(0xE000_E104, 4, 0xFFFF_FFFF)
    assert bus.read(0xE000_E104, 4) == (1 << lines - 32) - 1


def test_the_fsmc_has_neither_nand_nor_pc_cards(big):
    """RM0041 section 20.2: what it has is the configuration registers and the controller of NOR flash and PSRAM."""
    fsmc, bus = big.chip.peripherals["FSMC"], big.machine.bus
    assert {one.name[:-1] for one in fsmc.registers.values()} == {"BCR", "BTR", "BWTR"}
    big.poke("RCC_AHBENR", 0x114)
    assert bus.read(0x6000_0000, 2) == 0
    bus.write(0xA000_0060, 4, 0x000C)
    with pytest.raises(BusFault):
        bus.read(0x7000_0000, 2)


def test_cec_is_declared(rig):
    part = rig.chip.peripherals["CEC"]
    assert part.base == 0x4000_7800
    assert all(register.fidelity is Fidelity.ABSENT for register in part.registers.values())


# --- clocks


@pytest.mark.parametrize(("prediv", "mul", "mhz"), [(1, 3, 24), (2, 6, 24), (4, 12, 24), (8, 16, 16)])
def test_a_divider_stands_before_the_pll(rig, prediv, mul, mhz):
    """RM0041 section 6.3.11; PREDIV1 is the divisor less one."""
    rig.poke("RCC_CR", 0x1_0083)
    rig.advance(200_000)
    rig.poke("RCC_CFGR2", prediv - 1)
    rig.poke("RCC_CFGR", (mul - 2) << 18 | 1 << 16 | (prediv - 1 & 1) << 17)
    rig.poke("RCC_CR", 0x101_0083)
    rig.advance(200_000)
    rig.poke("RCC_CFGR", rig.peek("RCC_CFGR") | 2)
    rig.advance(100)
    assert rig.machine.time.hclk_hz == mhz * 1_000_000
    assert rig.noted("misuse") == []
    rig.poke("RCC_CFGR2", 15)
    assert rig.peek("RCC_CFGR2") == prediv - 1
    assert rig.noted("misuse") == ["RCC_CFGR2.PREDIV1"]


def test_the_lowest_bit_of_the_divider_is_pllxtpre(rig):
    rig.poke("RCC_CFGR", 1 << 17)
    assert rig.peek("RCC_CFGR2") == 1
    rig.poke("RCC_CFGR2", 6)
    assert not rig.peek("RCC_CFGR") & 1 << 17
    rig.poke("RCC_CFGR", 0x0060_0000 | 1 << 22)
    assert not rig.peek("RCC_CFGR") & 1 << 22  # USBPRE is not there


def test_more_than_24_mhz_is_noted(rig):
    rig.poke("RCC_CFGR", 5 << 18)  # HSI / 2 * 7
    rig.poke("RCC_CR", 0x100_0083)
    rig.advance(200_000)
    rig.poke("RCC_CFGR", 5 << 18 | 2)
    rig.advance(100)
    assert set(rig.noted("misuse")) - {"FLASH_ACR.LATENCY"} == {
        *("RCC_CFGR.PLLMUL", "RCC_CFGR.SW", "RCC_CFGR.PPRE1", "RCC_CFGR.PPRE2", "RCC_CFGR.ADCPRE"),
    }


# --- timers


@pytest.mark.parametrize(
    ("timer", "enable", "number"),
    [
        ("TIM15", 0x80, 24),
        ("TIM15", 0x01, 24),
        ("TIM15", 0x04, 24),
        ("TIM16", 0x02, 25),
        ("TIM17", 0x80, 26),
        ("TIM1", 0x80, 24),
        ("TIM1", 0x01, 25),
        ("TIM1", 0x40, 26),
        ("TIM6", 0x01, 54),
        ("TIM7", 0x01, 55),
    ],
)
def test_interrupts_that_timers_share(rig, timer, enable, number):
    """Table 50."""
    rig.poke(f"{timer}_DIER", enable)
    rig.poke(f"{timer}_EGR", enable)
    rig.advance(4)
    assert rig.pending() == {number}


def test_a_shared_interrupt_is_high_while_either_asks(rig):
    for timer in ("TIM1", "TIM16"):
        rig.poke(f"{timer}_DIER", 1)
        rig.poke(f"{timer}_EGR", 1)
    for timer, left in (("TIM1", {25}), ("TIM16", set())):
        rig.poke(f"{timer}_SR", 0)
        rig.machine.bus.write(0xE000_E280, 4, 0xFFFF_FFFF)
        rig.advance(4)
        assert rig.pending() == left


@pytest.mark.parametrize(
    ("signal", "remap", "pin"),
    [
        ("TIM15_CH1", 0, "PA2"),
        ("TIM15_CH2", 0, "PA3"),
        ("TIM15_CH1", 1, "PB14"),
        ("TIM15_CH2", 1, "PB15"),
        ("TIM16_CH1", 0, "PB8"),
        ("TIM16_CH1", 2, "PA6"),
        ("TIM17_CH1", 0, "PB9"),
        ("TIM17_CH1", 4, "PA7"),
        ("TIM15_CH1N", 0, "PB15"),
        ("TIM16_CH1N", 0, "PB6"),
        ("TIM17_CH1N", 0, "PB7"),
    ],
)
def test_outputs_at_their_pins(rig, signal, remap, pin):
    timer, channel = signal.split("_")
    rig.poke("AFIO_MAPR2", remap)
    rig.mode(pin, AF)
    rig.poke(f"{timer}_CCMR1", 0x5050)
    rig.poke(f"{timer}_CCER", {"CH1": 0x1, "CH2": 0x10, "CH1N": 0x4}[channel])
    rig.advance(4)
    assert rig.chip.pins[pin].level is not True
    rig.poke(f"{timer}_BDTR", 0x8000)
    rig.advance(4)
    assert rig.chip.pins[pin].level is True


def test_tim15_counts_what_tim16_puts_out(rig):
    """ITR2 is OC1 of TIM16."""
    rig.poke("TIM15_SMCR", 2 << 4 | 7)
    rig.poke("TIM15_CR1", 1)
    rig.poke("TIM16_CCMR1", 0x60)
    rig.poke("TIM16_CCR1", 5)
    rig.poke("TIM16_ARR", 9)
    rig.poke("TIM15_CNT", 0)  # OC1REF has risen when it was set up
    rig.poke("TIM16_CR1", 1)
    rig.advance(102)
    assert rig.peek("TIM15_CNT") == 10


def test_timers_of_high_density(big):
    """TIM12 counts what TIM13 puts out (ITR2), whose compare is at PC8, and each has an interrupt of its own."""
    big.mode("PC8", AF)
    big.poke("TIM12_SMCR", 2 << 4 | 7)
    big.poke("TIM12_CR1", 1)
    for register, value in (("CCMR1", 0x60), ("CCER", 1), ("CCR1", 5), ("ARR", 9)):
        big.poke(f"TIM13_{register}", value)
    big.poke("TIM12_CNT", 0)
    big.chip.pins["PC8"].record()
    big.poke("TIM13_CR1", 1)
    big.advance(102)
    assert big.peek("TIM12_CNT") == 10
    assert len(big.chip.pins["PC8"].edges) == 20
    for timer in ("TIM12", "TIM13", "TIM14"):
        big.poke(f"{timer}_DIER", 1)
        big.poke(f"{timer}_EGR", 1)
    big.advance(4)
    assert big.pending() == {43, 44, 45}


@pytest.mark.parametrize(
    ("signal", "remap", "pin"),
    [
        ("TIM12_CH1", 0, "PC4"),
        ("TIM12_CH2", 0, "PC5"),
        ("TIM12_CH1", 1 << 12, "PB12"),
        ("TIM12_CH2", 1 << 12, "PB13"),
        ("TIM13_CH1", 1 << 8, "PB0"),
        ("TIM14_CH1", 0, "PC9"),
        ("TIM14_CH1", 1 << 9, "PB1"),
    ],
)
def test_outputs_of_high_density_at_their_pins(big, signal, remap, pin):
    timer, channel = signal.split("_")
    big.poke("AFIO_MAPR2", remap)
    big.mode(pin, AF)
    big.poke(f"{timer}_CCMR1", 0x5050)
    big.poke(f"{timer}_CCER", {"CH1": 0x1, "CH2": 0x10}[channel])
    big.advance(4)
    assert big.chip.pins[pin].level is True


# --- requests to DMA


def served(rig, where, event, mapr2=0):
    """Say whether an update or capture/compare event of a timer moves a word by a channel."""
    controller, channel = where
    rig.poke("AFIO_MAPR2", mapr2)
    for register, value in (("CNDTR", 9), ("CPAR", 0x4000_0024), ("CMAR", 0x2000_0000), ("CCR", 0x581)):
        rig.poke(f"{controller}_{register}{channel}", value)
    timer, bit = event
    rig.poke(f"{timer}_DIER", bit << 8)
    rig.poke(f"{timer}_EGR", bit)
    rig.advance(20)
    return rig.peek(f"{controller}_CNDTR{channel}") == 8


@each(
    ("chip", "event", "where", "mapr2"),
    [
        ("STM32F100RB", ("TIM15", 1), ("DMA1", 5), 0),
        ("STM32F100RB", ("TIM15", 2), ("DMA1", 5), 0),
        ("STM32F100RB", ("TIM15", 1 << 6), ("DMA1", 5), 0),
        ("STM32F100RB", ("TIM16", 1), ("DMA1", 6), 0),
        ("STM32F100RB", ("TIM17", 2), ("DMA1", 7), 0),
        ("STM32F100RB", ("TIM1", 2), ("DMA1", 2), 0),
        ("STM32F100RB", ("TIM1", 2), ("DMA1", 6), 1 << 4),
        ("STM32F100RB", ("TIM1", 4), ("DMA1", 3), 0),
        ("STM32F100RB", ("TIM1", 4), ("DMA1", 6), 1 << 4),
        ("STM32F100RB", ("TIM6", 1), ("DMA1", 3), 0),
        ("STM32F100RE", ("TIM6", 1), ("DMA2", 3), 0),
        ("STM32F100RE", ("TIM6", 1), ("DMA1", 3), 1 << 11),
        ("STM32F100RE", ("TIM7", 1), ("DMA2", 4), 0),
        ("STM32F100RE", ("TIM7", 1), ("DMA1", 4), 1 << 11),
        ("STM32F100RE", ("TIM5", 1), ("DMA2", 2), 0),
        ("STM32F100RE", ("TIM5", 2), ("DMA2", 5), 0),
    ],
)
def test_who_asks_which_channel(chip, event, where, mapr2):
    """RM0041 section 9.3.7; AFIO_MAPR2 moves those of TIM1, and with high density of TIM6, TIM7 and the DAC."""
    assert served(Rig(chip), where, event, mapr2)
    if mapr2:
        assert not served(Rig(chip), where, event)


def test_a_request_that_is_moved_takes_its_level_along():
    class Line:
        level = False

        def set(self, level):
            self.level = level

    usual, moved = Line(), Line()
    choice = RequestChoice(usual, moved)
    choice.set(True)
    choice.choose(moved=True)
    assert (usual.level, moved.level) == (False, True)
    choice.choose(moved=False)
    assert (usual.level, moved.level) == (True, False)


def test_channel_5_of_dma2_has_an_interrupt_of_its_own_with_misc_remap(big):
    """RM0041 section 7.4.7."""
    for channel in (4, 5):
        for register, value in (("CNDTR", 1), ("CPAR", 0x2000_0000), ("CMAR", 0x2000_0010), ("CCR", 0x4A83)):
            big.poke(f"DMA2_{register}{channel}", value)
        big.advance(40)
    steps = []
    for mapr2 in (0, 1 << 13, 0):
        big.poke("AFIO_MAPR2", mapr2)
        big.machine.bus.write(0xE000_E284, 4, 0xFFFF_FFFF)  # pending is again what is still high
        big.advance(4)
        steps.append(big.pending())
    big.poke("AFIO_MAPR2", 1 << 13)
    big.poke("DMA2_IFCR", 0xF << 12)
    big.machine.bus.write(0xE000_E284, 4, 0xFFFF_FFFF)
    assert steps == [{59}, {59, 60}, {59}]
    assert big.pending() == {60}


@each(("mapr2", "timer", "counts"), [(0, "TIM5", 1), (0, "TIM15", 0), (1 << 13, "TIM15", 1), (1 << 13, "TIM5", 0)])
def test_misc_remap_chooses_who_triggers(mapr2, timer, counts):
    """TIM1 by ITR0, TIM3 by ITR2, and the DAC by trigger 3."""
    big = Rig("STM32F100RE")
    big.poke("AFIO_MAPR2", mapr2)
    for slave, source in (("TIM1", 0), ("TIM3", 2)):
        big.poke(f"{slave}_SMCR", source << 4 | 7)
        big.poke(f"{slave}_CR1", 1)
    big.poke("DAC_CR", 3 << 3 | 5)
    big.poke("DAC_DHR12R1", 77)
    big.poke(f"{timer}_CR2", 2 << 4)
    big.poke(f"{timer}_EGR", 1)
    big.advance(4)
    assert [big.peek(f"{slave}_CNT") for slave in ("TIM1", "TIM3")] == [counts, counts]
    assert big.peek("DAC_DOR1") == 77 * counts


def test_uart5_asks_for_dma(big):
    """RM0041 section 9.3.7: channel 1 of DMA2 sends."""
    for register, value in (("CNDTR1", 3), ("CPAR1", 0x4000_5004), ("CMAR1", 0x2000_0000), ("CCR1", 0x91)):
        big.poke(f"DMA2_{register}", value)
    for register, value in (("BRR", 0x10), ("CR3", 0x80), ("CR1", 0x2008)):
        big.poke(f"UART5_{register}", value)
    big.advance(2000)
    assert big.peek("DMA2_CNDTR1") == 0


# --- the DAC


def test_tim6_and_dma1_play_a_table(rig):
    """RM0041 section 9.3.7: channel 3 of DMA1."""
    table = [100, 1000, 4000]
    for index, word in enumerate(table):
        rig.machine.bus.write(0x2000_0000 + 2 * index, 2, word)
    for register, value in (("CNDTR3", 3), ("CPAR3", 0x4000_7408), ("CMAR3", 0x2000_0000), ("CCR3", 0x5B1)):
        rig.poke(f"DMA1_{register}", value)
    rig.poke("DAC_CR", 0x1005)
    seen = []
    for _ in range(5):
        rig.poke("TIM6_EGR", 1)
        rig.advance(20)
        seen.append(rig.peek("DAC_DOR1"))
    assert seen == [0, *table, table[0]]


@pytest.mark.parametrize(("select", "timer"), [(1, "TIM3"), (3, "TIM15")])
def test_triggers_of_the_dac(rig, select, timer):
    rig.poke("DAC_CR", select << 3 | 5)
    rig.poke("DAC_DHR12R1", 77)
    rig.poke(f"{timer}_EGR", 1)
    rig.advance(4)
    assert rig.peek("DAC_DOR1") == 77


@pytest.mark.parametrize(("channel", "dma"), [(1, 3), (2, 4)])
def test_dma_that_comes_too_late_is_an_underrun(rig, channel, dma):
    """RM0041 section 11.3.7: then no request is treated until it is set up anew."""
    shift, flag = 16 * (channel - 1), 1 << 13 + 16 * (channel - 1)
    for register, value in ((f"CPAR{dma}", 0x4000_7408 + 12 * (channel - 1)), (f"CMAR{dma}", 0x2000_0000)):
        rig.poke(f"DMA1_{register}", value)
    rig.poke("DAC_CR", 0x3005 << shift)  # TIM6, and DMAUDRIE

    def trigger():
        rig.poke("TIM6_EGR", 1)
        rig.advance(20)
        return bool(rig.peek("DAC_SR") & flag), 54 in rig.pending()

    assert [trigger(), trigger()] == [(False, False), (True, True)]
    rig.poke(f"DMA1_CNDTR{dma}", 9)
    rig.poke(f"DMA1_CCR{dma}", 0x5B1)
    trigger()
    assert rig.peek(f"DMA1_CNDTR{dma}") == 9
    rig.poke("DAC_SR", flag)
    assert rig.peek("DAC_SR") == 0
    assert trigger()[0] is False
    rig.poke("DAC_CR", 0)
    rig.poke("DAC_CR", 0x1005 << shift)
    assert [trigger(), trigger(), trigger()][-1][0] is False
    assert rig.peek(f"DMA1_CNDTR{dma}") == 6


@pytest.mark.parametrize(
    ("brr", "over8", "cycles"), [(0x115, False, 0x115), (0x115, True, 0x11 * 8 + 5), (0x10, True, 8), (0xF, True, 0)]
)
def test_a_bit_of_a_usart_that_samples_it_8_times(rig, brr, over8, cycles):
    """RM0041 section 23.3.4: the divider has three bits behind the point, and counts eighths."""
    sent = []
    rig.mode("PA9", AF)
    usart = rig.chip.usarts["USART1"]
    usart.on_frame = sent.append
    rig.poke("USART1_BRR", brr)
    rig.poke("USART1_CR1", 0x2008 | over8 << 15)
    rig.poke("USART1_DR", 0x55)
    rig.advance(20_000)
    assert [frame.bit_s * 8_000_000 for frame in sent] == ([cycles] if cycles else [])


@pytest.mark.parametrize(("register", "value"), [("CR2", 1 << 14), ("CR3", 1 << 1), ("CR3", 1 << 5)])
def test_lin_irda_and_smartcards_are_sampled_16_times(rig, register, value):
    """RM0041 section 23.3.3: OVER8 is forced to 0 by hardware with LINEN, IREN and SCEN."""
    sent = []
    rig.mode("PA9", AF)
    rig.chip.usarts["USART1"].on_frame = sent.append
    rig.poke("USART1_BRR", 0x110)
    rig.poke("USART1_CR1", 0xA008)
    rig.poke(f"USART1_{register}", value)
    assert rig.peek("USART1_CR1") == 0x2008
    rig.poke("USART1_CR1", 0xA008)
    assert rig.peek("USART1_CR1") == 0x2008
    rig.poke("USART1_DR", 0x55)
    rig.advance(20_000)
    assert [frame.bit_s * 8_000_000 for frame in sent] == [0x110]


def test_bit_3_of_brr_is_not_looked_at_with_over8(rig):
    rig.poke("USART1_BRR", 0x118)
    assert rig.noted("misuse") == []
    rig.poke("USART1_CR1", 0xA008)
    assert rig.noted("misuse") == ["USART1_BRR"]


@pytest.mark.parametrize(("onebit", "noisy"), [(False, True), (True, False)])
def test_one_sample_knows_no_noise(rig, onebit, noisy):
    """RM0041 section 23.6.6: ONEBIT disables the noise flag. A spike at the first of the three samples."""
    for register, value in (("BRR", 320), ("CR3", onebit << 11), ("CR1", 0x2004)):
        rig.poke(f"USART1_{register}", value)
    pin, start = rig.chip.pins["PA10"], rig.machine.time.now + 1000
    at = rig.machine.time.at
    for cycle, level in ((0, True), (1000, False), (1320, True), (1320 + 150, False), (1320 + 170, True)):
        at(start - 1000 + cycle, lambda level=level: pin.drive(level))
    rig.advance(6000)
    assert bool(rig.peek("USART1_SR") & 1 << 2) is noisy
    assert rig.peek("USART1_DR") == 0xFF


def test_others_have_none_of_it():
    machine = Machine(Board.from_mapping({"name": "medium", "chip": "STM32F103RB"}), IMAGE)
    assert not {"TIM15", "TIM6", "DAC", "CEC"} & set(machine.chip.peripherals)
    assert 0x2C not in machine.chip.rcc.registers
    assert 0x1C not in machine.chip.afio.registers


def test_the_flash_has_no_wait_states(rig):
    """PM0063, FLASH_ACR: half-cycle access alone."""
    flash = rig.chip.peripherals["FLASH"]
    asked = []
    flash.on_latency = asked.append
    assert peek(flash, "ACR") == 0
    poke(flash, "ACR", 0x3F)
    assert peek(flash, "ACR") == 1 << 3
    assert not asked
