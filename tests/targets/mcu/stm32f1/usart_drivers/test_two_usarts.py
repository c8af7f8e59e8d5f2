"""Two USARTs of two chips on one line: random formats, rates that differ a little, drivers that are late."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from tests.each import each
from tests.share import examples

RXNE, TXE = 0x20, 0x80
FLAWS = 0xF
FORMATS = {"8N1": (0, 0), "7E1": (0x400, 0), "8O2": (0x1600, 0x2000), "9N1": (0x1000, 0), "8E1": (0x1400, 0)}


class Station:
    """A chip whose driver sends a list of words and notes what it receives, by interrupt and with some latency."""

    def __init__(self, cpu, usart, brr, setting, words, latencies):
        self.cpu, self.usart, self.chip = cpu, usart, cpu.chip
        self.words, self.latencies = list(words), latencies
        self.turns = 0
        self.heard = []
        self.scheduled = False
        cr1, cr2 = setting
        for offset, value in ((0x08, brr), (0x10, cr2), (0x0C, 0x200C | cr1)):
            usart.write(offset, value)
        line = self.chip.irq({"USART1": 37, "USART2": 38, "USART3": 39}[usart.name])
        line.on_set = lambda level: self.schedule() if level else None
        usart.write(0x0C, 0x20AC | cr1)

    def schedule(self):
        if not self.scheduled:
            self.scheduled = True
            self.turns += 1
            self.chip.time.after(self.latencies[self.turns % len(self.latencies)], self.handle)

    def handle(self):
        self.scheduled = False
        flags = self.usart.read(0x00)
        if flags & RXNE:
            self.heard.append((self.usart.read(0x04), flags & FLAWS))
        elif flags & FLAWS:
            self.heard.append((None, flags & FLAWS))
            self.usart.read(0x04)
        if flags & TXE:
            if self.words:
                self.usart.write(0x04, self.words.pop(0))
            else:
                self.usart.write(0x0C, self.usart.read(0x0C) & ~0x80)
        if self.chip.irq({"USART1": 37, "USART2": 38, "USART3": 39}[self.usart.name]).level:
            self.schedule()


def join(one, other):
    for near, far in ((one, other), (other, one)):

        def carry(frame, far=far):
            far.chip.advance_to(far.chip.time.cycle_at(frame.start_s))
            far.usart.receive(frame)

        near.usart.on_frame = carry


def run(*stations):
    """Let the chip go on whose next event is the earliest in bench time, until nothing happens any more."""
    while True:
        due = []
        for index, station in enumerate(stations):
            cycle = station.chip.time.next_cycle()
            if cycle is not None:
                due.append((station.chip.time.seconds(cycle), index, cycle))
        if not due:
            return
        _, index, cycle = min(due)
        stations[index].chip.advance_to(cycle)


WORDS = st.lists(st.integers(0, 0x1FF), max_size=12)


@settings(max_examples=examples(60))
@given(
    text=st.sampled_from(sorted(FORMATS)),
    clocks=st.tuples(st.sampled_from((8_000_000, 36_000_000, 72_000_000)), st.sampled_from((8_000_000, 24_000_000))),
    baud=st.sampled_from((9600, 115200, 230400)),
    ways=st.tuples(WORDS, WORDS),
    latencies=st.lists(st.integers(1, 100), min_size=1, max_size=5),
)
def test_what_one_sends_the_other_receives(make_board, text, clocks, baud, ways, latencies):
    names = ("USART1", "USART2")
    stations = []
    for hclk_hz, name, words in zip(clocks, names, ways, strict=True):
        cpu, *_ = make_board(name, hclk_hz=hclk_hz, apb1=1)
        brr = (hclk_hz + baud // 2) // baud
        assert abs(hclk_hz / brr / baud - 1) < 0.015
        stations.append(Station(cpu, cpu.usarts[name], brr, FORMATS[text], words, latencies))
    one, other = stations
    join(one, other)
    run(one, other)
    for sender, receiver, words in ((one, other, ways[0]), (other, one, ways[1])):
        line_format = sender.usart.format
        assert receiver.heard == [(line_format.word(word), 0) for word in words]
        assert not sender.words


@each(("percent", "fine"), [(-6, False), (-3, True), (0, True), (3, True), (7, False)])
def test_how_far_rates_may_be_apart(make_board, percent, fine):
    words = [0x55, 0x00, 0xFF, 0x80, 0x01] * 4
    stations = []
    for name, brr, sent in (("USART1", 1000, []), ("USART2", 1000 * 100 // (100 + percent), words)):
        cpu, *_ = make_board(name, apb1=1)
        stations.append(Station(cpu, cpu.usarts[name], brr, FORMATS["8N1"], sent, [10]))
    join(*stations)
    run(*stations)
    assert (stations[0].heard == [(word, 0) for word in words]) is fine
    assert any(flaws for _, flaws in stations[0].heard) is not fine
