"""A whole session by keys alone, on a bench that runs: drive, noise on the line, see it counted, read bytes, check."""

from __future__ import annotations

import asyncio
import select

import pytest

from hilbench.tui.app import Dashboard
from hilbench.tui.bench_process import BenchProcess
from hilbench.tui.panes import FramesPane

REJECTED = ("noise", "bad_syncs", "bad_crcs", "bad_lengths", "bad_terminators")


class Session:
    """A dashboard, and the keys that are pressed there; what is waited for is looked for again and again."""

    def __init__(self, app, pilot):
        self.app, self.press, self._pause = app, pilot.press, pilot.pause

    async def until(self, condition):
        """Look until something is so; the pause is for the bench's sake."""
        while self.app.model is None or not condition(self.app.model):
            assert not self.app.process.cause, self.app.process.cause
            select.select((), (), (), 0.1)
            self.app.look()
            await self._pause()

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


@pytest.mark.parametrize(
    "bench", ["rover-model", pytest.param("rover", marks=pytest.mark.exhaustive("takes too long"))]
)
def test_a_session_by_keys(bench, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    process = BenchProcess.start([bench], name=bench)

    async def play(session):
        press, until, app = session.press, session.until, session.app
        await until(lambda model: model.machines["station"].state == "LINKED")
        await press("w")
        await until(lambda model: model.driver.who == "user" and model.driver.forward == 0.5)
        await until(lambda model: model.driver.who == "dead man")

        before = rejected(app.model)
        await press("i")
        await press("tab", "tab", "backspace", "3", "0", "ctrl+s")
        await until(lambda model: model.faults["noise towards target"] > 0)
        await until(lambda model: rejected(model) > before)
        await press("u")

        await press("slash", *"> request", "enter")
        await press("5", "up", "enter")
        await session.seen("[50 4B 54 21][01][00]")
        assert app.query_one(FramesPane).opened
        await press("escape", "escape", "escape")

        await press("t", "shift+tab", *"P02D", "enter", "enter")
        await session.seen("all checks passed")
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
