"""Steps of a world on a bench: when they are made, in which order, and of which time the truth in the journal is."""

from __future__ import annotations

import pytest

from hilbench.bench import Bench
from hilbench.bench.world_runner import TRUTH_HZ, WorldRunner
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from worlds.world import open_world

HZ = 50
STEP_NS = 1_000_000_000 // HZ


@pytest.fixture
def world():
    world = open_world("empty", "pioneer-2dx", physics="plane", step_hz=HZ)
    yield world
    world.close()


@pytest.fixture
def bench():
    return Bench(Scheduler(), Journal())


def poses(bench):
    return [(event["ns"], event["x_m"]) for event in bench.journal.recent if event["kind"] == "pose"]


@pytest.mark.parametrize("ahead", [False, True])
def test_before_then_the_step_then_after_each_with_its_ends(bench, world, ahead):
    runner, calls = WorldRunner(bench, world, ahead=ahead), []
    runner.before.append(lambda *ends: calls.append(("before", world.step_index, *ends)))
    runner.after.append(lambda *ends: calls.append(("after", world.step_index, *ends)))
    bench.run_for(2.5 / HZ)
    assert calls == [
        ("before", 0, STEP_NS, 2 * STEP_NS),
        ("after", 1, STEP_NS, 2 * STEP_NS),
        ("before", 1, 2 * STEP_NS, 3 * STEP_NS),
        ("after", 2, 2 * STEP_NS, 3 * STEP_NS),
    ]
    assert runner.dt_s == 1 / HZ


def test_the_truth_is_written_ten_times_a_second(bench, world):
    WorldRunner(bench, world)
    bench.run_for(1.0)
    assert [ns for ns, _ in poses(bench)] == [number * 1_000_000_000 // TRUTH_HZ for number in range(1, 11)]


@pytest.mark.parametrize(("ahead", "steps"), [(False, 5), (True, 4)])
def test_the_truth_is_that_of_its_own_time(bench, world, ahead, steps):
    """Ahead, the fifth step is made at tick 5 for the time until tick 6, and the truth of tick 5 is that before it."""
    runner = WorldRunner(bench, world, ahead=ahead)
    runner.before.append(lambda *_: [world.command(wheel, 1.0, 1.0) for wheel in ("wheel_left", "wheel_right")])
    bench.run_for(0.1)
    ((ns, x_um),) = poses(bench)
    assert ns == 100_000_000
    assert x_um == pytest.approx(steps / HZ * world.vehicle.drive.wheel_radius_m * 1e6, abs=2)
