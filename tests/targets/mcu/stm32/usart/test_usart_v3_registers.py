"""Registers of the USART with ISR and ICR: rates, what is locked, flags and lines (RM0410 section 34)."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.services import Watch

PE, FE, NF, ORE, IDLE, RXNE, TC, TXE, LBDF, CTSIF, CTS, RTOF, EOBF = (1 << bit for bit in range(13))
BUSY, CMF, SBKF, RWU, WUF, TEACK, REACK = (1 << bit for bit in range(16, 23))
UE, RE, TE, PS, PCE, M0, OVER8, M1 = 1 << 0, 1 << 2, 1 << 3, 1 << 9, 1 << 10, 1 << 12, 1 << 15, 1 << 28


def test_reset_values(port):
    for name in ("CR1", "CR2", "CR3", "BRR", "GTPR", "RTOR", "RQR", "ICR", "RDR", "TDR"):
        assert port.peek(name) == 0, name
    assert port.peek("ISR") == TXE | TC | CTS  # the pin of CTS is low


# RM0410 section 34.5.4: the examples, and the ends of the table at 216 MHz
@pytest.mark.parametrize(
    ("kernel_hz", "over8", "brr", "usartdiv"),
    [
        (8_000_000, False, 0x341, 833),
        (8_000_000, True, 0x681, 0x682),
        (48_000_000, False, 0x34, 52),
        (48_000_000, True, 0x64, 104),
        (216_000_000, False, 0x57E4, 22500),
        (216_000_000, False, 0x753, 1875),
        (216_000_000, False, 0x10, 16),
        (216_000_000, True, 0x10, 16),
    ],
)
def test_the_rate(make_port, kernel_hz, over8, brr, usartdiv):
    port = make_port(kernel_hz=kernel_hz)
    port.poke("CR1", OVER8 if over8 else 0)
    port.poke("BRR", brr)
    assert port.usart.baud_hz == Fraction(kernel_hz * (2 if over8 else 1), usartdiv)
    assert not port.chip.noted()


def test_the_rate_follows_over8_and_the_clock(port):
    settings = []
    port.usart.on_format_change = lambda: settings.append(port.usart.baud_hz)
    port.poke("BRR", 0x20)
    port.poke("CR1", OVER8)
    port.chip.change_clock(APB1=8)
    port.kernel_hz = 16_000_000
    port.chip.change_clock()
    assert settings == [54_000_000 / Fraction(32), 54_000_000 / Fraction(16), 27_000_000 / Fraction(16), 1_000_000]


@pytest.mark.parametrize(("cr1", "brr"), [(0, 15), (OVER8, 0x7), (0, 0)])
def test_a_divider_below_16_is_noted_and_does_nothing(port, cr1, brr):
    port.open(brr, TE | RE | cr1, past_preamble=False)
    assert port.chip.noted("misuse") == ["USART3_BRR"]
    assert port.peek("ISR") & (TEACK | REACK) == 0


def test_bit_3_of_brr_is_noted_with_over8(port):
    port.poke("CR1", OVER8)
    port.poke("BRR", 0x48)
    assert port.chip.noted("misuse") == ["USART3_BRR"]
    assert port.usart.baud_hz == Fraction(2 * 54_000_000, 0x40)


@pytest.mark.parametrize(
    ("cr1", "cr2", "text"),
    [
        (0, 0, "8N1"),
        (M0, 0, "9N1"),
        (M1, 0, "7N1"),
        (M1 | PCE, 0, "6E1"),
        (PCE | PS, 2 << 12, "7O2"),
        (M0 | PCE, 3 << 12, "8E1.5"),
        (0, 1 << 12, "8N0.5"),
    ],
)
def test_the_format_for_people(port, cr1, cr2, text):
    port.open(cr1=TE | RE | cr1, cr2=cr2)
    assert str(port.usart.format) == text


@pytest.mark.parametrize(
    ("register", "locked"),
    [
        ("CR1", 0x1000_0000 | 0x03FF_0000 | 0x9E00),
        ("CR2", 0x006F_FF30 & ~(1 << 20)),
        ("CR3", 0x003E_FB3E & ~(1 << 20) | 0x0030_0000),
        ("BRR", 0xFFFF),
        ("GTPR", 0xFFFF),
    ],
)
def test_what_is_locked_while_ue_is_set(port, register, locked):
    port.open(past_preamble=False)
    before = port.peek(register)
    writable = {"CR1": 0x1FFF_FFFF, "CR2": 0x00FF_FF70, "CR3": 0x00FE_FFFF, "BRR": 0xFFFF, "GTPR": 0xFFFF}[register]
    port.poke(register, ~before & writable | (UE if register == "CR1" else 0))
    stayed = ~(before ^ port.peek(register)) & writable
    if register == "CR1":
        stayed &= ~UE
    assert stayed == locked
    assert f"USART3_{register}" in port.chip.noted("misuse")


def test_the_address_is_locked_while_the_receiver_is_enabled(port):
    port.open(cr1=RE, past_preamble=False)
    port.poke("CR2", 0x41 << 24)
    assert port.peek("CR2") == 0
    port.clear("CR1", RE)
    port.poke("CR2", 0x41 << 24)
    assert port.peek("CR2") == 0x41 << 24


def test_everything_may_change_in_the_write_that_clears_ue(port):
    port.open()
    port.poke("CR1", M1)
    assert port.peek("CR1") == M1
    assert str(port.usart.format) == "7N1"


@pytest.mark.parametrize(
    ("register", "bit"), [("CR2", 20), ("CR2", 11), ("CR3", 1), ("CR3", 5), ("CR3", 14), ("CR1", 1)]
)
def test_modes_that_are_missing_are_noted(port, register, bit):
    port.poke(register, 1 << bit)
    assert port.chip.noted("unmodelled") == [f"USART3_{register}"]


def test_auto_baud_request_is_noted(port):
    port.poke("RQR", 1)
    assert port.chip.noted("unmodelled") == ["USART3_RQR"]


def test_teack_and_reack(port):
    port.open(past_preamble=False)
    assert port.peek("ISR") & (TEACK | REACK) == TEACK | REACK
    port.clear("CR1", RE)
    assert port.peek("ISR") & (TEACK | REACK) == TEACK
    port.clear("CR1", UE)
    assert port.peek("ISR") & (TEACK | REACK) == 0


def test_clearing_ue_stops_and_sets_the_flags_as_after_reset(open_port):
    open_port.hear(0x41)
    open_port.hear(0x42)
    open_port.poke("TDR", 1)
    open_port.poke("TDR", 2)
    assert open_port.flags == RXNE | ORE
    open_port.clear("CR1", UE)
    assert open_port.flags == TXE | TC
    assert open_port.tx.level is None
    assert open_port.chip.noted("misuse") == ["USART3_CR1.UE"]
    open_port.set("CR1", UE)
    open_port.bits(40)
    assert open_port.values == [1]


def test_a_word_written_while_ue_is_clear_is_lost(port):
    port.poke("TDR", 1)
    assert port.chip.noted("misuse") == ["USART3_TDR"]
    port.open()
    port.bits(20)
    assert not port.sent


def test_cts_is_the_inverse_of_its_pin(port):
    assert port.peek("ISR") & CTS
    port.cts.drive(True)
    assert not port.peek("ISR") & CTS
    assert not port.peek("ISR") & CTSIF


FLAGS = PE | FE | NF | ORE | IDLE | RXNE | TC | TXE | LBDF | CTSIF | RTOF | CMF
CLEARED = PE | FE | NF | ORE | IDLE | TC | LBDF | CTSIF | RTOF | CMF


@given(flags=st.integers(0, 0x7F_FFFF), written=st.integers(0, 0xFFFF_FFFF))
def test_icr_clears_what_it_names(make_port, flags, written):
    port = make_port().open(past_preamble=False)
    port.usart[0x1C] = flags & FLAGS
    port.poke("ICR", written)
    assert port.usart[0x1C] == flags & FLAGS & ~(written & CLEARED)
    assert port.peek("ICR") == 0


ENABLES = {  # RM0410 table "USART interrupt requests": enable, and the flags that it lets through
    ("CR1", 1 << 4): IDLE,
    ("CR1", 1 << 5): RXNE | ORE,
    ("CR1", 1 << 6): TC,
    ("CR1", 1 << 7): TXE,
    ("CR1", 1 << 8): PE,
    ("CR1", 1 << 14): CMF,
    ("CR1", 1 << 26): RTOF,
    ("CR2", 1 << 6): LBDF,
    ("CR3", 1 << 0): FE | NF | ORE,
    ("CR3", 1 << 10): CTSIF,
}


@pytest.mark.parametrize("enable", ENABLES)
@given(flags=st.integers(0, 0x7F_FFFF))
def test_the_interrupt_is_the_level_of_flags_and_enables(make_port, enable, flags):
    port = make_port().open(past_preamble=False)
    port.usart[0x1C] = flags & FLAGS
    port.set(*enable)
    assert port.irq.level is bool(flags & ENABLES[enable])


@given(flags=st.integers(0, 0xFF), ddre=st.booleans())
def test_dma_requests(make_port, flags, ddre):
    port = make_port().open(cr3=1 << 13 if ddre else 0, past_preamble=False)
    port.usart[0x1C] = flags
    port.set("CR3", 1 << 6 | 1 << 7)
    assert port.dma_tx.level is bool(flags & TXE)
    assert port.dma_rx.level is (bool(flags & RXNE) and not (ddre and flags & (PE | FE | NF | ORE)))


def test_a_clock_that_stands_still_is_no_misuse(open_port):
    open_port.kernel_hz = 0
    open_port.chip.change_clock()
    open_port.hear(0x41, bit_s=Fraction(1, 3_375_000))
    assert open_port.flags == TXE | TC
    assert open_port.tx.level is True
    assert not open_port.chip.noted()


@pytest.mark.parametrize(("register", "remembered", "enable"), [("CR1", 1 << 1, 1 << 6), ("CR3", 1 << 14, 1 << 0)])
def test_an_enable_beside_a_bit_that_is_only_remembered_sets_up_nothing_anew(port, register, remembered, enable):
    """What was kept of the words that were sent stays one piece; UESM is remembered, and DEM would be without UE."""
    port.tx.set_watch(Watch.NOBODY)
    port.usart.keeps_words = True
    port.open(0x20, TE)
    port.set(register, remembered)
    for value in (0x55, 0x66):
        port.poke("TDR", value)
        port.bits(12)
        port.poke(register, port.peek(register) | remembered | enable)
    assert [words.bits for words in port.usart.take_words()] == [[0x55, 0x66]]
    assert port.peek(register) & enable
    assert port.chip.noted("unmodelled") == [f"USART3_{register}"]
