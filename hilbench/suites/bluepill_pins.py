"""Does a robot do what the pins of a Blue Pill say, and do the pins say what the robot meets?

The validation experiments of the bachelor's thesis (section 5.4) with figures, and what else can be asked of the wires
between the board and the robot. Two ways lead from the pins to the same robot in the same world: straight to wheels and
sensors, as in the original's simulation, and over its adapter by P2OS, as on its real robot. The same images run on
both. Where the published programs have a quirk, a case holds the bench to the quirk and another, with the setting that
mends it, to what is sound.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from itertools import pairwise
from typing import TypeVar

import pytest

from hilbench.check import CaseSetup, Violation, at_least, at_most, case, near
from hilbench.clock import NS_PER_MS, NS_PER_S
from hilbench.mcu.board_case import BoardBench, BoardCase
from hilbench.suites._bluepill import (
    CODES,
    CONNECT,
    DISTANCES,
    LEFT_ENCODER,
    LEFT_MOTOR,
    MM_S_PER_CODE,
    MOTORS,
    RESET,
    RIGHT_ENCODER,
    RIGHT_MOTOR,
    adapter_speed_mm_s,
    adapter_turn_deg_s,
    adapter_turn_mrad_s,
    bits,
    connect,
    drive_codes,
    face_wall,
    last,
    levels,
    obstacles,
    place_before,
    place_in_cell,
    runs,
    show,
    signed,
    take_away,
    wheel_turn_mrad_s,
    word,
)
from hilbench.suites._board_watch import Watch
from hilbench.suites._truth import Sample
from targets.parts.distance_switch import DistanceSwitched
from targets.parts.encoder_3bit import EncoderMoved
from targets.parts.motor_code import MotorWord
from targets.parts.p2os_adapter import (
    AdapterHeld,
    AdapterStarted,
    CodesRead,
    ConnectionPin,
    EncoderWords,
    RobotConnected,
    RobotLeft,
    RobotLost,
    SafeStopped,
    SpeedSent,
)
from worlds.scenes.builtin import RAMP_FOOT_M, RAMP_SLOPE_RAD

EventT = TypeVar("EventT")
FunctionT = TypeVar("FunctionT", bound=Callable[..., object])
Settings = Mapping[str, Mapping[str, object]]

# --- tolerances

SPEED = 0.05
"""Tolerance of a speed, as a share; the thesis compares speeds by eye, so the figure is a choice."""

STOP_S = 1.0
"""How soon the robot has to stand after code 0."""

DRIFT_DEG = 3.0
"""How much its heading may drift in a leg on a flat floor."""

UNIT = 1.0
"""Tolerance of the tables: one mm/s, mrad/s or deg/s."""

SECTOR_DEG = 45.0
SECTOR_TOLERANCE_DEG = 1.0

LOOP_S = 0.010
"""The programs look at their pins every 10 ms."""

PUBLISH_S = 0.100
"""The original reads the motor wires every 100 ms (stm32-qemu vl.c)."""

ON_RAMP = 0.2
"""Tolerance of the speed on a ramp, as a share. A choice."""

MOVES_MM_S = 5.0
"""A robot that is faster has begun to move. A choice."""

# --- the two ways, and what each needs of the bench

_MOTORS = {"part 'motor_left'", "part 'motor_right'"}
_SENSORS = {f"part 'switch_{number}'" for number in range(1, 9)}
_ENCODERS = {"part 'encoder_left'", "part 'encoder_right'"}
_SONAR_S = 8 * 0.040
"""A round of the eight discs at the front: one every 40 ms (Pioneer 2 Operations Manual)."""

_SONAR_LATE_S = _SONAR_S + 0.100 + 0.100
"""Until a reading is at the pins: a whole round, the cycle of the SIP, and its bytes at 9600 baud."""


def on_wheels(
    *clause_ids: str,
    program: str,
    lasts_s: float,
    scene: str = "empty",
    settings: Settings | None = None,
    needs: Iterable[str] = (),
) -> Callable[[FunctionT], FunctionT]:
    """Declare a case with the pins straight on wheels and sensors."""
    setup = CaseSetup(program=program, settings=settings or {})
    wanted = {*_MOTORS, *_SENSORS, *_ENCODERS, "rays", *needs}
    return case(*clause_ids, bench_time_s=lasts_s, needs=wanted, scene=scene, setup=setup)


def on_adapter(
    *clause_ids: str, program: str, lasts_s: float, scene: str = "empty", needs: Iterable[str] = (), **settings: object
) -> Callable[[FunctionT], FunctionT]:
    """Declare a case with the pins on the adapter; what is named beside is set on it."""
    setup = CaseSetup(variant="robot", program=program, settings={"adapter": settings} if settings else {})
    wanted = {"part 'adapter'", "rays", *needs}
    return case(*clause_ids, bench_time_s=lasts_s, needs=wanted, scene=scene, setup=setup)


def on_nothing(*clause_ids: str, program: str, lasts_s: float) -> Callable[[FunctionT], FunctionT]:
    """Declare a case with motors on the pins and nothing else."""
    setup = CaseSetup(variant="bare", program=program)
    return case(*clause_ids, bench_time_s=lasts_s, needs=_MOTORS, setup=setup)


def required(holds: bool, message: str, lines: Iterable[object] = ()) -> None:
    """Require something of the target."""
    if not holds:
        raise Violation(message, [str(line) for line in lines])


# --- G01: words


WORDS = (0, 3, -4, 0)
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
        published = [told.event for told in watch.told(MotorWord, side)]
        raw, codes = (runs([getattr(one, name) for one in published]) for name in ("raw", "code"))
        required(raw == [RAW[code] for code in WORDS], f"{side} published {raw}, not 0, 3, 4, 0")
        required(codes == [*WORDS], f"{side} understood {codes}, not 0, 3, -4, 0")


@on_adapter("G01", program="words", lasts_s=9.5)
def test_words_on_the_adapter(bench: BoardCase) -> None:
    watch = Watch(bench)
    require_words_at_pins(bench)
    read = [(told.event.left, told.event.right) for told in watch.told(CodesRead)]
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


def mean_mm_s(samples: Sequence[Sample]) -> float:
    """Return the mean speed from way and time, + forward."""
    return samples[-1].seen_from(samples[0])[0] / samples[-1].after_s(samples[0].at_ns)


def mean_mrad_s(samples: Sequence[Sample]) -> float:
    """Return the mean rate of turn from angle and time, + counter-clockwise."""
    turned_deg = samples[-1].heading_deg - samples[0].heading_deg
    return math.radians(turned_deg) * 1000 / samples[-1].after_s(samples[0].at_ns)


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
        codes = runs([told.event.code for told in watch.told(MotorWord, side)])
        required(codes == [0, 3, -4], f"{side} understood {codes}, not 0, 3, -4")
        stepped_ns = next(told.at_ns for told in watch.told(MotorWord, side) if told.event.code == -4)
        there = [one for one in watch.since(stepped_ns) if one.speed_mm_s < -0.95 * 250]
        required(bool(there), "the speed of code -4 is not reached")
        at_most(there[0].after_s(stepped_ns), 0.3, unit="s", what=f"time from the word of {side} to its speed")


@on_adapter("G03", program="words", lasts_s=7.0)
def test_a_step_on_the_adapter(bench: BoardCase) -> None:
    """The robot's own ramps follow; what it is told has none."""
    watch = Watch(bench)
    bench.board.run(7.0)
    told = runs([(one.event.speed_mm_s, one.event.turn_deg_s) for one in watch.told(SpeedSent)])
    required(told == [(187, 0), (-250, 0)], f"the robot was told {told}")


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
    both = zip(watch.told(MotorWord, "motor_left"), watch.told(MotorWord, "motor_right"), strict=True)
    published = [(left.at_ns, (left.event.code, right.event.code)) for left, right in both]
    return [one for place, one in enumerate(published) if place == 0 or one[1] != published[place - 1][1]]


