from __future__ import annotations

import json
import math
from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from hilbench.journal import Journal
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.follower import Follower
from hilbench.tui.model.frames import LEAST_STEP_NS, FramesModel
from hilbench.tui.model.pins import PinModel
from hilbench.tui.model.rates import Counted
from hilbench.tui.model.stick import HOLD_S, Stick
from hilbench.tui.views.pins import pins_view
from tests.each import each

S = 1_000_000_000
NAMES = st.text(max_size=8)
PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers(-(2**70), 2**70) | st.floats() | NAMES,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(NAMES, inner, max_size=3),
    max_leaves=6,
)
KINDS = [
    "tx", "rx", "machine", "event", "link", "pose", "pin", "pwm", "volts", "fault", "host-pace", "driver", "clock",
    "note", "standing", "scene",
]  # fmt: skip
FIELDS = [
    "data", "state", "visits", "timers", "counters", "name", "value", "up", "x_m", "level", "edges", "pins", "fault",
    "who", "paused", "speed", "driver", "armed", "struck", "outages", "scene", "vehicle", "shapes",
]  # fmt: skip
EVENTS = st.builds(
    lambda kind, source, more: {**more, "ns": 5, "kind": kind, "source": source},
    st.sampled_from(KINDS), st.sampled_from(["client", "host", "brain.PA0", ""]),
    st.dictionaries(st.sampled_from(FIELDS), PLAIN, max_size=5),
)  # fmt: skip


@given(st.lists(EVENTS, max_size=6))
def test_no_event_of_any_shape_breaks_the_model(events):
    model = BenchModel({"live": {"operator": "client", "protocol": "p2os"}})
    model.take(events)
    assert model.ns == (5 if events else 0)


def test_where_the_robot_is_and_what_it_counted(model_of):
    model = model_of("pioneer")
    assert model.ns == 8 * S
    assert model.ended
    client, robot = model.machines["client"], model.machines["robot"]
    assert (client.state, robot.state) == ("OPEN", "OPEN")
    assert (client.came_from, client.trigger) == ("CONFIGURING", "CONFIG")
    assert client.counters["bytes_out"].value > 0
    assert robot.counters["noise"].value + robot.counters["bad_checksums"].value > 0
    assert sum(model.faults.values()) > 0
    assert len(model.world.track) > 50
    assert model.driver.who == "dead man"


def test_the_entries_of_a_state_are_those_of_its_edges(model_of):
    machine = model_of("pioneer").machines["client"]
    assert machine.entries("SYNC1_SENT") == 1
    assert machine.entries("LOST") == 0
    taken = sum(machine.visits.values())
    assert sum(machine.entries(state) for state in machine.states) == taken


def test_what_is_heard_is_what_is_decoded(model_of):
    frames = list(model_of("pioneer").frames.frames)
    sips = [frame for frame in frames if frame.item.name == "Sip"]
    assert len(sips) > 60
    assert all(not frame.sent and frame.good for frame in sips)
    assert {"SYNC0", "PULSE", "VEL"} & {frame.item.name for frame in frames if frame.sent}
    assert [frame.number for frame in frames] == list(range(1, len(frames) + 1))


def test_a_filter_is_words(model_of):
    frames = model_of("pioneer").frames
    sent = frames.matching(">", 1000)
    heard = frames.matching("<", 1000)
    assert len(sent) + len(heard) == len(frames.frames)
    assert all(frame.item.name == "PULSE" for frame in frames.matching("> pulse", 1000))
    assert not [frame for frame in frames.matching("-sip", 1000) if frame.item.name == "Sip"]
    assert [frame.number for frame in frames.matching("", 3)] == [frame.number for frame in list(frames.frames)[-3:]]
    assert frames.matching("!", 1000) == [frame for frame in frames.frames if not frame.good]


