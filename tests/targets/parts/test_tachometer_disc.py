"""Slotted discs: exact edges, the same ones however time is cut, and everything that can go wrong with them."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.parts import Ports
from targets.parts.tachometer_disc import TachometerDisc, TachometerSettings
from targets.parts.testing import Wire
from tests.each import each

STEP_NS = 4_166_667
S = 1_000_000_000


def turned(settings, angle_at, cuts, seed=1):
    """The edges of a disc on a wheel that turns evenly between the cuts, without that of power-on."""
    wire = Wire()
    disc = TachometerDisc(settings, Ports(outputs={"out": wire}), seed=seed)
    disc.power_on(cuts[0])
    for start, end in itertools.pairwise(cuts):
        disc.after_step(start, end, {"angle": angle_at(start)}, {"angle": angle_at(end)})
    disc.wire = wire
    return disc


def steady(speed_rad_s, start_rad=0.0):
    return lambda ns: start_rad + speed_rad_s * ns / S


def steps(seconds):
    return range(0, round(seconds * S), STEP_NS)


def falls(disc):
    return [ns for ns, level in disc.wire.edges[1:] if level is False]


@each("slots", [20, 32, 1])
def test_one_turn_has_a_falling_edge_for_each_slot(slots):
    for speed in (math.tau, -math.tau):
        disc = turned(TachometerSettings(slots=slots), steady(speed, 1e-6), [0, S])
        assert len(falls(disc)) == slots
        assert disc.pulses == slots


def test_forward_a_slot_begins_at_whole_pitches_and_ends_at_its_width():
    """With the phase at 0.75 the first slot begins a quarter of a pitch on; at 1 rev/s a pitch takes 50 ms."""
    disc = turned(TachometerSettings(slot_width=0.4), steady(math.tau), [0, S // 10])
    assert disc.wire.edges[0] == (0, True)
    assert disc.wire.edges[1:] == [(12_500_000, False), (32_500_000, True), (62_500_000, False), (82_500_000, True)]


def test_backward_a_slot_begins_where_it_ends_forward():
    disc = turned(TachometerSettings(slot_width=0.4), steady(-math.tau), [0, S // 10])
    assert disc.wire.edges[1:] == [(17_500_000, False), (37_500_000, True), (67_500_000, False), (87_500_000, True)]


def test_a_wheel_may_stand_in_a_slot():
    assert turned(TachometerSettings(phase=0.25), steady(0.0), [0, 10]).wire.edges == [(0, False)]


@given(
    st.floats(-80, 80),
    st.floats(-10, 10),
    st.lists(st.integers(1, S - 1), max_size=30),
    st.sampled_from([{}, {"extra_pulses": 2}, {"missed": 0.3}, {"spurious_hz": 50.0}, {"slots": 32, "phase": 0.1}]),
)
def test_the_edges_do_not_depend_on_the_cuts(speed, start, cuts, wrong):
    settings = TachometerSettings(**wrong)
    whole = turned(settings, steady(speed, start), [0, *range(S // 10, S, S // 10), S])
    cut = turned(settings, steady(speed, start), sorted({0, S, *cuts, *range(S // 10, S, S // 10)}))
    assert [level for _, level in cut.wire.edges] == [level for _, level in whole.wire.edges]
    times = zip(cut.wire.edges, whole.wire.edges, strict=True)
    assert all(abs(one[0] - other[0]) <= 2 for one, other in times)  # rounding of the angles between the cuts


@given(st.lists(st.floats(-2, 2), min_size=2, max_size=20), st.floats(0.05, 0.95), st.floats(0, 1))
def test_at_each_end_of_a_step_the_level_is_that_of_the_angle(moves, width, phase):
    angles = [0.0, *itertools.accumulate(moves)]
    cuts = range(0, len(angles) * STEP_NS, STEP_NS)
    disc = turned(TachometerSettings(slot_width=width, phase=phase), lambda ns: angles[ns // STEP_NS], list(cuts))
    for ns, angle in zip(cuts, angles, strict=True):
        place = (angle * 20 / math.tau + phase) % 1.0
        if min(abs(place - edge) for edge in (0.0, width, 1.0)) > 1e-9:
            assert disc.wire.level_at(ns) is (place >= width)
    levels = [level for _, level in disc.wire.edges]
    assert all(one is not other for one, other in itertools.pairwise(levels))


@given(st.floats(0.5, 30), st.floats(0, 3))
def test_between_two_falling_edges_the_wheel_turns_a_pitch(speed, start):
    disc = turned(TachometerSettings(), steady(speed, start), list(steps(1.0)))
    pitch_ns = math.tau / 20 / speed * S
    for one, other in itertools.pairwise(ns for ns in falls(disc) if ns > 0):
        assert other - one == pytest.approx(pitch_ns, abs=2)


def test_several_pulses_at_an_edge():
    disc = turned(TachometerSettings(extra_pulses=1), steady(math.tau), [0, S // 10])
    assert disc.wire.edges[1:6] == [
        (12_500_000, False),
        (12_600_000, True),
        (12_700_000, False),
        (37_500_000, True),
        (62_500_000, False),
    ]
    once, seven = (turned(TachometerSettings(extra_pulses=n), steady(10.0), list(steps(2.0))).pulses for n in (0, 7))
    assert seven == 8 * once


def test_pulses_that_have_no_room_are_cut_off_by_the_next_edge():
    settings = TachometerSettings(extra_pulses=100, extra_spacing_us=1000.0)
    disc = turned(settings, steady(math.tau), list(steps(1.0)))
    levels = [level for _, level in disc.wire.edges]
    assert all(one is not other for one, other in itertools.pairwise(levels))
    rises = [ns for ns, level in disc.wire.edges if level and (ns - 37_500_000) % 50_000_000 == 0]
    assert len(rises) >= 10


def test_slots_that_are_not_seen_leave_neither_edge():
    all_seen = turned(TachometerSettings(), steady(20.0), list(steps(5.0)))
    some = turned(TachometerSettings(missed=0.25), steady(20.0), list(steps(5.0)))
    none = turned(TachometerSettings(missed=1.0), steady(20.0), list(steps(5.0)))
    assert set(some.wire.edges) < set(all_seen.wire.edges)
    assert some.pulses / all_seen.pulses == pytest.approx(0.75, abs=0.08)
    assert none.pulses == 0


def test_pulses_out_of_nothing_come_at_their_rate_and_length():
    disc = turned(TachometerSettings(spurious_hz=40.0, spurious_us=30.0), steady(0.0), list(steps(20.0)))
    edges = disc.wire.edges[1:]
    assert len(edges) / 2 / 20.0 == pytest.approx(40.0, rel=0.15)
    assert {end - start for (start, _), (end, _) in zip(edges[::2], edges[1::2], strict=False)} == {30_000}


def test_what_is_random_follows_from_the_seed():
    settings = TachometerSettings(missed=0.5, spurious_hz=30.0)
    one, again, other = (turned(settings, steady(9.0), list(steps(2.0)), seed).wire.edges for seed in (1, 1, 2))
    assert one == again != other


def test_noise_does_not_change_which_slots_are_missed():
    quiet = turned(TachometerSettings(missed=0.5), steady(9.0), list(steps(2.0)))
    noisy = turned(TachometerSettings(missed=0.5, spurious_hz=3.0, spurious_us=1.0), steady(9.0), list(steps(2.0)))
    assert set(quiet.wire.edges) - set(noisy.wire.edges) == set()


def test_a_wheel_that_is_put_elsewhere_or_nowhere():
    angles = [0.0, 1e6, math.nan, math.inf, 0.1, 0.1]
    disc = turned(TachometerSettings(), lambda ns: angles[ns // STEP_NS], list(range(0, 6 * STEP_NS, STEP_NS)))
    assert len(disc.wire.edges) <= 3
    assert disc.wire.level_at(6 * STEP_NS) is ((0.1 * 20 / math.tau + 0.75) % 1.0 >= 0.5)


def test_settings_are_checked():
    with pytest.raises(ValueError, match=r"^missed must be at most 1"):
        TachometerSettings(missed=1.5)
