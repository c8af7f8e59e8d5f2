"""The drives, on the built-in bench `vehicle`: our firmware on the emulated chip, a car on the test track."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import replace

import msgspec

from hilbench.bench import Bench
from hilbench.clock import NS_PER_S, Scheduler
from hilbench.config import open_bench
from hilbench.journal import Journal
from hilbench.mcu.board_case import BoardBench
from hilbench.mcu.emulated import EmulatedBench
from hilbench.suites._vehicle_drive import Drive, DriveBench
from hilbench.vehicle_on_board import VehicleOnBoard
from worlds.vehicles.car import CarBody

__all__ = ["lap", "opened", "stop"]

LAP_WITHIN_S = 90.0
LOSE_AT_M_S = 9.99


@contextlib.contextmanager
def opened() -> Iterator[Drive]:
    """A car at the start of the track, everything just switched on."""
    bench_file = open_bench("vehicle")
    world = msgspec.structs.replace(bench_file.world, scene="test-track")
    bench = Bench(Scheduler(), Journal())
    with contextlib.closing(EmulatedBench(replace(bench_file, world=world), seed=0, bench=bench)) as emulated:
        there = BoardBench(emulated)
        vehicle = VehicleOnBoard(there)
        body = emulated.surroundings.body
        assert isinstance(body, CarBody)
        assert vehicle.hands is not None
        yield Drive(
            DriveBench(
                bench=bench,
                simulator=vehicle.simulator.port,
                stack=vehicle.stack.port,
                body=body,
                runner=there.runner,
                hands=vehicle.hands,
            )
        )


def lap() -> Drive:
    """Once around, by the driving stack."""
    with opened() as drive:
        drive.start()
        drive.until(lambda: drive.driver.travelled_m >= drive.path.length_m, LAP_WITHIN_S)
        return drive


def stop() -> tuple[Drive, float, float]:
    """Up to 10 m/s, then no status any more; when the last one was said, and the emergency's first frame, in s."""
    with opened() as drive:
        drive.start()
        drive.reach(LOSE_AT_M_S)
        drive.car.statuses.stop()
        lost_s = (drive.car.statuses.last_ns or 0) / NS_PER_S
        emergency_s = drive.emergency(2.0)
        drive.go(2.0)
        return drive, lost_s, emergency_s
