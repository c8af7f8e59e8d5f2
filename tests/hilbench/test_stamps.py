"""Times at a port that something else reads: what counts is when it had the bytes, not when the bench looked."""

from __future__ import annotations

import os
import resource
import select
import signal
import socket
from contextlib import closing, suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.bench import LOCAL_PORT_S, Bench
from hilbench.bench.stamps import Arrival, ByteStamps, PortStamps
from hilbench.clock import NS_PER_MS, NS_PER_S, Scheduler, precedence
from hilbench.clock.stamping import HEAD, stamp
from hilbench.errors import UnavailableError
from hilbench.journal import Journal
from hilbench.judging.recorder import recording
from hilbench.judging.verdicts import Violation
from hilbench.links import SerialPort
from hilbench.links.stamped import Stamped, StampingProcess
from hilbench.pace.lateness import IN_TIME, Lateness
from hilbench.systems.vehicle.simulator_peer import SimulatorPeer
from hilbench.terminal import own_process
from hilbench.testing import FakeHostClock
from protocols.carla import CommandFrame, encode_command

MS = NS_PER_MS
FRAME = encode_command(CommandFrame())


class ScriptedReader:
    """What read the port: a list of what it takes, each at its moment."""

    runs_first = True

    def __init__(self, now_ns):
        self._now_ns = now_ns
        self.ready, self._wakes = os.pipe()
        self.taken = []

    def fileno(self):
        return self.ready

    def take(self):
        return self.taken.pop(0) if self.taken and self.taken[0].by_ns <= self._now_ns() else None

    def close(self):
        os.close(self.ready)
        os.close(self._wakes)


class FarBench:
    """A bench of ours behind the port, that tells when it was due what it sent, or does not know any more."""

    def __init__(self, due=None, lateness=IN_TIME):
        self.due, self.late = due or {}, lateness

    def lateness(self, since_ns, now_ns):
        return self.late

    def due_between(self, after_ns, by_ns):
        return self.due.get(by_ns)

    def life_since(self, begin_ns):
        return lambda now_ns: now_ns - begin_ns


class Rig:
    """A checker at a port: the host's clock and the reader are made up, the port is a pseudo-terminal.

    All moments that a test names are milliseconds from the begin.
    """

    def __init__(self, *, stamped=True):
        self.host = FakeHostClock()
        self.reader = ScriptedReader(self.host.monotonic_ns)
        self.begin_ns = self.host.monotonic_ns()
        scheduler = Scheduler()
        scheduler.lock(self.host)
        self.bench = Bench(scheduler, Journal(None))
        self.bench.port_floor_s, self.bench.port_uncertainty_s = 0.0, LOCAL_PORT_S
        self.master, self.slave = os.openpty()
        if stamped:
            self.bench.stamps = ByteStamps(lambda _descriptor: self.reader)
        self.stamps = None if self.bench.stamps is None else PortStamps(self.bench.stamps)
        self.port = SerialPort(scheduler, os.ttyname(self.slave), stamps=self.stamps)
        self.peer = SimulatorPeer(self.bench, self.port)

    def close(self):
        self.port.close()
        os.close(self.master)
        os.close(self.slave)
        if self.bench.stamps is None:
            self.reader.close()

    def comes(self, data, at_ms, *, early_ms=0.1, seen_ms=None):
        """Have bytes come: the reader has them at a moment, and the checker is woken then or later."""
        by_ns = self.begin_ns + round(at_ms * MS)
        self.reader.taken.append(Stamped(data, by_ns - round(early_ms * MS), by_ns))
        self.host.arrive(self.begin_ns + round((at_ms if seen_ms is None else seen_ms) * MS), self.port._input)
        return by_ns

    def has_behind(self, far):
        """Have a bench of ours behind the port."""
        self.bench.far.append(far)
        self.stamps.far = far
        return far

    def busy(self, at_ms, for_ms):
        """Have the checker compute from a moment on, for so long."""
        scheduler = self.bench.scheduler
        scheduler.at(round(at_ms * MS), lambda: self.host.advance(round(for_ms * MS)))


