"""``python -m measure.dashboard_pictures [NAME ...]``: draws the pictures of the dashboard in ``docs/images``.

Each is the screen of a live bench after a session that is always the same: bench time is virtual, the seed is 0.
"""

from __future__ import annotations

import asyncio
import select
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

from hilbench.commands.live import in_scene
from hilbench.exit_codes import ExitCode
from hilbench.live.folders import Session
from hilbench.live.scenes import scene_for
from hilbench.live.session import LiveBench, LiveOptions
from hilbench.mcu.command_line import open_target
from hilbench.testing import FakeHostClock
from hilbench.tui.app import Dashboard
from hilbench.tui.bench_process import Phase
from hilbench.tui.check_run import CheckRun
from hilbench.tui.recorded import RecordedBench
from hilbench.tui.svg import in_cells

IMAGES = Path(__file__).parents[1] / "docs" / "images"
Asked = Mapping[str, Any]


class Picture(NamedTuple):
    """A session and how it is drawn.

    Attributes:
        bench: which.
        scene: where it stands; None for that which the dashboard takes.
        asked: what is asked of it, and after how many seconds each.
        until_s: when it is drawn.
        size: columns and rows.
        suite: a suite, and which of its clauses, that has run meanwhile; None for none.
    """

    bench: str
    scene: str | None
    asked: tuple[tuple[float, Asked], ...]
    until_s: float
    size: tuple[int, int]
    suite: tuple[str, str] | None = None


PICTURES: Mapping[str, Picture] = {
    "dashboard": Picture(
        "pioneer",
        "room-with-boxes",
        (
            (26.0, {"do": "inject", "kind": "noise", "probability": 0.1, "count": 2}),
            (26.4, {"do": "inject", "kind": "flip", "probability": 0.003, "towards": "operator"}),
        ),
        28.7,
        (150, 46),
    ),
    "dashboard-rover": Picture(
        "rover",
        None,
        (
            (7.0, {"do": "inject", "kind": "noise", "probability": 0.05, "count": 2}),
            (9.0, {"do": "clear-faults"}),
            (9.2, {"do": "drive", "forward": 0.5, "turn": 0.2}),
            (9.7, {"do": "drive", "forward": 0.5, "turn": 0.2}),
        ),
        11.8,
        (150, 46),
        ("pkt-board", "P02 or P03 or P05 or P06"),
    ),
    "dashboard-vehicle": Picture(
        "vehicle",
        None,
        (
            (9.0, {"do": "drive", "forward": 0.5, "turn": 0.0}),
            (9.5, {"do": "drive", "forward": 0.5, "turn": 0.0}),
            (13.2, {"do": "demo"}),
            (17.2, {"do": "lamps", "which": "left"}),
            (17.5, {"do": "simulator", "on": False}),
        ),
        18.1,
        (180, 54),
    ),
}


FAILED = "failed-case"
_PANEL = """
from __future__ import annotations

from hilbench.check import Violation, case
from protocols.p2os import CommandNumber


@case("OUR02", text="The robot stands a second after the last packet.", level="must", source="our panel, rev. C",
      scene="room-with-boxes")
def test_stops_within_a_second(peer):
    peer.start()
    peer.send(CommandNumber.ENABLE, 1)
    peer.run(0.2)
    peer.send(CommandNumber.VEL, 300)
    peer.send(CommandNumber.RVEL, 20)
    peer.run_alive(3.0)
    peer.run(1.2)
    if peer.sips()[-1].moving:
        raise Violation("it still moves 1.2 s after the last packet", peer.evidence())
"""
"""A robot that drives on for two seconds is asked to stand after one."""


class _Shown(RecordedBench):
    """A bench that stands still while it is drawn."""

    def __init__(self, journal: Path, actions: tuple[str, ...]) -> None:
        super().__init__(journal)
        self.actions = actions


def recorded(picture: Picture, folder: Path) -> _Shown:
    """Let a session take place."""
    bench_file = open_target(picture.bench)
    bench_file = in_scene(bench_file, picture.scene or scene_for(bench_file))
    journal = folder / "journal.jsonl"
    live = LiveBench(bench_file, LiveOptions(session=Session(folder), journal=journal))
    live.bench.scheduler.lock(FakeHostClock())
    for at_s, asked in (*picture.asked, (picture.until_s, None)):
        live.bench.run_for(at_s - live.bench.now_ns / 1e9)
        if asked is not None:
            live.actions.obey(asked)
    actions = live.actions.names
    live.close()
    return _Shown(journal, actions)


async def drawn(picture: Picture, bench: _Shown) -> str:
    """Return the screen."""
    app = Dashboard(bench, ticking=False)
    async with app.run_test(size=picture.size) as pilot:
        while app.model is None or not app.model.ended:
            app.look()
        if picture.suite is not None:
            app.run_of_suite = run = CheckRun(picture.bench, *picture.suite)
            while run.code is None:
                select.select((), (), (), 0.2)
                app.look()
        for _ in range(3):  # the panes get their sizes, and then show what there is room for
            app.look()
            await pilot.pause()
        assert bench.phase is Phase.LIVE
        return in_cells(app.export_screenshot(title=f"hilbench {app.model.name}"))


def failed(folder: Path) -> str:
    """Return the screen of a case that fails, as `hilbench check --screens` draws it."""
    suite = folder / "our_panel.py"
    suite.write_text(_PANEL)
    command = [sys.executable, "-m", "hilbench", "check", "pioneer", "--suite", str(suite), "--screens", str(folder)]
    assert subprocess.run(command, check=False).returncode == ExitCode.VIOLATION
    (screen,) = folder.glob("*.svg")
    return screen.read_text()


def main() -> None:
    """Draw."""
    for name in sys.argv[1:] or (*PICTURES, FAILED):
        with tempfile.TemporaryDirectory() as folder:
            if name == FAILED:
                picture = failed(Path(folder))
            else:
                picture = asyncio.run(drawn(PICTURES[name], recorded(PICTURES[name], Path(folder))))
            (IMAGES / f"{name}.svg").write_text(picture)


if __name__ == "__main__":
    main()
