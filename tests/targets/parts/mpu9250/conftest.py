"""An MPU-9250 with an I2C master in front of it that knows no timing but what it is told."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import fields

import pytest

from targets.mcu.i2c_bus import I2cBus
from targets.parts.mpu6050 import Mpu6050
from targets.parts.mpu9250 import Mpu9250, SensorNote
from targets.parts.testing import PartBench

MS = 1_000_000
READY_NS = 50 * MS
REST = {"ax": 0.0, "ay": 0.0, "az": 9.80665, "wx": 0.0, "wy": 0.0, "wz": 0.0}
IDEAL = {
    "accel_noise_ug_rthz": 0,
    "gyro_noise_dps_rthz": 0,
    "mag_noise_ut": 0,
    "zero_g_xy_mg": 0,
    "zero_g_z_mg": 0,
    "zero_rate_dps": 0,
    "sensitivity_percent": 0,
    "zero_field_ut": 0,
    "clock_tolerance_percent": 0,
    "clock_phase_percent": 0,
}


class ImuRig:
    """A sensor, its interrupt wire, and a bus; each byte takes 25 us, as at 400 kHz with the gaps.

    Attributes:
        bench: the part on its bench.
        bus: the bus.
    """

    def __init__(
        self,
        moving: Callable[[int], Mapping[str, float]] | None,
        step_ns: int,
        settings: dict,
        kind: type = Mpu9250,
    ) -> None:
        self.bench = PartBench(
            kind, kind.Settings(**settings), quantities=moving or (lambda _ns: REST), step_ns=step_ns
        )
        self.bus = I2cBus()
        self.bus.attach(self.bench.part.slave("i2c"))
        self.byte_ns = 25_000

    @property
    def now_ns(self) -> int:
        return self.bench.now_ns

    def run_to(self, ns: int) -> None:
        self.bench.run_to(ns)

    def run(self, ms: float) -> None:
        self.bench.run_to(self.now_ns + round(ms * MS))

    def write(self, register: int, *values: int, address: int = 0x68) -> bool:
        self.bus.start(self.now_ns)
        acknowledged = self.bus.address(address, False, self._tick())
        if acknowledged:
            for byte in (register, *values):
                assert self.bus.write(byte, self._tick())
        self.bus.stop(self._tick())
        return acknowledged

    def read(self, register: int, count: int = 1, address: int = 0x68) -> bytes:
        self.bus.start(self.now_ns)
        assert self.bus.address(address, False, self._tick())
        assert self.bus.write(register, self._tick())
        self.bus.start(self._tick())
        assert self.bus.address(address, True, self._tick())
        found = bytes(self.bus.read(self._tick()) for _ in range(count))
        self.bus.stop(self._tick())
        return found

    def answers(self, address: int) -> bool:
        self.bus.start(self.now_ns)
        found = self.bus.address(address, False, self._tick())
        self.bus.stop(self._tick())
        return found

    def byte(self, register: int, address: int = 0x68) -> int:
        return self.read(register, 1, address)[0]

    def words(self, register: int, count: int) -> list[int]:
        data = self.read(register, 2 * count)
        return [int.from_bytes(data[i : i + 2], "big", signed=True) for i in range(0, len(data), 2)]

    def accel(self) -> list[int]:
        return self.words(0x3B, 3)

    def gyro(self) -> list[int]:
        return self.words(0x43, 3)

    def magnetic(self) -> list[int]:
        """The data registers of the AK8963 in bypass."""
        data = self.read(0x03, 7, address=0x0C)
        return [int.from_bytes(data[i : i + 2], "little", signed=True) for i in (0, 2, 4)]

    def notes(self) -> list[str]:
        return [event.text for event in self.bench.told(SensorNote)]

    def edges(self) -> list[tuple[int, bool | None]]:
        return self.bench.wires["int"].edges

    def rises(self) -> list[int]:
        return [ns for ns, level in self.edges() if level]

    def _tick(self) -> int:
        self.bench.run_to(self.now_ns + self.byte_ns)
        return self.now_ns


@pytest.fixture
def make_imu() -> Callable[..., ImuRig]:
    """Makes rigs without errors of their own: what happens (at rest by default), then settings by name."""

    def make(moving=None, *, step_ns: int = MS, ready: bool = True, ideal: bool = True, **settings) -> ImuRig:
        rig = ImuRig(moving, step_ns, {**(IDEAL if ideal else {}), **settings})
        if ready:
            rig.run_to(READY_NS)
        return rig

    return make


@pytest.fixture
def make_mpu6050() -> Callable[..., ImuRig]:
    """Makes rigs with an MPU-6050, without errors of its own and awake."""

    def make(moving=None, *, step_ns: int = MS, awake: bool = True, **settings) -> ImuRig:
        known = {field.name for field in fields(Mpu6050.Settings)}
        ideal = {name: value for name, value in IDEAL.items() if name in known}
        rig = ImuRig(moving, step_ns, {**ideal, **settings}, Mpu6050)
        rig.run_to(READY_NS)
        if awake:
            rig.write(0x6B, 0)
            rig.run(50)
        return rig

    return make


@pytest.fixture
def imu(make_imu) -> ImuRig:
    """One at rest, without errors, 50 ms after power-on."""
    return make_imu()


@pytest.fixture
def turning() -> Callable[..., Callable[[int], dict[str, float]]]:
    """What a body does that turns about z, in deg/s, at one g."""

    def make(rate_dps: float) -> Callable[[int], dict[str, float]]:
        return lambda _ns: {**REST, "wz": math.radians(rate_dps)}

    return make


@pytest.fixture
def rest() -> dict[str, float]:
    return dict(REST)


@pytest.fixture
def gaps() -> Callable[[Iterable[int]], set[int]]:
    """The distances of times."""

    def find(times: Iterable[int]) -> set[int]:
        return {b - a for a, b in itertools.pairwise(times)}

    return find
