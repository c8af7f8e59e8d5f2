"""What a USART sends on a bench in real time: bytes come together, and do not wait for a round that takes long."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from hilbench.clock import NS_PER_S
from hilbench.links.memory import REAL_TIME_GROUP_NS
from hilbench.mcu.group import LOCKED_STEP_NS
from hilbench.testing import FakeHostClock
from targets.mcu.services import Watch
from targets.mcu.testing import poke
from tests.share import examples

DATA = bytes(range(100, 150))
SENT_NS = 3_200_000
BAUDS = 921_600, 460_800
OVERRUN = 8


class Heard:
    """A board that sends `DATA` at once, and what its far end is told of that."""

    def __init__(self, emulate, baud, *, reacts=False, locked=True, each_frame=True):
        self.host, self.frames, self.chunks, self.known = FakeHostClock(), [], [], []

        def program(machine):
            machine.usart("USART1", baud)
            if not each_frame:  # whoever looks at the pin needs each, too
                machine.fake.output("USART1_TX").set_watch(Watch.NOBODY)
            machine.at_ns(SENT_NS, lambda: machine.send_all("USART1", DATA))

        self.emulated = emulate(program, step_ns=LOCKED_STEP_NS)
        self.port = self.emulated.ports["brain.usart1"]
        self.port.reacts, self.port.each_frame = reacts, each_frame
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
        assert len(self.frames) == len(DATA) or not self.port.each_frame
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


def test_where_nobody_needs_each_frame_the_chip_tells_of_many_and_the_bytes_are_the_same(emulate):
    heard, one_by_one = Heard(emulate, 921_600, each_frame=False), Heard(emulate, 921_600)
    chunks, expected = heard.run(), one_by_one.run()
    assert [data for data, _ in chunks] == [data for data, _ in expected]
    # frames begin at whole nanoseconds here, rounded down
    assert all(there - 1 <= here <= there for (_, here), (_, there) in zip(chunks, expected, strict=True))
    assert [frame.bits for frame in heard.frames] == [DATA[-1]]


@pytest.mark.parametrize("cr1", [(0x340C, 0x200C), (0x200C, 0x340C)])
def test_words_are_read_in_the_format_in_which_they_were_sent(emulate, cr1):
    """8 bits with parity, and without; the firmware chooses the other in the round in which it has sent."""
    got = []
    for each_frame in (True, False):
        heard = Heard(emulate, 921_600, each_frame=each_frame)
        usart = heard.port._usart
        heard.emulated.machines["brain"].at_ns(1_000_000, lambda usart=usart: poke(usart, "CR1", cr1[0]))
        heard.emulated.machines["brain"].at_ns(SENT_NS + 800_000, lambda usart=usart: poke(usart, "CR1", cr1[1]))
        heard.emulated.bench.run_for(0.02)
        got.append((b"".join(data for data, _ in heard.chunks), heard.port.counters.framing_errors))
    assert got[0] == got[1]
    assert len(got[0][0]) == len(DATA)


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


class Told:
    """A board that only listens, what it has heard, and a far end that writes to it in real time."""

    def __init__(self, emulate, *, each_frame):
        self.heard = []

        def program(machine):
            machine.usart("USART1", BAUDS[0])
            usart, time = machine.chip.usarts["USART1"], machine.time
            usart.on_word = lambda word, errors: self.heard.append((time.ns(time.now), word, errors & ~OVERRUN))

        self.emulated = emulate(program, step_ns=LOCKED_STEP_NS)
        self.port = self.emulated.ports["brain.usart1"]
        self.port.reacts, self.port.each_frame = False, each_frame
        self.tapped = bytearray()
        self.port.heard_taps.append(lambda data, _at_ns: self.tapped.extend(data))
        self.emulated.bench.scheduler.lock(FakeHostClock())
        self.emulated.bench.run_for(0.01)

    def do(self, actions):
        """Do things to the line, each so many us after the one before; return all that came of it."""
        value = itertools.count()
        for after_us, what, amount in actions:
            self.emulated.bench.run_for(after_us / 1e6)
            if what == "write":
                self.port.write(bytes(next(value) & 0xFF for _ in range(amount)))
            elif what == "withdraw":
                self.port.withdraw(amount)
            elif what == "baud":
                self.port.baud = BAUDS[amount % 2]
            else:
                self.port.send_break(amount * 1000)
        self.emulated.bench.run_for(0.1)
        return [(word, errors) for _, word, errors in self.heard], self.port.counters, self.port.pending, self.tapped


ACTIONS = st.lists(
    st.one_of(
        st.tuples(st.integers(0, 3000), st.just("write"), st.integers(1, 300)),
        st.tuples(
            st.integers(0, 3000), st.sampled_from(["withdraw", "withdraw", "baud", "break"]), st.integers(0, 100)
        ),
    ),
    min_size=1,
    max_size=8,
)


@settings(max_examples=examples(60), suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(actions=ACTIONS)
def test_bytes_that_the_chip_knows_of_beforehand_come_as_those_that_go_one_by_one(emulate, actions):
    by_the_block, one_by_one = Told(emulate, each_frame=False), Told(emulate, each_frame=True)
    assert by_the_block.do(actions) == one_by_one.do(actions)
    assert all(abs(a - b) <= 100 for (a, *_), (b, *_) in zip(by_the_block.heard, one_by_one.heard, strict=True))


def test_a_block_is_heard_without_a_word_to_anybody(emulate):
    told, looked = Told(emulate, each_frame=False), []
    told.port._machine.chip.usarts["USART1"].receive = looked.append
    assert len(told.do([(0, "write", 1000)])[0]) == 1000
    assert not looked
