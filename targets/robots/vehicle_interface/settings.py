"""What a vehicle-interface board is set to: every value with its unit and where it comes from."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

__all__ = ["LINE_BAUD", "PROFILE_NAMES", "SIMULATOR_LINE", "STACK_LINE", "VehicleSettings"]

LINE_BAUD = 921_600
"""Of both lines, in bit/s; as `protocols.carla.BAUD`, which takes its time."""
SIMULATOR_LINE = "usart2"
STACK_LINE = "usart3"

PROFILE_NAMES = ("hardened", "v0", "v1")


def _setting(default: Any, unit: str, source: str) -> Any:
    return field(default=default, metadata={"unit": unit, "source": source})


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleSettings:
    """The board. The defaults are those of our firmware.

    Raises:
        ValueError: a value makes no board. The message begins with the name of the setting.
    """

    profile: Literal["hardened", "v0", "v1"] = _setting(
        "hardened", "", "protocols.carla.profiles: ours, and the firmwares of November 2024 and January 2025"
    )
    defects: tuple[str, ...] = _setting(
        (), "", "names of targets.robots.vehicle_interface.defects, put into the profile"
    )
    boot_s: float | None = _setting(None, "s", "none: of the profile")

    def __post_init__(self) -> None:
        """Checks the figures."""
        if self.defects:
            self._check_defects()
        if self.boot_s is not None and not 0 <= self.boot_s <= 60:
            raise ValueError(f"boot_s {self.boot_s} is not 0..60 s")

    def _check_defects(self) -> None:
        from targets.robots.vehicle_interface.defects import DEFECTS  # takes its time

        for name in self.defects:
            if name not in DEFECTS:
                raise ValueError(f"defects has '{name}', which is none; there are {', '.join(DEFECTS)}")
