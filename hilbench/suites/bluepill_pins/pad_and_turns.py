"""The game pad, and turning."""

from __future__ import annotations

import math

from hilbench.check import near
from hilbench.mcu.board_case import BoardBench, BoardCase
from hilbench.suites._bluepill import adapter_turn_deg_s, connect, drive_codes, last, wheel_turn_mrad_s
from hilbench.suites._board_watch import Watch
from hilbench.suites.bluepill_pins._ways import SPEED, UNIT, mean_mm_s, mean_mrad_s, on_adapter, on_wheels, required
from targets.parts.p2os_adapter import CodesRead, RobotConnected, SpeedSent


@on_adapter("G19", program="quiet", lasts_s=3.5, mode="gamepad")
def test_the_game_pad(bench: BoardCase) -> None:
    require_pad(bench, 500)


@on_adapter("G19", program="quiet", lasts_s=3.5, mode="gamepad", trigger_mm_s=400)
def test_the_game_pad_of_the_thesis(bench: BoardCase) -> None:
    require_pad(bench, 400)


def require_pad(bench: BoardBench, speed_mm_s: int) -> None:
    """Connect by the pad, pull the right trigger, and require the true speed; release it again."""
    watch, parts = Watch(bench), bench.emulated.surroundings.parts
    parts.set("adapter", {"up": 1})
    bench.board.run_until(lambda: bool(watch.reported(RobotConnected)), 4.0)
    required(bool(watch.reported(RobotConnected)), "the pad's button up does not connect")
    parts.set("adapter", {"up": 0, "r2": 255})
    bench.board.run(2.2)
    begun_s = bench.bench.now_s
    bench.board.run(1.0)
    samples = watch.span(begun_s, begun_s + 1.0)
    near(mean_mm_s(samples), speed_mm_s, SPEED * speed_mm_s, unit="mm/s", what="speed at a whole right trigger")
    near(mean_mrad_s(samples), 0.0, 5.0, unit="mrad/s", what="rate of turn at a whole right trigger")
    sent = last(watch.reported(SpeedSent), "what the robot is sent").event
    required((sent.speed_mm_s, sent.turn_deg_s) == (speed_mm_s, 0), f"the robot was sent {sent}")


def require_turn(bench: BoardBench, watch: Watch, expected_mrad_s: float) -> None:
    """Drive codes -1 and 1, and require the true rate of turn, on the spot."""
    drive_codes(bench.board, -1, 1)
    bench.board.run(1.0)
    begun_s = bench.bench.now_s
    bench.board.run(1.5)
    samples = watch.span(begun_s, begun_s + 1.5)
    near(mean_mrad_s(samples), expected_mrad_s, SPEED * expected_mrad_s, unit="mrad/s", what="rate of turn at -1, 1")
    near(mean_mm_s(samples), 0.0, 2.0, unit="mm/s", what="speed at -1, 1")


@on_wheels("G20", program="quiet", lasts_s=2.5)
def test_turning_on_wheels(bench: BoardCase) -> None:
    require_turn(bench, Watch(bench), wheel_turn_mrad_s(-1, 1))


@on_adapter("G20", program="quiet", lasts_s=3.8)
def test_turning_on_the_adapter(bench: BoardCase) -> None:
    """42 mrad/s are asked for; a robot is sent whole degrees per second, which makes 2 of 2.4."""
    watch = Watch(bench)
    connect(bench, watch, RobotConnected)
    told_deg_s = adapter_turn_deg_s(-1, 1)
    require_turn(bench, watch, math.radians(told_deg_s) * 1000)
    asked = last(watch.reported(CodesRead), "the codes that were read").event
    near(asked.turn_rad_s * 1000, 42, UNIT, unit="mrad/s", what="rate of turn asked for at -1, 1")
    required(asked.speed_m_s == 0, f"a speed is asked for: {asked}")


@on_adapter("G20", program="quiet", lasts_s=3.8, turning="differential")
def test_turning_on_a_mended_adapter(bench: BoardCase) -> None:
    watch = Watch(bench)
    connect(bench, watch, RobotConnected)
    require_turn(bench, watch, wheel_turn_mrad_s(-1, 1))
