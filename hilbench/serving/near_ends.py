"""A virtual target with its line in our hands: what a checker, a proxy or a program in this process has of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from hilbench.bench import Bench
from hilbench.benchfile.bench_file import BenchFile
from hilbench.errors import UsageError
from hilbench.links import Line, MemoryLink, Port
from hilbench.nearest import did_you_mean
from hilbench.serving.bench_faults import with_faults
from hilbench.serving.served_model import served_target

__all__ = ["NearEnd", "open_near_end"]


@dataclass(frozen=True, slots=True, kw_only=True)
class NearEnd:
    """Our end of a line.

    Attributes:
        name: the line.
        port: our end of it.
        step_ns: how far the target runs ahead of the bench, and takes what comes late, in ns.
        ended: says why the target will never go on; empty while it does.
        close: ends the target.
    """

    name: str
    port: Port
    step_ns: int = 0
    ended: Callable[[], str] = lambda: ""
    close: Callable[[], None] = lambda: None


def open_near_end(
    bench: Bench, bench_file: BenchFile, *, line: str = "", baud: int | None = None, seed: int = 0, real_time: bool
) -> NearEnd:
    """Bring the target of a bench file to life.

    Args:
        bench: whose time and journal are used.
        bench_file: what to build.
        line: which of its lines; where none is named, that of the checker, a board's console, or the first.
        baud: rate of the line, bit/s; None for that of the bench file, or what firmware sets.
        seed: of everything random.
        real_time: whether bench time is locked to the host's clock, so that chips may not run far ahead.

    Raises:
        UsageError: no such line, or the bench file does not fit together.
        UnavailableError: physics, engine or an image is missing.
    """
    if bench_file.boards:
        return _board(bench, bench_file, line, baud, seed, real_time=real_time)
    target = served_target(bench_file, baud=baud, seed=seed)
    name = _pick(line, tuple(target.lines), next(iter(target.lines)))
    links = {each: MemoryLink(bench.scheduler, Line(baud=rate), name=each) for each, rate in target.lines.items()}
    ends = {each: link.b for each, link in links.items()}
    close = target.make(bench, with_faults(bench, ends, bench_file, seed=seed))
    return NearEnd(name=name, port=links[name].a, close=close)


def _board(bench: Bench, bench_file: BenchFile, line: str, baud: int | None, seed: int, *, real_time: bool) -> NearEnd:
    from hilbench.mcu.emulated import EmulatedBench
    from hilbench.mcu.group import FREE_STEP_NS, LOCKED_STEP_NS
    from hilbench.serving.boards import free_usarts, usual_usarts

    free = free_usarts(bench_file)
    of_checker = bench_file.checker_lines.get("", "")
    name = _pick(line, free, of_checker if of_checker in free else (usual_usarts(bench_file) or free or [""])[0])
    step_ns = LOCKED_STEP_NS if real_time else FREE_STEP_NS
    emulated = EmulatedBench(bench_file, seed=seed, step_ns=step_ns, bench=bench)
    port = emulated.far_ends[name]
    if baud is not None:
        port.baud = baud
    return NearEnd(
        name=name,
        port=port,
        step_ns=step_ns,
        ended=lambda: "" if emulated.end is None else str(emulated.end),
        close=emulated.close,
    )


def _pick(line: str, names: Sequence[str], usual: str) -> str:
    """Return the line that is meant by its name, whole or behind the dot."""
    if not line:
        return usual
    fitting = [name for name in names if line in (name, name.partition(".")[2])]
    if len(fitting) != 1:
        message = "several lines are called so" if fitting else "no such line, or it is linked already"
        raise UsageError(message, where=f"line {line}", hint=did_you_mean(line, names, "lines"))
    return fitting[0]
