"""The dashboard by mouse and by its command palette: what a key does, they do, and nothing does nothing unsaid."""

from __future__ import annotations

import pytest

from hilbench.tui.bench_process import Phase
from hilbench.tui.model.rows import rows_of
from hilbench.tui.recorded import RecordedBench
from tests.share import few

BENCHES = [("pioneer", "a robot")]
OF_VEHICLES = ("mode", "press", "stack", "simulator", "lamps", "restart", "reset")


def said(app):
    return [note.message for note in app._notifications]


async def close_all(app, pilot):
    while len(app.screen_stack) > 1:
        app.pop_screen()
        await pilot.pause()


def test_a_key_of_the_footer_can_be_clicked(process_of, on_screen):
    process = process_of("pioneer")

    async def click(app, pilot, key):
        (shown,) = [one for one in app.query("FooterKey") if one.key_display == key]
        await pilot.click(shown)
        await pilot.pause()

    async def scenario(app, pilot):
        for key in ("wasd", "space", "p"):
            await click(app, pilot, key)
        assert process.sent == [("drive", {"forward": 0.5, "turn": 0.0}), ("stop", {}), ("pause", {})]
        for key, screen in (("i", "InjectScreen"), ("?", "HelpScreen"), ("q", "LeaveScreen")):
            await click(app, pilot, key)
            assert type(app.screen).__name__ == screen
            await close_all(app, pilot)

    on_screen(process, scenario)


def test_the_footer_is_put_together_anew_only_where_other_keys_are_offered(process_of, on_screen):
    async def scenario(app, pilot):
        shown = list(app.query("FooterKey"))
        await pilot.press("question_mark", "escape")
        assert list(app.query("FooterKey")) == shown
        app.query_one("#frames").focus()
        await pilot.pause()
        assert {key.description for key in app.query("FooterKey")} - {key.description for key in shown} == {
            "Bytes", "Hold", "Fold",
        }  # fmt: skip

    on_screen(process_of("pioneer"), scenario, (200, 60))


def test_a_fault_is_put_in_by_mouse(process_of, on_screen):
    process = process_of("vehicle")

    async def scenario(app, pilot):
        await pilot.press("i")
        await pilot.pause()
        await pilot.click("#kind")
        await pilot.pause()
        overlay = app.screen.query_one("#kind SelectOverlay")
        await pilot.click(overlay, offset=(4, 2))
        await pilot.pause()
        await pilot.click("#put")
        await pilot.pause()
        asked = {"kind": "drop", "towards": "target", "line": "simulator", "probability": 0.05, "count": 3}
        assert process.sent == [("inject", asked)]

    on_screen(process, scenario)


def test_a_click_beside_a_form_closes_it_and_asks_for_nothing(process_of, on_screen):
    process = process_of("pioneer")
    process.about = {"file": "pioneer-plane", "suites": ["p2os-server"]}

    async def scenario(app, pilot):
        for key in ("i", "P", "t", "question_mark", "q"):
            await pilot.press(key)
            await pilot.pause()
            (dialog,) = app.screen.query(".dialog")
            assert len(app.screen_stack) == 2, key
            await pilot.click(dialog, offset=(2, 1))
            assert len(app.screen_stack) == 2, key
            await pilot.click(offset=(100, 0))
            await pilot.pause()
            assert len(app.screen_stack) == 1, key
        assert process.sent == []

    on_screen(process, scenario, size=(132, 40), benches=BENCHES)


def test_a_frame_is_pointed_at_opened_and_left_by_mouse(process_of, on_screen):
    async def scenario(app, pilot):
        frames = app.query_one("#frames")
        bottom = frames.content_size.height
        await pilot.click(frames, offset=(9, bottom - 1))
        await pilot.pause()
        first = frames.chosen
        drawn = rows_of(frames.held)
        assert (first, frames.opened) == (drawn[-2].number, False)
        await pilot.click(frames, offset=(10, bottom - 1))  # the row is where it was
        await pilot.pause()
        assert (frames.chosen, frames.opened) == (first, True)
        await pilot.press("escape")
        frames.post_message(scroll_up(frames))
        await pilot.pause()
        assert frames.chosen == drawn[-5].number
        await pilot.click(frames, offset=(0, 3))  # its border
        await pilot.pause()
        assert frames.chosen == drawn[-5].number

    on_screen(process_of("pioneer"), scenario)


def scroll_up(widget):
    from textual.events import MouseScrollUp

    return MouseScrollUp(widget, 3, 3, 0, -1, 0, False, False, False)


def test_a_clause_is_pointed_at_and_opened_by_mouse(process_of, journal_file, on_screen):
    cases = [{"ns": number, "kind": "case", "source": "journal", "case": f"suite/c{number}"} for number in range(1, 9)]
    process = process_of("pioneer")
    process.journal = journal_file(cases)

    async def scenario(app, pilot):
        await pilot.press("0")
        await pilot.pause()
        checks = app.query_one("#checks")
        await pilot.click(checks, offset=(9, 4))
        await pilot.pause()
        assert (checks.chosen, checks.opened) == ("suite/c3", False)
        await pilot.click(checks, offset=(10, 4))
        await pilot.pause()
        assert (checks.chosen, checks.opened) == ("suite/c3", True)

    on_screen(process, scenario)


