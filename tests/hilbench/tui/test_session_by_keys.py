"""A whole session by keys alone, on a bench that runs: drive, noise on the line, see it counted, read bytes, check."""

from __future__ import annotations

import asyncio
import inspect
import select
from itertools import count

import pytest

from hilbench.tui import bench_process
from hilbench.tui.bench_process import BenchProcess
from hilbench.tui.model.follower import Follower

EMULATED = pytest.mark.exhaustive("the session on the model of the rover, with firmware")
MOST_LOOKS = 15_000
"""Only against hanging: some five minutes."""

REJECTED = ("noise", "bad_syncs", "bad_crcs", "bad_lengths", "bad_terminators")


class Session:
    """A dashboard, and the keys that are pressed there; what is waited for is looked for again and again.

    What does not last is looked for in the journal: a slow host's dashboard may never have shown it.
    """

    def __init__(self, app, pilot):
        self.app, self.press, self._pause = app, pilot.press, pilot.pause
        self._journal, self._events = Follower(app.process.journal), []

    async def until(self, condition):
        """Look until something is so; the pause is for the bench's sake."""
        looks = count()
        while self.app.model is None or not condition(self.app.model):
            assert next(looks) < MOST_LOOKS, f"{inspect.getsource(condition)}\n{self.screen()}"
            assert not self.app.process.cause, self.app.process.cause
            select.select((), (), (), 0.02)
            self.app.look()
            await self._pause()

    async def told(self, **fields):
        """Look until the journal has an event behind the one that was waited for before."""

        def is_there(_model):
            self._events += self._journal.news()
            while self._events:
                event = self._events.pop(0)
                if all(event.get(name) == value for name, value in fields.items()):
                    return True
            return False

        await self.until(is_there)

    async def seen(self, text):
        """Look until a text is on the screen."""
        await self.until(lambda _model: text in self.screen())

    def screen(self):
        strips = self.app.screen._compositor.render_strips()
        return "\n".join("".join(segment.text for segment in strip) for strip in strips)


def rejected(model):
    """Return how much both ends have refused; an end that nobody sees into tells of it in its reports."""
    counted = [one.counters for one in model.machines.values()]
    reports = [frame.item.fields["rejected"] for frame in model.frames.matching("< GeneralReport", 1)]
    return sum(counters[name].value for counters in counted for name in REJECTED) + sum(reports)


@pytest.mark.slow("what a person does in a whole session, with a suite in processes of its own")
@pytest.mark.real_time("a bench runs in a process of its own")
@pytest.mark.parametrize("bench", ["rover-model", pytest.param("rover", marks=EMULATED)])
def test_a_session_by_keys(bench, tmp_path, monkeypatch, all_done):
    from hilbench.tui.app import Dashboard

    monkeypatch.setattr(bench_process, "_PATIENCE_S", 600.0)
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    process = BenchProcess.start([bench], name=bench)

    async def play(session):
        press, until, app = session.press, session.until, session.app
        await until(lambda model: model.machines["station"].state == "LINKED")
        await press("w")
        await session.told(kind="driver", who="user", forward=0.5)
        await session.told(kind="driver", who="dead man")

        before = rejected(app.model)
        await press("i")
        await press("tab", "tab", "backspace", "3", "0", "ctrl+s")
        await until(lambda model: model.faults["noise towards target"] > 0)
        await until(lambda model: rejected(model) > before)
        await press("u")

        await press("slash", *"> request", "enter")
        await until(lambda model: model.frames.matching("> request", 1))
        await press("5", "up", "enter")
        await session.seen("[50 4B 54 21][01][00]")
        assert app.query_one("#frames").opened
        await press("escape", "escape", "escape")

        await press("t", "tab", *"P02D", "enter")
        await until(lambda _model: app.run_of_suite.code is not None)
        assert "all checks passed" in session.screen()
        await press("down", "enter")
        await session.seen("LED_ON")
        assert {row.state for row in app.run_of_suite.checks.rows.values()} == {"pass"}
        await press("escape", "escape")

        await press("g")
        (saved,) = tmp_path.glob(f"hilbench-{bench}-*.svg")
        assert "<svg" in saved.read_text()
        await press("q", "s")

    async def go():
        app = Dashboard(process, ticking=False)
        async with app.run_test(size=(132, 40)) as pilot:
            await play(Session(app, pilot))
            await pilot.pause()

    asyncio.run(go())
    assert not process.session.folder.exists()