@pytest.fixture
def rig():
    with closing(Rig()) as rig:
        yield rig


def judged(rig, within_s):
    """Wait for a frame, and return the figure that came of it and whether it could be judged."""
    with recording() as recorded, suppress(Violation):
        rig.peer.expect(CommandFrame, within_s)
    (measure,) = recorded.measures
    return measure, not recorded.unclear


class TestReadLate:
    @pytest.mark.parametrize("busy_ms", [40, 100])
    def test_a_checker_that_reads_late_judges_by_what_its_reader_stamped_in_time(self, rig, busy_ms):
        rig.comes(FRAME, 190)
        rig.busy(185, busy_ms)
        measure, clear = judged(rig, 0.2)
        assert clear
        assert measure.value == pytest.approx(0.190)
        assert measure.uncertainty == pytest.approx(0.0001 + LOCAL_PORT_S)

    def test_a_reader_that_was_late_itself_judges_nothing_that_near(self, rig):
        rig.comes(FRAME, 205, early_ms=15)
        assert not judged(rig, 0.2)[1]
        assert judged_later(rig, early_ms=4)[1]

    def test_a_frame_that_is_too_late_fails_though_the_checker_was_late_too(self, rig):
        rig.comes(FRAME, 202)
        rig.busy(150, 45)
        measure, clear = judged(rig, 0.2)
        assert clear
        assert measure.margin < 0

    def test_bytes_that_come_while_the_checker_reads_are_heard_before_the_port_hangs_up(self, rig):
        def take():
            if heard:
                raise OSError
            rig.host.advance(MS)  # the reader has more, and the end, before the checker has taken all
            heard.append(by_ns := rig.host.monotonic_ns())
            return Stamped(FRAME, by_ns - MS, by_ns)

        heard = []
        rig.reader.take = take
        rig.host.arrive(rig.begin_ns + 10 * MS, rig.port._input)
        rig.port.on_line = lambda *_: rig.port.close()  # as a port does that may come back
        rig.bench.run_for(0.1)
        assert rig.port.closed
        assert len(rig.peer.frames()) == 1

    def test_without_stamps_how_late_the_checker_was_counts(self):
        with closing(Rig(stamped=False)) as rig:
            rig.busy(185, 30)
            rig.host.arrive(rig.begin_ns + 190 * MS, rig.port._input)
            os.write(rig.master, FRAME)
            assert not judged(rig, 0.2)[1]

    def test_what_was_read_late_comes_in_its_order_and_begins_when_it_came(self, rig):
        first_ns, second_ns = (rig.comes(FRAME, at_ms, seen_ms=30) for at_ms in (10, 20))
        happened = []
        rig.peer.port.on_sent = lambda _data, at_ns: happened.append(at_ns)
        rig.bench.scheduler.at(15 * MS, lambda: rig.peer.write(b"x"))
        rig.busy(5, 25)
        rig.bench.run_for(0.1)
        assert [rig.begin_ns + got.start_ns for got in rig.peer.frames()] == [first_ns, second_ns]
        assert happened == [15 * MS]


def judged_later(rig, early_ms):
    rig.comes(FRAME, 400, early_ms=early_ms)
    return judged(rig, 0.3)