def test_equal_lines_of_the_log_are_one(model_of):
    model = BenchModel({})
    struck = {"ns": 1, "kind": "fault", "source": "line", "fault": "noise", "towards": "target"}
    model.take([struck, {**struck, "ns": 2}, {"ns": 3, "kind": "line", "source": "line", "up": False}])
    assert [(line.text, line.count, line.ns) for line in model.log.lines] == [
        ("fault: noise towards target", 2, 2),
        ("line down", 1, 3),
    ]
    assert model.log.errors == 3


def test_a_line_that_goes_down_is_an_outage():
    model = BenchModel({})
    told = {"kind": "link", "source": "host", "baud": 9600, "pending": 0, "sent": 0}
    for ns, up in ((1, True), (2, False), (3, False), (4, True), (5, False)):
        model.take([{**told, "ns": ns, "up": up}])
    assert model.lines["host"].outages == 2


def standing(ns, **more):
    about = {"paused": False, "speed": 1.0, "driver": None, "armed": [], "struck": []}
    return {"ns": ns, "kind": "standing", "source": "bench", **about, **more}


def test_outages_are_counted_also_by_who_comes_late_and_none_before_the_line_was_there():
    model = BenchModel({})
    told = {"kind": "link", "source": "host", "baud": 9600, "pending": 0}
    model.take([{**told, "ns": 0, "up": False}])
    assert model.lines["host"].outages == 0
    model.take([{**told, "ns": 1, "up": True}, standing(1, outages={"host": 3})])
    model.take([{**told, "ns": 2, "up": False}])
    assert model.lines["host"].outages == 4


def test_faults_stay_armed_until_they_are_taken_back(model_of):
    armed = ["noise 0.05 towards target"]
    assert (model_of("rover", 4.4).armed, model_of("rover", 3.1).armed) == (armed, armed)
    assert (model_of("rover", 2.9).armed, model_of("rover").armed) == ([], [])


def test_what_a_console_says_is_read_across_nothing():
    model = BenchModel({})
    model.take([{"ns": 1, "kind": "console", "source": "brain.itm0", "data": b"hello\n".hex()}])
    assert model.log.lines[0].text == "says hello"


# --- rates


def test_a_rate_is_that_of_the_last_two_seconds():
    counted = Counted()
    for second in range(11):
        counted.take(10 * second, second * S)
    assert counted.per_s(10 * S) == 10
    assert counted.per_s(11 * S) == 5
    assert counted.per_s(13 * S) == 0


def test_a_counter_that_begins_anew_has_no_rate_below_zero():
    counted = Counted()
    counted.take(100, 0)
    counted.take(3, S)
    assert counted.per_s(S) == 0
    counted.take(5, 2 * S)
    assert counted.per_s(2 * S) == 2


@given(st.lists(st.tuples(st.integers(0, S), st.integers(0, 100)), max_size=20))
def test_a_rate_is_never_negative_nor_more_than_all(steps):
    counted, ns, value = Counted(), 0, 0
    for after_ns, more in steps:
        ns, value = ns + after_ns, value + more
        counted.take(value, ns)
        assert counted.per_s(ns) >= 0


# --- the stick


def test_a_press_holds_and_runs_out():
    stick = Stick()
    assert stick.press(0, 0.5, 0.0) == (0.5, 0.0)
    assert stick.at(HOLD_S - 0.01) == (0.5, 0.0)
    assert stick.at(HOLD_S) == (0.0, 0.0)


def test_forward_and_then_left_held_is_a_curve():
    stick = Stick()
    stick.press(0, 0.5, 0.0)
    for tenth in range(1, 20):
        assert stick.press(1, 0.5, tenth * 0.4) == (0.5, 0.5)
    assert stick.press(1, 0.5, 100.0) == (0.0, 0.5)
    stick.release()
    assert stick.at(100.0) == (0.0, 0.0)


# --- pins


def test_a_pin_that_goes_to_and_fro_has_a_wave_until_it_rests():
    pin = PinModel(board="brain", pin="PB0")
    for number in range(6):
        pin.edges.append((number * 10, number % 2 == 0))
    assert pin.wave(60) == (20, 10)
    assert pin.wave(50 + 81) is None


