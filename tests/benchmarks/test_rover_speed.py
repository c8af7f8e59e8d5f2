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

from hilbench.check.provider import CaseInfo, CaseSetup
from hilbench.config import open_bench
from hilbench.journal import Journal
from hilbench.mcu.board_provider import BoardProvider
from hilbench.shared import Shared
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


class Shares:
    """Adds up what calls take, less the calls in them that are watched as well."""

    def __init__(self):
        self.spent_s = {}
        self._nested_s = 0.0

    def timed(self, call, label):
        def run(*args, **named):
            outer_s, self._nested_s = self._nested_s, 0.0
            began = time.process_time()
            try:
                return call(*args, **named)
            finally:
                took_s = time.process_time() - began
                self.spent_s[label] = self.spent_s.get(label, 0.0) + took_s - self._nested_s
                self._nested_s = outer_s + took_s

        return run

    def watch(self, owner, name, label):
        setattr(owner, name, self.timed(getattr(owner, name), label))


def shares_of(bench, rover, throttle):
    """Return the share of each in a block."""
    shares = Shares()
    around = bench.emulated.surroundings
    shares.watch(around.world, "step", "physics")
    shares.watch(around.parts._signals, "read", "reading the world")
    shares.watch(around.parts._signals, "drive", "driving the world")
    for name, part in around.parts.by_name.items():
        kind = bench.emulated.bench_file.parts[name].kind
        for call in ("feed", "before_step", "after_step", "advance", "receive"):
            if hasattr(part, call):
                shares.watch(part, call, kind)
    around.runner.before[:] = [shares.timed(call, "wiring") for call in around.runner.before]
    around.runner.after[:] = [shares.timed(call, "wiring") for call in around.runner.after]
    for machine in bench.emulated.machines.values():
        shares.watch(machine, "run_to", "chip")
        shares.watch(machine.engine, "_emu_start", "instructions")
    group = bench.emulated._group
    group.after_round[:] = [shares.timed(call, "pins into the journal") for call in group.after_round]
    total_s = block(rover, throttle)
    shares.spent_s["the bench around"] = total_s - sum(shares.spent_s.values())
    return {label: spent_s / total_s for label, spent_s in shares.spent_s.items()}


@pytest.mark.parametrize(("what", "scene", "throttle"), [
    ("at rest", "stand", 0.0), ("wheels in the air", "stand", 0.6), ("on the floor", "hard-floor", 0.6),
])  # fmt: skip
def test_the_rover(what, scene, throttle, capsys):
    with opened(scene) as (bench, rover):
        best_s = min(block(rover, throttle) for _ in range(BLOCKS))
        shares = shares_of(bench, rover, throttle)
        turned = bench.rover.wheel("wheel_lf").angle_rad
    parts = sorted(shares.items(), key=lambda share: -share[1])
    shown = ", ".join(f"{label} {100 * share:.0f} %" for label, share in parts if share >= 0.005)
    with capsys.disabled():
        print(f"\nrover {what}: {BLOCK_S / best_s:.2f} x real time\n  {shown}")  # noqa: T201 - what one runs it for
    assert (turned > 10) is (throttle > 0)
