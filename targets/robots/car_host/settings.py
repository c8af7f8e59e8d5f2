"""What a car host is set to: every value with its unit and where it comes from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

__all__ = ["PROFILE_NAMES", "CarHostSettings"]

PROFILE_NAMES = ("hardened", "v0", "v1")


def _setting(default: Any, unit: str, source: str) -> Any:
    return field(default=default, metadata={"unit": unit, "source": source})


@dataclass(frozen=True, slots=True, kw_only=True)
class CarHostSettings:
    """The simulator's side. The defaults are those of our own bridge.

    Raises:
        ValueError: a value makes no host. The message begins with the name of the setting.
    """

    profile: Literal["hardened", "v0", "v1"] = _setting(
        "hardened", "", "protocols.carla.profiles: ours, and the bridge that goes with either firmware"
    )
    defects: tuple[str, ...] = _setting((), "", "names of targets.robots.car_host.DEFECTS, put into the profile")
    signs: Literal["profile", "original", "ros"] = _setting(
        "profile",
        "",
        "of lateral speed and heading rate in a status: those of the profile, which are ros, + left, in hardened "
        "(choice) and original, + right, else; or one of them "
        "(LMA-FEM-UNICAMP/Carla-Autoware-Bridge: heading_rate = -yaw rate)",
    )
    status_hz: float = _setting(
        20.0, "Hz", "LMA-FEM-UNICAMP/Carla-Autoware-Bridge: the simulator's steps, fixed_delta_seconds 0.05"
    )

    def __post_init__(self) -> None:
        """Checks the figures."""
        if self.defects:
            self._check_defects()
        if not 1 <= self.status_hz <= 1000:
            raise ValueError(f"status_hz {self.status_hz} is not 1..1000 Hz")

    def _check_defects(self) -> None:
        from targets.robots.car_host.behaviour import DEFECTS  # takes its time

        for name in self.defects:
            if name not in DEFECTS:
                raise ValueError(f"defects has '{name}', which is none; there are {', '.join(DEFECTS)}")
