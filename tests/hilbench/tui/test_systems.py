"""A system of somebody else's brings keys, a view, help and words to the dashboard; what fails of it costs a line."""

from __future__ import annotations

import sys

import pytest

from hilbench.plugins.discovery import PLUGINS, Plugins
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.replay import _Kept
from hilbench.tui.views.beside import beside_view
from hilbench.tui.views.help import help_text
from hilbench.tui.views.status import strip_view
from targets.parts import ROUTINE

HEAD = """
from rich.text import Text

from hilbench.plugins.dashboard import Dashboard, Help, Key
from hilbench.plugins.system import System


def view(told, width, height):
    return [Text(f"pan {told['pan_deg']} of {180 // told['pan_deg']}"), Text("." * 2 * width)][:height]


def help_on(actions, driver):
    rows = (("y", "looks at you"),) if "look" in actions else ()
    return Help(seen=(f"A head that {driver or 'nobody'} turns.",), title="Of a head", rows=rows)


class Head(System):
    api = 1
    name = "head"

    def dashboard(self):
        return Dashboard(
            kind="head",
            shows=frozenset({"head-pan-tilt"}),
            wide=((1, (("pins", 2), ("log", 1))), (1, (("world", 1),))),
            narrow=("pins", "log"),
            plots=("pan",),
            keys=(
                Key(key="y", title="Look at me", help="Turns.", do="look", more={"at": "me"}, shown="Look"),
                Key(key="v", title="Torque", help="Lets go.", do="torque", toggle=("on", "torque_on"), shown="Torque"),
                Key(key="z", title="Next way", help="Left, then right.", do="way", cycle=("to", ("left", "right"))),
                Key(key="p", title="Park", help="Parks.", do="park"),
                Key(key="k", title="Kick", help="There is no such thing.", do="kick", shown="Kick"),
            ),
            help=help_on,
            tells="head",
            view=view,
            routine=frozenset({"ServoMoved"}),
            bad=frozenset({"ServoHot"}),
            said={"nod": lambda event: (f"nods {event['times']} times", 1 // event["times"] > 1)},
            traffic=frozenset({"moves"}),
        )


HEAD = Head()
"""
ACTIONS = ("look", "torque", "way", "park", "pause", "stop")
LIVE = {"vehicle": "head-pan-tilt", "vehicle_size_m": [0.2, 0.1], "scene": {"name": "desk", "boxes": []}}
SEEN = {"ns": 1, "kind": "head", "source": "bench", "pan_deg": 30, "torque_on": True}
REPORTED = {"kind": "event", "source": "servo", "value": {}}
EVENTS = [
    SEEN,
    {**REPORTED, "ns": 2, "name": "ServoMoved"},
    {**REPORTED, "ns": 3, "name": "ServoHot"},
    {"ns": 4, "kind": "nod", "source": "servo", "times": 2},
    {"ns": 5, "kind": "nod", "source": "servo", "times": 0},
    {"ns": 6, "kind": "machine", "source": "servo", "state": "UP", "counters": {"moves": 3, "stalls": 2}},
]


@pytest.fixture
def plugins(monkeypatch):
    """What is known of plug-ins is forgotten again."""
    fresh = Plugins()
    monkeypatch.setattr(PLUGINS, "__dict__", fresh.__dict__)
    monkeypatch.setattr(sys, "path", [*sys.path])
    yield
    for name in ("head_of_a_test", "head_package"):
        sys.modules.pop(name, None)


@pytest.fixture
def bring(plugins, tmp_path):
    """Return what has a file bring its systems."""

    def run(source=HEAD):
        path = tmp_path / "head_of_a_test.py"
        path.write_text(source)
        PLUGINS.add_file(path, "a test")

    return run


def model_with(events=EVENTS):
    model = BenchModel({"live": LIVE})
    model.take(events)
    return model


def said(model):
    return [(line.text, line.bad) for line in model.log.lines]


def test_a_key_a_view_and_help_show_up_while_such_a_bench_is_open(
    bring, process_of, on_screen, journal_file, rows, settle
):
    bring()
    process, other = process_of("rover"), process_of("vehicle")
    process.journal, process.actions = journal_file(EVENTS, **LIVE), ACTIONS

    async def scenario(app, pilot):
        assert list(app.arrangement.seen(app.available(), 2)) == ["pins", "log"]
        screen = "\n".join(rows(app))
        assert "pan 30 of 6" in screen
        assert "y Look" in screen
        assert "v Torque" in screen
        assert "Kick" not in screen
        await pilot.press("y", "v", "z", "z", "z", "p", "k")
        assert process.sent == [
            ("look", {"at": "me"}), ("torque", {"on": False}),
            ("way", {"to": "left"}), ("way", {"to": "right"}), ("way", {"to": "left"}), ("pause", {}),
        ]  # fmt: skip
        assert list(app._notifications)[-1].message == "this bench has no 'kick'"
        offered = {one.title: one for one in app.get_system_commands(app.screen)}
        assert {
            f"Target: {it}" for it in ("Look at me  (y)", "Torque  (v)", "Next way  (z)", "Park  (p)")
        } <= offered.keys()
        assert not [title for title in offered if "Kick" in title or "joystick" in title]
        offered["Target: Park  (p)"].callback()
        assert process.sent[-1] == ("park", {})
        await pilot.press("question_mark")
        shown = str(app.screen.query_one("#help Static").render())
        assert "A head that nobody turns." in shown
        assert "Of a head\ny          looks at you" in shown
        app.pop_screen()
        app.open(other)
        await settle(app, pilot)
        await pilot.press("y")
        assert len(process.sent) == 7
        assert other.sent == []  # it cannot do what its own key asks for
        assert "Look" not in "\n".join(rows(app))

    on_screen(process, scenario)


