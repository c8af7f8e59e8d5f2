"""The reset line, a board without its parts, when words are published, and wires that were left inputs."""

from __future__ import annotations

from itertools import pairwise

from hilbench.check import at_least, at_most, near
from hilbench.clock import NS_PER_S
from hilbench.mcu.board_case import BoardBench, BoardCase
from hilbench.suites._bluepill import (
    CONNECT,
    LEFT_ENCODER,
    MOTORS,
    RESET,
    RIGHT_ENCODER,
    connect,
    drive_codes,
    last,
    levels,
    obstacles,
    runs,
)
from hilbench.suites._board_watch import Watch
from hilbench.suites.bluepill_pins._ways import (
    PUBLISH_S,
    SPEED,
    Settings,
    on_adapter,
    on_nothing,
    on_wheels,
    pulse,
    required,
)
from targets.parts.motor_code import MotorWord
from targets.parts.p2os_adapter import AdapterHeld, AdapterStarted, RobotConnected

# --- G22: the reset line

REJOIN_S = 4.0
"""How soon the session is there again: 1 s in which p2dx_con is not looked at, the old session closed, the new one
opened. A choice."""


@on_adapter("G22", program="quiet", lasts_s=7.8)
def test_the_reset_line(bench: BoardCase) -> None:
    watch = Watch(bench)
    bench.board.pin(RESET).drive(False)
    connect(bench, watch, RobotConnected)
    drive_codes(bench.board, 3, 3)
    bench.board.run(1.0)
    before, resets = levels(bench.board, (*MOTORS, CONNECT)), board_resets(bench)
    reset_ns = bench.now_ns
    pulse(bench, RESET, 0.010)
    bench.board.run(REJOIN_S + 1.5)
    held, started = watch.reported(AdapterHeld, since_ns=reset_ns), watch.reported(AdapterStarted, since_ns=reset_ns)
    required(len(held) == 1 and len(started) == 1, f"held {len(held)} times and started {len(started)} times")
    near((started[0].at_ns - reset_ns) / NS_PER_S, 0.010, 0.002, unit="s", what="time from reset to restart")
    again = watch.reported(RobotConnected, since_ns=reset_ns)
    required(bool(again), f"no session {REJOIN_S} s after the reset")
    at_least((again[0].at_ns - reset_ns) / NS_PER_S, 1.0, unit="s", what="time from reset to the new session")
    at_most((again[0].at_ns - reset_ns) / NS_PER_S, REJOIN_S, unit="s", what="time from reset to the new session")
    near(watch.samples[-1].speed_mm_s, 187, SPEED * 187, unit="mm/s", what="speed after the new session")
    required(levels(bench.board, (*MOTORS, CONNECT)) == before, "wires of the Blue Pill have changed")
    required(bench.board.end is None and board_resets(bench) == resets, "the Blue Pill was reset")


def board_resets(bench: BoardBench) -> int:
    """Return how often the board was reset so far."""
    return sum(" reset (" in line for line in bench.board.transcript)


# --- G23, G24, G25


@on_nothing("G23", program="sensors", lasts_s=0.5)
def test_no_sensors(bench: BoardCase) -> None:
    line = bench.board.usart("usart1")
    bench.board.run(0.5)
    required(line.text == "near 00000000\r\n", f"the program says {line.text!r}")
    required(obstacles(bench.board) == [], "a distance wire is high")


@on_nothing("G23", program="encoders", lasts_s=3.0)
def test_no_encoders(bench: BoardCase) -> None:
    line = bench.board.usart("usart1")
    bench.board.run(3.0)
    required(line.text == "left 0 right 0\r\n", f"the program says {line.text!r}")
    required(not any(levels(bench.board, (*LEFT_ENCODER, *RIGHT_ENCODER))), "a wire of an encoder is high")


@on_nothing("G23", program="words", lasts_s=4.0)
def test_motors_without_sensors(bench: BoardCase) -> None:
    watch = Watch(bench)
    bench.board.run(4.0)
    for side in ("motor_left", "motor_right"):
        published = [one.event.raw for one in watch.reported(MotorWord, side)]
        required(runs(published) == [0, 3], f"{side} published {runs(published)}, not 0 and 3")
        required(abs(len(published) - 40) <= 1, f"{side} published {len(published)} words in 4 s")


@on_wheels("G24", program="words", lasts_s=10.0)
def test_period_of_publication(bench: BoardCase) -> None:
    watch = Watch(bench)
    bench.board.run(10.0)
    for side in ("motor_left", "motor_right"):
        near(len(watch.reported(MotorWord, side)), 100, 1, unit="words", what=f"words of {side} in 10 s")
        times = [one.at_ns for one in watch.reported(MotorWord, side)]
        longest_s = max(other - one for one, other in pairwise(times)) / NS_PER_S
        near(longest_s, PUBLISH_S, 0.005, unit="s", what=f"longest interval of the words of {side}")


@on_wheels("G25", program="inputs", lasts_s=0.6)
def test_wires_that_were_left_inputs(bench: BoardCase) -> None:
    require_codes_of_inputs(bench, right=0)


_LATCHES: Settings = {"motor_left": {"reads": "odr"}, "motor_right": {"reads": "odr"}}


@on_wheels("G25", program="inputs", lasts_s=0.6, settings=_LATCHES)
def test_wires_that_were_left_inputs_as_published(bench: BoardCase) -> None:
    require_codes_of_inputs(bench, right=3)


def require_codes_of_inputs(bench: BoardBench, right: int) -> None:
    """Require the last codes of the program that wants 3 on both and has left the right wires inputs."""
    watch = Watch(bench)
    bench.board.run(0.6)
    for side, code in (("motor_left", 3), ("motor_right", right)):
        understood = last(watch.reported(MotorWord, side), f"a word of {side}").event.code
        required(understood == code, f"{side} understood {understood}, not {code}")
