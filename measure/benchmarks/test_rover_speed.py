"""How fast the bench of the rover is beside real time, with all its parts, and where the time goes.

Figures are of CPU time and are printed; nothing is asserted on time. The rover stands, turns its wheels in the air, or
drives over a floor, while its program talks to both sensors and to the host. Each block begins where the one before
has ended; the best of them counts. Looking at where the time goes makes what is called often look more expensive than
it is, so that is done in a block of its own. Run by `make bench`.
"""

from __future__ import annotations

import contextlib
import time

import pytest

from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.journal import Journal
from hilbench.judging.provider import CaseInfo, CaseSetup
from hilbench.mcu.board_provider import BoardProvider
from hilbench.suites._rover import Rover, rover_bench
from protocols.pkt import MotorThrottles

BLOCKS, BLOCK_S = 4, 1.0
UP_S = 1.0
"""By then the sensors are set up."""


@contextlib.contextmanager
def opened(scene):
    shared = Shared(bench_file=open_bench("rover"), timeout_scale=1.0, journal=Journal())
    info = CaseInfo(id="speed", clause_ids=(), seed=0, scene=scene, setup=CaseSetup(program="documented"))
    with BoardProvider(shared).open_case(info) as bench:
        rover = Rover(rover_bench(bench))
        rover.keep_alive(UP_S)
        yield bench, rover
        bench.finish("pass", "")


def block(rover, throttle):
    """Return the CPU seconds of `BLOCK_S` of bench time."""
    began = time.process_time()
    rover.peer.send(MotorThrottles(a=throttle, b=throttle))
    rover.keep_alive(BLOCK_S)
    return time.process_time() - began


def shares_of(shares, bench, rover, throttle):
    """Return the share of each in a block."""
    around = bench.emulated.surroundings
    shares.watch(around.parts._signals, "read", "reading the world")
    shares.watch(around.parts._signals, "drive", "driving the world")
    for name, part in around.parts.by_name.items():
        kind = bench.emulated.bench_file.parts[name].kind
        for call in ("feed", "before_step", "after_step", "advance", "receive"):
            if hasattr(part, call):
                shares.watch(part, call, kind)
    shares.watch_bench(bench.emulated)
    return shares.of(block(rover, throttle))


@pytest.mark.parametrize(("what", "scene", "throttle"), [
    ("at rest", "stand", 0.0), ("wheels in the air", "stand", 0.6), ("on the floor", "hard-floor", 0.6),
])  # fmt: skip
def test_the_rover(what, scene, throttle, shares, show):
    with opened(scene) as (bench, rover):
        best_s = min(block(rover, throttle) for _ in range(BLOCKS))
        parts = shares_of(shares, bench, rover, throttle)
        turned = bench.body.wheel("wheel_lf").angle_rad
    show(f"rover {what}", BLOCK_S / best_s, parts)
    assert (turned > 10) is (throttle > 0)
