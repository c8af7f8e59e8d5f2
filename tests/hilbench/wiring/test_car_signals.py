"""The signals of a world with a car: names, directions and units."""

from __future__ import annotations

from hilbench.wiring.car_signals import CAR_SIGNALS
from targets.parts import Direction


def test_names_directions_and_units():
    taken = {name: signal.unit for name, signal in CAR_SIGNALS.items() if signal.direction is Direction.OUT}
    assert taken == {
        "command_mode": "1",
        "steering_command": "rad",
        "steering_rate_limit": "rad/s",
        "speed_command": "m/s",
        "accel_limit": "m/s2",
        "jerk_limit": "m/s3",
        "throttle": "1",
        "brake": "1",
        "steer": "1",
        "hand_brake": "1",
    }
    assert {name for name, signal in CAR_SIGNALS.items() if signal.by_rays} == {"ray_left", "ray_middle", "ray_right"}
