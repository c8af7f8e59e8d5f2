"""A demo: its script without a screen, one session in a dashboard, and the command."""

from __future__ import annotations

import asyncio
import textwrap

import pytest

from hilbench.benchfile.reader import open_bench
from hilbench.cli import main
from hilbench.plugins.demo import Check, Demo, LiveBench, Scene
from hilbench.plugins.discovery import PLUGINS
from hilbench.strict.changes import parse_change
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.checks import ChecksModel
from hilbench.tui.model.playing import Playing, Seen, figures
from hilbench.tui.views.caption import caption_keys, caption_of, caption_view, words_of
from tests.each import each

NS_PER_S = 1_000_000_000
BENCH = LiveBench(bench="tiny")
CHECK = Check(bench="tiny", suite="s", select="A1 and x", verdicts={"A1": "fail"})


def seen(s=0.0, *, live=True, checked=True, verdicts=(), **figures):
    ns = round(s * NS_PER_S)
    values = {name: (value,) for name, value in figures.items()}
    return Seen(ns=ns, live=live, checked=checked, figures=values, verdicts=dict(verdicts))


def playing(*scenes, opens=True):
    first = Scene(title="first", text="", lasts_s=2, bench=BENCH)
    return Playing(Demo(title="t", scenes=(first, *scenes) if opens else scenes))


def scene(**more):
    return Scene(**{"title": "a", "text": "", "lasts_s": 2.0, **more})


# --- the script, without a screen


def test_a_scene_lasts_as_long_as_it_says_and_the_last_one_is_the_end():
    one = playing(scene())
    assert not one.play(1.5, seen())
    assert one.play(0.5, seen())
    assert one.go_on(seen())
    assert one.number == 1
    assert not one.play(1.9, seen())
    assert one.play(0.1, seen())
    assert not one.go_on(seen())
    assert one.broken == []


def test_a_scene_waits_for_its_bench_for_its_check_and_for_bench_time():
    one = playing(scene(check=CHECK), scene(bench_s=3))
    assert not one.play(9, seen(live=False))
    assert one.play(0, seen(1))
    one.go_on(seen(1))
    assert not one.play(9, seen(1, checked=False))
    assert one.play(0, seen(1))
    one.go_on(seen(1, verdicts={"A1": "fail"}))
    assert not one.play(9, seen(3.9))
    assert one.play(0, seen(4))
    assert one.broken == []


def test_nothing_passes_in_a_pause_and_a_skipped_scene_waits_for_its_check_alone():
    one = playing(scene(check=CHECK, lasts_s=60, claims={"speed": (1, 2)}), scene())
    one.paused = True
    assert not one.play(9, seen())
    one.skip()
    assert one.play(0, seen())
    one.go_on(seen())
    one.skip()
    assert not one.play(0, seen(checked=False))
    assert one.play(0, seen())
    one.go_on(seen(verdicts={"A1": "fail"}))
    assert not one.play(1, seen())  # the next one was not skipped
    assert one.broken == []  # what a skipped scene claims was not shown


@each(
    ("claims", "figures", "said"),
    [
        ({"speed": (0.1, 9)}, {"speed": 0.2}, []),
        ({"speed": (0.1, 9)}, {"speed": -0.2}, []),
        ({"speed": (0, 0.1)}, {"speed": -0.2}, ["scene 'first': speed is -0.2, expected 0 to 0.1 either way"]),
        ({"speed": (0, 0.1)}, {}, ["scene 'first': speed is not known, expected 0 to 0.1 either way"]),
    ],
)
def test_what_a_scene_claims_is_looked_at(claims, figures, said):
    one = playing(scene(title="first", bench=BENCH, claims=claims), opens=False)
    one.go_on(seen(**figures))
    assert one.broken == said


@each(("verdicts", "found"), [({"A1": "pass"}, "pass"), ({}, "not run")])
def test_another_verdict_than_the_script_says_is_reported(verdicts, found):
    one = playing(scene(title="first", bench=BENCH, check=CHECK), opens=False)
    one.skip()
    one.go_on(seen(verdicts=verdicts))
    assert one.broken == [f"scene 'first': the verdict of A1 is '{found}', expected 'fail'"]


def test_the_time_since_something_was_requested_begins_with_a_bench():
    one = playing(scene(asks=({"do": "stop"},)), scene(), scene(bench=BENCH))
    found = [one.since_s(5 * NS_PER_S)]
    for at_s in (5, 6, 8):
        one.go_on(seen(at_s))
        found.append(one.since_s((at_s + 1) * NS_PER_S))
    assert found == [5, 1, 2, 9]


@each("scenes", [(), (scene(),)])
def test_a_demo_opens_a_bench_first(scenes):
    with pytest.raises(ValueError, match="the first scene of a demo opens a bench"):
        Demo(title="t", scenes=scenes)


# --- the caption


def test_a_caption_has_what_was_measured(model_of):
    model, one = model_of("rover"), playing()
    words = words_of(one, model, None)
    assert caption_of("{throttles} {faults} {since} {verdict} {nothing}", words) == (
        f"{words['throttles']} {sum(model.faults.values())} 6.0 s … …"
    )
    assert len(figures(model)["rpm"][0]) == len(words["rpm"].split("/")) == 4


def test_a_pin_that_has_come_to_rest_has_no_duty_any_more():
    model = BenchModel({"bench": "own", "live": {}})
    edges = [(0, True), (5, False), (20, True), (25, False), (40, True), (45, False)]
    model.take({"kind": "pin", "source": "a.PB1", "level": level, "ns": ms * 1_000_000} for ms, level in edges)
    assert figures(model)["PB1 duty"] == ((25.0,), "%")
    model.take([{"kind": "mark", "ns": NS_PER_S}])
    assert figures(model)["PB1 duty"] == ((0.0,), "%")
    assert figures(None) == {}


