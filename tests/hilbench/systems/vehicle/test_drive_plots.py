"""The pictures and the page of `measure.drive_plots`."""

from __future__ import annotations

import re
from pathlib import Path

from hilbench.suites.vehicle_drive import STOP_M
from measure.drive_plots.chart import Panel, chart
from measure.drive_plots.pages import TEMPLATE

DOCS = Path(__file__).parents[4] / "docs"


def test_a_chart_has_its_lines_where_they_belong():
    line = [(0.0, 0.0), (5.0, 10.0), (10.0, 0.0)]
    drawn = chart("title", "x", [0, 5, 10], [Panel(title="y < 11", low=0, high=10, step=5, lines=[(line, "red")])])
    (points,) = re.findall(r'<polyline points="([^"]*)"', drawn)
    first, middle, last = ([float(number) for number in point.split(",")] for point in points.split())
    assert first[1] == last[1] > middle[1]
    assert middle[0] - first[0] == last[0] - middle[0] > 0
    assert "y &lt; 11" in drawn
    assert drawn.count("<rect") == 1


def test_a_band_is_shaded_and_a_line_thinned():
    line = [(x / 1000, 0.5) for x in range(10_001)]
    panel = Panel(title="y", low=0, high=1, step=0.5, lines=[(line, "red")], band=(0.25, 0.75))
    drawn = chart("title", "x", [0, 10], [panel])
    assert drawn.count("<rect") == 2
    (points,) = re.findall(r'<polyline points="([^"]*)"', drawn)
    assert 100 < len(points.split()) < 1000


def test_the_committed_page_is_that_of_the_template_and_its_figures_are_within_the_clauses():
    text = (DOCS / "vehicle-drive.md").read_text(encoding="utf-8")
    fixed = re.split(r"\{[^}]*\}", TEMPLATE.read_text(encoding="utf-8"))
    assert all(part in text for part in fixed)
    (off_m,) = re.findall(r"Farthest off the middle line, root mean square \| ([\d.]+) m", text)
    (half_m,) = re.findall(r"that the lane allows \| ([\d.]+) m", text)
    assert float(off_m) < float(half_m)
    (ideal_m, stop_m) = re.findall(r"v² / \(2·8 m/s²\) \| ([\d.]+) m \| ([\d.]+) m", text)[0]
    assert abs(float(ideal_m) - float(stop_m)) < STOP_M
    for picture in re.findall(r"\(images/([^)]*)\)", text):
        assert (DOCS / "images" / picture).is_file()
