"""What a USART with ISR and ICR sends and reads: order and levels of bits, rates, tolerance, timeouts, mute mode."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.serial_line import SerialFormat, Words

PE, FE, NF, ORE, IDLE, RXNE, TC, TXE = (1 << bit for bit in range(8))
LBDF, CTSIF, RTOF, BUSY, CMF, SBKF, RWU = (1 << bit for bit in (8, 9, 11, 16, 17, 18, 19))
UE, RE, TE, PS, PCE, WAKE, M0, MME, OVER8, M1 = (1 << bit for bit in (0, 2, 3, 9, 10, 11, 12, 13, 15, 28))
ADDM7, LINEN, SWAP, RXINV, TXINV, DATAINV, MSBFIRST, RTOEN = (1 << bit for bit in (4, 14, 15, 16, 17, 18, 19, 23))
HDSEL, RTSE, CTSE, ONEBIT, OVRDIS = (1 << bit for bit in (3, 8, 9, 11, 12))
QUIET = TXE | TC


# --- sending


@pytest.mark.parametrize(("over8", "brr"), [(False, 16), (False, 469), (True, 0x10), (True, 0x1D3)])
@pytest.mark.parametrize("divider", [1, 4])
def test_txe_and_tc_to_the_cycle(make_port, over8, brr, divider):
    port = make_port(216_000_000, divider).open(brr, TE | RE | (OVER8 if over8 else 0))
    bit = port.bit
    start = port.now
    port.poke("TDR", 0x55)
    assert port.flags == TXE
    port.poke("TDR", 0xAA)
    assert port.flags == 0
    port.chip.advance_to(start + 10 * bit - 1)
    assert port.flags == 0
    port.chip.advance(1)
    assert port.flags == TXE
    port.chip.advance_to(start + 20 * bit - 1)
    assert port.flags == TXE
    port.chip.advance(1)
    assert port.flags == TXE | TC
    assert port.values == [0x55, 0xAA]
    assert {frame.bit_s for _, frame in port.sent} == {1 / port.usart.baud_hz}


# The second is as near to it as makes no difference, but its ratio to HCLK has more digits than C counts with.
HSI_HZ = (16_000_000, 16_000_000 + Fraction(1, 10**20))


@pytest.mark.parametrize("kernel_hz", HSI_HZ)
def test_a_bit_may_be_a_fraction_of_a_cycle(make_port, kernel_hz):
    """HSI at 16 MHz beside HCLK at 216 MHz: 139 ticks are 1876.5 cycles."""
    port = make_port(kernel_hz=kernel_hz).open(139)
    start = port.now
    port.poke("TDR", 0x00)
    port.poke("TDR", 0x00)
    port.chip.advance(40_000)
    assert [cycle - start for cycle, _ in port.sent] == [0, 18765]
    edges = [(cycle - start, level) for cycle, level in port.tx.edges if cycle >= start]
    assert edges == [(0, False), (16889, True), (18765, False), (18765 + 16889, True)]
    assert port.sent[0][1].bit_s == 139 / Fraction(kernel_hz)


@pytest.mark.parametrize("kernel_hz", HSI_HZ)
def test_so_may_one_that_comes_in(make_port, kernel_hz):
    port = make_port(kernel_hz=kernel_hz).open(139)
    start = port.now
    port.usart.receive(port.usart.format.frame(0x5A, port.chip.time.seconds(start), 1 / port.usart.baud_hz))
    for cycles, flag in ((18_062, RXNE), (2 * 18_765, IDLE)):
        port.chip.advance_to(start + cycles - 1)
        assert not port.flags & flag
        port.chip.advance(1)
        assert port.flags & flag
    assert port.peek("RDR") == 0x5A


def line_of(value, data_bits, parity, inverted, reversed_):
    """Return the bits between start and stop, the first to be sent first: the manual, word by word."""
    bits = [value >> bit & 1 for bit in range(data_bits)]
    ones = sum(bits)
    if reversed_:
        bits = bits[::-1]
    if parity:
        bits.append(ones % 2 if parity == "E" else 1 - ones % 2)
    return [1 - bit if inverted else bit for bit in bits]


@given(
    value=st.integers(0, 0x1FF),
    length=st.sampled_from([0, M0, M1]),
    parity=st.sampled_from([0, PCE, PCE | PS]),
    turned=st.sampled_from([0, MSBFIRST]),
    inverted=st.sampled_from([0, DATAINV]),
    levels=st.sampled_from([0, TXINV, RXINV, TXINV | RXINV]),
    swap=st.sampled_from([0, SWAP]),
)
def test_bits_and_levels_at_the_pin_and_back(make_port, value, length, parity, turned, inverted, levels, swap):
    port = make_port().open(64, TE | RE | length | parity, turned | inverted | levels | swap)
    word_bits = {0: 8, M0: 9, M1: 7}[length]
    data_bits = word_bits - bool(parity)
    letter = ("O" if parity & PS else "E") if parity else None
    expected = [0, *line_of(value, data_bits, letter, bool(inverted), bool(turned)), 1]
    output = port.tx_at_rx if swap else port.tx
    start, bit = port.now, int(port.bit)
    port.poke("TDR", value)
    port.bits(20)
    levels_at_pin = []
    for index in range(len(expected)):
        cycle = start + index * bit + bit // 2
        levels_at_pin.append([level for at, level in output.edges if at <= cycle][-1])
    assert levels_at_pin == [bool(level) is not bool(levels & TXINV) for level in expected]
    assert (port.tx if swap else port.tx_at_rx).level is None

    source = port.rx_at_tx if swap else port.rx
    source.drive(not levels & RXINV)
    port.bits(20)
    port.poke("RQR", 8)
    for level in expected:
        source.drive(bool(level) is not bool(levels & RXINV))
        port.chip.advance(bit)
    port.bits(2)
    assert port.flags & ~(IDLE | CMF) == QUIET | RXNE
    assert port.peek("RDR") & (1 << data_bits) - 1 == value & (1 << data_bits) - 1
    assert port.words[-1] == (value & (1 << data_bits) - 1, 0)


@pytest.mark.parametrize(("cr1", "cr2", "low"), [(0, 0, 10), (M0, 0, 11), (M1, 0, 9), (0, LINEN, 13)])
def test_a_break(port, cr1, cr2, low):
    port.open(cr1=TE | RE | cr1, cr2=cr2)
    start, bit = port.now, port.bit
    port.poke("RQR", 2)
    assert port.flags & SBKF
    assert [cycle for cycle, _ in port.sent] == [start]
    port.poke("TDR", 0x41)
    port.chip.advance_to(start + low * bit - 1)
    assert port.flags & SBKF
    port.chip.advance(1)
    assert not port.flags & SBKF
    port.bits(30)
    assert [(cycle - start) / bit for cycle, _ in port.sent] == [0, low + 1]
    assert port.sent[0][1].is_break


def test_a_break_waits_for_the_word_under_way(open_port):
    open_port.poke("TDR", 0x41)
    open_port.bits(3)
    open_port.poke("RQR", 2)
    open_port.bits(40)
    assert [frame.is_break for _, frame in open_port.sent] == [False, True]


def test_waiting_data_can_be_thrown_away(open_port):
    for value in (1, 2):
        open_port.poke("TDR", value)
    open_port.poke("RQR", 1 << 4)
    assert open_port.flags & TXE
    open_port.bits(40)
    assert open_port.values == [1]


def test_flow_control(port):
    port.cts.drive(True)
    port.open(cr3=CTSE | RTSE)
    assert port.rts.level is False
    port.poke("TDR", 1)
    port.bits(20)
    assert not port.sent
    port.cts.drive(False)
    assert port.flags & CTSIF
    port.bits(20)
    assert port.values == [1]
    port.hear(0x41)
    assert port.rts.level is True
    port.peek("RDR")
    assert port.rts.level is False


def test_half_duplex_hears_what_it_sends_and_others(port):
    port.open(cr3=HDSEL)
    assert port.tx.level is None
    port.poke("TDR", 0x5A)
    port.bits(15)
    assert port.peek("RDR") == 0x5A
    port.hear(0x33)
    assert port.peek("RDR") == 0x33
    assert port.tx.level is None


def test_half_duplex_on_an_inverted_line(port):
    port.open(0x40, cr2=TXINV | RXINV, cr3=HDSEL)
    port.rx_at_tx.drive(False)
    port.bits(20)
    for level in (True, False, True, False, True, False, True, False, True, False):  # a start bit, 0x55 and a stop bit
        port.rx_at_tx.drive(level)
        port.bits(1)
    assert port.words == [(0x55, 0)]


def test_rts_is_high_while_nothing_is_received(port):
    port.open(cr1=TE, cr3=RTSE)
    assert port.rts.level is True
    port.set("CR1", RE)
    assert port.rts.level is False


def test_frames_of_inverted_lines_are_noted(port):
    port.open(cr2=TXINV)
    assert port.chip.noted("assumed") == ["USART3_CR2.TXINV"]


# --- receiving


@pytest.mark.parametrize(("over8", "last"), [(False, 10), (True, 12)])
@pytest.mark.parametrize(
    ("cr1", "stop", "sixteenths"), [(0, 0, None), (M1, 0, None), (M0, 2, 16), (0, 3, 24), (0, 1, 8)]
)
def test_rxne_to_the_cycle(port, over8, last, cr1, stop, sixteenths):
    port.open(64, TE | RE | cr1 | (OVER8 if over8 else 0), stop << 12)
    bit, start = port.bit, port.now
    words = {0: 8, M0: 9, M1: 7}[cr1]
    port.hear(0x2A, wait=False)
    assert port.flags == QUIET | BUSY
    port.chip.advance_to(start + (16 * (words + 1) + (sixteenths or last)) * bit / 16 - 1)
    assert port.flags == QUIET | BUSY
    port.chip.advance(1)
    assert port.flags == QUIET | RXNE
    assert port.peek("RDR") == 0x2A
    assert port.flags == QUIET


# RM0410 table "Tolerance of the USART receiver when BRR[3:0] = 0000"
TOLERANCES = [
    (0, False, False, "3.75"),
    (0, False, True, "4.375"),
    (0, True, False, "2.5"),
    (0, True, True, "3.75"),
    (M0, False, False, "3.41"),
    (M0, False, True, "3.97"),
    (M0, True, False, "2.27"),
    (M0, True, True, "3.41"),
    (M1, False, False, "4.16"),
    (M1, False, True, "4.86"),
    (M1, True, False, "2.77"),
    (M1, True, True, "4.16"),
]


@pytest.mark.parametrize(("cr1", "over8", "one_sample", "percent"), TOLERANCES)
@pytest.mark.parametrize("side", ["inside", "outside"])
def test_tolerance(port, cr1, over8, one_sample, percent, side):
    """Of a sender that is too fast, and sends without a pause."""
    port.open(0x2000, TE | RE | cr1 | (OVER8 if over8 else 0), 0, ONEBIT if one_sample else 0)
    off = Fraction(percent) / 100 * (Fraction(99, 100) if side == "inside" else Fraction(102, 100))
    bit_s = (1 - off) / port.usart.baud_hz
    first = port.frame(0x155, bit_s=bit_s)
    port.hear_all(first, port.frame(0x0AA, bit_s=bit_s, start_s=first.end_s))
    assert bool(port.words[0][1] & (NF | FE)) is (side == "outside")


@given(
    values=st.lists(st.integers(0, 0x1FF), min_size=1, max_size=4),
    cr1=st.sampled_from([0, M0, M1, PCE, M0 | PCE | PS]),
    over8=st.sampled_from([0, OVER8]),
    percent=st.integers(-20, 20),
)
def test_frames_back_to_back_at_rates_that_are_a_bit_off(make_port, values, cr1, over8, percent):
    port = make_port().open(0x100, TE | RE | cr1 | over8)
    bit_s = (1 + Fraction(percent, 1000)) / port.usart.baud_hz
    start_s, frames = port.chip.time.seconds(port.now), []
    port.irq.on_set = lambda level: port.peek("RDR") if level else None
    port.set("CR1", 1 << 5)
    for value in values:
        frames.append(port.frame(value, bit_s=bit_s, start_s=start_s))
        start_s = frames[-1].end_s
    port.hear_all(*frames)
    mask = (1 << port.usart.format.data_bits) - 1
    assert port.words == [(value & mask, 0) for value in values]


def noisy(port):
    """Send a word whose first data bit is high in one sample only, at eight samples a bit or sixteen."""
    eighth = int(port.bit) // 8
    port.rx.drive(True)
    port.bits(20)
    port.rx.drive(False)
    port.chip.advance(8 * eighth + 4 * eighth)
    port.rx.drive(True)
    port.chip.advance(eighth // 2)
    port.rx.drive(False)
    port.chip.advance(9 * 8 * eighth - 12 * eighth - eighth // 2)
    port.rx.drive(True)
    port.bits(3)


@pytest.mark.parametrize(("cr1", "cr3", "noise"), [(OVER8, 0, NF), (0, 0, NF), (OVER8, ONEBIT, 0), (0, ONEBIT, 0)])
def test_noise(port, cr1, cr3, noise):
    port.open(0x80, TE | RE | cr1, 0, cr3)
    noisy(port)
    assert port.words == [(0, noise)]


@pytest.mark.parametrize("over8", [0, OVER8])
@pytest.mark.parametrize("sixteenths", [1, 4, 8])
def test_a_glitch_is_no_start_bit(port, over8, sixteenths):
    port.open(0x80, TE | RE | over8)
    port.rx.drive(True)
    port.bits(20)
    port.rx.drive(False)
    port.chip.advance(int(sixteenths * port.bit / 16))
    port.rx.drive(True)
    port.bits(40)
    assert port.flags == QUIET
    port.hear(0x41)
    assert port.peek("RDR") == 0x41


def test_errors_are_cleared_by_icr_alone(open_port):
    open_port.hear(0x55, bits=0x055, bit_count=9)
    assert open_port.flags == QUIET | RXNE | FE
    open_port.peek("RDR")
    assert open_port.flags == QUIET | FE
    open_port.poke("ICR", FE)
    assert open_port.flags == QUIET


def test_a_parity_error(port):
    port.open(cr1=RE | M0 | PCE)
    port.hear(0x55, like="8O1")
    assert port.flags == QUIET | RXNE | PE
    assert port.peek("RDR") == 0x155  # the parity bit is read as well


def test_an_overrun(open_port):
    for value in (1, 2):
        open_port.hear(value)
    assert open_port.flags & ~IDLE == QUIET | RXNE | ORE
    assert open_port.peek("RDR") == 1
    open_port.hear(3)
    assert open_port.flags & ~IDLE == QUIET | RXNE | ORE
    assert open_port.peek("RDR") == 3
    open_port.poke("ICR", ORE)
    assert open_port.flags & ~IDLE == QUIET
    assert open_port.words == [(1, 0), (2, ORE), (3, 0)]


def test_without_overrun_detection_the_newest_word_stays(port):
    port.open(cr3=OVRDIS)
    for value in (1, 2):
        port.hear(value)
    assert port.flags & ~IDLE == QUIET | RXNE
    assert port.peek("RDR") == 2


def test_received_data_can_be_thrown_away(open_port):
    open_port.hear(1)
    open_port.poke("RQR", 8)
    assert open_port.flags == QUIET


def test_idle_one_frame_after_the_stop_bit(open_port):
    start, bit = open_port.now, open_port.bit
    open_port.hear(0x5A)
    open_port.peek("RDR")
    open_port.chip.advance_to(start + 20 * bit - 1)
    assert not open_port.flags & IDLE
    open_port.chip.advance(1)
    assert open_port.flags & IDLE
    open_port.poke("ICR", IDLE)
    open_port.bits(50)
    assert not open_port.flags & IDLE


@pytest.mark.parametrize("timeout", [1, 35, 200])
def test_a_timeout_after_the_last_word(port, timeout):
    port.open(cr2=RTOEN, rtor=timeout)
    port.bits(500)
    assert not port.flags & RTOF
    bit = port.bit
    port.hear(1)
    start = port.now
    port.hear(2)
    port.chip.advance_to(start + (10 + timeout) * bit - 1)
    assert not port.flags & RTOF
    port.chip.advance(1)
    assert port.flags & RTOF
    port.poke("ICR", RTOF)
    port.bits(500)
    assert not port.flags & RTOF


def test_a_timeout_does_not_come_between_words(port):
    port.open(cr2=RTOEN, rtor=20)
    for pause in (0, 5, 19):
        port.bits(pause)
        assert not port.flags & RTOF, pause
        port.hear(pause)
    port.bits(20)
    assert port.flags & RTOF


def test_a_glitch_without_a_word_begins_no_timeout(port):
    port.open(cr2=RTOEN, rtor=20)
    port.rx.drive(True)
    port.bits(30)
    port.rx.drive(False)
    port.chip.advance(4)
    port.rx.drive(True)
    port.bits(100)
    assert not port.flags & RTOF


def test_a_glitch_after_a_timeout_begins_none(port):
    port.open(cr2=RTOEN, rtor=20)
    port.hear(1)
    port.bits(30)
    port.poke("ICR", RTOF)
    port.rx.drive(True)
    port.rx.drive(False)
    port.chip.advance(4)
    port.rx.drive(True)
    port.bits(100)
    assert not port.flags & RTOF


def test_character_match(port):
    port.open(cr2=0x0A << 24)
    port.hear(0x41)
    assert not port.flags & CMF
    port.hear(0x0A)
    assert port.flags & CMF
    port.poke("ICR", CMF)
    assert not port.flags & CMF


def test_lin_break(port):
    port.open(cr2=LINEN)
    port.hear(0, bits=0, bit_count=12)
    port.bits(3)
    assert port.flags & LBDF


class TestMute:
    def test_until_the_line_is_idle(self, port):
        port.open(cr1=RE | MME)
        port.poke("RQR", 4)
        assert port.flags & RWU
        port.hear(1)
        port.hear(2)
        assert port.flags == QUIET | RWU
        port.bits(11)
        assert port.flags == QUIET
        port.hear(3)
        assert port.peek("RDR") == 3

    def test_the_request_does_nothing_without_mme(self, open_port):
        open_port.poke("RQR", 4)
        assert not open_port.flags & RWU

    @pytest.mark.parametrize(
        ("cr1", "cr2", "mine", "other"),
        [
            (0, 0x05 << 24, 0x85, 0x86),
            (0, 0x05 << 24, 0xF5, 0xF6),  # four bits are compared
            (0, ADDM7 | 0x75 << 24, 0xF5, 0x85),
            (M0, ADDM7 | 0x75 << 24, 0x175, 0x1F5),
            (M1, ADDM7 | 0x15 << 24, 0x55, 0x56),
        ],
    )
    def test_until_the_address_comes(self, port, cr1, cr2, mine, other):
        port.open(cr1=RE | MME | WAKE | cr1, cr2=cr2)
        port.hear(other)
        assert port.flags & ~CMF == QUIET | RWU
        port.hear(0x11)
        assert not port.flags & RXNE
        port.hear(mine)
        assert port.flags & (RXNE | RWU) == RXNE
        assert port.peek("RDR") == mine
        port.hear(0x12)
        assert port.peek("RDR") == 0x12
        port.hear(other)
        assert port.flags & (RXNE | RWU) == RWU


def test_receive_takes_a_frame_of_another_format(open_port):
    frame = SerialFormat.parse("7E2").frame(0x2A, open_port.chip.time.seconds(open_port.now), Fraction(1, 3_375_000))
    open_port.usart.receive(frame)
    open_port.bits(20)
    assert open_port.words == [(0x2A | 0x80, 0)]


def test_a_frame_of_the_past_may_be_expected_while_the_clock_gets_faster(make_port):
    """At the new rate its start lies before the first cycle."""
    port = make_port(8_000_000, kernel_hz=8_000_000).open()
    later_ns = port.chip.time.ns(port.now) + 1000
    port.usart.expect(Words([0, later_ns], [0x55, 0x66], Fraction(16, 8_000_000), 8))
    port.chip.change_clock(216_000_000)
    port.bits(40)
    assert port.usart.expected == 0
    assert port.words[-1][0] == 0x66
