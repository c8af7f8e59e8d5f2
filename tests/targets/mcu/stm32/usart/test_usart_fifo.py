"""The FIFOs of a USART of the STM32H7: how many words fit, which flags tell of it, who is asked for more (RM0433)."""

from __future__ import annotations

from collections import deque
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.each import each

FE, NF, ORE, IDLE, RXNE, TC, TXE, RTOF = (1 << bit for bit in (1, 2, 3, 4, 5, 6, 7, 11))
TXFE, RXFF, TCBGT, RXFT, TXFT = (1 << bit for bit in range(23, 28))
UE, RE, TE, RXNEIE, TCIE, TXEIE, RTOIE = (1 << bit for bit in (0, 2, 3, 5, 6, 7, 26))
FIFOEN, TXFEIE, RXFFIE = 1 << 29, 1 << 30, 1 << 31
DMAR, DMAT, RTSE, OVRDIS, TXFTIE, RXFTIE = (1 << bit for bit in (6, 7, 8, 12, 23, 28))
RXFRQ, TXFRQ = 1 << 3, 1 << 4
TXFECF, ORECF, TCBGTCF = 1 << 5, 1 << 3, 1 << 7
LEVELS = RXNE | TXE | TC | TXFE | RXFF | RXFT | TXFT
THRESHOLDS = (2, 4, 8, 12, 14, 16, 16, 16)
EMPTY = TXE | TC | TXFE | TXFT


@pytest.fixture
def port(make_fifo_port):
    return make_fifo_port().open(cr1=FIFOEN | TE | RE)


def hear(port, *values):
    for value in values:
        port.hear(value)


# --- flags after reset


def test_flags_after_reset_with_and_without_fifos(make_fifo_port):
    port = make_fifo_port()
    assert port.flags == 0x0200_00C0
    port.poke("CR1", FIFOEN)
    assert port.flags == 0x0280_00C0
    port.poke("CR1", 0)
    assert port.flags == 0x0200_00C0


def test_fifos_are_chosen_while_ue_is_clear(port):
    port.clear("CR1", FIFOEN)
    assert port.peek("CR1") & FIFOEN
    assert port.chip.noted("misuse") == ["USART3_CR1"]


# --- receiving


def test_seventeen_words_fit_and_the_eighteenth_is_lost(port):
    hear(port, *range(16))
    assert port.flags & (RXNE | RXFT | RXFF | ORE) == RXNE | RXFT
    hear(port, 16)
    assert port.flags & (RXNE | RXFT | RXFF | ORE) == RXNE | RXFT | RXFF
    hear(port, 17)
    assert port.flags & ORE
    assert port.words[-1] == (17, ORE)
    assert [port.peek("RDR") for _ in range(17)] == list(range(17))
    assert not port.flags & (RXNE | RXFF | RXFT)
    hear(port, 18)
    assert port.peek("RDR") == 18, "ORE does not keep words out"


def test_errors_stand_by_the_word_that_rdr_shows(port):
    hear(port, 1)
    port.hear(2, bits=2, bit_count=9)
    assert not port.flags & (FE | NF)
    assert port.peek("RDR") == 1
    assert port.flags & FE
    port.poke("ICR", FE)
    hear(port, 3)
    assert not port.flags & FE
    assert (port.peek("RDR"), port.peek("RDR")) == (2, 3)
    assert not port.flags & FE


def test_with_ovrdis_the_fifo_is_passed_by(make_fifo_port):
    port = make_fifo_port().open(cr1=FIFOEN | TE | RE, cr3=OVRDIS)
    hear(port, 1, 2, 3)
    assert port.flags & (RXNE | RXFT | ORE) == RXNE
    assert port.peek("RDR") == 3
    assert not port.flags & RXNE


def test_rts_stops_the_far_end_when_nothing_more_fits(make_fifo_port):
    port = make_fifo_port().open(cr1=FIFOEN | RE, cr3=RTSE)
    hear(port, *range(16))
    assert port.rts.level is False
    hear(port, 16)
    assert port.rts.level is True
    port.peek("RDR")
    assert port.rts.level is False


def test_a_request_empties_what_has_come_in(port):
    hear(port, 1, 2, 3)
    port.poke("RQR", RXFRQ)
    assert not port.flags & RXNE
    hear(port, 4)
    assert port.peek("RDR") == 4


def test_idle_and_timeout_follow_the_last_word(make_fifo_port):
    port = make_fifo_port().open(cr1=FIFOEN | RE | RTOIE, cr2=1 << 23, rtor=15)
    port.hear(1)
    port.bits(14)
    assert port.flags & (IDLE | RTOF) == IDLE
    assert not port.irq.level
    port.bits(1)
    assert port.flags & (IDLE | RTOF) == IDLE | RTOF
    assert port.irq.level


@each("field", range(6))
def test_interrupt_at_the_threshold_of_the_receiver(make_fifo_port, field):
    port = make_fifo_port().open(cr1=FIFOEN | RE, cr3=RXFTIE | field << 25)
    hear(port, *range(THRESHOLDS[field] - 1))
    assert not port.irq.level
    hear(port, 99)
    assert port.irq.level
    port.peek("RDR")
    assert not port.irq.level


