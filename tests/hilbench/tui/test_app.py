"""The dashboard by its keys, over recordings."""

from __future__ import annotations

import json
import math
import select

import pytest

from hilbench.tui.bench_process import Phase
from hilbench.tui.model.bench import BenchModel
from tests.each import each
from tests.share import matrix

SIZES = {"80x24": (80, 24), "200x60": (200, 60)}


@pytest.mark.parametrize(("bench", "size"), matrix(["pioneer", "rover", "vehicle", "agent"], [*SIZES]))
def test_the_whole_screen_looks_as_it_did(process_of, expect, bench, size, on_screen, rows):
    async def scenario(app, pilot):
        expect(f"screen-{bench}-{size}", rows(app))

    on_screen(process_of(bench), scenario, SIZES[size])


def test_a_wider_terminal_has_more_keys_at_once(process_of, on_screen, rows):
    from hilbench.tui.key_line import KeyLine

    async def scenario(app, pilot):
        assert "Export" not in rows(app)[-1]
        await pilot.resize_terminal(200, 24)
        while app.query_one(KeyLine).size.width != 200:  # Textual lays out at its own pace
            await pilot.pause()
        await pilot.pause()
        assert "Export" in rows(app)[-1]

    on_screen(process_of("pioneer"), scenario)


def test_each_pane_can_have_the_screen(process_of, on_screen):
    from hilbench.tui.panes import PANES

    async def scenario(app, pilot):
        for name, pane in PANES.items():
            await pilot.press(pane.key)
            await pilot.pause()
            assert [pane.id for pane in app.query("Pane") if pane.display] == [name]
            assert app.focused is not None
            assert app.focused.id == name
        await pilot.press("escape")
        await pilot.pause()
        assert app.zoomed == ""

    on_screen(process_of("pioneer"), scenario)


ASKED_BY_KEYS = {
    "w": ("drive", {"forward": 0.5, "turn": 0.0}),
    "space": ("stop", {}),
    "D": ("drive", {"forward": 0.0, "turn": -1.0}),
    "o": ("demo", {}),
    "c": ("connect", {}),
    "x": ("disconnect", {}),
    "p": ("pause", {}),
    "n": ("step", {"seconds": 0.1}),
    "plus": ("speed", {"factor": 2.0}),
    "minus": ("speed", {"factor": 0.5}),
    "u": ("clear-faults", {}),
}


def test_keys_ask_the_bench(process_of, on_screen):
    process = process_of("pioneer")

    async def scenario(app, pilot):
        for key in ASKED_BY_KEYS:
            await pilot.press(key)
        assert process.sent == list(ASKED_BY_KEYS.values())

    on_screen(process, scenario)


def test_what_the_bench_cannot_is_not_asked_for(process_of, on_screen):
    process = process_of("pioneer")

    async def scenario(app, pilot):
        await pilot.press("r")
        process.phase = Phase.ENDED
        await pilot.press("w")
        assert process.sent == []

    on_screen(process, scenario)


def test_a_fault_is_put_in_by_keys(process_of, on_screen):
    process = process_of("pioneer")

    async def scenario(app, pilot):
        await pilot.press("i")
        await pilot.press("ctrl+s")
        await pilot.pause()
        assert process.sent == [
            ("inject", {"kind": "noise", "towards": "target", "probability": 0.05, "count": 3}),
        ]
        await pilot.press("i", "escape")
        await pilot.pause()
        assert len(process.sent) == 1

    on_screen(process, scenario)


def test_a_moment_is_marked_with_a_word(process_of, on_screen):
    process = process_of("pioneer")

    async def scenario(app, pilot):
        await pilot.press("m", *"here", "enter")
        await pilot.pause()
        assert process.sent == [("mark", {"text": "here"})]

    on_screen(process, scenario)


def test_a_board_is_given_a_stimulus(process_of, on_screen):
    process = process_of("pioneer")

    async def scenario(app, pilot):
        await pilot.press("I", *"PA0=1", "enter")
        await pilot.press("I", "escape")
        await pilot.pause()
        assert process.sent == [("stimulate", {"text": "PA0=1"})]

    on_screen(process, scenario)


def test_a_frame_is_found_held_and_opened(process_of, on_screen, rows, settle):
    async def scenario(app, pilot):
        await pilot.press("slash", *"pulse", "enter")
        await pilot.press("5", "F", "up", "enter")
        await settle(app, pilot)
        screen = "\n".join(rows(app))
        assert "[FA FB][03][00][00 00]" in screen
        assert "Sip" not in screen
        frames = app.query_one("#frames")
        held = frames.held
        await pilot.press("up", "up")
        assert frames.held is held
        assert frames.chosen == held[-4].number
        await pilot.press("F")
        await settle(app, pilot)
        assert frames.border_subtitle == "filter: pulse, held"
        assert f"x{len(held)}" in "\n".join(rows(app))  # the one that is pointed at is among them
        await pilot.press("escape", "escape")
        await pilot.pause()
        assert (frames.opened, frames.held, app.zoomed) == (False, None, "frames")
        await pilot.press("escape")
        await pilot.pause()
        assert app.zoomed == ""

    on_screen(process_of("pioneer"), scenario)


@each(("key", "sent"), [("s", [("stopped", {})]), ("d", [("left", {})])])
def test_leaving_asks_stop_or_detach(process_of, key, sent, on_screen):
    process = process_of("pioneer")

    async def scenario(app, pilot):
        await pilot.press("q", "escape")
        await pilot.pause()
        assert app.is_running
        await pilot.press("q", key)
        await pilot.pause()
        assert process.sent == sent

    on_screen(process, scenario)


