"""`hilbench run`: emulated boards in virtual time, until they end or their time is up."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from hilbench.benchfile.bench_file import BenchFile
from hilbench.clock import NS_PER_S, MonotonicHostClock, Stopwatch, deferred_interrupts
from hilbench.errors import UnavailableError, UsageError
from hilbench.exit_codes import ExitCode
from hilbench.files.names import json_text
from hilbench.judging.note_lines import note_lines, notes_counted
from hilbench.mcu.coverage import Coverage
from hilbench.mcu.emulated import EmulatedBench, MachineFactory, make_machine
from hilbench.mcu.group import FREE_STEP_NS, LOCKED_STEP_NS
from hilbench.mcu.narration import Narrator
from hilbench.mcu.pictures import check_displays, save_pictures
from hilbench.mcu.stimulus_writer import StimulusWriter
from hilbench.mcu.stops import set_stops
from hilbench.mcu.usart_port import UsartPort
from hilbench.serving import STOP_SIGNALS
from hilbench.terminal.console import Console

__all__ = ["RunOptions", "run"]

_PATIENCE_S = 1.0
_REFRESH_S = 0.25


@dataclass(frozen=True, slots=True, kw_only=True)
class RunOptions:
    """What ``hilbench run`` was asked to do.

    Attributes:
        for_ns: bench time to run; None until the firmware ends.
        follow: tell what happens, line by line.
        journal: where to write the journal.
        journal_max: how large it and the part before it may get together, in bytes; None for no limit.
        edges: tell the edges of pins that send serial frames, too.
        vcd: where to write waveforms.
        write_stimuli: where to write what the boards did, as stimuli for others.
        coverage: where to write which lines of the firmware were executed.
        breaks: before which functions or addresses to end.
        watches: before writes to which variables or addresses to end.
        pictures: displays, and where to write what they show at the end.
        realtime: keep pace with the wall clock.
        as_json: say how it went as JSON.
        seed: seed of the run.
        each_note: a line for each note; else those of one cause share one.
    """

    for_ns: int | None = None
    follow: bool = False
    edges: bool = False
    journal: Path | None = None
    journal_max: int | None = None
    vcd: Path | None = None
    write_stimuli: Path | None = None
    coverage: Path | None = None
    breaks: tuple[str, ...] = ()
    watches: tuple[str, ...] = ()
    pictures: tuple[tuple[str, Path], ...] = ()
    realtime: bool = False
    as_json: bool = False
    seed: int = 0
    each_note: bool = False


def run(
    options: RunOptions, bench_file: BenchFile, console: Console, *, make_machine: MachineFactory = make_machine
) -> ExitCode:
    """Run a bench.

    Returns:
        OK when the time is up or the firmware has ended with status 0; VIOLATION when it has ended in any other way;
        INTERRUPTED.

    Raises:
        UsageError: no board in this bench; an image cannot run on its board.
        UnavailableError: something is missing, or a file cannot be written.
    """
    _check(options, bench_file)
    step_ns = LOCKED_STEP_NS if options.realtime else FREE_STEP_NS
    emulated = EmulatedBench(
        bench_file,
        seed=options.seed,
        journal=options.journal,
        journal_max=options.journal_max,
        vcd=options.vcd,
        step_ns=step_ns,
        edges_of_frames=options.edges,
        make_machine=make_machine,
    )
    if not options.realtime:
        emulated.pass_over_sleep()
    watch = Stopwatch()
    with contextlib.ExitStack() as open_files:
        open_files.callback(emulated.close)
        narrator = Narrator(emulated, console.data, each_note=options.each_note) if options.follow else None
        if options.write_stimuli is not None:  # behind the narrator, whom it lets hear everything
            emulated.at_close.append(StimulusWriter(options.write_stimuli, emulated).close)
        emulated.at_close.append(partial(save_pictures, options.pictures, emulated))
        set_stops(emulated, options.breaks, options.watches)
        coverage = None
        if options.coverage is not None:
            coverage = Coverage(emulated)
            emulated.at_close.append(partial(coverage.write, options.coverage))
        interrupted = _run(options, emulated, console, watch)
        if narrator is not None:
            narrator.finish()
        executed = None if coverage is None else coverage.counted()
        report = _Report(emulated, watch.elapsed_s(), executed, interrupted=interrupted, each_note=options.each_note)
        data, text = report.data(), report.text()
        # How it went is reported when nothing can go wrong any more: a full disk may have no room for the last lines.
        try:
            open_files.close()
        except UnavailableError as error:
            console.narrate(text)
            raise error from None
    if options.as_json:
        console.data(json_text(data))
    else:
        console.narrate(text)
    return report.exit_code


def _check(options: RunOptions, bench_file: BenchFile) -> None:
    if not bench_file.boards:
        raise UsageError(
            "runs no firmware", where=bench_file.name, hint=f"serve it: hilbench serve {bench_file.name} --pty ./p2"
        )
    check_displays((name for name, _ in options.pictures), bench_file)
    if options.follow and options.as_json:
        raise UsageError("--follow and --json both want the standard output", where="run", hint="choose one")


def _run(options: RunOptions, emulated: EmulatedBench, console: Console, watch: Stopwatch) -> bool:
    """Run; return whether somebody has interrupted it."""
    scheduler = emulated.bench.scheduler
    # Lines that tell what happens are progress enough, and would get mixed up with another one.
    progress = contextlib.nullcontext(_show_nothing) if options.follow else console.progress()
    with _pace(emulated, realtime=options.realtime), progress as show:
        ticker = _Progress(emulated, watch, show)
        try:
            with deferred_interrupts(scheduler, STOP_SIGNALS):
                scheduler.run_until(lambda: emulated.end is not None or ticker.tick(), options.for_ns)
        except KeyboardInterrupt:
            return True
    return False


@contextlib.contextmanager
def _pace(emulated: EmulatedBench, *, realtime: bool) -> Iterator[None]:
    if not realtime:
        yield
        return
    host = MonotonicHostClock()
    emulated.bench.scheduler.lock(host)
    try:
        yield
    finally:
        emulated.bench.scheduler.unlock()
        host.close()


def _show_nothing(_text: str) -> None:
    """Stand in for what shows progress."""


class _Progress:
    """Shows how far the run is, if it takes long."""

    def __init__(self, emulated: EmulatedBench, watch: Stopwatch, show: Callable[[str], None]) -> None:
        self._bench = emulated.bench
        self._watch = watch
        self._show = show
        self._next_s = _PATIENCE_S
        self._calls = 0

    def tick(self) -> bool:
        """Look at the host's clock now and then; always False."""
        self._calls += 1
        if not self._calls & 63 and (elapsed_s := self._watch.elapsed_s()) >= self._next_s:
            self._next_s = elapsed_s + _REFRESH_S
            self._show(f"{self._bench.now_s:.1f} s of bench time, {self._bench.now_s / elapsed_s:.2f} x real time")
        return False


