"""An hour of bench time, as fast as it goes, with a dashboard that looks at it; what memory both have taken."""

from __future__ import annotations

import asyncio
import sys
import tempfile
from pathlib import Path

from hilbench.live import session
from hilbench.live.folders import Session
from hilbench.mcu.command_line import open_target
from hilbench.testing import FakeHostClock
from hilbench.tui.app import Dashboard
from hilbench.tui.recorded import RecordedBench
from measure.dashboard_load.measure import resident_mb
from measure.dashboard_load.rig import open_saturated

_LOOK_EVERY_S = 1.0
_TELL_EVERY_S = 300.0
_SIZE = (200, 60)


def watch_memory(bench: str, bench_time_s: float) -> None:
    """Run a bench and a dashboard in this process, and print what memory they have."""
    if bench == "full":
        session.open_rig = open_saturated
        bench = "rover-model"
    with tempfile.TemporaryDirectory() as folder:
        asyncio.run(_watch(bench, bench_time_s, Path(folder)))


async def _watch(bench: str, bench_time_s: float, folder: Path) -> None:
    live = session.LiveBench(open_target(bench), session.LiveOptions(session=Session(folder)))
    live.bench.scheduler.lock(FakeHostClock())
    dashboard = Dashboard(RecordedBench(folder / "journal.jsonl", None), ticking=False)
    told_s = 0.0
    async with dashboard.run_test(size=_SIZE) as pilot:
        while live.bench.now_s < bench_time_s:
            live.bench.run_for(_LOOK_EVERY_S)
            dashboard.look()
            await pilot.pause()
            if live.bench.now_s >= told_s:
                told_s += _TELL_EVERY_S
                sys.stdout.write(f"{live.bench.now_s:8.0f} s {resident_mb():8.1f} MB\n")
                sys.stdout.flush()
    live.close()
