"""DMA streams behind a multiplexer, as in the STM32H7: which request reaches which stream, and when."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.stm32.dma import Dma
from targets.mcu.stm32.dma_requests import Requests
from targets.mcu.stm32.dmamux import DmaMux, Outlets
from targets.mcu.testing import FakeChip, peek, poke
from tests.each import each

RAM, PORT = 0x2400_0000, 0x4001_0000
EN, TCIE, CIRC, MINC, TRBUFF = 1 << 0, 1 << 4, 1 << 8, 1 << 10, 1 << 20
NAMES = {9: "A", 10: "B", 20: "C"}
ACCESS = 5 + 4  # cycles of AHB: peripheral, then memory


class Rig:
    """Two controllers of eight streams behind 16 channels, with three requests."""

    def __init__(self, ahb=1):
        self.chip = FakeChip(480_000_000, {"AHB": ahb})
        self.requests = Requests()
        services = self.chip.services
        self.mux = self.chip.add(
            DmaMux("DMAMUX1", 0x4002_0800, services, requests=self.requests, names=NAMES, channels=16)
        )
        self.dmas = [
            self.chip.add(
                Dma(
                    f"DMA{number + 1}",
                    0x4002_0000 + 0x400 * number,
                    services,
                    sources=Outlets(self.mux, 8 * number),
                    irqs=range(8 * number, 8 * number + 8),
                    between_memories=True,
                    control_bits=0x01FF_FFFF,
                )
            )
            for number in range(2)
        ]
        for peripheral in (self.mux, *self.dmas):
            peripheral.reset()
        self.chip.bus.load(RAM, bytes(0x1000))
        self.chip.bus.load(PORT, bytes(range(1, 0x41)))

    def lead(self, channel, number):
        poke(self.mux, f"C{channel}CR", number)

    def stream(self, channel, control=MINC | TRBUFF, count=4):
        dma, number = self.dmas[channel // 8], channel % 8
        poke(dma, f"S{number}NDTR", count)
        poke(dma, f"S{number}PAR", PORT)
        poke(dma, f"S{number}M0AR", RAM + 0x80 * channel)
        poke(dma, f"S{number}CR", control | EN)

    def left(self, channel):
        return peek(self.dmas[channel // 8], f"S{channel % 8}NDTR")

    def pulse(self, name):
        self.requests.line(name).pulse()
        self.chip.advance(200)


@pytest.fixture
def rig():
    return Rig()


@pytest.mark.parametrize("channel", [0, 1, 7, 8, 9, 15])
def test_a_channel_leads_its_request_to_its_stream(rig, channel):
    rig.lead(channel, 10)
    rig.stream(channel)
    rig.pulse("A")
    assert rig.left(channel) == 4
    rig.pulse("B")
    assert rig.left(channel) == 3
    assert rig.chip.bus.dump(RAM + 0x80 * channel, 2) == b"\x01\x00"


def test_several_channels_may_lead_the_same_request(rig):
    for channel in (0, 9):
        rig.lead(channel, 20)
        rig.stream(channel)
    rig.pulse("C")
    assert [rig.left(channel) for channel in (0, 9)] in ([3, 3], [4, 3], [3, 4])


def test_a_channel_may_be_led_elsewhere_while_the_stream_waits(rig):
    rig.lead(3, 9)
    rig.stream(3)
    rig.pulse("A")
    rig.requests.line("B").set(True)
    rig.lead(3, 10)
    rig.chip.advance(7)
    rig.requests.line("B").set(False)
    rig.chip.advance(200)
    assert rig.left(3) == 2
    rig.pulse("A")
    assert rig.left(3) == 2


def test_what_asked_before_is_served_once_the_channel_leads_it(rig):
    rig.requests.line("A").set(True)
    rig.stream(4)
    rig.chip.advance(200)
    assert rig.left(4) == 4
    rig.lead(4, 9)
    rig.chip.advance(200)
    assert rig.left(4) == 0


def test_the_last_transfer_is_told_to_the_peripheral(rig):
    told = []
    rig.requests.line("A").on_last = lambda: told.append(rig.chip.time.now)
    rig.lead(0, 9)
    rig.stream(0, count=2)
    rig.pulse("A")
    assert not told
    rig.pulse("A")
    assert len(told) == 1


@each("ahb", [1, 2, 4])
def test_accesses_take_cycles_of_ahb(ahb):
    rig = Rig(ahb)
    rig.lead(0, 9)
    rig.stream(0, MINC | TCIE, count=1)
    start = rig.chip.time.now
    rig.requests.line("A").pulse()
    rig.chip.advance(100)
    assert rig.chip.irq(0).rises == [start + ahb * ACCESS]


def test_what_is_not_modelled_says_so(rig):
    rig.lead(0, 1)
    rig.lead(1, 77)
    rig.lead(2, 9 | 1 << 16)
    poke(rig.mux, "RG0CR", 1 << 16)
    assert rig.chip.noted("unmodelled") == ["DMAMUX1_C0CR.DMAREQ_ID", "DMAMUX1_C2CR", "DMAMUX1_RG0CR"]
    assert rig.chip.noted("reserved") == ["DMAMUX1_C1CR.DMAREQ_ID"]


CHANNELS = (0, 5, 8, 15)
STEPS = st.lists(
    st.one_of(
        st.tuples(st.just("lead"), st.sampled_from(CHANNELS), st.sampled_from([0, 9, 10, 20, 3, 50])),
        st.tuples(st.just("pulse"), st.just(0), st.sampled_from("ABC")),
    ),
    max_size=40,
)


@given(steps=STEPS)
def test_each_request_moves_one_item_where_one_channel_leads_it(steps):
    """A request that two channels lead is served by one of them: it is one request, and who comes first takes it."""
    rig = Rig()
    led = dict.fromkeys(CHANNELS, 0)
    moved = dict.fromkeys(CHANNELS, 0)
    for channel in CHANNELS:
        rig.stream(channel, MINC | CIRC, count=100)
    waiting = set()
    for what, channel, value in steps:
        if what == "lead":
            led[channel] = value
            rig.lead(channel, value)
            rig.chip.advance(200)
            taken = {name for name in waiting if NAMES.get(value) == name}
            moved[channel] += len(taken)
            waiting -= taken
            continue
        number = next(number for number, name in NAMES.items() if name == value)
        hearing = [channel for channel in CHANNELS if led[channel] == number]
        if len(hearing) > 1:
            continue
        rig.pulse(value)
        if hearing:
            moved[hearing[0]] += 1
        else:
            waiting.add(value)
    assert {channel: 100 - rig.left(channel) for channel in CHANNELS} == moved
