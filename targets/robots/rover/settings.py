"""What a rover is set to: every value with its unit and where it comes from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

__all__ = ["PROFILE_NAMES", "RATES", "RoverSettings"]

PROFILE_NAMES = ("documented", "term-doc", "g0", "g2")

RATES = (9600, 19200, 38400, 57600, 115200)
"""Rates that the host's line is used at, in bit/s."""


def _setting(default: Any, unit: str, source: str) -> Any:
    return field(default=default, metadata={"unit": unit, "source": source})


@dataclass(frozen=True, slots=True, kw_only=True)
class RoverSettings:
    """The rover. The defaults are what document and manual promise.

    Raises:
        ValueError: a value makes no rover. The message begins with the name of the setting.
    """

    profile: Literal["documented", "term-doc", "g0", "g2"] = _setting(
        "documented", "", "protocols.pkt.profiles: what was promised, what was shipped"
    )
    defects: tuple[str, ...] = _setting((), "", "names of targets.robots.rover.defects, put into the profile")
    boot_s: float | None = _setting(
        None, "s", "none: of the profile; G2 needs 0.955 s for its sensors (rover_firmware, mpu9250.cpp)"
    )
    wheel_lag_s: float = _setting(0.08, "s", "assumed: time constant of a geared motor and its wheel in the air")
    latitude_deg: float = _setting(-34.6175, "deg", "choice: Buenos Aires, nhorro/ceai2020 example frames")
    longitude_deg: float = _setting(-58.3683, "deg", "choice: as above")
    temperature_c: float = _setting(25.0, "C", "choice")
    field_mgauss: tuple[float, float, float] = _setting(
        (180.0, 0.0, -140.0), "mG", "assumed: 23 uT at Buenos Aires, the needle pointing up in the south"
    )

    def __post_init__(self) -> None:
        """Checks the figures."""
        if self.defects:
            self._check_defects()
        if self.boot_s is not None and not 0 <= self.boot_s <= 60:
            raise ValueError(f"boot_s {self.boot_s} is not 0..60 s")
        if not 0 < self.wheel_lag_s <= 10:
            raise ValueError(f"wheel_lag_s {self.wheel_lag_s} is not above 0 and at most 10 s")

    def _check_defects(self) -> None:
        from targets.robots.rover.defects import DEFECTS  # takes its time

        for name in self.defects:
            if name not in DEFECTS:
                raise ValueError(f"defects has '{name}', which is none; there are {', '.join(DEFECTS)}")
