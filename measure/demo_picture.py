"""``python -m measure.demo_picture [SYSTEM]``: plays a demo and draws it as a moving picture, ``docs/images/demo.svg``.

It is the demo of `hilbench demo`, on a wall clock that never waits: the benches run in this process, so the picture is
always the same. Each scene is drawn at its end. Where a picture cannot move, the verdict is shown.
"""

from __future__ import annotations

import asyncio
import re
import select
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import hilbench.tui.demo
from hilbench.commands.live import in_scene
from hilbench.exit_codes import ExitCode
from hilbench.live.folders import Session
from hilbench.live.scenes import scene_for
from hilbench.live.session import LiveBench as RunningBench
from hilbench.live.session import LiveOptions
from hilbench.mcu.command_line import open_target
from hilbench.plugins.demo import Demo, LiveBench, Scene
from hilbench.plugins.discovery import PLUGINS
from hilbench.strict.changes import parse_change
from hilbench.terminal.options import DEFAULT_DEMO
from hilbench.testing import FakeHostClock
from hilbench.tui.bench_process import Phase
from hilbench.tui.demo import DemoDashboard
from hilbench.tui.svg import in_cells

PICTURE = Path(__file__).parents[1] / "docs" / "images" / "demo.svg"
SIZE = (100, 30)
LOOK_S = 0.1
SHOWN_S = 4.0
"""How long each scene is seen in the picture."""


class OwnTime:
    """The clock on the wall of a demo that is played here."""

    def __init__(self) -> None:
        self.now_s = 0.0

    def elapsed_s(self) -> float:
        """Return the time."""
        return self.now_s


class BenchHere:
    """A bench in this process, in the place of a process of its own: it runs as far as the clock on the wall is."""

    cause, ended_well, detached = "", True, False

    def __init__(self, bench: LiveBench, wall: OwnTime) -> None:
        self.phase = Phase.LIVE
        self._wall = wall
        self._begin_s = wall.now_s
        self._folder = tempfile.TemporaryDirectory(prefix="hilbench-demo-")
        changes = [parse_change(text) for text in bench.changes]
        bench_file = open_target(bench.bench, changes=changes)
        bench_file = in_scene(bench_file, scene_for(bench_file))
        self.journal = Path(self._folder.name) / "journal.jsonl"
        self._live = RunningBench(
            bench_file, LiveOptions(session=Session(Path(self._folder.name)), journal=self.journal)
        )
        self._live.bench.scheduler.lock(FakeHostClock())
        self.about = {"bench": bench_file.name}
        self.actions = self._live.actions.names

    def poll(self) -> list[str]:
        """Let the bench catch up; one that is paused stands still for so long."""
        by_s, self._begin_s = self._wall.now_s - self._begin_s, self._wall.now_s
        if not self._live.actions.paused and by_s > 0:
            self._live.bench.run_for(by_s)
        return []

    def send(self, do: str, **more: object) -> None:
        """See `BenchProcess`."""
        self._live.actions.obey({"do": do, **more})
        self._live.bench.record("clock", "bench", paused=self._live.actions.paused, speed=self._live.actions.speed)
        self._live.bench.journal.flush_step()

    def stop(self) -> None:
        """See `BenchProcess`."""
        if self.phase is Phase.LIVE:
            self.phase = Phase.ENDED
            self._live.close()
            self._folder.cleanup()


def script_of(system: str, *, physics: bool = True) -> Demo:
    """Return the demo of a system."""
    return PLUGINS.systems.demos(physics=physics)[system]


class Filmed(DemoDashboard):
    """A demo whose screen is kept at the end of each scene."""

    CSS_PATH = Path(hilbench.tui.demo.__file__).with_name("dashboard.tcss")

    def __init__(self, *words: Any, **more: Any) -> None:
        super().__init__(*words, **more)
        self.screens: list[str] = []

    def begin(self, scene: Scene) -> None:
        """Keep the scene before."""
        if self.playing.number:
            self._film()
        super().begin(scene)

    def leave(self, code: ExitCode) -> None:
        """Keep the last scene."""
        self._film()
        super().leave(code)

    def _film(self) -> None:
        self.screens.append(in_cells(self.export_screenshot(title="hilbench demo")))


