"""What the cases of a vehicle-interface board measure with: steps between frames, one by one and together."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from hilbench.check import Inconclusive, Violation
from hilbench.judging.recorder import recording
from hilbench.suites._vehicle import TICK_S, Vehicle
from protocols.carla import CommandFrame, Mode
from tests.each import each


class Uncertain:
    """A bench all of whose times are so uncertain."""

    def __init__(self, uncertainty_s):
        self._uncertainty_s = uncertainty_s

    def uncertainty_s(self, _since_ns):
        return self._uncertainty_s

    def span(self, first_ns, last_ns, *, unprompted=False):
        del unprompted
        return (last_ns - first_ns) / 1e9, self._uncertainty_s


def judge(steps_s, uncertainty_s):
    """Judge frames that come these steps apart, where 0.1 s is required."""
    starts_s = [sum(steps_s[:count]) for count in range(len(steps_s) + 1)]
    frames = [SimpleNamespace(start_ns=round(start_s * 1e9)) for start_s in starts_s]
    vehicle = object.__new__(Vehicle)
    vehicle.bench = Uncertain(uncertainty_s)
    with recording() as recorded:
        vehicle.require_steps(frames, 0.1, "between frames")
    return len(recorded.unclear)


def test_where_the_bench_is_exact_each_step_counts():
    judge([0.1] * 9, 0.0)
    judge([0.1 + 0.9 * TICK_S] * 9, 0.0)
    with pytest.raises(Violation, match=r"between frames: 0\.103 s"):
        judge([0.1] * 8 + [0.103], 0.0)


def test_where_it_is_not_all_steps_together_still_tell():
    """Each step may be right, for all that the bench knows; nine of them cannot."""
    assert judge([0.1] * 9, 0.005) > 0
    with pytest.raises(Violation, match=r"between frames, 9 together: 0\.945 "):
        judge([0.105] * 9, 0.005)


def test_what_is_wrong_goes_before_what_cannot_be_told():
    with pytest.raises(Violation, match=r"between frames: 0\.2 "):
        judge([0.1, 0.2], 0.005)


def test_one_step_is_no_sum():
    judge([0.1], 0.0)
    judge([], 0.0)


@each(("doubt_s", "outcome"), [(0.0, Violation), (0.002, Inconclusive)])
def test_a_gap_is_judged_as_far_as_the_bench_can_tell(doubt_s, outcome):
    """107.9 ms where 108.9 are required: wrong, or nobody knows."""
    vehicle = object.__new__(Vehicle)
    vehicle.bench = Uncertain(doubt_s)
    first, second = (SimpleNamespace(start_ns=ns) for ns in (0, 107_881_000))
    with pytest.raises(outcome):
        vehicle.require_gap(first, second, 0.1089, 0.1611, "the gap")


@each(
    ("said", "wrong"),
    [
        ({}, False),
        ({"steering": -0.0, "speed": 1 / 65_535}, False),
        ({"steering": 1 / 65_535 / 32}, False),
        ({"steering": -1.0327, "acceleration": 1.0327}, False),
        ({"speed": 3.0, "mode": Mode.AUTOWARE}, False),
        ({"jerk": 1e-38}, True),
        ({"steering_rate": 0.12}, True),
        ({"speed": -0.5}, True),
        ({"speed": 0.5, "acceleration": 0.5}, True),
        ({"steering": 2.0}, True),
        ({"steering": 1.8e-43}, True),
    ],
)
def test_a_frame_of_manual_says_what_a_joystick_can(said, wrong):
    vehicle = object.__new__(Vehicle)
    frame = CommandFrame(**{"mode": Mode.MANUAL, **said})
    vehicle.frames, vehicle.shown = lambda: [SimpleNamespace(packet=frame)], lambda _frames: ()
    if wrong:
        with pytest.raises(Violation, match="what no joystick does"):
            vehicle.require_manual_frames()
    else:
        vehicle.require_manual_frames()