class TestSpans:
    def test_between_two_stamps_how_exactly_both_are_known_counts(self, rig):
        for at_ms, early_ms in ((100, 0.2), (200, 0.7), (300, 0.1)):
            rig.comes(FRAME, at_ms, early_ms=early_ms)
        rig.busy(150, 45)
        rig.bench.run_for(0.4)
        first, second, third = (got.start_ns for got in rig.peer.frames())
        assert rig.bench.span(first, second, unprompted=True) == pytest.approx((0.1, 0.0007))
        assert rig.bench.span(first, third, unprompted=True) == pytest.approx((0.2, 0.0002))
        assert rig.bench.uncertainty_s(first) > 0.04

    def test_a_stimulus_that_leaves_late_makes_what_is_measured_from_it_less_certain(self, rig):
        rig.bench.scheduler.at(100 * MS, lambda: rig.peer.write(b"x"))
        rig.busy(99, 6)
        rig.comes(FRAME, 200)
        rig.bench.run_for(0.3)
        (got,) = rig.peer.frames()
        span = rig.bench.span(100 * MS, got.start_ns)
        assert span.s == pytest.approx(0.1)
        assert 0.005 <= span.doubt_s <= 0.006
        assert rig.bench.span(99 * MS, got.start_ns).doubt_s >= span.doubt_s  # the same was sent meanwhile

    def test_a_stall_of_bench_time_shortens_no_span_between_stamps(self, rig):
        for at_ms in (100, 300):
            rig.comes(FRAME, at_ms)
        rig.busy(150, 120)
        rig.bench.run_for(0.3)
        first, second = (got.start_ns for got in rig.peer.frames())
        assert (second - first) / NS_PER_S < 0.15
        assert rig.bench.span(first, second, unprompted=True) == pytest.approx((0.2, 0.0001))

    def test_a_bench_of_ours_tells_when_it_should_have_sent(self, rig):
        first_ns, second_ns = rig.comes(FRAME, 103), rig.comes(FRAME, 200.5)
        far = rig.has_behind(FarBench({first_ns: (100 * MS, 100.4 * MS), second_ns: (200.2 * MS, 200.2 * MS)}))
        rig.bench.run_for(0.3)
        first, second = (got.start_ns for got in rig.peer.frames())
        # The groups in which bytes pass its line, and half of what it left open.
        assert rig.bench.span(first, second, unprompted=True) == pytest.approx((0.1, 0.0001 + 0.0002))
        far.late = Lateness(late_ns=3 * MS, lost_ns=60 * MS)  # that it stood still meanwhile moves all that it sends
        assert rig.bench.span(first, second, unprompted=True).doubt_s == pytest.approx(0.0003 + 0.06)
        assert rig.bench.span(first, second) == pytest.approx((0.0975, 0.0001 + 0.063 + LOCAL_PORT_S))

    def test_where_more_lies_between_or_nobody_remembers_how_late_it_was_counts(self, rig):
        first_ns, second_ns = rig.comes(FRAME, 100), rig.comes(FRAME, 200)
        far = rig.has_behind(FarBench({first_ns: (0, 0), second_ns: (0, 0)}, Lateness(late_ns=2 * MS)))
        rig.bench.adapter_s = 0.001
        rig.bench.run_for(0.15)
        far.due.clear()
        rig.bench.run_for(0.15)
        first, second = (got.start_ns for got in rig.peer.frames())
        assert rig.bench.span(first, second, unprompted=True) == pytest.approx((0.1, 0.0001 + 0.002 + 0.001))
        rig.bench.adapter_s = 0.0
        assert rig.bench.span(first, second, unprompted=True) == pytest.approx((0.1, 0.0001 + 0.002))

    def test_of_two_chunks_of_one_moment_the_less_exact_counts(self, rig):
        rig.has_behind(FarBench({rig.comes(FRAME, 100): (0, 0)}, Lateness(late_ns=2 * MS)))
        rig.comes(b"x", 100, early_ms=0.7)
        rig.comes(FRAME, 200)
        rig.bench.run_for(0.3)
        first, second = (got.start_ns for got in rig.peer.frames())
        assert rig.bench.span(first, second, unprompted=True) == pytest.approx((0.1, 0.0027))

    def test_of_two_ports_the_later_one_may_tell_first(self, rig):
        """In a stall the bytes of both have one bench time, and each port is read when its turn comes."""
        for after_ns, by_ns in ((5, 9), (2, 7)):
            rig.stamps.came(100 * MS, Stamped(b"x", after_ns, by_ns))
        assert rig.bench.stamps.arrival(100 * MS) == Arrival(2, 9, None)

    def test_what_had_to_wait_behind_other_bytes_left_late(self, rig):
        rig.bench.scheduler.at(100 * MS, lambda: rig.peer.write(bytes(1 << 17)))  # more than the system takes
        rig.bench.scheduler.at(200 * MS, lambda: rig.peer.write(b"x"))
        rig.bench.scheduler.at(300 * MS, lambda: [os.read(rig.master, 4096) for _ in range(2)])
        rig.comes(FRAME, 400)
        rig.bench.run_for(0.5)
        (got,) = rig.peer.frames()
        assert rig.bench.span(200 * MS, got.start_ns).doubt_s >= 0.1

    def test_what_has_no_stamp_is_as_uncertain_as_ever(self, rig):
        rig.bench.run_for(0.1)
        assert rig.bench.span(10 * MS, 50 * MS, unprompted=True) == (0.04, rig.bench.uncertainty_s(10 * MS))
        free = Bench(Scheduler(), Journal(None))
        assert free.span(10 * MS, 50 * MS) == (0.04, 0.0)


