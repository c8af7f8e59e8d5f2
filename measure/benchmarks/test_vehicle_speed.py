"""How fast the benches of the vehicle interface are beside real time, and where the time goes.

Figures are of CPU time and are printed; nothing is asserted on time. The driving stack commands 30 times a second, the
simulator says statuses 20 times a second, or the joystick rules, or nobody says anything. Each block begins where the
one before has ended; the best of them counts. Looking at where the time goes makes what is called often look more
expensive than it is, so that is done in a block of its own. Run by `make bench`.

What a byte costs is measured as served in real time, beside milliseconds without bytes.
"""

from __future__ import annotations

import contextlib
import statistics
import time

import pytest

from hilbench.check import CheckOptions
from hilbench.check.bench_provider import make_provider
from hilbench.clock import NS_PER_MS
from hilbench.judging.provider import CaseInfo, CaseSetup
from hilbench.mcu.group import LOCKED_STEP_NS
from hilbench.suites._vehicle import Vehicle, vehicle_bench
from hilbench.testing import FakeHostClock
from protocols.carla import Mode

BLOCKS, BLOCK_S = 4, 1.0
MILLISECONDS = 2000
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


class Served:
    """The emulated board as it is served, on a host that is never late: nobody at the lines answers at once."""

    def __init__(self, emulated):
        self.moved = 0
        for port in emulated.ports.values():
            port.reacts = False
            port.taps.append(self._count)
            port.heard_taps.append(self._count)
        emulated._group._step_ns = emulated._group.turn_ns = LOCKED_STEP_NS
        self._scheduler = emulated.bench.scheduler
        self._scheduler.lock(FakeHostClock())

    def _count(self, data, _at_ns):
        self.moved += len(data)

    def millisecond(self):
        """Return how many bytes a millisecond has moved, in and out, and its CPU seconds."""
        before, began = self.moved, time.process_time()
        self._scheduler.run_until(None, self._scheduler.now_ns + NS_PER_MS)
        return self.moved - before, time.process_time() - began


def test_a_byte_by_dma(capsys):
    with opened("vehicle", "AUTOWARE") as (bench, _vehicle):
        served = Served(bench.emulated)
        taken = [served.millisecond() for _ in range(MILLISECONDS)]
    quiet_s = statistics.median(took_s for moved, took_s in taken if not moved)
    busy = [(moved, took_s - quiet_s) for moved, took_s in taken if moved > 20]
    byte_s = statistics.median(more_s / moved for moved, more_s in busy)
    assert sum(moved for moved, _ in busy) > MILLISECONDS  # most of what is said, and enough of it
    with capsys.disabled():
        about = f"{byte_s * 1e6:.0f} us of CPU time, {byte_s / quiet_s:.2f} of a millisecond without bytes"
        print(f"\na byte at 921600 baud by DMA and USART, in or out: {about}")  # noqa: T201 - what one runs it for
