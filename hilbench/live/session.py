"""A live bench from its beginning to its end: built, run in real time, paused, and closed in good order."""

from __future__ import annotations

import contextlib
import json
import os
import signal
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from hilbench.bench import Bench
from hilbench.bench.lateness_log import LatenessLog
from hilbench.bench.state_reporter import StateReporter
from hilbench.benchfile.bench_file import BenchFile
from hilbench.clock import NS_PER_S, MonotonicHostClock, ScaledHostClock, Scheduler, deferred_interrupts
from hilbench.driving.control import Control
from hilbench.driving.driver import Driver, Drives
from hilbench.driving.rig import Rig
from hilbench.errors import UnavailableError
from hilbench.exit_codes import ExitCode
from hilbench.journal import Journal
from hilbench.live.actions import Actions
from hilbench.live.attached import open_attached
from hilbench.live.folders import Session
from hilbench.live.rigs import open_rig
from hilbench.serving import STOP_SIGNALS, signals_held
from hilbench.terminal.console import Console
from hilbench.terminal.options import TargetChoice

__all__ = ["JOURNAL_BYTES", "LINGER_NS", "LiveBench", "LiveOptions", "run_live"]

JOURNAL_BYTES = 64 * 1024 * 1024
"""What a live journal may take on disk; the older half is forgotten first. A choice: some two hours of a robot that
reports ten times a second."""
LINGER_NS = 60 * NS_PER_S
"""How long a bench goes on whose dashboard has died without a word (choice)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class LiveOptions:
    """What a live bench was asked to be.

    Attributes:
        session: where it lives.
        seed: of everything random.
        demo: whether the demo driver begins.
        journal: where the journal is written instead of the folder of the session.
        targets: serial ports or pyserial URLs in the place of the target of the bench file; none for that.
    """

    session: Session
    seed: int = 0
    demo: bool = True
    journal: Path | None = None
    targets: Sequence[TargetChoice] = ()


class LiveBench:
    """The bench, built but not running.

    Args:
        bench_file: what to build.
        options: how.

    Raises:
        UsageError: the bench file does not fit together.
        UnavailableError: something it needs is missing.
    """

    def __init__(self, bench_file: BenchFile, options: LiveOptions) -> None:
        self._undo = contextlib.ExitStack()
        self._reported: tuple[bool, float] | None = None
        with contextlib.ExitStack() as undo:
            self.bench = Bench(Scheduler(), Journal())
            if options.targets:
                rig = open_attached(self.bench, bench_file, options.targets, seed=options.seed)
            else:
                rig = open_rig(self.bench, bench_file, seed=options.seed)
            undo.callback(rig.close)
            self.rig: Rig = rig
            self._write_journal(bench_file, options)
            undo.callback(lambda: self.bench.journal.close(self.bench.now_ns))
            self.driver = _driver(self.bench, rig, demo=options.demo and rig.demo)
            self.actions = Actions(self.bench, rig, self.driver)
            self.reporter = StateReporter(self.bench, rig.machines, rig.taps, senses=rig.senses, views=rig.views)
            self.reporter.standing = self.actions.standing
            self.reporter.after += [tap.flush for tap in rig.taps.values()]
            if options.targets:
                self.reporter.after.append(LatenessLog(self.bench, "bench").look)
            self.control = Control(self.bench.scheduler, options.session.socket, self.actions.obey)
            undo.callback(self.control.close)
            self._undo = undo.pop_all()

    def close(self) -> None:
        """Hang up, complete the journal, give everything back."""
        self._undo.close()

    def run(self) -> None:
        """Run until somebody asks for the end, or nobody is there any more.

        Raises:
            KeyboardInterrupt: a signal came.
        """
        host = MonotonicHostClock()
        try:
            while not self._over():
                if self.actions.paused and not self.actions.step_ns:
                    self._stand_still()
                else:
                    self._run_locked(host)
        finally:
            host.close()

    def _stand_still(self) -> None:
        """Wait until something is asked for; a speed that is asked for meanwhile is reported at once."""
        self._tell_clock(paused=True)
        self.bench.journal.flush_step()
        self.control.wait()

    def _tell_clock(self, *, paused: bool) -> None:
        if (paused, self.actions.speed) != self._reported:
            self._reported = paused, self.actions.speed
            self.bench.record("clock", "bench", paused=paused, speed=self.actions.speed)

    def _run_locked(self, host: MonotonicHostClock) -> None:
        """Let bench time pass until it is to stand still, or to pass at another speed."""
        scheduler, actions = self.bench.scheduler, self.actions
        speed, step_ns = actions.speed, actions.step_ns
        actions.step_ns = 0
        deadline_ns = scheduler.now_ns + step_ns if step_ns else None

        def is_over() -> bool:
            return (actions.paused and not step_ns) or actions.speed != speed or self._over()

        scheduler.lock(host if speed == 1 else ScaledHostClock(host, speed))
        self._tell_clock(paused=False)
        try:
            scheduler.run_until(is_over, deadline_ns)
        finally:
            scheduler.unlock()

    def _over(self) -> bool:
        control = self.control
        abandoned = (
            control.left_ns is not None
            and not control.farewell
            and (self.actions.paused or self.bench.now_ns - control.left_ns > LINGER_NS)
        )
        return self.actions.stopped or abandoned

    def _write_journal(self, bench_file: BenchFile, options: LiveOptions) -> None:
        """Write the journal from now on, with what building the bench has put there."""
        path = options.journal or options.session.journal
        header = bench_file.header(options.seed) | {"live": dict(self.rig.about)}
        self.bench.journal = Journal(path, header, max_bytes=JOURNAL_BYTES, after=self.bench.journal)


def _driver(bench: Bench, rig: Rig, *, demo: bool) -> Drives | None:
    if rig.drive is not None:
        return rig.drive(demo)
    return None if rig.operator is None else Driver(bench, rig.operator, demo=demo)


def run_live(bench_file: BenchFile, options: LiveOptions) -> ExitCode:
    """Build a live bench and run it to its end.

    Raises:
        UsageError, UnavailableError: see `LiveBench`; or the journal can no longer be written.
    """
    with signals_held(), contextlib.ExitStack() as stack:
        stack.callback(options.session.hold().release)
        live = LiveBench(bench_file, options)
        stack.callback(live.close)
        _describe(bench_file, options, live)
        Console().data(f"live in {options.session.folder}")
        with deferred_interrupts(live.bench.scheduler, STOP_SIGNALS), contextlib.suppress(KeyboardInterrupt):
            before = signal.pthread_sigmask(signal.SIG_BLOCK, ())
            try:
                signal.pthread_sigmask(signal.SIG_UNBLOCK, STOP_SIGNALS)  # one that waits comes here
                live.run()
            finally:
                signal.pthread_sigmask(signal.SIG_SETMASK, before)
    return ExitCode.OK


def _describe(bench_file: BenchFile, options: LiveOptions, live: LiveBench) -> None:
    """Say what this is; whoever finds it knows that the bench has begun."""
    about = {
        "bench": bench_file.name,
        "pid": os.getpid(),
        "journal": str(options.journal or options.session.journal),
        "actions": live.actions.names,
        "file": str(bench_file.path.absolute()) if bench_file.path is not None else "",
        "suites": bench_file.suites if not options.targets and bench_file.path is not None else (),
    }
    beside = options.session.about.with_suffix(".new")
    try:
        beside.write_text(json.dumps(about))
        beside.replace(options.session.about)
    except OSError as error:
        raise UnavailableError(f"cannot be written: {error.strerror}", where=str(options.session.about)) from error
