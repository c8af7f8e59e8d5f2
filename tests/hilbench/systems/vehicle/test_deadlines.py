"""A small run of the measurement of `measure.deadlines`: right boards are within, wrong ones are not."""

from __future__ import annotations

import functools
from pathlib import Path

import pytest

from measure.deadlines.measure import EVENTS, measure
from measure.deadlines.pages import page, picture
from measure.deadlines.rigs import RIGS, model_rig
from measure.deadlines.spread import spread_of
from protocols.carla.states import DEADLINES
from tests.each import each

DOCS = Path(__file__).parents[4] / "docs"


@functools.cache
def samples_of(profile):
    return run(profile)


def run(profile="hardened", seed=2, *, count=2, **changes):
    with model_rig(profile, seed, **changes) as rig:
        return measure(rig, count)


def off(samples):
    """The names of the events with a time that is more than a tick off what is documented."""
    found = set()
    for name, event in EVENTS.items():
        for sample in samples[name]:
            counted = event.deadline_s is None or abs(sample.deadline_s - event.deadline_s) < 0.001
            seen = event.seen_least_s - 0.001 < sample.seen_s < event.seen_most_s + 0.001
            found |= set() if counted and seen else {name}
    return found


@each("profile", ["hardened", "v0"])
def test_the_models_keep_their_deadlines(profile):
    assert off(samples_of(profile)) == set()


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ({"command_deadline_s": 0.115}, {"commands"}),
        ({"status_deadline_s": 0.105}, {"status", "manual"}),
        ({"manual_pause_s": 0.064}, {"manual"}),
    ],
    ids=["command_deadline_s", "status_deadline_s", "manual_pause_s"],
)
def test_a_deadline_that_is_wrong_by_a_few_milliseconds_is_found(changes, expected):
    assert off(run(**changes)) == expected


def test_the_same_seed_gives_the_same_times_and_another_one_others():
    usual = run(count=1)
    assert run(count=1) == usual
    assert run(count=1, seed=3) != usual


def test_what_a_spread_says():
    spread = spread_of([1.0, 1.2, 1.1, 1.1], 0.01)
    assert (spread.least_s, spread.most_s, spread.mean_s) == (1.0, 1.2, pytest.approx(1.1))
    assert spread.deviation_s == pytest.approx(0.08165, abs=1e-5)
    assert spread.uncertainty_s == pytest.approx(0.08165 + 0.01, abs=1e-5)
    assert spread.within(1.01, 1.19, 0.011)
    assert not spread.within(1.01, 1.19, 0.009)


def test_page_and_picture_have_every_event_and_board():
    samples = samples_of("hardened")
    text, drawn = page({"some board": samples}, 1), picture({"some board": samples})
    for event in EVENTS.values():
        assert f"## {event.name}" in text
        assert event.name.split(", ")[0] in drawn
    assert text.count("| some board | seen |") == len(EVENTS)
    assert "**no**" not in text
    assert drawn.count("<circle") == 2 * len(EVENTS) + 1


def test_the_committed_page_has_the_models_and_all_are_within():
    text = (DOCS / "carla" / "deadlines.md").read_text(encoding="utf-8")
    measured = {line.split(" | ")[0][2:] for line in text.splitlines() if " | seen | " in line}
    assert {"model, hardened", "model, v0"} <= measured <= set(RIGS)
    assert "**no**" not in text
    assert str(round(DEADLINES["command_deadline_s"].value_s * 9e3)) in text
