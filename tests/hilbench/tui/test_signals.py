"""Figures over time, words of firmware, verdicts of a run: what the models make of events."""

from __future__ import annotations

import math
from enum import IntFlag
from types import SimpleNamespace

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from hilbench.plugins.dashboard import Dashboard
from hilbench.plugins.protocol import Quantity
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.checks import ChecksModel
from hilbench.tui.model.quantities import numbers_of, quantity_of, text_of
from hilbench.tui.model.signals import SignalsModel
from hilbench.tui.views.checks import checks_view, clause_view
from hilbench.tui.views.console import console_view
from hilbench.tui.views.plots import figure, plots_view
from protocols import p2os
from protocols.p2os import SonarReading
from tests.each import each

S = 1_000_000_000
MS = 1_000_000
BOARD = {"live": {"boards": {"brain": {"board": "bluepill", "leds": {}}}}}


def values(model, name):
    return [value for _, value in model.signals.signals[name].parts[0]]


def pose(ns, x_m, y_m, yaw_rad):
    return {
        "ns": ns, "kind": "pose", "source": "world", "z_m": 0,
        "x_m": round(1e6 * x_m), "y_m": round(1e6 * y_m), "yaw_rad": round(1e6 * yaw_rad),
    }  # fmt: skip


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-3.1, 3.1))
def test_speed_and_turn_rate_are_those_of_the_way(speed, turn, yaw):
    model = BenchModel({})
    for number in range(4):
        along = speed * number / 10
        model.take([pose(number * S // 10, along * math.cos(yaw), along * math.sin(yaw), yaw)])
    assert values(model, "speed") == pytest.approx([speed] * 3, abs=1e-4)
    model = BenchModel({})
    model.take(pose(n * S // 10, 0, 0, math.remainder(yaw + turn * n / 10, math.tau)) for n in range(4))
    assert values(model, "turn rate") == pytest.approx([math.degrees(turn)] * 3, abs=1e-2)


@given(st.integers(1, 99))
def test_duty_is_told_of_fast_and_of_slow_pins(percent):
    model = BenchModel(BOARD)
    wave = {"period_ns": 1_000_000, "high_ns": 10_000 * percent, "edges": 200, "level": True}
    model.take([{"ns": S, "kind": "pwm", "source": "brain.PA8", **wave}])
    for number in range(6):
        begin = number * 20 * MS
        model.take([{"ns": begin, "kind": "pin", "source": "brain.PB1", "level": True}])
        model.take([{"ns": begin + percent * MS // 5, "kind": "pin", "source": "brain.PB1", "level": False}])
    assert values(model, "PA8 duty") == pytest.approx([percent])
    assert values(model, "PB1 duty") == pytest.approx([percent] * 2)


def test_one_name_with_two_units_is_two_figures():
    model = SignalsModel(Dashboard(kind="it"), {})
    for number in range(2):
        for unit, value in (("mm/s", 250.0), ("%", 40.0)):
            one = SimpleNamespace(quantity=Quantity("speed", unit), numbers=[value])
            item = SimpleNamespace(name="Report", fields={})
            model.take_frames([SimpleNamespace(sent=False, good=True, line="", ns=number * S, item=item, fields=[one])])
    found = {name: (signal.unit, [value for _, value in signal.parts[0]]) for name, signal in model.signals.items()}
    assert found == {"speed": ("mm/s", [250.0] * 2), "speed in %": ("%", [40.0] * 2)}


def test_what_the_far_end_tells_has_its_unit(model_of):
    robot, rover = model_of("pioneer").signals, model_of("rover").signals
    assert robot.signals["battery"].unit == "V"
    assert set(values(model_of("pioneer"), "battery")) == {13.0}
    assert (rover.signals["rpm"].unit, len(rover.signals["rpm"].parts)) == ("rpm", 4)
    assert robot.usual() == ["speed", "turn rate", "battery"]
    assert rover.usual()[:2] == ["rpm", "throttles"]


@each(
    ("name", "value", "shown", "numbers"),
    [
        ("level_mm", 7, "level 7 mm", [7]),
        ("speed_mm_s", -0.0, "speed 0 mm/s", [0]),
        ("battery_dv", 131, "battery 13.1 V", [13.1]),
        ("range_m", (1.5, 22), "range 1.5 22 m", [1.5, 22]),
        ("last_number", True, "last number yes ", [1]),
        ("x_raw", 32_760, "x -6.4 mm", [-6.4]),
        (
            "sonars",
            (SonarReading(number=3, range_raw=100), SonarReading(number=4, range_raw=7)),
            "sonars 3:50 4:3.5 mm",
            [],
        ),
        ("name", "P2", "name P2 ", []),
        ("flags", IntFlag("Flags", "A B")(0), "flags 0 ", [0]),
    ],
)
def test_a_field_has_the_unit_that_its_protocol_says_else_the_one_that_ends_its_name(name, value, shown, numbers):
    known = {"x_raw": Quantity("x", "mm", 0.8, 32_768), "sonars": Quantity("sonars", "mm", 0.5)}
    quantity = quantity_of(name, known)
    assert f"{quantity.label} {text_of(value, quantity)} {quantity.unit}" == shown
    assert numbers_of(value, quantity) == pytest.approx(numbers)


def test_any_field_of_a_message_is_a_figure_as_far_back_as_frames_are_kept(model_of):
    signals = model_of("pioneer").signals
    heading = signals.signal("< Sip.th_raw")
    assert heading.unit == "°"
    assert heading.parts[0][-1] == pytest.approx((7_911_000_000, 91.8), rel=0.01)
    assert [value for _, value in signals.signal("> VEL.argument").parts[0]] == [240, 200, 0]
    assert signals.signal("< Sip.nothing") is None


def test_what_is_ahead_is_the_nearest_that_was_heard_last():
    live = {"operator": "client", "protocol": "p2os", "sonar_unit_mm": 1.0, "sonar_no_echo": 5000}
    model = BenchModel({"live": live})
    for number, readings in enumerate([[(2, 900), (7, 100)], [(3, 700)], [(2, 1200), (3, 5000)], [(2, 5000)]]):
        sonars = tuple(p2os.SonarReading(number=disc, range_raw=raw) for disc, raw in readings)
        data = p2os.encode_packet(p2os.Sip(sonars=sonars)).hex()
        model.take([{"ns": number * S, "kind": "rx", "source": "client", "data": data}])
    assert values(model, "range ahead") == pytest.approx([0.9, 0.7, 1.2])


def test_what_the_sonar_hears_is_drawn_from_where_the_robot_is():
    live = {"operator": "client", "protocol": "p2os", "sonar_unit_mm": 1.0, "sonar_no_echo": 5000}
    model = BenchModel({"live": live | {"sonars": [[0.1, 0.0, 0.0], [0.0, 0.2, math.pi / 2]]}})
    heard = {"packet": {"sonars": [{"number": 0, "range_raw": 900}, {"number": 1, "range_raw": 5000}]}}
    packet = {"kind": "event", "name": "PacketReceived", "source": "client", "ns": S, "value": heard}
    model.take([{"kind": "pose", "ns": 0, "x_m": 1_000_000, "y_m": 0, "yaw_rad": 0}, packet])
    begin, end, heard = model.world.echoes[0]
    assert (begin, end, heard) == (pytest.approx((1.1, 0)), pytest.approx((2.0, 0)), True)
    assert not model.world.echoes[1][2]


def test_a_line_is_told_in_bytes_a_second():
    model = BenchModel({})
    told = {"kind": "link", "source": "host", "up": True, "baud": 9600, "pending": 0}
    model.take({**told, "ns": n * S, "sent": 100 * n, "received": 7 * n} for n in range(4))
    assert (values(model, "sent"), values(model, "heard")) == ([100.0] * 3, [7.0] * 3)


def test_of_several_lines_each_has_its_own_rates():
    model = BenchModel({})
    for n in range(4):
        for line, share in (("simulator", 1), ("stack", 3)):
            told = {"kind": "link", "source": line, "up": True, "ns": n * S, "sent": 100 * n * share}
            model.take([{**told, "received": 7 * n * share}])
    assert [values(model, name) for name in ("simulator sent", "stack sent")] == [[100.0] * 3, [300.0] * 3]
    assert [values(model, name) for name in ("simulator heard", "stack heard")] == [[7.0] * 3, [21.0] * 3]


@given(st.lists(st.floats(allow_nan=True, allow_infinity=True), min_size=1, max_size=20), st.integers(12, 90))
@example([8.98846567431158e307], 12)
@example([1.7976931348623157e308], 12)
@example([-1.7976931348623157e308, 1.7976931348623157e308], 12)
def test_any_figures_are_plotted_within_their_room(figures, width):
    model = BenchModel({})
    for number, value in enumerate(figures):
        model.signals._put("any", "m", number * S // 10, value)
    for height in (2, 5, 12):
        lines = plots_view(model.signals, width, height, 2 * S, chosen=["any"])
        assert len(lines) <= max(height, 3)
        assert max(line.cell_len for line in lines) <= width


def test_figures_are_few_letters():
    figures = [figure(value) for value in (0, -1e-9, -0.1234, 12.34, 1234.5, 2.5e7)]
    assert figures == ["0.00", "0.00", "-0.12", "12.3", "1234", "2.5e+07"]


def test_a_figure_that_is_always_0_stands_on_the_bottom_of_its_scale():
    model = BenchModel({})
    for number in range(20):
        model.signals._put("level", "m", number * S // 10, 0.0)
    lines = [line.plain for line in plots_view(model.signals, 60, 8, 2 * S, chosen=["level"])]
    assert lines[1].split()[0] == "1.00"
    assert lines[-2].split()[0] == "0.00"


def test_a_gap_is_not_drawn_over(expect):
    model = BenchModel({})
    for number in [*range(40), *range(80, 120)]:
        model.signals._put("level", "V", number * S // 10, 3 + math.sin(number / 8))
    expect("plot-gap", [line.plain for line in plots_view(model.signals, 60, 8, 12 * S, chosen=["level"])])


# --- console


def said(model):
    return [(line.source, line.text) for line in model.console.lines]


@given(st.text(st.characters(codec="utf-8", exclude_categories=["Cc", "Zl", "Zp", "Cf"]), max_size=30), st.data())
def test_a_line_is_the_same_however_it_comes(text, data):
    raw = f"one {text}\ntwo\n".encode()
    cut = data.draw(st.integers(0, len(raw)))
    model = BenchModel(BOARD)
    at = {"ns": 1, "kind": "console", "source": "brain.itm0"}
    model.take([{**at, "data": raw[:cut].hex()}, {**at, "data": raw[cut:].hex()}])
    assert said(model)[-1] == ("brain.itm0", "two")
    assert len(said(model)) == 2


def test_a_uart_with_text_is_a_console_and_one_with_frames_is_none():
    model = BenchModel(BOARD)
    sent = {"ns": 1, "kind": "tx"}
    model.take([{**sent, "source": "brain.usart1", "data": b"forward\r\n".hex()}])
    model.take([{**sent, "source": "brain.usart2", "data": b"looks like text".hex()}])
    model.take([{**sent, "source": "brain.usart2", "data": "fafb0300000001"}])
    model.take([{**sent, "source": "client", "data": b"of somebody else".hex()}])
    assert said(model) == [("brain.usart1", "forward")]
    assert [line.plain for line in console_view(model.console, 40, 3)] == ["     0.000 s forward"]


def test_nothing_of_a_console_is_obeyed_by_the_terminal():
    model = BenchModel(BOARD)
    model.take([{"ns": 1, "kind": "console", "source": "brain.itm0", "data": b"\x1b[2Jgone\x07\n".hex()}])
    assert said(model) == [("brain.itm0", "\\x1b[2Jgone\\x07")]


# --- verdicts

PLAN = [
    {"id": "s/a", "suite": "s", "clause_ids": ["A1", "A2"], "levels": ["must", "should"],
     "titles": ["does A1", "does A2"], "missing": []},
    {"id": "s/b", "suite": "s", "clause_ids": ["B1"], "levels": ["must"], "titles": ["does B1"], "missing": []},
    {"id": "s/c", "suite": "s", "clause_ids": ["C1"], "levels": ["must"], "titles": ["does C1"], "missing": ["rays"]},
]  # fmt: skip
TOLD = [
    {"ns": 0, "kind": "case", "source": "journal", "case": "s/a"},
    {"ns": 9, "kind": "verdict", "source": "checker", "verdict": "pass", "cause": ""},
    {"ns": 0, "kind": "case", "source": "journal", "case": "s/b"},
    {"ns": 9, "kind": "verdict", "source": "checker", "verdict": "fail", "cause": "it came 2 s late"},
]


@given(st.integers(0, len(TOLD)))
def test_what_is_known_of_a_run_does_not_depend_on_when_its_plan_comes(cut):
    checks = ChecksModel()
    for event in TOLD[:cut]:
        checks.take(event)
    checks.plan(PLAN)
    for event in TOLD[cut:]:
        checks.take(event)
    assert {row.id: row.state for row in checks.rows.values()} == {
        "A1": "pass", "A2": "pass", "B1": "fail", "C1": "not-applicable",
    }  # fmt: skip
    assert checks.rows["B1"].cause == "it came 2 s late"


def test_a_run_that_ends_before_its_plan_has_come_shows_clauses_and_no_cases():
    """On a busy host the shorter of the two processes may end last."""
    checks = ChecksModel()
    for event in TOLD:
        checks.take(event)
    about = {"suite": "s", "level": "must", "title": "", "cause": ""}
    clauses = [{**about, "id": name, "verdict": verdict} for name, verdict in (("A1", "pass"), ("B1", "fail"))]
    cases = [
        {"id": "s/a", "clause_ids": ["A1"], "verdict": "pass"},
        {"id": "s/b", "clause_ids": ["B1"], "verdict": "fail"},
    ]
    checks.take_report({"cases": cases, "clauses": clauses})
    assert {row.id: row.cases for row in checks.rows.values()} == {"A1": {"s/a": "pass"}, "B1": {"s/b": "fail"}}


def test_a_run_is_shown_while_it_goes_on_and_after(expect):
    checks = ChecksModel()
    checks.plan(PLAN)
    for event in TOLD[:3]:
        checks.take(event)
    going = [line.plain for line in checks_view(checks, 70, 6)]
    checks.take(TOLD[3])
    clause = {
        "id": "B1", "suite": "s", "level": "must", "title": "does B1", "text": "It does B1 within 1 s.",
        "source": "manual 4.2", "verdict": "fail", "cause": "it came 2 s late", "evidence": ["at 3.0 s: nothing"],
        "worst_margin": {"name": "B1 came after", "value": 3.0, "unit": "s", "high": 1.0, "margin": -2.0},
        "reproduce": "hilbench check own -k B1",
    }  # fmt: skip
    checks.take_report({"cases": [], "clauses": [clause], "exit_meaning": "the target violates a clause"})
    after = [line.plain for line in checks_view(checks, 70, 6, chosen="B1")]
    whole = [line.plain for line in clause_view(checks.rows["B1"], 40)]
    expect("checks", [*going, "", *after, "", *whole])


def test_what_a_target_only_says_of_itself_is_marked_before_and_after_the_report():
    checks = ChecksModel()
    checks.plan([{**PLAN[1], "by_own_report": ["duty"]}])
    row = checks.rows["B1"]
    mark = "by its own report: "
    assert f"{mark}does B1" in checks_view(checks, 70, 6)[1].plain
    clause = {"id": "B1", "suite": "s", "level": "must", "title": "does B1", "verdict": "pass", "cause": ""}
    checks.take_report({"cases": [], "clauses": [{**clause, "by_own_report": ["duty"]}]})
    assert f"{mark}does B1" in checks_view(checks, 70, 6)[1].plain
    assert f"{mark}nobody saw duty" in [line.plain for line in clause_view(row, 70)]
    checks.take_report({"cases": [], "clauses": [clause]})
    assert mark not in "".join(line.plain for line in (*checks_view(checks, 70, 6), *clause_view(row, 70)))


def test_a_recording_of_a_run_shows_its_cases():
    model = BenchModel({})
    model.take(TOLD)
    assert {row.id: row.state for row in model.checks.rows.values()} == {"s/a": "pass", "s/b": "fail"}
