from __future__ import annotations

import asyncio
import contextlib
import contextvars
import json
import os
import sys
from pathlib import Path

import pytest

from hilbench.live.folders import Session
from hilbench.live.session import LiveBench, LiveOptions
from hilbench.mcu.command_line import open_target
from hilbench.recordings.piecewise import Pieces
from hilbench.testing import FakeHostClock
from hilbench.tui.bench_process import Phase
from hilbench.tui.memory import Memory
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.follower import Follower
from hilbench.tui.model.replay import Replay

EXPECTED = Path(__file__).parent / "expected"
WRITE = bool(os.environ.get("HILBENCH_WRITE_SCREENS"))
A_DAY_S = 86_400
IN_NO_HURRY = """
import os, signal, sys
import hilbench.tui.bench_process
from hilbench.__main__ import main
hilbench.tui.bench_process._PATIENCE_S = 600
os.nice = lambda by: open("nice", "w").write(str(by))
alarm = signal.alarm
signal.alarm = lambda seconds: alarm(60 * seconds)
sys.exit(main())
"""
"""Who draws gives way to others; it and its bench end in some seconds: beside others' work that is next to nothing."""
ACTIONS = (
    "connect", "demo", "disconnect", "drive", "clear-faults", "inject", "mark", "pause", "quit", "resume", "speed",
    "send", "step", "stimulate", "stop",
)  # fmt: skip


def record(folder, bench, seconds):
    """Run a live bench on a clock that never waits, with a fault, a mark and somebody at the stick."""
    path = folder / f"{bench}.jsonl"
    live = LiveBench(open_target(bench), LiveOptions(session=Session(folder), journal=path))
    live.bench.scheduler.lock(FakeHostClock())
    live.bench.run_for(seconds / 2)
    live.actions.obey({"do": "inject", "kind": "noise", "probability": 0.05, "count": 3})
    live.bench.run_for(seconds / 4)
    live.actions.obey({"do": "clear-faults"})
    live.actions.obey({"do": "mark", "text": "three quarters"})
    if "drive" in live.actions.names:
        live.actions.obey({"do": "drive", "forward": 0.5, "turn": -0.2})
    live.bench.run_for(seconds / 4)
    live.close()
    return path


@pytest.fixture(scope="session")
def journals(tmp_path_factory):
    folder = tmp_path_factory.mktemp("journals")
    return {
        "pioneer": record(folder, "pioneer-plane", 8.0),
        "rover": record(folder, "rover-model", 6.0),
        "vehicle": record(folder, "vehicle-model", 6.0),
        "agent": record(folder, "xrce-agent", 6.0),
    }


def read(path):
    follower = Follower(path)
    events = []
    while batch := follower.news():
        events += batch
    follower.close()
    return follower.header, events


@pytest.fixture(scope="session")
def recordings(journals):
    return {name: read(path) for name, path in journals.items()}


@pytest.fixture
def model_of(recordings):
    """Make the model of a recording, whole or up to a bench time."""

    def make(name, until_s=None):
        header, events = recordings[name]
        model = BenchModel(header)
        model.take(event for event in events if until_s is None or event["ns"] <= until_s * 1e9)
        return model

    return make


@pytest.fixture
def expect():
    """Compare a screen with the one that is stored; HILBENCH_WRITE_SCREENS=1 stores it anew."""

    def compare(name, lines):
        text = "\n".join(line.rstrip() for line in lines) + "\n"
        path = EXPECTED / f"{name}.txt"
        if WRITE:
            path.parent.mkdir(exist_ok=True)
            path.write_text(text)
        assert text == path.read_text()

    return compare


class FakeProcess:
    """A bench that is a recording; takes down what it is asked for."""

    def __init__(self, journal):
        self.journal = journal
        self.phase = Phase.LIVE
        self.cause = ""
        self.ended_well = False
        self.about = {}
        self.actions = ACTIONS
        self.sent = []
        self.refusals = []

    def poll(self):
        refusals, self.refusals = self.refusals, []
        return refusals

    def send(self, do, **more):
        self.sent.append((do, more))

    def stop(self):
        self.sent.append(("stopped", {}))

    def leave(self):
        self.sent.append(("left", {}))


@pytest.fixture
def process_of(journals):
    return lambda name: FakeProcess(journals[name])


@pytest.fixture
def replay_of(recordings):
    return lambda name: Replay(Pieces(*recordings[name]))


@pytest.fixture
def journal_file(tmp_path):
    """Write a journal of events of one's own."""

    def write(events, **live):
        path = tmp_path / "own.jsonl"
        header = {"kind": "journal", "part": 0, "bench": "own", "live": live}
        path.write_text("".join(json.dumps(line) + "\n" for line in (header, *events)))
        return path

    return write


