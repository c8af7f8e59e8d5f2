"""The game pad: what its triggers and stick mean."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.parts.gamepad import Gamepad, GamepadSettings, PadMapping, PadMoved, PadState, c_scale
from targets.parts.testing import PartBench
from tests.each import each

PUBLISHED = PadMapping(trigger_mm_s=500, stick_mrad_s=1700)
BOUNDS = st.integers(-1000, 1000)


@given(st.integers(-1000, 1000), BOUNDS, BOUNDS, BOUNDS, BOUNDS)
def test_scaling_truncates_as_c_does(value, old_low, old_high, new_low, new_high) -> None:
    if old_low == old_high:
        return
    exact = (value - old_low) * (new_high - new_low) / (old_high - old_low)
    assert c_scale(value, (old_low, old_high), (new_low, new_high)) == new_low + math.trunc(exact)


@each(("trigger_mm_s", "speed_m_s"), [(400, 0.4), (500, 0.5)])
def test_a_whole_trigger(trigger_mm_s, speed_m_s) -> None:
    mapping = PadMapping(trigger_mm_s=trigger_mm_s, stick_mrad_s=1700)
    assert mapping.speed_m_s(255, 0) == speed_m_s
    assert mapping.speed_m_s(0, 255) == -speed_m_s
    assert mapping.speed_m_s(255, 255) == 0
    assert mapping.turn_rad_s(0) == 0


def test_the_stick_turns_about_and_is_a_little_lopsided() -> None:
    assert PUBLISHED.turn_rad_s(-128) == 1.70
    assert PUBLISHED.turn_rad_s(127) == -1.68
    assert PUBLISHED.turn_rad_s(1) == -0.01
    assert PUBLISHED.turn_rad_s(-1) == 0.02


@given(st.integers(0, 255), st.integers(0, 255), st.integers(-128, 127))
def test_the_mapping_stays_near_the_straight_line(r2, l2, rx) -> None:
    assert PUBLISHED.speed_m_s(r2, l2) == pytest.approx((r2 - l2) / 255 * 0.5, abs=0.0011)
    assert PUBLISHED.turn_rad_s(rx) == pytest.approx(-rx / 128 * 1.7, abs=0.011)


def test_up_connects_and_down_disconnects() -> None:
    state = PadState(PUBLISHED)
    state.set({"r2": 255})
    assert not state.connected
    state.set({"up": 1})
    state.set({"up": 0})
    assert state.connected
    assert state.velocity == (0.5, 0.0)
    state.set({"down": 1})
    assert not state.connected


def test_it_drives_wheels_only_while_connected() -> None:
    bench = PartBench(Gamepad, GamepadSettings(track_m=0.4), step_ns=4_000_000)
    bench.part.set({"r2": 255, "rx": -128}, 0)
    bench.run(0.01)
    assert bench.quantities_out == {"left": 0, "right": 0}
    assert bench.events == []
    bench.part.set({"up": 1}, bench.now_ns)
    bench.run(0.01)
    assert bench.quantities_out == {"left": pytest.approx(0.5 - 0.34), "right": pytest.approx(0.5 + 0.34)}
    assert bench.wires["connected"].level_at(bench.now_ns)
    bench.part.set({"up": 0, "down": 1}, bench.now_ns)
    bench.run(0.01)
    assert bench.quantities_out == {"left": 0, "right": 0}
    assert not bench.wires["connected"].level_at(bench.now_ns)
    assert bench.told(PadMoved) == [
        PadMoved(connected=True, speed_m_s=0.5, turn_rad_s=1.7),
        PadMoved(connected=False, speed_m_s=0.0, turn_rad_s=0.0),
    ]


def test_a_wrong_value_moves_nothing() -> None:
    bench = PartBench(Gamepad, GamepadSettings())
    with pytest.raises(ValueError, match=r"^rx goes from -128 to 127"):
        bench.part.set({"up": 1, "rx": 128}, 0)
    assert bench.events == []
