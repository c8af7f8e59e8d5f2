"""Distance switches: threshold, hysteresis, profiles, when they are read."""

from __future__ import annotations

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.parts.distance_switch import DistanceSwitch, DistanceSwitched, DistanceSwitchSettings
from targets.parts.testing import PartBench
from tests.each import each

STEP_NS = 4_000_000


def _bench(settings, ranges_m) -> PartBench:
    """A switch before which `ranges_m[k]` is measured at tick k."""
    last = len(ranges_m) - 1
    bench = PartBench(
        DistanceSwitch,
        settings,
        quantities=lambda ns: {"range": ranges_m[min(last, ns // STEP_NS)]},
        step_ns=STEP_NS,
    )
    bench.run_to(last * STEP_NS - 1)
    return bench


def _levels(bench, count) -> list[bool]:
    return [bench.wires["out"].level_at(tick * STEP_NS) for tick in range(count)]


@each(
    ("profile", "threshold_m", "expected"),
    [("simulation", 0.5, [True, False, False]), ("robot", 1.0, [True, True, False])],
)
def test_one_centimetre_around_the_threshold(profile, threshold_m, expected) -> None:
    settings = DistanceSwitchSettings(profile=profile)
    assert settings.effective_threshold_m == threshold_m
    found = []
    for range_m in (threshold_m - 0.01, threshold_m, threshold_m + 0.01):
        bench = _bench(settings, [9.0, range_m, range_m])
        found.append(bench.wires["out"].level_at(2 * STEP_NS))
    assert found == expected


def test_a_threshold_of_ones_own_wins() -> None:
    assert DistanceSwitchSettings(profile="robot", threshold_m=4.0).effective_threshold_m == 4.0
    with pytest.raises(ValueError, match=r"^threshold_m must be at least"):
        DistanceSwitchSettings(threshold_m=-1.0)
    with pytest.raises(ValueError, match=r"^profile must be one of"):
        DistanceSwitchSettings(profile="dream")


def test_low_from_the_start_and_written_at_changes_only() -> None:
    bench = _bench(DistanceSwitchSettings(), [math.inf, math.inf, 0.3, 0.2, math.inf, math.inf, 0.4])
    assert bench.wires["out"].edges == [
        (0, False),
        (2 * STEP_NS, True),
        (4 * STEP_NS, False),
        (6 * STEP_NS, True),
    ]
    assert bench.told(DistanceSwitched) == [
        DistanceSwitched(on=True, range_m=0.3, at_ns=2 * STEP_NS),
        DistanceSwitched(on=False, range_m=None, at_ns=4 * STEP_NS),
        DistanceSwitched(on=True, range_m=0.4, at_ns=6 * STEP_NS),
    ]


def test_hysteresis_holds_it_until_farther_out() -> None:
    settings = DistanceSwitchSettings(threshold_m=0.5, hysteresis_m=0.1)
    ranges_m = [9.0, 0.55, 0.49, 0.55, 0.599, 0.61, 0.55, 0.55]
    bench = _bench(settings, ranges_m)
    assert _levels(bench, 7) == [False, False, True, True, True, False, False]


def test_a_period_reads_no_more_often() -> None:
    settings = DistanceSwitchSettings(period_ms=10.0)
    ranges_m = [9.0, 0.1, 9.0, 9.0, 0.1, 0.1, 9.0, 9.0, 9.0, 9.0, 9.0]
    bench = _bench(settings, ranges_m)
    # read at 0, 10 (the range of 8 ms), 20 (that of 20 ms itself), 30 ms (that of 28 ms)
    assert bench.wires["out"].edges == [(0, False), (20_000_000, True), (30_000_000, False)]


@given(st.lists(st.floats(0.0, 2.0) | st.just(math.inf), min_size=2, max_size=30), st.floats(0.0, 0.5))
def test_it_is_the_comparison_with_a_memory(ranges_m, hysteresis_m) -> None:
    bench = _bench(DistanceSwitchSettings(hysteresis_m=hysteresis_m), [9.0, *ranges_m])
    on = False
    for tick, range_m in enumerate(ranges_m, start=1):
        on = range_m < 0.5 + (hysteresis_m if on else 0.0)
        assert bench.wires["out"].level_at(tick * STEP_NS) is on
    levels = [level for _, level in bench.wires["out"].edges]
    assert all(a is not b for a, b in itertools.pairwise(levels))
