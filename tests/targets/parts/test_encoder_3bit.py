"""Three-bit encoders: sectors, both forms, both orders, exact times."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.parts.encoder_3bit import SECTOR_RAD, Encoder3Bit, EncoderMoved, EncoderSettings, sector_word
from targets.parts.testing import PartBench
from targets.parts.words import word_of
from tests.each import each

STEP_NS = 4_000_000


def _turned(settings, angle_at, ticks) -> PartBench:
    """An encoder on a wheel whose angle at tick k is `angle_at(k)`; it turns evenly between ticks."""
    bench = PartBench(Encoder3Bit, settings, quantities=lambda ns: {"angle": angle_at(ns / STEP_NS)}, step_ns=STEP_NS)
    bench.run_to(ticks * STEP_NS - 1)
    return bench


def _words(bench) -> list[int]:
    return [event.word for event in bench.told(EncoderMoved)]


def _read(bench, order, ns) -> int:
    return word_of([bench.wires[name].level_at(ns) for name in ("s1", "s2", "s3")], order)


def _as_published(angle_rad) -> int:
    """The plug-in's expression with C's fmod and truncation, and the low three bits of it."""
    return math.trunc(math.fmod(angle_rad, 2 * math.pi) / (math.pi / 4)) & 7


@each("sector", range(8))
def test_a_turn_has_eight_sectors_of_45_degrees(sector) -> None:
    middle_rad = (sector + 0.5) * SECTOR_RAD
    for turns in (-2, 0, 3):
        assert sector_word(middle_rad + turns * 2 * math.pi, "floor") == sector
    assert sector_word(middle_rad, "truncating") == sector


@given(st.floats(-100, 100))
def test_the_truncating_form_is_the_published_expression(angle_rad) -> None:
    near_boundary = abs(angle_rad / SECTOR_RAD - round(angle_rad / SECTOR_RAD)) < 1e-9
    if not near_boundary:
        assert sector_word(angle_rad, "truncating") == _as_published(angle_rad)


def test_one_turn_forward_shows_every_number_once_in_order() -> None:
    bench = _turned(EncoderSettings(), lambda tick: 0.001 + tick * 2 * math.pi / 100, 99)
    assert _words(bench) == [1, 2, 3, 4, 5, 6, 7]


def test_one_turn_backward_in_the_floor_form() -> None:
    bench = _turned(EncoderSettings(), lambda tick: -0.001 - tick * 2 * math.pi / 100, 99)
    assert _words(bench) == [7, 6, 5, 4, 3, 2, 1, 0]


def test_one_turn_backward_in_the_truncating_form() -> None:
    """Sector 0 spans 90 degrees around zero; then 7 down to 1."""
    bench = _turned(EncoderSettings(form="truncating"), lambda tick: 0.4 * SECTOR_RAD - tick * SECTOR_RAD / 10, 85)
    assert _words(bench) == [7, 6, 5, 4, 3, 2, 1, 0]
    first_ns = bench.told(EncoderMoved)[0].at_ns
    assert first_ns == pytest.approx(14 * STEP_NS, abs=2)


@each("speed_rad_s", [0.5, 3.0, -3.0, 27.0, -200.0, 900.0])
def test_boundaries_are_crossed_at_their_exact_time(speed_rad_s) -> None:
    start_rad = 0.3
    bench = _turned(EncoderSettings(), lambda tick: start_rad + speed_rad_s * tick * STEP_NS / 1e9, 50)
    moves = bench.told(EncoderMoved)
    for event in moves:
        sectors = (start_rad + speed_rad_s * event.at_ns / 1e9) / SECTOR_RAD
        assert sectors == pytest.approx(round(sectors), abs=abs(speed_rad_s) * 5e-9)
        entered = round(sectors) if speed_rad_s > 0 else round(sectors) - 1
        assert event.word == entered % 8
    assert len(moves) == abs(math.floor((start_rad + speed_rad_s * 50 * STEP_NS / 1e9) / SECTOR_RAD))


@each(
    ("order", "code", "levels"),
    [
        ("lsb-first", 5, (True, False, True)),
        ("msb-first", 5, (True, False, True)),
        ("lsb-first", 1, (True, False, False)),
        ("msb-first", 1, (False, False, True)),
        ("lsb-first", 4, (False, False, True)),
        ("msb-first", 4, (True, False, False)),
    ],
)
def test_bits_on_the_wires(order, code, levels) -> None:
    bench = _turned(EncoderSettings(bit_order=order), lambda _tick: (code + 0.5) * SECTOR_RAD, 2)
    assert tuple(bench.wires[name].level_at(STEP_NS) for name in ("s1", "s2", "s3")) == levels


def test_the_start_is_shown_as_soon_as_it_is_known() -> None:
    bench = _turned(EncoderSettings(), lambda _tick: 3.5 * SECTOR_RAD, 3)
    assert bench.told(EncoderMoved) == [EncoderMoved(word=3, at_ns=0)]


@given(
    st.lists(st.floats(-30.0, 30.0), min_size=2, max_size=20),
    st.sampled_from(["floor", "truncating"]),
    st.sampled_from(["lsb-first", "msb-first"]),
)
def test_at_every_tick_the_wires_have_the_sector_of_the_angle(angles_rad, form, order) -> None:
    last = len(angles_rad) - 1
    bench = _turned(EncoderSettings(form=form, bit_order=order), lambda tick: angles_rad[min(last, round(tick))], last)
    for tick, angle_rad in enumerate(angles_rad):
        if abs(angle_rad / SECTOR_RAD - round(angle_rad / SECTOR_RAD)) < 1e-9:
            continue  # on a boundary: it may be left in that very nanosecond
        assert _read(bench, order, tick * STEP_NS) == sector_word(angle_rad, form)
    for wire in bench.wires.values():
        levels = [level for _, level in wire.edges]
        assert all(a is not b for a, b in itertools.pairwise(levels))


def test_in_the_floor_form_neighbours_follow_each_other() -> None:
    bench = _turned(EncoderSettings(), lambda tick: 20 * math.sin(tick / 7), 200)
    words = [0, *_words(bench)]
    assert all((b - a) % 8 in (1, 7) for a, b in itertools.pairwise(words))


def test_a_wheel_that_is_put_elsewhere_or_nowhere() -> None:
    angles_rad = [0.1, 1e6, math.nan, math.inf, 2.5 * SECTOR_RAD, 2.5 * SECTOR_RAD]
    bench = _turned(EncoderSettings(), lambda tick: angles_rad[min(5, round(tick))], 6)
    assert _words(bench) == [sector_word(1e6, "floor"), 2]


def test_settings_are_checked() -> None:
    with pytest.raises(ValueError, match=r"^form must be one of floor, truncating"):
        EncoderSettings(form="round")
