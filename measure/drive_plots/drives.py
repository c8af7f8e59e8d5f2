"""The drives, on the built-in bench `vehicle`: our firmware on the emulated chip, a car on the test track."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from dataclasses import replace

import msgspec

from hilbench.bench import Bench
from hilbench.benchfile.reader import open_bench
from hilbench.clock import NS_PER_S, Scheduler
from hilbench.journal import Journal
from hilbench.mcu.board_case import BoardBench
from hilbench.mcu.emulated import EmulatedBench
from hilbench.suites._vehicle_drive import Drive, DriveBench, Moment
from hilbench.systems.vehicle.on_board import VehicleOnBoard
from targets.firmware import image_path
from worlds.vehicles.car import CarBody

__all__ = ["SLOW_FROM_M_S", "SLOW_S", "lap", "opened", "slow", "stop"]

LAP_WITHIN_S = 90.0
LOSE_AT_M_S = 9.99
SLOW_FROM_M_S, SLOW_S = 5.0, 4.0


@contextlib.contextmanager
def opened(image: str = "vehicle") -> Iterator[Drive]:
    """A car at the start of the track, everything just switched on; one of our images runs on the board."""
    bench_file = open_bench("vehicle")
    world = msgspec.structs.replace(bench_file.world, scene="test-track")
    boards = {name: replace(one, firmware=image_path(image)) for name, one in bench_file.boards.items()}
    bench_file = replace(bench_file, world=world, boards=boards)
    bench = Bench(Scheduler(), Journal())
    with contextlib.closing(EmulatedBench(bench_file, seed=0, bench=bench)) as emulated:
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


def slow(rate_hz: float, image: str = "vehicle") -> list[Moment]:
    """On the straight up to `SLOW_FROM_M_S` as ever, then `SLOW_S` with so many commands a second; these moments."""
    with opened(image) as drive:
        drive.start()
        drive.reach(SLOW_FROM_M_S)
        begin_s = drive.now_s
        drive.follow(rate_hz)
        drive.go(SLOW_S)
        return drive.since(begin_s)


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