def test_a_fast_pin_is_what_its_windows_say():
    model = BenchModel({"live": {"boards": {"brain": {"leds": {"PB0": "LD1"}}}}})
    model.take([{"ns": 1, "kind": "pwm", "source": "brain.PB0", "edges": 40, "period_ns": 50, "high_ns": 10,
                 "in_ns": 100, "level": True}])  # fmt: skip
    pin = model.pins.pins["brain.PB0"]
    assert (pin.light, pin.wave(1), pin.edge_count) == ("LD1", (50, 10), 40)
    model.take([{"ns": 2, "kind": "pwm", "source": "brain.PB0", "edges": 0, "in_ns": 100, "level": False}])
    assert (pin.wave(2), pin.level) == (None, False)


def test_the_voltage_of_a_pin_is_the_one_that_was_told_last():
    model = BenchModel({})
    for ns, volts in ((0, 1.5), (S, 2.25)):
        model.take([{"ns": ns, "kind": "volts", "source": "bench", "pins": {"brain.PF12": [volts, 3.3]}}])
    pin = model.pins.pins["brain.PF12"]
    assert (pin.board, pin.pin, pin.full_v) == ("brain", "PF12", 3.3)
    assert [pin.volts_at(ns) for ns in (-1, 0, S - 1, S, 9 * S)] == [None, 1.5, 1.5, 2.25, 2.25]


@each("told", [[math.nan, 3.3], [math.inf, 3.3], [1.0, 0.0], [1.0, math.nan], [1.0], "1.0", None])
def test_what_is_no_voltage_is_not_taken(told):
    model = BenchModel({})
    model.take([{"ns": 1, "kind": "volts", "source": "bench", "pins": {"brain.PF12": told}}])
    assert model.pins.pins == {}


def test_a_pin_that_is_told_again_is_known_to_who_comes_late():
    early, late = BenchModel({}), BenchModel({})
    begun = [{"ns": ns, "kind": "pin", "source": "brain.PB0", "level": not ns % 2} for ns in range(3)]
    later = [
        standing(1 * S, pins={"brain.PB0": [True, 3, False]}),
        {"ns": 2 * S, "kind": "pin", "source": "brain.PB0", "level": False},
    ]
    early.take([*begun, *later])
    late.take(later)
    pins = [model.pins.pins["brain.PB0"] for model in (early, late)]
    assert [(pin.level, pin.edge_count) for pin in pins] == [(False, 4)] * 2
    assert [len(pin.edges) for pin in pins] == [4, 1]
    assert [pin.known for pin in pins] == [None, (1 * S, True)]
    (before, after) = (pins_view(model.pins, 80, 5, 3 * S)[0].plain[:47] for model in (early, late))
    assert before == after


def test_a_pin_whose_edges_were_passed_over_is_as_it_is_told_again():
    model = BenchModel({})
    model.take([{"ns": 1, "kind": "pwm", "source": "brain.PB0", "edges": 40, "period_ns": 50, "high_ns": 10,
                 "in_ns": 100, "level": True}])  # fmt: skip
    model.take([standing(S, pins={"brain.PB0": [False, 90, False]})])
    pin = model.pins.pins["brain.PB0"]
    assert (pin.level, pin.edge_count, pin.wave(S)) == (False, 90, None)


# --- following a file


def test_a_file_is_followed_while_it_is_written(tmp_path):
    path = tmp_path / "journal.jsonl"
    follower = Follower(path)
    assert follower.news() == []
    journal = Journal(path, {"bench": "b"})
    assert follower.news() == []
    assert follower.header["bench"] == "b"
    journal.record("mark", "x", 7)
    assert follower.news() == []
    journal.flush_step()
    assert [event["ns"] for event in follower.news()] == [7]
    journal.close(9)
    assert [event["kind"] for event in follower.news()] == ["host-end"]
    follower.close()


