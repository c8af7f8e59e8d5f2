"""What a rover does that is not said on its line; beside these it reports the events of its connection."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["LedSwitched", "MotorsCommanded", "RoverEvent"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LedSwitched:
    """The test LED."""

    lit: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorsCommanded:
    """What a command or a lost link made of the motors; what the speed controllers do is not told.

    Attributes:
        throttles: left and right pair.
        setpoints_rpm: left and right pair.
        pid: the speed controllers set the throttles.
    """

    throttles: tuple[float, float]
    setpoints_rpm: tuple[float, float]
    pid: bool


RoverEvent = LedSwitched | MotorsCommanded
