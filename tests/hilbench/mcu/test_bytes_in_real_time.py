"""What a USART sends on a bench in real time: bytes come together, and do not wait for a round that takes long."""

from __future__ import annotations

import itertools

import pytest

from hilbench.clock import NS_PER_S
from hilbench.links.memory import REAL_TIME_GROUP_NS
from hilbench.mcu.group import LOCKED_STEP_NS
from hilbench.testing import FakeHostClock

DATA = bytes(range(100, 150))
SENT_NS = 3_200_000


class Heard:
    """A board that sends `DATA` at once, and what its far end is told of that."""

    def __init__(self, emulate, baud, *, reacts=False, locked=True):
        self.host, self.frames, self.chunks, self.known = FakeHostClock(), [], [], []

        def program(machine):
            machine.usart("USART1", baud)
            machine.at_ns(SENT_NS, lambda: machine.send_all("USART1", DATA))

        self.emulated = emulate(program, step_ns=LOCKED_STEP_NS)
        self.port = self.emulated.ports["brain.usart1"]
        self.port.reacts = reacts
        self.port.frame_taps.append(self.frames.append)
        self.port.on_receive = self._take
        if locked:
            self.emulated.bench.scheduler.lock(self.host)

    def _take(self, data, at_ns):
        self.chunks.append((data, at_ns))
        self.known.append(len(self.frames))

    def run(self):
        self.emulated.bench.run_for(0.02)
        assert b"".join(data for data, _ in self.chunks) == DATA
        assert len(self.frames) == len(DATA)
        return self.chunks

    def frames_of_chunks(self):
        begin = 0
        for data, at_ns in self.chunks:
            yield self.frames[begin : begin + len(data)], at_ns
            begin += len(data)


def test_bytes_that_end_within_a_tenth_of_a_millisecond_are_told_of_when_the_last_is_complete(emulate):
    heard = Heard(emulate, 921_600)
    assert max(len(data) for data, _ in heard.run()) == 9
    for frames, at_ns in heard.frames_of_chunks():
        assert at_ns == frames[-1].end_ns
        assert frames[-1].end_ns - frames[0].start_ns <= REAL_TIME_GROUP_NS


def test_how_long_a_round_takes_is_told_by_the_clock_that_the_bench_follows_and_no_other(emulate, monkeypatch):
    hours_ns = itertools.count(step=3_600 * NS_PER_S)
    monkeypatch.setattr("time.monotonic_ns", lambda: next(hours_ns))
    assert max(len(data) for data, _ in Heard(emulate, 921_600).run()) == 9


@pytest.mark.parametrize(
    "how", [{"baud": 115_200}, {"baud": 921_600, "reacts": True}, {"baud": 921_600, "locked": False}], ids=str
)
def test_slow_bytes_and_those_that_somebody_may_answer_come_alone(emulate, how):
    heard = Heard(emulate, **how)
    assert {len(data) for data, _ in heard.run()} == {1}
    assert [at_ns for _, at_ns in heard.chunks] == [frame.end_ns for frame in heard.frames]


@pytest.mark.parametrize(("frame_takes_ns", "known_at_most"), [(200_000, 7), (1_000, len(DATA))])
def test_what_is_out_does_not_wait_until_the_host_is_through_with_the_rest_of_a_step(
    emulate, frame_takes_ns, known_at_most
):
    heard = Heard(emulate, 921_600)
    heard.port.frame_taps.append(lambda _frame: heard.host.advance(frame_takes_ns))
    heard.run()
    assert heard.known[0] <= known_at_most
    assert (heard.known[0] < len(DATA)) is (known_at_most < len(DATA))