def test_a_caption_has_the_verdict_of_the_check():
    checks, one = ChecksModel(), playing()
    checks.take({"kind": "case", "case": "s/a"})
    assert words_of(one, None, checks)["verdict"] == "still running"
    checks.take({"kind": "verdict", "case": "s/a", "verdict": "fail", "cause": "no answer"})
    words = words_of(one, None, checks)
    assert (words["verdict"], words["cause"]) == ("FAIL", "no answer")


def test_a_caption_that_is_too_long_shows_that():
    assert [line.plain for line in caption_view("one two three four", 9, 2)] == ["one two", "three …"]
    assert [line.plain for line in caption_view("one two", 9, 2)] == ["one two"]


def test_the_keys_stand_beside_the_time_that_is_left():
    one = playing(scene(lasts_s=70))
    assert caption_keys(one) == "space Pause  n Next  q Quit   1/2  1:12 left"
    one.paused = True
    assert caption_keys(one) == "space Continue  n Next  q Quit   1/2  PAUSED"
    one.skip()
    assert caption_keys(one) == "space Pause  wait for the end  q Quit   1/2  1:12 left"


# --- the scripts of our systems


@pytest.fixture(scope="module")
def demos():
    """The demos of our systems, with physics and without."""
    return {(name, on): one for on in (True, False) for name, one in PLUGINS.systems.demos(physics=on).items()}


LONGEST = {"speed": "-0.15 m/s", "PB11 duty": "80.00 %", "faults": "120", "since": "12.5 s", "verdict": "still running"}
LONGEST |= {"cause": "the motors still run: (0.5, -0.25)"}


def test_a_script_takes_about_two_minutes_and_fits_below_a_small_screen(demos):
    from hilbench.tui.panes import PANES

    assert len(demos) == 2
    for name, script in demos.items():
        assert 90 <= sum(one.lasts_s for one in script.scenes) <= 120, name
        for one in script.scenes:
            filled = caption_of(one.text, LONGEST)
            assert "…" not in filled, one.title
            assert len(textwrap.wrap(filled, 76)) <= 3, (one.title, filled)
            assert {*one.panes} <= {*PANES}, one.title
            assert one.lasts_s >= len(one.text.split()) / 4, f"{one.title}: nobody reads that fast"


def test_a_script_opens_benches_and_checks_that_there_are(demos):
    for script in demos.values():
        for one in script.scenes:
            if one.bench is not None:
                changes = [parse_change(text) for text in one.bench.changes]
                assert open_bench(one.bench.bench, changes=changes).boards
            if one.check is not None:
                assert one.check.suite in open_bench(one.check.bench).suites
                assert "-k 'P24D and documented'" in one.check.command


# --- a session


def test_a_session(process_of, all_done, rows):
    from hilbench.tui.demo import DemoDashboard
    from hilbench.tui.panes import PANES

    script = Demo(
        title="t",
        scenes=(
            Scene(title="One", text="It drives: {throttles}.", lasts_s=60, panes=("frames",), bench=BENCH,
                  asks=({"do": "inject", "kind": "noise"},)),
            Scene(title="Two", text="Another bench.", lasts_s=60, bench=BENCH, panes=("world", "link")),
            Scene(title="Three", text="The end.", lasts_s=60, claims={"throttles": (2, 3)}),
        ),
    )  # fmt: skip
    first, second = process_of("rover"), process_of("rover")
    app = DemoDashboard(script, first, lambda bench: second, ticking=False)

    async def play():
        async with app.run_test(size=(80, 24)) as pilot:
            while app.model is None or not app.model.ended:
                app.look()
            await pilot.pause()
            screen = "\n".join(rows(app))
            assert "One" in screen
            assert f"It drives: {words_of(app.playing, app.model, None)['throttles']}." in screen
            assert first.sent == [("inject", {"kind": "noise"})]
            assert [pane for pane in PANES if app.query_one(f"#{pane}").display] == ["frames"]
            await pilot.press("space")
            assert first.sent[-1] == ("pause", {})
            assert "PAUSED" in "\n".join(rows(app))
            await pilot.press("n")
            assert first.sent[-2:] == [("resume", {}), ("stopped", {})]
            assert app.process is second
            while app.model is None or not app.model.ended:
                app.look()
            await pilot.pause()
            assert "link" in [pane for pane in PANES if app.query_one(f"#{pane}").display]
            await pilot.press("n")
            app.stopwatch = type("Late", (), {"elapsed_s": lambda _: 1e6})()
            app.look()
            await pilot.pause()

    asyncio.run(play())
    assert app.return_code == 4
    assert app.playing.broken[0].startswith("scene 'Three': throttles is ")
    assert second.sent[-1] == ("stopped", {})


# --- the command


def test_without_a_terminal_it_is_one_line(capfd):
    assert main(["demo"]) == 2
    said = "hilbench: the dashboard needs a terminal, and this is none; start it in a terminal window\n"
    assert capfd.readouterr() == ("", said)


@pytest.mark.exhaustive("minutes of bench time in the emulator; the gate has the script, and a session on recordings")
@pytest.mark.parametrize("physics", [True, False])
def test_our_demo_shows_what_it_says(physics):
    from measure.demo_picture import played, script_of

    app = asyncio.run(played(script_of("rover", physics=physics)))
    assert (app.playing.broken, app.problem, app.return_code) == ([], "", 0)
    assert len(app.screens) == len(app.playing.demo.scenes)