@given(st.lists(st.tuples(st.integers(1, 40), st.integers(0, 200)), max_size=20), st.integers(0, 1000))
def test_a_moment_of_the_host_has_the_bench_time_that_it_had(stalls, since_ms):
    host, scheduler = FakeHostClock(), Scheduler()
    scheduler.lock(host)
    begin_ns, seen = host.monotonic_ns(), []
    for wait_ms, stall_ms in stalls:
        scheduler.run_for(wait_ms * MS)
        seen.append((host.monotonic_ns(), scheduler.now_ns))
        host.advance(stall_ms * MS)
    scheduler.run_for(MS)
    for host_ns, now_ns in seen:
        assert now_ns - 1 <= scheduler.bench_ns(host_ns) <= now_ns  # a pause is counted just before what comes next
    moments = [scheduler.bench_ns(begin_ns + ms * MS) for ms in range(since_ms)]
    assert moments == sorted(moments)


class TestStamping:
    """What the process does, in this one: the clock is made up, and things happen as it is looked at."""

    def records(self, happenings, *, data=b""):
        ours, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        reads, writes = os.pipe()
        os.write(writes, data)
        looks = iter(range(1, 1000))

        def now_ns():
            look = next(looks)
            happenings.get(look, lambda _writes: None)(writes)
            return look

        with ours, its:
            stamp(reads, its, now_ns, look_every_s=0)
            os.close(reads)
            its.close()
            return [(*HEAD.unpack_from(record), record[HEAD.size :]) for record in iter(lambda: ours.recv(5000), b"")]

    def test_bytes_have_the_last_moment_without_them_and_the_first_with_them(self):
        happenings = {3: lambda writes: os.write(writes, b"ab"), 5: os.close}
        # Looks 1 and 2 find nothing, and what comes during the third is there when it has looked; 4 stamps it.
        assert self.records(happenings) == [(2, 4, b"ab"), (2, 6, b"")]

    def test_of_what_was_there_from_the_beginning_nobody_knows_since_when(self):
        assert self.records({3: os.close}, data=b"old")[0] == (0, 2, b"old")

    def test_it_ends_when_nobody_listens(self):
        ours, its = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        reads, writes = os.pipe()
        ours.close()
        with its:
            stamp(reads, its, iter(range(100)).__next__, look_every_s=0)
        for descriptor in (reads, writes):
            os.close(descriptor)

    def test_a_process_reads_a_terminal_until_it_hangs_up(self):
        master, slave = os.openpty()
        os.set_blocking(slave, False)
        with closing(StampingProcess(slave)) as reader:
            got = b""
            os.write(master, b"hello\n")
            while got != b"hello\n":
                select.select((reader,), (), (), 60)
                read = reader.take()
                assert read is not None, "a target was asked before the process had begun to read"
                assert read.after_ns < read.by_ns
                got += read.data
            os.close(master)
            select.select((reader,), (), (), 60)
            with pytest.raises(OSError, match="gone"):
                reader.take()
        os.close(slave)

    def test_one_that_does_not_begin_is_no_hung_up_port(self, rig, monkeypatch):
        monkeypatch.setattr("sys.executable", "true")
        with pytest.raises(UnavailableError, match="has not begun"):
            StampingProcess(rig.slave)

    def test_where_none_can_be_started_the_bench_reads_by_itself(self, rig):
        def refuse(_descriptor):
            raise OSError

        rig.port.close()
        stamps = PortStamps(nobody := ByteStamps(refuse))
        with closing(SerialPort(rig.bench.scheduler, os.ttyname(rig.slave), stamps=stamps)) as port:
            assert port._input.descriptor == port._descriptor
            assert not nobody.words


