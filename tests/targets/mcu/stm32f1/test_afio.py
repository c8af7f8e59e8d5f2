"""Remapping, debug and oscillator pins, event output."""

from __future__ import annotations

import pytest

from targets.mcu.stm32f1.afio import FIXED, REMAPS
from targets.mcu.stm32f1.gpio import PADS
from targets.mcu.testing import peek, poke

# RM0008 section 9.3, tables 39 to 55: signal, field value, pin
VECTORS = [
    ("CAN_REMAP", 0b00, "CAN_RX", "PA11"),
    ("CAN_REMAP", 0b10, "CAN_TX", "PB9"),
    ("CAN_REMAP", 0b11, "CAN_RX", "PD0"),
    ("TIM4_REMAP", 0, "TIM4_CH2", "PB7"),
    ("TIM4_REMAP", 1, "TIM4_CH4", "PD15"),
    ("TIM3_REMAP", 0b00, "TIM3_CH3", "PB0"),
    ("TIM3_REMAP", 0b10, "TIM3_CH1", "PB4"),
    ("TIM3_REMAP", 0b10, "TIM3_CH4", "PB1"),
    ("TIM3_REMAP", 0b11, "TIM3_CH2", "PC7"),
    ("TIM2_REMAP", 0b00, "TIM2_ETR", "PA0"),
    ("TIM2_REMAP", 0b01, "TIM2_CH1", "PA15"),
    ("TIM2_REMAP", 0b01, "TIM2_CH3", "PA2"),
    ("TIM2_REMAP", 0b10, "TIM2_CH2", "PA1"),
    ("TIM2_REMAP", 0b10, "TIM2_CH4", "PB11"),
    ("TIM2_REMAP", 0b11, "TIM2_CH2", "PB3"),
    ("TIM2_REMAP", 0b11, "TIM2_CH3", "PB10"),
    ("TIM1_REMAP", 0b00, "TIM1_BKIN", "PB12"),
    ("TIM1_REMAP", 0b01, "TIM1_CH1N", "PA7"),
    ("TIM1_REMAP", 0b01, "TIM1_CH4", "PA11"),
    ("TIM1_REMAP", 0b11, "TIM1_CH3N", "PE12"),
    ("TIM1_REMAP", 0b11, "TIM1_ETR", "PE7"),
    ("USART3_REMAP", 0b00, "USART3_TX", "PB10"),
    ("USART3_REMAP", 0b01, "USART3_RX", "PC11"),
    ("USART3_REMAP", 0b01, "USART3_RTS", "PB14"),
    ("USART3_REMAP", 0b11, "USART3_CTS", "PD11"),
    ("USART2_REMAP", 0, "USART2_CTS", "PA0"),
    ("USART2_REMAP", 1, "USART2_RX", "PD6"),
    ("USART1_REMAP", 1, "USART1_TX", "PB6"),
    ("I2C1_REMAP", 1, "I2C1_SDA", "PB9"),
    ("SPI1_REMAP", 1, "SPI1_MOSI", "PB5"),
]
SHIFTS = {remap.field: remap.shift for remap in REMAPS}


@pytest.mark.parametrize(("field", "value", "signal", "pin"), VECTORS)
def test_remaps(pinout, field, value, signal, pin):
    poke(pinout.afio, "MAPR", value << SHIFTS[field])
    assert pinout.signals.route_of(signal) == pin
    poke(pinout.afio, "MAPR", 0)
    assert pinout.signals.route_of(signal) == next(remap for remap in REMAPS if remap.field == field).pins[0][signal]


def test_the_fields_fill_the_register_without_overlap():
    taken = 0
    for remap in REMAPS:
        assert not taken & remap.mask << remap.shift
        taken |= remap.mask << remap.shift
        assert len({tuple(pins) for pins in remap.pins.values()}) == 1
        assert all(pin in PADS for pins in remap.pins.values() for pin in pins.values())
    assert taken == 0x7FFF
    assert all(pin in PADS for pin in FIXED.values())


def test_reserved_values_move_nothing_and_are_noted(pinout):
    poke(pinout.afio, "MAPR", 0b10 << 6)
    assert pinout.signals.route_of("TIM1_CH1") == "PA8"
    assert pinout.chip.noted("reserved") == ["AFIO_MAPR.TIM1_REMAP"]


DEBUG = ("PA13", "PA14", "PA15", "PB3", "PB4")


@pytest.mark.parametrize(
    ("value", "kept"), [(0b000, DEBUG), (0b001, DEBUG[:4]), (0b010, DEBUG[:2]), (0b100, ()), (0b111, DEBUG)]
)
def test_swj_cfg_frees_pins(pinout, value, kept):
    poke(pinout.afio, "MAPR", value << 24)
    assert tuple(name for name in DEBUG if pinout.pins[name].claimed_by) == kept
    assert peek(pinout.afio, "MAPR") == value << 24
    assert pinout.chip.noted("assumed") == (["AFIO_MAPR.SWJ_CFG"] if value else [])


@pytest.mark.parametrize("swj_cfg", [0b010, 0b111])
def test_what_was_freed_stays_so_with_111_and_when_mapr_is_read_changed_and_written(pinout, swj_cfg):
    poke(pinout.afio, "MAPR", 0b010 << 24)
    poke(pinout.afio, "MAPR", swj_cfg << 24 | 1)
    poke(pinout.afio, "MAPR", peek(pinout.afio, "MAPR") | 2)
    assert pinout.pins["PB3"].claimed_by is None
    poke(pinout.afio, "MAPR", 3)
    assert pinout.pins["PB3"].claimed_by == "the debug port"
    pinout.afio.reset()
    assert peek(pinout.afio, "MAPR") == 0
    assert pinout.pins["PB4"].level is True
    assert pinout.pins["PA14"].level is False


def test_oscillator_pins_are_a_port_only_when_remapped(pinout):
    pinout.pins["PD0"].drive(True)
    assert peek(pinout.ports["D"], "IDR") == 0
    poke(pinout.afio, "MAPR", 1 << 15)
    assert peek(pinout.ports["D"], "IDR") == 1
    poke(pinout.afio, "MAPR", 0)
    assert peek(pinout.ports["D"], "IDR") == 0


def test_nothing_of_mapr_is_only_remembered(pinout):
    poke(pinout.afio, "MAPR", 0xFFFF_FFFF & ~(0b11 << 26))
    assert peek(pinout.afio, "MAPR") == 0x031F_FFFF
    assert pinout.chip.noted("unmodelled") == []


def test_sev_is_a_pulse_at_the_chosen_pin(pinout):
    pinout.mode("PB7", 0b1011)
    pinout.pins["PB7"].record()
    poke(pinout.afio, "EVCR", 1 << 7 | 1 << 4 | 7)
    pinout.chip.advance(10)
    pinout.afio.send_event()
    pinout.chip.advance(10)
    assert [edge[::2] for edge in pinout.pins["PB7"].edges] == [(0, False), (10, True), (11, False)]
    poke(pinout.afio, "EVCR", 0)
    pinout.afio.send_event()
    assert pinout.pins["PB7"].level is None
