"""Ports with a multiplexer for each pin: configuration, levels, alternate functions, the lock (RM0410 section 6)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.pins import PadMode
from targets.mcu.services import Watch
from targets.mcu.stm32.gpio import thresholds
from targets.mcu.testing import peek, poke

RESETS = {
    "A": {"MODER": 0xA800_0000, "OSPEEDR": 0x0C00_0000, "PUPDR": 0x6400_0000},
    "B": {"MODER": 0x0000_0280, "OSPEEDR": 0x0000_00C0, "PUPDR": 0x0000_0100},
}
LONG = 216_000_000  # a second in HCLK cycles
KEY = 1 << 16


@pytest.mark.parametrize("letter", "ABCDEFGHIJK")
def test_reset_values(pinout, letter):
    port = pinout.ports[letter]
    for name in ("MODER", "OTYPER", "OSPEEDR", "PUPDR", "ODR", "BSRR", "LCKR", "AFRL", "AFRH"):
        assert peek(port, name) == RESETS.get(letter, {}).get(name, 0), name


def test_idr_after_reset_shows_the_pulls_of_the_debug_port(pinout):
    assert peek(pinout.ports["A"], "IDR") == 0xA000
    assert peek(pinout.ports["B"], "IDR") == 0x0010
    assert not pinout.chip.noted()


def naive(mode, open_drain, pull, latch, outside):
    """Return the level of a pin that is no alternate function, and what IDR shows."""
    pulled = {0: None, 1: True, 2: False, 3: None}[pull]
    if mode == 3:
        return outside, False
    driven = None if mode == 0 or (open_drain and latch) else bool(latch)
    if outside is not None and driven is not None:
        level = outside if outside is driven else False
    elif driven is not None:
        level = driven
    else:
        level = outside if outside is not None else pulled
    return level, level is True


@given(
    mode=st.sampled_from([0, 1, 3]),
    open_drain=st.integers(0, 1),
    pull=st.integers(0, 3),
    latch=st.integers(0, 1),
    outside=st.sampled_from([None, False, True]),
    pin=st.sampled_from(["PA0", "PC13", "PE15", "PG8"]),
)
def test_levels(make_pinout, mode, open_drain, pull, latch, outside, pin):
    pinout = make_pinout()
    number = int(pin[2:])
    pinout.pins[pin].drive(outside)
    pinout.field(pin, "OTYPER", open_drain, width=1)
    pinout.field(pin, "PUPDR", pull)
    pinout.field(pin, "MODER", mode)
    poke(pinout.ports[pin[1]], "BSRR", 1 << number if latch else 1 << number + 16)
    level, shown = naive(mode, open_drain, pull, latch, outside)
    assert pinout.pins[pin].level is level
    assert bool(peek(pinout.ports[pin[1]], "IDR") >> number & 1) is shown


def test_an_open_drain_output_keeps_its_pull_up(pinout):
    pinout.field("PB8", "OTYPER", 1, width=1)
    pinout.field("PB8", "PUPDR", 1)
    pinout.field("PB8", "MODER", 1)
    assert pinout.pins["PB8"].level is False
    poke(pinout.ports["B"], "BSRR", 1 << 8)
    assert pinout.pins["PB8"].level is True


def test_bsrr_sets_resets_and_set_wins(pinout):
    port = pinout.ports["E"]
    poke(port, "ODR", 0xFFFF_00F0)
    assert peek(port, "ODR") == 0x00F0
    poke(port, "BSRR", 0x00FF_000F | 1 << 4 | 1 << 20)
    assert peek(port, "ODR") == 0x001F
    assert peek(port, "BSRR") == 0


def test_port_k_has_eight_pins(pinout):
    port = pinout.ports["K"]
    poke(port, "MODER", 0x5555_5555)
    poke(port, "ODR", 0xFFFF)
    assert len(port.pins) == 8
    assert peek(port, "IDR") == 0x00FF


def test_the_use_of_a_pin_that_the_package_lacks_is_noted(pinout):
    pinout.field("PI0", "MODER", 3)
    assert not pinout.chip.noted()
    pinout.field("PI1", "MODER", 1)
    assert pinout.chip.noted("misuse") == ["PI1"]


def test_thresholds():
    assert thresholds(3.3) == pytest.approx((1.115, 1.785))


def test_a_voltage_between_the_thresholds_leaves_the_level(pinout):
    pin = pinout.pins["PC13"]
    levels = []
    for volts in (0.0, 1.5, 1.79, 1.5, 1.11):
        pin.drive_volts(volts)
        levels.append(pin.level)
    assert levels == [False, False, True, True, False]


# --- alternate functions


def test_a_signal_is_connected_only_where_it_is_chosen(pinout):
    signal = pinout.services.output("USART3_TX")
    signal.set(True)
    assert not signal.at_pin()
    pinout.alternate("PD8", 7)
    assert signal.at_pin()
    assert pinout.pins["PD8"].level is True
    assert pinout.functions.pin_of("USART3_TX") == "PD8"
    pinout.field("PD8", "MODER", 0)
    assert not signal.at_pin()
    assert pinout.pins["PD8"].level is None


def test_a_change_from_output_to_alternate_function_at_the_same_level_makes_no_edge(pinout):
    pinout.services.output("USART3_TX").set(True)
    pin = pinout.pins["PD8"]
    pinout.field("PD8", "MODER", 1)
    poke(pinout.ports["D"], "BSRR", 1 << 8)
    pin.record()
    pinout.alternate("PD8", 7)
    pinout.field("PD8", "MODER", 1)
    assert pin.edges == []


def test_an_input_hears_the_pin_that_has_chosen_it(pinout):
    signal = pinout.services.input("TIM4_CH1")
    heard = []
    signal.on_change = heard.append
    pinout.pins["PD12"].drive(True)
    assert not signal.level()
    pinout.alternate("PD12", 2)
    assert heard == [True]
    pinout.pins["PD12"].drive(False)
    pinout.field("PD12", "MODER", 0)
    pinout.pins["PD12"].drive(True)
    assert heard == [True, False]


def test_an_input_that_no_pin_carries_does_not_hear_the_output_of_its_name(pinout):
    pinout.services.output("TIM4_CH1").set(True)
    assert not pinout.services.input("TIM4_CH1").level()


def test_the_line_of_a_serial_port_that_no_pin_carries_is_high(pinout):
    assert pinout.services.input("USART2_RX").level()
    assert pinout.services.input("UART8_TX").level()
    assert not pinout.services.input("USART2_CTS").level()


def test_signals_inside_the_chip_still_meet(pinout):
    pinout.services.output("TIM1_TRGO").set(True)
    assert pinout.services.input("TIM1_TRGO").level()


def test_two_signals_share_a_function(pinout):
    channel, trigger = pinout.services.input("TIM2_CH1"), pinout.services.input("TIM2_ETR")
    pinout.alternate("PA5", 1)
    pinout.pins["PA5"].drive(True)
    assert channel.level()
    assert trigger.level()


def test_a_function_that_a_pin_lacks_is_noted_a_millisecond_later(pinout):
    pinout.alternate("PD8", 1)
    assert pinout.pins["PD8"].level is None
    pinout.chip.advance(215_999)
    assert pinout.chip.noted("misuse") == []
    pinout.chip.advance(1)
    assert pinout.chip.noted("misuse") == ["PD8_AF1"]
    pinout.chip.advance(LONG)
    assert [note.cycle for note in pinout.chip.notes.all] == [216_000]


def test_the_note_has_the_place_in_the_program_that_chose_the_function(pinout, monkeypatch):
    monkeypatch.setattr(pinout.chip.notes, "_pc", lambda: 0x0800_0100)
    pinout.alternate("PD8", 1)
    monkeypatch.setattr(pinout.chip.notes, "_pc", lambda: None)
    pinout.chip.advance(LONG)
    assert [note.pc for note in pinout.chip.notes.all] == [0x0800_0100]


@pytest.mark.parametrize("later", [("AFR", 7), ("MODER", 0)])
def test_the_mode_may_be_written_before_the_function(pinout, later):
    pinout.field("PD8", "MODER", 2)
    pinout.chip.advance(215_999)
    pinout.field("PD8", *later)
    pinout.chip.advance(LONG)
    assert pinout.chip.notes.all == []


def test_a_reset_forgets_the_function_that_a_pin_lacks(pinout):
    pinout.field("PD8", "MODER", 2)
    pinout.ports["D"].reset()
    pinout.chip.advance(LONG)
    assert pinout.chip.notes.all == []


def test_a_second_function_that_a_pin_lacks_has_a_millisecond_of_its_own(pinout):
    pinout.field("PD8", "MODER", 2)
    pinout.chip.advance(200_000)
    pinout.field("PD8", "AFR", 1)
    pinout.chip.advance(200_000)
    assert pinout.chip.notes.all == []
    pinout.chip.advance(LONG)
    assert pinout.chip.noted("misuse") == ["PD8_AF1"]


def test_several_pins_carry_the_same_output(pinout):
    signal = pinout.services.output("TIM2_CH1")
    signal.set(True)
    pinout.alternate("PA0", 1)
    pinout.alternate("PA5", 1)
    assert not pinout.chip.noted()
    assert [pinout.pins[pin].level for pin in ("PA0", "PA5")] == [True, True]
    pinout.pins["PA0"].record()
    heard = []
    pinout.pins["PA5"].on_edge(lambda _cycle, _ns, level: heard.append(level))
    signal.set(False)
    assert heard == [False]
    assert [edge.level for edge in pinout.pins["PA0"].edges] == [False]
    pinout.field("PA5", "MODER", 0)
    assert signal.at_pin()
    assert [pinout.pins[pin].level for pin in ("PA0", "PA5")] == [False, None]
    pinout.field("PA0", "MODER", 0)
    assert not signal.at_pin()


def test_who_looks_at_any_of_several_pins_is_who_looks_at_the_output(pinout):
    signal = pinout.services.output("TIM2_CH1")
    for pin in ("PA0", "PA5"):
        pinout.alternate(pin, 1)
    assert signal.watch() is Watch.NOBODY
    pinout.pins["PA0"].record()
    assert signal.watch() is Watch.RECORD
    pinout.pins["PA5"].on_edge(lambda *_: None)
    assert signal.watch() is Watch.LIVE
    pinout.field("PA5", "MODER", 0)
    assert signal.watch() is Watch.RECORD


def test_an_input_at_several_pins_hears_the_last_and_is_noted(pinout):
    signal = pinout.services.input("USART2_RX")
    heard = []
    signal.on_change = heard.append
    for pin in ("PA3", "PD6"):
        pinout.pins[pin].drive(True)
        pinout.alternate(pin, 7)
    assert pinout.chip.noted("assumed") == ["PD6_USART2_RX"]
    pinout.pins["PA3"].drive(False)
    assert heard == []
    pinout.pins["PD6"].drive(False)
    assert heard == [False]
    pinout.field("PD6", "MODER", 0)
    pinout.pins["PA3"].drive(True)
    assert heard == [False, True]


def test_eventout_is_noted(pinout):
    pinout.alternate("PC13", 15)
    assert pinout.chip.noted("unmodelled") == ["PC13_AF15"]


def test_exti_sees_an_output_and_an_alternate_function(pinout):
    line = pinout.services.input("EXTI8")
    pinout.signals.route("EXTI8", "PD8")
    pinout.services.output("USART3_TX").set(True)
    pinout.field("PD8", "MODER", 1)
    poke(pinout.ports["D"], "BSRR", 1 << 8)
    assert line.level()
    pinout.alternate("PD8", 7)
    assert line.level()
    pinout.field("PD8", "MODER", 3)
    assert not line.level()


def test_an_open_drain_alternate_function(pinout):
    signal = pinout.services.output("UART8_TX")
    pinout.field("PE1", "OTYPER", 1, width=1)
    pinout.alternate("PE1", 8)
    signal.set(True)
    assert pinout.pins["PE1"].level is None
    signal.set(False)
    assert pinout.pins["PE1"].level is False
    assert pinout.pins["PE1"]._mode is PadMode.AF_OPEN_DRAIN


def test_reset_takes_the_functions_away(pinout):
    pinout.alternate("PD8", 7)
    pinout.alternate("PA13", 15)
    pinout.ports["D"].reset()
    pinout.ports["A"].reset()
    assert pinout.functions.pin_of("USART3_TX") is None
    assert pinout.functions.pin_of("SWDIO") == "PA13"


# --- the lock


def lock(port, *steps):
    for step in steps:
        seen = peek(port, "LCKR") if step == "read" else poke(port, "LCKR", step)
    return seen


def test_the_lock_freezes_the_configuration_of_its_pins(pinout):
    port = pinout.ports["B"]
    before = {name: peek(port, name) for name in ("MODER", "OTYPER", "OSPEEDR", "PUPDR", "AFRL", "AFRH")}
    assert lock(port, KEY | 0x0101, 0x0101, KEY | 0x0101, "read") == 0x0101
    assert peek(port, "LCKR") == KEY | 0x0101
    for name in before:
        poke(port, name, 0xFFFF_FFFF)
    kept = {"MODER": 0x3_0003, "OSPEEDR": 0x3_0003, "PUPDR": 0x3_0003, "OTYPER": 0x0101, "AFRL": 0xF, "AFRH": 0xF}
    for name, mask in kept.items():
        everything = 0xFFFF if name == "OTYPER" else 0xFFFF_FFFF
        assert peek(port, name) == everything & ~mask | before[name] & mask, name
    poke(port, "ODR", 0x0101)
    assert peek(port, "ODR") == 0x0101
    port.reset()
    assert peek(port, "LCKR") == 0


@pytest.mark.parametrize(
    "steps",
    [
        (KEY | 1, 1, KEY | 3, "read"),
        (KEY | 1, KEY | 1, 1, "read"),
        (1, KEY | 1, "read"),
        (KEY | 1, "read", 1, KEY | 1, "read"),
        (KEY | 1, 1, KEY | 1),
    ],
)
def test_a_sequence_that_is_broken_locks_nothing(pinout, steps):
    port = pinout.ports["C"]
    lock(port, *steps)
    poke(port, "MODER", 0x1)
    assert peek(port, "MODER") == 1
