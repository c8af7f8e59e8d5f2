from __future__ import annotations

import itertools
from dataclasses import fields

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.links import LinkCounters
from hilbench.systems.pioneer.protocol import P2OS
from hilbench.systems.rover.protocol import PKT
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.views.above import world_view
from hilbench.tui.views.canvas import Canvas
from hilbench.tui.views.frames import frame_view
from hilbench.tui.views.head import guide_view, head_view
from hilbench.tui.views.pins import pins_view
from hilbench.tui.views.status import LINE_ERRORS, clock_words, link_view, strip_view
from hilbench.tui.views.words import bar, bytes_words, ns_words, rate_words, seconds
from protocols import p2os, pkt
from tests.each import each
from worlds import find_scene, find_vehicle
from worlds.stage import Stage

S = 1_000_000_000
SIZES = {"small": (38, 9), "large": (76, 30)}


@pytest.fixture
def panes():
    from hilbench.tui.panes import PANES

    return PANES


@pytest.mark.parametrize("bench", ["pioneer", "rover", "vehicle"])
def test_every_pane_of_every_bench_looks_as_it_did(panes, model_of, expect, bench):
    model = model_of(bench)
    for (name, pane), (size, (width, height)) in itertools.product(panes.items(), SIZES.items()):
        lines = pane.view(model, width, height)
        expect(f"{bench}-{name}-{size}", [line.plain for line in lines[:height]])


@each(
    ("recent", "speed", "words", "pace"),
    [
        (1.0, 1.0, "", "pace     1.00 x real time, 0.90 in all"),
        (0.25, 1.0, "SLOW: 0.25 x real time", "pace     0.25 x real time, 0.90 in all"),
        (1.0, 4.0, "4 x", "pace     4.00 of 4 x real time, 3.60 in all"),
        (0.25, 4.0, "1.00 of 4 x", "pace     1.00 of 4 x real time, 3.60 in all"),
        (0.9, 1.0, "SLOW: 0.90 x real time", "pace     0.90 x real time"),
    ],
)
def test_a_bench_that_the_host_does_not_keep_up_with_is_shown_as_such(recent, speed, words, pace):
    model = BenchModel({})
    late = {"p50_ns": 0, "p99_ns": 0, "max_ns": 0, "slips": 0, "slipped_ns": 0}
    told = {"kind": "host-pace", "source": "bench", "factor": 0.9, "recent": recent, **late}
    clock = {"kind": "clock", "source": "bench", "speed": speed}
    model.take([{**clock, "ns": 0, "paused": False}, {**told, "ns": 1}])
    assert clock_words(model) == words
    assert pace in [line.plain for line in link_view(model, 80)]
    assert f"{recent * speed:.2f} x" in strip_view(model, 80).plain
    model.take([{**clock, "ns": 2, "paused": True}])
    assert clock_words(model) == "PAUSED"


@pytest.mark.parametrize("until_s", [0.0, 0.05, 0.3, 4.5])
def test_no_pane_is_wider_than_its_room(panes, model_of, until_s):
    model = model_of("pioneer", until_s)
    for name, width, height in itertools.product(panes, (12, 30, 57, 120), (2, 5, 20)):
        widest = max(line.cell_len for line in panes[name].view(model, width, height))
        assert widest <= max(width, 34), f"{name}, {width} x {height}"


def test_a_pane_of_nothing_says_so(panes):
    for name, pane in panes.items():
        assert pane.view(BenchModel({}), 40, 5)[0].plain, name


def test_colour_says_nothing_that_the_text_does_not(panes, model_of):
    model = model_of("pioneer")
    states = [line.plain for line in panes["states"].view(model, 60, 20)]
    assert [line for line in states if "▶" in line and "OPEN" in line]
    frames = [line.plain for line in panes["frames"].view(model, 60, 20)]
    assert all(" > " in line or " < " in line for line in frames)


def test_the_strip_names_states_the_nearest_deadline_and_errors(model_of):
    text = strip_view(model_of("pioneer"), 200).plain
    assert text.startswith("client OPEN  robot OPEN")
    assert " errors" in text


# --- one frame, byte by byte


@pytest.mark.parametrize("width", [100, 45])
def test_a_line_that_is_down_is_said_first_and_without_it_that_there_are_no_faults(width):
    model = BenchModel({"target": "it"})
    link = {"kind": "link", "source": "host", "port": "/dev/ttyUSB0", "baud": 9600}
    model.take([{**link, "ns": 0, "up": True}])
    assert "no faults" in head_view(model, "1.0 s", 100).plain
    model.take([{**link, "ns": 1, "up": False}])
    shown = head_view(model, "1.0 s", width).plain
    assert "no faults" not in shown
    assert "/dev/ttyUSB0 9600 DOWN" in shown


def test_a_bench_without_a_suite_offers_no_checks():
    model = BenchModel({})
    assert "checks" in guide_view(model, ["check"], 100, recorded=False).plain
    assert "checks" not in guide_view(model, [], 100, recorded=False).plain


