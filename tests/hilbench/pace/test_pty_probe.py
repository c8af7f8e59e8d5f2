"""What the kernel keeps of a byte that was written into a pseudo-terminal, while both ends are in time."""

from __future__ import annotations

import errno
import os
import select

import pytest

from hilbench.bench import Bench
from hilbench.clock import NS_PER_MS, Scheduler
from hilbench.errors import UnavailableError
from hilbench.journal import Journal
from hilbench.pace.lateness import IN_TIME
from hilbench.pace.pty_probe import PtyProbe
from tests.hilbench.hosts import SkippingHost

MS = NS_PER_MS


@pytest.fixture
def host():
    host = SkippingHost()
    yield host
    host.close()


@pytest.fixture
def probe(host, monkeypatch):
    """A probe whose bytes come when the test says so; the kernel of this host has no part in it."""
    scheduler = Scheduler()
    scheduler.lock(host)
    probe = PtyProbe(scheduler, host)
    scheduler.remove_source(probe)
    probe.there = True
    monkeypatch.setattr(PtyProbe, "_is_there", lambda self: self.there)
    monkeypatch.setattr("hilbench.pace.pty_probe.os.read", lambda descriptor, count: b"\0")
    yield probe
    scheduler.add_source(probe)
    probe.close()


def let_pass(probe, duration_ns, *, there):
    probe.there = there
    probe._scheduler.run_for(duration_ns)
    if there:
        probe.on_readable(probe._scheduler.now_ns)


def test_what_comes_at_once_adds_nothing(probe, host):
    begun_ns = host.monotonic_ns()
    for _ in range(20):
        let_pass(probe, 6 * MS, there=True)
    assert probe.lateness(begun_ns) == IN_TIME


def test_what_is_kept_counts_for_question_and_answer(probe, host):
    begun_ns = host.monotonic_ns()
    let_pass(probe, 41 * MS, there=False)  # sent after 5 ms, missed 35 ms later
    assert 2 * 35 * MS <= probe.lateness(begun_ns).late_ns <= 2 * 45 * MS
    let_pass(probe, 2 * MS, there=True)
    assert 2 * 35 * MS <= probe.lateness(begun_ns).late_ns <= 2 * 45 * MS


def test_a_look_right_after_it_was_sent_finds_nothing_late(probe, host):
    """A bench that was late itself looks again at once."""
    begun_ns = host.monotonic_ns()
    let_pass(probe, 5 * MS + 1, there=False)
    host.pass_time(MS // 4)
    probe._beat()
    assert probe.lateness(begun_ns) == IN_TIME
    let_pass(probe, MS, there=True)
    assert probe.lateness(begun_ns) == IN_TIME


def test_what_was_before_does_not_count(probe, host):
    let_pass(probe, 41 * MS, there=False)
    let_pass(probe, 2 * MS, there=True)
    let_pass(probe, 20 * MS, there=True)
    assert probe.lateness(host.monotonic_ns()) == IN_TIME


def test_a_span_that_begins_with_what_was_kept_is_that_much_too_short(probe, host):
    let_pass(probe, 41 * MS, there=False)
    let_pass(probe, 2 * MS, there=True)
    begun_ns = host.monotonic_ns()  # as of an answer that was kept beside the byte
    let_pass(probe, 4 * MS, there=True)
    assert 2 * 35 * MS <= probe.lateness(begun_ns).late_ns <= 2 * 45 * MS


def test_a_bench_is_no_surer_than_the_way_to_its_port(probe):
    bench = Bench(probe._scheduler, Journal())
    before_s = bench.uncertainty_s(0)
    bench.way = probe
    let_pass(probe, 44 * MS, there=False)
    assert bench.uncertainty_s(0) >= before_s + 0.07
    assert bench.lateness(0).late_ns >= 70 * MS


def test_to_look_for_it_does_not_have_the_kernel_hand_it_on(host, monkeypatch):
    """A poll of a pseudo-terminal waits for the kernel's worker, finds the byte, and makes the bench late instead."""

    def polled(*_):
        raise AssertionError("that waits for the worker")

    probe = PtyProbe(Scheduler(), host)
    for name in ("select", "poll"):
        monkeypatch.setattr(select, name, polled)
    assert not probe._is_there()
    probe._beat()
    while not probe._is_there():
        pass
    probe.close()


def test_where_there_is_no_pair_left_it_is_said_in_a_line(host, monkeypatch):
    def full():
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "openpty", full)
    with pytest.raises(UnavailableError, match="no pseudo-terminal: No space left on device"):
        PtyProbe(Scheduler(), host)


def test_a_real_byte_comes_through(host):
    scheduler = Scheduler()
    scheduler.lock(host)
    probe = PtyProbe(scheduler, host)
    probe._beat()
    while not probe._is_there():
        pass
    scheduler.run_for(MS)
    assert probe._sent_ns is None
    probe.close()