@on_adapter("G04", program="sweep", lasts_s=SWEEP_S)
def test_all_codes_on_the_adapter(bench: BoardCase) -> None:
    watch = Watch(bench)
    bench.board.run(SWEEP_S)
    read = watch.told(CodesRead)
    seen = [(told.event.left, told.event.right) for told in read]
    required(seen == [*PAIRS, (0, 0)], "the adapter did not read the 64 pairs in their order", seen)
    for told in read:
        left, right = told.event.left, told.event.right
        pair = f"codes {left}, {right}"
        speed_mm_s, turn_mrad_s = told.event.speed_m_s * 1000, told.event.turn_rad_s * 1000
        near(speed_mm_s, adapter_speed_mm_s(left, right), UNIT, unit="mm/s", what=f"speed asked for at {pair}")
        near(turn_mrad_s, adapter_turn_mrad_s(left, right), UNIT, unit="mrad/s", what=f"turn asked for at {pair}")
        sent = last(watch.told(SpeedSent, since_ns=told.at_ns)[:1], f"what the robot is told at {pair}").event
        near(sent.speed_mm_s, adapter_speed_mm_s(left, right), UNIT, unit="mm/s", what=f"VEL at {pair}")
        near(sent.turn_deg_s, adapter_turn_deg_s(left, right), UNIT, unit="deg/s", what=f"RVEL at {pair}")


# --- G05, G06, G07: distance sensors

POST_M = 0.4
"""Where the post is before a sensor: within the threshold of either way, and in the cone of no other disc."""


def look_at_post(bench: BoardBench, sensor: int, settle_s: float) -> list[int]:
    """Put the post before a sensor, and return the distance wires that are high then; take it away again."""
    place_before(bench, sensor, POST_M)
    bench.board.run(settle_s)
    high = obstacles(bench.board)
    take_away(bench)
    bench.board.run(settle_s)
    left = obstacles(bench.board)
    required(not left, f"the obstacle before sensor {sensor} is gone, and DD{left} still high")
    return high


def said(sensors: Iterable[int]) -> list[str]:
    """Return the lines of the program that says which switches are on, for one after the other."""
    lines = ["near 00000000"]
    for sensor in sensors:
        lines += [f"near {1 << sensor - 1:08b}", "near 00000000"]
    return lines


@on_wheels("G05", program="sensors", lasts_s=1.0, scene="post")
def test_each_sensor_on_wheels(bench: BoardCase) -> None:
    line = bench.board.usart("usart1")
    bench.board.run(0.1)
    for sensor in range(1, 9):
        high = look_at_post(bench, sensor, 0.05)
        required(high == [sensor], f"an obstacle before sensor {sensor}: DD{high} are high")
    bench.board.run(0.1)
    required(line.text.splitlines() == said(range(1, 9)), "the program says something else", line.text.splitlines())


