"""A live bench with something real: what somebody else runs at serial ports, and nobody drives unasked."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hilbench.bench import Bench
from hilbench.benchfile.bench_file import BenchFile
from hilbench.benchfile.target_grammar import TargetKind, target_of
from hilbench.driving.rig import Rig
from hilbench.errors import UsageError
from hilbench.plugins.blame import checked
from hilbench.plugins.discovery import PLUGINS
from hilbench.plugins.system import System
from hilbench.protocol_bench.system import ProtocolSystem, system_of
from hilbench.terminal.options import TargetChoice

__all__ = ["open_attached", "ports_asked"]


def open_attached(bench: Bench, bench_file: BenchFile, targets: Sequence[TargetChoice], *, seed: int) -> Rig:
    """Attach to what is at serial ports or behind pyserial URLs.

    Args:
        bench: whose time passes.
        bench_file: says which protocol is spoken, and on which lines.
        targets: as ``serial:/dev/ttyACM0@115200``; one for each line, by its name where there are several.
        seed: decides what chance decides in faults.

    Raises:
        UsageError: a target is no serial port, a line has none, or the bench has no line that a client of ours could
            speak on.
        UnavailableError: a port cannot be opened.
    """
    ports = ports_asked(bench_file, targets)
    return checked(_system_at(bench_file).attached_rig, Rig)(bench, bench_file, ports, seed=seed)


def ports_asked(bench_file: BenchFile, targets: Sequence[TargetChoice]) -> Mapping[str, str]:
    """Return what is asked for at the far end of each line of ours, by its name; of a line without one, by nothing.

    Raises:
        UsageError: a target is no serial port, a line has none, or two.
    """
    for choice in targets:
        if target_of(choice).kind is not TargetKind.SERIAL:
            hint = "write serial:/dev/ttyUSB0@115200 or a pyserial URL"
            raise UsageError("is no serial port", where=choice.where, hint=hint)
    return checked(_system_at(bench_file).lines_asked, Mapping)(bench_file, targets)


def _system_at(bench_file: BenchFile) -> System:
    """Return whose clients speak to what stands for this bench: those of its model, or of what its boards speak."""
    if bench_file.model is not None and not bench_file.boards:
        return system_of(bench_file.model)
    protocol = bench_file.protocols.get(bench_file.checker_lines.get("", ""))
    if protocol is not None:
        return ProtocolSystem(protocol)
    found = next((system for system in PLUGINS.systems.there() if system.speaks_to(bench_file)), None)
    if found is None:
        where = f"bench '{bench_file.name}'"
        raise UsageError("no client of ours speaks to its boards", where=where, hint="leave out --target")
    return found
