"""Receiving: the cycle of RXNE, errors, overrun, idle line, mute mode, LIN, and lines that are not as expected."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from targets.mcu.serial_line import LineReceiver, SerialFormat, SerialFrame
from tests.each import each

PE, FE, NE, ORE, IDLE, RXNE, TC, TXE, LBD = (1 << bit for bit in range(9))
UE, M, WAKE, PCE, PS, RE, RWU = 0x2000, 0x1000, 0x800, 0x400, 0x200, 4, 2
QUIET = TXE | TC


@each("brr", [16, 17, 78, 625, 7500])
@each("divider", [1, 2])
def test_rxne_in_the_middle_of_the_stop_bit(make_port, brr, divider):
    port = make_port(72_000_000, {"APB1": divider}, "USART3").open(brr)
    start = port.now
    port.hear(0x5A, wait=False)
    rxne = start + -(-(9 * 16 + 10) * brr * divider // 16)
    port.chip.advance_to(rxne - 1)
    assert port.flags == QUIET
    port.chip.advance(1)
    assert port.flags == QUIET | RXNE
    assert port.peek("DR") == 0x5A
    assert port.flags == QUIET


@pytest.mark.parametrize(("stop", "half_bits", "sixteenths"), [(0, 2, 10), (1, 1, 8), (2, 4, 16), (3, 3, 24)])
def test_rxne_with_other_stop_bits(port, stop, half_bits, sixteenths):
    port.open(cr2=stop << 12)
    start = port.now
    frame = port.hear(0x5A, wait=False)
    assert frame.stop_half_bits == half_bits
    port.chip.advance_to(start + 9 * 16 + sixteenths - 1)
    assert not port.flags & RXNE
    port.chip.advance(1)
    assert port.flags & RXNE


@given(
    cr1=st.sampled_from((0, M, PCE, PCE | PS, M | PCE, M | PCE | PS)),
    values=st.lists(st.integers(0, 0x1FF), min_size=1, max_size=5),
    divider=st.sampled_from((1, 2, 16)),
)
def test_frames_back_to_back(make_port, cr1, values, divider):
    port = make_port(dividers={"APB2": divider}).open(cr1=UE | RE | cr1)
    for value in values:
        port.hear(value)
        assert port.peek("SR") == QUIET | RXNE
        assert port.peek("DR") == port.usart.format.word(value)  # the parity bit is read as well


class TestErrors:
    def test_a_parity_error(self, port):
        port.open(cr1=UE | RE | M | PCE)
        port.hear(0x55, like="8O1")
        assert port.peek("SR") == QUIET | RXNE | PE
        assert port.peek("DR") == 0x155
        assert port.flags == QUIET

    def test_a_parity_error_is_cleared_by_a_write_too(self, port):
        port.open(cr1=UE | RE | M | PCE)
        port.hear(0x55, like="8O1")
        port.peek("SR")
        port.poke("DR", 0)
        assert port.flags & (RXNE | PE) == RXNE

    def test_a_low_stop_bit(self, open_port):
        open_port.hear(0x55, bits=0x055, bit_count=9)
        assert open_port.peek("SR") == QUIET | RXNE | FE
        assert open_port.peek("DR") == 0x55
        assert open_port.flags == QUIET

    def test_a_break_is_a_word_of_zeros_with_a_framing_error(self, open_port):
        frame = open_port.hear(0, bits=0, bit_count=9)
        assert open_port.peek("SR") == QUIET | RXNE | FE
        assert open_port.peek("DR") == 0
        open_port.chip.advance(10_000)
        assert open_port.flags & ~IDLE == QUIET  # and nothing more, however long the line was low
        assert not frame.is_break

    @pytest.mark.parametrize("bits", [10, 30, 300])
    def test_a_long_break_is_received_once(self, open_port, bits):
        open_port.hear(0, bits=0, bit_count=bits)
        assert open_port.peek("SR") & 0xF == FE
        assert open_port.peek("DR") == 0
        open_port.hear(0x41)
        assert open_port.peek("SR") == QUIET | RXNE
        assert open_port.peek("DR") == 0x41

    @pytest.mark.parametrize(
        ("from_16", "length_16", "data", "noise"),
        [
            (16 + 8, 1, 0x00, True),  # one sample of three is high: noise, the majority stays low
            (16 + 8, 2, 0x01, True),
            (16 + 8, 3, 0x01, False),
            (16 + 1, 6, 0x00, False),  # between the samples: nobody sees it
            (16 * 8 + 9, 1, 0x00, True),
            (3, 1, 0x00, True),  # in the start bit
            (9, 1, 0x00, True),
        ],
    )
    def test_noise(self, open_port, from_16, length_16, data, noise):
        """A pulse of whole sixteenths of a bit in a frame of zeros, by the pin."""
        open_port.rx.drive(True)
        open_port.bits(20)
        open_port.rx.drive(False)
        open_port.chip.advance(from_16)
        open_port.rx.drive(True)
        open_port.chip.advance(length_16)
        open_port.rx.drive(False)
        open_port.chip.advance(9 * 16 - from_16 - length_16)
        open_port.rx.drive(True)
        open_port.bits(5)
        assert open_port.peek("SR") == QUIET | RXNE | (NE if noise else 0)
        assert open_port.peek("DR") == data

    @pytest.mark.parametrize("length_16", [1, 2, 5, 8])
    def test_a_glitch_is_no_start_bit(self, open_port, length_16):
        open_port.rx.drive(True)
        open_port.bits(20)
        open_port.rx.drive(False)
        open_port.chip.advance(length_16)
        open_port.rx.drive(True)
        open_port.bits(40)
        assert open_port.flags == QUIET
        open_port.hear(0x41)
        assert open_port.peek("DR") == 0x41


class TestOverrun:
    def test_the_first_word_stays_and_the_second_is_lost(self, open_port):
        open_port.hear(1)
        open_port.hear(2)
        assert open_port.peek("SR") == QUIET | RXNE | ORE
        assert open_port.peek("DR") == 1
        assert open_port.flags == QUIET
        open_port.hear(3)
        assert open_port.peek("DR") == 3

    def test_a_dr_read_alone_does_not_clear_it(self, open_port):
        open_port.hear(1)
        open_port.hear(2)
        open_port.peek("DR")
        assert open_port.flags == QUIET | ORE

    def test_between_the_reads_of_sr_and_dr(self, open_port):
        """RM0008 on ORE: with RXNE=0 the word came in during the reading sequence."""
        open_port.hear(1)
        assert open_port.peek("SR") == QUIET | RXNE
        open_port.hear(2)
        assert open_port.peek("DR") == 1
        assert open_port.flags == QUIET | ORE

    def test_nothing_is_received_until_it_is_cleared(self, open_port):
        """RXNE is no longer set after an overrun (libopencm3 issue 918, on an STM32F103)."""
        open_port.hear(1)
        open_port.hear(2)
        open_port.peek("DR")
        open_port.hear(3)
        assert open_port.flags == QUIET | ORE
        open_port.peek("SR")
        open_port.peek("DR")
        open_port.hear(4)
        assert open_port.flags == QUIET | RXNE
        assert open_port.peek("DR") == 4

    def test_no_other_error_is_flagged_with_it(self, open_port):
        open_port.hear(1)
        open_port.hear(0, bits=0, bit_count=12)
        assert open_port.flags == QUIET | RXNE | ORE

    def test_rxne_cleared_by_writing_zero_makes_room(self, open_port):
        open_port.hear(1)
        open_port.poke("SR", 0x3FF & ~RXNE)
        open_port.hear(2)
        assert open_port.flags == QUIET | RXNE
        assert open_port.peek("DR") == 2


class TestIdle:
    @pytest.mark.parametrize(("cr1", "cr2", "frame"), [(0, 0, 10), (M, 0, 11), (0, 0x2000, 11), (M, 0x2000, 12)])
    def test_one_frame_after_the_stop_bit(self, port, cr1, cr2, frame):
        port.open(cr1=UE | RE | cr1, cr2=cr2)
        start = port.now
        port.hear(0x5A)
        port.peek("DR")
        port.chip.advance_to(start + 2 * frame * 16 - 1)
        assert not port.flags & IDLE
        port.chip.advance(1)
        assert port.flags & IDLE

    def test_not_between_frames(self, open_port):
        for pause in (0, 5, 9):
            open_port.hear(0xFF)
            open_port.peek("DR")
            open_port.bits(pause)
            assert not open_port.flags & IDLE
        open_port.bits(1)
        assert open_port.flags & IDLE

    def test_not_again_before_rxne(self, open_port):
        open_port.hear(1)
        open_port.bits(12)
        open_port.peek("SR")
        open_port.peek("DR")
        assert open_port.flags == QUIET
        open_port.bits(100)
        assert open_port.flags == QUIET
        open_port.hear(1)
        open_port.bits(12)
        assert open_port.flags & IDLE

    def test_not_without_a_word(self, open_port):
        open_port.bits(100)
        assert open_port.flags == QUIET

    def test_a_sr_read_before_it_does_not_arm_it(self, open_port):
        open_port.hear(1)
        open_port.peek("SR")
        open_port.bits(12)
        open_port.peek("DR")
        assert open_port.flags == QUIET | IDLE

    def test_it_counts_from_the_end_of_a_break(self, open_port):
        start = open_port.now
        open_port.hear(0, bits=0, bit_count=29)
        open_port.chip.advance_to(start + 40 * 16 - 1)
        assert not open_port.flags & IDLE
        open_port.chip.advance(1)
        assert open_port.flags & IDLE

    def test_it_follows_the_clock(self, open_port):
        start = open_port.now
        open_port.hear(0x5A)
        open_port.chip.advance_to(start + 15 * 16)
        open_port.chip.change_clock(APB2=2)
        open_port.chip.advance_to(start + 15 * 16 + 5 * 32 - 1)
        assert not open_port.flags & IDLE
        open_port.chip.advance(1)
        assert open_port.flags & IDLE

    def test_a_frame_within_a_slow_senders_frame(self, open_port):
        """A sender 20 times slower: its low bits are breaks, its high bits idle lines."""
        open_port.hear(0b101, bit_s=20 * open_port.bit / open_port.chip.time.hclk_hz, wait=False)
        found = []
        for _ in range(150):
            open_port.bits(1)
            flags = open_port.peek("SR")
            if flags & (RXNE | IDLE):
                found.append(flags & 0x3F)
                open_port.peek("DR")
        # start bit, bit 0 high for 20 bit times, bit 1 low, bit 2 high, bits 3-7 low
        assert found == [RXNE | FE, IDLE, RXNE | FE, IDLE, RXNE | FE]


class TestMute:
    def test_until_the_line_was_idle(self, port):
        port.open(cr1=UE | RE)
        port.hear(1)
        port.peek("DR")
        port.set("CR1", RWU)
        port.hear(2)
        port.bits(9)
        port.hear(3)
        assert port.flags & 0x3F == 0
        assert port.peek("CR1") & RWU
        port.bits(10)
        assert not port.peek("CR1") & RWU
        assert port.flags & 0x3F == 0  # IDLE is not set by the idle line that ends mute mode
        port.hear(4)
        assert port.peek("DR") == 4

    @pytest.mark.parametrize(("cr1", "mark"), [(0, 0x80), (M, 0x100)])
    def test_until_the_own_address(self, port, cr1, mark):
        port.open(cr1=UE | RE | WAKE | RWU | cr1, cr2=0x5)
        heard = []
        for value in (0x01, mark | 4, 2, mark | 5, 3, mark | 0x15, 4, mark | 6, 5, mark | 5, 6):
            port.hear(value)
            if port.peek("SR") & RXNE:
                heard.append(port.peek("DR"))
        assert heard == [mark | 5, 3, mark | 0x15, 4, mark | 5, 6]
        assert not port.peek("SR") & 0xF

    def test_rwu_cannot_be_written_while_rxne_is_set(self, port):
        port.open(cr1=UE | RE | WAKE)
        port.hear(1)
        port.set("CR1", RWU)
        assert not port.peek("CR1") & RWU
        port.peek("DR")
        port.set("CR1", RWU)
        assert port.peek("CR1") & RWU


class TestLin:
    LINEN, LBDL = 0x4000, 0x20

    @pytest.mark.parametrize(
        ("cr2", "low", "detected_at"),
        [(0, 9, None), (0, 10, 10), (LBDL, 10, None), (LBDL, 11, 11), (0, 13, 13), (LBDL, 13, 13), (LBDL, 26, 26)],
    )
    def test_a_break_is_detected_with_its_delimiter(self, port, cr2, low, detected_at):
        port.open(cr1=UE | RE, cr2=self.LINEN | cr2)
        start = port.now
        port.hear(0, bits=0, bit_count=low - 1, wait=False)
        if detected_at is not None:
            port.chip.advance_to(start + detected_at * 16 + 9)
            assert not port.flags & LBD
            port.chip.advance(1)
            assert port.flags & LBD
            assert port.flags & (RXNE | FE) == RXNE | FE
        else:
            port.bits(low + 5)
            assert not port.flags & LBD

    def test_the_delimiter_comes_by_the_pin(self, port):
        port.open(cr1=UE | RE, cr2=self.LINEN | 0x40)
        port.rx.drive(True)
        port.bits(20)
        port.rx.drive(False)
        port.bits(200)
        assert port.flags & (FE | LBD) == FE
        port.rx.drive(True)
        port.bits(1)
        assert port.flags & LBD
        assert port.irq.level
        port.poke("SR", 0x3FF & ~LBD)
        assert not port.irq.level

    def test_a_word_of_nine_zeros_is_a_break_of_ten_bits(self, port):
        port.open(cr1=UE | RE | M, cr2=self.LINEN)
        port.hear(0)
        assert port.flags & (RXNE | FE | LBD) == RXNE | LBD

    def test_without_lin_mode_there_is_no_such_flag(self, open_port):
        open_port.hear(0, bits=0, bit_count=20)
        open_port.bits(20)
        assert not open_port.flags & LBD

    def test_words_after_the_break(self, port):
        port.open(cr1=UE | RE, cr2=self.LINEN)
        port.hear(0, bits=0, bit_count=12)
        port.peek("SR")
        port.peek("DR")
        port.hear(0x55)
        assert port.peek("SR") & 0x3F == RXNE
        assert port.peek("DR") == 0x55


class TestSwitchedOff:
    @pytest.mark.parametrize("bit", [UE, RE])
    def test_what_is_coming_in_is_lost(self, open_port, bit):
        open_port.hear(0x55, wait=False)
        open_port.bits(5)
        open_port.clear("CR1", bit)
        open_port.bits(20)
        assert open_port.flags == QUIET
        open_port.set("CR1", bit)
        open_port.bits(20)
        open_port.hear(0x41)
        assert open_port.peek("DR") == 0x41

    def test_a_frame_while_off_is_lost(self, open_port):
        open_port.clear("CR1", RE)
        open_port.hear(0x55)
        open_port.set("CR1", RE)
        open_port.bits(50)
        assert open_port.flags == QUIET

    def test_a_frame_while_the_clock_gate_is_shut_is_lost(self, open_port):
        open_port.usart.clocked = False
        open_port.hear(0x55)
        assert open_port.flags == QUIET

    def test_switched_on_in_mid_frame_it_reads_what_is_left(self, open_port):
        """0xF0: after the first bits there is no falling edge. 0x0F: bit 4 is taken for a start bit."""
        for value, read in ((0xF0, None), (0x0F, 0xF8)):
            open_port.clear("CR1", RE)
            open_port.hear(value, wait=False)
            open_port.bits(3)
            open_port.set("CR1", RE)
            open_port.bits(20)
            flags = open_port.peek("SR")
            assert (open_port.peek("DR") if flags & RXNE else None) == read

    def test_a_pin_that_does_not_listen(self, open_port):
        open_port.rx.connected = False
        open_port.hear(0x55)
        assert open_port.flags == QUIET
        (note,) = open_port.chip.notes.all
        assert (note.kind, note.where) == ("misuse", "USART1_RX")
        assert "PA10" in note.text


class TestPin:
    """The level of the pin counts as well as frames: somebody may send by hand."""

    def send(self, port, value, bit=16):
        port.rx.drive(True)
        port.bits(3)
        for level in (0, *(value >> n & 1 for n in range(8)), 1):
            port.rx.drive(bool(level))
            port.chip.advance(bit)

    @given(values=st.lists(st.integers(0, 255), min_size=1, max_size=4), bit=st.sampled_from((16, 160, 156, 164)))
    @settings(deadline=None)
    def test_bits_by_hand(self, make_port, values, bit):
        port = make_port().open(round(bit, -1) if bit > 16 else 16)
        for value in values:
            self.send(port, value, bit)
            assert port.peek("SR") & 0x3F == RXNE
            assert port.peek("DR") == value

    def test_a_pin_that_was_low_all_the_time_says_nothing(self, open_port):
        """It floats and reads as low; frames come in all the same."""
        assert not open_port.rx.level()
        open_port.hear(0x41)
        assert open_port.peek("DR") == 0x41

    def test_nobody_listens_while_the_receiver_is_off(self, open_port):
        assert open_port.rx.on_change is not None
        open_port.clear("CR1", RE)
        assert open_port.rx.on_change is None
        open_port.rx.drive(True)
        open_port.rx.drive(False)
        open_port.set("CR1", RE)
        open_port.hear(0x41)
        assert open_port.peek("DR") == 0x41

    def test_the_same_by_pin_and_as_a_frame(self, open_port):
        open_port.rx.drive(True)
        open_port.bits(20)
        open_port.hear(0xA5, wait=False)
        for level in (0, *(0xA5 >> n & 1 for n in range(8)), 1):
            open_port.rx.drive(bool(level))
            open_port.chip.advance(16)
        assert open_port.peek("SR") & 0x3F == RXNE
        assert open_port.peek("DR") == 0xA5


class TestHalfDuplex:
    def test_it_hears_itself(self, port):
        port.open(cr3=0x8)
        port.poke("DR", 0x41)
        port.bits(12)
        assert port.peek("DR") == 0x41

    def test_not_with_the_receiver_off(self, port):
        port.open(cr1=UE | 8, cr3=0x8)
        port.poke("DR", 0x41)
        port.bits(12)
        assert not port.flags & RXNE

    def test_others_come_in_by_the_same_pin(self, port):
        port.open(cr3=0x8)
        port.rx.connected = False
        port.hear(0x42)
        assert port.peek("DR") == 0x42
        port.chip.input("USART1_TX").connected = False
        port.hear(0x43)
        assert not port.flags & RXNE
        assert "PA9" in port.chip.notes.all[0].text

    def test_others_by_the_level_of_the_pin(self, port):
        port.open(cr3=0x8)
        pin = port.chip.input("USART1_TX")
        pin.drive(True)
        port.bits(20)
        for level in (0, *(0x3C >> n & 1 for n in range(8)), 1):
            pin.drive(bool(level))
            port.bits(1)
        assert port.peek("SR") & 0x2F == RXNE
        assert port.peek("DR") == 0x3C

    def test_two_at_a_time_are_anded(self, port):
        port.open(cr3=0x8)
        port.poke("DR", 0xF5)
        port.hear(0x5F)
        assert port.peek("DR") == 0x55


class TestFlowControl:
    def test_rts_says_whether_there_is_room(self, port):
        port.open(cr1=UE, cr3=0x100)
        assert port.rts.level is True
        port.set("CR1", RE)
        assert port.rts.level is False
        port.hear(1)
        assert port.rts.level is True
        port.peek("DR")
        assert port.rts.level is False
        port.poke("CR3", 0)
        assert port.rts.level is None


class TestOtherRates:
    @given(
        bit=st.one_of(st.integers(150, 170), st.integers(40, 400)),
        values=st.lists(st.integers(0, 255), min_size=1, max_size=4),
        pauses=st.lists(st.integers(0, 40), min_size=4, max_size=4),
        text=st.sampled_from(("8N1", "8E1", "7O2", "9N1", "8N2")),
    )
    @settings(deadline=None)
    def test_as_a_receiver_outside_would_read_it(self, make_port, bit, values, pauses, text):
        """Samples at whole cycles: with BRR a multiple of 16 they are exactly those of `LineReceiver`."""
        sent_bit_s = Fraction(bit, 72_000_000)
        port = make_port().open(160, UE | RE)
        bit_s = Fraction(160, 72_000_000)
        outside = LineReceiver(SerialFormat(), bit_s)
        cycle, heard, expected = port.now, [], []
        last = 0
        for value, pause in zip(values, pauses, strict=False):
            self.collect(port, cycle, heard)
            frame = SerialFormat.parse(text).frame(value, port.chip.time.seconds(cycle), sent_bit_s)
            expected += outside.advance(frame.start_s)
            port.usart.receive(frame)
            outside.receive(frame)
            cycle = last = port.chip.time.cycle_at(frame.end_s) + pause * 16
        self.collect(port, last + 4000, heard)
        expected += outside.advance(port.chip.time.seconds(last + 4000))
        assert heard == [(word.value, word.framing_error, word.noise) for word in expected]

    def collect(self, port, until, heard):
        """Advance, and read each word when it is there."""
        while port.now < until:
            port.chip.advance_to(min(until, port.now + 80))
            flags = port.peek("SR")
            if flags & RXNE:
                heard.append((port.peek("DR"), bool(flags & FE), bool(flags & NE)))

    @each(("m", "tolerated"), [(0, "3.75"), (M, "3.41")])
    def test_tolerance_of_a_fast_sender(self, make_port, m, tolerated):
        """RM0008, "USART receiver's tolerance when DIV_Fraction is 0"; a hundredth of a percent for whole cycles."""
        for percent, clean in (
            (Fraction(tolerated) - Fraction(5, 100), True),
            (Fraction(tolerated) + Fraction(5, 100), False),
        ):
            port = make_port().open(1600, UE | RE | m)
            bit_s = Fraction(1600, 72_000_000) * (100 - percent) / 100
            port.hear(0x55, bit_s=bit_s)
            port.hear(0x55, bit_s=bit_s, wait=False)
            port.bits(1)
            assert port.peek("SR") & (NE | FE) == (0 if clean else NE)
            assert port.peek("DR") == 0x55


class TestClock:
    @given(
        value=st.integers(0, 255),
        changes=st.lists(st.tuples(st.integers(1, 120), st.sampled_from((1, 2, 4))), max_size=4),
    )
    def test_the_samples_follow_the_clock(self, make_port, value, changes):
        """Sender on the same clock as the receiver: what both count in their bits is unharmed by any change."""
        port = make_port().open()
        port.rx.drive(True)
        port.bits(20)
        levels = [0, *(value >> n & 1 for n in range(8)), 1]
        ticks, divider, due = 0, 1, dict(changes)
        while ticks < 160:
            if ticks % 16 == 0:
                port.rx.drive(bool(levels[ticks // 16]))
            if ticks in due:
                divider = due[ticks]
                port.chip.change_clock(APB2=divider)
            port.chip.advance(divider)
            ticks += 1
        assert port.peek("SR") & 0x3F == RXNE
        assert port.peek("DR") == value

    def test_a_frame_from_outside_is_cut_by_a_change(self, open_port):
        """The sender goes on as before: with twice the bit time the receiver takes its start bits for glitches."""
        open_port.hear(0x55, wait=False)
        open_port.chip.change_clock(36_000_000)
        open_port.bits(20)
        assert open_port.flags == QUIET
        open_port.hear(0x55, wait=False)
        open_port.bits(7)
        open_port.chip.change_clock(72_000_000)
        open_port.bits(20)
        assert open_port.peek("SR") & 0xF == FE
        assert open_port.peek("DR") == 0xD5

    def test_hclk_may_change_if_the_bit_time_does_not(self, make_port):
        port = make_port(72_000_000).open(160, past_preamble=True)
        port.hear(0x55, wait=False)
        port.bits(4)
        port.usart.before_clock_change()
        port.chip.time.set_hclk(Fraction(36_000_000))
        port.usart[0x08] = 80
        port.usart.after_clock_change()
        port.bits(10)
        assert port.peek("SR") & 0x3F == RXNE
        assert port.peek("DR") == 0x55

    def test_a_start_bit_that_is_still_to_come(self, open_port):
        """After a framing error the next start bit is found in the rest of a slow frame, some of it in the future."""
        open_port.hear(0, bits=0b1011_0000, bit_count=8, bit_s=Fraction(64, 72_000_000), wait=False)
        for _ in range(60):
            open_port.chip.advance(16)
            open_port.usart.before_clock_change()
            open_port.usart.after_clock_change()
            if open_port.peek("SR") & RXNE:
                open_port.peek("DR")
        assert open_port.flags & ~IDLE == QUIET


def test_receive_takes_a_frame_of_any_origin(open_port):
    start_s = open_port.chip.time.seconds(open_port.now)
    open_port.usart.receive(SerialFrame(start_s=start_s, bit_s=Fraction(1, 4_500_000), bits=0x33, bit_count=8))
    open_port.bits(12)
    assert open_port.peek("DR") == 0x33