def rows(app):
    """Return what is on the screen, row by row."""
    return ["".join(segment.text for segment in strip) for strip in app.screen._compositor.render_strips()]


class Stopped:
    """A stopwatch that stands still: how long a scene takes on this host changes nothing in it."""

    def __init__(self):
        self.stood_s = 0

    def elapsed_s(self):
        return self.stood_s


class Stage:
    """One dashboard for many scenes: beginning one takes longer than most scenes do."""

    def __init__(self):
        self._loop = asyncio.new_event_loop()
        self._context = contextvars.copy_context()
        self._app = self._running = self._pilot = None

    def play(self, process, scenario, size=(80, 24), *, replay=None, benches=(), open_bench=None, **of_person):
        """Open a bench or a recording on the dashboard, and let a scenario play with it.

        Of the person there may be a `memory` of the last time, and `pads`.
        """
        from hilbench.tui.app import Dashboard
        from hilbench.tui.pad_hand import PadHand

        async def scene():
            if self._app is None or not self._app.is_running:
                await self._end()
                self._app = Dashboard(process, replay, ticking=False)
                self._app.stopwatch = Stopped()
                self._app.NOTIFICATION_TIMEOUT = A_DAY_S
                self._running = self._app.run_test(size=size, notifications=True)
                self._pilot = await self._running.__aenter__()
            app = self._app
            while len(app.screen_stack) > 1:
                app.pop_screen()
            app.clear_notifications()
            app.stopwatch.stood_s += A_DAY_S
            app._memory = of_person.get("memory") or Memory()
            app._pad = PadHand(of_person.get("pads"))
            app._plots_of, app.theme = "", "textual-dark"
            app._benches, app._open_bench = list(benches), open_bench
            app.open(process, replay)
            app.set_focus(None)
            if app.size != size:
                await self._pilot.resize_terminal(*size)
            await settle(app, self._pilot)
            await scenario(app, self._pilot)

        with waiting_for_all():
            self._wait_for(scene())

    def close(self):
        self._wait_for(self._end())
        self._loop.close()

    async def _end(self):
        if self._running is not None:
            await self._running.__aexit__(None, None, None)
        self._running = None

    def _wait_for(self, coroutine):
        self._loop.run_until_complete(self._loop.create_task(coroutine, context=self._context))


async def all_is_done(*_limits):
    """Wait until nothing is left to be done: no message is on its way, and the screen is drawn.

    It stands for Textual's `wait_for_idle`, which judges that by what the process has had of the processor.
    """
    from textual._context import active_app

    app, loop = active_app.get(), asyncio.get_running_loop()
    while True:
        await asyncio.sleep(0)
        while loop._ready:
            await asyncio.sleep(0)
        if not app.screen._update_timer._active.is_set():
            return
        app.screen._on_timer_update()


@contextlib.contextmanager
def waiting_for_all():
    """Have a pilot wait for `all_is_done`, which draws, and no timer."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("textual.screen.UPDATE_PERIOD", A_DAY_S)
        patch.setattr("textual.app.wait_for_idle", all_is_done)
        patch.setattr("textual.pilot.wait_for_idle", all_is_done)
        yield


async def settle(app, pilot):
    """Look, and wait until that is drawn, and no pane is laid out that is not to be seen."""
    from hilbench.tui.panes import Pane

    placed = displayed = None
    while placed is None or not placed <= displayed:
        await pilot.pause()
        app.look()
        await pilot.pause()
        placed = {widget.id for widget in app.screen._compositor.visible_widgets if isinstance(widget, Pane)}
        displayed = {pane.id for pane in app.query(Pane) if pane.display}


@pytest.fixture(scope="session")
def _stage():
    stage = Stage()
    yield stage
    stage.close()


@pytest.fixture
def on_new_screen():
    """As `on_screen`, with a dashboard that begins now: what its environment says counts."""
    stage = Stage()
    yield stage.play
    stage.close()


@pytest.fixture
def on_screen(_stage):
    """Play a scenario with a dashboard over a recording."""
    return _stage.play


@pytest.fixture
def all_done():
    """A dashboard of one's own waits as the one of `on_screen` does."""
    with waiting_for_all():
        yield


@pytest.fixture
def command():
    """The words that begin `hilbench` as a process of its own, which may take its time."""
    return [sys.executable, "-c", IN_NO_HURRY]


@pytest.fixture(name="rows")
def _rows():
    return rows


@pytest.fixture(name="settle")
def _settle():
    return settle
