"""What the docs say of the car is what it does."""

from __future__ import annotations

import pytest

from measure import car_figures
from measure.car_figures import DOCS, PICTURE, picture, rows
from worlds.car_dynamics import CarDynamics

PAGE = (DOCS / "vehicle-car.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def figures():
    return list(rows())


@pytest.mark.exhaustive("a page whose figures are measured")
def test_the_table_in_the_docs_is_what_comes_out(figures, monkeypatch):
    monkeypatch.setattr(car_figures, "rows", lambda: figures)
    assert car_figures.table() in PAGE, "run python -m measure.car_figures"


@pytest.mark.exhaustive("the figures of a page; the gate has the formulas in test_car_formulas")
def test_no_figure_is_off_by_more_than_a_thousandth_of_its_formula(figures):
    """But for the kinematic bicycle where tyres slip, which the table shows for what it leaves out."""
    for row in figures:
        if "the same" not in row.what:
            assert row.found == pytest.approx(row.expected, rel=1e-3)


def test_what_is_not_modelled_is_in_the_docs():
    for line in CarDynamics.ABSENT:
        assert f"- {line}" in PAGE


def test_the_picture_of_the_track_is_that_of_the_scene():
    assert PICTURE.read_text(encoding="utf-8") == picture(), "run python -m measure.car_figures --picture"
