"""What the distance sensors say, and how soon a program heeds it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from hilbench.check import at_most
from hilbench.clock import NS_PER_S
from hilbench.mcu.board_case import BoardBench, BoardCase
from hilbench.suites._bluepill import DISTANCES, MOTORS, face_wall, levels, obstacles, place_before, place_in_cell, show
from hilbench.suites._board_watch import Watch
from hilbench.suites._truth import Sample
from hilbench.suites.bluepill_pins._ways import (
    LOOP_S,
    MOVES_MM_S,
    POST_M,
    PUBLISH_S,
    SONAR_LATE_S,
    look_at_post,
    on_adapter,
    on_wheels,
    required,
)
from targets.parts.distance_switch import DistanceSwitched

# --- G05, G06, G07: distance sensors


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
        high = look_at_post(bench, sensor, SONAR_LATE_S)
        wanted = [sensor] if 2 <= sensor <= 6 else []
        required(high == wanted, f"an obstacle before sensor {sensor}: DD{high} are high, not DD{wanted}")
    bench.board.run(0.1)
    required(line.text.splitlines() == said(range(2, 7)), "the program says something else", line.text.splitlines())


@on_adapter("G05", program="sensors", lasts_s=5.1, scene="post", dd1_forced_low=False, dd7_8_driven=True)
def test_the_outer_sensors_on_a_mended_adapter(bench: BoardCase) -> None:
    bench.board.run(2.0)
    for sensor in (1, 7, 8):
        high = look_at_post(bench, sensor, SONAR_LATE_S)
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
    require_all(bench, range(2, 7), SONAR_LATE_S)


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
        required(high is wanted, f"DD4 is {_level(high)} at {range_m:.3f} m", watch.reported(DistanceSwitched))


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
        bench.board.run(SONAR_LATE_S)
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
