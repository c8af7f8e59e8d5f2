from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from hilbench.clock import Scheduler
from hilbench.errors import PortClosedError
from hilbench.links import Line, MemoryLink
from hilbench.links.memory import REAL_TIME_GROUP_NS
from hilbench.links.uart import Sampler, resample

S = 10**9
BAUDS = [9600, 19_200, 38_400, 57_600, 115_200, 230_400, 250_000, 460_800, 921_600]


class Log:
    def __init__(self, port):
        self.got = []
        self.lines = []
        self.breaks = []
        port.on_receive = lambda data, at_ns: self.got.append((data, at_ns))
        port.on_line = lambda up, at_ns: self.lines.append((up, at_ns))
        port.on_break = self.breaks.append

    @property
    def data(self):
        return b"".join(data for data, _ in self.got)


@pytest.fixture
def scheduler():
    return Scheduler()


def exact_end_ns(baud, count):
    return int(Fraction(count * 10 * S, baud))


@settings(deadline=None)
@given(baud=st.sampled_from(BAUDS), data=st.binary(min_size=1, max_size=300), cuts=st.lists(st.integers(1, 299)))
def test_each_byte_comes_alone_when_its_stop_bit_ends(baud, data, cuts):
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=baud))
    log = Log(link.b)
    edges = [0, *sorted(set(cuts) & set(range(len(data)))), len(data)]
    for start, end in pairwise(edges):
        link.a.write(data[start:end])
    scheduler.run_for(S)
    assert log.got == [(data[i : i + 1], exact_end_ns(baud, i + 1)) for i in range(len(data))]


@given(
    baud=st.sampled_from(BAUDS),
    data=st.binary(min_size=1, max_size=300),
    group_ns=st.sampled_from([0, 50_000, REAL_TIME_GROUP_NS, 1_000_000]),
)
def test_bytes_of_a_group_come_when_its_last_is_complete(baud, data, group_ns):
    scheduler = Scheduler()
    link = MemoryLink(scheduler, Line(baud=baud), group_ns=group_ns)
    heard = []
    link.b.on_receive = lambda found, at_ns: heard.append((found, at_ns))
    link.a.write(data)
    scheduler.run_until(None, 10**12)
    assert b"".join(found for found, _ in heard) == data
    count = 0
    for found, at_ns in heard:
        count += len(found)
        assert at_ns == count * 10 * 10**9 // baud
        assert len(found) == 1 or len(found) * 10 * 10**9 // baud <= group_ns


def test_bytes_written_later_queue_behind_and_gaps_start_anew(scheduler):
    link = MemoryLink(scheduler, Line(baud=9600))
    log = Log(link.b)
    link.a.write(b"ab")
    scheduler.run_for(1_500_000)
    link.a.write(b"c")
    scheduler.run_for(S - 1_500_000)
    link.a.write(b"d")
    scheduler.run_for(S)
    assert [at_ns for _, at_ns in log.got] == [1_041_666, 2_083_333, 3_125_000, S + 1_041_666]


def test_both_directions_are_independent(scheduler):
    link = MemoryLink(scheduler, Line(baud=9600))
    to_a, to_b = Log(link.a), Log(link.b)
    link.a.write(b"x")
    link.b.write(b"y")
    scheduler.run_for(S)
    assert (to_a.got, to_b.got) == ([(b"y", 1_041_666)], [(b"x", 1_041_666)])
    assert (link.a.counters.sent, link.a.counters.received) == (1, 1)


def test_without_pace_everything_comes_in_the_next_entry(scheduler):
    link = MemoryLink(scheduler, Line(baud=0))
    log = Log(link.b)
    link.a.write(b"hello")
    assert log.got == []
    scheduler.run_for(0)
    assert log.got == [(b"hello", 0)]


def test_other_formats_take_their_bits():
    assert Line(baud=9600, parity="E").bits_per_byte == 11
    assert Line(baud=1000, stop_bits=2).bytes_ns(2) == 22_000_000
    with pytest.raises(ValueError):
        Line(baud=-1)


def test_a_new_rate_holds_from_the_next_byte(scheduler):
    link = MemoryLink(scheduler, Line(baud=9600))
    log = Log(link.b)
    link.a.write(b"ab")
    scheduler.run_for(500_000)
    link.a.baud = link.b.baud = 115_200
    scheduler.run_for(S)
    assert log.got == [(b"a", 1_041_666), (b"b", 1_041_666 + 86_805)]


def test_a_full_queue_overruns(scheduler):
    link = MemoryLink(scheduler, Line(baud=9600), tx_depth=4)
    log = Log(link.b)
    link.a.write(b"abcdef")
    scheduler.run_for(S)
    link.a.write(b"g")
    scheduler.run_for(S)
    assert log.data == b"abcdg"
    assert link.a.counters.overruns == 2


