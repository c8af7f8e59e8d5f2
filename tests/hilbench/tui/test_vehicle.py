"""A vehicle interface on the dashboard: both lines decoded byte by byte, what its board does, what is asked of it."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hilbench.plugins.discovery import PLUGINS
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.views.above import world_view
from hilbench.tui.views.beside import beside_view
from hilbench.tui.views.counters import counters_view
from hilbench.tui.views.frames import frame_view
from hilbench.tui.views.help import help_text
from hilbench.tui.views.status import link_view
from hilbench.tui.views.watchdogs import timers_view
from protocols import autoware, carla
from tests.each import each

MS = 1_000_000
SEEN = {
    "reported": "MANUAL", "stack_on": True, "simulator_on": False, "stick": [0.0, 1.0], "pressed": True,
    "lights": ["green"], "lamps": [True, False], "speed_m_s": 10.0, "tyre_rad": -0.1, "offset_m": -0.5,
}  # fmt: skip
ACTIONS = ("press", "mode", "stack", "simulator", "lamps", "restart", "drive", "stop", "demo", "inject")


# --- frames


def named(protocol, raw, *, sent):
    spoken = PLUGINS.get(protocol, "a test")
    return [(region.name, region.data.hex()) for region in spoken.regions(raw, spoken.options(), sent=sent)]


def test_the_fields_of_a_command_are_called_what_they_mean_in_its_mode():
    autoware_names = [name for name, _ in named("carla", carla.VECTORS["F1"].data, sent=False)]
    manual = dict(named("carla", carla.VECTORS["F2"].data, sent=False))
    assert autoware_names[2::2] == [
        "steering_rad", "steering_rate_rad_s", "speed_m_s", "acceleration_m_s2", "jerk_m_s3", "mode", "NUL",
    ]  # fmt: skip
    assert (manual["steer"], manual["throttle"], manual["brake"], manual["mode"]) == (
        "000000bf", "0000403f", "00000000", "04",
    )  # fmt: skip


finite = st.floats(-1e6, 1e6, width=32)


@given(finite, finite, finite, finite)
def test_the_regions_of_a_status_have_no_gap(a, b, c, d):
    status = carla.StatusFrame(lon_speed_m_s=a, lat_speed_m_s=b, heading_rate_rad_s=c, steering_rad=d)
    found = named("carla", carla.encode_status(status), sent=True)
    assert "".join(data for _, data in found) == carla.encode_status(status).hex()
    assert [name for name, _ in found][2::2] == [
        "lon_speed_m_s", "lat_speed_m_s", "heading_rate_rad_s", "steering_rad",
    ]  # fmt: skip


@given(st.integers(0, 2**31 - 1), st.integers(0, 999_999_999), finite)
def test_the_regions_of_a_report_have_no_gap_though_bytes_are_escaped(sec, nanosec, speed):
    report = autoware.VelocityReport(stamp=autoware.Time(sec, nanosec), longitudinal_velocity=speed)
    raw = autoware.encode_frame(autoware.encode_message(report))
    found = named("autoware", raw, sent=False)
    assert "".join(data for _, data in found) == raw.hex()
    assert [name for name, _ in found] == [
        "flag", "source", "remote", "length", "id", "stamp",
        "longitudinal_velocity", "lateral_velocity", "heading_rate", "CRC",
    ]  # fmt: skip


def test_frames_of_both_lines_are_decoded_and_found_by_their_line(model_of, expect):
    frames = model_of("vehicle").frames
    simulator, stack = frames.matching("simulator", 400), frames.matching("stack -simulator", 400)
    assert {frame.item.name for frame in simulator} == {"Status", "AUTOWARE", "MANUAL"}
    assert "VelocityReport" in {frame.item.name for frame in stack}
    command = frames.matching("simulator < autoware", 1)[0]
    expect("frame-command", [line.plain for line in frame_view(command, 72)])


# --- panes


@each("view", [link_view, timers_view, counters_view])
@each("width", [36, 60, 100])
def test_panes_keep_to_their_width(model_of, view, width):
    lines = view(model_of("vehicle"), width)
    assert lines
    assert all(line.cell_len <= width for line in lines)


def test_both_lines_are_shown_as_links(model_of):
    text = "\n".join(line.plain for line in link_view(model_of("vehicle"), 60))
    assert "simulator up    no errors  921600 baud" in text
    assert "stack     up    no errors  921600 baud" in text


def test_the_modes_and_their_way_are_known(model_of):
    board = model_of("vehicle").machines["board"]
    assert board.states == ["AUTOWARE", "MANUAL", "EMERGENCY"]
    assert (board.state, board.came_from, board.trigger) == ("MANUAL", "AUTOWARE", "PRESS")
    assert board.visits["AUTOWARE", "PRESS"] == 1
    link = model_of("vehicle").machines["board link"]
    assert (link.state, link.trigger) == ("ONLINE", "AGENT_ONLINE")


def test_deadlines_that_come_fast_show_their_margin_and_misses_grow():
    model = BenchModel({"live": {"machines": {"board": {"states": {"AUTOWARE": ""}, "seen": "from its frames"}}}})
    timers = {
        "COMMAND": {"deadline_ns": 5 * MS, "span_ns": 110 * MS, "margin_ns": 80 * MS, "worst_ns": 20 * MS},
        "COMMANDS_LOST": {"deadline_ns": 700 * MS, "span_ns": 1100 * MS, "margin_ns": 1000 * MS, "worst_ns": 0},
        "PAUSE": {"deadline_ns": None, "span_ns": 60 * MS, "margin_ns": None, "worst_ns": None},
    }
    model.take(
        [{"ns": 100 * MS, "kind": "machine", "source": "board", "timers": timers, "misses": {"STATUS": [8, 10, 9]}}]
    )
    lines = [line.plain for line in timers_view(model, 80)]
    assert lines[0] == "board, from its frames"
    assert "80.0 ms  min 20.0 ms  of 110.0 ms" in lines[1]
    assert "600.0 ms  ran out  last 1.00 s" in lines[2]
    assert "stopped  of 60.0 ms" in lines[3]
    assert "8 of 10  most 9" in lines[4]
    model.ns = 400 * MS
    assert " 0 us  min 20.0 ms" in timers_view(model, 80)[1].plain  # nobody fed it since


def cockpit(seen, width):
    model = BenchModel({"live": {"vehicle": "car"}})
    model.take([{"ns": 1, "kind": "vehicle", "source": "bench", **seen}] if seen else [])
    return beside_view(model, width, 6)


def test_the_cockpit(expect):
    expect("cockpit", [line.plain for line in cockpit(SEEN, 60)])
    assert cockpit({}, 60) == []
    elsewhere = [line.plain for line in cockpit({**SEEN, "stick": None, "lights": None, "lamps": None}, 70)]
    assert elsewhere[0].startswith("joystick, lights and lamps are at the board")
    assert len(elsewhere) == 4
    assert not any(word in line for line in elsewhere[1:] for word in ("lights", "lamps", "stick"))


@given(st.floats(-1, 1), st.floats(-1, 1), st.integers(20, 80))
def test_the_stick_is_within_its_field(right, forward, width):
    lines = cockpit({**SEEN, "stick": [right, forward]}, width)
    assert len(lines) == 6
    assert sum(line.plain[:12].count("●") for line in lines) == 1
    assert all(line.cell_len <= width for line in lines)


def test_the_lane_is_drawn_whole_before_anything_has_moved():
    lane = {"center": [[0, 0], [100, 0], [100, 40], [0, 40]], "width_m": 3.5, "closed": True}
    model = BenchModel({"live": {"vehicle": "car", "scene": {"name": "track", "boxes": []}, "lane": lane}})
    model.take([{"ns": 1, "kind": "pose", "source": "world", "x_m": 0, "y_m": 0, "z_m": 0, "yaw_rad": 0}])
    drawn = [line.plain for line in world_view(model.world, 60, 14)][:-1]
    dots = [(row, column) for row, line in enumerate(drawn) for column, cell in enumerate(line) if cell != " "]
    assert max(column for _, column in dots) - min(column for _, column in dots) > 50
    assert max(row for row, _ in dots) - min(row for row, _ in dots) > 8


# --- keys


ASKED_BY_KEYS = {
    "y": ("mode", {"mode": "AUTOWARE"}),
    "v": ("mode", {"mode": "MANUAL"}),
    "j": ("press", {}),
    "k": ("stack", {"on": False}),
    "l": ("simulator", {"on": False}),
    "z": ("lamps", {"which": "left"}),
    "backspace": ("restart", {}),
}


def test_keys_ask_the_board_and_those_around_it(process_of, on_screen):
    process = process_of("vehicle")
    process.actions = ACTIONS

    async def scenario(app, pilot):
        for key in ASKED_BY_KEYS:
            await pilot.press(key)
        assert process.sent == list(ASKED_BY_KEYS.values())
        app.model.seen = {**app.model.seen, "simulator_on": False}
        await pilot.press("l", "z")
        assert process.sent[-2:] == [("simulator", {"on": True}), ("lamps", {"which": "right"})]

    on_screen(process, scenario, (132, 40))


def test_lamps_begin_anew_with_each_bench(process_of, on_screen):
    async def press(app, pilot):
        await pilot.press("z")

    for _ in range(2):
        process = process_of("vehicle")
        process.actions = ACTIONS
        on_screen(process, press)
        assert process.sent == [("lamps", {"which": "left"})]


def test_a_bench_without_them_is_not_asked(process_of, on_screen):
    process = process_of("pioneer")

    async def scenario(app, pilot):
        await pilot.press(*ASKED_BY_KEYS)
        assert process.sent == []

    on_screen(process, scenario, (132, 40))


def test_a_fault_is_put_on_one_of_the_lines(process_of, on_screen):
    process = process_of("vehicle")
    process.actions = ACTIONS

    async def scenario(app, pilot):
        await pilot.press("i")
        await pilot.pause()
        assert type(app.screen).__name__ == "InjectScreen"
        app.screen.query_one("#line").value = "stack"
        await pilot.press("ctrl+s")
        await pilot.pause()
        assert process.sent[-1][1]["line"] == "stack"

    on_screen(process, scenario, (132, 40))


# --- plots


def test_what_is_commanded_is_another_signal_than_what_is_true(model_of):
    signals = model_of("vehicle").signals.signals
    assert {"speed", "AUTOWARE speed"} <= signals.keys()
    assert max(value for _, value in signals["speed"].parts[0]) < 9.0
    assert max(value for _, value in signals["AUTOWARE speed"].parts[0]) == 10.0


# --- help


def test_help_knows_who_is_at_both_lines(model_of):
    text = help_text(model_of("vehicle"), ACTIONS, [], recorded=False)
    assert "None of our clients speaks to it" not in text
    assert "at its two lines" in text
    assert "Of a vehicle interface" in text
    assert "pauses the simulator" in text
    driven = model_of("vehicle", 1.0)
    assert "press the switch, and you have the stick" in help_text(driven, ("drive", "press"), [], recorded=False)
    assert "press the switch" not in help_text(driven, ("mode", "stack"), [], recorded=False)
    assert "Of a vehicle interface" not in help_text(model_of("pioneer"), ("drive",), [], recorded=False)
