"""What stands on a live bench where nothing is real: the model of its file, or its emulated boards, and a client."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench.bench import Bench
from hilbench.bench.about import about_boards, about_world
from hilbench.bench.state_reporter import describe_machine
from hilbench.benchfile.bench_file import BenchFile
from hilbench.driving.rig import Rig
from hilbench.plugins.blame import checked
from hilbench.plugins.discovery import PLUGINS
from hilbench.protocol_bench.system import ProtocolSystem, system_of

if TYPE_CHECKING:
    from hilbench.mcu.emulated import EmulatedBench

__all__ = ["open_rig"]


def open_rig(bench: Bench, bench_file: BenchFile, *, seed: int) -> Rig:
    """Build the target of a bench file, and a client for it.

    Raises:
        UnavailableError: physics, engine or an image is missing.
        UsageError: the bench file does not fit together.
    """
    if not bench_file.boards:
        assert bench_file.model is not None
        return checked(system_of(bench_file.model).rig, Rig)(bench, bench_file, seed=seed)
    from hilbench.mcu.emulated import EmulatedBench
    from hilbench.mcu.group import LOCKED_STEP_NS

    emulated = EmulatedBench(bench_file, seed=seed, step_ns=LOCKED_STEP_NS, bench=bench)
    with contextlib.ExitStack() as undo:
        undo.callback(emulated.close)
        rig = _around(emulated, seed)
        undo.pop_all()
    return rig


def _around(emulated: EmulatedBench, seed: int) -> Rig:
    """Return what speaks to emulated boards, and the boards."""
    bench_file, surroundings = emulated.bench_file, emulated.surroundings
    asked = (checked(one.board_rig, Rig, or_none=True) for one in PLUGINS.systems.there())
    rig = next(filter(None, (board_rig(emulated, seed=seed) for board_rig in asked)), None)
    far_end = bench_file.checker_lines.get("", "")
    if rig is None and far_end in bench_file.protocols:
        rig = ProtocolSystem(bench_file.protocols[far_end]).board_rig(emulated, seed=seed)
    rig = rig or Rig()
    about = {"boards": about_boards(bench_file.boards), **about_world(surroundings.world), **rig.about}
    machines = rig.machines
    if surroundings.model is not None:
        machines = {**machines, **surroundings.model.machines}
        about["machines"] = {name: describe_machine(one) for name, one in machines.items()}
    return replace(
        rig,
        machines=machines,
        views={**rig.views, **_analog(emulated)},
        about=about,
        reset=lambda: _reset(emulated),
        stimulate=partial(_stimulate, emulated),
        ended=lambda: "" if emulated.end is None else str(emulated.end),
        close=emulated.close,
    )


def _analog(emulated: EmulatedBench) -> Mapping[str, Callable[[], Mapping[str, object]]]:
    """Return the view of what parts put on analog pins; none where no part does."""
    parts = emulated.surroundings.parts
    full_v = {name: machine.chip.pins.vdd_volts for name, machine in emulated.machines.items()}

    def look() -> Mapping[str, object]:
        return {"pins": {pin: [round(v, 4), full_v[pin.partition(".")[0]]] for pin, v in parts.volts().items()}}

    return {"volts": look} if parts.volts() else {}


def _stimulate(emulated: EmulatedBench, text: str) -> None:
    from hilbench.benchfile.stimulus import parse_stimulus

    emulated.stimuli.add(parse_stimulus(text, emulated.bench_file.boards, Path()))


def _reset(emulated: EmulatedBench) -> None:
    for machine in emulated.machines.values():
        machine.reset()