def test_each_error_of_a_line_is_one_that_ports_count_and_is_told_once():
    assert sorted(LINE_ERRORS) == sorted({field.name for field in fields(LinkCounters)} - {"sent", "received"})


def test_the_bytes_of_a_sip_are_those_that_change_its_fields():
    sip = p2os.Sip(x_raw=0x1234, battery_dv=130, sonars=(p2os.SonarReading(number=3, range_raw=900),))
    raw = p2os.encode_packet(sip)
    found = P2OS.regions(raw, P2OS.options(), sent=False)
    assert b"".join(region.data for region in found) == raw
    by_name = {region.name: region.data for region in found}
    assert by_name["x_raw"] == bytes.fromhex("3412")
    assert by_name["battery_dv"] == bytes([130])
    assert by_name["sonars"] == bytes([3]) + (900).to_bytes(2, "little")
    assert by_name["checksum"] == raw[-2:]


def test_the_bytes_of_a_command_of_the_rover():
    raw = pkt.encode_frame(pkt.encode_command(pkt.MotorThrottles(a=0.5, b=-0.5), pkt.Schema.V2))
    found = PKT.regions(raw, PKT.options(), sent=True)
    assert [region.name for region in found][:3] == ["sync word", "length", "opcode"]
    assert {"a", "b"} <= {region.name for region in found}
    assert [region.name for region in found][-2:] == ["CRC", "end"]


@given(st.binary(min_size=1, max_size=40))
def test_the_regions_of_a_frame_of_any_body_have_no_gap(body):
    raw = b"\xfa\xfb" + bytes([len(body) + 2]) + body + b"\x00\x00"
    for sent in (True, False):
        found = P2OS.regions(raw, P2OS.options(), sent=sent)
        assert b"".join(region.data for region in found) == raw
        assert [region.start for region in found] == [
            sum(len(before.data) for before in found[:number]) for number in range(len(found))
        ]


def test_a_frame_is_shown_whole(model_of, expect):
    frames = model_of("pioneer").frames
    sip = frames.matching("< sip", 1)[0]
    expect("frame-sip", [line.plain for line in frame_view(sip, 72)])


def test_bytes_that_are_no_frame_are_shown_as_bytes(journal_file):
    model = BenchModel({"live": {"operator": "client", "protocol": "p2os"}})
    model.take([{"ns": 1, "kind": "rx", "source": "client", "data": "00112233fafb"}])
    bad = model.frames.matching("!", 5)
    assert bad
    assert "00 11 22 33" in "\n".join(line.plain for line in frame_view(bad[0], 40))


# --- pictures


@given(
    st.lists(st.tuples(st.floats(-50, 500), st.floats(-50, 500)), max_size=20), st.integers(1, 30), st.integers(1, 9)
)
def test_a_canvas_takes_any_line_and_keeps_its_size(points, columns, rows):
    canvas = Canvas(columns, rows)
    for begin, end in itertools.pairwise(points):
        canvas.line(begin, end)
    lines = canvas.lines()
    assert [len(line.plain) for line in lines] == [columns] * rows


def test_dots_of_a_canvas_are_where_they_belong():
    canvas = Canvas(2, 1)
    canvas.dot(0, 0)
    canvas.dot(3, 3)
    assert canvas.lines()[0].plain == "\u2801\u2880"


def test_the_vehicle_looks_where_it_goes():
    model = BenchModel({"live": {"vehicle": "pioneer-2dx", "scene": {"name": "room", "boxes": []}}})
    for yaw, arrow in ((0, "→"), (1_570_796, "↑"), (3_141_592, "←"), (-1_570_796, "↓"), (-785_398, "↘")):
        model.take([{"ns": 1, "kind": "pose", "source": "world", "x_m": 0, "y_m": 0, "z_m": 0, "yaw_rad": yaw}])
        assert arrow in "".join(line.plain for line in world_view(model.world, 40, 12))


def test_each_case_of_a_recording_has_its_own_world_around_the_vehicle():
    model = BenchModel({})
    for name in ("wall", "test-track"):
        stage = Stage.of(find_scene(name), find_vehicle("pioneer-2dx"))
        pose = {"kind": "pose", "source": "world", "x_m": 10**6, "y_m": 0, "z_m": 0, "yaw_rad": 0}
        model.take([{"ns": 0, "kind": "scene", "source": "world", **stage.data()}, {"ns": 1, **pose}])
        assert [list(outline) for outline in model.world.boxes] == list(map(list, stage.scene.outlines_m().values()))
        assert (model.world.vehicle, model.world.scene, len(model.world.track)) == ("pioneer-2dx", name, 1)
        assert model.world.size_m == pytest.approx((0.44, 0.38), abs=0.1)
    points, half_m = model.world.lane
    assert (points[0], half_m) == (points[-1], 1.75)


