"""From what happens to the body to the numbers in the output registers.

The specific force and the rotation rate come in the axes of the body, the field of the earth in those of the world;
the mounting turns them into the sensor's. The magnetometer's x is the accelerometer's y, its y the accelerometer's x,
and its z points the other way (PS-MPU-9250A-01 section 9.1).

Noise is white from sample to sample, of the density times the root of the filter's bandwidth, which is how the data
sheet comes to its total of 0.1 dps at 92 Hz (choice: silicon's is correlated where the filter is slower than the
samples).
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from targets.parts.mpu9250.individual import ACCEL_OFFSET_STEPS_PER_G, Individual, accel_offset_steps
from targets.parts.mpu9250.model import Model
from targets.parts.mpu9250.rates import ACCEL_LSB_PER_G, GYRO_LSB_PER_DPS, Rates
from targets.parts.mpu9250.registers import Reg
from targets.parts.mpu9250.settings import Mpu9250Settings
from targets.parts.noise import gaussians
from targets.parts.track import Track, Vector

__all__ = ["G_M_S2", "Sensing", "signed16"]

G_M_S2 = 9.80665
"""Standard gravity."""

_GYRO_OFFSET_DPS = 4 / GYRO_LSB_PER_DPS[0]
"""What one step of XG_OFFSET adds, whatever the full scale (RM section 4.3)."""

_FORCES, _RATES, _ANGLES = ("ax", "ay", "az"), ("wx", "wy", "wz"), ("roll", "pitch", "yaw")

_NONE = (0.0, 0.0, 0.0)

Rows = tuple[Vector, Vector, Vector]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Setup:
    """What the registers say of one sensor's three axes: counts per unit, what is added, standard deviation."""

    counts: float
    added: Vector
    noise: float


class Sensing:
    """See the module.

    Args:
        model: which of the family it is.
        settings: of the part.
        individual: of the part.
        seed: of its noise.
    """

    def __init__(self, model: Model, settings: Mpu9250Settings, individual: Individual, seed: int) -> None:
        self._model = model
        self._settings = settings
        self._individual = individual
        self._seed = seed
        angles_deg = settings.mount_roll_deg, settings.mount_pitch_deg, settings.mount_yaw_deg
        self._mounting = _rotation(*map(math.radians, angles_deg))
        self._field_ut = _field(settings)
        self._force = Track((0.0, 0.0, G_M_S2))
        self._rate = Track((0.0, 0.0, 0.0))
        self._attitude = Track((0.0, 0.0, 0.0))
        self._accel = self._gyro = _Setup(counts=1, added=(0.0, 0.0, 0.0), noise=0)

    def step(self, from_ns: int, to_ns: int, before: Mapping[str, float], after: Mapping[str, float]) -> None:
        """Take what happens in a physics step; see `Track.follow`."""
        for track, names in ((self._force, _FORCES), (self._rate, _RATES), (self._attitude, _ANGLES)):
            track.follow(from_ns, to_ns, before, after, names)

    def forget(self, before_ns: int) -> None:
        """Forget what was before."""
        for track in (self._force, self._rate, self._attitude):
            track.forget(before_ns)

    def configure(self, values: Mapping[int, int], rates: Rates) -> None:
        """Take the configuration registers."""
        person = self._individual
        self._force.set_filter(rates.accel.lag_s, rates.accel.rest_s)
        self._rate.set_filter(rates.gyro.lag_s, rates.gyro.rest_s)
        tested = _tested(values[Reg.ACCEL_CONFIG], person.accel_test_g)
        trims = [_accel_trim_g(values, address, person.factory) for address in self._model.accel_offsets]
        self._accel = _Setup(
            counts=ACCEL_LSB_PER_G[values[Reg.ACCEL_CONFIG] >> 3 & 3],
            added=_sum(person.zero_g, tested, trims),
            noise=self._settings.accel_noise_ug_rthz * 1e-6 * math.sqrt(rates.accel.bandwidth_hz),
        )
        tested = _tested(values[Reg.GYRO_CONFIG], person.gyro_test_dps)
        offsets = [
            signed16(values[address], values[address + 1]) * _GYRO_OFFSET_DPS for address in self._model.gyro_offsets
        ]
        self._gyro = _Setup(
            counts=GYRO_LSB_PER_DPS[values[Reg.GYRO_CONFIG] >> 3 & 3],
            added=_sum(person.zero_rate_dps, tested, offsets),
            noise=self._settings.gyro_noise_dps_rthz * math.sqrt(rates.gyro.bandwidth_hz),
        )

    def words(self, index: int, at_ns: int, accel_ns: int) -> tuple[int, ...]:
        """Return the seven words of a sample: x, y, z of the accelerometer, temperature, x, y, z of the gyroscope.

        Args:
            index: number of the sample.
            at_ns: its time.
            accel_ns: time of the accelerometer's last value, which may be slower.
        """
        noise = gaussians(self._seed, "motion", index)
        force = self._turned(self._force.at(accel_ns))
        rate = self._turned(self._rate.at(at_ns))
        accel_g = [f / G_M_S2 * scale for f, scale in zip(force, self._individual.accel_scale, strict=True)]
        gyro_dps = [math.degrees(w) * scale for w, scale in zip(rate, self._individual.gyro_scale, strict=True)]
        temperature = self._model.temperature_lsb(self._settings.temperature_degc)
        return (
            *_counted(accel_g, self._accel, noise[:3]),
            _cut(temperature),
            *_counted(gyro_dps, self._gyro, noise[3:6]),
        )

    def field_ut(self, index: int, at_ns: int) -> Vector:
        """Return what the magnetometer measures, in its own axes, in uT."""
        settings = self._settings
        body = _back(_rotation(*self._attitude.unfiltered_at(at_ns)), self._field_ut)
        x, y, z = self._turned(body)
        x, y, z = x + settings.hard_iron_x_ut, y + settings.hard_iron_y_ut, z + settings.hard_iron_z_ut
        noise = gaussians(self._seed, "field", index)
        return tuple(
            value + zero + settings.mag_noise_ut * drawn
            for value, zero, drawn in zip((y, x, -z), self._individual.zero_field_ut, noise[:3], strict=True)
        )

    def _turned(self, body: Vector) -> Vector:
        """A vector of the body in the axes of the sensor."""
        return _back(self._mounting, body)


