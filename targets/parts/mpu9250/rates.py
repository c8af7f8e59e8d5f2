"""Bandwidths, delays, rates, scales of the MPU-9250 (RM-MPU-9250A-00 sections 4.4 to 4.9, PS-MPU-9250A-01 section 3).

The tables give the bandwidth and the delay of each filter. Here a filter is a first-order low pass of that bandwidth
and a pure delay for what is then missing (choice): a slow signal comes as late as on silicon, and a fast one is
attenuated less steeply.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass

from targets.parts.mpu9250.registers import Reg

__all__ = ["ACCEL_LSB_PER_G", "GYRO_LSB_PER_DPS", "Filter", "Rates", "filter_of", "rates_of"]

GYRO_LSB_PER_DPS = (131.0, 65.5, 32.8, 16.4)
"""By GYRO_FS_SEL: 250, 500, 1000, 2000 degrees per second (PS section 3.1)."""

ACCEL_LSB_PER_G = (16384, 8192, 4096, 2048)
"""By ACCEL_FS_SEL: 2, 4, 8, 16 g (PS section 3.2)."""

_MS = 1_000_000
_32_KHZ_NS, _8_KHZ_NS, _4_KHZ_NS, _1_KHZ_NS = 31_250, 125_000, 250_000, _MS
_LOW_POWER_NS = 2 * _MS
"""Half a kilohertz at the fastest of the low power rates: 500 Hz / 2**(11 - LPOSC_CLKSEL), which is 0.24 Hz at 0."""
_FASTEST_LOW_POWER = 11


@dataclass(frozen=True, slots=True, kw_only=True)
class Filter:
    """One row of a table.

    Attributes:
        bandwidth_hz: at which a sine has lost 3 dB.
        delay_s: of a slow signal.
    """

    bandwidth_hz: float
    delay_s: float

    @property
    def lag_s(self) -> float:
        """The time constant of a first-order low pass of that bandwidth."""
        return 1 / (2 * math.pi * self.bandwidth_hz)

    @property
    def rest_s(self) -> float:
        """What the low pass alone falls short of the delay."""
        return self.delay_s - self.lag_s


def filter_of(bandwidth_hz: float, delay_ms: float) -> Filter:
    """Return one row."""
    return Filter(bandwidth_hz=bandwidth_hz, delay_s=delay_ms / 1000)


_GYRO_FILTERS = (
    filter_of(250, 0.97),
    filter_of(184, 2.9),
    filter_of(92, 3.9),
    filter_of(41, 5.9),
    filter_of(20, 9.9),
    filter_of(10, 17.85),
    filter_of(5, 33.48),
    filter_of(3600, 0.17),
)
"""By DLPF_CFG, with FCHOICE_B 00 (RM section 4.5)."""

_GYRO_UNFILTERED = {1: filter_of(8800, 0.064), 2: filter_of(3600, 0.11), 3: filter_of(8800, 0.064)}
"""By FCHOICE_B, which is FCHOICE inverted: bit 0 set is FCHOICE x0."""

_ACCEL_FILTERS = (
    filter_of(460, 1.94),
    filter_of(184, 5.80),
    filter_of(92, 7.80),
    filter_of(41, 11.80),
    filter_of(20, 19.80),
    filter_of(10, 35.70),
    filter_of(5, 66.96),
    filter_of(460, 1.94),
)
"""By A_DLPFCFG, with ACCEL_FCHOICE_B 0 (RM section 4.8)."""

_ACCEL_UNFILTERED = filter_of(1130, 0.75)


@dataclass(frozen=True, slots=True, kw_only=True)
class Rates:
    """What the configuration registers make of the signal paths.

    Attributes:
        sample_ns: from one set of measurements to the next.
        accel_ns: from one value of the accelerometer to the next; a faster set repeats it.
        gyro: its filter.
        accel: as above.
    """

    sample_ns: int
    accel_ns: int
    gyro: Filter
    accel: Filter


def rates_of(values: Mapping[int, int], *, gyro_on: bool, low_power: bool) -> Rates:
    """Return the rates and filters that some register values mean.

    Args:
        values: of the configuration registers, by address.
        gyro_on: an axis of the gyroscope is on, and its rate is that of the measurements; else the accelerometer's.
        low_power: the accelerometer wakes up for single samples.
    """
    unfiltered, divider = values[Reg.GYRO_CONFIG] & 3, 1 + values[Reg.SMPLRT_DIV]
    setting, accel_setting = values[Reg.CONFIG] & 7, values[Reg.ACCEL_CONFIG2] & 7
    gyro = _GYRO_UNFILTERED[unfiltered] if unfiltered else _GYRO_FILTERS[setting]
    accel_fast = bool(values[Reg.ACCEL_CONFIG2] & 8)
    accel_ns = _4_KHZ_NS if accel_fast else _1_KHZ_NS
    if low_power:
        sample_ns = _LOW_POWER_NS << max(0, _FASTEST_LOW_POWER - values[Reg.LP_ACCEL_ODR])
    elif not gyro_on:
        sample_ns = accel_ns if accel_fast else accel_ns * divider
    elif unfiltered:
        sample_ns = _32_KHZ_NS
    else:
        sample_ns = _8_KHZ_NS if setting in (0, 7) else _1_KHZ_NS * divider
    accel = _ACCEL_UNFILTERED if accel_fast else _ACCEL_FILTERS[accel_setting]
    return Rates(sample_ns=sample_ns, accel_ns=accel_ns, gyro=gyro, accel=accel)
