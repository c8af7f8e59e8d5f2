"""Panes by keys and mouse: larger, smaller, elsewhere, hidden, remembered; plots, themes and what is exported."""

from __future__ import annotations

import csv
import json
from pathlib import Path

from hilbench.tui.memory import Memory
from hilbench.tui.model.frames import KEPT_FRAMES
from hilbench.tui.views.help import help_text
from tests.each import each

WIDE = (200, 60)
ACTIONS = ("connect", "demo", "drive", "inject", "pause", "step", "stop")


def width_of(app, name):
    return app.query_one(f"#{name}").region.width


def test_a_pane_is_resized_by_keys_and_stays_so(process_of, on_screen, tmp_path):
    path = tmp_path / "dashboard.json"
    seen = {}

    async def scenario(app, pilot):
        app.query_one("#timers").focus()
        wide, high = width_of(app, "timers"), app.query_one("#timers").region.height
        await pilot.press("]", "]", "}")
        await pilot.pause()
        seen["box"] = app.query_one("#timers").region
        assert (seen["box"].width, seen["box"].height) == (wide + 4, high + 1)
        await pilot.press("[", "{")
        await pilot.pause()
        assert (width_of(app, "timers"), app.query_one("#timers").region.height) == (wide + 2, high)
        await pilot.press("]", "}")

    async def again(app, pilot):
        assert app.query_one("#timers").region == seen["box"]

    on_screen(process_of("pioneer"), scenario, WIDE, memory=Memory(path))
    on_screen(process_of("pioneer"), again, WIDE, memory=Memory(path))


@each(("edge", "to", "grows"), [((-1, 3), (5, 3), (6, 0)), ((9, -1), (9, 2), (0, 3))])
def test_a_border_is_dragged(process_of, on_screen, edge, to, grows):
    async def scenario(app, pilot):
        before = app.query_one("#link").region

        def at(place):
            x = before.right + place[0] if edge[0] < 0 else before.x + place[0]
            y = before.bottom + place[1] if edge[1] < 0 else before.y + place[1]
            return x, y

        await pilot.mouse_down(offset=at(edge))
        await pilot.hover(offset=at(to))
        await pilot.mouse_up(offset=at(to))
        await pilot.pause()
        after = app.query_one("#link").region
        assert (after.width - before.width, after.height - before.height) == grows
        await pilot.hover(offset=(3, 3))
        assert app.query_one("#link").region == after

    on_screen(process_of("pioneer"), scenario, WIDE)


def test_panes_are_hidden_and_moved_by_name(process_of, on_screen):
    async def scenario(app, pilot):
        body = app.query_one("Body")
        await pilot.press("P", "enter", "down", "right")
        await pilot.pause()
        assert "link" not in body.shown
        assert "timers" in app.arrangement.columns[1].names
        await pilot.press("r", "escape")
        await pilot.pause()
        assert "link" in body.shown
        assert "timers" in app.arrangement.columns[0].names

    on_screen(process_of("pioneer"), scenario, WIDE)


def test_where_there_is_little_room_the_next_pane_takes_the_place_of_a_hidden_one(process_of, on_screen):
    async def scenario(app, pilot):
        assert list(app.query_one("Body").shown) == ["world", "frames", "plots"]
        await pilot.press("P", "space", "escape")
        await pilot.pause()
        assert list(app.query_one("Body").shown) == ["frames", "plots", "link"]

    on_screen(process_of("pioneer"), scenario)


def test_a_file_that_is_damaged_is_a_line_in_the_log(process_of, on_screen, rows, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "state").write_text("{")

    async def scenario(app, pilot):
        await pilot.press("8")
        await pilot.pause()
        assert sum("is damaged; the panes are" in row for row in rows(app)) == 1

    on_screen(process_of("pioneer"), scenario, (160, 30), memory=Memory(Path("state")))


def test_a_theme_is_seen_while_it_is_pointed_at_and_its_colours_are_those_of_all_views(process_of, on_screen):
    from hilbench.tui.theme import terminal_theme  # not to be imported where tests are collected

    memory = Memory()

    async def scenario(app, pilot):
        await pilot.press("T", "down")
        await pilot.pause()
        assert app.theme == "textual-light"
        letters = app.ansi_theme.foreground_color
        assert letters == terminal_theme(app.current_theme).foreground_color
        await pilot.press("escape")
        await pilot.pause()
        assert memory.theme == app.theme == "textual-dark"
        assert app.ansi_theme.foreground_color != letters
        await pilot.press("T", "down", "enter")
        await pilot.pause()
        assert memory.theme == app.theme == "textual-light"

    on_screen(process_of("pioneer"), scenario, memory=memory)


