from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hilbench.tui.model.replay import Replay
from hilbench.tui.recorded import RecordedBench
from hilbench.tui.views.timeline import time_at, timeline_view

S = 1_000_000_000


def told(model):
    """Return what a model knows, as far as it can be compared."""
    machines = {name: (one.state, dict(one.visits), one.timers) for name, one in model.machines.items()}
    return machines, model.world.pose, model.frames.count, len(model.log.lines), model.paused


def test_a_place_is_what_had_been_told_by_then(recordings, model_of):
    replay = Replay(*recordings["pioneer"])
    assert replay.length_ns == 8 * S
    for at_s in (8.0, 0.3, 5.1, 0.0, 2.0):
        replay.go_to(round(at_s * S))
        assert told(replay.model) == told(model_of("pioneer", at_s))


@given(moves=st.lists(st.integers(-30, 60), max_size=8))
def test_steps_go_to_and_fro(moves):
    events = [{"ns": ns, "kind": "fault", "source": "line", "fault": "noise", "towards": str(ns)} for ns in range(100)]
    replay, at = Replay({}, events), 100
    for move in moves:
        at = max(0, min(100, at + move))
        replay.step(move)
        assert len(replay.model.log.lines) == at


def test_errors_are_found_one_after_the_other(recordings):
    replay = Replay(*recordings["pioneer"])
    replay.go_to(0)
    found = []
    while replay.to_error(1):
        found.append(replay.model.log.errors)
    assert found == list(range(1, len(found) + 1))
    assert found


def test_it_plays_to_its_end_and_stops(recordings):
    replay = Replay(*recordings["pioneer"])
    replay.go_to(6 * S)
    replay.play(1.0)
    assert replay.model.ns <= 6 * S
    replay.playing = True
    replay.play(1.0)
    assert 6.9 * S < replay.model.ns <= 7 * S
    replay.play(5.0)
    assert (replay.playing, replay.model.ns) == (False, 8 * S)


def test_a_recording_of_nothing_is_shown():
    replay = Replay({}, [])
    replay.go_to(5)
    replay.step(1)
    assert not replay.to_error(1)
    assert replay.model.ns == 0


def test_keys_move_in_a_recording_and_ask_nobody(recordings, journals, on_screen, rows):
    replay = Replay(*recordings["pioneer"])

    async def scenario(app, pilot):
        await pilot.press("home")
        assert app.model.ns == 0
        await pilot.press("right", "right", "left", "full_stop")
        assert 1 * S <= app.model.ns < 1.2 * S
        await pilot.press("e")
        assert app.model.log.errors == 1
        await pilot.press("e", "E")
        assert app.model.log.errors == 1
        await pilot.press("p")
        assert replay.playing
        await pilot.press("p", "end")
        assert (replay.playing, app.model.ns) == (False, 8 * S)
        await pilot.pause()
        assert "8.000 s of 8.000 s  recorded" in rows(app)[0]
        assert "cut in line 7" in rows(app)[1]
        assert "b opens" not in rows(app)[1] + rows(app)[2]
        await pilot.press("t", "w", "b")
        assert len(app.screen_stack) == 1

    on_screen(RecordedBench(journals["pioneer"], "cut in line 7"), scenario, (200, 60), replay=replay)


def test_a_click_on_the_line_of_time_goes_there(recordings, journals, on_screen, rows):
    replay = Replay(*recordings["pioneer"])

    async def scenario(app, pilot):
        line = rows(app)[-2]
        assert {"!", "m"} <= set(line)
        mark = line.index("m")
        await pilot.click("#timeline", offset=(mark, 0))
        assert abs(app.model.ns - 6 * S) < 0.2 * S
        await pilot.click("#timeline", offset=(0, 0))
        assert app.model.ns == 0
        assert "●" in rows(app)[-2]

    on_screen(RecordedBench(journals["pioneer"], None), scenario, replay=replay)


@given(st.integers(0, 10**12), st.integers(30, 200), st.floats(0, 1))
def test_what_is_clicked_is_what_is_shown(length_ns, width, share):
    now_ns = round(length_ns * share)
    shown = timeline_view(length_ns, now_ns, [], width).plain
    assert abs(time_at(shown.index("●"), length_ns, width) - now_ns) <= length_ns / (width - 27) + 1