def test_pins_that_do_most_are_shown_where_not_all_fit(expect):
    model = BenchModel({"live": {"boards": {"brain": {"leds": {"PB0": "LD1"}}}}})
    for number in range(20):
        for edge in range(number + 1):
            event = {"ns": edge * S // 10, "kind": "pin", "source": f"brain.PA{number}", "level": edge % 2 == 0}
            model.take([event])
    model.take([{"ns": S, "kind": "pwm", "source": "brain.PC1", "edges": 40, "period_ns": 2_000_000,
                 "high_ns": 500_000, "in_ns": 100_000_000, "level": True}])  # fmt: skip
    expect("pins", [line.plain for line in pins_view(model.pins, 70, 8, 2 * S)])


def test_analog_pins_have_volts_a_trace_on_the_scale_of_their_supply_and_a_row_before_busy_ones(expect):
    model = BenchModel({"live": {"boards": {"brain": {"leds": {"PB0": "LD1"}}}}})
    for tenth in range(25):
        ns = tenth * S // 10
        volts = {"brain.PF12": [1.7106, 3.3], "brain.PF11": [3.3 * tenth / 24, 3.3]}
        model.take([{"ns": ns, "kind": "volts", "source": "bench", "pins": volts}])
        model.take([{"ns": ns, "kind": "pin", "source": f"brain.PA{tenth % 3}", "level": tenth % 2 == 0}])
    model.take([{"ns": 2 * S, "kind": "pin", "source": "brain.PF11", "level": True}])
    large, small = (pins_view(model.pins, width, height, 5 * S // 2) for width, height in ((70, 8), (38, 4)))
    expect("pins-analog", [line.plain for line in (*large, *small)])


# --- words


@each(
    ("ns", "text"),
    [(0, "0.000 s"), (1_234_567_890, "1.234 s"), (61 * S, "0:01:01.000"), (7384_900_000_000, "2:03:04.900")],
)
def test_bench_times(ns, text):
    assert seconds(ns) == text


def test_spans_rates_and_sizes():
    assert [ns_words(ns) for ns in (0, 250_000, 12_500_000, 7_900_000_000)] == ["0 us", "250 us", "12.5 ms", "7.90 s"]
    assert [rate_words(rate) for rate in (0.0, 9.8, 1234.0)] == ["", "9.8/s", "1.2 k/s"]
    assert [bytes_words(count) for count in (812, 12_300, 4_200_000)] == ["812 B", "12.3 kB", "4.2 MB"]


@given(st.floats(-1, 2), st.integers(1, 60))
def test_a_bar_is_as_wide_as_it_is_told(share, width):
    assert len(bar(share, width)) == width


# --- several boards


def test_lines_are_shown_below_their_boards_and_no_line_is_cut(expect):
    model = BenchModel({"live": {"boards": {"brain": {}, "arm": {}}}})
    told = {"kind": "link", "baud": 115_200, "pending": 0, "up": True, "framing_errors": 0}
    for name, port in (("gps", "brain.usart1"), ("grip", "arm.usart1"), ("host", "brain.usart2")):
        for ns in (S, 2 * S):
            model.take([{**told, "ns": ns, "source": name, "port": port, "sent": ns // 10**6, "received": 12_345}])
    model.take([{**told, "ns": 2 * S, "source": "grip", "up": False, "framing_errors": 3, "port": "arm.usart1"}])
    for width in (78, 58):
        lines = [line.plain for line in link_view(model, width)]
        assert not any("…" in line for line in lines), width
        expect(f"link-boards-{width}", lines)


def test_pins_of_several_boards_stand_below_their_names():
    model = BenchModel({"live": {"boards": {"brain": {"leds": {"PB0": "LD1"}}}}})
    model.take({"ns": 0, "kind": "pin", "source": f"{board}.PA{at}", "level": True} for board in ("brain", "arm")
               for at in (0, 1))  # fmt: skip
    whole = [line.plain.split()[0] for line in pins_view(model.pins, 60, 7, 0)]
    assert whole == ["arm", "PA0", "PA1", "brain", "PB0", "PA0", "PA1"]
    short = [line.plain.split()[0] for line in pins_view(model.pins, 60, 6, 0)]
    assert short == ["arm", "PA0", "PA1", "brain", "PA0", "and"]  # the light that never lit goes first


def test_analog_pins_are_seen_beside_a_cockpit_in_any_room(panes, model_of):
    model = model_of("vehicle")
    model.take({"ns": model.ns, "kind": "pin", "source": f"brain.PA{at}", "level": True} for at in range(9))
    model.take([{"ns": model.ns, "kind": "volts", "source": "bench",
                 "pins": {"brain.PF11": [1.0, 3.3], "brain.PF12": [2.0, 3.3]}}])  # fmt: skip
    for height in range(3, 14):
        lines = [line.plain for line in panes["pins"].view(model, 58, height)]
        assert len(lines) <= height
        assert "stick" in lines[0], height
        seen = [line.split()[0] for line in lines if " V of " in line]
        assert seen == ["PF11", "PF12"][: max(1, height - 2)], height
