"""One measurement: a bench, with or without a dashboard, over a span of host time."""

from __future__ import annotations

import contextlib
import os
import select
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from hilbench.clock import Stopwatch
from hilbench.live.folders import new_session
from hilbench.tui.bench_process import BenchProcess, Phase
from hilbench.tui.model.follower import Follower
from measure.dashboard_load.screen import opened

_SETTLE_S = 4.0
_OBEY_S = 0.3
_TICKS_PER_S = os.sysconf("SC_CLK_TCK")
_PAGE_BYTES = os.sysconf("SC_PAGE_SIZE")


@dataclass(frozen=True, slots=True, kw_only=True)
class Figures:
    """What was measured.

    Attributes:
        p50_ms: half of all wake-ups of the bench were later than that.
        p99_ms: one in a hundred was.
        factor: bench time in host time.
        slips: how often bench time stood still because the host was too late.
        bench_cpu: share of one core that the bench took.
        screen_cpu: the same of the dashboard; 0 without.
        drawn_per_s: bytes that the dashboard wrote to its terminal in a second.
        stolen: share of the host's processors that its hypervisor gave to others meanwhile; 0 where none says so.
    """

    p50_ms: float
    p99_ms: float
    factor: float
    slips: int
    bench_cpu: float
    screen_cpu: float
    drawn_per_s: float
    stolen: float


def measure(span_s: float, frames_per_s: int) -> Figures:
    """Run a bench for a span of host time, with a dashboard unless it draws nothing in a second."""
    with _bench() as process, contextlib.ExitStack() as stack:
        pid, screen = 0, -1
        if frames_per_s:
            pid, screen = stack.enter_context(opened(process.session.name, frames_per_s))
        _read_for(_SETTLE_S, screen)
        for asked in ("pause", "resume"):  # what goes on begins to measure its lateness anew
            process.send(asked)
            _read_for(_OBEY_S, screen)
        bench_pid = int(process.about["pid"])
        before = (_cpu_s(bench_pid), _cpu_s(pid), _stolen_s())
        watch = Stopwatch()
        drawn = _read_for(span_s, screen)
        took_s = watch.elapsed_s()
        after = (_cpu_s(bench_pid), _cpu_s(pid), _stolen_s())
        pace = _pace(process.journal)
    return Figures(
        p50_ms=pace["p50_ns"] / 1e6,
        p99_ms=pace["p99_ns"] / 1e6,
        factor=pace["factor"],
        slips=pace["slips"],
        bench_cpu=(after[0] - before[0]) / took_s,
        screen_cpu=(after[1] - before[1]) / took_s,
        drawn_per_s=drawn / took_s,
        stolen=(after[2] - before[2]) / took_s / (os.cpu_count() or 1),
    )


@contextlib.contextmanager
def _bench() -> Iterator[BenchProcess]:
    with tempfile.TemporaryDirectory() as home:
        os.environ["XDG_RUNTIME_DIR"] = home
        session = new_session("full")
        words = [sys.executable, "-m", "measure.dashboard_load", "bench", str(session.folder)]
        child = subprocess.Popen(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, start_new_session=True)
        process = BenchProcess(session, child)
        while process.phase is Phase.STARTING:
            process.poll()
            select.select((), (), (), 0.05)
        if process.phase is Phase.ENDED:
            raise SystemExit(process.cause)
        try:
            yield process
        finally:
            process.stop()


def _read_for(span_s: float, screen: int) -> int:
    """Read from a screen as a terminal does, for a span of host time; return how much it was."""
    watch, read = Stopwatch(), 0
    while (left_s := span_s - watch.elapsed_s()) > 0:
        if select.select([screen] if screen >= 0 else (), (), (), left_s)[0]:
            read += len(os.read(screen, 1 << 16))
    return read


def _pace(journal: Path) -> dict[str, Any]:
    follower = Follower(journal)
    found: dict[str, Any] = {}
    while events := follower.news():
        found = next((dict(event) for event in reversed(events) if event["kind"] == "host-pace"), found)
    follower.close()
    return found


def _cpu_s(pid: int) -> float:
    """Return the processor time that a process has taken; 0 of none."""
    if not pid:
        return 0.0
    fields = Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / _TICKS_PER_S


def _stolen_s() -> float:
    """Return the time of all processors that a hypervisor has given to others (proc(5), /proc/stat, "steal")."""
    return int(Path("/proc/stat").read_text(encoding="utf-8").split(maxsplit=9)[8]) / _TICKS_PER_S


def resident_mb(pid: int | str = "self") -> float:
    """Return the memory that a process has, in MB."""
    return int(Path(f"/proc/{pid}/statm").read_text(encoding="utf-8").split()[1]) * _PAGE_BYTES / 1e6