class TestPrecedence:
    @pytest.fixture(autouse=True)
    def _limits_of_this_process(self):
        before, limits = signal.getsignal(signal.SIGXCPU), resource.getrlimit(resource.RLIMIT_RTTIME)
        yield
        signal.signal(signal.SIGXCPU, before)
        resource.setrlimit(resource.RLIMIT_RTTIME, limits)

    def test_who_may_not_is_run_as_any_other(self, monkeypatch):
        def refuse(*_):
            raise PermissionError

        monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
        monkeypatch.setattr(os, "sched_setscheduler", refuse)
        assert not precedence.take_precedence(precedence.OF_A_READER)

    def test_who_has_one_processor_leaves_it_to_others(self, monkeypatch):
        asked = []
        monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0})
        monkeypatch.setattr(os, "sched_setscheduler", lambda *words: asked.append(words))
        assert not precedence.take_precedence(precedence.OF_A_READER)
        assert not asked

    def test_a_reader_comes_before_a_bench_and_its_children_before_nobody(self, monkeypatch):
        asked = []
        monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
        monkeypatch.setattr(os, "sched_setscheduler", lambda *words: asked.append(words))
        for priority in (precedence.OF_A_BENCH, precedence.OF_A_READER):
            assert precedence.take_precedence(priority)
        (_, how, bench), (_, _, reader) = asked
        assert how == os.SCHED_FIFO | os.SCHED_RESET_ON_FORK
        assert bench.sched_priority < reader.sched_priority

    def test_who_computes_without_end_gives_way(self, monkeypatch):
        """An endless loop in somebody's suite keeps no processor from the others."""
        asked, limits = [], []
        monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
        monkeypatch.setattr(os, "sched_setscheduler", lambda _process, how, _priority: asked.append(how))
        monkeypatch.setattr(resource, "setrlimit", lambda *words: limits.append(words))
        assert precedence.take_precedence(precedence.OF_A_BENCH)
        ((which, (most_us, _)),) = limits
        assert (which, most_us) == (resource.RLIMIT_RTTIME, 1_000_000)
        os.kill(os.getpid(), signal.SIGXCPU)
        assert asked[1] & ~os.SCHED_RESET_ON_FORK == os.SCHED_OTHER

    def test_who_may_not_take_back_that_children_are_as_others_gives_way_all_the_same(self, monkeypatch):
        """Linux refuses whoever has no CAP_SYS_NICE to give SCHED_RESET_ON_FORK back (sched(7))."""
        asked = []
        monkeypatch.setattr(os, "sched_setscheduler", lambda _process, how, _priority: asked.append(how))
        precedence.give_way()
        assert asked == [os.SCHED_OTHER | os.SCHED_RESET_ON_FORK]

    def test_the_process_of_a_test_is_not_the_command_s(self):
        assert not own_process.is_ours()
