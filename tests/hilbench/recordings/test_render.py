"""`hilbench render`: the world of a recording at one moment, as a map and as a picture, and where there is none."""

from __future__ import annotations

import importlib.util
import json
import struct
import subprocess
import sys
import xml.etree.ElementTree as ET
import zlib
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.cli import main
from hilbench.errors import HilbenchError
from hilbench.journal import Journal, Recording
from hilbench.recordings.layout import of_case
from hilbench.recordings.moments import moment_of
from tests.each import each
from tests.rigid import MUJOCO
from tests.share import few
from worlds import find_scene, find_vehicle
from worlds.errors import CapabilityError
from worlds.scenes import Box, Scene
from worlds.stage import Stage
from worlds.vehicles.model import BoxShape

S = 1_000_000_000
SVG = "{http://www.w3.org/2000/svg}"
ROOM, ROBOT = find_scene("room-with-boxes", 3), find_vehicle("pioneer-2dx")


def pose(ns, x_m, y_m, yaw_rad=0.0):
    values = {"x_m": round(x_m * 1e6), "y_m": round(y_m * 1e6), "z_m": 0, "yaw_rad": round(yaw_rad * 1e6)}
    return {"ns": ns, "kind": "pose", "source": "world", **values}


def scene(ns=0, scene=ROOM, vehicle=ROBOT):
    return {"ns": ns, "kind": "scene", "source": "world", **Stage.of(scene, vehicle).data()}


def case(name, ns=0):
    return {"ns": ns, "kind": "case", "source": "journal", "case": name}