def test_its_words_and_counters_are_what_it_says_they_are(bring):
    bring()
    model = model_with()
    assert said(model) == [("ServoHot", True), ("nods 2 times", False)]  # what fails makes no line
    assert "2 errors" in strip_view(model, 80).plain
    assert model.world.size_m == [0.2, 0.1]


def test_an_installed_one_is_known_by_the_vehicle_that_is_called_like_it(plugins, tmp_path, monkeypatch):
    about = tmp_path / "site" / "head_package-1.0.dist-info"
    about.mkdir(parents=True)
    about.joinpath("METADATA").write_text("Metadata-Version: 2.1\nName: head_package\nVersion: 1.0\n")
    about.joinpath("entry_points.txt").write_text("[hilbench.systems]\nhead = head_package:HEAD\n")
    (tmp_path / "site" / "head_package.py").write_text(HEAD)
    monkeypatch.syspath_prepend(tmp_path / "site")
    assert BenchModel({"live": {"vehicle": "other"}}).dashboard.kind == "board"
    assert "head_package" not in sys.modules  # nobody has named it
    assert model_with().dashboard.kind == "head"


def test_a_recording_of_such_a_bench_is_kept_and_come_back_to(bring):
    bring()
    model = model_with()
    again = _Kept(model).model()
    assert again.dashboard is model.dashboard
    assert (said(again), again.seen) == (said(model), model.seen)


def test_a_bench_of_another_system_is_shown_as_before(bring, model_of):
    before = model_of("vehicle").dashboard
    bring()
    after = model_of("vehicle").dashboard
    assert (after.kind, after.keys, after.view) == (before.kind, before.keys, before.view)
    assert after.traffic == before.traffic | {"moves"}
    assert BenchModel({"live": {"vehicle": "nobody's"}}).dashboard.kind == "board"


@pytest.mark.parametrize(
    ("was", "will_be", "why"),
    [
        ("        return Dashboard(", "        return dict(", "TypeError: {'kind': 'head'"),
        ('cycle=("to", ("left", "right"))', 'cycle=("to", ())', "ZeroDivisionError"),
        ("    def dashboard(self):", "    def dashboard(self):\n        raise OSError('no')", "OSError: no"),
        ("wide=((1, ", "wide=((", "its dashboard fails"),
    ],
)
def test_a_dashboard_that_cannot_be_had_costs_a_line(bring, was, will_be, why):
    bring(HEAD.replace(was, will_be))
    model = model_with([])
    assert model.dashboard.kind == "board"
    (line,) = model.log.lines
    assert line.text.startswith("system 'head': its dashboard fails: ")
    assert why in line.text


def test_a_view_and_help_that_fail_say_so_in_their_place(bring):
    bring(HEAD.replace("rows = ((", "rows = [].nothing, ((").replace("180 //", "180 / 0 //"))
    model = model_with()
    assert beside_view(model, 200, 5)[0].plain.startswith("its view fails: head_of_a_test.py:")
    text = help_text(model, ACTIONS, [], recorded=False)
    assert "its help fails: head_of_a_test.py:" in text
    assert "[b]Keys[/b]" in text


def test_what_parts_and_buses_report_all_the_time_is_no_line_of_the_log():
    events = [{**REPORTED, "ns": 1, "name": name} for name in (*ROUTINE, "I2cTransaction", "MotorHot")]
    assert [line.text for line in model_with(events).log.lines] == ["MotorHot"]


def test_help_names_a_protocol_that_says_nothing_of_itself(plugins, tmp_path):
    path = tmp_path / "head_of_a_test.py"
    path.write_text(
        "from hilbench.plugins.protocol import API, ProtocolPlugin\n"
        "BUS = ProtocolPlugin(api=API, name='bus', title='Our [bus]', decoder=print)\n"
    )
    PLUGINS.add_file(path, "a test")
    text = help_text(BenchModel({"live": {"operator": "host", "protocol": "bus"}}), ACTIONS, [], recorded=False)
    assert "The line speaks Our \\[bus]." in text
    assert "None of our clients" not in text


def test_what_is_shown_keeps_to_its_room(bring):
    bring()
    model = model_with()
    assert [line.cell_len for line in beside_view(model, 40, 9)] == [11, 40]
    assert len(beside_view(model, 40, 1)) == 1
    assert beside_view(model_with([]), 40, 9) == []
