"""What is sent: payloads of random bytes, and payloads as a rover has them."""

from __future__ import annotations

import math
import random
import struct
from collections.abc import Callable, Iterator, Mapping

from protocols.pkt import (
    GeneralReport,
    GpsReport,
    ImuReport,
    MotionReport,
    MotorSpeeds,
    MotorThrottles,
    Schema,
    encode_command,
    encode_report,
)

__all__ = ["STRUCTURED", "random_payloads"]

ACCEL_G_PER_LSB = 2 / 32768
"""MPU-9250 at 2 g (PS-MPU-9250A-01, section 3.2)."""
GYRO_DPS_PER_LSB = 250 / 32768
"""At 250 degrees/s (section 3.1)."""
MAG_MG_PER_LSB = 1.5
"""AK8963 at 16 bits: 0.15 uT (section 3.3)."""


def random_payloads(size: int, chance: random.Random) -> Iterator[bytes]:
    """Payloads of independent bytes, each as likely as any other, for ever."""
    while True:
        yield chance.randbytes(size)


def random_imu(chance: random.Random) -> Iterator[bytes]:
    """0x82 with its head, and 14 floats of random bits."""
    while True:
        yield b"\x82\x03\0\0" + chance.randbytes(56)


def _float32(value: float) -> float:
    return float(struct.unpack("<f", struct.pack("<f", value))[0])


def _imu(chance: random.Random, moving: float) -> bytes:
    """0x82 of a sensor whose readings are whole steps, in the units of G2."""

    def steps(middle: float, spread: float, size: float) -> float:
        return round(chance.gauss(middle, spread) / size) * size

    tilt = moving * chance.uniform(-0.3, 0.3)
    half = tilt / 2
    return encode_report(
        ImuReport(
            validity=3,
            acceleration=(
                steps(math.sin(tilt), 0.004 + 0.2 * moving, ACCEL_G_PER_LSB),
                steps(0.01, 0.004 + 0.2 * moving, ACCEL_G_PER_LSB),
                steps(math.cos(tilt), 0.004 + 0.2 * moving, ACCEL_G_PER_LSB),
            ),
            rate_deg_s=tuple(steps(0.5, 0.1 + 30 * moving, GYRO_DPS_PER_LSB) for _ in range(3)),  # type: ignore[arg-type]
            field_mgauss=tuple(steps(mean, 4 + 40 * moving, MAG_MG_PER_LSB) for mean in (180.0, 5.0, -140.0)),  # type: ignore[arg-type]
            temperature_c=round(chance.gauss(1300, 20)) / 333.87 + 21,
            quaternion=(math.cos(half), 0.0, math.sin(half), _float32(chance.gauss(0, 0.002))),
        )
    )


def imu_still(chance: random.Random) -> Iterator[bytes]:
    """0x82 of a rover at rest."""
    while True:
        yield _imu(chance, 0.0)


def imu_moving(chance: random.Random) -> Iterator[bytes]:
    """0x82 of a rover that drives over bumps."""
    while True:
        yield _imu(chance, 1.0)


def motion(chance: random.Random) -> Iterator[bytes]:
    """0x83 of a rover that drives: speeds by whole microseconds between slots, counts that grow."""
    ticks = [0, 0, 0, 0]
    while True:
        rpm = [60e6 / (20 * round(chance.uniform(21_000, 31_000))) for _ in range(4)]
        ticks = [count + round(one / 3 / 4) for count, one in zip(ticks, rpm, strict=True)]
        throttle = round(chance.uniform(0.23, 0.4), 3)
        yield encode_report(
            MotionReport(rpm=tuple(rpm), ticks=tuple(ticks), throttles=(throttle, throttle))  # type: ignore[arg-type]
        )


def general(_chance: random.Random) -> Iterator[bytes]:
    """0x80 after LED_ON, with each count in turn."""
    while True:
        for accepted in range(256):
            yield encode_report(GeneralReport(accepted=accepted, last_opcode=1))


def gps(chance: random.Random) -> Iterator[bytes]:
    """0x84 within 100 m of a place in Buenos Aires, in degrees as a receiver has them."""
    while True:
        latitude, longitude = (round(middle + chance.uniform(-1e-3, 1e-3), 6) for middle in (-34.6037, -58.3816))
        yield encode_report(GpsReport(first_deg=longitude, second_deg=latitude))


def throttles(_chance: random.Random) -> Iterator[bytes]:
    """0x03 of the last schema with both throttles the same, in steps of 0.001; without its length, which is 0A."""
    while True:
        for step in range(-1000, 1001):
            yield encode_command(MotorThrottles(a=step / 1000, b=step / 1000))


def speeds(_chance: random.Random) -> Iterator[bytes]:
    """0x03 of the first schema with both speeds the same, each in turn."""
    while True:
        for speed in range(-255, 256):
            yield encode_command(MotorSpeeds(a=speed, b=speed), Schema.V1)


STRUCTURED: Mapping[str, tuple[str, Callable[[random.Random], Iterator[bytes]]]] = {
    "0x82, random floats": ("14 floats of random bits behind the head", random_imu),
    "0x82, still sensor": ("readings in whole steps of an MPU-9250, in g and deg/s (assumed noise)", imu_still),
    "0x82, moving": ("the same on a rover that shakes and turns (assumed)", imu_moving),
    "0x83, driving": ("speeds by whole microseconds, counts that grow (assumed)", motion),
    "0x80, every count": ("ACC from 0 to 255 after LED_ON", general),
    "0x84, one place": ("degrees with six digits, within 100 m", gps),
    "0x03, throttles": ("both the same, -1 to 1 in steps of 0.001; its length byte, itself 0A, left out", throttles),
    "0x03, first schema": ("both speeds the same, -255 to 255", speeds),
}
"""What a rover or its host says: what varies, and the payloads."""