@given(st.integers(1, 40))
def test_lines_that_come_in_pieces_are_whole(tmp_path_factory, size):
    path = tmp_path_factory.mktemp("pieces") / "journal.jsonl"
    lines = b"".join(json.dumps({"ns": ns, "kind": "k", "source": "ü"}).encode() + b"\n" for ns in range(12))
    follower, seen = Follower(path), []
    with path.open("wb", buffering=0) as file:
        for at in range(0, len(lines), size):
            file.write(lines[at : at + size])
            seen += follower.news()
    follower.close()
    assert [event["ns"] for event in seen] == list(range(12))


def test_nothing_is_lost_when_the_journal_is_rotated(tmp_path):
    path = tmp_path / "journal.jsonl"
    journal = Journal(path, {"bench": "b"}, max_bytes=4000)
    follower, seen = Follower(path), []
    for ns in range(300):
        journal.record("mark", "somebody", ns)
        journal.flush_step()
        if ns % 7 == 0:
            seen += follower.news()
            seen += follower.news()
    journal.close()
    for _ in range(3):
        seen += follower.news()
    follower.close()
    assert (tmp_path / "journal.jsonl.1").exists()
    assert [event["ns"] for event in seen if event["kind"] == "mark"] == list(range(300))


def test_lines_that_are_no_events_are_left_out(tmp_path):
    path = tmp_path / "journal.jsonl"
    path.write_bytes(b'{"ns":1,"kind":"a"}\nnonsense\n[1]\n{"kind":"a"}\n{"ns":"x","kind":"a"}\n{"ns":2,"kind":"b"}\n')
    follower = Follower(path)
    assert [event["ns"] for event in follower.news()] == [1, 2]
    follower.close()


def test_frames_of_a_checker_that_is_the_server_are_read_from_its_side():
    frames = FramesModel({"operator": "server", "protocol": "p2os", "side": "target"})
    pulse = {"ns": 1, "source": "server", "data": "fafb03000000"}
    for way in ("rx", "tx"):
        frames.take({"kind": way, **pulse})
    heard, sent = frames.frames
    assert (heard.item.name, sent.item.name) == ("SYNC0", "SyncEcho")
    assert (heard.regions[2].name, sent.regions[2].name) == ("number", "type")


@each("bench", ["pioneer", "rover", "vehicle"])
def test_of_a_line_each_message_is_read_for_its_figures_once_in_a_while(recordings, bench):
    header, events = recordings[bench]
    frames = FramesModel(header["live"])
    names, times = set(), {}
    for event in events:
        if event["kind"] in {"tx", "rx"}:
            for frame in frames.take(event):
                assert not frame.sent
                names.add((frame.line, frame.item.name))
                sort = frames._decoders[event["source"], False].sort(frame._found)
                times.setdefault((frame.line, sort), []).append(frame.ns)
    assert names == {(frame.line, frame.item.name) for frame in frames.frames if not frame.sent and frame.good}
    assert all(later - earlier >= LEAST_STEP_NS for told in times.values() for earlier, later in pairwise(told))


def test_a_follower_passes_over_what_is_old_and_reads_whole_events_behind_it(tmp_path):
    path = tmp_path / "j.jsonl"
    lines = [json.dumps({"ns": ns, "kind": "mark", "source": "x", "text": "é" * ns}) for ns in range(100)]
    path.write_text("\n".join(['{"kind":"journal","part":0}', *lines, ""]))
    follower = Follower(path)
    assert (follower.waiting, follower.pass_over(0)) == (0, 0)
    (first, *_) = follower.news()
    assert first["ns"] == 0
    with path.open("a") as journal:
        journal.write("\n".join([*lines, ""]))
    size = follower.waiting
    assert follower.pass_over(1000) == size - 1000
    assert follower.waiting == 1000
    found = [event["ns"] for event in follower.news()]
    assert found
    assert found == list(range(100))[-len(found) :]
    assert follower.pass_over(1000) == 0
    follower.close()
