"""What was measured at a port makes the verdicts on times at that port less certain, and never more."""

from __future__ import annotations

import os
import pty
import socket
from contextlib import closing

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.bench import LOCAL_PORT_S, LOCKED_FLOOR_S, Bench
from hilbench.check.bench_provider import make_provider
from hilbench.clock import NS_PER_MS, Scheduler
from hilbench.journal import Journal
from hilbench.judging.judge import at_most
from hilbench.judging.provider import CaseInfo
from hilbench.judging.verdicts import Inconclusive
from hilbench.ports.calibration import Calibration, keep, key_of
from hilbench.ports.listing import PortInfo, UsbIdentity
from hilbench.terminal.options import CheckOptions, TargetChoice
from hilbench.testing import FakeHostClock

USB = UsbIdentity(vendor_id=0x0403, product_id=0x6001, serial_number="A1", location="1-1")


class SilentHostClock(FakeHostClock):
    """The host's clock of a bench whose real ports say nothing: time need not pass for that."""

    def close(self):
        assert self.watched == []


@pytest.fixture(autouse=True)
def no_waiting_for_silence(monkeypatch):
    monkeypatch.setattr("hilbench.bench.locked_providers.MonotonicHostClock", SilentHostClock)


def locked_bench(late_ms=0):
    scheduler, clock = Scheduler(), FakeHostClock()
    scheduler.lock(clock)
    bench = Bench(scheduler, Journal(None))
    if late_ms:
        clock.stall(clock.monotonic_ns() + NS_PER_MS, round(late_ms * NS_PER_MS))
    bench.run_for(0.1)
    return bench


@given(st.integers(0, 40), st.floats(0, 0.1))
def test_it_adds_to_the_lateness_of_the_host_and_takes_nothing_away(late_ms, port_s):
    bench = locked_bench(late_ms)
    before_s = bench.uncertainty_s(0)
    late_s = bench.scheduler.lateness_max_ns(0) / 1e9
    bench.port_uncertainty_s = port_s
    assert bench.uncertainty_s(0) == pytest.approx(max(LOCKED_FLOOR_S, late_s + port_s))
    assert bench.uncertainty_s(0) >= before_s


def test_it_turns_a_verdict_near_the_limit_into_an_open_one():
    bench = locked_bench()
    at_most(0.190, 0.2, unit="s", what="the answer took", uncertainty=bench.uncertainty_s(0))
    bench.port_uncertainty_s = 0.016
    with pytest.raises(Inconclusive):
        at_most(0.190, 0.2, unit="s", what="the answer took", uncertainty=bench.uncertainty_s(0))


def test_a_bench_in_virtual_time_is_exact_whatever_is_kept():
    bench = Bench(Scheduler(), Journal(None))
    bench.port_uncertainty_s = 1.0
    assert bench.uncertainty_s(0) == 0.0


@pytest.mark.parametrize("calibrated", [True, False])
def test_a_check_at_a_port_takes_what_is_kept_of_it_and_says_so(tmp_path, monkeypatch, calibrated):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    master, slave = pty.openpty()
    ports = [PortInfo(device=os.ttyname(slave), usb=USB)]
    key = key_of(os.ttyname(slave), ports)
    if calibrated:
        keep(
            Calibration(
                key=key,
                target="x",
                measured_at="",
                baud=9600,
                round_trips=1,
                lost=0,
                wire_s=0.0,
                excess_p50_s=0.0,
                excess_p99_s=0.0,
                excess_max_s=0.0161,
                jitter_s=0.0,
                paced_bytes=1,
                paced_returned=1,
                paced_expected_s=0.0,
            )
        )
    monkeypatch.setattr("hilbench.bench.locked_providers.list_ports", lambda: ports)
    provider = make_provider(CheckOptions(targets=(TargetChoice(spec=f"serial:{os.ttyname(slave)}"),)))
    try:
        with provider.open_case(CaseInfo(id="x", clause_ids=(), seed=0)) as bench:
            bench.finish("pass", "")
        assert provider._bench.port_uncertainty_s == (0.0161 if calibrated else LOCAL_PORT_S)
        assert provider._bench.port_floor_s == 0
        assert provider._bench.way is not None  # behind the port is no adapter, whatever is kept of it
        said = provider.describe().get("calibration")
        assert said == (f"16.10 ms at {key}" if calibrated else None)
    finally:
        provider.close()
        os.close(master)
        os.close(slave)


class Reader:
    """Stands in for the process that reads a port."""

    runs_first = False

    def __init__(self, descriptor):
        self._descriptor = descriptor

    def fileno(self):
        return self._descriptor

    def close(self):
        """Nothing is held."""


