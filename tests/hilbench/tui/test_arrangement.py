"""Panes in columns: they fill the room, keep their least size, and one that grows takes it from its neighbour."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from hilbench.plugins.dashboard import Dashboard
from hilbench.systems.rover.dashboard import DASHBOARD as ROVER
from hilbench.systems.vehicle.dashboard import DASHBOARD as VEHICLE
from hilbench.tui.model.arrangement import LEAST_COLUMNS, LEAST_ROWS, arrangement_of
from hilbench.tui.model.dashboards import BOARD, ROBOT
from tests.each import each

ARRANGED = {
    one.kind: (arrangement_of(one, wide=True), arrangement_of(one, wide=False))
    for one in (ROBOT, BOARD, ROVER, VEHICLE)
}
PANES = sorted(ARRANGED["robot"][0].names)
SIZES = {"width": st.integers(60, 100), "height": st.integers(20, 40)}


@each("kind", ARRANGED)
def test_every_kind_has_every_pane_once(kind):
    from hilbench.tui import panes

    assert sorted(panes.PANES) == PANES
    for arrangement in ARRANGED[kind]:
        assert sorted(arrangement.names) == PANES


def test_a_pane_that_a_dashboard_does_not_name_comes_last_and_one_that_there_is_not_is_left_out():
    own = Dashboard(kind="own", wide=((1, (("world", 1), ("of another version", 3))),), narrow=("world",))
    for wide in (True, False):
        arrangement = arrangement_of(own, wide=wide)
        assert arrangement.names[0] == "world"
        assert sorted(arrangement.names) == PANES


@given(kind=st.sampled_from(sorted(ARRANGED)), shown=st.sets(st.sampled_from(PANES), min_size=1), **SIZES)
def test_panes_fill_the_room_and_nothing_twice(kind, shown, width, height):
    boxes = ARRANGED[kind][0].boxes(shown, width, height)
    assert boxes.keys() == shown
    cells = [
        (x, y)
        for box in boxes.values()
        for x in range(box.x, box.x + box.width)
        for y in range(box.y, box.y + box.height)
    ]
    assert len(cells) == len(set(cells)) == width * height


@given(
    kind=st.sampled_from(sorted(ARRANGED)), name=st.sampled_from(PANES),
    dx=st.integers(-12, 12), dy=st.integers(-6, 6),
)  # fmt: skip
def test_a_pane_grows_by_as_much_as_its_neighbour_can_spare(kind, name, dx, dy):
    before, shown = ARRANGED[kind][0], set(PANES)
    after = before.resized(shown, 200, 60, name, dx=dx, dy=dy)
    was, now = before.boxes(shown, 200, 60), after.boxes(shown, 200, 60)
    assert now[name].width == was[name].width + dx
    assert (now[name].height - was[name].height) * dy >= 0
    assert min(box.width for box in now.values()) >= LEAST_COLUMNS
    assert min(box.height for box in now.values()) >= min(LEAST_ROWS, *(box.height for box in was.values()))
    cells = {(x, y) for box in now.values() for x in range(box.x, box.x + box.width) for y in _rows(box)}
    assert len(cells) == sum(box.width * box.height for box in now.values()) == 200 * 60


def _rows(box):
    return range(box.y, box.y + box.height)


def test_the_lower_border_of_a_band_moves_for_all_of_its_columns():
    before, shown = ARRANGED["robot"][0], {"link", "world", "frames", "log"}
    after = before.resized(shown, 200, 60, "world", dx=0, dy=4)
    was, now = (one.boxes(shown, 200, 60) for one in (before, after))
    assert [now[name].height - was[name].height for name in ("link", "world", "frames", "log")] == [4, 4, -4, -4]


@each(
    ("height", "room", "seen"),
    [
        (24, 3, ["world", "frames", "plots"]),
        (50, 5, ["world", "frames", "plots", "link", "log"]),
    ],
)
def test_on_a_narrow_screen_frames_have_all_of_the_width_below_the_first_pane(height, room, seen):
    narrow = ARRANGED["robot"][1]
    assert narrow.seen(PANES, room) == seen
    boxes = narrow.boxes(seen, 80, height)
    assert (boxes["frames"].width, boxes["frames"].y) == (80, boxes["world"].height)
    assert boxes["plots"].x == boxes["world"].width


def test_a_pane_that_is_not_seen_or_not_there_changes_nothing():
    arrangement = ARRANGED["robot"][0]
    for name in ("pins", "nothing"):
        assert arrangement.resized({"link", "world"}, 200, 60, name, dx=5, dy=5) == arrangement
    assert arrangement.moved("nothing", columns=1) == arrangement


def test_panes_are_moved_and_hidden():
    arrangement = ARRANGED["robot"][0].moved("log", columns=-3).moved("log", places=-5)
    assert arrangement.columns[1].names[0] == "log"
    assert sorted(arrangement.names) == PANES
    hidden = arrangement.toggled("log")
    assert "log" not in hidden.seen(PANES, 11)
    assert hidden.toggled("log") == arrangement
    assert ARRANGED["robot"][1].seen({"frames", "log", "link"}, 2) == ["frames", "link"]
