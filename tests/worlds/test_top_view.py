"""Pictures from above: everything that stands, the lane, and every track."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest

from worlds import find_scene
from worlds.above import Sheet, top_view

SVG = "{http://www.w3.org/2000/svg}"
OUTLINE = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5)]
TRACKS = {"one": [(0.0, 0.0), (0.001, 0.0), (1.0, 0.0)], "two & more": [(0.0, 0.0), (0.0, -2.0)]}


def test_the_picture_has_everything_that_stands_and_every_track():
    scene = find_scene("room-with-boxes", 3)
    root = ET.fromstring(top_view(scene, TRACKS, [OUTLINE], Sheet(title="a < b")))
    assert root.find(f"{SVG}title").text == "a < b"
    assert len(root.findall(f"{SVG}polygon")) == len(scene.boxes) + 1
    lines = root.findall(f"{SVG}polyline")
    assert [line.get("points").count(",") for line in lines] == [3, 3]
    ends = [circle.get("cx") for circle in root.findall(f"{SVG}circle")]
    assert float(ends[0]) - float(ends[1]) == pytest.approx(60)
    assert [text.text for text in root.findall(f"{SVG}text")][:2] == ["one", "two & more"]


def test_a_lane_lies_below_everything_and_fits_the_sheet():
    scene = find_scene("test-track")
    root = ET.fromstring(top_view(scene, TRACKS, [OUTLINE], Sheet(title="track", px_per_m=5, bar_m=10)))
    lane, dashes, *rest = root.findall(f"{SVG}polygon")
    assert lane.get("points") == dashes.get("points")
    assert float(lane.get("stroke-width")) == 17.5
    assert len(rest) == 2  # the wall and the car; cones are too small for this scale
    assert len(root.findall(f"{SVG}circle")) == 4 + len(TRACKS)
    _, _, width, height = map(float, root.get("viewBox").split())
    places = [tuple(map(float, point.split(","))) for point in lane.get("points").split()]
    assert all(16 <= x <= width - 16 and 16 <= y <= height - 16 for x, y in places)
    assert "10 m" in [text.text for text in root.findall(f"{SVG}text")]