def test_a_check_of_the_command_itself_runs_before_others_and_has_ports_read_by_processes(monkeypatch):
    master, slave = pty.openpty()
    happened = []
    here = "hilbench.bench.locked_providers."
    monkeypatch.setattr(here + "own_process.is_ours", lambda: True)
    monkeypatch.setattr(here + "freeze_memory", lambda: happened.append("freeze"))
    monkeypatch.setattr(here + "take_precedence", lambda _: happened.append("first") or True)
    monkeypatch.setattr(here + "give_way", lambda: happened.append("as others"))
    monkeypatch.setattr(here + "StampingProcess", lambda port: happened.append("reads") or Reader(port))
    provider = make_provider(CheckOptions(targets=(TargetChoice(spec=f"serial:{os.ttyname(slave)}"),)))
    with closing(provider):
        with provider.open_case(CaseInfo(id="x", clause_ids=(), seed=0)) as bench:
            bench.finish("pass", "")
        assert provider._bench.adapter_s == 0
        said = provider.describe()["stamps"]
        assert said == "by a process for each port, which Linux runs as any other (no SCHED_FIFO)"
    assert happened == ["reads", "freeze", "first", "as others"]  # a start that is waited for is no lateness
    os.close(master)
    os.close(slave)


@given(st.integers(0, 40), st.floats(0, 0.1))
def test_where_nothing_is_unknown_of_the_port_there_is_no_least_uncertainty(late_ms, port_s):
    bench = locked_bench(late_ms)
    bench.port_floor_s, bench.port_uncertainty_s = 0.0, port_s
    late_s = bench.scheduler.lateness_max_ns(0) / 1e9
    assert bench.uncertainty_s(0) == pytest.approx(late_s + port_s)


@pytest.mark.parametrize(("late_us", "lately_s"), [(1000, 0.001), (40_000, LOCKED_FLOOR_S)])
def test_how_late_the_host_was_just_before_counts_as_well_up_to_the_usual_least(late_us, lately_s):
    bench = locked_bench(late_us / 1000)
    bench.port_floor_s, bench.port_uncertainty_s = 0.0, LOCAL_PORT_S
    expected_s = min(LOCKED_FLOOR_S, lately_s + LOCAL_PORT_S)
    assert bench.uncertainty_s(bench.now_ns) == pytest.approx(expected_s, rel=0.13)
    bench.run_for(1.0)
    assert bench.uncertainty_s(bench.now_ns) == LOCAL_PORT_S


class Door:
    """A foreign port, as pyserial opens it, which nobody reads."""

    def __init__(self, monkeypatch):
        self.server, self.client = socket.socketpair()
        monkeypatch.setattr("hilbench.links.serialport.open_serial", lambda *_: self)
        monkeypatch.setattr("hilbench.links.serialport.close_serial", lambda _: None)

    def fileno(self):
        return self.client.fileno()

    def close(self):
        self.server.close()
        self.client.close()


@pytest.mark.parametrize(
    ("target", "floor_s", "port_s"),
    [
        ("socket://127.0.0.1:8101", 0.0, LOCAL_PORT_S),
        ("rfc2217://localhost:4000", 0.0, LOCAL_PORT_S),
        ("socket://192.0.2.1:8101", LOCKED_FLOOR_S, 0.0),
        ("serial:/dev/ttyUSB0", LOCKED_FLOOR_S, 0.0),
        ("serial:/dev/null", LOCKED_FLOOR_S, 0.0),
    ],
)
def test_what_a_port_adds_follows_from_where_it_leads(monkeypatch, target, floor_s, port_s):
    monkeypatch.setattr("hilbench.bench.locked_providers.list_ports", list)
    provider = make_provider(CheckOptions(targets=(TargetChoice(spec=target),)))
    with closing(Door(monkeypatch)), closing(provider), provider.open_case(CaseInfo(id="x", clause_ids=(), seed=0)):
        assert (provider._bench.port_floor_s, provider._bench.port_uncertainty_s) == (floor_s, port_s)


@pytest.mark.parametrize(
    ("door", "floor_s"),
    [("pty:{}/door", 0), ("tcp:0", 0), ("tcp:[::1]:0", 0), ("tcp:0.0.0.0:0", LOCKED_FLOOR_S)],
)
def test_a_client_comes_from_this_host_or_from_anywhere(tmp_path, door, floor_s):
    spec = f"listen:{door.format(tmp_path)}"
    provider = make_provider(CheckOptions(suites=("p2os-client",), targets=(TargetChoice(spec=spec),)))
    with closing(provider), provider.open_case(CaseInfo(id="x", clause_ids=(), seed=0)):
        assert provider._bench.port_floor_s == floor_s
