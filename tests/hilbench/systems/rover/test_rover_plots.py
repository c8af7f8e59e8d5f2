"""How the rover's wheels follow throttles and set points: the record, and the page and pictures made of it."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from hilbench.suites.rover_motion.throttles import ORIGINAL_RPM
from measure.rover_plots.drives import STEPS, course
from measure.rover_plots.pages import page

DOCS = Path(__file__).parents[4] / "docs"
RECORD = json.loads((DOCS / "rover-motion.json").read_text(encoding="utf-8"))


def test_the_page_is_that_of_the_record():
    assert page(RECORD) == (DOCS / "rover-motion.md").read_text(encoding="utf-8")


def test_the_record_has_what_the_page_says_in_words():
    """Within 1 rpm of the original from 0.30 on, slower by 2 to 7 rpm at 0.25."""
    up = {point["throttle"]: point["rpm"] for point in RECORD["up"]}
    off = {throttle: (up[throttle] - high, up[throttle] - low) for throttle, (low, high) in ORIGINAL_RPM.items()}
    assert all(over < 1 and under > -1 for throttle, (over, under) in off.items() if throttle >= 0.3)
    assert -8 < off[0.25][0] < off[0.25][1] < -2
    for point in (*RECORD["up"], *RECORD["down"]):
        if point["throttle"] > 0.24:
            assert point["rpm"] == pytest.approx(point["law_rpm"], abs=2.5)
    power_up, tuned = (RECORD["steps"][f"{name} 30"] for name in ("power-up", "tuned"))
    assert max(power_up["rpm_left"][-50:]) < 0 < min(power_up["rpm_left"][4:10])
    assert tuned["rpm_left"][-1] == pytest.approx(30.0, abs=0.5)
    assert RECORD["steps"].keys() == {step.name for step in STEPS}


@pytest.mark.exhaustive("draws the pictures of a page, twice")
def test_pictures_are_drawn_from_it():
    pytest.importorskip("matplotlib", reason="matplotlib comes with the extra 'plots'")
    from measure.rover_plots.pictures import pictures

    drawn = pictures(RECORD)
    assert {path.name for path in (DOCS / "images").glob("rover-*.png")} == drawn.keys()
    assert all(data.startswith(b"\x89PNG") and len(data) > 20_000 for data in drawn.values())
    assert drawn == pictures(RECORD)


@pytest.mark.exhaustive("a page whose figures are measured")
@pytest.mark.needs_physics
def test_a_drive_is_the_one_of_the_record():
    (held,) = (step for step in STEPS if step.name == "held")
    found, known = course(held), RECORD["steps"]["held"]
    assert found.keys() == known.keys()
    assert found["rpm_left"] == pytest.approx(known["rpm_left"], abs=0.01)
    throttles = [[report["throttle_left"] for report in one["reports"]] for one in (found, known)]
    assert throttles[0] == pytest.approx(throttles[1], abs=1e-3)
