"""Bytes that pass a stream unseen leave everything as those do that pass it access by access."""

from __future__ import annotations

import dataclasses
from fractions import Fraction
from functools import partial

import hypothesis.strategies as st
import pytest
from hypothesis import given

from targets.mcu.serial_line import SerialFormat, SerialFrame
from targets.mcu.services import Watch
from targets.mcu.stm32 import dma as dma_module
from targets.mcu.stm32.dma import Dma
from targets.mcu.stm32.dma_requests import Channels, Requests
from targets.mcu.stm32.usart_fifo import FifoUsart
from targets.mcu.testing import FakeChip, peek, poke

HCLK_HZ = 240_000_000
RAM, USARTS = 0x2000_0000, (0x4000_4400, 0x4000_4800)
TO_SEND, RECEIVED, SIZE = RAM, RAM + 0x400, 0x800
RDR, TDR = 0x24, 0x28
UE, RE, TE, IDLEIE, FIFOEN = 1 << 0, 1 << 2, 1 << 3, 1 << 4, 1 << 29
DMAR_DMAT, RTSE = 3 << 6, 1 << 8
EN, TEIE, HTIE_TCIE, TO_PERIPHERAL, CIRC, MINC = 1, 1 << 2, 3 << 3, 1 << 6, 1 << 8, 1 << 10


class Board:
    """Two USARTs of which DMA moves all bytes: streams 0 and 2 fetch, 1 and 3 store, in a ring."""

    def __init__(self, data, room, brr, cr1, cr3, fcr, watch=Watch.NOBODY):
        self.chip = FakeChip(HCLK_HZ)
        for n in (0, 1):
            self.chip.output(f"U{n}_TX").set_watch(watch)
        self.frames, self.moments = [], []
        requests = Requests()
        services = dataclasses.replace(self.chip.services, dma=requests.line)
        names = {(0, 0): ("U0_RX",), (1, 0): ("U0_TX",), (2, 0): ("U1_RX",), (3, 0): ("U1_TX",)}
        self.usarts = [
            self.chip.add(FifoUsart(f"U{n}", base, services, irq=n, kernel_hz=lambda: Fraction(HCLK_HZ)))
            for n, base in enumerate(USARTS)
        ]
        sources, irqs = Channels(requests, names), range(10, 18)
        self.dma = self.chip.add(Dma("DMA1", 0x4002_0000, services, sources=sources, irqs=irqs, between_memories=False))
        self.chip.bus.load(RAM, bytes(SIZE))
        for n, usart in enumerate(self.usarts):
            usart.on_frame = lambda frame, n=n: self._sent(n, frame)
            usart.on_word = lambda _data, _errors: self.moments.append(self.chip.time.now)
            poke(usart, "BRR", brr + n)
            poke(usart, "CR3", cr3)
            poke(usart, "CR1", UE | RE | TE | cr1)
            self.stream(2 * n, USARTS[n] + RDR, RECEIVED + 0x100 * n, room, MINC | CIRC | HTIE_TCIE, fcr)
            self.chip.bus.load(TO_SEND + 0x100 * n, data[n])
            self.stream(
                2 * n + 1, USARTS[n] + TDR, TO_SEND + 0x100 * n, len(data[n]), MINC | TO_PERIPHERAL | HTIE_TCIE, fcr
            )

    def _sent(self, n, frame):
        self.moments.append(self.chip.time.now)
        self.frames.append((n, self.chip.time.now, frame))

    def stream(self, number, peripheral, memory, count, control, fcr):
        poke(self.dma, f"S{number}NDTR", count)
        poke(self.dma, f"S{number}PAR", peripheral)
        poke(self.dma, f"S{number}M0AR", memory)
        poke(self.dma, f"S{number}FCR", fcr)
        poke(self.dma, f"S{number}CR", control | EN)

    def hear(self, n, data, start_cycle):
        """Let bytes come in without gaps."""
        usart, form = self.usarts[n], SerialFormat()
        bit_s = 1 / usart.baud_hz
        start_s = Fraction(start_cycle, HCLK_HZ)
        for value in data:
            frame = form.frame(value, start_s, bit_s)
            self.chip.time.at_time(start_s, lambda frame=frame: usart.receive(frame), order=1)
            start_s = frame.end_s

    def run(self, cuts, *, asleep):
        """Run to each of these cycles; return what is to be seen there."""
        time, seen = self.chip.time, []
        for cycle in cuts:
            while asleep and time.run_until(cycle) is not None:
                pass
            self.chip.advance_to(cycle)
            streams = [peek(self.dma, f"S{n}{register}") for n in range(4) for register in ("CR", "NDTR", "FCR")]
            flags = [peek(self.dma, "LISR"), *(usart[0x1C] for usart in self.usarts)]
            memory = [self.chip.bus.read(RAM + offset, 4) for offset in range(0, SIZE, 4)]
            irqs = [self.chip.irq(number).changes[:] for number in range(18)]
            seen.append((streams, flags, memory, irqs, self.frames[:]))
        return seen


SOME = st.binary(min_size=2, max_size=16)
END = 90_000