class _Report:
    """How it went."""

    def __init__(
        self,
        emulated: EmulatedBench,
        host_s: float,
        executed: tuple[int, int] | None,
        *,
        interrupted: bool,
        each_note: bool,
    ) -> None:
        self._executed = executed
        self._emulated = emulated
        self._each_note = each_note
        self._host_s = host_s
        self._interrupted = interrupted
        self._bench_s = (emulated.end.ns if emulated.end else emulated.bench.now_ns) / NS_PER_S

    @property
    def exit_code(self) -> ExitCode:
        """What the process says."""
        if self._interrupted:
            return ExitCode.INTERRUPTED
        end = self._emulated.end
        return ExitCode.OK if end is None or end.good else ExitCode.VIOLATION

    def data(self) -> dict[str, object]:
        """Return it as plain data."""
        end = self._emulated.end
        return {
            "bench": self._emulated.bench_file.name,
            "bench_time_s": self._bench_s,
            "real_time_factor": round(self._bench_s / self._host_s, 4) if self._host_s else None,
            "end": None
            if end is None
            else {
                "board": end.board,
                "kind": end.kind,
                "status": end.status,
                "ns": end.ns,
                "pc": end.pc,
                "place": end.place,
                "cause": end.cause,
            },
            "lines": {
                name: {"sent": port.counters.received, "framing_errors": port.counters.framing_errors}
                for name, port in self._emulated.ports.items()
            },
            "waiting": dict(self._waiting()),
            "starting": {name: dict(self._emulated.starting(name)) for name in self._emulated.machines},
            "resets": [
                {"board": board, "reason": reason, "count": resets.count, "last_ns": resets.last_ns}
                for (board, reason), resets in self._emulated.resets.items()
            ],
            "notes": self._emulated.notes(),
            **self._covered(),
            "exit_code": int(self.exit_code),
        }

    def _covered(self) -> dict[str, object]:
        if self._executed is None:
            return {}
        executed, lines = self._executed
        return {"coverage": {"executed": executed, "lines": lines}}

    def text(self) -> str:
        """Return it as lines for a person."""
        lines = []
        if self._emulated.end is not None:
            lines.append(f"hilbench: {self._emulated.end}")
        factor = self._bench_s / self._host_s if self._host_s else 0
        stopped = "interrupted after" if self._interrupted else "ran"
        lines.append(f"{stopped} {self._bench_s:.6f} s of bench time at {factor:.2f} x real time")
        lines += [f"  {name}: {port.counters.received} bytes sent" for name, port in self._used_lines()]
        for (board, reason), resets in self._emulated.resets.items():
            times = f"{resets.count} resets, the last" if resets.count > 1 else "1 reset,"
            lines.append(f"  {board}: {times} at {resets.last_ns / NS_PER_S:.6f} s ({reason})")
        lines += [f"  {name}: {text}, at the end" for name, text in self._waiting()]
        lines += [
            f"  {name}: {clock} starts, and is ready at {ready_ns / NS_PER_S:.6f} s"
            for name in self._emulated.machines
            for clock, ready_ns in self._emulated.starting(name).items()
        ]
        if self._executed is not None:
            hit, there = self._executed
            lines.append(f"  coverage: {hit} of {there} lines of the firmware executed ({hit / there:.1%})")
        return "\n".join(lines + self._note_lines())

    def _note_lines(self) -> list[str]:
        notes = self._emulated.notes()
        lines = note_lines(notes, each=self._each_note)
        if not lines:
            return []
        head = notes_counted(len(notes), len(lines), " (--notes all for each)")
        return [f"{head}:", *(f"  {line}" for line in lines)]

    def _waiting(self) -> list[tuple[str, str]]:
        """Return which boards wait in a loop at the end, and where."""
        if self._emulated.end is not None:
            return []
        waiting = [(name, self._emulated.waiting(name)) for name in self._emulated.machines]
        return [(name, text) for name, text in waiting if text]

    def _used_lines(self) -> Iterator[tuple[str, UsartPort]]:
        return ((name, port) for name, port in self._emulated.ports.items() if port.counters.received)