def test_a_border_that_is_held_is_let_go_when_a_form_comes(process_of, on_screen):
    async def scenario(app, pilot):
        before = app.arrangement
        await pilot.mouse_down("#world", offset=(30, app.query_one("#world").outer_size.height - 1))
        assert app.mouse_captured is not None
        await pilot.press("question_mark")
        await pilot.mouse_up(offset=(30, 5))
        await pilot.press("escape")
        await pilot.hover(offset=(30, 3))
        await pilot.pause()
        assert app.arrangement == before

    on_screen(process_of("pioneer"), scenario)


def test_the_wheel_goes_through_a_recording(replay_of, on_screen, tmp_path):
    replay = replay_of("rover")

    async def scenario(app, pilot):
        replay.go_to(3_000_000_000)
        line = app.query_one("#timeline")
        line.post_message(scroll_up(line))
        await pilot.pause()
        assert replay.now_ns == 2_000_000_000

    on_screen(RecordedBench(tmp_path), scenario, replay=replay)


def state_of(app, process):
    """Return what an action may change, but for what it says."""
    frames = app.query_one("#frames")
    plots = app.query_one("#plots")
    replay = app.replay
    told = None if replay is None else (replay.now_ns, replay.model.taken, replay.playing)
    sent = list(getattr(process, "sent", ()))
    return sent, type(app.screen), app.theme, app.zoomed, frames.pattern, plots.span_s, told


@pytest.mark.parametrize("kind", few(["vehicle", "replay", "beginning"], 1, "the same commands on other screens"))
def test_each_command_of_the_palette_does_something_or_says_why_not(
    process_of, replay_of, on_screen, kind, tmp_path, monkeypatch
):
    from hilbench.tui.keys import BY_NAME, NEEDS
    from hilbench.tui.panes import PANES

    # One pane for all: `test_app` gives each of them the screen.
    left_out = ("Dashboard: leave", *(f"View: {pane.title} alone" for name, pane in PANES.items() if name != "link"))
    monkeypatch.chdir(tmp_path)
    process = process_of("vehicle" if kind == "vehicle" else "rover")
    replay = None
    if kind == "vehicle":
        process.actions = (*process.actions, *OF_VEHICLES)
    elif kind == "beginning":
        process.phase, process.journal = Phase.STARTING, tmp_path / "none"
    elif kind == "replay":
        process, replay = RecordedBench(tmp_path), replay_of("rover")

    async def scenario(app, pilot):
        offered = [one for one in app.get_system_commands(app.screen) if not one.title.startswith(left_out)]
        assert {"View: choose a theme  (T)", "Dashboard: explain this screen  (?)"} <= {one.title for one in offered}
        for command in offered:
            app.zoomed = "log" if command.title.startswith("View: all panes") else ""
            if replay is not None:
                replay.go_to(replay.length_ns // 2)
            app.look()
            app.clear_notifications()
            before = state_of(app, process)
            command.callback()
            await pilot.pause()
            assert state_of(app, process) != before or said(app), command.title
            await close_all(app, pilot)
        asked = {name for name, _ in getattr(process, "sent", ())}
        can = {NEEDS[action] for action, _ in BY_NAME.values() if action in NEEDS and app.check_action(action, ())}
        can |= {key.do for number, key in enumerate(app.keys) if app.check_action("ask", (number,))}
        assert can - {"inject", "mark", "send", "stimulate"} <= asked  # these ask first

    on_screen(process, scenario, replay=replay, benches=BENCHES)


def test_a_key_that_does_nothing_here_says_why(process_of, replay_of, on_screen, tmp_path):
    process = process_of("pioneer")

    async def scenario(app, pilot):
        await pilot.press("r", "r", "home")
        assert said(app) == ["this bench has no 'reset'", "only a recording can be gone through"]
        process.phase = Phase.ENDED
        await pilot.press("w")
        assert said(app)[2:] == ["the bench has ended"]
        assert process.sent == []

    on_screen(process, scenario)

    async def recorded(app, pilot):
        await pilot.press("space")
        assert said(app) == ["a recording obeys nobody"]

    on_screen(RecordedBench(tmp_path), recorded, replay=replay_of("rover"))


def test_brackets_in_what_somebody_wrote_are_brackets(process_of, on_screen, rows):
    process = process_of("pioneer")
    process.refusals = ["mark: [/b] is [no mark"]

    async def scenario(app, pilot):
        app.query_one("#frames").filter("[/b] [red")
        app.look()
        assert said(app) == ["mark: [/b] is [no mark"]
        await pilot.press("b")
        await pilot.pause()
        screen = "\n".join(rows(app))
        assert "my [/b] bench" in screen
        assert app.query_one("#frames")._border_subtitle.plain == "filter: [/b] [red"

    benches = [(f"bench-{number}", "my [/b] bench") for number in range(3)]
    on_screen(process, scenario, benches=benches)
