"""Lines that are drawn only where they have changed."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.text import Span, Text

from hilbench.recordings.piecewise import Pieces
from hilbench.tui.model.replay import NS_PER_S, Replay
from hilbench.tui.recorded import RecordedBench

STYLES = ("", "bold", "dim", "red", "bold reverse", "cyan")


@st.composite
def texts(draw):
    text = Text(draw(st.text(alphabet="ab ⣿█", max_size=12)), draw(st.sampled_from(STYLES)))
    for start, length, style in draw(
        st.lists(st.tuples(st.integers(0, 12), st.integers(0, 12), st.sampled_from(STYLES)), max_size=4)
    ):
        if start < len(text):
            text.spans.append(Span(start, min(len(text), start + length), style))
    return text


@given(texts())
def test_each_cell_has_the_styles_that_lie_over_it(text):
    from hilbench.tui.lines import pieces

    found = [(letter, styles) for piece, styles in pieces(text) for letter in piece]
    ground = (text.style,) if text.style else ()
    wanted = []
    for at, letter in enumerate(text.plain):
        over = (span.style for span in text.spans if span.start <= at < span.end and span.style)
        wanted.append((letter, (*ground, *over)))
    assert found == wanted


@pytest.fixture
def playing(on_screen, recordings, tmp_path):
    """Play a scenario over a recording, at 3 s of it."""

    def play(bench, scenario):
        replay = Replay(Pieces(*recordings[bench]))
        replay.work()
        replay.go_to(3 * NS_PER_S)
        on_screen(RecordedBench(tmp_path, None), scenario, (200, 60), replay=replay)

    return play


@pytest.mark.parametrize("bench", ["pioneer", "vehicle"])
def test_what_is_drawn_bit_by_bit_is_what_is_drawn_at_once(playing, rows, settle, bench):
    async def scenario(app, pilot):
        for _ in range(8):
            app.replay.go_by(NS_PER_S // 20)
            app.look()
            await pilot.pause()
        step_by_step = rows(app)
        app.screen.refresh(layout=True)
        for pane in app.query("Pane"):
            pane.refresh()
        await settle(app, pilot)
        assert rows(app) == step_by_step

    playing(bench, scenario)


def test_what_has_not_changed_is_not_drawn(playing, settle):
    async def scenario(app, pilot):
        await settle(app, pilot)
        log = app.query_one("#log")
        app.model.taken += 1  # as if an event had come that tells the log nothing
        app.look()
        assert not log._repaint_regions
        for _ in range(2):  # the second time it is counted in the line that is there
            await settle(app, pilot)
            app.model.log.say(app.model.ns, "test", "something else")
            app.model.taken += 1
            app.look()
        (region,) = log._repaint_regions
        assert region.height == 1

    playing("vehicle", scenario)


def test_without_news_nobody_looks(playing, settle, monkeypatch):
    async def scenario(app, pilot):
        await settle(app, pilot)
        monkeypatch.setattr("hilbench.tui.panes.Pane.look", lambda _self: pytest.fail("a pane was asked"))
        app.look()

    playing("pioneer", scenario)