def test_a_bench_that_ends_leaves_the_screen_and_says_why(process_of, expect, on_screen, rows):
    process = process_of("pioneer")

    async def scenario(app, pilot):
        process.phase, process.cause = Phase.ENDED, "the bench was killed by SIGKILL"
        app.look()
        await pilot.pause()
        screen = rows(app)
        assert "the bench was killed by SIGKILL. Journal:" in screen[1]
        assert any("Sip" in row for row in screen)
        await pilot.press("q")
        await pilot.pause()
        assert process.sent == [("stopped", {})]  # it clears up what is left

    on_screen(process, scenario)


def test_another_bench_is_opened(process_of, on_screen):
    first, second = process_of("pioneer"), process_of("rover")
    opened = []

    def open_bench(name):
        opened.append(name)
        return second

    async def scenario(app, pilot):
        await pilot.press("b", "down", "enter")
        await pilot.pause()
        app.look()
        assert first.sent == [("stopped", {})]
        assert opened == ["rover-model"]
        assert app.model.name == "rover-model"

    on_screen(first, scenario, benches=[("pioneer", "a robot"), ("rover-model", "a rover")], open_bench=open_bench)


@pytest.mark.exhaustive("test_session_by_keys runs a suite and reads a verdict; here is one of somebody's own")
def test_a_suite_is_run_and_its_verdicts_are_read(process_of, tmp_path, on_screen, rows):
    suite = tmp_path / "test_mine.py"
    suite.write_text(
        'from hilbench.check import case\n\n@case("A1", text="It does A1.", source="us")\ndef test_a(): pass\n'
    )
    process = process_of("pioneer")
    process.about = {"file": "pioneer-plane", "suites": [str(suite)]}

    async def scenario(app, pilot):
        await pilot.press("t", "down", "enter")
        await pilot.pause()
        run = app.run_of_suite
        while run.code is None:
            select.select((), (), (), 0.02)
            app.look()
        await pilot.pause()
        screen = "\n".join(rows(app))
        assert "all checks passed  1 pass" in screen
        await pilot.press("down", "enter")
        await pilot.pause()
        assert "It does A1." in "\n".join(rows(app))
        assert process.sent == [("mark", {"text": f"suite {suite}"})]

    on_screen(process, scenario, SIZES["200x60"])


def test_a_bench_without_suites_runs_none(process_of, on_screen):
    async def scenario(app, pilot):
        await pilot.press("t")
        await pilot.pause()
        assert len(app.screen_stack) == 1

    on_screen(process_of("pioneer"), scenario)


def test_the_screen_is_saved(process_of, tmp_path, monkeypatch, on_screen):
    monkeypatch.chdir(tmp_path)

    async def scenario(app, pilot):
        await pilot.press("g")
        await pilot.pause()

    on_screen(process_of("pioneer"), scenario)
    (saved,) = tmp_path.glob("hilbench-pioneer-plane-*.svg")
    assert "<svg" in saved.read_text()


def test_a_refusal_is_shown(process_of, on_screen, rows):
    process = process_of("pioneer")

    async def scenario(app, pilot):
        process.refusals = ["inject: no fault 'ghost'"]
        app.look()
        await pilot.pause()
        await pilot.pause()
        assert any("no fault 'ghost'" in row for row in rows(app))

    on_screen(process, scenario)


def test_nothing_but_the_text_is_needed(process_of, monkeypatch, on_new_screen):
    monkeypatch.setenv("NO_COLOR", "1")

    async def scenario(app, pilot):
        shown = [
            segment.style.color.triplet
            for strip in app.screen._compositor.render_strips()
            for segment in strip
            if segment.style is not None and segment.style.color is not None
        ]
        assert shown
        assert all(colour is None or colour.red == colour.green == colour.blue for colour in shown)

    on_new_screen(process_of("pioneer"), scenario)


def test_a_dashboard_that_is_too_slow_passes_over_what_is_old_and_says_so(process_of, on_screen, tmp_path, monkeypatch):
    from hilbench.tui import watching

    process = process_of("rover")
    data = process.journal.read_bytes()
    process.journal = tmp_path / "grows.jsonl"
    process.journal.write_bytes(data)
    monkeypatch.setattr(watching, "_MUCH_BYTES", 1000)

    async def scenario(app, pilot):
        app._follower.news()
        app._most_s = -1  # no time to read anything
        for _ in range(watching._LOSING_LOOKS):
            assert app.passed_over == 0
            with process.journal.open("ab") as journal:
                journal.write(data[data.index(b"\n") + 1 :])
            app.look()
        assert app.passed_over > 0
        app._most_s = math.inf
        app.model = BenchModel(app._follower.header)
        app.look()
        assert f"{app.passed_over / 1e6:.1f} MB passed over" in app._headline()
        app.open(process_of("pioneer"))
        app.look()
        assert "passed over" not in app._headline()

    on_screen(process, scenario)


def test_a_port_that_goes_is_shown_as_down_and_one_that_came_back_as_up_again(
    process_of, on_screen, rows, journal_file, settle
):
    def link(ns, up):
        counters = {"sent": ns, "received": ns, "lost": 0}
        about = {"port": "/dev/ttyACM0", "up": up, "baud": 115_200, "pending": 0}
        return {"ns": ns * 10**9, "kind": "link", "source": "host", **about, **counters}

    process = process_of("rover")
    process.journal = journal_file([link(1, True), link(2, False)])

    async def scenario(app, pilot):
        assert "DOWN" in "\n".join(rows(app))
        with process.journal.open("a") as journal:
            journal.write(json.dumps(link(5, True)) + "\n")
        await settle(app, pilot)
        seen = "\n".join(rows(app))
        assert "DOWN" not in seen
        assert "went down 1 times" in seen

    on_screen(process, scenario, (200, 60))
