"""What the page of a run draws of a case: state machines with the way taken, margins of timers, speed of a vehicle."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from hilbench.check.page.margins import MOST_TIMERS, margins_of
from hilbench.check.page.speed import speeds_of
from hilbench.check.page.states import MOST_STATES, MOST_TRANSITIONS, machines_of

SVG = "{http://www.w3.org/2000/svg}"


def changed(ns, old, new, *, source="robot", trigger="go"):
    value = {"old": old, "new": new, "trigger": trigger}
    return {"ns": ns, "kind": "event", "source": source, "name": "StateChanged", "value": value}


def pose(ns, x_m):
    return {
        "ns": ns,
        "kind": "pose",
        "source": "world",
        "x_m": round(x_m * 1e6),
        "y_m": 0,
        "z_m": 0,
        "yaw_rad": 0,
    }


def texts(svg):
    return [element.text for element in ET.fromstring(svg).iter(f"{SVG}text")]


def test_each_way_that_was_taken_is_drawn_once_with_its_numbers():
    states = ["A", "B", "A", "B", "B", "C"]
    events = [changed(n * 10**6, *pair) for n, pair in enumerate(pairwise(states))]
    (machine,) = machines_of(events)
    root = ET.fromstring(machine.picture)
    assert len(root.findall(f"{SVG}path")) == 4  # A to B, B to A, B to itself, B to C
    assert texts(machine.picture) == ["1, 3", "2", "4", "5", "A", "B", "C"]
    (last,) = [rect for rect in root.iter(f"{SVG}rect") if rect.get("fill") == "#0072b2"]
    assert [(one.number, one.time_s, one.old, one.new) for one in machine.transitions][4] == (5, "0.004", "B", "C")
    assert last is root.findall(f"{SVG}rect")[-1]


def test_two_sources_are_two_machines_and_only_the_last_transitions_are_listed():
    events = [changed(n, "A", "B") for n in range(MOST_TRANSITIONS + 3)] + [changed(9, "X", "Y", source="host")]
    robot, host = machines_of(events)
    assert (robot.source, len(robot.transitions), robot.left_out, robot.transitions[-1].number) == ("robot", 40, 3, 43)
    assert (host.source, host.left_out) == ("host", 0)
    assert texts(robot.picture)[0] == "1, 2, 3, 4 and 39 more"


def test_too_many_states_are_listed_and_not_drawn():
    (machine,) = machines_of([changed(n, f"S{n}", f"S{n + 1}") for n in range(MOST_STATES)])
    assert machine.picture == ""
    assert len(machine.transitions) == MOST_STATES


json_values = st.recursive(
    st.none() | st.integers() | st.text(), lambda inner: st.dictionaries(st.text(), inner), max_leaves=4
)


@given(st.lists(st.fixed_dictionaries({"kind": st.just("event"), "name": st.just("StateChanged")}, optional={
    "ns": json_values, "source": json_values,
    "value": json_values | st.fixed_dictionaries({"old": json_values, "new": json_values, "trigger": json_values}),
}), max_size=5))  # fmt: skip
def test_whatever_stands_in_a_recording_is_drawn_or_passed_over(events):
    for machine in machines_of(events):
        ET.fromstring(machine.picture)


def test_a_steady_drive_is_a_level_line_at_its_speed():
    svg = speeds_of([pose(n * 10**8, 0.02 * n) for n in range(11)])
    assert "200 mm/s" in texts(svg)
    assert texts(svg)[-2:] == ["0.000 s", "1.000 s"]
    (line,) = ET.fromstring(svg).iter(f"{SVG}polyline")
    points = [point.split(",") for point in line.get("points").split()]
    assert len(points) == 10
    assert {y for _, y in points} == {"12.0"}


def test_who_stands_or_is_not_known_to_be_anywhere_has_no_speed():
    assert speeds_of([]) == ""
    assert speeds_of([pose(0, 1.0)]) == ""
    assert speeds_of([pose(n, 1.0) for n in range(3)]) == ""
    assert speeds_of([pose(0, 0.0), pose(1, 1.0) | {"x_m": "far"}]) == ""
    assert speeds_of([pose(5, 0.0), pose(5, 1.0)]) == ""
    ET.fromstring(speeds_of([pose(5, 0.0), pose(9, 1.0), pose(5, 2.0)]))  # a clock that went back


@given(st.lists(st.tuples(st.integers(0, 10**12), st.floats(-100, 100)), max_size=30))
def test_whenever_and_wherever_it_was_the_picture_is_one(places):
    svg = speeds_of([pose(ns, x_m) for ns, x_m in places])
    if svg:
        ET.fromstring(svg)
        assert "nan" not in svg
        assert "inf" not in svg


MS = 10**6


def margins(points, *, timer="WATCHDOG", source="robot"):
    return {"ns": 9000 * MS, "kind": "margins", "source": source, "timer": timer, "points": points}


def circles(svg):
    return [
        (float(dot.get("cx")), float(dot.get("cy")), dot.get("fill")) for dot in ET.fromstring(svg).iter(f"{SVG}circle")
    ]


def test_a_timer_falls_from_its_span_to_zero_and_is_red_where_it_ran_out():
    case = {"ns": 0, "kind": "case", "source": "journal", "case": "x"}
    points = [[ns * MS, left * MS, 2000 * MS] for ns, left in ((0, 2000), (4500, 1000), (9000, 0))]
    svg = margins_of([case, margins(points)])
    (x1, top, blue), (x2, middle, _), (x3, bottom, red) = circles(svg)
    assert x2 - x1 == x3 - x2
    assert middle - top == bottom - middle > 0
    assert (blue, red) == ("#0072b2", "#c0262d")
    assert texts(svg) == ["robot WATCHDOG, set for 2 s: ran out", "2 s", "0", "0.000 s", "9.000 s"]


def test_of_many_timers_those_that_came_nearest_to_their_end_are_drawn_and_names_are_text():
    events = [margins([[n * MS, n * MS, 100 * MS]], timer=f"<T{n}>") for n in range(1, MOST_TIMERS + 3)]
    said = texts(margins_of(events[::-1]))
    assert [text for text in said if "least" in text] == [
        f"robot <T{n}>, set for 100 ms: least {n} ms left" for n in range(1, MOST_TIMERS + 1)
    ]
    assert said[-1] == "2 more came less near to their end"
    assert margins_of([]) == margins_of([margins([])]) == ""


times = st.integers(0, 2**62 - 1)


@given(st.lists(st.builds(margins, st.lists(st.tuples(times, times, times)), timer=st.text(), source=st.text())))
def test_margins_of_any_size_are_drawn_within_their_plots(events):
    svg = margins_of(events)
    assert bool(svg) is any(event["points"] for event in events)
    if svg:
        height = float(ET.fromstring(svg).get("height"))
        assert all(0 <= x <= 740 and 0 <= y <= height for x, y, _ in circles(svg))