@on_adapter("G05", program="sensors", lasts_s=10.4, scene="post")
def test_each_sensor_on_the_adapter(bench: BoardCase) -> None:
    """As published: DD1 is forced low, DD7 and DD8 are not driven."""
    line = bench.board.usart("usart1")
    bench.board.run(2.0)
    for sensor in range(1, 9):
        high = look_at_post(bench, sensor, _SONAR_LATE_S)
        wanted = [sensor] if 2 <= sensor <= 6 else []
        required(high == wanted, f"an obstacle before sensor {sensor}: DD{high} are high, not DD{wanted}")
    bench.board.run(0.1)
    required(line.text.splitlines() == said(range(2, 7)), "the program says something else", line.text.splitlines())


@on_adapter("G05", program="sensors", lasts_s=5.1, scene="post", dd1_forced_low=False, dd7_8_driven=True)
def test_the_outer_sensors_on_a_mended_adapter(bench: BoardCase) -> None:
    bench.board.run(2.0)
    for sensor in (1, 7, 8):
        high = look_at_post(bench, sensor, _SONAR_LATE_S)
        required(high == [sensor], f"an obstacle before sensor {sensor}: DD{high} are high")


def require_all(bench: BoardBench, numbers: Sequence[int], period_s: float) -> None:
    """Put the robot into the cell, and require these distance wires to go high in time."""
    watch = Watch(bench, DISTANCES)
    required(not obstacles(bench.board), "something is near before anything is there")
    watch.next_step()
    placed_ns = watch.samples[-1].at_ns
    place_in_cell(bench)
    bench.board.run(period_s + 0.05)
    high = obstacles(bench.board)
    required(high == [*numbers], f"obstacles on all sides: DD{high} are high, not DD{[*numbers]}")
    last_ns = max(edge.at_ns for edge in watch.edges_of(DISTANCES, placed_ns) if edge.level)
    at_most((last_ns - placed_ns) / NS_PER_S, period_s + 0.001, unit="s", what="time until all are high")


@on_wheels("G06", program="sensors", lasts_s=0.16, scene="cell")
def test_all_sensors_on_wheels(bench: BoardCase) -> None:
    """The period of the sensors is a step of the physics."""
    bench.board.run(0.1)
    require_all(bench, range(1, 9), bench.runner.dt_s)


@on_adapter("G06", program="sensors", lasts_s=2.6, scene="cell")
def test_all_sensors_on_the_adapter(bench: BoardCase) -> None:
    """The period of the sensors is a round of the sonar, until the SIP with its last disc is there."""
    bench.board.run(2.0)
    require_all(bench, range(2, 7), _SONAR_LATE_S)


SIMULATED_THRESHOLD_M = 0.5
ROBOT_THRESHOLD_M = 1.0
WALL_M = 2.0
"""Where the face of the wall stands in the scene of that name."""


def require_threshold(bench: BoardBench, threshold_m: float, at_threshold: bool) -> None:
    """Show a switch a range 1 cm nearer than its threshold, at it, and 1 cm beyond."""
    watch = Watch(bench)
    bench.emulated.surroundings.parts.senses = False
    bench.board.run(0.05)
    for range_m, wanted in ((threshold_m - 0.01, True), (threshold_m, at_threshold), (threshold_m + 0.01, False)):
        show(bench, "switch_4", {"range": math.inf})
        show(bench, "switch_4", {"range": range_m})
        (high,) = levels(bench.board, DISTANCES[3:4])
        required(high is wanted, f"DD4 is {_level(high)} at {range_m:.3f} m", watch.told(DistanceSwitched))


def _level(high: bool) -> str:
    return "high" if high else "low"


@on_wheels("G07", program="sensors", lasts_s=0.15, scene="wall")
def test_threshold_of_the_simulation(bench: BoardCase) -> None:
    """Strict: low at the threshold. Nearer and farther by 1 cm before a real wall, too."""
    bench.board.run(0.05)
    for range_m, wanted in ((0.49, True), (0.51, False)):
        face_wall(bench, 4, range_m, WALL_M)
        bench.board.run(0.02)
        (high,) = levels(bench.board, DISTANCES[3:4])
        required(high is wanted, f"DD4 is {_level(high)} at {range_m:.3f} m from the wall")
    require_threshold(bench, SIMULATED_THRESHOLD_M, at_threshold=False)


@on_wheels("G07", program="sensors", lasts_s=0.06, settings={"switch_4": {"profile": "robot"}})
def test_threshold_as_on_the_robot(bench: BoardCase) -> None:
    require_threshold(bench, ROBOT_THRESHOLD_M, at_threshold=True)


@on_adapter("G07", program="sensors", lasts_s=3.6, scene="wall")
def test_threshold_of_the_adapter(bench: BoardCase) -> None:
    """A unit of a sonar reading is 0.27 mm, and the adapter reckons in whole millimetres: 1.000 m is 1000 mm."""
    bench.board.run(2.0)
    for range_m, wanted in ((0.99, True), (1.01, False), (1.0, True)):
        face_wall(bench, 4, range_m, WALL_M)
        bench.board.run(_SONAR_LATE_S)
        (high,) = levels(bench.board, DISTANCES[3:4])
        required(high is wanted, f"DD4 is {_level(high)} at {range_m:.3f} m from the wall")


# --- G08: reaction


