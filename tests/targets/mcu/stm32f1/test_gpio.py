"""Ports: configuration, levels, the lock."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.pins import PadMode
from targets.mcu.testing import peek, poke


def test_reset_values(pinout):
    for letter in "ABCDE":
        port = pinout.ports[letter]
        assert peek(port, "CRL") == peek(port, "CRH") == 0x4444_4444
        for name in ("ODR", "BSRR", "BRR", "LCKR"):
            assert peek(port, name) == 0


def test_idr_after_reset_shows_the_pulls_of_the_debug_port(pinout):
    assert peek(pinout.ports["A"], "IDR") == 0xA000
    assert peek(pinout.ports["B"], "IDR") == 0x0010


MODES = {
    0b0000: (PadMode.ANALOG, None),
    0b0100: (PadMode.INPUT, None),
    0b1000: (PadMode.INPUT, False),
    0b1100: (PadMode.INPUT, None),
    0b0001: (PadMode.PUSH_PULL, None),
    0b0110: (PadMode.OPEN_DRAIN, None),
    0b1011: (PadMode.AF_PUSH_PULL, None),
    0b1101: (PadMode.AF_OPEN_DRAIN, None),
}


@pytest.mark.parametrize("nibble", MODES)
@pytest.mark.parametrize("pin", ["PA0", "PB11"])
def test_modes(pinout, nibble, pin):
    pinout.mode(pin, nibble)
    mode, pull = MODES[nibble]
    assert pinout.pins[pin]._mode is mode
    assert pinout.pins[pin].level is (False if mode in (PadMode.PUSH_PULL, PadMode.OPEN_DRAIN) else pull)


def test_odr_chooses_the_direction_of_a_pull(pinout):
    pinout.mode("PA5", 0b1000)
    poke(pinout.ports["A"], "BSRR", 1 << 5)
    assert pinout.pins["PA5"].level is True
    assert peek(pinout.ports["A"], "IDR") & 1 << 5
    poke(pinout.ports["A"], "BRR", 1 << 5)
    assert pinout.pins["PA5"].level is False


def test_bsrr_sets_resets_and_set_wins(pinout):
    port = pinout.ports["B"]
    poke(port, "ODR", 0xFFFF_00F0)
    assert peek(port, "ODR") == 0x00F0
    poke(port, "BSRR", 0x00FF_000F | 1 << 4 | 1 << 20)
    assert peek(port, "ODR") == 0x001F
    poke(port, "BRR", 0x0003)
    assert peek(port, "ODR") == 0x001C
    poke(port, "IDR", 0xFFFF)
    assert peek(port, "IDR") == 0x0010


@given(
    nibbles=st.lists(st.sampled_from(sorted(MODES)), min_size=16, max_size=16),
    odr=st.integers(0, 0xFFFF),
    outside=st.lists(st.sampled_from([None, False, True]), min_size=16, max_size=16),
)
def test_idr_is_the_level_of_each_pin(make_pinout, nibbles, odr, outside):
    pinout = make_pinout()
    port = pinout.ports["A"]
    poke(pinout.afio, "MAPR", 0b100 << 24)
    poke(port, "CRL", sum(nibble << 4 * index for index, nibble in enumerate(nibbles[:8])))
    poke(port, "CRH", sum(nibble << 4 * index for index, nibble in enumerate(nibbles[8:])))
    poke(port, "ODR", odr)
    for number, level in enumerate(outside):
        pinout.pins[f"PA{number}"].drive(level)
    for number, (nibble, level) in enumerate(zip(nibbles, outside, strict=True)):
        latch = bool(odr >> number & 1)
        own = {0b0001: latch, 0b0110: False if not latch else None}.get(nibble)
        pull = latch if nibble == 0b1000 else None
        strong = {value for value in (own, level) if value is not None}
        expected = bool(pull) if not strong else (False not in strong)
        assert bool(peek(port, "IDR") >> number & 1) is (expected and nibble != 0)


def test_open_drain_can_be_read_back(pinout):
    pinout.mode("PB6", 0b0101)
    poke(pinout.ports["B"], "BSRR", 1 << 6)
    pinout.pins["PB6"].drive(True, ohms=4_700)
    assert peek(pinout.ports["B"], "IDR") & 1 << 6
    pinout.pins["PB6"].drive(False)
    assert not peek(pinout.ports["B"], "IDR") & 1 << 6


def lock(port, *steps):
    for step in steps:
        if step == "read":
            last = peek(port, "LCKR")
        else:
            poke(port, "LCKR", step)
    return last


KEY = 1 << 16


def test_the_lock_sequence_freezes_the_configuration(pinout):
    port = pinout.ports["A"]
    poke(port, "CRL", 0x4444_4443)
    assert lock(port, KEY | 0x0101, 0x0101, KEY | 0x0101, "read") == 0x0101
    assert peek(port, "LCKR") == KEY | 0x0101
    poke(port, "CRL", 0x1111_1111)
    poke(port, "CRH", 0x1111_1111)
    assert peek(port, "CRL") == 0x1111_1113
    assert peek(port, "CRH") == 0x1111_1114
    poke(port, "ODR", 1)
    assert pinout.pins["PA0"].level is True
    poke(port, "LCKR", 0)
    assert peek(port, "LCKR") == KEY | 0x0101
    port.reset()
    poke(port, "CRL", 0)
    assert peek(port, "CRL") == 0


@pytest.mark.parametrize(
    "steps",
    [
        (KEY | 1, 1, "read"),
        (KEY | 1, 1, KEY | 3, "read"),
        (KEY | 1, 3, KEY | 3, "read"),
        (1, KEY | 1, KEY | 1, "read"),
        (KEY | 1, KEY | 1, 1, "read"),
        (KEY | 1, 1, "read", KEY | 1, "read"),
        (KEY | 1, 1, KEY | 1, 1, "read"),
    ],
)
def test_an_error_in_the_sequence_aborts_it(pinout, steps):
    port = pinout.ports["A"]
    lock(port, *steps)
    assert peek(port, "LCKR") & KEY == 0
    poke(port, "CRL", 0)
    assert peek(port, "CRL") == 0


def test_a_sequence_after_an_error_counts(pinout):
    port = pinout.ports["A"]
    lock(port, KEY | 1, KEY | 1, 1, KEY | 1, "read")
    assert peek(port, "LCKR") == KEY | 1


def test_using_a_pin_that_is_not_there_or_not_free_is_noted(pinout):
    pinout.mode("PE3", 0b0011)
    pinout.mode("PA15", 0b0011)
    pinout.mode("PB4", 0b0000)
    assert pinout.chip.noted("misuse") == ["PE3", "PA15"]
    assert pinout.pins["PE3"].level is False
    assert peek(pinout.ports["E"], "IDR") == 0
    poke(pinout.ports["E"], "BSRR", 8)
    assert peek(pinout.ports["E"], "IDR") == 8


def test_reset_releases_all_pins(pinout):
    pinout.mode("PC13", 0b0010)
    poke(pinout.ports["C"], "BSRR", 1 << 13)
    assert pinout.pins["PC13"].level is True
    pinout.ports["C"].reset()
    assert pinout.pins["PC13"].level is None
    assert peek(pinout.ports["C"], "ODR") == 0


def test_idr_is_live_only_while_a_pin_has_edges_that_are_not_told(pinout):
    port = pinout.ports["A"]
    assert not port.is_live(0x08)
    signal = pinout.signals.output("TIM2_CH2")
    signal.refresh = lambda: None
    pinout.mode("PA1", 0b1011)
    assert port.is_live(0x08)
    assert not port.is_live(0x0C)
    pinout.pins["PA1"].on_edge(lambda *_edge: None)
    assert not port.is_live(0x08)
