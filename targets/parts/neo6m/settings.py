"""Which NEO-6M it is, where its antenna stands, and when."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from targets.parts.neo6m.gps_time import gps_of_utc
from targets.parts.settings import check_settings, setting

__all__ = ["Neo6mSettings"]

_DS = "NEO-6 data sheet GPS.G6-HW-09005 table 2"


@dataclass(frozen=True, slots=True, kw_only=True)
class Neo6mSettings:
    """See the module.

    Raises:
        ValueError: a value makes no receiver.
    """

    latitude_deg: float = setting(
        -34.6175,
        "deg",
        "choice: the world's origin is the faculty of engineering in Buenos Aires",
        least=-90,
        greatest=90,
    )
    longitude_deg: float = setting(-58.3683, "deg", "choice: as above", least=-180, greatest=180)
    height_m: float = setting(36.0, "m", "assumed: 20 m above the sea; of the origin above the ellipsoid", least=-500)
    geoid_m: float = setting(16.0, "m", "assumed: height of the sea above the ellipsoid there", least=-110, greatest=90)
    x_axis_bearing_deg: float = setting(90.0, "deg", "choice: the world's x axis points east, its y axis north")
    utc: str = setting("2021-09-10T12:00:00", "", "choice: UTC when bench time is 0")
    leap_seconds: int = setting(18, "s", "IERS Bulletin C: GPS is ahead of UTC since 2017", least=0, greatest=60)
    start: Literal["cold", "warm", "hot"] = setting("cold", "", "choice: what it remembers when it is switched on")
    cold_s: float = setting(27.0, "s", f"{_DS}: time to first fix at -130 dBm", least=0.1)
    warm_s: float = setting(27.0, "s", f"{_DS}", least=0.1)
    hot_s: float = setting(1.0, "s", f"{_DS}; also when satellites come back", least=0.1)
    spread_percent: float = setting(
        10.0, "%", "choice: standard deviation of these times, seeded", least=0, greatest=30
    )
    boot_ms: float = setting(250.0, "ms", "assumed: from power-on to the first text", least=1)
    latency_ms: float = setting(
        60.0, "ms", "assumed: from the moment of a solution to its first byte", least=1, greatest=150
    )
    baud: int = setting(
        9600, "bit/s", "data sheet section 1.7: of its end of the line at start, whatever the link says", least=1
    )
    buffer_s: float = setting(1.0, "s", "choice: a message that would have to wait for longer is dropped", least=0.1)
    accuracy_m: float = setting(2.5, "m", f"{_DS}: circular error probable, under an open sky", least=0)
    correlation_s: float = setting(120.0, "s", "choice: the error wanders with this time constant", least=0.1)
    noise_m: float = setting(0.05, "m rms", "choice: from solution to solution, on each axis", least=0)
    velocity_m_s: float = setting(0.1, "m/s", f"{_DS}: half of the errors are smaller", least=0)
    course_from_m_s: float = setting(
        0.1, "m/s", "ZED-F9T Integration Manual UBX-19005590 section 3.1.7.5: the course is frozen when slower", least=0
    )

    def __post_init__(self) -> None:
        check_settings(self)
        try:
            gps_of_utc(self.utc, self.leap_seconds)
        except ValueError as error:
            raise ValueError(f"utc {error}, not {self.utc!r}") from error
