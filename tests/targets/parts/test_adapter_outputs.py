"""What the adapter puts on its wires: obstacle bits and encoder numbers, as published and otherwise."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols.p2os import Pose, Sip, SonarReading
from targets.parts.p2os_adapter import DistanceBits, EncoderWords, P2osAdapterSettings
from targets.parts.p2os_adapter.outputs import published_words
from tests.each import each

RANGE_UNIT_MM = 0.268
DISTANCE_UNIT_MM = 0.84


def _sonars(*ranges_m) -> Sip:
    return Sip(
        sonars=tuple(
            SonarReading(number=number, range_raw=round(range_m * 1000 / RANGE_UNIT_MM))
            for number, range_m in enumerate(ranges_m)
            if range_m is not None
        )
    )


def _at(x_m, y_m=0.0, heading_rad=0.0) -> Sip:
    return Sip(
        x_raw=round(x_m * 1000 / DISTANCE_UNIT_MM) & 0x7FFF,
        y_raw=round(y_m * 1000 / DISTANCE_UNIT_MM) & 0x7FFF,
        th_raw=round(heading_rad * 2048 / math.pi),
    )


def _shown(make_adapter, sip, **settings):
    adapter = make_adapter(**settings)
    adapter.connect()
    adapter.robot.sip = sip
    adapter.run(0.5)
    return adapter


def test_six_bits_dd1_forced_low_dd7_and_dd8_not_driven(make_adapter) -> None:
    adapter = _shown(make_adapter, _sonars(*[0.5] * 8))
    assert adapter.distances() == [False, True, True, True, True, True, None, None]
    assert adapter.told(DistanceBits) == [DistanceBits(bits=0b111110)]


def test_dd1_not_forced(make_adapter) -> None:
    adapter = _shown(make_adapter, _sonars(*[0.5] * 8), dd1_forced_low=False)
    assert adapter.distances() == [True] * 6 + [None] * 2


def test_dd7_and_dd8_driven(make_adapter) -> None:
    adapter = _shown(make_adapter, _sonars(*[0.5] * 8), dd7_8_driven=True)
    assert adapter.distances() == [False] + [True] * 7


@each("number", range(1, 8))
def test_each_wire_has_the_sonar_before_it(make_adapter, number) -> None:
    ranges_m = [3.0] * 8
    ranges_m[number] = 0.4
    adapter = _shown(make_adapter, _sonars(*ranges_m), dd7_8_driven=True)
    assert [bool(level) for level in adapter.distances()] == [index == number for index in range(8)]


@each(
    ("sense", "threshold_m", "expected"),
    [
        ("near", 1.0, [True, True, False]),
        ("near", 4.0, [True, True, False]),
        ("far", 4.0, [False, False, True]),
    ],
)
def test_around_the_threshold_in_every_profile(make_adapter, sense, threshold_m, expected) -> None:
    """One centimetre below, at, and above; 2024-12-17, 2024-12-08, and the inverted one before."""
    found = []
    for range_m in (threshold_m - 0.01, threshold_m, threshold_m + 0.01):
        adapter = _shown(make_adapter, _sonars(None, range_m), distance_sense=sense, distance_threshold_m=threshold_m)
        found.append(adapter.level("dd2"))
    assert found == expected


def test_readings_of_other_discs_stay(make_adapter) -> None:
    adapter = _shown(make_adapter, _sonars(None, 0.5))
    adapter.robot.sip = _sonars(None, None, 0.5)
    adapter.run(0.2)
    adapter.robot.sip = Sip()
    adapter.run(0.2)
    assert adapter.distances()[:6] == [False, True, True, False, False, False]
    adapter.robot.sip = _sonars(None, 8.576)
    adapter.run(0.2)
    assert adapter.distances()[:6] == [False, False, True, False, False, False]


def test_a_robot_with_many_discs(make_adapter) -> None:
    sip = Sip(sonars=tuple(SonarReading(number=number, range_raw=100) for number in (1, 8, 15, 31, 255)))
    adapter = _shown(make_adapter, sip, dd7_8_driven=True)
    assert [bool(level) for level in adapter.distances()] == [False, True] + [False] * 6


@each(
    ("x_m", "y_m", "words"),
    [
        (0.0, 0.0, (0, 0)),
        (0.013, 0.0, (1, 1)),  # 0.13 rad of a wheel of 0.1 m: the second eighth
        (0.05, 0.0, (4, 4)),
        (0.0999, 0.0, (7, 7)),
        (0.1001, 0.0, (0, 0)),
        (0.05, 0.05, (6, 5)),  # d 0.0707, b 45 degrees: -1.2564 and 2.6706; the fractions cut: -2, 5
    ],
)
def test_published_numbers(x_m, y_m, words) -> None:
    assert published_words(Pose(x_mm=x_m * 1000, y_mm=y_m * 1000), P2osAdapterSettings()) == words


@given(st.floats(-5000, 5000), st.floats(-5000, 5000))
def test_published_numbers_are_the_c_expression(x_mm, y_mm) -> None:
    """As static_cast<int>(fmod(position, 1.0) * 8) % 8, then + 8 and % 8 again, with C's remainder."""
    x_m, y_m = x_mm / 1000, y_mm / 1000
    distance_m, bearing_rad = math.hypot(x_m, y_m), math.atan2(y_m, x_m)
    expected = []
    for sign in (-1, 1):
        position = (distance_m + sign * bearing_rad * 0.5 / 2) / 0.1
        code = int(math.fmod(int(math.fmod(position, 1.0) * 8), 8))
        expected.append((code + 8) % 8)
    found = published_words(Pose(x_mm=x_mm, y_mm=y_mm), P2osAdapterSettings())
    assert all((a - b) % 8 in (0, 1, 7) for a, b in zip(found, expected, strict=True))
    assert found == tuple(expected) or x_mm * y_mm != 0


