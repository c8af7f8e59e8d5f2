"""One drive: a program, one way to the robot, one room."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Iterator
from dataclasses import asdict, dataclass

from hilbench.benchfile.reader import open_bench
from hilbench.mcu.board_case import BoardBench
from hilbench.mcu.emulated import EmulatedBench
from hilbench.suites._dodge import AHEAD, BACK, TURN, Drive, longest_overlap_s
from worlds.scenes import Scene

WAYS = {"a": "bluepill", "b": "bluepill-robot", "c": "bluepill-p2os"}
"""The benches: pins, adapter, P2OS."""

Point = tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class Figures:
    """What came of a drive.

    Attributes:
        way: a, b or c.
        seed: of the room.
        bench_s: how long it was, in seconds of bench time.
        way_m: how far the robot drove.
        contacts: steps of the physics at which it touched anything but the floor.
        touched: what it touched first, and when; empty for nothing.
        least_clearance_m: how near it came to a box or a wall.
        changes: of state.
        turns: how often it turned, and
        backs: how often it backed.
        longest_turn_s: the longest of both.
        blind_s: how long it was told to drive at what was seen (a, b: DD3 to DD6), or was there (c).
        end: why the program did not run on; empty if it did.
    """

    way: str
    seed: int
    bench_s: float
    way_m: float
    contacts: int
    touched: str
    least_clearance_m: float
    changes: int
    turns: int
    backs: int
    longest_turn_s: float
    blind_s: float
    end: str

    @property
    def good(self) -> bool:
        """Whether nothing was touched and the program ran on."""
        return not self.contacts and not self.end

    def data(self) -> dict[str, object]:
        """Return it as plain data, rounded to what is worth keeping."""
        return {name: round(value, 3) if isinstance(value, float) else value for name, value in asdict(self).items()}


def drive(way: str, seed: int, bench_s: float) -> Figures:
    """Let the program of a way find its way."""
    with opened(way, seed) as bench:
        watched = Drive(bench, commands=way == "c")
        bench.board.run(bench_s)
        return _figures(way, seed, bench, watched)


def track(way: str, seed: int, bench_s: float) -> tuple[Scene, list[Point], Figures]:
    """Do the same, and return the scene and where the robot was, ten times a second."""
    with opened(way, seed) as bench:
        watched = Drive(bench, commands=way == "c")
        points: list[Point] = []

        def look(_now_ns: int, _next_ns: int) -> None:
            if bench.world.step_index % (bench.world.step_hz // 10) == 0:
                points.append(bench.world.pose().position_m[:2])

        bench.runner.after.append(look)
        bench.board.run(bench_s)
        return bench.world.scene, points, _figures(way, seed, bench, watched)


@contextlib.contextmanager
def opened(way: str, seed: int) -> Iterator[BoardBench]:
    """Open the bench of a way in a room."""
    with contextlib.closing(EmulatedBench(open_bench(WAYS[way]), seed=seed)) as emulated:
        yield BoardBench(emulated)


def _figures(way: str, seed: int, bench: BoardBench, watched: Drive) -> Figures:
    spells = watched.spells()
    spans = [watched.near()] if way == "c" else [watched.high(sensor) for sensor in AHEAD]
    end = bench.emulated.end
    return Figures(
        way=way,
        seed=seed,
        bench_s=bench.bench.now_s,
        way_m=watched.way_m,
        contacts=watched.contacts,
        touched=f"{watched.hits[0].other} after {watched.hits[0].at_s:.1f} s" if watched.hits else "",
        least_clearance_m=watched.clearance.least_m if math.isfinite(watched.clearance.least_m) else 99.0,
        changes=len(spells) - 1,
        turns=sum(spell.motion == TURN for spell in spells),
        backs=sum(spell.motion == BACK for spell in spells),
        longest_turn_s=max((spell.length_s for spell in spells if spell.motion in {TURN, BACK}), default=0.0),
        blind_s=max(longest_overlap_s(span, spells) for span in spans),
        end="" if end is None else str(end),
    )
