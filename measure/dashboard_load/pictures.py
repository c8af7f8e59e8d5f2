"""What a picture of a full line costs in processor time: the same feed each time, and nobody who is waited for."""

from __future__ import annotations

import asyncio
import contextlib
import cProfile
import io
import pstats
import tempfile
import time
from pathlib import Path

from textual.drivers.headless_driver import HeadlessDriver

from hilbench.clock import NS_PER_S
from hilbench.live import session
from hilbench.live.folders import Session
from hilbench.mcu.command_line import open_target
from hilbench.testing import FakeHostClock
from hilbench.tui.app import Dashboard
from hilbench.tui.recorded import RecordedBench
from measure.dashboard_load.rig import open_saturated

_SIZE = (200, 60)
_SETTLE_S = 3.0
_SHOWN = 45
_TURNS = 20
"""Of the event loop: more than the messages of a picture need."""


class _Sink(HeadlessDriver):
    """A terminal that takes everything: what it is sent is made, as for a real one, and counted."""

    drawn = 0

    @property
    def is_headless(self) -> bool:
        return False

    def write(self, data: str) -> None:
        self.drawn += len(data.encode())


def _drawn(journal: Path) -> tuple[Dashboard, list[_Sink]]:
    """Make a dashboard that draws into a sink."""
    dashboard = Dashboard(RecordedBench(journal, None), ticking=False)

    def build(*_args: object, **_more: object) -> _Sink:
        sinks.append(_Sink(dashboard, size=_SIZE))
        dashboard._driver = sinks[-1]
        return sinks[-1]

    sinks: list[_Sink] = []
    dashboard._build_driver = build
    return dashboard, sinks


def record(bench: str, folder: Path, span_s: float, frames_per_s: int) -> tuple[Path, list[int]]:
    """Record a bench as it is told live; return its journal, and how long that was when each picture was due."""
    path, sizes = folder / "told.jsonl", []
    before = session.open_rig
    if bench == "full":
        session.open_rig = open_saturated
    try:
        name = "rover-model" if bench == "full" else bench
        live = session.LiveBench(open_target(name), session.LiveOptions(session=Session(folder), journal=path))
    finally:
        session.open_rig = before
    every_ns = NS_PER_S // frames_per_s

    def note() -> None:
        sizes.append(path.stat().st_size)
        live.bench.scheduler.after(every_ns, note, source="~pictures")

    live.bench.scheduler.lock(FakeHostClock())
    note()
    live.bench.run_for(span_s)
    live.close()
    return path, sizes


async def draw(path: Path, sizes: list[int], settle: int, profile: cProfile.Profile | None) -> tuple[float, int]:
    """Draw a picture of each part of a journal; return processor time in s and bytes drawn, but for the first few."""
    data = path.read_bytes()
    growing = path.with_name("growing.jsonl")
    dashboard, sinks = _drawn(growing)
    took_s, drawn, end = 0.0, 0, 0
    async with dashboard.run_test(size=_SIZE) as pilot:
        await pilot.pause()
        with growing.open("wb", buffering=0) as file:
            for number, size in enumerate(sizes):
                file.write(data[end:size])
                end, before = size, sinks[-1].drawn
                with profile if profile is not None and number >= settle else contextlib.nullcontext():
                    began_s = time.process_time()
                    await _picture(dashboard)
                    ended_s = time.process_time()
                if number >= settle:
                    took_s += ended_s - began_s
                    drawn += sinks[-1].drawn - before
    return took_s, drawn


async def _picture(dashboard: Dashboard) -> None:
    """Look, and draw what that has changed, without the wait for the next tick of Textual's."""
    dashboard.look()
    for act in (lambda: None, dashboard.screen._on_timer_update):
        act()
        for _ in range(_TURNS):
            await asyncio.sleep(0)


def cost(bench: str, span_s: float, frames_per_s: int, *, profiled: bool = False) -> str:
    """Return what a picture of a bench costs, in words."""
    profile = cProfile.Profile() if profiled else None
    with tempfile.TemporaryDirectory() as folder:
        path, sizes = record(bench, Path(folder), _SETTLE_S + span_s, frames_per_s)
        settle = round(_SETTLE_S * frames_per_s)
        took_s, drawn = asyncio.run(draw(path, sizes, settle, profile))
    pictures = len(sizes) - settle
    told = io.StringIO()
    if profile is not None:
        pstats.Stats(profile, stream=told).sort_stats("tottime").print_stats(_SHOWN)
    return (
        f"{bench}: {pictures} pictures, {1000 * took_s / pictures:.2f} ms of processor each, "
        f"{took_s / pictures * frames_per_s:.1%} of one at {frames_per_s} a second; {drawn / pictures:.0f} B each"
        f"{told.getvalue()}"
    )
