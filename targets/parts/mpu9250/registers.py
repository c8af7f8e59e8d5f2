"""The registers of the MPU-9250, as data (RM-MPU-9250A-00 section 3, table 1).

"The reset value is 0x00 for all registers other than" PWR_MGMT_1 (0x01) and WHO_AM_I (0x71); those that the factory
has filled, see `FACTORY`, come with values of this very part. Addresses that are not listed are reserved: they read 0
and what is written to them is lost (choice).
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

__all__ = ["ACCEL_OFFSETS", "FACTORY", "LAST_ADDRESS", "REGISTERS", "Reg", "Register"]

LAST_ADDRESS = 0x7F
"""Seven bits of a register address count; the counter of a burst wraps here (choice)."""


class Reg(enum.IntEnum):
    """Names and addresses."""

    SELF_TEST_X_GYRO = 0x00
    SELF_TEST_Y_GYRO = 0x01
    SELF_TEST_Z_GYRO = 0x02
    SELF_TEST_X_ACCEL = 0x0D
    SELF_TEST_Y_ACCEL = 0x0E
    SELF_TEST_Z_ACCEL = 0x0F
    XG_OFFSET_H = 0x13
    XG_OFFSET_L = 0x14
    YG_OFFSET_H = 0x15
    YG_OFFSET_L = 0x16
    ZG_OFFSET_H = 0x17
    ZG_OFFSET_L = 0x18
    SMPLRT_DIV = 0x19
    CONFIG = 0x1A
    GYRO_CONFIG = 0x1B
    ACCEL_CONFIG = 0x1C
    ACCEL_CONFIG2 = 0x1D
    LP_ACCEL_ODR = 0x1E
    WOM_THR = 0x1F
    FIFO_EN = 0x23
    I2C_MST_CTRL = 0x24
    I2C_SLV0_ADDR = 0x25
    I2C_SLV0_REG = 0x26
    I2C_SLV0_CTRL = 0x27
    I2C_SLV1_ADDR = 0x28
    I2C_SLV1_REG = 0x29
    I2C_SLV1_CTRL = 0x2A
    I2C_SLV2_ADDR = 0x2B
    I2C_SLV2_REG = 0x2C
    I2C_SLV2_CTRL = 0x2D
    I2C_SLV3_ADDR = 0x2E
    I2C_SLV3_REG = 0x2F
    I2C_SLV3_CTRL = 0x30
    I2C_SLV4_ADDR = 0x31
    I2C_SLV4_REG = 0x32
    I2C_SLV4_DO = 0x33
    I2C_SLV4_CTRL = 0x34
    I2C_SLV4_DI = 0x35
    I2C_MST_STATUS = 0x36
    INT_PIN_CFG = 0x37
    INT_ENABLE = 0x38
    INT_STATUS = 0x3A
    ACCEL_XOUT_H = 0x3B
    TEMP_OUT_H = 0x41
    GYRO_XOUT_H = 0x43
    EXT_SENS_DATA_00 = 0x49
    EXT_SENS_DATA_23 = 0x60
    I2C_SLV0_DO = 0x63
    I2C_SLV1_DO = 0x64
    I2C_SLV2_DO = 0x65
    I2C_SLV3_DO = 0x66
    I2C_MST_DELAY_CTRL = 0x67
    SIGNAL_PATH_RESET = 0x68
    ACCEL_INTEL_CTRL = 0x69
    USER_CTRL = 0x6A
    PWR_MGMT_1 = 0x6B
    PWR_MGMT_2 = 0x6C
    FIFO_COUNTH = 0x72
    FIFO_COUNTL = 0x73
    FIFO_R_W = 0x74
    WHO_AM_I = 0x75
    XA_OFFSET_H = 0x77
    XA_OFFSET_L = 0x78
    YA_OFFSET_H = 0x7A
    YA_OFFSET_L = 0x7B
    ZA_OFFSET_H = 0x7D
    ZA_OFFSET_L = 0x7E


ACCEL_OFFSETS = (Reg.XA_OFFSET_H, Reg.YA_OFFSET_H, Reg.ZA_OFFSET_H)
"""The high bytes; the low byte follows each."""

FACTORY = (
    *range(Reg.SELF_TEST_X_GYRO, Reg.SELF_TEST_Z_GYRO + 1),
    *range(Reg.SELF_TEST_X_ACCEL, Reg.SELF_TEST_Z_ACCEL + 1),
    *(address + byte for address in ACCEL_OFFSETS for byte in (0, 1)),
)
"""What a reset fills with the factory's values (RM sections 4.1, 4.2 and 4.38)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Register:
    """One byte.

    Attributes:
        name: as in the manual.
        reset: value after power-on or reset.
        writable: bits that keep what is written; none of a read-only register.
        acts: further bits that do something when they are written, and read 0.
    """

    name: str
    reset: int = 0
    writable: int = 0xFF
    acts: int = 0


