"""The MPU-9250 as a part on an I2C bus: 3 axes of acceleration, 3 of rotation, and the AK8963 in the same package.

Start here; `inertial.py` puts it together, `chip.py` has the registers and the sample clock, `sensing.py` the way from
physics to counts, `ak8963.py` the magnetometer. It answers at 0x68 or 0x69, and at 0x0C too while the auxiliary bus is
bypassed (INT_PIN_CFG, BYPASS_EN).

What is not modelled: `Mpu9250.ABSENT`.
"""

from __future__ import annotations

from targets.parts.mpu9250.ak8963 import Ak8963
from targets.parts.mpu9250.individual import Individual
from targets.parts.mpu9250.inertial import InertialPart, motion_quantities
from targets.parts.mpu9250.model import MPU9250
from targets.parts.mpu9250.settings import Mpu9250Settings
from targets.parts.part import Direction, Ports, Quantity

__all__ = ["Mpu9250"]


def _angles() -> tuple[Quantity, ...]:
    return tuple(
        Quantity(
            name=name,
            direction=Direction.IN,
            unit="rad",
            needed=False,
            text="attitude, for the magnetometer; else level",
        )
        for name in ("roll", "pitch", "yaw")
    )


class Mpu9250(InertialPart):
    """See the head of this file."""

    QUANTITIES = (*motion_quantities(), *_angles())
    ABSENT = (
        "the digital motion processor",
        "the SPI interface",
        "the pin FSYNC",
        "other sensors on the auxiliary bus, and the time that its transfers take",
        "the magnetometer's external trigger",
        "higher noise in the low power mode",
        "noise that is correlated from sample to sample",
        "drift with temperature, cross-axis sensitivity, nonlinearity, vibration",
    )
    Settings = Mpu9250Settings

    def __init__(self, settings: Mpu9250Settings, ports: Ports, *, seed: int) -> None:
        individual = Individual.of(settings, seed)
        self.assemble(
            MPU9250,
            settings,
            individual,
            ports,
            seed,
            magnetometer=lambda sensing, notes: Ak8963(sensing.field_ut, individual.mag_codes, notes),
        )
