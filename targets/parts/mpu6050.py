"""The MPU-6050 as a part on an I2C bus: 3 axes of acceleration and 3 of rotation.

Sources: RM-MPU-6000A-00 rev. 4.2 (register map), PS-MPU-6000A-00 rev. 3.4 (data sheet). What it has in common with its
successor is `targets.parts.mpu9250`; here are its registers, rates and scales. It sleeps after power-on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from types import MappingProxyType

from targets.parts.mpu9250.individual import Individual
from targets.parts.mpu9250.inertial import InertialPart, motion_quantities
from targets.parts.mpu9250.model import Model
from targets.parts.mpu9250.rates import Rates, filter_of
from targets.parts.mpu9250.registers import REGISTERS, Reg, Register
from targets.parts.mpu9250.settings import InertialSettings, Mpu9250Settings
from targets.parts.noise import uniforms
from targets.parts.part import Ports
from targets.parts.settings import check_settings, setting

__all__ = ["MPU6050", "Mpu6050", "Mpu6050Settings"]

_PS = "PS-MPU-6000A-00"
_MS = 1_000_000
_SELF_TEST_X, _SELF_TEST_A = 0x0D, 0x10
_TEST_CODES = (8, 22)
_TEST_TOLERANCE = 0.05

_GYRO_FILTERS = tuple(
    filter_of(hz, ms) for hz, ms in ((256, 0.98), (188, 1.9), (98, 2.8), (42, 4.8), (20, 8.3), (10, 13.4), (5, 18.6))
)
_ACCEL_FILTERS = tuple(
    filter_of(hz, ms) for hz, ms in ((260, 0.62), (184, 2.0), (94, 3.0), (44, 4.9), (21, 8.5), (10, 13.8), (5, 19.0))
)
"""By DLPF_CFG (RM section 4.3). It gives no delay of 260 Hz: here it is that of a first-order low pass (choice)."""

_WAKE_NS = (800 * _MS, 200 * _MS, 50 * _MS, 25 * _MS)
"""By LP_WAKE_CTRL: 1.25, 5, 20, 40 Hz (RM section 4.29)."""


def _rates(values: Mapping[int, int], *, gyro_on: bool, low_power: bool) -> Rates:  # noqa: ARG001
    """See `targets.parts.mpu9250.rates.rates_of`; the gyroscope's rate is that of all samples (RM section 4.2).

    Choice: the reserved setting 7 of the filter is as 0.
    """
    setting = values[Reg.CONFIG] & 7
    unfiltered = setting in (0, 7)
    row = 0 if unfiltered else setting
    sample_ns = (_MS // 8 if unfiltered else _MS) * (1 + values[Reg.SMPLRT_DIV])
    if low_power:
        sample_ns = _WAKE_NS[values[Reg.PWR_MGMT_2] >> 6]
    return Rates(sample_ns=sample_ns, accel_ns=_MS, gyro=_GYRO_FILTERS[row], accel=_ACCEL_FILTERS[row])


def _registers() -> Mapping[int, Register]:
    there = {
        address: register
        for address, register in REGISTERS.items()
        if Reg.SMPLRT_DIV <= address <= Reg.ACCEL_CONFIG
        or Reg.FIFO_EN <= address <= Reg.SIGNAL_PATH_RESET
        or Reg.USER_CTRL <= address <= Reg.WHO_AM_I
    }
    there |= {
        _SELF_TEST_X: Register(name="SELF_TEST_X"),
        _SELF_TEST_X + 1: Register(name="SELF_TEST_Y"),
        _SELF_TEST_X + 2: Register(name="SELF_TEST_Z"),
        _SELF_TEST_A: Register(name="SELF_TEST_A"),
        Reg.CONFIG: Register(name="CONFIG", writable=0x3F),
        Reg.GYRO_CONFIG: Register(name="GYRO_CONFIG", writable=0xF8),
        Reg.INT_ENABLE: Register(name="INT_ENABLE", writable=0x19),
        Reg.PWR_MGMT_1: Register(name="PWR_MGMT_1", reset=0x40, writable=0x6F, acts=0x80),
        Reg.PWR_MGMT_2: Register(name="PWR_MGMT_2"),
        Reg.WHO_AM_I: Register(name="WHO_AM_I", reset=0x68, writable=0),
    }
    return MappingProxyType(dict(sorted(there.items())))


MPU6050 = Model(
    registers=_registers(),
    accel_offsets=(),
    gyro_offsets=(),
    rates=_rates,
    fifo_bytes=1024,
    gyro_start_ns=30 * _MS,
    accel_start_ns=30 * _MS,
    lsb_per_degc=340.0,
    zero_degc=36.53,
)
"""FIFO: PS section 7.17; start: 6.1, of the accelerometer alone the same (choice); thermometer: RM section 4.18."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mpu6050Settings(InertialSettings):
    """Which one it is, and how it is mounted. What is seeded is drawn as for the MPU-9250.

    Raises:
        ValueError: a value makes no sensor.
    """

    ad0: bool = setting(False, "", f"{_PS} section 6.4: AD0 low is address 0x68, high 0x69")
    ready_ms: float = setting(20.0, "ms", f"{_PS} section 6.3, typical: no acknowledge after power-on before", least=0)
    clock_tolerance_percent: float = setting(
        1.0, "%", f"{_PS} section 6.6: with the PLL of the gyroscope, seeded", least=0, greatest=5
    )
    accel_noise_ug_rthz: float = setting(400.0, "ug/rtHz", f"{_PS} section 6.2", least=0)
    gyro_noise_dps_rthz: float = setting(0.005, "dps/rtHz", f"{_PS} section 6.1", least=0)
    zero_g_xy_mg: float = setting(50.0, "mg", f"{_PS} section 6.2: tolerance of x and y, seeded", least=0)
    zero_g_z_mg: float = setting(80.0, "mg", f"{_PS} section 6.2: tolerance of z, seeded", least=0)
    zero_rate_dps: float = setting(20.0, "dps", f"{_PS} section 6.1: tolerance, seeded", least=0)
    sensitivity_percent: float = setting(3.0, "%", f"{_PS} sections 6.1 and 6.2: tolerance, seeded", least=0)

    def __post_init__(self) -> None:
        check_settings(self)