def signed16(high: int, low: int) -> int:
    """Two bytes as a number -32768..32767."""
    word = high << 8 | low
    return word - 0x10000 if word & 0x8000 else word


def _tested(config: int, responses: Vector) -> list[float]:
    """What the self-test adds: bits 7, 6, 5 excite x, y, z."""
    return [response if config >> (7 - axis) & 1 else 0.0 for axis, response in enumerate(responses)]


def _accel_trim_g(values: Mapping[int, int], address: int, factory: Mapping[int, int]) -> float:
    steps = accel_offset_steps(values[address], values[address + 1])
    return (steps - accel_offset_steps(factory[address], factory[address + 1])) / ACCEL_OFFSET_STEPS_PER_G


def _sum(*vectors: tuple[float, ...] | list[float]) -> Vector:
    return tuple(map(sum, zip(*(vector or _NONE for vector in vectors), strict=True)))


def _counted(values: list[float], setup: _Setup, noise: Vector) -> list[int]:
    return [
        _cut((value + added + setup.noise * drawn) * setup.counts)
        for value, added, drawn in zip(values, setup.added, noise, strict=True)
    ]


def _cut(counts: float) -> int:
    return max(-32768, min(32767, round(counts)))


def _rotation(roll_rad: float, pitch_rad: float, yaw_rad: float) -> Rows:
    """From the turned axes to the fixed ones: about z by yaw, then about the new y by pitch, then about x by roll."""
    cr, sr = math.cos(roll_rad), math.sin(roll_rad)
    cp, sp = math.cos(pitch_rad), math.sin(pitch_rad)
    cy, sy = math.cos(yaw_rad), math.sin(yaw_rad)
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def _back(rows: Rows, vector: Vector) -> Vector:
    """From the fixed axes to the turned ones: the transpose."""
    return tuple(sum(row[axis] * part for row, part in zip(rows, vector, strict=True)) for axis in range(3))


def _field(settings: Mpu9250Settings) -> Vector:
    """The earth's field in the axes of the world, in uT: x has the bearing of the setting, y is to its left, z up."""
    bearing = math.radians(settings.x_axis_bearing_deg)
    north, east = settings.field_north_nt / 1000, settings.field_east_nt / 1000
    along = north * math.cos(bearing) + east * math.sin(bearing)
    aside = north * math.sin(bearing) - east * math.cos(bearing)
    return along, aside, -settings.field_down_nt / 1000
