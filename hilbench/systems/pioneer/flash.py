"""The FLASH of a virtual robot by the names that CONFIG has for what is in it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

from targets.robots.pioneer import RobotSettings
from targets.robots.pioneer.sonar import ARRAY

__all__ = ["with_figures"]

_NAMES: Mapping[str, str] = MappingProxyType(
    {
        "rot_vel_top_deg_s": "rotation_top_deg_s",
        "trans_vel_top_mm_s": "translation_top_mm_s",
        "rot_acc_top_deg_s2": "rotation_acceleration_top_deg_s2",
        "trans_acc_top_mm_s2": "translation_acceleration_top_mm_s2",
        "pwm_max": "pwm_max",
        "sip_cycle_ms": "sip_cycle_ms",
        "aux1_baud": "aux1_baud",
        "gripper": "gripper_fitted",
        "low_battery_dv": "low_battery_dv",
        "revcount": "encoder_ticks_per_half_turn",
        "watchdog_ms": "watchdog_ms",
        "p2mpacs": "motor_packets",
        "stall_pwm": "stall_pwm",
        "stall_count_ms": "stall_wait_ms",
        "joy_vel_mm_s": "joystick_mm_s",
        "joy_rot_vel_deg_s": "joystick_deg_s",
    }
)
"""Figure of CONFIG, setting of the robot."""

_ARRAYS = ("front_sonar", "rear_sonar")


def with_figures(settings: RobotSettings, figures: Mapping[str, int]) -> RobotSettings:
    """Return settings with some figures of CONFIG as given; the two of the sonar go together.

    Raises:
        KeyError: a figure is not one of FLASH, or none that the model has.
    """
    arrays = [figures[name] for name in _ARRAYS if name in figures]
    fitted: dict[str, Any] = {_NAMES[name]: value for name, value in figures.items() if name not in _ARRAYS}
    if "gripper_fitted" in fitted:
        fitted["gripper_fitted"] = bool(fitted["gripper_fitted"])
    if arrays:
        discs = [range(array * ARRAY, (array + 1) * ARRAY) for array, there in enumerate(arrays) if there]
        fitted["sonar_discs"] = tuple(disc for array in discs for disc in array)
    return replace(settings, **fitted)
