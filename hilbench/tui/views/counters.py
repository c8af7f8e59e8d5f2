"""The counters of every machine, with their rates."""

from __future__ import annotations

from collections.abc import Iterator

from rich.text import Text

from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.machines import MachineModel
from hilbench.tui.model.rates import Counted
from hilbench.tui.views.words import BAD, DIM, HEAD, fit, rate_words

__all__ = ["counters_view"]

_WITH_RATE = 19
_NAMES = 19
_SIDE_BY_SIDE = 2
_MANY = 24
_ALWAYS = frozenset({"bytes_in", "bytes_out", "frames_in", "frames_out", "noise"})


def counters_view(model: BenchModel, width: int) -> list[Text]:
    """Return the counters of every machine with their rates; what counts errors is marked once it has counted.

    Machines that count the same things stand side by side, others below. Of many counters those that have counted
    nothing are left out, and how many they are is said.
    """
    blocks: dict[tuple[str, ...], list[MachineModel]] = {}
    for machine in model.machines.values():
        if machine.counters:
            blocks.setdefault(tuple(machine.counters), []).append(machine)
    lines: list[Text] = []
    for machines in _joined(list(blocks.values())):
        lines += [fit(line, width) for line in _block(machines, width, model)]
    return lines or [Text("nothing is counted yet", DIM)]


def _joined(blocks: list[list[MachineModel]]) -> list[list[MachineModel]]:
    """Join the blocks that have room side by side: two ends that do not count quite the same are still compared."""
    everyone = [machine for block in blocks for machine in block]
    return [everyone] if len(everyone) <= _SIDE_BY_SIDE else blocks


def _block(machines: list[MachineModel], width: int, model: BenchModel) -> Iterator[Text]:
    traffic = model.dashboard.traffic
    names = dict.fromkeys(name for machine in machines for name in machine.counters)
    shown = [name for name in names if len(names) <= _MANY or name in _ALWAYS or _counted(machines, name)]
    column = max(8, (width - _NAMES) // max(1, len(machines)))
    yield Text(f"{'':<{_NAMES}}" + "".join(f"{machine.name:>{column}}" for machine in machines), HEAD)
    for name in sorted(shown, key=lambda one: one not in traffic):
        line = Text(f"{name.replace('_', ' '):<{_NAMES}}")
        for machine in machines:
            now_ns = model.ns if column >= _WITH_RATE else None
            line.append_text(_cell(machine.counters.get(name), column, now_ns, "" if name in traffic else BAD))
        yield line
    if len(shown) < len(names):
        yield Text(f"and {len(names) - len(shown)} more, all 0", DIM)


def _counted(machines: list[MachineModel], name: str) -> bool:
    return any(machine.counters[name].value for machine in machines if name in machine.counters)


def _cell(counted: Counted | None, column: int, now_ns: int | None, style: str) -> Text:
    if counted is None:
        return Text(f"{'-':>{column}}", DIM)
    said = str(counted.value) if now_ns is None else f"{counted.value} {rate_words(counted.per_s(now_ns)):>9}"
    return Text(f"{said:>{column}}", style if counted.value else DIM)
