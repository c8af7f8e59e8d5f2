"""Registers of the USART, the lines they drive, and what it says of itself."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.each import each

RESET = {"SR": 0xC0, "DR": 0, "BRR": 0, "CR1": 0, "CR2": 0, "CR3": 0, "GTPR": 0}
WRITABLE = {"BRR": 0xFFFF, "CR1": 0x3FFE, "CR2": 0x7F6F, "CR3": 0x7FF, "GTPR": 0xFFFF}


def test_reset_values(port):
    assert {name: port.peek(name) for name in RESET} == RESET


def test_reset_from_anywhere(open_port):
    open_port.cts.drive(True)
    open_port.poke("CR3", 0x7C0)
    open_port.poke("CR1", 0x3DFC)
    open_port.poke("DR", 1)
    open_port.hear(0x55)
    open_port.usart.reset()
    assert {name: open_port.peek(name) for name in RESET} == RESET
    assert [line.level for line in (open_port.irq, open_port.dma_tx, open_port.dma_rx)] == [False] * 3
    assert open_port.tx.level is None
    open_port.chip.advance(100_000)
    assert open_port.flags == 0xC0


@pytest.mark.parametrize(("name", "mask"), WRITABLE.items())
def test_reserved_bits_stay_zero(port, name, mask):
    port.poke(name, 0xFFFF_FFFF & ~(1 if name == "CR1" else 0))
    assert port.peek(name) == mask


@pytest.mark.parametrize(("register", "bits"), [("CR3", 0x02), ("CR3", 0x20)])
def test_modes_that_are_missing_are_noted(port, register, bits):
    port.poke(register, bits)
    assert port.chip.noted("unmodelled") == [f"USART1_{register}"]


@pytest.mark.parametrize("brr", [0, 15])
def test_a_divider_below_one_is_misuse_and_does_nothing(port, brr):
    port.open(brr, past_preamble=False)
    assert port.chip.noted("misuse") == ["USART1_BRR"]
    port.poke("DR", 0x41)
    port.chip.advance(1_000_000)
    assert not port.sent
    assert port.usart.baud_hz == 0
    port.poke("BRR", 16)
    port.chip.advance(1_000_000)
    assert port.values == [0x41]


def test_a_bus_that_stands_still_is_no_misuse(port):
    port.open(625)
    port.chip.change_clock(APB1=0, APB2=0)  # as Stop does
    assert port.usart.baud_hz == 0
    port.chip.change_clock(APB1=1, APB2=1)
    port.poke("DR", 0x41)
    port.chip.advance(100_000)
    assert port.values == [0x41]
    assert not port.chip.notes.all


@pytest.mark.parametrize(
    ("cr1", "cr2", "text"),
    [
        (0x0000, 0x0000, "8N1"),
        (0x1000, 0x0000, "9N1"),
        (0x0400, 0x0000, "7E1"),
        (0x0600, 0x2000, "7O2"),
        (0x1400, 0x2000, "8E2"),
        (0x1600, 0x3000, "8O1.5"),
        (0x1000, 0x1000, "9N0.5"),
        (0x0200, 0x0000, "8N1"),
    ],
)
def test_the_format_for_people(port, cr1, cr2, text):
    port.poke("CR2", cr2)
    port.poke("CR1", cr1)
    assert str(port.usart.format) == text


@each(
    ("hclk_hz", "divider", "brr", "baud"),
    # RM0008, "Error calculation for programmed baud rates": 36 MHz and 72 MHz
    [
        (36_000_000, 1, 0x3A98, 2400),
        (36_000_000, 1, 0xEA6, 9600),
        (36_000_000, 1, 0x753, 19200),
        (72_000_000, 2, 0x138, "115384.615"),
        (72_000_000, 1, 0x271, 115200),
        (72_000_000, 1, 0x4E, "923076.923"),
        (72_000_000, 1, 0x10, 4_500_000),
        (72_000_000, 2, 0x10, 2_250_000),
    ],
)
def test_the_baud_rate_follows_the_divider(make_port, hclk_hz, divider, brr, baud):
    port = make_port(hclk_hz, {"APB1": divider}, "USART2")
    port.poke("BRR", brr)
    assert abs(port.usart.baud_hz - Fraction(baud)) < Fraction(1, 1000)


def test_changes_of_rate_and_format_are_told_once_each(port):
    told = []
    port.usart.on_format_change = lambda: told.append((int(port.usart.baud_hz), str(port.usart.format)))
    port.poke("BRR", 7500)
    port.poke("CR1", 0x1400)
    port.poke("CR1", 0x14F0)
    port.poke("CR3", 0xC0)
    port.chip.change_clock(APB2=2)
    port.chip.change_clock(36_000_000, APB2=1)
    assert told == [(9600, "8N1"), (9600, "8E1"), (4800, "8E1")]


@given(
    flags=st.integers(0, 0x3FF),
    enables=st.integers(0, 0x1F),
    lbdie=st.booleans(),
    cr3=st.integers(0, 0x7FF),
)
def test_lines_are_the_levels_of_flags_and_enables(make_port, flags, enables, lbdie, cr3):
    """RM0008 section 27.4, USART interrupts and interrupt mapping diagram."""
    port = make_port()
    port.usart[0x00] = flags
    port.poke("CR1", enables << 4)
    port.poke("CR2", lbdie << 6)
    port.poke("CR3", cr3)

    def flag(bit):
        return flags >> bit & 1

    def enabled(bit):
        return enables << 4 >> bit & 1

    pe, fe, ne, ore, idle, rxne, tc, txe, lbd, cts = (flag(bit) for bit in range(10))
    eie, dmar, dmat, ctsie = cr3 & 1, cr3 >> 6 & 1, cr3 >> 7 & 1, cr3 >> 10 & 1
    wanted = [
        txe & enabled(7),
        tc & enabled(6),
        (rxne | ore) & enabled(5),
        idle & enabled(4),
        pe & enabled(8),
        lbd & lbdie,
        cts & ctsie,
        eie & dmar & (fe | ne | ore),
    ]
    assert port.irq.level is any(wanted)
    assert port.dma_tx.level is bool(txe & dmat)
    assert port.dma_rx.level is bool(rxne & dmar)


@each("name", ["USART1", "USART2", "USART3"])
def test_each_has_its_own_lines(make_port, name):
    port = make_port(name=name).open(cr1=0x20AC, cr3=0xC0)
    port.hear(0x12)
    assert (port.irq.level, port.dma_tx.level, port.dma_rx.level) == (True, True, True)


@given(flags=st.integers(0, 0x3FF), written=st.integers(0, 0xFFFF_FFFF))
def test_only_four_flags_are_cleared_by_writing_zero(make_port, flags, written):
    port = make_port()
    port.usart[0x00] = flags
    port.poke("SR", written)
    assert port.flags == flags & (written | ~0x360)


@given(
    flags=st.integers(0, 0x3FF),
    steps=st.lists(st.sampled_from(("read SR", "read DR", "write DR")), max_size=6),
    late=st.integers(0, 0x1F),
)
def test_clear_sequences(make_port, flags, steps, late):
    """SR then DR: PE FE NE ORE IDLE by a read of DR, PE and TC by a write; of flags that the read of SR has seen."""
    port = make_port()  # disabled: nothing but these accesses changes a flag
    port.usart[0x00] = flags
    seen = 0
    for index, step in enumerate(steps):
        if index == 3:
            port.usart[0x00] |= late
            flags |= late
        if step == "read SR":
            seen = port.peek("SR")
            assert seen == flags
        elif step == "read DR":
            port.peek("DR")
            flags &= ~(0x20 | seen & 0x1F)
            seen &= ~0x1F
        else:
            port.poke("DR", 0)
            flags &= ~(0x80 | seen & 0x41)
            seen &= ~0x41
        assert port.flags == flags


def test_addresses_between_the_registers(port):
    port.usart.write(0x1C, 1)
    assert port.usart.read(0x1C) == 0
    assert port.chip.noted("reserved") == ["USART1_0x1C"]


def test_in_stop_the_line_keeps_its_level_and_no_preamble_follows(port):
    """All pins keep the state of Run mode (RM0008 section 4.3.4)."""
    port.open()
    port.chip.change_clock(APB1=0, APB2=0)
    assert port.tx.level is True
    port.chip.change_clock(APB1=1, APB2=1)
    port.poke("DR", 0x41)
    assert [frame.bits for _, frame in port.sent] == [0x41]
    assert port.chip.notes.all == []


def test_a_frame_that_stop_breaks_off_is_noted(port):
    port.open()
    port.poke("DR", 0x41)
    port.chip.change_clock(APB1=0, APB2=0)
    assert [note.where for note in port.chip.notes.all] == ["USART1_SR.TC"]