def require_reaction(bench: BoardBench, watch: Watch, sensor: int, within_s: float) -> None:
    """Let the robot drive past a post that one sensor sees: the wire goes high, and low again behind the post."""
    wire = DISTANCES[sensor - 1]
    begun_ns = bench.bench.now_ns
    bench.board.run_until(lambda: len([e for e in watch.edges_of([wire], begun_ns) if e.level is False]) > 0, within_s)
    bench.board.run(0.5)
    edges = watch.edges_of([wire], begun_ns)
    required([edge.level for edge in edges] == [True, False], f"DD{sensor} does not go high and low again", edges)
    for edge, code in zip(edges, (3, 0), strict=True):
        changed = [one for one in watch.edges_of(MOTORS, edge.at_ns) if one.at_ns - edge.at_ns < NS_PER_S // 5]
        what = f"time from DD{sensor} going {_level(edge.level is True)}"
        required(bool(changed), f"no motor wire changes after DD{sensor} goes {_level(edge.level is True)}")
        wires_ns = changed[-1].at_ns
        at_most((wires_ns - edge.at_ns) / NS_PER_S, LOOP_S + bench.runner.dt_s, unit="s", what=f"{what} to the wires")
        begins = motion_changes(watch, wires_ns)
        required(begins is not None, f"the motion does not change after the wires of code {code}")
        assert begins is not None
        at_most(begins.after_s(wires_ns), PUBLISH_S + 2 * bench.runner.dt_s, unit="s", what=f"{what}, wires to motion")


def motion_changes(watch: Watch, since_ns: int) -> Sample | None:
    """Return when the speed is first another than it was at a time."""
    samples = watch.since(since_ns)
    return next((one for one in samples if abs(one.speed_mm_s - samples[0].speed_mm_s) > MOVES_MM_S), None)


@on_wheels("G08", program="reactive", lasts_s=1.0, scene="post")
def test_reaction_on_wheels(bench: BoardCase) -> None:
    """The post is as wide as 40 mm: 15 mm of it are behind the ray of sensor 1, to be driven past."""
    watch = Watch(bench, (*DISTANCES, *MOTORS))
    bench.board.run(0.2)
    place_before(bench, 1, POST_M, back_m=0.015)
    require_reaction(bench, watch, 1, 2.0)


@on_adapter("G08", program="reactive", lasts_s=4.4, scene="post")
def test_reaction_on_the_adapter(bench: BoardCase) -> None:
    """Sensor 2 looks 50 degrees to the left; its cone is driven out of."""
    watch = Watch(bench, (*DISTANCES, *MOTORS))
    bench.board.run(2.0)
    place_before(bench, 2, 0.5)
    require_reaction(bench, watch, 2, 5.0)


# --- G09 to G12: encoders


SETTLED_DEG = 1.0
"""A wheel at rest in the beginning may stand on either side of 0: what it shows there means nothing."""


def require_numbers(watch: Watch, side: str, wanted: Sequence[int]) -> list[float]:
    """Require the numbers of an encoder from its second sector on, and return the angle in deg at which each began."""
    moved = watch.told(EncoderMoved, f"encoder_{side}")
    angles = [math.degrees(getattr(watch.angles_at(told.event.at_ns), f"{side}_rad")) for told in moved]
    turned = next((place for place, angle in enumerate(angles) if abs(angle) > SETTLED_DEG), len(angles))
    numbers = [0, *(told.event.word for told in moved)][turned : turned + len(wanted)]
    required(numbers == [*wanted], f"the {side} encoder shows {numbers}, not {[*wanted]}")
    return angles[turned : turned + len(wanted) - 1]


def require_widths(side: str, begins_deg: Sequence[float], widths_deg: Sequence[float]) -> None:
    """Require how far the wheel turns while each number is shown."""
    for (begin, end), width in zip(pairwise(begins_deg), widths_deg, strict=True):
        what = f"width of the sector from {begin:.1f} deg of the {side} wheel"
        near(abs(end - begin), width, SECTOR_TOLERANCE_DEG, unit="deg", what=what)


def numbers_said(text: str) -> list[tuple[int, int]]:
    """Return the numbers, left and right, that the program has said."""
    words = [line.split() for line in text.splitlines() if line.startswith("left ")]
    return [(int(line[1]), int(line[3])) for line in words if len(line) == 4]


TURN = [1, 2, 3, 4, 5, 6, 7, 0, 1]
"""What an encoder shows in a turn forward, from its first boundary on."""


@on_wheels("G09", program="encoders", lasts_s=12.5)
def test_encoders_forward(bench: BoardCase) -> None:
    """The program turns the wheels at 43 degrees per second for 11 s."""
    watch = Watch(bench)
    line = bench.board.usart("usart1")
    bench.board.run(12.5)
    for side in ("left", "right"):
        begins_deg = require_numbers(watch, side, [0, *TURN])
        near(begins_deg[0], SECTOR_DEG, SECTOR_TOLERANCE_DEG, unit="deg", what=f"first boundary of the {side} wheel")
        require_widths(side, begins_deg, [SECTOR_DEG] * (len(begins_deg) - 1))
    for place, side in enumerate(("left", "right")):
        heard = runs([pair[place] for pair in numbers_said(line.text)])
        found = any(heard[begin : begin + len(TURN)] == TURN for begin in range(len(heard)))
        required(found, f"the program says {heard} of the {side} encoder, and not {TURN}")


BACK_S = 4.8
"""At code -2 a wheel turns back by 417 degrees in this time."""


@on_wheels("G10", program="quiet", lasts_s=BACK_S)
def test_encoders_backward(bench: BoardCase) -> None:
    watch = Watch(bench)
    drive_codes(bench.board, -2, -2)
    bench.board.run(BACK_S)
    for side in ("left", "right"):
        begins_deg = require_numbers(watch, side, [7, 6, 5, 4, 3, 2, 1, 0, 7])
        near(begins_deg[0], -SECTOR_DEG, SECTOR_TOLERANCE_DEG, unit="deg", what=f"first boundary of the {side} wheel")
        require_widths(side, begins_deg, [SECTOR_DEG] * (len(begins_deg) - 1))


@on_wheels("G10", program="encoders", lasts_s=25.2)
def test_encoders_back_again(bench: BoardCase) -> None:
    """After its turn and more forward the program waits, and turns the wheels back."""
    watch = Watch(bench)
    line = bench.board.usart("usart1")
    bench.board.run(14.0)
    begun_ns, said_before = bench.now_ns, len(line.text)
    bench.board.run(11.2)
    back = TURN[::-1]
    for place, side in enumerate(("left", "right")):
        shown = [told.event.word for told in watch.told(EncoderMoved, f"encoder_{side}", begun_ns)]
        required(shown[: len(back)] == back, f"the {side} encoder shows {shown}, not {back}")
        heard = runs([pair[place] for pair in numbers_said(line.text[said_before:])])
        required(heard[: len(back)] == back, f"the program says {heard} of the {side} encoder, not {back}")


_TRUNCATING: Settings = {"encoder_left": {"form": "truncating"}, "encoder_right": {"form": "truncating"}}


@on_wheels("G10", program="quiet", lasts_s=BACK_S + 0.9, settings=_TRUNCATING)
def test_encoders_backward_as_the_plug_in_has_it(bench: BoardCase) -> None:
    """First forward into sector 1, so that the whole of the wide sector 0 is passed."""
    watch = Watch(bench)
    drive_codes(bench.board, 2, 2)
    bench.board.run(0.9)
    drive_codes(bench.board, -2, -2)
    bench.board.run(BACK_S)
    for side in ("left", "right"):
        begins_deg = require_numbers(watch, side, [0, 1, 0, 7, 6, 5, 4, 3, 2, 1])
        require_widths(side, begins_deg[1:], [2 * SECTOR_DEG, *[SECTOR_DEG] * 6])


@on_wheels("G10", program="quiet", lasts_s=1.5)
def test_each_encoder_shows_its_own_wheel(bench: BoardCase) -> None:
    """On the spot, the left wheel goes back while the right one goes forward, by more than two sectors in 1.5 s."""
    watch = Watch(bench)
    drive_codes(bench.board, -2, 2)
    bench.board.run(1.5)
    require_numbers(watch, "left", [7, 6])
    require_numbers(watch, "right", [0, 1, 2])
    for part, pins in (("encoder_left", LEFT_ENCODER), ("encoder_right", RIGHT_ENCODER)):
        number = watch.told(EncoderMoved, part)[-1].event.word
        seen = levels(bench.board, pins)
        required(seen == bits(number), f"{part} shows {number}: {', '.join(pins)} are {seen}")


def show_number(bench: BoardBench, part: str, number: int) -> None:
    """Show an encoder the middle of a sector."""
    show(bench, part, {"angle": math.radians((number + 0.5) * SECTOR_DEG)})


@on_wheels("G11", program="encoders", lasts_s=0.24)
def test_pins_of_the_encoders(bench: BoardCase) -> None:
    """The program has to read the numbers as well: PB3, PB4 and PA15 belong to the debug port after reset."""
    line = bench.board.usart("usart1")
    bench.emulated.surroundings.parts.senses = False
    bench.board.run(0.05)
    for side, pins in (("left", LEFT_ENCODER), ("right", RIGHT_ENCODER)):
        for number in (5, 1, 4):
            show_number(bench, f"encoder_{side}", number)
            seen = levels(bench.board, pins)
            required(seen == bits(number), f"number {number} on the {side}: {', '.join(pins)} are {seen}")
            bench.board.run(0.03)
            pair = last(numbers_said(line.text), "what the program says")
            required(pair[side == "right"] == number, f"the program reads {pair} (left, right)")


@on_wheels("G12", program="quiet", lasts_s=0.02)
def test_bit_order_of_the_encoders(bench: BoardCase) -> None:
    require_order(bench, {1: (True, False, False), 4: (False, False, True)})


_MSB_FIRST: Settings = {"encoder_left": {"bit_order": "msb-first"}, "encoder_right": {"bit_order": "msb-first"}}


@on_wheels("G12", program="quiet", lasts_s=0.02, settings=_MSB_FIRST)
def test_bit_order_as_on_the_adapter(bench: BoardCase) -> None:
    require_order(bench, {1: (False, False, True), 4: (True, False, False)})


def require_order(bench: BoardBench, wanted: Mapping[int, tuple[bool, bool, bool]]) -> None:
    """Show both encoders numbers, and require the levels of s1 to s3."""
    bench.emulated.surroundings.parts.senses = False
    bench.board.run(0.02)
    for part, pins in (("encoder_left", LEFT_ENCODER), ("encoder_right", RIGHT_ENCODER)):
        for number, right in wanted.items():
            show_number(bench, part, number)
            seen = levels(bench.board, pins)
            required(seen == right, f"{part} shows {number}: s1 to s3 are {seen}, not {right}")


@on_adapter("G12", program="quiet", lasts_s=2.0)
def test_bit_order_of_the_adapter(bench: BoardCase) -> None:
    require_adapter_order(bench, mirrored=True)


@on_adapter("G12", program="quiet", lasts_s=2.0, encoder_order="lsb-first")
def test_bit_order_of_a_mended_adapter(bench: BoardCase) -> None:
    require_adapter_order(bench, mirrored=False)


def require_adapter_order(bench: BoardBench, *, mirrored: bool) -> None:
    """Drive, and require of each number that the adapter tells of the levels on its wires."""
    watch = Watch(bench)
    connect(bench, watch, RobotConnected)
    drive_codes(bench.board, 3, 3)
    seen: set[int] = set()
    for _ in range(40):
        shown = next_told(bench, watch, EncoderWords)
        for number, pins in ((shown.left, LEFT_ENCODER), (shown.right, RIGHT_ENCODER)):
            wanted = bits(number)[::-1] if mirrored else bits(number)
            found = levels(bench.board, pins)
            required(found == wanted, f"number {number}: s1 to s3 are {found}, not {wanted}")
            seen.add(number)
        if {1, 4} <= seen:
            return
    raise Violation(f"the numbers 1 and 4 do not come in 40 changes, only {sorted(seen)}")


def next_told(bench: BoardBench, watch: Watch, kind: type[EventT]) -> EventT:
    """Return the next of a kind that a part tells, when what it has done is at the pins."""
    before = len(watch.told(kind))
    bench.board.run_until(lambda: len(watch.told(kind)) > before, 1.0)
    bench.board.run(0.001)
    return last(watch.told(kind)[before:], f"another {kind.__name__}").event


# --- G14: one image, two robots


def order_of(watch: Watch, pins: Iterable[str], since_ns: int = 0) -> list[tuple[str, bool]]:
    """Return the edges of pins without their times."""
    return [(edge.pin, edge.level is True) for edge in watch.edges_of(pins, since_ns)]


OUTPUTS = (*MOTORS, CONNECT, RESET, "PA0", "PA11", "PA12")


@on_wheels("G14", program="words", lasts_s=9.5, needs=("variant 'robot'", "part 'adapter'"))
def test_words_on_both(bench: BoardCase) -> None:
    other = bench.open_other(CaseSetup(variant="robot", program="words"), "empty")
    benches = (bench, other)
    watches = [Watch(one, OUTPUTS) for one in benches]
    for one in benches:
        one.board.run(9.5)
    here, there = (order_of(watch, OUTPUTS) for watch in watches)
    required(len(here) > len(WORDS), "the program moves nothing", here)
    required(here == there, "the edges at the connector come in another order over the adapter", [here, there])


FRONT = range(2, 7)
"""The sensors that both ways have."""


@on_wheels("G14", program="sensors", lasts_s=2.6, scene="post", needs=("variant 'robot'", "part 'adapter'"))
def test_sensors_on_both(bench: BoardCase) -> None:
    other = bench.open_other(CaseSetup(variant="robot", program="sensors"), "post")
    orders, texts = [], []
    for one, settle_s in ((bench, 0.05), (other, _SONAR_LATE_S)):
        pins = (*DISTANCES[1:6], *OUTPUTS)
        watch, line = Watch(one, pins), one.board.usart("usart1")
        one.board.run(2.0)
        begun_ns = one.bench.now_ns
        for sensor in FRONT:
            look_at_post(one, sensor, settle_s)
        one.board.run(0.1)
        orders.append(order_of(watch, pins, begun_ns))
        texts.append(line.text)
    required(len(orders[0]) >= 4 * len(FRONT), "the sensors or the lamp move nothing", orders[0])
    required(orders[0] == orders[1], "the edges come in another order over the adapter", orders)
    required(texts[0] == texts[1], "the program says something else over the adapter", texts)


# --- G15, G16: how the adapter reads its wires


def pulse(bench: BoardBench, pin: str, high_s: float) -> None:
    """Drive a pin high for a time, then low."""
    bench.board.pin(pin).drive(True)
    bench.board.run(high_s)
    bench.board.pin(pin).drive(False)


def echo(bench: BoardBench) -> bool:
    """Return whether the adapter drives its echo high."""
    return bench.emulated.surroundings.parts.driven("adapter", "echo") is True


@on_adapter("G15", program="quiet", lasts_s=2.05)
def test_short_pulses_do_not_connect(bench: BoardCase) -> None:
    """Seven of them, at all places of the window of 10 ms in which the wire is read."""
    watch = Watch(bench)
    bench.board.pin(CONNECT).drive(False)
    bench.board.run(1.2)
    for _ in range(7):
        pulse(bench, CONNECT, 0.005)
        bench.board.run(0.0957)
    required(not watch.told(ConnectionPin), "a pulse of 5 ms was acted on", watch.told(ConnectionPin))
    pulse(bench, CONNECT, 0.050)
    seen = [told.event.connected for told in watch.told(ConnectionPin)]
    required(seen == [True], "a pulse of 50 ms was not acted on", watch.told(ConnectionPin))
    required(echo(bench), "the echo is not high")
    bench.board.run(0.1)
    seen = [told.event.connected for told in watch.told(ConnectionPin)]
    required(seen == [True, False], "the end of the pulse was not acted on", watch.told(ConnectionPin))
    required(not echo(bench), "the echo is not low again")


@on_adapter("G15", program="quiet", lasts_s=1.7)
def test_the_first_second_does_not_connect(bench: BoardCase) -> None:
    watch = Watch(bench)
    bench.board.run(0.2)
    pulse(bench, CONNECT, 0.050)
    bench.board.run(0.25)
    bench.board.pin(CONNECT).drive(True)
    bench.board.run(0.45)
    required(not watch.told(ConnectionPin) and not echo(bench), "acted on before 1 s", watch.told(ConnectionPin))
    bench.board.run(0.75)
    required([told.event.connected for told in watch.told(ConnectionPin)] == [True], "not acted on after 1 s")
    at_least(watch.told(ConnectionPin)[0].at_ns / NS_PER_S, 1.0, unit="s", what="first acted on")
    at_most(watch.told(ConnectionPin)[0].at_ns / NS_PER_S, 1.02, unit="s", what="first acted on")
    required(echo(bench), "the echo is not high")


LEAVE_S = 1.0
"""How soon the robot has been let go after p2dx_con went low; its CLOSE goes out with the next command. A choice."""


@on_adapter("G15", program="quiet", lasts_s=4.6)
def test_the_robot_is_let_go(bench: BoardCase) -> None:
    """The robot moves when p2dx_con goes low: it gets a CLOSE, stands, and is taken up again by the next pulse."""
    watch = Watch(bench)
    connect(bench, watch, RobotConnected)
    drive_codes(bench.board, 3, 3)
    bench.board.run(1.0)
    low_ns = bench.now_ns
    bench.board.pin(CONNECT).drive(False)
    bench.board.run(2.0)
    left = last(watch.told(RobotLeft, since_ns=low_ns), "the end of the session")
    at_most((left.at_ns - low_ns) / NS_PER_S, LEAVE_S, unit="s", what="time from p2dx_con going low to the end")
    closes = [at_ns for at_ns, data in watch.sent if at_ns >= low_ns and data == CLOSE]
    required(len(closes) == 1, f"{len(closes)} CLOSE went to the robot, not one")
    after = [data for at_ns, data in watch.sent if at_ns > closes[0]]
    required(not after, "the robot is sent something after the CLOSE", [data.hex(" ") for data in after])
    required(watch.samples[-1].still, "the robot still moves")
    again_ns = bench.now_ns
    bench.board.pin(CONNECT).drive(True)
    again = bench.board.run_until(lambda: bool(watch.told(RobotConnected, since_ns=again_ns)), 2.0)
    required(again, "no other session 2 s after p2dx_con went high again")


SPACING_US = 100
"""Far enough apart that the reads can be told from each other: at 0, 100, 200, 300 and 400 us before the pass."""


@on_adapter("G16", program="quiet", lasts_s=0.025, pass_ms=1.0, motor_reads=5, motor_read_spacing_us=float(SPACING_US))
@pytest.mark.parametrize("pin", MOTORS)
@pytest.mark.parametrize(("reads", "seen"), [(2, False), (3, True)])
def test_majority_of_five(bench: BoardCase, pin: str, reads: int, seen: bool) -> None:
    """The adapter takes a pass each millisecond; before each of six the wire is high for the last reads of five."""
    watch = Watch(bench)
    bench.board.run(0.02)
    machine, wire = bench.emulated.machines[bench.board.name], bench.board.pin(pin)
    first_ns = bench.now_ns - bench.now_ns % NS_PER_MS + 2 * NS_PER_MS
    for number in range(6):
        pass_ns = first_ns + number * NS_PER_MS
        machine.at_ns(pass_ns - int((reads - 0.5) * SPACING_US * 1000), lambda: wire.drive(True))
        machine.at_ns(pass_ns + 10_000, lambda: wire.drive(False))
    bench.board.run(0.005)
    codes = [(told.event.left, told.event.right) for told in watch.told(CodesRead)]
    wanted = code_of_wire(pin)
    if seen:
        required(codes == [wanted], f"{pin} high in {reads} of 5 reads: codes {codes}, not {wanted}")
    else:
        required(not codes, f"{pin} high in {reads} of 5 reads: codes {codes}")


def code_of_wire(pin: str) -> tuple[int, int]:
    """Return the codes, left and right, that one motor wire alone stands for."""
    if pin in LEFT_MOTOR:
        return signed(1 << LEFT_MOTOR.index(pin)), 0
    return 0, signed(1 << RIGHT_MOTOR.index(pin))


# --- G17, G18: what becomes of a robot


@on_adapter("G17", program="halt", lasts_s=12.0)
def test_a_stopped_program_drives_on(bench: BoardCase) -> None:
    """The program stops after 5 s, with codes 3 on its wires; the robot's own watchdog, of 2 s, is kept quiet."""
    watch = Watch(bench)
    bench.board.run(12.0)
    required(levels(bench.board, MOTORS) == (*bits(3), *bits(3)), "the wires do not carry codes 3 any more")
    near(mean_mm_s(watch.span(9.0, 12.0)), 187, SPEED * 187, unit="mm/s", what="speed 4 to 7 s after the program ended")


SAFE_STOP_S = 3.0


@on_adapter("G17", program="halt", lasts_s=7.0, safe_stop_s=SAFE_STOP_S)
def test_a_stopped_program_is_noticed(bench: BoardCase) -> None:
    """The last that changed on the wires is p2dx_con, acted on after 1 s of uptime."""
    watch = Watch(bench)
    bench.board.run(7.0)
    changed_ns = last(watch.told(ConnectionPin), "the connection").at_ns
    stopped = watch.told(SafeStopped)
    required(len(stopped) == 1, f"stopped {len(stopped)} times, not once")
    within_s = (stopped[0].at_ns - changed_ns) / NS_PER_S
    near(within_s, SAFE_STOP_S, 0.01, unit="s", what="time from the last change of a wire to the stop")
    fastest = max(abs(one.speed_mm_s) for one in watch.samples)
    near(fastest, 187, SPEED * 187, unit="mm/s", what="speed before")
    moving = last([one for one in watch.samples if not one.still], "any motion")
    at_most(moving.after_s(stopped[0].at_ns), STOP_S, unit="s", what="time from the stop to rest")


PULSE = bytes.fromhex("fafb03000000")
CLOSE = bytes.fromhex("fafb03020002")
ENABLE = bytes.fromhex("fafb06043b0100053b")
WATCH_S = 10.0


@on_adapter("G18", program="quiet", lasts_s=11.3)
def test_the_robot_is_kept_alive(bench: BoardCase) -> None:
    watch = Watch(bench)
    connected_ns = connect(bench, watch, RobotConnected)
    bench.board.run(WATCH_S)
    for frame, name, every_s, off_s in ((PULSE, "PULSE", 0.5, 0.01), (ENABLE, "ENABLE", 0.1, 0.01)):
        times_ns = [at_ns for at_ns, data in watch.sent if at_ns >= connected_ns and data == frame]
        count = WATCH_S / every_s
        required(abs(len(times_ns) - count) <= 0.03 * count + 1, f"{len(times_ns)} {name} in {WATCH_S:g} s")
        for one, other in pairwise(times_ns):
            near((other - one) / NS_PER_S, every_s, off_s, unit="s", what=f"interval of {name}")
    required(not watch.told(RobotLost), "the session was lost")
    required(all(one.still for one in watch.since(connected_ns)), "the robot moves")


# --- G19, G20: the game pad, and turning


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
    bench.board.run_until(lambda: bool(watch.told(RobotConnected)), 4.0)
    required(bool(watch.told(RobotConnected)), "the pad's button up does not connect")
    parts.set("adapter", {"up": 0, "r2": 255})
    bench.board.run(2.2)
    begun_s = bench.bench.now_s
    bench.board.run(1.0)
    samples = watch.span(begun_s, begun_s + 1.0)
    near(mean_mm_s(samples), speed_mm_s, SPEED * speed_mm_s, unit="mm/s", what="speed at a whole right trigger")
    near(mean_mrad_s(samples), 0.0, 5.0, unit="mrad/s", what="rate of turn at a whole right trigger")
    sent = last(watch.told(SpeedSent), "what the robot is told").event
    required((sent.speed_mm_s, sent.turn_deg_s) == (speed_mm_s, 0), f"the robot was told {sent}")


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
    """42 mrad/s are asked for; a robot is told whole degrees per second, which makes 2 of 2.4."""
    watch = Watch(bench)
    connect(bench, watch, RobotConnected)
    told_deg_s = adapter_turn_deg_s(-1, 1)
    require_turn(bench, watch, math.radians(told_deg_s) * 1000)
    asked = last(watch.told(CodesRead), "the codes that were read").event
    near(asked.turn_rad_s * 1000, 42, UNIT, unit="mrad/s", what="rate of turn asked for at -1, 1")
    required(asked.speed_m_s == 0, f"a speed is asked for: {asked}")


@on_adapter("G20", program="quiet", lasts_s=3.8, turning="differential")
def test_turning_on_a_mended_adapter(bench: BoardCase) -> None:
    watch = Watch(bench)
    connect(bench, watch, RobotConnected)
    require_turn(bench, watch, wheel_turn_mrad_s(-1, 1))


# --- G21: a ramp


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
    held, started = watch.told(AdapterHeld, since_ns=reset_ns), watch.told(AdapterStarted, since_ns=reset_ns)
    required(len(held) == 1 and len(started) == 1, f"held {len(held)} times and started {len(started)} times")
    near((started[0].at_ns - reset_ns) / NS_PER_S, 0.010, 0.002, unit="s", what="time from reset to restart")
    again = watch.told(RobotConnected, since_ns=reset_ns)
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
        published = [told.event.raw for told in watch.told(MotorWord, side)]
        required(runs(published) == [0, 3], f"{side} published {runs(published)}, not 0 and 3")
        required(abs(len(published) - 40) <= 1, f"{side} published {len(published)} words in 4 s")


@on_wheels("G24", program="words", lasts_s=10.0)
def test_period_of_publication(bench: BoardCase) -> None:
    watch = Watch(bench)
    bench.board.run(10.0)
    for side in ("motor_left", "motor_right"):
        near(len(watch.told(MotorWord, side)), 100, 1, unit="words", what=f"words of {side} in 10 s")
        times = [told.at_ns for told in watch.told(MotorWord, side)]
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
        understood = last(watch.told(MotorWord, side), f"a word of {side}").event.code
        required(understood == code, f"{side} understood {understood}, not {code}")