def test_other_sizes_in_the_published_form() -> None:
    settings = P2osAdapterSettings(encoder_radius_m=0.2, encoder_base_m=0.0)
    assert published_words(Pose(x_mm=100, y_mm=0.0), settings) == (4, 4)


@each(("order", "levels"), [("msb-first", [False, False, True]), ("lsb-first", [True, False, False])])
def test_order_of_the_encoder_bits(make_adapter, order, levels) -> None:
    """Number 1: the published code has s3 high, Fig. 22 of the thesis s1."""
    adapter = _shown(make_adapter, _at(0.0185), encoder_order=order)
    assert adapter.encoders(order) == (1, 1)
    assert [adapter.level(f"e1_s{bit}") for bit in (1, 2, 3)] == levels
    assert [adapter.level(f"e2_s{bit}") for bit in (1, 2, 3)] == levels
    assert adapter.told(EncoderWords) == [EncoderWords(left=1, right=1)]


def test_wheel_form_follows_both_wheels(make_adapter) -> None:
    """Straight on for one sector of the wheels and a half, then a turn on the spot."""
    adapter = make_adapter(encoder_form="wheel", encoder_order="lsb-first")
    adapter.connect()
    adapter.run(0.3)
    sector_m = 0.0825 * math.pi / 4
    adapter.robot.sip = _at(1.5 * sector_m)
    adapter.run(0.2)
    assert adapter.encoders("lsb-first") == (1, 1)
    adapter.robot.sip = _at(1.5 * sector_m, heading_rad=sector_m / (0.35714 / 2))
    adapter.run(0.2)
    assert adapter.encoders("lsb-first") == (0, 2)
    adapter.robot.sip = _at(1.5 * sector_m, heading_rad=-1.0 * sector_m / (0.35714 / 2))
    adapter.run(0.2)
    assert adapter.encoders("lsb-first") == (2, 0)


@given(st.lists(st.tuples(st.floats(-200, 200), st.floats(-0.4, 0.4)), max_size=20))
def test_wheel_form_on_arcs(steps) -> None:
    """Chords and turns of a differential drive come back as the ways of its wheels."""
    from targets.parts.p2os_adapter.outputs import EncoderWires
    from targets.parts.testing import Wire

    wires = EncoderWires(P2osAdapterSettings(encoder_form="wheel"), [Wire()] * 3, [Wire()] * 3, lambda _event: None)
    x_mm = y_mm = heading_rad = left_mm = right_mm = 0.0
    for chord_mm, turn_rad in steps:
        x_mm += chord_mm * math.cos(heading_rad + turn_rad / 2)
        y_mm += chord_mm * math.sin(heading_rad + turn_rad / 2)
        heading_rad += turn_rad
        left_mm += chord_mm - turn_rad * 1000 / 5.6
        right_mm += chord_mm + turn_rad * 1000 / 5.6
        wires.update(Pose(x_mm=x_mm, y_mm=y_mm, heading_rad=heading_rad), 0)
    assert wires._way_m == (pytest.approx(left_mm / 1000, abs=1e-9), pytest.approx(right_mm / 1000, abs=1e-9))


def test_poses_before_the_origin_was_set_do_not_count(make_adapter, bare_robot) -> None:
    robot = bare_robot()
    robot.sip = _at(3.0185)
    adapter = make_adapter(robot)
    adapter.put("p2dx_con", True)
    adapter.run(1.25)  # in session, SETO has gone out
    robot.sip = _at(0.0)
    adapter.run(1.0)
    assert adapter.told(EncoderWords) == []