def test_interrupts_of_the_full_and_of_the_empty_fifo(make_fifo_port):
    port = make_fifo_port().open(cr1=FIFOEN | RE | TE | RXFFIE)
    hear(port, *range(16))
    assert not port.irq.level
    hear(port, 16)
    assert port.irq.level
    port.peek("RDR")
    assert not port.irq.level
    port.set("CR1", TXFEIE)
    assert port.irq.level
    port.poke("ICR", TXFECF)
    assert not port.irq.level
    port.poke("TDR", 1)
    assert port.irq.level, "it went on into the shift register, so the FIFO has become empty"


# --- sending


def test_sixteen_words_wait_behind_the_one_that_is_sent(port):
    for value in range(17):
        assert port.flags & TXE
        port.poke("TDR", value)
    assert not port.flags & (TXE | TXFE | TXFT | TC)
    port.poke("TDR", 17)
    assert port.chip.noted("misuse") == ["USART3_TDR"]
    port.bits(10)
    assert port.flags & TXE
    port.bits(159)
    assert port.flags & (TXE | TXFE | TC) == TXE | TXFE
    port.bits(1)
    assert port.flags & LEVELS == EMPTY
    assert port.values == list(range(17))
    starts = [cycle for cycle, _ in port.sent]
    assert {later - earlier for earlier, later in pairwise(starts)} == {10 * port.bit}


@each("field", range(6))
def test_interrupt_at_the_threshold_of_the_transmitter(make_fifo_port, field):
    port = make_fifo_port().open(cr1=FIFOEN | TE, cr3=TXFTIE | field << 29)
    assert port.irq.level, "all places are empty"
    for value in range(17):
        port.poke("TDR", value)
    assert not port.irq.level
    port.bits(10 * THRESHOLDS[field] - 1)
    assert not port.irq.level
    port.bits(1)
    assert port.irq.level


def test_a_request_throws_away_what_waits(port):
    for value in range(5):
        port.poke("TDR", value)
    port.poke("RQR", TXFRQ)
    assert port.flags & (TXE | TXFE | TXFT | TC) == TXE | TXFE | TXFT
    port.bits(10)
    assert port.flags & TC
    assert port.values == [0]


def test_clearing_ue_empties_both(port):
    hear(port, 1, 2)
    port.poke("TDR", 1)
    port.poke("TDR", 2)
    port.clear("CR1", UE)
    assert port.flags == 0x0280_00C0
    port.set("CR1", UE)
    port.bits(40)
    assert port.values == [1]
    assert not port.flags & RXNE


# --- the prescaler


PRESCALERS = (1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256, 256, 256, 256, 256)


@each("field", range(16))
def test_the_prescaler_divides_the_kernel_clock(make_fifo_port, field):
    port = make_fifo_port(kernel_hz=120_000_000)
    port.poke("PRESC", field)
    port.open(brr=130)
    assert port.usart.baud_hz * 130 * PRESCALERS[field] == 120_000_000
    port.poke("PRESC", 0)
    assert port.peek("PRESC") == field, "locked while UE is set"


# --- DMA


def test_dma_is_asked_for_as_long_as_there_is_something_to_move(make_fifo_port):
    port = make_fifo_port().open(cr1=FIFOEN | TE | RE, cr3=DMAR | DMAT)
    assert port.dma_tx.level
    hear(port, 1, 2)
    for _ in range(2):
        assert port.dma_rx.level
        port.peek("RDR")
    assert not port.dma_rx.level
    for value in range(17):
        assert port.dma_tx.level
        port.poke("TDR", value)
    assert not port.dma_tx.level


# --- all of it, against queues


STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("hear"), st.integers(0, 255)),
        st.tuples(st.just("read"), st.none()),
        st.tuples(st.just("write"), st.integers(0, 255)),
        st.tuples(st.just("bits"), st.integers(1, 60)),
        st.tuples(st.just("flush"), st.sampled_from([RXFRQ, TXFRQ])),
    ),
    max_size=80,
)


@given(steps=STEPS, control=st.tuples(st.integers(0, 7), st.integers(0, 7)))
def test_like_two_queues(make_fifo_port, steps, control):
    """What came in is read in its order; what goes out is what was written; levels are those of the queues."""
    rxft, txft = (THRESHOLDS[field] for field in control)
    port = make_fifo_port().open(cr1=FIFOEN | TE | RE, cr3=control[0] << 25 | control[1] << 29)
    received, waiting = deque(), deque()
    read, written = [], []
    for what, value in steps:
        if what == "hear":
            if len(received) < 17:
                received.append(value)
            port.hear(value)
        elif what == "read":
            got = port.peek("RDR")
            if received:
                read.append((received.popleft(), got))
        elif what == "write":
            if port.flags & TXE:
                written.append(value)
            port.poke("TDR", value)
        elif what == "bits":
            port.bits(value)
        else:
            if value == RXFRQ:
                received.clear()
            else:
                written = port.values
            port.poke("RQR", value)
        waiting = len(written) - len(port.sent)
        flags = port.flags
        assert bool(flags & RXNE) is bool(received)
        assert bool(flags & RXFF) is (len(received) == 17)
        assert bool(flags & RXFT) is (len(received) >= rxft)
        assert bool(flags & TXE) is (waiting < 16)
        assert bool(flags & TXFE) is (waiting == 0)
        assert bool(flags & TXFT) is (16 - waiting >= txft)
    port.bits(200)
    assert port.values == written
    assert all(expected == got for expected, got in read)