def _registers() -> dict[int, Register]:
    special = {
        Reg.CONFIG: Register(name="CONFIG", writable=0x7F),
        Reg.GYRO_CONFIG: Register(name="GYRO_CONFIG", writable=0xFB),
        Reg.ACCEL_CONFIG: Register(name="ACCEL_CONFIG", writable=0xF8),
        Reg.ACCEL_CONFIG2: Register(name="ACCEL_CONFIG2", writable=0x0F),
        Reg.LP_ACCEL_ODR: Register(name="LP_ACCEL_ODR", writable=0x0F),
        Reg.I2C_SLV4_DI: Register(name="I2C_SLV4_DI", writable=0),
        Reg.I2C_MST_STATUS: Register(name="I2C_MST_STATUS", writable=0),
        Reg.INT_PIN_CFG: Register(name="INT_PIN_CFG", writable=0xFE),
        Reg.INT_ENABLE: Register(name="INT_ENABLE", writable=0x59),
        Reg.INT_STATUS: Register(name="INT_STATUS", writable=0),
        Reg.I2C_MST_DELAY_CTRL: Register(name="I2C_MST_DELAY_CTRL", writable=0x9F),
        Reg.SIGNAL_PATH_RESET: Register(name="SIGNAL_PATH_RESET", writable=0, acts=0x07),
        Reg.ACCEL_INTEL_CTRL: Register(name="ACCEL_INTEL_CTRL", writable=0xC0),
        Reg.USER_CTRL: Register(name="USER_CTRL", writable=0x70, acts=0x07),
        Reg.PWR_MGMT_1: Register(name="PWR_MGMT_1", reset=0x01, writable=0x7F, acts=0x80),
        Reg.PWR_MGMT_2: Register(name="PWR_MGMT_2", writable=0x3F),
        Reg.FIFO_COUNTH: Register(name="FIFO_COUNTH", writable=0),
        Reg.FIFO_COUNTL: Register(name="FIFO_COUNTL", writable=0),
        Reg.FIFO_R_W: Register(name="FIFO_R_W", writable=0, acts=0xFF),
        Reg.WHO_AM_I: Register(name="WHO_AM_I", reset=0x71, writable=0),
    }
    found = {int(reg): special.get(reg) or Register(name=reg.name) for reg in Reg}
    words = [f"{kind}_{axis}OUT" for kind in ("ACCEL", "TEMP", "GYRO") for axis in _axes(kind)]
    for number, word in enumerate(words):
        for byte, half in enumerate("HL"):
            found[Reg.ACCEL_XOUT_H + 2 * number + byte] = Register(name=f"{word}_{half}", writable=0)
    for number in range(24):
        found[Reg.EXT_SENS_DATA_00 + number] = Register(name=f"EXT_SENS_DATA_{number:02}", writable=0)
    return dict(sorted(found.items()))


def _axes(kind: str) -> tuple[str, ...]:
    return ("",) if kind == "TEMP" else ("X", "Y", "Z")


REGISTERS: Mapping[int, Register] = MappingProxyType(_registers())
"""By address."""