DRIVE = [scene(), *(pose(tenth * S // 10, tenth * 0.1, 0.0) for tenth in range(1, 21))]


def recording(*events):
    return Recording(header={}, events=tuple(json.loads(json.dumps(events))), problem=None, ended=True)


@pytest.fixture
def journal(tmp_path, monkeypatch):
    """Write a journal of events into the working folder; return its name."""
    monkeypatch.chdir(tmp_path)

    def written(*events, name="run.jsonl"):
        made = Journal(name)
        for event in events:
            about = {key: value for key, value in event.items() if key not in {"kind", "source", "ns"}}
            made.record(event["kind"], event["source"], event["ns"], **about)
        made.close(3 * S)
        return name

    return written


@given(at_ns=st.integers(0, 2 * S))
def test_the_vehicle_stands_where_it_was_recorded_last(at_ns):
    found = moment_of(recording(*DRIVE), at_ns, "x")
    tenths = at_ns * 10 // S
    assert found.ns == tenths * S // 10
    assert found.pose.position_m[0] == pytest.approx(tenths * 0.1)
    assert [x_m for x_m, _ in found.track] == pytest.approx([tenth * 0.1 for tenth in range(tenths + 1)])


def test_each_case_has_a_world_of_its_own_and_its_times_follow_each_other():
    events = [case("a"), *DRIVE, case("b"), scene(0, find_scene("wall")), pose(S // 10, 0.0, 1.0), case("c")]
    assert moment_of(recording(*events), S, "x").stage.scene == ROOM
    second = moment_of(recording(*events[:-1]), None, "x")
    assert (second.case, second.stage.scene.name, second.ns) == ("b", "wall", 2 * S + S // 10)
    assert second.track == ((0.0, 0.0), (0.0, 1.0))
    assert moment_of(recording(*events), None, "x").case == "b"
    with pytest.raises(HilbenchError, match=r"says of no vehicle where it stands at 2\.1 s, in case c"):
        moment_of(recording(*events), 2 * S + S // 10, "x")


def test_a_world_that_was_made_before_its_case_began_is_that_of_the_case():
    """A bench of emulated boards is recorded from power-on, which comes before the case."""
    wall = find_scene("wall")
    one = [scene(0, wall), case("one"), pose(S, 0.5, 0.0), {"ns": 2 * S, "kind": "case-end", "case": "one"}]
    two = [scene(), {"ns": 0, "kind": "pin", "source": "b.PA0", "level": True}, case("two"), pose(S, 0.0, 1.0)]
    whole = recording(*one, *two)
    for name, there, place_m in (("one", wall, (0.5, 0.0)), ("two", ROOM, (0.0, 1.0))):
        found = moment_of(of_case(whole, name, "x"), None, "x")
        assert (found.case, found.stage.scene, found.track[-1]) == (name, there, place_m)
    assert moment_of(whole, None, "x").case == "two"
    assert moment_of(whole, 3 * S, "x").stage.scene == ROOM
    assert moment_of(whole, S, "x").case == "one"
    with pytest.raises(HilbenchError, match="says of no vehicle where it stands"):
        moment_of(recording(*one, case("two"), pose(S, 0.0, 1.0)), 3 * S, "x")


@each("name", ["room-with-boxes", "test-track", "ramp", "empty"])
def test_a_stage_comes_back_from_its_data(name):
    stage = Stage.of(find_scene(name), ROBOT)
    assert Stage.from_data(json.loads(json.dumps(stage.data()))) == stage


def test_a_shape_of_a_class_of_its_own_is_what_it_is_derived_from():
    class Bumper(BoxShape):
        pass

    stage = Stage(scene=ROOM, vehicle="own", shapes=(Bumper(size_m=(1.0, 1.0, 1.0), center_m=(0.0, 0.0, 0.5)),))
    (shape,) = Stage.from_data(stage.data()).shapes
    assert shape == BoxShape(size_m=(1.0, 1.0, 1.0), center_m=(0.0, 0.0, 0.5))


def test_a_map_has_what_stands_there_the_vehicle_and_its_way(journal, capsys):
    name = journal(*DRIVE)
    assert main(["render", name, "--at", "1500ms", "--output", "map.svg"]) == 0
    place = "at 1.500 s: x +1.500 m, y +0.000 m, +0.0 degrees"
    assert capsys.readouterr().out == f"wrote map.svg: pioneer-2dx in room-with-boxes {place}\n"
    root = ET.parse("map.svg").getroot()
    shapes = sum(len(part.shapes) for part in ROBOT.parts)
    assert len(root.findall(f"{SVG}polygon")) == len(ROOM.boxes) + shapes
    assert place in [text.text for text in root.findall(f"{SVG}text")]
    _, _, width, height = map(float, root.get("viewBox").split())
    assert width <= 1280
    assert height == pytest.approx(720, abs=2)


@pytest.mark.parametrize("size", [(600, 200), (4096, 300), (640, 4096)])
@pytest.mark.parametrize("name", ["empty", "test-track", "corridor"])
def test_a_map_keeps_its_size_and_shows_everything(journal, size, name):
    run = journal(scene(0, find_scene(name)), pose(S, 0.1, 3.0), name=f"{name}.jsonl")
    assert main(["render", run, "--size", f"{size[0]}x{size[1]}", "--output", "map.svg"]) == 0
    root = ET.parse("map.svg").getroot()
    _, _, width, height = map(float, root.get("viewBox").split())
    assert width <= size[0] + 2
    assert height <= size[1] + 2
    places = [tuple(map(float, one.split(","))) for shape in root.findall(f"{SVG}polygon")
              for one in shape.get("points").split()]  # fmt: skip
    assert all(0 <= x <= width and 0 <= y <= height for x, y in places)


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        ({"shapes": [{"kind": "cone"}]}, "'cone' is missing or unknown"),
        ({"shapes": [{"kind": []}]}, "Expected `str`, got `array`"),
        ({"vehicle": 7}, "Expected `str`, got `int`"),
        ({"scene": {"name": "x", "boxes": [{"name": "b", "center_m": [1e300, 0, 0], "size_m": [1, 1, 1]}]}}, "beyond"),
        ({"scene": {"name": "x", "lane": {"center_m": [], "width_m": 1, "closed": True}}}, "a lane without points"),
    ],
)
def test_a_damaged_world_is_one_line(journal, capsys, damage, message):
    name = journal(scene() | damage)
    assert main(["render", name, "--output", "map.svg"]) == 3
    assert capsys.readouterr().err.startswith(f"hilbench: {name}: what stands there is damaged: ")
    with pytest.raises(HilbenchError, match=message):
        moment_of(recording(scene() | damage), None, "x")


@each("x_m", [None, "far", 10**40, True])
def test_a_damaged_pose_is_one_line(x_m):
    with pytest.raises(HilbenchError, match="the pose at 5 ns is damaged"):
        moment_of(recording(scene(), pose(5, 0, 0) | {"x_m": x_m}), None, "x")


@pytest.mark.parametrize(
    ("words", "code", "message"),
    [
        (["--at", "1h"], 2, "run.jsonl: ends at 3.000 s"),
        (["--at", "soon"], 2, "'soon'"),
        (["--size", "0x0"], 2, "'0x0' is no size from 600x200 to 4096x4096"),
        (["--size", "9" * 5000 + "x300"], 2, "is no size from"),
        (["--output", "map.gif"], 2, "'map.gif' is neither FILE.svg nor FILE.png"),
        (["--output", "nowhere/map.svg"], 2, "there is no folder"),
        (["--case", "a"], 2, "has no case 'a'"),
    ],
)
def test_what_cannot_be_drawn_is_said_in_one_line(journal, capsys, words, code, message):
    name = journal(*DRIVE)
    assert main(["render", name, *words]) == code
    shown = capsys.readouterr()
    assert message in shown.err
    assert (shown.err.count("\n"), shown.out) == (1, "")


def test_a_recording_without_a_world_says_so(journal, capsys):
    name = journal({"ns": 0, "kind": "tx", "source": "a", "data": "00"})
    assert main(["render", name]) == 2
    assert "says of no vehicle where it stands; --case ID takes" in capsys.readouterr().err


def test_a_part_of_a_journal_says_again_what_stands_there(tmp_path):
    made = Journal(tmp_path / "run.jsonl", max_bytes=100_000)
    made.record("scene", "world", 0, **Stage.of(ROOM, ROBOT).data())
    for tick in range(2000):
        made.record("pose", "world", 1000 * tick, x_m=1_000_000, y_m=0, z_m=0, yaw_rad=0)
        made.flush_step()
    made.close(2_000_000)
    later = Journal.read(tmp_path / "run.jsonl")
    assert [event["kind"] for event in later.events][:2] == ["scene", "pose"]
    assert moment_of(later, None, "x").track[0] == (1.0, 0.0)
    with pytest.raises(HilbenchError, match="says of no vehicle where it stands at 1e-06 s"):
        moment_of(later, 1000, "x")


def test_the_world_around_a_case_is_no_part_of_its_hash():
    hashes = []
    for found in (ROOM, find_scene("wall")):
        made = Journal()
        made.begin_case("a")
        made.record("scene", "world", 0, **Stage.of(found, ROBOT).data())
        hashes.append(made.end_case())
    assert hashes[0] == hashes[1]


def test_without_a_library_to_draw_with_the_map_takes_the_place_of_the_picture(journal, capsys, monkeypatch):
    monkeypatch.setattr("worlds.mujoco_picture.picture", _no_gl)
    name = journal(*DRIVE)
    assert main(["render", name]) == 0
    shown = capsys.readouterr()
    assert (shown.err, shown.out.split(":")[0]) == ("drawn from above: there is no GL\n", "wrote run.svg")
    assert main(["render", name, "--output", "run.png"]) == 3
    assert capsys.readouterr().err == "hilbench: render: there is no GL; a map needs none of it: --output FILE.svg\n"


def _no_gl(*_):
    raise CapabilityError("there is no GL")


@pytest.mark.parametrize("place_m", few([500.0, 0.0], 1, "the gate has a robot far from the origin"))
@pytest.mark.parametrize("physics", [MUJOCO])
def test_a_picture_shows_the_robot_in_its_middle_on_its_floor(journal, physics, place_m):
    if importlib.util.find_spec("OpenGL") is None:
        pytest.skip("PyOpenGL is not installed")
    name = journal(scene(0, Scene(name="far", boxes=(far_box(2000.0),))), pose(0, place_m, 0.0))
    # In a process of its own: MuJoCo decides by its environment, once, how it draws.
    words = [sys.executable, "-m", "hilbench", "render", name, "--size", "640x480", "--output", "run.png"]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    if "there is no GL" in done.stderr:
        pytest.skip(done.stderr)
    assert (done.returncode, done.stderr) == (0, "")
    rows = pixels(640, 480)
    red, _, blue = rows[240][320]
    assert red > 2 * blue
    assert all(min(rows[y][x]) > 120 for x, y in ((5, 5), (634, 5), (5, 474), (634, 474)))


def far_box(x_m):
    return Box(name="far", center_m=(x_m, 0.0, 0.5), size_m=(1.0, 1.0, 1.0))


def pixels(width, height):
    """Return run.png as rows of colours."""
    data = Path("run.png").read_bytes()
    assert struct.unpack(">II", data[16:24]) == (width, height)
    begin = data.index(b"IDAT") + 4
    (length,) = struct.unpack(">I", data[begin - 8 : begin - 4])
    raw = zlib.decompress(data[begin : begin + length])
    lines = [raw[row * (3 * width + 1) + 1 : (row + 1) * (3 * width + 1)] for row in range(height)]
    return [[tuple(line[at : at + 3]) for at in range(0, 3 * width, 3)] for line in lines]


def test_names_that_are_no_text_for_a_terminal_or_for_xml_are_replaced(journal, capsys):
    name = journal({**scene(), "vehicle": "a\x1b[2J\0\n<&"})
    assert main(["render", name, "--output", "map.svg"]) == 0
    assert capsys.readouterr().out.startswith("wrote map.svg: a\ufffd[2J\ufffd\ufffd<& in ")
    assert ET.parse("map.svg").getroot().find(f"{SVG}title").text.startswith("a\ufffd[2J\ufffd\ufffd<& in ")


def test_a_recording_that_was_cut_before_says_so(journal, capsys):
    name = journal(*DRIVE)
    Path(name).write_bytes(Path(name).read_bytes()[:700])
    assert main(["render", name]) == 3
    assert capsys.readouterr().err == f"hilbench: {name}: says of no vehicle where it stands: cut in line 2\n"


def test_a_case_without_a_world_has_not_that_of_the_case_before(tmp_path):
    made = Journal(tmp_path / "run.jsonl", max_bytes=100_000)
    for name in ("with", "without"):
        made.begin_case(name)
        if name == "with":
            made.record("scene", "world", 0, **Stage.of(ROOM, ROBOT).data())
        for tick in range(1000):
            made.record("tx", "client", tick, data="00" * 30)
            made.flush_step()
        made.end_case(1000)
    made.close(1000)
    assert "scene" not in {event["kind"] for event in Journal.read(tmp_path / "run.jsonl").events}


def test_a_scene_that_would_fill_a_part_is_not_said_again(tmp_path):
    made = Journal(tmp_path / "run.jsonl", max_bytes=100_000)
    made.record("scene", "world", 0, text="x" * 60_000)
    for tick in range(2000):
        made.record("tx", "client", tick, data="00" * 30)
        made.flush_step()
    made.close(2000)
    assert len(Journal.read(tmp_path / "run.jsonl.1").events) > 100


def test_two_recordings_are_equal_although_one_says_what_stands_there(journal, capsys):
    old, new = journal(*DRIVE[1:], name="old.jsonl"), journal(*DRIVE, name="new.jsonl")
    assert main(["diff", old, new, "--events"]) == 0
