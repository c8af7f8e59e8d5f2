from __future__ import annotations

import dataclasses
import math
import xml.etree.ElementTree as ET

import pytest

from tests.each import each
from worlds import find_vehicle, vehicle_names
from worlds.vehicles.model import box_inertia, parameter_table, sphere_inertia, wheel_inertia
from worlds.vehicles.pioneer_2dx import DEFAULTS, LEFT, RIGHT, Pioneer2dxParameters, vehicle
from worlds.vehicles.urdf import to_urdf


def test_every_figure_has_a_unit_and_a_source():
    rows = parameter_table(DEFAULTS)
    assert [row.name for row in rows] == [field.name for field in dataclasses.fields(DEFAULTS)]
    for row in rows:
        assert row.unit
        assert row.source.startswith(("assumed", "reedhedges/AriaCoda params/p2dx.p"))


def test_a_figure_the_user_sets_says_so():
    rows = {row.name: row for row in parameter_table(Pioneer2dxParameters(torque_limit_nm=1.5))}
    assert rows["torque_limit_nm"].value == 1.5
    assert rows["torque_limit_nm"].source == "set by the user, instead of 1"
    assert rows["mass_kg"].source != "set by the user"


def test_the_published_figures():
    assert DEFAULTS.wheel_radius_m == 0.0825
    assert DEFAULTS.track_m == pytest.approx(0.35714, abs=1e-5)
    assert 0.001 / (DEFAULTS.track_m / 2) == pytest.approx(0.0056)  # rad/s per mm/s
    assert DEFAULTS.length_front_m + DEFAULTS.length_rear_m == pytest.approx(0.511)


@each("name", vehicle_names())
def test_inertias_are_possible(name):
    for part in find_vehicle(name).parts:
        a, b, c = sorted(part.inertia_kg_m2)
        assert 0 < a <= b <= c <= a + b + 1e-12


def test_the_parts_weigh_what_the_robot_weighs():
    assert sum(part.mass_kg for part in vehicle().parts) == pytest.approx(9.0)
    assert sum(part.mass_kg for part in vehicle(Pioneer2dxParameters(mass_kg=20.0)).parts) == pytest.approx(20.0)


def test_the_weight_rests_on_wheels_and_caster():
    parts = vehicle().parts
    center = sum(part.mass_kg * part.center_of_mass_m[0] for part in parts) / 9.0
    assert DEFAULTS.caster_x_m < center < 0


def test_urdf_reads_back_bit_for_bit():
    model = vehicle()
    root = ET.fromstring(to_urdf(model))
    links = {link.get("name"): link for link in root.findall("link")}
    joints = {joint.get("name"): joint for joint in root.findall("joint")}
    assert list(links) == [part.name for part in model.parts]
    for part in model.parts:
        assert float(links[part.name].find("inertial/mass").get("value")) == part.mass_kg
        assert len(links[part.name].findall("collision")) == len(part.shapes)
    assert {name for name, joint in joints.items() if joint.get("type") == "continuous"} == {LEFT, RIGHT}
    origin = [float(value) for value in joints[LEFT].find("origin").get("xyz").split()]
    assert origin == [0.0, DEFAULTS.track_m / 2, DEFAULTS.wheel_radius_m]
    assert joints[LEFT].find("axis").get("xyz") == "0.0 1.0 0.0"


def test_textbook_inertias():
    assert box_inertia(12.0, (1.0, 2.0, 3.0)) == pytest.approx((13.0, 10.0, 5.0))
    assert sphere_inertia(1.0, 1.0) == (0.4, 0.4, 0.4)
    assert wheel_inertia(2.0, 1.0, 0.0) == pytest.approx((0.5, 1.0, 0.5))
    assert wheel_inertia(12.0, 0.0, 1.0)[0] == pytest.approx(1.0)
    assert math.isclose(wheel_inertia(1.0, 0.1, 0.02)[0], wheel_inertia(1.0, 0.1, 0.02)[2])
