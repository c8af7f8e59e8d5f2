"""What differs between the sensors of this family."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Protocol

from targets.parts.mpu9250.rates import Rates, rates_of
from targets.parts.mpu9250.registers import ACCEL_OFFSETS, REGISTERS, Reg, Register

__all__ = ["MPU9250", "Model"]


class _RatesOf(Protocol):
    def __call__(self, values: Mapping[int, int], *, gyro_on: bool, low_power: bool) -> Rates: ...


@dataclass(frozen=True, slots=True, kw_only=True)
class Model:
    """One of them.

    Attributes:
        registers: by address.
        accel_offsets: addresses of the high bytes of the accelerometer's offsets, if it has such registers.
        gyro_offsets: addresses of the high bytes of the gyroscope's.
        rates: returns what configuration registers mean, see `targets.parts.mpu9250.rates.rates_of`.
        fifo_bytes: size of the FIFO.
        gyro_start_ns: from sleep to the first sample of the gyroscope,
        accel_start_ns: and of the accelerometer alone.
        lsb_per_degc: of the thermometer,
        zero_degc: and where it reads 0.
    """

    registers: Mapping[int, Register]
    accel_offsets: tuple[int, ...]
    gyro_offsets: tuple[int, ...]
    rates: _RatesOf
    fifo_bytes: int
    gyro_start_ns: int
    accel_start_ns: int
    lsb_per_degc: float
    zero_degc: float

    def start_ns(self, gyro_on: bool) -> int:
        """Return how long the first sample takes."""
        return self.gyro_start_ns if gyro_on else self.accel_start_ns

    def temperature_lsb(self, degc: float) -> float:
        """Return what the thermometer counts."""
        return (degc - self.zero_degc) * self.lsb_per_degc


MPU9250 = Model(
    registers=REGISTERS,
    accel_offsets=ACCEL_OFFSETS,
    gyro_offsets=(Reg.XG_OFFSET_H, Reg.YG_OFFSET_H, Reg.ZG_OFFSET_H),
    rates=rates_of,
    fifo_bytes=512,
    gyro_start_ns=35_000_000,
    accel_start_ns=20_000_000,
    lsb_per_degc=333.87,
    zero_degc=21.0,
)
"""FIFO: PS-MPU-9250A-01 section 4.17; starts: sections 3.1 and 3.2; thermometer: section 3.4.2."""
