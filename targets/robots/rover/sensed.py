"""What the inertial sensor of a behavioural rover senses: the rover has no body, so a bench chooses it."""

from __future__ import annotations

from dataclasses import dataclass

from protocols.pkt import STANDARD_GRAVITY_M_S2

__all__ = ["Sensed"]


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