async def played(demo: Demo, size: tuple[int, int] = SIZE) -> Filmed:
    """Play a demo; return its dashboard at the end."""
    wall = OwnTime()
    app = Filmed(demo, BenchHere(demo.opening, wall), lambda bench: BenchHere(bench, wall), ticking=False)
    app.stopwatch = wall  # type: ignore[assignment]
    async with app.run_test(size=size) as pilot:
        while app.return_code is None:
            while app.run_of_suite is not None and app.run_of_suite.code is None:
                select.select((), (), (), 0.05)
                app.run_of_suite.poll()
            wall.now_s += LOOK_S
            app.look()
            await pilot.pause()
    return app


_CLIP = re.compile(
    r"\s*<clipPath id=\"[^\"]*-line-\d+\">.*?</clipPath>| clip-path=\"url\(#[^\"]*-line-\d+\)\"", re.DOTALL
)
_FONT = re.compile(r"\s*@font-face \{.*?\n    \}", re.DOTALL)
_CELL = re.compile(
    r'<rect fill="(#\w+)" x="([\d.]+)" y="([\d.]+)" width="([\d.]+)" height="([\d.]+)" shape-rendering="crispEdges"/>'
)
_CELLS = re.compile(rf"(?:{_CELL.pattern.replace('(', '(?:')})+")


def lean(screen: str, name: str) -> str:
    """Return a screen in fewer words: without clips that clip nothing, and equal cells side by side as one."""
    screen = _FONT.sub("", _CLIP.sub("", screen)) if name != "s0" else _CLIP.sub("", screen)
    return _CELLS.sub(_merged, re.sub(r"terminal-\d+", name, screen))


def _merged(cells: re.Match[str]) -> str:
    runs: list[list[str]] = []
    for fill, x, y, width, height in _CELL.findall(cells[0]):
        if runs and runs[-1][0] == fill and runs[-1][2] == y:
            runs[-1][3] = f"{float(x) + float(width) - float(runs[-1][1]):g}"
        else:
            runs.append([fill, x, y, width, height])
    return "".join(
        f'<rect fill="{fill}" x="{x}" y="{y}" width="{width}" height="{height}" shape-rendering="crispEdges"/>'
        for fill, x, y, width, height in runs
    )


def moving(screens: Sequence[str], still: int) -> str:
    """Return screens as one picture that shows them by turns; where it cannot move, one of them stands still."""
    head = re.match(r"<svg[^>]*>", screens[0])
    assert head is not None
    share = 100 / len(screens)
    rules = [f"@keyframes turn{{0%{{visibility:visible}}{share:.3f}%,100%{{visibility:hidden}}}}"]
    rules.append(f".scene{{visibility:hidden;animation:turn {SHOWN_S * len(screens):g}s step-end infinite}}")
    rules.append(f"#scene{still}{{visibility:visible}}")
    rules += [
        f"#scene{number}{{animation-delay:{SHOWN_S * (number - len(screens)):g}s}}" for number in range(len(screens))
    ]
    rules.append("@media (prefers-reduced-motion: reduce){.scene{animation:none}}")
    scenes = [
        f'<g class="scene" id="scene{number}">{screen[screen.index(">") + 1 : screen.rindex("</svg>")]}</g>'
        for number, screen in enumerate(lean(one, f"s{number}") for number, one in enumerate(screens))
    ]
    return f"{head[0]}<style>{''.join(rules)}</style>{''.join(scenes)}</svg>"


def main() -> None:
    """Play, and draw."""
    app = asyncio.run(played(script_of((sys.argv[1:] or [DEFAULT_DEMO])[0])))
    assert app.return_code == 0, app.playing.broken
    scenes = app.playing.demo.scenes
    still = next(number for number, scene in enumerate(scenes) if scene.check is not None) + 1
    PICTURE.write_text(moving(app.screens, still))


if __name__ == "__main__":
    main()