def test_signals_are_chosen_and_seen_over_another_time(process_of, on_screen, rows):
    memory = Memory()

    async def scenario(app, pilot):
        plots = app.query_one("#plots")
        usual = list(plots.plotted)
        await pilot.press("L", "enter", "escape", "greater_than_sign", "9")
        await pilot.pause()
        first = next(iter(app.model.signals.signals))
        assert set(plots.plotted) == set(usual) ^ {first}
        assert plots.span_s == 60
        assert memory.signals("robot") == (plots.plotted, 60)
        await pilot.press(*["less_than_sign"] * 9)
        assert plots.span_s == 2
        assert "─ 2 s ─" in "".join(rows(app))

    on_screen(process_of("pioneer"), scenario, memory=memory)


# --- export


def test_what_is_selected_is_exported(process_of, on_screen, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)

    async def export(app, pilot, number):
        await pilot.press("X", *["down"] * number, "enter")
        await pilot.pause()

    async def scenario(app, pilot):
        await pilot.press("slash", *"> pulse", "enter")
        for number in (0, 1, 2):
            await export(app, pilot, number)
        await pilot.press("5", "up", "escape")
        frames = app.query_one("#frames")
        assert len(frames.selected()) == len(app.model.frames.matching("> pulse", KEPT_FRAMES))
        for number in (3, 6):
            await export(app, pilot, number)

    on_screen(process_of("pioneer"), scenario)
    (table,) = (csv.DictReader((tmp_path / "hilbench-pioneer-plane-8000ms-frames.csv").read_text().splitlines()),)
    found = list(table)
    listed = json.loads((tmp_path / "hilbench-pioneer-plane-8000ms-frames.json").read_text())
    lines = (tmp_path / "hilbench-pioneer-plane-8000ms-frames.hex").read_text().splitlines()
    assert {row["name"] for row in found} == {"PULSE"}
    assert [row["bytes"] for row in listed] == [row["bytes"] for row in found]
    assert lines == ["> fafb03000000"] * len(found)
    counters = (tmp_path / "hilbench-pioneer-plane-8000ms-counters.csv").read_text()
    assert counters.startswith("source,counter,value,per_s\nclient,bytes_in,")
    points = json.loads((tmp_path / "hilbench-pioneer-plane-8000ms-plot.json").read_text())
    assert {"speed", "battery"} <= {point["signal"] for point in points}
    assert [point["time_s"] for point in points] == sorted(point["time_s"] for point in points)


def test_a_folder_that_cannot_be_written_is_said(process_of, on_screen, tmp_path, monkeypatch):
    folder = tmp_path / "gone"
    folder.mkdir()
    monkeypatch.chdir(folder)
    folder.rmdir()
    monkeypatch.setattr("hilbench.tui.saving.Path.cwd", lambda: folder)

    async def scenario(app, pilot):
        await pilot.press("X", "enter")
        await pilot.pause()
        await pilot.pause()
        assert "No such file" in list(app._notifications)[-1].message  # a row holds a part of it, as the path is long

    on_screen(process_of("pioneer"), scenario)


# --- help and the palette


TEACHES = {
    "pioneer": "SYNC2 open the session, then the robot sends a SIP",
    "rover": "A rover that hears nobody stops",
    "vehicle": "press the joystick's switch",
}


@each("bench", TEACHES)
def test_help_tells_of_this_bench(model_of, bench):
    text = " ".join(help_text(model_of(bench), (*ACTIONS, "press"), [], recorded=False).split())
    assert TEACHES[bench] in text
    assert "[b]Try[/b]" in text


def test_help_tells_of_the_panes_that_have_something_to_show(process_of, on_screen):
    from hilbench.tui.panes import PANES

    async def scenario(app, pilot):
        await pilot.press("question_mark")
        shown = str(app.screen.query_one("#help Static").render())
        assert "What you see" in shown
        assert TEACHES["pioneer"] in " ".join(shown.split())
        for pane in app.available():
            assert PANES[pane].title in shown

    on_screen(process_of("pioneer"), scenario, (132, 40))


def test_the_palette_has_every_action_that_a_key_has(process_of, on_screen):
    from textual.binding import Binding

    from hilbench.tui.keys import BY_NAME, KEYS

    bound = {one.action.partition("(")[0] for one in KEYS if isinstance(one, Binding)}
    named = {name for name, _ in BY_NAME.values()}
    assert bound - named == {"resize"}

    async def scenario(app, pilot):
        offered = {command.title: command for command in app.get_system_commands(app.screen)}
        assert {
            "Line: put a fault on it  (i)",
            "Save: mark this moment  (m)",
            "View: Plots alone  (9)",
        } <= offered.keys()
        assert not [title for title in offered if title.startswith("Recording: ")]
        assert all(command.help for command in offered.values())
        offered["View: Plots alone  (9)"].callback()
        assert app.zoomed == "plots"

    on_screen(process_of("pioneer"), scenario)


def test_the_recording_so_far_is_kept_and_can_be_replayed(process_of, on_screen, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    process = process_of("rover")

    async def scenario(app, pilot):
        await pilot.press("R")
        await pilot.pause()

    on_screen(process, scenario)
    (kept,) = tmp_path.glob("hilbench-rover-model-*-journal.jsonl")
    assert kept.read_bytes() == process.journal.read_bytes()
