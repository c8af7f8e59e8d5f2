"""A whole session by keys alone, on a bench that runs: drive, noise on the line, see it counted, read bytes, save."""

from __future__ import annotations

import asyncio
import select

import pytest

from hilbench.tui.app import Dashboard
from hilbench.tui.bench_process import BenchProcess
from hilbench.tui.panes import FramesPane

pytestmark = pytest.mark.slow


def test_a_session_by_keys(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    process = BenchProcess.start(["rover-model"], name="rover-model")

    async def go():
        app = Dashboard(process, ticking=False)
        async with app.run_test(size=(200, 60)) as pilot:

            async def until(condition):
                """Look again and again; the pause is for the bench's sake."""
                while app.model is None or not condition(app.model):
                    assert not process.cause, process.cause
                    select.select((), (), (), 0.02)
                    app.look()
                    await pilot.pause()

            def errors(model):
                counters = model.machines["rover"].counters
                return counters["noise"].value + counters["bad_syncs"].value + counters["bad_crcs"].value

            await until(lambda model: model.machines["station"].state == "LINKED")
            await pilot.press("w")
            await until(lambda model: model.driver.who == "user" and model.driver.forward == 0.5)
            await until(lambda model: model.driver.who == "dead man")

            await pilot.press("i")
            await pilot.press("tab", "tab", "backspace", "3", "0", "ctrl+s")
            await until(lambda model: model.faults["noise towards target"] > 0)
            await until(lambda model: errors(model) > 0)
            await pilot.press("u")

            await pilot.press("slash", *"> request", "enter")
            await pilot.press("5", "up", "enter")
            await pilot.pause()
            frames = app.query_one(FramesPane)
            assert frames.opened
            shown = "\n".join(line.plain for line in frames.lines(app.model, 100, 40))
            assert "[50 4B 54 21][01][00]" in shown

            await pilot.press("g")
            assert list(tmp_path.glob("hilbench-rover-model-*.svg"))
            await pilot.press("q", "s")
            await pilot.pause()

    asyncio.run(go())
    assert not process.session.folder.exists()
