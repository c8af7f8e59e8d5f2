"""How fast the benches of the vehicle interface are beside real time, and where the time goes.

Figures are of CPU time and are printed; nothing is asserted on time. The driving stack commands 30 times a second, the
simulator says statuses 20 times a second, or the joystick rules, or nobody says anything. Each block begins where the
one before has ended; the best of them counts. Looking at where the time goes makes what is called often look more
expensive than it is, so that is done in a block of its own. Run by `make bench`.
"""

from __future__ import annotations

import contextlib
import time

import pytest

from hilbench.bench_provider import make_provider
from hilbench.check import CheckOptions
from hilbench.check.provider import CaseInfo, CaseSetup
from hilbench.suites._vehicle import Vehicle, vehicle_bench
from protocols.carla import Mode

BLOCKS, BLOCK_S = 4, 1.0
MODES = {"AUTOWARE": Mode.AUTOWARE, "MANUAL": Mode.MANUAL, "EMERGENCY": Mode.EMERGENCY}


@contextlib.contextmanager
def opened(name, mode):
    provider = make_provider(CheckOptions(bench=name, suites=("vehicle-board",)))
    info = CaseInfo(id="speed", clause_ids=(), seed=0, setup=CaseSetup(program="hardened"))
    with provider.open_case(info) as bench:
        vehicle = Vehicle(vehicle_bench(bench))
        {"AUTOWARE": vehicle.autoware, "MANUAL": vehicle.manual, "EMERGENCY": vehicle.emergency}[mode]()
        yield bench, vehicle
        bench.finish("pass", "")
    provider.close()


def block(vehicle):
    """Return the CPU seconds of `BLOCK_S` of bench time."""
    began = time.process_time()
    vehicle.run(BLOCK_S)
    return time.process_time() - began


@pytest.mark.parametrize("mode", MODES)
def test_the_model(mode, shares, show):
    with opened("vehicle-model", mode) as (bench, vehicle):
        best_s = min(block(vehicle) for _ in range(BLOCKS))
        for call in ("receive", "advance"):
            shares.watch(bench.board, call, "board")
        shares.watch(bench.simulator, "_read", "checker's reading")
        parts = shares.of(block(vehicle))
        assert vehicle.simulator.modes()[-1] == MODES[mode]
    show(f"model of the vehicle interface in {mode}", BLOCK_S / best_s, parts)


@pytest.mark.parametrize("mode", MODES)
def test_the_emulated_board(mode, shares, show):
    with opened("vehicle", mode) as (bench, vehicle):
        best_s = min(block(vehicle) for _ in range(BLOCKS))
        shares.watch_bench(bench.emulated)
        parts = shares.of(block(vehicle))
        assert vehicle.simulator.modes()[-1] == MODES[mode]
    show(f"emulated vehicle interface in {mode}", BLOCK_S / best_s, parts)