@given(
    data=st.tuples(SOME, SOME),
    heard=st.tuples(SOME, SOME),
    begins=st.tuples(st.integers(1, 8_000), st.integers(1, 8_000)),
    room=st.integers(1, 20),
    brr=st.sampled_from([52, 130, 200, 16]),
    cr1=st.sampled_from([0, IDLEIE, FIFOEN]),
    cr3=st.sampled_from([DMAR_DMAT, DMAR_DMAT, DMAR_DMAT | RTSE]),
    fcr=st.sampled_from([0x21, 0x21, 0x24, 0x27]),
    cuts=st.lists(st.tuples(st.integers(0, 60), st.integers(0, 14)), min_size=1, max_size=12),
)
def test_nobody_can_tell(data, heard, begins, room, brr, cr1, cr3, fcr, cuts):
    def board():
        made = Board(data, room, brr, cr1, cr3, fcr)
        for n in (0, 1):
            made.hear(n, heard[n], begins[n])
        return made

    once = board()
    once.run([END], asleep=False)
    begun = sorted(once.moments)  # what DMA does then is over within some cycles, which are of interest
    cycles = sorted({begun[index % len(begun)] + offset for index, offset in cuts})
    assert board().run([*cycles, END], asleep=True) == board().run([*cycles, END], asleep=False)


@pytest.mark.parametrize(
    ("cr1", "watch", "most"), [(0, Watch.NOBODY, True), (FIFOEN, Watch.NOBODY, False), (0, Watch.LIVE, False)]
)
def test_most_bytes_take_the_short_way_while_the_program_sleeps(monkeypatch, cr1, watch, most):
    taken, pass_unseen = [], dma_module.pass_unseen

    def count(*what, **how):
        taken.append(pass_unseen(*what, **how))
        return taken[-1]

    monkeypatch.setattr(dma_module, "pass_unseen", count)
    board = Board((bytes(40), bytes(40)), 16, 52, cr1, DMAR_DMAT, 0x21, watch)
    board.hear(0, bytes(40), 5_000)
    board.run([60_000], asleep=True)
    assert len(board.frames) == 80
    assert (sum(taken) > 80) is most


LBDL, LBDIE, LINEN, RTOEN, OVER8, RTOIE = 1 << 5, 1 << 6, 1 << 14, 1 << 23, 1 << 15, 1 << 26
BREAK = SerialFrame(start_s=Fraction(5000, HCLK_HZ), bit_s=Fraction(130, HCLK_HZ), bits=0, bit_count=9)
BYTE = SerialFormat().frame(0x5A, Fraction(5000, HCLK_HZ), Fraction(8, HCLK_HZ))


@pytest.mark.parametrize(
    ("brr", "cr1", "cr2", "frame"),
    [(130, 1 << 12, LINEN | LBDIE, BREAK), (16, OVER8 | RTOIE, RTOEN, BYTE)],
    ids=["a break that comes as a word, too", "a timeout of no bits"],
)
def test_who_is_woken_in_the_event_that_asks_sees_nothing_of_what_comes_later(brr, cr1, cr2, frame):
    def seen(*, asleep):
        board = Board((bytes(1), bytes(1)), 8, brr, 0, 0, 0x21)
        usart, time, at_wake_up = board.usarts[0], board.chip.time, []

        def look():
            at_wake_up.append((time.now, peek(board.dma, "S0NDTR"), board.chip.bus.read(RECEIVED, 4)))

        def wake(level):
            if level:
                time.halted = True  # as the machine does
                time.at(time.now, look, order=9)

        board.chip.irq(0).on_set = wake
        poke(usart, "CR1", 0)
        for register, value in (("RTOR", 0), ("CR2", cr2), ("CR3", DMAR_DMAT), ("CR1", UE | RE | TE | cr1)):
            poke(usart, register, value)
        time.at(5000, lambda: usart.receive(frame), order=1)
        while asleep and time.run_until(END) is not None:
            pass
        board.chip.advance_to(END)
        return at_wake_up

    assert seen(asleep=True) == seen(asleep=False) != []


@pytest.mark.parametrize("direction", [0, TO_PERIPHERAL])
@pytest.mark.parametrize("others", [0, 1])
def test_a_request_that_stays_is_served_as_fast_either_way(make_rig, direction, others):
    seen = []
    for private in (False, True):
        rig = make_rig()
        for number in range(2, 3 + others):
            rig.line(number).private = private
            rig.stream(number, direction | MINC | HTIE_TCIE | EN, 10, memory=RAM + 0x100 * number)
            rig.chip.time.at(100 + number, partial(rig.line(number).set, True))
        while rig.chip.time.run_until(10_000) is not None:
            pass
        seen.append([rig.irq(number).changes for number in range(8)])
    assert seen[0] == seen[1]
    assert len(seen[0][2]) == 1  # half of them; the rest of the flags keep it high


@pytest.mark.parametrize("direction", [0, TO_PERIPHERAL])
@pytest.mark.parametrize(
    "address", [{"memory": RAM + 0xFFD}, {"peripheral": 0x5000_0000}], ids=["memory", "peripheral"]
)
def test_an_access_that_fails_does_so_at_its_cycle(make_rig, direction, address):
    seen = []
    for private in (False, True):
        rig = make_rig()
        rig.line(2).private = private
        rig.stream(2, direction | MINC | TEIE | EN, 10, **address)
        for ask in range(8):
            rig.chip.time.at(100 + 40 * ask, rig.line(2).pulse)
        while rig.chip.time.run_until(10_000) is not None:
            pass
        seen.append((rig.irq(2).changes, rig.flags(2), rig.peek("S2NDTR"), rig.peek("S2CR")))
    assert seen[0] == seen[1]
    assert "TE" in seen[0][1]