class Mpu6050(InertialPart):
    """See the head of this file."""

    QUANTITIES = motion_quantities()
    ABSENT = (
        "the digital motion processor",
        "the pins FSYNC and CLKIN",
        "sensors on the auxiliary bus, and what INT_PIN_CFG lets through to it",
        "registers that the register map does not have: offsets, and the detection of motion of older revisions",
        "noise that is correlated from sample to sample",
        "drift with temperature, cross-axis sensitivity, nonlinearity, vibration",
    )
    Settings = Mpu6050Settings

    def __init__(self, settings: Mpu6050Settings, ports: Ports, *, seed: int) -> None:
        common = Mpu9250Settings(**asdict(settings))
        self.assemble(MPU6050, common, _individual(common, seed), ports, seed)


def _individual(settings: Mpu9250Settings, seed: int) -> Individual:
    """Draw one; the responses to the self-test follow from its codes (RM section 4.1)."""
    draws = [
        _TEST_CODES[0] + int(drawn * (_TEST_CODES[1] - _TEST_CODES[0] + 1))
        for purpose in ("accel codes", "gyro codes")
        for drawn in uniforms(seed, purpose, 0)[:3]
    ]
    accel, gyro = draws[:3], draws[3:]
    off = [1 + _TEST_TOLERANCE * (2 * drawn - 1) for drawn in uniforms(seed, "self-test", 0)[:3]]
    factory = {_SELF_TEST_X + axis: accel[axis] >> 2 << 5 | gyro[axis] for axis in range(3)}
    factory[_SELF_TEST_A] = sum((code & 3) << 4 - 2 * axis for axis, code in enumerate(accel))
    gyro_dps = [25 * 1.046 ** (code - 1) * part for code, part in zip(gyro, off, strict=True)]
    return replace(
        Individual.of(settings, seed),
        factory=factory,
        accel_test_g=tuple(
            0.34 * (0.92 / 0.34) ** ((code - 1) / 30) * part for code, part in zip(accel, off, strict=True)
        ),
        gyro_test_dps=(gyro_dps[0], -gyro_dps[1], gyro_dps[2]),
    )