def test_echo_from_within_a_callback(scheduler):
    link = MemoryLink(scheduler, Line(baud=9600))
    log = Log(link.a)
    link.b.on_receive = lambda data, at_ns: link.b.write(data)
    link.a.write(b"abc")
    scheduler.run_for(S)
    assert log.data == b"abc"


def test_hang_up_and_restore(scheduler):
    link = MemoryLink(scheduler, Line(baud=9600))
    to_a, to_b = Log(link.a), Log(link.b)
    link.a.write(b"abc")
    scheduler.run_for(2 * 1_041_666)
    link.hang_up()
    scheduler.run_for(S)
    link.a.write(b"x")
    scheduler.run_for(S)
    link.restore()
    scheduler.run_for(0)
    link.a.write(b"d")
    scheduler.run_for(S)
    assert to_b.data == b"ad"
    assert [up for up, _ in to_a.lines] == [up for up, _ in to_b.lines] == [False, True]
    assert link.a.counters.lost == 3


def test_close(scheduler):
    link = MemoryLink(scheduler, Line(baud=9600))
    log = Log(link.b)
    link.a.close()
    link.a.close()
    scheduler.run_for(S)
    assert log.lines == [(False, 0)]
    for act in (lambda: link.a.write(b"x"), lambda: link.a.send_break(1)):
        with pytest.raises(PortClosedError):
            act()
    link.b.write(b"x")
    scheduler.run_for(S)
    assert link.b.counters.lost == 1
    link.close()


def test_break_comes_after_the_bytes_before_it(scheduler):
    link = MemoryLink(scheduler, Line(baud=9600))
    log = Log(link.b)
    link.a.write(b"a")
    link.a.send_break(2_000_000)
    link.a.write(b"b")
    scheduler.run_for(S)
    assert log.breaks == [3_041_666]
    assert log.got == [(b"a", 1_041_666), (b"b", 3_041_666 + 1_041_666)]
    assert link.b.counters.breaks == 1


class TestOtherRate:
    @given(st.binary(min_size=1, max_size=50), st.sampled_from(BAUDS), st.integers(-35, 35))
    @settings(deadline=None)
    def test_a_few_per_cent_off_is_understood(self, data, baud, per_mille):
        own_baud = baud * (1000 + per_mille) // 1000
        sampled = resample(data, baud, own_baud)
        assert bytes(byte.value for byte in sampled) == data
        assert not any(byte.framing_error for byte in sampled)

    @given(st.binary(min_size=1, max_size=50), st.sampled_from(BAUDS))
    @settings(deadline=None)
    def test_the_same_rate_changes_nothing_even_when_sampled(self, data, baud):
        sampler = Sampler(baud, baud)
        for index, value in enumerate(data):
            sampler.feed(index * 10 * S // baud, value)
        assert bytes(byte.value for byte in sampler.take(10 * S)) == data

    def test_known_garbage(self):
        # At twice the rate every bit is seen twice. The low of 0x00 lasts beyond the stop bit, and there is no second
        # falling edge in it.
        assert [byte.value for byte in resample(b"\x00", 9600, 19_200)] == [0x00]
        assert resample(b"\x00", 9600, 19_200)[0].framing_error
        assert [byte.value for byte in resample(b"\xff", 9600, 19_200)] == [0xFE]

    @pytest.mark.parametrize(("sent", "own"), [(9600, 115_200), (115_200, 9700), (9600, 38_400)])
    def test_the_link_garbles_and_counts(self, scheduler, sent, own):
        link = MemoryLink(scheduler, Line(baud=sent))
        link.b.baud = own
        log = Log(link.b)
        data = bytes(range(256))
        link.a.write(data)
        scheduler.run_for(2 * S)
        expected = resample(data, sent, own)
        assert abs(len(log.data) - len(expected)) <= 1
        assert log.data[:30] == bytes(byte.value for byte in expected)[:30]
        assert data not in log.data
        assert link.b.counters.framing_errors > 0

    def test_it_is_understood_again_at_the_right_rate(self, scheduler):
        link = MemoryLink(scheduler, Line(baud=9600))
        link.b.baud = 57_600
        log = Log(link.b)
        link.a.write(b"hello")
        scheduler.run_for(S)
        garbage = len(log.data)
        link.b.baud = 9600
        link.a.write(b"hello")
        scheduler.run_for(S)
        assert log.data[garbage:] == b"hello"

    def test_a_rate_of_zero_understands_all(self, scheduler):
        link = MemoryLink(scheduler, Line(baud=9600))
        link.b.baud = 0
        log = Log(link.b)
        link.a.write(b"hello")
        scheduler.run_for(S)
        assert log.data == b"hello"
