"""The MPU-9250 as a part on an I2C bus: 3 axes of acceleration, 3 of rotation, and the AK8963 in the same package.

Start here; `chip.py` has the registers and the sample clock, `sensing.py` the way from physics to counts, `ak8963.py`
the magnetometer. It answers at 0x68 or 0x69, and at 0x0C too while the auxiliary bus is bypassed (INT_PIN_CFG,
BYPASS_EN).

What is not modelled: `Mpu9250.ABSENT`.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial

from targets.mcu.i2c_bus import I2cSlave
from targets.parts.mpu9250.ak8963 import AK8963_ADDRESS, Ak8963
from targets.parts.mpu9250.chip import Chip
from targets.parts.mpu9250.individual import Individual
from targets.parts.mpu9250.interrupts import Interrupts
from targets.parts.mpu9250.model import MPU9250
from targets.parts.mpu9250.notes import Notes
from targets.parts.mpu9250.registers import LAST_ADDRESS, Reg
from targets.parts.mpu9250.sensing import Sensing
from targets.parts.mpu9250.settings import Mpu9250Settings
from targets.parts.noise import uniforms
from targets.parts.part import Direction, Part, Ports, Quantity, Terminal

__all__ = ["Mpu9250", "SensorSlave", "clock_phase", "motion_quantities"]


def motion_quantities() -> tuple[Quantity, ...]:
    """Return what an inertial sensor feels."""
    forces = [
        Quantity(name=f"a{axis}", direction=Direction.IN, unit="m/s2", text="specific force, axes of the body")
        for axis in "xyz"
    ]
    rates = [
        Quantity(name=f"w{axis}", direction=Direction.IN, unit="rad/s", text="rotation, axes of the body")
        for axis in "xyz"
    ]
    return *forces, *rates


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


class Mpu9250(Part):
    """See the head of this file."""

    TERMINALS = (Terminal(name="int", direction=Direction.OUT, text="interrupt"),)
    QUANTITIES = (*motion_quantities(), *_angles())
    BUSES = ("i2c",)
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
        self._notes = Notes(ports.tell)
        self._sensing = Sensing(MPU9250, settings, individual, seed)
        ak8963 = Ak8963(self._sensing.field_ut, individual.mag_codes, self._notes)
        self._chip = Chip(
            MPU9250,
            self._sensing,
            individual,
            ak8963,
            Interrupts(ports.output("int")),
            self._notes,
            phase=partial(clock_phase, seed, settings.clock_phase_percent / 100),
        )
        self._slave = SensorSlave(self._chip, ak8963, 0x69 if settings.ad0 else 0x68, self._notes)
        self._ready_ns = round(settings.ready_ms * 1e6)

    def slave(self, name: str) -> I2cSlave:
        """Return what answers on the bus; raises KeyError as `Part.slave` does."""
        return {"i2c": self._slave}[name]

    def power_on(self, now_ns: int) -> None:
        """Begin to start up."""
        self._chip.power_on(now_ns)
        self._slave.ready_ns = now_ns + self._ready_ns

    def after_step(self, from_ns: int, to_ns: int, before: Mapping[str, float], after: Mapping[str, float]) -> None:
        """Take what happens to the body in the step."""
        self._chip.keep_up(from_ns)
        self._sensing.step(from_ns, to_ns, before, after)

    def next_deadline_ns(self) -> int | None:
        """When the interrupt pin may change next."""
        return self._chip.next_event_ns

    def advance(self, now_ns: int) -> None:
        """Take the samples that are due."""
        self._chip.advance(now_ns)


def clock_phase(seed: int, most: float, number: int) -> float:
    """The share of a sample period that the clock has gone when it is started or changed for the `number`-th time."""
    return most * uniforms(seed, "clock phase", number)[0]


class SensorSlave:
    """What answers on the bus: the chip, and the magnetometer behind it while it is bypassed.

    Args:
        chip: the chip.
        ak8963: the magnetometer, if there is one.
        address: of the chip.
        notes: takes what is a mistake.

    Attributes:
        ready_ns: before that nothing is acknowledged; None: there is no supply.
    """

    def __init__(self, chip: Chip, ak8963: Ak8963 | None, address: int, notes: Notes) -> None:
        self._chip = chip
        self._ak8963 = ak8963
        self._address = address
        self._notes = notes
        self._pointer = 0
        self._pointer_set = False
        self._other: Ak8963 | None = None  # the magnetometer, while the message is for it
        self.ready_ns: int | None = None

    def address(self, address: int, read: bool, now_ns: int) -> bool:
        """Acknowledge its own address, or let the magnetometer acknowledge its."""
        self._other = self._ak8963 if address == AK8963_ADDRESS else None
        if (address != self._address and self._other is None) or not self._awake(now_ns):
            return False
        if self._other is not None:
            self._chip.advance(now_ns)
            return self._chip.bypassed and self._other.address(address, read, now_ns)
        if read:
            self._chip.freeze(now_ns)
        self._pointer_set = False
        return True

    def write(self, byte: int, now_ns: int) -> bool:
        """Take a register's address, then values for it and those that follow."""
        if self._other is not None:
            return self._other.write(byte, now_ns)
        if self._pointer_set:
            self._chip.write(self._pointer, byte, now_ns)
            self._step()
        else:
            self._pointer, self._pointer_set = byte & LAST_ADDRESS, True
        return True

    def read(self, now_ns: int) -> int:
        """Return the register whose turn it is."""
        if self._other is not None:
            return self._other.read(now_ns)
        value = self._chip.read(self._pointer, now_ns)
        self._step()
        return value

    def end(self, now_ns: int) -> None:
        """The message is over."""
        if self._other is not None:
            self._other.end(now_ns)
        else:
            self._chip.thaw(now_ns)

    def _awake(self, now_ns: int) -> bool:
        if self.ready_ns is None or now_ns < self.ready_ns:
            self._notes.note("spoken to before the start-up time for registers was over: not acknowledged")
            return False
        return not self._chip.deaf

    def _step(self) -> None:
        """The next register; a burst at the FIFO stays there (RM-MPU-9250A-00 section 4.37)."""
        if self._pointer != Reg.FIFO_R_W:
            self._pointer = self._pointer + 1 & LAST_ADDRESS
