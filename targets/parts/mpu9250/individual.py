"""What makes one MPU-9250 differ from the next: offsets, sensitivities, and what the factory has written into it.

The factory's self-test codes and sensitivity adjustments are assumed: values as they come out of real parts. The
offset registers of the accelerometer come filled, and cancel an offset of the raw element except for the tolerance.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from targets.parts.mpu9250.registers import ACCEL_OFFSETS, Reg
from targets.parts.mpu9250.settings import Mpu9250Settings
from targets.parts.noise import gaussians, uniforms

__all__ = ["ACCEL_OFFSET_STEPS_PER_G", "Individual", "accel_offset_steps"]

ACCEL_OFFSET_STEPS_PER_G = 1024
"""Steps of 0.98 mg in the upper 15 bits of XA_OFFSET, YA_OFFSET and ZA_OFFSET (RM section 4.38)."""

_GYRO_CODES, _ACCEL_CODES = (180, 220), (90, 120)
"""Self-test codes. The responses that they mean are within PS sections 3.1 and 3.2: over 60 dps, 225 to 675 mg."""
_MAG_CODES = (160, 190)
_TRIM_STEPS = 2000
_SELF_TEST_TOLERANCE = 0.05


@dataclass(frozen=True, slots=True, kw_only=True)
class Individual:
    """One part.

    Attributes:
        factory: values of the registers that the factory has filled, by address.
        zero_g: what the accelerometer adds, in g.
        zero_rate_dps: what the gyroscope adds.
        accel_scale: sensitivity over the nominal one.
        gyro_scale: as above.
        accel_test_g: what the self-test of each axis adds.
        gyro_test_dps: as above.
        mag_codes: ASAX, ASAY, ASAZ.
        zero_field_ut: what the magnetometer adds, in its own axes.
        clock_error: by which part its clock is too fast.
    """

    factory: Mapping[int, int]
    zero_g: tuple[float, ...]
    zero_rate_dps: tuple[float, ...]
    accel_scale: tuple[float, ...]
    gyro_scale: tuple[float, ...]
    accel_test_g: tuple[float, ...]
    gyro_test_dps: tuple[float, ...]
    mag_codes: tuple[int, ...]
    zero_field_ut: tuple[float, ...]
    clock_error: float

    @classmethod
    def of(cls, settings: Mpu9250Settings, seed: int) -> Individual:
        """Draw one."""
        gyro_codes = _whole(seed, "gyro codes", *_GYRO_CODES)
        accel_codes = _whole(seed, "accel codes", *_ACCEL_CODES)
        trims = _whole(seed, "trims", -_TRIM_STEPS, _TRIM_STEPS)
        factory = dict(zip(range(Reg.SELF_TEST_X_GYRO, Reg.SELF_TEST_Z_GYRO + 1), gyro_codes, strict=True))
        factory |= zip(range(Reg.SELF_TEST_X_ACCEL, Reg.SELF_TEST_Z_ACCEL + 1), accel_codes, strict=True)
        for address, steps in zip(ACCEL_OFFSETS, trims, strict=True):
            factory[address], factory[address + 1] = (steps << 1 & 0xFFFF).to_bytes(2, "big")
        percent = settings.sensitivity_percent / 100
        wrong = _within(seed, "self-test", _SELF_TEST_TOLERANCE)
        tests = tuple(1.01 ** (code - 1) for code in (*accel_codes, *gyro_codes))
        xy_g, z_g = settings.zero_g_xy_mg / 1000, settings.zero_g_z_mg / 1000
        zero_g = _within(seed, "zero g", 1.0)
        return cls(
            factory=factory,
            zero_g=(zero_g[0] * xy_g, zero_g[1] * xy_g, zero_g[2] * z_g),
            zero_rate_dps=_within(seed, "zero rate", settings.zero_rate_dps),
            accel_scale=tuple(1 + part for part in _within(seed, "accel scale", percent)),
            gyro_scale=tuple(1 + part for part in _within(seed, "gyro scale", percent)),
            accel_test_g=tuple(2620 / 16384 * test * (1 + part) for test, part in zip(tests[:3], wrong, strict=True)),
            gyro_test_dps=tuple(2620 / 131 * test * (1 + part) for test, part in zip(tests[3:], wrong, strict=True)),
            mag_codes=_whole(seed, "mag codes", *_MAG_CODES),
            zero_field_ut=_within(seed, "zero field", settings.zero_field_ut),
            clock_error=settings.clock_error_percent / 100
            + _within(seed, "clock", settings.clock_tolerance_percent / 100)[0],
        )


def accel_offset_steps(high: int, low: int) -> int:
    """The number -16384..16383 in the two bytes of an offset register; bit 0 is reserved."""
    word = high << 8 | low
    return (word - 0x10000 if word & 0x8000 else word) >> 1


def _whole(seed: int, purpose: str, least: int, greatest: int) -> tuple[int, ...]:
    return tuple(least + int(drawn * (greatest - least + 1)) for drawn in uniforms(seed, purpose, 0)[:3])


def _within(seed: int, purpose: str, tolerance: float) -> tuple[float, ...]:
    return tuple(max(-1.0, min(1.0, drawn / 3)) * tolerance for drawn in gaussians(seed, purpose, 0)[:3])
