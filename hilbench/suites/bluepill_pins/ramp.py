"""A ramp."""

from __future__ import annotations

import math

from hilbench.check import at_most, near
from hilbench.mcu.board_case import BoardBench, BoardCase
from hilbench.suites._bluepill import connect, drive_codes
from hilbench.suites._board_watch import Watch
from hilbench.suites.bluepill_pins._ways import ON_RAMP, on_adapter, on_wheels, required
from targets.parts.p2os_adapter import RobotConnected
from worlds.scenes.builtin import RAMP_FOOT_M, RAMP_SLOPE_RAD


def require_ramp(bench: BoardBench, watch: Watch) -> None:
    """Drive up and back down, and judge the speeds while the robot is wholly on the slope."""
    begun_s = bench.bench.now_s
    drive_codes(bench.board, 3, 3)
    bench.board.run(7.0)
    turned_s = bench.bench.now_s
    drive_codes(bench.board, -4, -4)
    bench.board.run(4.0)
    for from_s, to_s, speed_mm_s in ((begun_s + 1.0, turned_s, 187), (turned_s + 1.7, turned_s + 4.0, -250)):
        sloping = [one for one in watch.span(from_s, to_s) if abs(one.pitch_deg + SLOPE_DEG) < SLOPE_DEG / 8]
        required(len(sloping) > 0.5 / bench.runner.dt_s, "the robot is hardly ever on the slope", sloping[-1:])
        mean = sum(one.speed_mm_s for one in sloping) / len(sloping)
        near(
            mean,
            speed_mm_s,
            ON_RAMP * abs(speed_mm_s),
            unit="mm/s",
            what=f"speed on the ramp, {speed_mm_s} on the flat",
        )
    rolls_deg = [abs(math.degrees(bench.world.pose().roll_rad)), *(abs(one.pitch_deg) for one in watch.samples)]
    at_most(max(rolls_deg), 2 * SLOPE_DEG, unit="deg", what="greatest inclination")


SLOPE_DEG = math.degrees(RAMP_SLOPE_RAD)

BEFORE_RAMP_M = 0.4


@on_wheels("G21", program="quiet", lasts_s=11.3, scene="ramp", needs=("gravity",))
def test_ramp_on_wheels(bench: BoardCase) -> None:
    watch = Watch(bench)
    bench.world.place(RAMP_FOOT_M - BEFORE_RAMP_M, 0.0, 0.0)
    bench.board.run(0.3)
    require_ramp(bench, watch)


@on_adapter("G21", program="quiet", lasts_s=12.3, scene="ramp", needs=("gravity",))
def test_ramp_on_the_adapter(bench: BoardCase) -> None:
    watch = Watch(bench)
    bench.world.place(RAMP_FOOT_M - BEFORE_RAMP_M, 0.0, 0.0)
    connect(bench, watch, RobotConnected)
    require_ramp(bench, watch)
