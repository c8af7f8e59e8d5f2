"""Sending: the order and the cycles of TXE and TC, preamble, break, flow control, what is on the wire."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.services import Watch
from tests.each import each

TXE, TC = 0x80, 0x40
UE, M, PCE, PS, TE, RE, SBK = 0x2000, 0x1000, 0x400, 0x200, 8, 4, 1


def changes(port, cycles, mask=TXE | TC):
    """Let cycles pass one by one; return each change of the flags as (cycles from now, flags)."""
    start, flags, found = port.now, port.flags & mask, []
    for _ in range(cycles):
        port.chip.advance(1)
        if port.flags & mask != flags:
            flags = port.flags & mask
            found.append((port.now - start, flags))
    return found


RATES = [
    (hclk_hz, divider, baud)
    for hclk_hz, divider in ((8_000_000, 1), (36_000_000, 1), (72_000_000, 1), (72_000_000, 2))
    for baud in (9600, 19200, 57600, 115200, 230400, 460800, 921600)
    if hclk_hz // divider // baud >= 16
]


@each(("hclk_hz", "divider", "baud"), RATES)
def test_txe_and_tc_to_the_cycle(make_port, baud, hclk_hz, divider):
    port = make_port(hclk_hz, {"APB1": divider}, "USART2")
    brr = (hclk_hz // divider + baud // 2) // baud
    port.open(brr)
    bit = brr * divider
    start = port.now
    port.peek("SR")
    port.poke("DR", 0x55)
    assert port.flags == TXE  # moved on at once, and TC cleared by the sequence
    port.poke("DR", 0xAA)
    assert port.flags == 0
    port.chip.advance_to(start + 10 * bit - 1)
    assert port.flags == 0
    port.chip.advance(1)
    assert port.flags == TXE
    port.poke("DR", 0x0F)
    port.chip.advance_to(start + 20 * bit)
    assert port.flags == TXE  # TC not set: the next word was waiting
    port.chip.advance_to(start + 30 * bit - 1)
    assert port.flags == TXE
    port.chip.advance(1)
    assert port.flags == TXE | TC
    assert [cycle for cycle, _ in port.sent] == [start, start + 10 * bit, start + 20 * bit]
    assert port.values == [0x55, 0xAA, 0x0F]
    assert {frame.bit_s for _, frame in port.sent} == {Fraction(bit, hclk_hz)}


def test_the_preamble_holds_the_first_word_in_the_data_register(port):
    port.open(past_preamble=False)
    assert port.flags == TXE | TC
    port.peek("SR")
    port.poke("DR", 0x41)
    assert port.flags == 0
    # one bit, and a frame of ones: TXE when it moves on, TC when it has gone
    assert changes(port, 400) == [(11 * 16, TXE), (21 * 16, TXE | TC)]
    assert [cycle for cycle, _ in port.sent] == [11 * 16]


@pytest.mark.parametrize(("cr1", "cr2", "bits"), [(M, 0, 12), (0, 0x2000, 12), (M, 0x2000, 13), (M | PCE, 0, 12)])
def test_the_preamble_is_as_long_as_a_frame(port, cr1, cr2, bits):
    port.open(cr1=UE | TE | cr1, cr2=cr2, past_preamble=False)
    port.poke("DR", 0x41)
    port.chip.advance(1000)
    assert [cycle for cycle, _ in port.sent] == [bits * 16]


def test_tc_stays_set_without_the_sequence(open_port):
    """The trap of the first byte: TC is set after reset and only a read of SR lets a write to DR clear it."""
    open_port.poke("DR", 0x41)
    assert open_port.flags == TXE | TC
    open_port.bits(5)
    open_port.poke("DR", 0x42)
    assert open_port.flags == TC


def test_tc_cleared_by_writing_zero_comes_back_after_the_next_frame_only(open_port):
    open_port.poke("SR", 0x3FF & ~TC)
    open_port.bits(100)
    assert open_port.flags == TXE
    open_port.poke("DR", 0x41)
    assert changes(open_port, 200) == [(160, TXE | TC)]


def test_a_word_in_the_data_register_is_overwritten(open_port):
    for value in (1, 2, 3):
        open_port.poke("DR", value)
    open_port.bits(50)
    assert open_port.values == [1, 3]


@given(
    cr1=st.sampled_from((0, M, PCE, PCE | PS, M | PCE, M | PCE | PS)),
    stop=st.integers(0, 3),
    values=st.lists(st.integers(0, 0x1FF), min_size=1, max_size=5),
    brr=st.integers(16, 40),
)
def test_words_stand_on_the_wire_as_the_format_says(make_port, cr1, stop, values, brr):
    port = make_port().open(brr, UE | TE | cr1, stop << 12)
    half_bits = 2 * (10 if cr1 & M else 9) + (2, 1, 4, 3)[stop]
    start = port.now
    for value in values:
        while not port.peek("SR") & TXE:
            port.chip.advance(1)
        port.poke("DR", value)
    port.bits(60)
    width = 9 if cr1 & M else 8
    for index, (cycle, frame) in enumerate(port.sent):
        # a half bit of an odd divider ends in mid-cycle
        assert 0 <= cycle - start - Fraction(index * half_bits * brr, 2) <= index
        assert (frame.bit_count, frame.stop_half_bits) == (width, (2, 1, 4, 3)[stop])
        if cr1 & PCE:
            data = values[index] & (1 << width - 1) - 1
            assert frame.bits & (1 << width - 1) - 1 == data
            assert frame.bits.bit_count() & 1 == bool(cr1 & PS)
        else:
            assert frame.bits == values[index] & (1 << width) - 1
    assert len(port.sent) == len(values)


class TestTurnedOff:
    def test_te_off_and_on_in_mid_frame_sends_a_preamble_after_it(self, open_port):
        start = open_port.now
        open_port.poke("DR", 1)
        open_port.poke("DR", 2)
        open_port.bits(3)
        open_port.clear("CR1", TE)
        open_port.set("CR1", TE)
        open_port.bits(60)
        assert [cycle - start for cycle, _ in open_port.sent] == [0, (10 + 11) * 16]
        assert not open_port.chip.noted()

    def test_te_off_lets_the_frame_end_and_notes_it(self, open_port):
        open_port.peek("SR")
        open_port.poke("DR", 1)
        open_port.poke("DR", 2)
        open_port.clear("CR1", TE)
        open_port.bits(60)
        assert open_port.values == [1]
        assert open_port.flags == 0
        assert open_port.tx.level is None
        assert open_port.chip.noted("misuse") == ["USART1_CR1.TE"]
        open_port.set("CR1", TE)
        open_port.bits(60)
        assert open_port.values == [1, 2]
        assert open_port.flags == TXE | TC

    def test_ue_off_lets_the_byte_end(self, open_port):
        open_port.peek("SR")
        open_port.poke("DR", 1)
        open_port.clear("CR1", UE)
        assert changes(open_port, 300) == [(160, TXE | TC)]
        assert open_port.tx.level is None
        assert not open_port.chip.noted()

    def test_a_word_written_before_ue_waits(self, port):
        port.poke("BRR", 16)
        port.poke("DR", 0x33)
        assert port.flags == TC
        port.poke("CR1", TE)
        port.bits(50)
        assert not port.sent
        port.set("CR1", UE)
        port.bits(50)
        assert port.values == [0x33]

    def test_the_pin_is_driven_while_te_and_ue_are_on(self, port):
        assert port.tx.level is None
        port.open()
        assert port.tx.level is True
        port.clear("CR1", TE)
        assert port.tx.level is None


class TestBreak:
    @pytest.mark.parametrize(
        ("cr1", "cr2", "low", "stop"),
        [(0, 0, 10, 1), (M, 0, 11, 1), (0, 0x2000, 10, 2), (0, 0x4000, 13, 1), (M, 0x4000, 13, 1)],
    )
    def test_its_length_and_when_sbk_is_cleared(self, port, cr1, cr2, low, stop):
        port.open(cr1=UE | TE | cr1, cr2=cr2)
        start = port.now
        port.set("CR1", SBK)
        port.poke("DR", 0x55)
        port.chip.advance(low * 16 - 1)
        assert port.peek("CR1") & SBK
        port.chip.advance(1)
        assert not port.peek("CR1") & SBK
        port.bits(30)
        (first, frame), (second, _) = port.sent
        assert first == start
        assert second == start + (low + stop) * 16
        assert frame.is_break
        assert frame.edges()[-1] == (frame.start_s + low * frame.bit_s, True)
        assert frame.end_s == port.chip.time.seconds(second)

    def test_it_waits_for_the_frame_and_goes_before_the_next_word(self, open_port):
        start = open_port.now
        open_port.peek("SR")
        open_port.poke("DR", 1)
        open_port.poke("DR", 2)
        open_port.set("CR1", SBK)
        assert changes(open_port, 600) == [(21 * 16, TXE), (31 * 16, TXE | TC)]
        assert [(cycle - start, frame.is_break) for cycle, frame in open_port.sent] == [
            (0, False),
            (10 * 16, True),
            (21 * 16, False),
        ]

    def test_tc_waits_for_a_break_that_is_due(self, open_port):
        open_port.peek("SR")
        open_port.poke("DR", 1)
        open_port.set("CR1", SBK)
        assert changes(open_port, 600) == [(21 * 16, TXE | TC)]

    def test_a_break_alone_does_not_set_tc(self, open_port):
        open_port.poke("SR", 0)
        open_port.set("CR1", SBK)
        assert changes(open_port, 600) == []

    def test_it_is_not_sent_if_sbk_is_cleared_in_time(self, open_port):
        open_port.poke("DR", 1)
        open_port.set("CR1", SBK)
        open_port.clear("CR1", SBK)
        open_port.bits(60)
        assert open_port.values == [1]

    def test_two_in_a_row(self, open_port):
        open_port.set("CR1", SBK)
        open_port.chip.advance(10 * 16)
        open_port.set("CR1", SBK)
        open_port.bits(60)
        (first, _), (second, _) = open_port.sent
        assert second == first + 11 * 16

    def test_set_before_the_transmitter_is_on(self, port):
        port.poke("BRR", 16)
        port.poke("CR1", UE | SBK)
        port.bits(30)
        assert not port.sent
        port.set("CR1", TE)
        port.bits(40)
        assert [frame.is_break for _, frame in port.sent] == [True]


class TestFlowControl:
    CTS, CTSE, CTSIE = 0x200, 0x200, 0x400

    def test_cts_holds_back_the_next_frame_only(self, port):
        port.open(cr3=self.CTSE)
        port.poke("SR", 0)
        port.poke("DR", 1)
        port.poke("DR", 2)
        start = port.now
        port.bits(2)
        port.cts.drive(True)
        port.bits(40)
        assert port.values == [1]
        assert port.flags & (TXE | TC) == 0
        port.cts.drive(False)
        assert port.flags & TXE
        port.bits(40)
        assert [cycle - start for cycle, _ in port.sent] == [0, 42 * 16]

    def test_each_toggle_sets_ctsif(self, port):
        port.open(cr3=self.CTSE | self.CTSIE)
        assert not port.irq.level
        for level in (True, False):
            port.cts.drive(level)
            assert port.flags & self.CTS
            assert port.irq.level
            port.poke("SR", 0x3FF & ~self.CTS)
            assert not port.irq.level

    def test_without_ctse_the_signal_does_not_matter(self, open_port):
        open_port.cts.drive(True)
        open_port.poke("DR", 1)
        open_port.bits(20)
        assert open_port.values == [1]
        assert not open_port.flags & self.CTS
        open_port.poke("CR3", self.CTSE)
        open_port.poke("DR", 2)
        open_port.bits(20)
        assert open_port.values == [1]
        open_port.poke("CR3", 0)
        open_port.bits(20)
        assert open_port.values == [1, 2]


class TestClock:
    def test_the_rest_of_a_frame_goes_on_at_the_new_rate(self, open_port):
        start = open_port.now
        open_port.peek("SR")
        open_port.poke("DR", 1)
        open_port.chip.advance(4 * 16)
        open_port.chip.change_clock(APB2=2)
        assert changes(open_port, 400) == [(6 * 32, TXE | TC)]
        open_port.poke("DR", 2)
        assert open_port.sent[1][1].bit_s == 2 * open_port.sent[0][1].bit_s
        assert open_port.sent[1][0] == start + 4 * 16 + 400

    def test_cycles_of_another_length(self, open_port):
        open_port.peek("SR")
        open_port.poke("DR", 1)
        open_port.chip.advance(40)
        open_port.chip.change_clock(8_000_000)
        assert changes(open_port, 400) == [(120, TXE | TC)]
        open_port.poke("DR", 2)
        assert open_port.sent[1][1].bit_s == Fraction(16, 8_000_000)
        assert open_port.sent[1][1].start_s == open_port.chip.time.seconds(open_port.now)

    def test_brr_in_mid_frame(self, open_port):
        open_port.peek("SR")
        open_port.poke("DR", 1)
        open_port.chip.advance(8)
        open_port.poke("BRR", 48)
        assert changes(open_port, 600) == [((10 * 16 - 8) * 3, TXE | TC)]

    def test_a_clock_that_stands_still_lets_the_frame_end(self, open_port):
        open_port.poke("DR", 1)
        open_port.poke("BRR", 0)
        open_port.chip.advance(1000)
        assert open_port.flags & TC
        open_port.poke("DR", 2)
        open_port.chip.advance(1000)
        assert open_port.values == [1]


class TestWire:
    def test_no_pin_no_frame_and_a_note(self, open_port):
        open_port.tx.connected = False
        open_port.poke("SR", 0)
        open_port.poke("DR", 1)
        open_port.bits(20)
        assert not open_port.sent
        assert open_port.flags & TC
        (note,) = open_port.chip.notes.all
        assert (note.kind, note.where) == ("misuse", "USART1_TX")
        assert "PA9" in note.text

    @given(
        values=st.lists(st.integers(0, 255), min_size=1, max_size=4),
        watch=st.sampled_from((Watch.LIVE, Watch.RECORD)),
        looks=st.lists(st.integers(1, 200), max_size=5),
        change=st.one_of(st.none(), st.integers(1, 400)),
    )
    def test_the_level_of_the_pin(self, make_port, values, watch, looks, change):
        """Whoever looks, and whenever: the edges are those of the frames, re-timed by the chip's own clock."""
        port = make_port().open()
        port.tx.set_watch(watch)
        port.tx.edges.clear()
        expected = []
        start = port.now
        for index, value in enumerate(values):
            for bit, level in port.usart.format.frame(value, Fraction(0), Fraction(16)).edges():
                at = index * 160 + int(bit)
                if change is not None and at > change:
                    at = change + 2 * (at - change)
                expected.append((start + at, level))
        pending = list(values)
        stops = sorted({start + sum(looks[: n + 1]) for n in range(len(looks))})
        changed = False
        while port.now < start + 40 * 32 * len(values):
            if pending and port.flags & TXE:
                port.poke("DR", pending.pop(0))
            if change is not None and not changed and port.now == start + change:
                port.chip.change_clock(APB2=2)
                changed = True
            if port.now in stops:
                port.tx.look()
            port.chip.advance(1)
        port.tx.look()
        assert port.tx.edges == expected

    def test_a_rate_that_is_written_again_in_mid_frame_changes_nothing(self, open_port):
        """Five bits at twice the length, the rest at the old one."""
        open_port.poke("BRR", 32)
        open_port.poke("SR", 0)
        start = open_port.now
        open_port.poke("DR", 0x55)
        open_port.chip.advance(5 * 32)
        for _ in range(3):
            open_port.poke("BRR", 16)
        open_port.chip.advance(5 * 16 - 1)
        assert not open_port.flags & TC
        open_port.chip.advance(1)
        assert open_port.flags & TC
        ends = [32 * bit if bit <= 5 else 160 + 16 * (bit - 5) for bit in range(10)]
        assert open_port.tx.edges[-10:] == [(start + cycle, bool(bit & 1)) for bit, cycle in enumerate(ends)]

    def test_nobody_looks_nothing_is_told(self, open_port):
        open_port.tx.set_watch(Watch.NOBODY)
        before = len(open_port.tx.edges)
        open_port.poke("DR", 0x55)
        open_port.bits(20)
        assert len(open_port.tx.edges) == before
        open_port.poke("DR", 0)
        open_port.bits(5)
        open_port.tx.look()
        assert open_port.tx.level is False
        open_port.bits(20)
        assert open_port.tx.level is True

    def test_half_duplex_releases_the_line_between_frames(self, port):
        port.open(cr3=0x8)
        assert port.tx.level is None
        port.poke("DR", 0x01)
        assert port.tx.level is False
        port.bits(1)
        assert port.tx.level is True
        port.bits(9)
        assert port.tx.level is None
