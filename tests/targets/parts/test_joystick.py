"""The joystick: voltages of the original's calibration, noise, and a switch that bounces."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.stm32.adc_format import code
from targets.parts.joystick import AxisCalibration, Joystick, JoystickMoved, JoystickSettings
from targets.parts.testing import PartBench
from tests.each import each

MS = 1_000_000
X, Y = JoystickSettings().axes


def joystick(**settings) -> PartBench:
    return PartBench(Joystick, JoystickSettings(**settings))


def read(bench) -> tuple[int, int]:
    """What an ideal converter of 16 bits makes of both axes."""
    x, y = (code(bench.wires[name].volts[-1][1], 3.3, 16) for name in ("vrx", "vry"))
    return x, y


def press(bench, level) -> None:
    bench.part.set({"press": level}, bench.now_ns)


@each(
    ("x", "y", "codes"),
    [(0, 0, (33970, 33580)), (1, 1, (65535, 65535)), (-1, -1, (1057, 1062)), (0.5, 0, (49752, 33580))],
)
def test_the_calibration_is_the_original_s(x, y, codes) -> None:
    bench = joystick()
    bench.part.set({"x": x, "y": y}, 0)
    assert read(bench) == pytest.approx(codes, abs=1 if x == 0.5 else 0)


@given(st.integers(0, 65535), st.integers(0, 65535))
def test_every_code_can_be_asked_for(x, y) -> None:
    bench = joystick()
    bench.part.set({"x": X.deflection(x), "y": Y.deflection(y)}, 0)
    assert read(bench) == (x, y)


def test_the_edges_of_the_dead_band_can_be_asked_for() -> None:
    bench = joystick()
    for x, y in ((34470, 34080), (33470, 33080), (34471, 34081), (33469, 33079)):
        bench.part.set({"x": X.deflection(x), "y": Y.deflection(y)}, 0)
        assert read(bench) == (x, y)


def test_an_axis_ends_at_the_supply() -> None:
    assert AxisCalibration(1000, 30000, 60000).code(1.04) == pytest.approx(61200)
    assert X.code(1.04) == 65535
    assert X.code(-1.04) == 0


def test_settings_that_make_no_axis_are_refused() -> None:
    with pytest.raises(ValueError, match=r"^x_zero must lie between x_min and x_max"):
        JoystickSettings(x_zero=100)
    with pytest.raises(ValueError, match=r"^y_max must be at most 65535"):
        JoystickSettings(y_max=65536)


def test_a_wrong_value_moves_nothing() -> None:
    bench = joystick()
    with pytest.raises(ValueError, match=r"^x goes from -1\.04 to 1\.04"):
        bench.part.set({"x": 2, "press": 1}, 0)
    assert bench.events == []
    assert read(bench) == (33970, 33580)
    assert bench.wires["sw"].edges == [(0, None)]


def test_what_a_person_does_is_told() -> None:
    bench = joystick()
    bench.part.set({"x": 0.25}, 0)
    press(bench, 1)
    assert bench.told(JoystickMoved) == [
        JoystickMoved(x=0.25, y=0.0, pressed=False),
        JoystickMoved(x=0.25, y=0.0, pressed=True),
    ]


def test_without_bounce_the_switch_is_a_wire_to_ground() -> None:
    bench = joystick(bounce_ms=0.0)
    bench.run(0.01)
    press(bench, 1)
    bench.run(0.01)
    press(bench, 1)
    press(bench, 0)
    bench.run(0.01)
    assert bench.wires["sw"].edges == [(0, None), (10 * MS, False), (20 * MS, None)]
    assert bench.part.next_deadline_ns() is None


def test_the_contact_bounces_for_no_longer_than_it_may() -> None:
    bench = joystick(bounce_ms=5.0, bounces=6)
    counts = set()
    for _ in range(20):
        for level, settled in ((1, False), (0, None)):
            before, edges = bench.now_ns, bench.wires["sw"].edges
            first = len(edges)
            press(bench, level)
            bench.run(0.05)
            assert edges[first] == (before, settled)
            assert edges[-1][1] is settled
            assert edges[-1][0] <= before + 5 * MS
            assert all(one[1] is not other[1] for one, other in zip(edges[first:], edges[first + 1 :], strict=False))
            counts.add((len(edges) - first - 1) // 2)
    assert counts <= set(range(7))
    assert len(counts) > 3


def test_a_press_while_it_still_bounces_ends_that() -> None:
    bench = joystick(bounce_ms=50.0, bounces=50)
    for step in range(21):
        press(bench, step % 2)
        bench.run(0.001)
    bench.run(0.1)
    assert bench.wires["sw"].driven_at(bench.now_ns) is None
    assert bench.part.next_deadline_ns() is None


def test_the_same_seed_bounces_alike() -> None:
    runs = []
    for _ in range(2):
        bench = joystick(noise_v=0.001)
        press(bench, 1)
        bench.run(0.02)
        runs.append((bench.wires["sw"].edges, bench.wires["vrx"].volts))
    assert runs[0] == runs[1]


def test_noise_is_as_large_as_it_is_set_and_changes_as_often() -> None:
    bench = joystick(noise_v=0.002, noise_period_ms=0.5)
    bench.run(2.0)
    volts = [value for _, value in bench.wires["vry"].volts]
    assert len(volts) == 4001
    mean = sum(volts) / len(volts)
    assert mean == pytest.approx(33580 / 65536 * 3.3, abs=2e-4)
    assert (sum((value - mean) ** 2 for value in volts) / len(volts)) ** 0.5 == pytest.approx(0.002, rel=0.05)
    assert len(joystick().wires["vry"].volts) == 1
