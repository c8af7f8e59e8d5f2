"""What may be wrong with a bench itself: the settings of its parts, and how they are soldered."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from hilbench.benchfile.bench_file import TerminalEnd
from hilbench.benchfile.reader import BenchFile

__all__ = ["Alteration", "setting", "swapped"]

Alteration = Callable[[BenchFile], BenchFile]


def setting(wrong: str, **settings: object) -> Alteration:
    """Set something wrong on a part, or on all parts of a kind."""

    def alter(bench_file: BenchFile) -> BenchFile:
        parts = {
            name: replace(plan, settings=replace(plan.settings, **settings)) if wrong in (name, plan.kind) else plan
            for name, plan in bench_file.parts.items()
        }
        return replace(bench_file, parts=parts)

    return alter


def swapped(one: str, other: str) -> Alteration:
    """Solder the wires of two terminals the other way round, wherever both are."""
    ends = _end(one), _end(other)
    change = dict(zip(ends, reversed(ends), strict=True))

    def alter(bench_file: BenchFile) -> BenchFile:
        nets = [replace(net, terminals=tuple(change.get(end, end) for end in net.terminals)) for net in bench_file.nets]
        return replace(bench_file, nets=tuple(nets))

    return alter


def _end(terminal: str) -> TerminalEnd:
    part, _, name = terminal.partition(".")
    return TerminalEnd(part=part, terminal=name)
