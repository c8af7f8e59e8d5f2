"""An inertial sensor as a part on an I2C bus: what the sensors of this family have in common."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

from targets.mcu.i2c_bus import I2cSlave
from targets.parts.mpu9250.ak8963 import AK8963_ADDRESS, Ak8963
from targets.parts.mpu9250.chip import Chip
from targets.parts.mpu9250.individual import Individual
from targets.parts.mpu9250.interrupts import Interrupts
from targets.parts.mpu9250.model import Model
from targets.parts.mpu9250.notes import Notes
from targets.parts.mpu9250.registers import LAST_ADDRESS, Reg
from targets.parts.mpu9250.sensing import Sensing
from targets.parts.mpu9250.settings import Mpu9250Settings
from targets.parts.noise import uniforms
from targets.parts.part import Direction, Part, Ports, Quantity, Terminal

__all__ = ["InertialPart", "motion_quantities"]


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


class InertialPart(Part):
    """See the module; a subclass calls `assemble`."""

    TERMINALS = (Terminal(name="int", direction=Direction.OUT, text="interrupt"),)
    BUSES = ("i2c",)
    ADDRESSED_BY = "ad0"

    def assemble(
        self,
        model: Model,
        settings: Mpu9250Settings,
        individual: Individual,
        ports: Ports,
        seed: int,
        *,
        magnetometer: Callable[[Sensing, Notes], Ak8963] | None = None,
    ) -> None:
        """Put it together.

        Args:
            model: which of the family it is.
            settings: of the part.
            individual: of the part.
            ports: what it is connected to.
            seed: of its noise.
            magnetometer: makes the one behind it, if it has one.
        """
        notes = Notes(ports.tell)
        self._sensing = Sensing(model, settings, individual, seed)
        behind = None if magnetometer is None else magnetometer(self._sensing, notes)
        self._chip = Chip(
            model,
            self._sensing,
            individual,
            behind,
            Interrupts(ports.output("int")),
            notes,
            phase=partial(_phase, seed, settings.clock_phase_percent / 100),
        )
        self._slave = _Slave(self._chip, behind, self.address_of(settings), notes)
        self._ready_ns = round(settings.ready_ms * 1e6)

    @staticmethod
    def address_of(settings: Any) -> int:
        """Return its address, by its pin AD0."""
        return 0x69 if settings.ad0 else 0x68

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


def _phase(seed: int, most: float, number: int) -> float:
    """The share of a sample period that the clock has gone when it is started or changed for the `number`-th time."""
    return most * uniforms(seed, "clock phase", number)[0]


class _Slave:
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
