from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.recordings.piecewise import Pieces, open_pieces
from hilbench.tui.model import replay as replay_module
from hilbench.tui.model.replay import Replay
from hilbench.tui.recorded import RecordedBench
from hilbench.tui.views.timeline import time_at, timeline_view

S = 1_000_000_000


def fault(ns):
    return {"ns": ns, "kind": "fault", "source": "line", "fault": "noise", "towards": str(ns)}


def at_end(header, events):
    """Return a replay of all that there is, which has read it."""
    replay = Replay(Pieces(header, events))
    replay.work()
    return replay


def told(model):
    """Return what a model knows, as far as it can be compared."""
    machines = {name: (one.state, dict(one.visits), one.timers) for name, one in model.machines.items()}
    return machines, model.world.pose, model.frames.count, len(model.log.lines), model.paused


@pytest.mark.parametrize(("bench", "length_s"), [("pioneer", 8), ("rover", 6), ("vehicle", 6)])
def test_a_place_is_what_had_been_told_by_then(recordings, model_of, monkeypatch, bench, length_s):
    monkeypatch.setattr(replay_module, "_AT_ONCE", 20)
    replay = at_end(*recordings[bench])
    assert replay.length_ns == length_s * S
    for at_s in (8.0, 0.3, 5.1, 0.0, 2.0, 4.0):
        replay.go_to(round(at_s * S))
        replay.work()
        assert told(replay.model) == told(model_of(bench, at_s))


def test_it_goes_far_in_small_steps_and_says_how_far_it_is(recordings, model_of):
    replay = Replay(Pieces(*recordings["pioneer"]))
    assert replay.progress == "reading, 0 %"
    while replay.progress:
        replay.work(lambda: True)
    replay.go_to(0)
    replay.work()
    replay._kept = {0: replay._kept[0]}  # as if the recording were long
    replay.go_to(8 * S)
    assert replay.progress == "on the way, 0 %"
    replay.work(lambda: True)
    assert 0 < replay.model.ns < 8 * S
    assert "on the way, 5" in replay.progress
    replay.go_to(2 * S)
    replay.work()
    assert told(replay.model) == told(model_of("pioneer", 2.0))


def test_what_is_read_is_followed_until_somebody_goes_elsewhere(tmp_path, journal_file):
    path = journal_file([fault(ns) for ns in range(5000)])
    replay = Replay(open_pieces(path))
    replay.work(lambda: True)
    read = replay.length_ns
    assert 0 < read < 4999
    assert (replay.now_ns, replay.model.ns, replay.model.faults.total()) == (read, read, read + 1)
    replay.go_to(7)
    replay.work()
    assert (replay.length_ns, replay.now_ns, replay.model.faults.total()) == (4999, 7, 8)
    assert not replay.to_error(-1) or replay.now_ns == 6
    replay.go_by(10**15)
    replay.work()
    assert replay.model.faults.total() == 5000


def test_no_errors_so_far_are_not_no_errors(journal_file, on_screen):
    path = journal_file([fault(ns) for ns in range(3000)])
    replay = Replay(open_pieces(path))

    async def scenario(app, pilot):
        app._most_s = 0
        app.open(RecordedBench(path), Replay(open_pieces(path)))
        app.look()
        assert "[reading, " in app._headline()
        await pilot.press("end", "e")
        assert "still read" in list(app._notifications)[-1].message
        app._most_s = math.inf
        app.look()
        assert app._headline().split()[-1] == "recorded"

    on_screen(RecordedBench(path), scenario, replay=replay)


@given(moves=st.lists(st.integers(-30, 60), max_size=8))
def test_steps_go_to_and_fro(moves):
    replay, at = at_end({}, [fault(ns) for ns in range(100)]), 100
    for move in moves:
        at = max(0, min(100, at + move))
        replay.step(move)
        replay.work()
        assert len(replay.model.log.lines) == at


def test_errors_are_found_one_after_the_other(recordings):
    replay = at_end(*recordings["pioneer"])
    replay.go_to(0)
    found = []
    while replay.to_error(1):
        replay.work()
        found.append(replay.model.log.errors)
    assert found == list(range(1, len(found) + 1))
    assert found


def test_it_plays_to_its_end_and_stops(recordings):
    replay = at_end(*recordings["pioneer"])
    replay.go_to(6 * S)
    replay.play(1.0)
    replay.work()
    assert replay.model.ns <= 6 * S
    replay.playing = True
    replay.play(1.0)
    replay.work()
    assert 6.9 * S < replay.model.ns <= 7 * S
    replay.play(5.0)
    replay.work()
    assert (replay.playing, replay.model.ns) == (False, 8 * S)


def test_a_recording_of_nothing_is_shown():
    replay = at_end({}, [])
    replay.go_to(5)
    replay.step(1)
    replay.work()
    assert not replay.to_error(1)
    assert replay.model.ns == 0


def test_keys_move_in_a_recording_and_ask_nobody(recordings, journals, on_screen, rows):
    replay = at_end(*recordings["pioneer"])

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
    replay = at_end(*recordings["pioneer"])

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
