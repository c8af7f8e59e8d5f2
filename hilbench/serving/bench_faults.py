"""The faults of a bench file on the lines of a virtual target."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from hilbench.bench import Bench
from hilbench.bench.line_faults import LineFaults
from hilbench.benchfile.bench_file import BenchFile
from hilbench.links import Port

__all__ = ["with_faults"]


def with_faults(
    bench: Bench,
    ports: Mapping[str, Port],
    bench_file: BenchFile,
    *,
    seed: int,
    on_refused: Callable[[str], None] | None = None,
) -> Mapping[str, Port]:
    """Return the target's ends of the lines, with the faults of the bench file on them.

    Args:
        bench: whose time and journal are used.
        ports: the ends by the names of their lines.
        bench_file: what faults there are, and of which link.
        seed: decides where random faults strike.
        on_refused: takes a line about a fault that a port cannot have.
    """
    if not bench_file.faults:
        return ports
    faults = LineFaults(bench, bench_file.faults, seed=seed, near_is_client=False)
    if on_refused is not None:
        faults.on_refused = on_refused
    ends = {line: line.rpartition(".")[2] for line in ports}
    links = {line: bench_file.link_of(end, [*ends.values()]) if len(ports) > 1 else 0 for line, end in ends.items()}
    return {line: faults.on(port, links[line]) for line, port in ports.items()}
