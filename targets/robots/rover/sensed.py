"""What the inertial sensor of a behavioural rover senses: the rover has no body, so a bench chooses it."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from protocols.pkt import STANDARD_GRAVITY_M_S2

__all__ = ["Rocking", "Sensed"]

_NS_PER_S = 1_000_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Sensed:
    """Along x, y and z of the rover: forward, left, up; level, still and towards magnetic north as it stands.

    Attributes:
        acceleration_m_s2: with gravity, upwards.
        rate_deg_s: of its turn, + counter-clockwise.
        field_mgauss: the earth's.
        temperature_c: of the sensor.
        attitude_wxyz: a quaternion of length 1, its scalar first.
    """

    acceleration_m_s2: tuple[float, float, float] = (0.0, 0.0, STANDARD_GRAVITY_M_S2)
    rate_deg_s: tuple[float, float, float] = (0.0, 0.0, 0.0)
    field_mgauss: tuple[float, float, float]
    temperature_c: float
    attitude_wxyz: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rocking:
    """A slow turn to and fro about one axis of the rover, as a hand does it.

    Attributes:
        axis: 0, 1 or 2: x, y or z.
        sweep_deg: how far it goes to either side (choice).
        period_s: how long it takes there and back (choice).
    """

    axis: int
    sweep_deg: float = 75.0
    period_s: float = 8.0

    def sensed(self, still: Sensed, now_ns: int) -> Sensed:
        """What is sensed at a time, in ns, of what is sensed at rest."""
        phase = math.tau * now_ns / _NS_PER_S / self.period_s
        angle_rad = math.radians(self.sweep_deg) * math.sin(phase)
        rate_deg_s = self.sweep_deg * math.cos(phase) * math.tau / self.period_s
        rates = [rate_deg_s * (number == self.axis) for number in range(3)]
        return replace(
            still,
            acceleration_m_s2=self._turned_back(still.acceleration_m_s2, angle_rad),
            rate_deg_s=(rates[0], rates[1], rates[2]),
            field_mgauss=self._turned_back(still.field_mgauss, angle_rad),
            attitude_wxyz=self._turned_by(still.attitude_wxyz, angle_rad),
        )

    def _turned_back(self, vector: tuple[float, float, float], angle_rad: float) -> tuple[float, float, float]:
        """A vector of the world, along axes that were turned by an angle."""
        cosine, sine = math.cos(angle_rad), math.sin(angle_rad)
        found, ahead, beyond = [*vector], (self.axis + 1) % 3, (self.axis + 2) % 3
        found[ahead] = cosine * vector[ahead] + sine * vector[beyond]
        found[beyond] = cosine * vector[beyond] - sine * vector[ahead]
        return found[0], found[1], found[2]

    def _turned_by(
        self, attitude_wxyz: tuple[float, float, float, float], angle_rad: float
    ) -> tuple[float, float, float, float]:
        """An attitude behind a turn about the axis."""
        cosine, sine = math.cos(angle_rad / 2), math.sin(angle_rad / 2)
        w, *found = attitude_wxyz
        x, y, z = (found[(self.axis + place) % 3] for place in range(3))
        found[self.axis] = x * cosine + w * sine
        found[(self.axis + 1) % 3] = y * cosine + z * sine
        found[(self.axis + 2) % 3] = z * cosine - y * sine
        return w * cosine - x * sine, found[0], found[1], found[2]
