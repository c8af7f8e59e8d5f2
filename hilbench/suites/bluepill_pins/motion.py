"""Words at the pins, how the robot moves by them, and all pairs of codes."""

from __future__ import annotations

from itertools import pairwise

from hilbench.check import at_most, near
from hilbench.clock import NS_PER_S
from hilbench.mcu.board_case import BoardBench, BoardCase
from hilbench.suites._bluepill import (
    CODES,
    MM_S_PER_CODE,
    MOTORS,
    adapter_speed_mm_s,
    adapter_turn_deg_s,
    adapter_turn_mrad_s,
    last,
    runs,
    wheel_turn_mrad_s,
    word,
)
from hilbench.suites._board_watch import Watch
from hilbench.suites.bluepill_pins._ways import (
    DRIFT_DEG,
    SPEED,
    STOP_S,
    UNIT,
    WORDS,
    mean_mm_s,
    mean_mrad_s,
    on_adapter,
    on_wheels,
    required,
)
from targets.parts.motor_code import MotorWord
from targets.parts.p2os_adapter import CodesRead, SpeedSent

# --- G01: words

LEG_S = 3.0

RAW = {0: 0b000, 3: 0b011, -4: 0b100}

MIRRORED = {0: 0b000, 3: 0b110, -4: 0b001}
"""What stands in bits 5 to 7 of port B for the code of the left motor."""


def require_words_at_pins(bench: BoardBench) -> None:
    """Run the program of four words, and look at the pins in the middle of each leg."""
    bench.board.run(LEG_S / 6)
    for number, code in enumerate(WORDS):
        port_b, port_a = word(bench.board, ("PB5", "PB6", "PB7")), word(bench.board, ("PA1", "PA2", "PA3"))
        required(port_b == MIRRORED[code], f"code {code}: PB7..5 carry {port_b:03b}, not {MIRRORED[code]:03b}")
        required(port_a == RAW[code], f"code {code}: PA3..1 carry {port_a:03b}, not {RAW[code]:03b}")
        if number < len(WORDS) - 1:
            bench.board.run(LEG_S)


@on_wheels("G01", program="words", lasts_s=9.5)
def test_words_on_wheels(bench: BoardCase) -> None:
    watch = Watch(bench)
    require_words_at_pins(bench)
    for side in ("motor_left", "motor_right"):
        published = [one.event for one in watch.reported(MotorWord, side)]
        raw, codes = (runs([getattr(one, name) for one in published]) for name in ("raw", "code"))
        required(raw == [RAW[code] for code in WORDS], f"{side} published {raw}, not 0, 3, 4, 0")
        required(codes == [*WORDS], f"{side} understood {codes}, not 0, 3, -4, 0")


@on_adapter("G01", program="words", lasts_s=9.5)
def test_words_on_the_adapter(bench: BoardCase) -> None:
    watch = Watch(bench)
    require_words_at_pins(bench)
    read = [(one.event.left, one.event.right) for one in watch.reported(CodesRead)]
    required(read == [(code, code) for code in WORDS[1:]], f"the adapter read {read}")


# --- G02, G03: how it moves


def require_legs(bench: BoardBench, watch: Watch) -> None:
    """Judge the motion that the program of four words makes."""
    bench.board.run(4 * LEG_S - 0.5)
    for begins_s, code, speed_mm_s in ((LEG_S, 3, adapter_speed_mm_s(3, 3)), (2 * LEG_S, -4, -250)):
        leg = watch.span(begins_s + 0.2, begins_s + LEG_S)
        steady = watch.span(begins_s + 2.0, begins_s + LEG_S)
        near(mean_mm_s(steady), speed_mm_s, SPEED * abs(speed_mm_s), unit="mm/s", what=f"true speed at code {code}")
        headings = [one.heading_deg for one in leg]
        at_most(max(headings) - min(headings), DRIFT_DEG, unit="deg", what=f"drift of the heading at code {code}")
    moving = [one.at_ns for one in watch.span(3 * LEG_S, 4 * LEG_S) if not one.still]
    at_most(
        last(moving, "any motion after code 0") / NS_PER_S - 3 * LEG_S,
        STOP_S,
        unit="s",
        what="time from code 0 to rest",
    )


@on_wheels("G02", program="words", lasts_s=11.5)
def test_motion_on_wheels(bench: BoardCase) -> None:
    require_legs(bench, Watch(bench))


@on_adapter("G02", program="words", lasts_s=11.5)
def test_motion_on_the_adapter(bench: BoardCase) -> None:
    require_legs(bench, Watch(bench))


