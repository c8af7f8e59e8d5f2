"""The boards that are measured: the behavioural model, and our firmware on the emulated chip."""

from __future__ import annotations

import contextlib
import random
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path

from hilbench.bench import Bench
from hilbench.bench.devices import LinesActor
from hilbench.benchfile.reader import read_bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.mcu.emulated import EmulatedBench
from hilbench.systems.vehicle.simulator_peer import SimulatorPeer
from hilbench.systems.vehicle.stack_peer import StackPeer
from measure.deadlines.measure import BAUD, Rig
from targets.robots.vehicle_interface.behaviour import BEHAVIOURS
from targets.robots.vehicle_interface.board import SIMULATOR_LINE, STACK_LINE, VehicleInterface
from targets.robots.vehicle_interface.settings import VehicleSettings

__all__ = ["RIGS", "board_rig", "model_rig"]

BENCH = Path(__file__).parent / "h753.toml"
IMAGES = Path(__file__).parents[2] / "targets" / "firmware" / "images"


@contextlib.contextmanager
def model_rig(profile: str, seed: int, **changes: object) -> Iterator[Rig]:
    """A behavioural board of a profile on a bench in virtual time; `changes` are other options of its modes."""
    bench = Bench(Scheduler(), Journal())
    links = {line: MemoryLink(bench.scheduler, Line(baud=BAUD), name=line) for line in (SIMULATOR_LINE, STACK_LINE)}
    rig = Rig(
        bench=bench,
        simulator=SimulatorPeer(bench, links[SIMULATOR_LINE].a),
        stack=StackPeer(bench, links[STACK_LINE].a),
        chance=random.Random(seed),
    )
    behaviour = BEHAVIOURS[profile]
    behaviour = replace(behaviour, board=replace(behaviour.board, **changes))  # type: ignore[arg-type]
    board = VehicleInterface(VehicleSettings(), behaviour=behaviour)
    LinesActor(bench, board, {line: link.b for line, link in links.items()}, name="board")
    yield rig


@contextlib.contextmanager
def board_rig(image: str, seed: int) -> Iterator[Rig]:
    """An emulated NUCLEO-H753ZI with one of our images, in virtual time."""
    bench_file = read_bench(BENCH)
    brain = replace(bench_file.boards["brain"], firmware=IMAGES / f"{image}.elf")
    bench = Bench(Scheduler(), Journal())
    with contextlib.closing(EmulatedBench(replace(bench_file, boards={"brain": brain}), seed=0, bench=bench)) as there:
        ports = [there.ports[f"brain.{line}"] for line in (SIMULATOR_LINE, STACK_LINE)]
        for port in ports:
            port.reacts = True
        yield Rig(
            bench=bench,
            simulator=SimulatorPeer(bench, ports[0]),
            stack=StackPeer(bench, ports[1]),
            chance=random.Random(seed),
        )


RIGS: Mapping[str, Callable[[int], contextlib.AbstractContextManager[Rig]]] = {
    "model, hardened": partial(model_rig, "hardened"),
    "model, v0": partial(model_rig, "v0"),
    "firmware, hardened": partial(board_rig, "vehicle"),
    "firmware, v0": partial(board_rig, "vehicle-v0"),
}
"""By the names that they have on the page."""
