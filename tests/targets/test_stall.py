"""The stall monitor of one wheel."""

from __future__ import annotations

import dataclasses

import pytest

from targets.robots.pioneer.settings import RobotSettings
from targets.robots.pioneer.stall import WheelStall
from tests.each import each

SETTINGS = RobotSettings()
STEP_S = 0.01


def feed(stall: WheelStall, load: float, speed_mm_s: float, duration_s: float, start_s: float = 0.0) -> float | None:
    """Feed for a while; return when the stall was noticed, s."""
    for k in range(round(duration_s / STEP_S)):
        now_s = start_s + k * STEP_S
        stall.update(load, speed_mm_s, round(now_s * 1e9), STEP_S)
        if stall.stalled:
            return now_s
    return None


@each(("load", "speed"), [(0.39, 0.0), (1.0, 100.0), (1.0, -250.0), (0.0, 0.0)])
def test_no_stall(load: float, speed: float) -> None:
    assert feed(WheelStall(SETTINGS), load, speed, 5.0) is None


@each("load", [1.0, 0.8, 0.5])
def test_a_blocked_wheel_stalls_when_the_average_exceeds_the_threshold(load: float) -> None:
    threshold = SETTINGS.stall_pwm / SETTINGS.pwm_max
    expected_s = SETTINGS.stall_average_ms / 1000 * threshold / load
    assert feed(WheelStall(SETTINGS), load, 0.0, 5.0) == pytest.approx(expected_s, abs=2 * STEP_S)


def test_the_average_forgets_what_is_older_than_its_window() -> None:
    stall = WheelStall(SETTINGS)
    for k in range(20):
        assert feed(stall, 1.0, 0.0, 0.1, start_s=k) is None
        assert feed(stall, 0.0, 0.0, 0.6, start_s=k + 0.1) is None


def test_power_comes_back_after_the_stall_time_and_the_average_starts_anew() -> None:
    settings = dataclasses.replace(SETTINGS, stall_wait_ms=300)
    stall = WheelStall(settings)
    noticed_s = feed(stall, 1.0, 0.0, 5.0)
    assert noticed_s is not None
    for k in range(1, 30):
        stall.update(1.0, 0.0, round((noticed_s + k * STEP_S) * 1e9), STEP_S)
        assert stall.stalled
    stall.update(1.0, 0.0, round((noticed_s + 0.3) * 1e9), STEP_S)
    assert not stall.stalled
    again_s = feed(stall, 1.0, 0.0, 5.0, start_s=noticed_s + 0.3 + STEP_S)
    assert again_s == pytest.approx(2 * noticed_s + 0.3, abs=3 * STEP_S)


def test_clear_forgets() -> None:
    stall = WheelStall(SETTINGS)
    feed(stall, 1.0, 0.0, 5.0)
    stall.clear()
    assert not stall.stalled