@on_wheels("G03", program="words", lasts_s=7.0)
def test_a_step_on_wheels(bench: BoardCase) -> None:
    """One torque limit for both wheels lets the vehicle follow at 2.5 m/s2: 0.17 s for the whole step."""
    watch = Watch(bench, MOTORS)
    bench.board.run(7.0)
    for side in ("motor_left", "motor_right"):
        codes = runs([one.event.code for one in watch.reported(MotorWord, side)])
        required(codes == [0, 3, -4], f"{side} understood {codes}, not 0, 3, -4")
        stepped_ns = next(one.at_ns for one in watch.reported(MotorWord, side) if one.event.code == -4)
        there = [one for one in watch.since(stepped_ns) if one.speed_mm_s < -0.95 * 250]
        required(bool(there), "the speed of code -4 is not reached")
        at_most(there[0].after_s(stepped_ns), 0.3, unit="s", what=f"time from the word of {side} to its speed")


@on_adapter("G03", program="words", lasts_s=7.0)
def test_a_step_on_the_adapter(bench: BoardCase) -> None:
    """The robot's own ramps follow; what it is told has none."""
    watch = Watch(bench)
    bench.board.run(7.0)
    sent = runs([(one.event.speed_mm_s, one.event.turn_deg_s) for one in watch.reported(SpeedSent)])
    required(sent == [(187, 0), (-250, 0)], f"the robot was sent {sent}")


# --- G04: all pairs

PAIRS = [(left, right) for left in CODES for right in CODES]

HOLD_S = 0.3

SWEEP_S = 2.0 + len(PAIRS) * HOLD_S + 0.2


@on_wheels("G04", program="sweep", lasts_s=SWEEP_S)
def test_all_codes_on_wheels(bench: BoardCase) -> None:
    """A wheel takes up to 0.2 s to its speed; the last step before the next word is judged."""
    watch = Watch(bench)
    bench.board.run(SWEEP_S)
    pairs = published_pairs(watch)
    seen = [pair for _, pair in pairs]
    wanted = [(0, 0), *PAIRS, (0, 0)]
    required(seen == runs(wanted), "the words are not the 64 pairs in their order", seen)
    for (begin_ns, (left, right)), (end_ns, _) in pairwise(pairs[1:]):
        steady = [one for one in watch.since(begin_ns) if one.at_ns <= end_ns][-8:]
        pair = f"codes {left}, {right}"
        near(mean_mm_s(steady), (left + right) / 2 * MM_S_PER_CODE, 3 * UNIT, unit="mm/s", what=f"speed at {pair}")
        turn_mrad_s = wheel_turn_mrad_s(left, right)
        near(mean_mrad_s(steady), turn_mrad_s, 10 * UNIT, unit="mrad/s", what=f"rate of turn at {pair}")


def published_pairs(watch: Watch) -> list[tuple[int, tuple[int, int]]]:
    """Return the pairs of codes that were published, each with when it first was."""
    both = zip(watch.reported(MotorWord, "motor_left"), watch.reported(MotorWord, "motor_right"), strict=True)
    published = [(left.at_ns, (left.event.code, right.event.code)) for left, right in both]
    return [one for place, one in enumerate(published) if place == 0 or one[1] != published[place - 1][1]]


@on_adapter("G04", program="sweep", lasts_s=SWEEP_S)
def test_all_codes_on_the_adapter(bench: BoardCase) -> None:
    watch = Watch(bench)
    bench.board.run(SWEEP_S)
    read = watch.reported(CodesRead)
    seen = [(one.event.left, one.event.right) for one in read]
    required(seen == [*PAIRS, (0, 0)], "the adapter did not read the 64 pairs in their order", seen)
    for one in read:
        left, right = one.event.left, one.event.right
        pair = f"codes {left}, {right}"
        speed_mm_s, turn_mrad_s = one.event.speed_m_s * 1000, one.event.turn_rad_s * 1000
        near(speed_mm_s, adapter_speed_mm_s(left, right), UNIT, unit="mm/s", what=f"speed asked for at {pair}")
        near(turn_mrad_s, adapter_turn_mrad_s(left, right), UNIT, unit="mrad/s", what=f"turn asked for at {pair}")
        sent = last(watch.reported(SpeedSent, since_ns=one.at_ns)[:1], f"what the robot is sent at {pair}").event
        near(sent.speed_mm_s, adapter_speed_mm_s(left, right), UNIT, unit="mm/s", what=f"VEL at {pair}")
        near(sent.turn_deg_s, adapter_turn_deg_s(left, right), UNIT, unit="deg/s", what=f"RVEL at {pair}")
