"""The synchronous clock of a USART by the manual (RM0008 section 27.3.9, figures 292 and 293)."""

from __future__ import annotations

import itertools

import pytest

from targets.mcu.services import Watch
from tests.each import each

UE, M, TE, RE, SBK = 1 << 13, 1 << 12, 1 << 3, 1 << 2, 1 << 0
LBCL, CPHA, CPOL, CLKEN = (1 << bit for bit in range(8, 12))
LINEN = 1 << 14
IREN, HDSEL, SCEN = 1 << 1, 1 << 3, 1 << 5
WAYS = [sum(bits) for bits in itertools.product((0, LBCL), (0, CPHA), (0, CPOL))]
BRR = 32


def open_clocked(make_port, cr2, cr1=UE | TE | RE, watch=Watch.LIVE):
    port = make_port()
    port.chip.output("USART1_CK").set_watch(watch)
    return port.open(BRR, cr1, CLKEN | cr2)


def edges(port, begin):
    ck = port.chip.output("USART1_CK")
    ck.look()
    return [((cycle - begin) / port.bit, level) for cycle, level in ck.edges if cycle > begin]


@each(("way", "watch", "wide"), itertools.product(WAYS, (Watch.RECORD, Watch.LIVE), (False, True)))
def test_a_pulse_for_each_bit_of_data(make_port, way, watch, wide):
    """None for start and stop bit, and for the last bit by LBCL; the middle of a bit is the edge that CPHA says."""
    port = open_clocked(make_port, way, UE | TE | (M if wide else 0), watch)
    idle = bool(way & CPOL)
    assert port.chip.output("USART1_CK").level is idle
    begin = port.chip.time.now
    port.poke("DR", 0x155)
    port.poke("DR", 0x0AA)
    frame = 11 if wide else 10
    port.bits(2 * frame)
    first = 1 if way & CPHA else 1.5
    count = (9 if wide else 8) - (0 if way & LBCL else 1)
    expected = [
        (start + first + bit + half, idle is bool(half))
        for start in (0, frame)
        for bit in range(count)
        for half in (0, 0.5)
    ]
    assert edges(port, begin) == expected


@each("way", WAYS)
def test_what_comes_in_is_sampled_in_the_middle_of_bits(make_port, way):
    port = open_clocked(make_port, way)
    rx = port.chip.input("USART1_RX")
    port.poke("DR", 0xFF)
    port.bits(1)
    for bit in range(8):
        rx.drive(True)
        port.chip.advance(port.bit // 2 - 1)
        rx.drive(bool(0x4D >> bit & 1))
        assert not port.flags & 1 << 5
        port.chip.advance(2)
        rx.drive(False)
        port.chip.advance(port.bit - port.bit // 2 - 1)
    assert port.flags & 1 << 5
    assert port.peek("DR") == 0x4D


def test_nothing_comes_in_unless_something_goes_out(make_port):
    port = open_clocked(make_port, LBCL)
    rx = port.chip.input("USART1_RX")
    for level in (False, True) * 5:
        rx.drive(level)
        port.bits(3)
    assert not port.flags & 0x3F


def test_without_re_nothing_comes_in(make_port):
    port = open_clocked(make_port, LBCL, UE | TE)
    port.poke("DR", 0xFF)
    port.bits(12)
    assert not port.flags & 1 << 5


def test_a_break_has_no_clock(make_port):
    port = open_clocked(make_port, LBCL)
    begin = port.chip.time.now
    port.poke("CR1", UE | TE | RE | SBK)
    port.bits(20)
    assert edges(port, begin) == []


def test_it_goes_on_at_another_rate(make_port):
    port = open_clocked(make_port, LBCL)
    begin = port.chip.time.now
    port.poke("DR", 0)
    port.bits(4)
    port.chip.change_clock(APB2=2)
    port.chip.advance(12 * BRR)
    found = edges(port, begin)
    assert [at for at, _ in found[:6]] == [1.5, 2, 2.5, 3, 3.5, 4]
    assert [at for at, _ in found[6:]] == [4 + 2 * step for step in (0.5, 1, 1.5, 2, 2.5, 3, 3.5, 4, 4.5, 5)]


def test_a_pin_that_nobody_looks_at_has_its_level(make_port):
    port = open_clocked(make_port, LBCL | CPHA, watch=Watch.NOBODY)
    port.poke("DR", 0)
    port.chip.advance(port.bit + port.bit // 4)
    ck = port.chip.output("USART1_CK")
    ck.look()
    assert ck.level is True
    port.poke("CR1", 0)
    assert ck.level is None


@pytest.mark.parametrize("bit", [LBCL, CPHA, CPOL])
def test_settings_wait_for_te(make_port, bit):
    port = open_clocked(make_port, 0)
    port.poke("CR2", CLKEN | bit)
    assert port.chip.noted("misuse") == ["USART1_CR2"]


def test_smartcard_mode_has_frames_without_a_clock(make_port):
    """Its drivers set CLKEN, too; frames of a card come in by themselves."""
    port = make_port().open(BRR, UE | TE | RE, CLKEN | LBCL, SCEN)
    port.hear(0x5A)
    assert port.peek("DR") == 0x5A
    begin = port.chip.time.now
    port.poke("DR", 0x55)
    port.bits(12)
    assert edges(port, begin) == []
    assert port.values == [0x55]


@each(("cr2", "cr3"), [(LINEN, 0), (0, HDSEL), (0, IREN)])
def test_modes_that_are_not_beside_it(make_port, cr2, cr3):
    port = make_port().open(BRR, UE | TE | RE, CLKEN | cr2, cr3)
    assert "USART1_CR2.CLKEN" in port.chip.noted("misuse")
