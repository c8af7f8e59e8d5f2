"""Runs the cases of a run in several processes, each of which is given one case after the other.

Each of them reads the suites and plans the run by itself, as this one has: a case's seed and bench are its own, so
nothing depends on who runs it, or when. Results are entered as they come and stand in the order of the plan, and so do
the cases in the journal. A process that dies costs the case that it ran; another one takes its place.
"""

from __future__ import annotations

import contextlib
import signal
import socket
import subprocess
import sys
import tempfile
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from hilbench.check.adding_up import added_up
from hilbench.check.collector import Collector, PlannedCase
from hilbench.check.evaluate import make_report
from hilbench.check.given import Draw, Given, Over, ProviderFactory, Ran, Refused
from hilbench.check.results import CaseResult, Report
from hilbench.clock import Stopwatch
from hilbench.errors import UnavailableError
from hilbench.judging.observations import Observations
from hilbench.judging.provider import Lines
from hilbench.judging.verdicts import Verdict
from hilbench.terminal.options import CheckOptions

if TYPE_CHECKING:
    from hilbench.check.plugin import ProgressCallback, ResultCallback

__all__ = ["Crew"]

_ENDED_BY_OTHERS = (-signal.SIGKILL, -signal.SIGTERM, -signal.SIGHUP)
"""What a process ends with that has done nothing wrong itself, as where there is no memory left."""


@dataclass(slots=True)
class _Worker:
    """A process that runs cases.

    Attributes:
        process: it.
        connection: to it.
        part: the journal that it writes; empty if there is none.
        done_bytes: how much of that belongs to cases that are over.
        case: what it runs at present.
    """

    process: subprocess.Popen[bytes]
    connection: Connection
    part: str
    done_bytes: int = 0
    case: PlannedCase | None = None


@dataclass(slots=True)
class _Journal:
    """Puts the cases of all workers into one journal, in the order of the plan.

    Attributes:
        lines: that journal.
        order: the cases that are not in it yet.
        parts: of those that have run the file, and from where to where in it.
    """

    lines: Lines
    order: deque[str]
    parts: dict[str, tuple[str, int, int]] = field(default_factory=dict)

    def take(self, case_id: str, part: str, begin: int, end: int) -> None:
        """A case is over; raises UnavailableError."""
        self.parts[case_id] = part, begin, end
        while self.order and self.order[0] in self.parts:
            self._put(self.order.popleft())

    def finish(self) -> None:
        """Nothing more will run: add what has run out of turn; raises UnavailableError."""
        for case_id in self.order:
            if case_id in self.parts:
                self._put(case_id)
        self.order.clear()

    def _put(self, case_id: str) -> None:
        part, begin, end = self.parts.pop(case_id)
        with open(part, "rb") as file:  # noqa: PTH123 - a name that another process was given
            file.seek(begin)
            self.lines.append(file.read(end - begin))


class Crew:
    """Several processes that run the cases of a plan.

    Args:
        options: of the run; `CheckOptions.jobs` says how many.
        collector: has the plan, and takes the results.
        provider_factory: makes the provider of a worker; a function that can be imported.
        draw: draws pictures of cases that fail; can be imported, too; None: none are drawn.
        journal: where the cases of all are recorded.

    Attributes:
        lost: why what was to be written beside the report could not be, the first time; None if all was.
    """

    def __init__(
        self,
        options: CheckOptions,
        collector: Collector,
        provider_factory: ProviderFactory,
        draw: Draw | None,
        journal: Lines,
    ) -> None:
        self.lost: UnavailableError | None = None
        self._given = Given(options=options, provider_factory=provider_factory, draw=draw)
        self._collector = collector
        self._waiting = deque(plan for plan in collector.planned if not plan.missing)
        self._total = len(self._waiting)
        self._begun = self._done = 0
        self._journal = _Journal(journal, deque(plan.id for plan in self._waiting))
        self._keeps_journal = options.journal is not None
        self._workers: dict[Connection, _Worker] = {}
        self._observed: list[Observations] = []
        self._on_case: ProgressCallback | None = None
        self._on_result: ResultCallback | None = None

    def report(
        self, bench: Mapping[str, str], on_case: ProgressCallback | None, on_result: ResultCallback | None
    ) -> Report:
        """Run all that is planned; return the report, complete for what was run also after Ctrl-C.

        Args:
            bench: its parts.
            on_case: called before each case with the case, its number from 1, and how many there are.
            on_result: called after each case that ran to its end, with its result, how many are over, and as above.

        Raises:
            HilbenchError: a worker has nothing to run cases with.
        """
        self._on_case, self._on_result = on_case, on_result
        watch = Stopwatch()
        self._run()
        places = {plan.id: place for place, plan in enumerate(self._collector.planned)}
        observed = added_up(self._observed, places)
        return make_report(self._collector, self._given.options, bench, watch.elapsed_s(), observed)

    def _run(self) -> None:
        with tempfile.TemporaryDirectory(prefix="hilbench-check-") as folder:
            try:
                for number in range(min(self._given.options.jobs, self._total)):
                    self._begin(Path(folder) / f"{number}.jsonl")
                while self._workers:
                    for connection in wait([*self._workers]):
                        assert isinstance(connection, Connection)
                        self._hear(self._workers[connection])
            except KeyboardInterrupt:
                self._collector.stop("interrupted", interrupted=True)
            finally:
                self._end_all()
                with self._journal_kept():
                    self._journal.finish()

    # --- the workers

    def _begin(self, part: Path) -> None:
        ours, theirs = socket.socketpair()
        with theirs:
            words = [sys.executable, "-P", "-m", "hilbench.check.worker", str(theirs.fileno())]
            # In a group of its own, so that Ctrl-C reaches this process alone, which ends the others.
            process = subprocess.Popen(words, stdin=subprocess.DEVNULL, pass_fds=[theirs.fileno()], process_group=0)
        connection = Connection(ours.detach())
        worker = _Worker(process, connection, str(part) if self._keeps_journal else "")
        self._workers[connection] = worker
        with contextlib.suppress(OSError):  # it has died; that is seen when it is listened to
            connection.send(replace(self._given, part=worker.part))

    def _hear(self, worker: _Worker) -> None:
        try:
            message = worker.connection.recv()
        except (EOFError, OSError):
            self._lost(worker)
            return
        if isinstance(message, Ran):
            self._ran(worker, message)
        elif isinstance(message, Over):
            self._over(worker, message)
        elif isinstance(message, Refused):
            raise message.error
        if worker.connection in self._workers:
            self._give(worker)

    def _give(self, worker: _Worker) -> None:
        """Give a worker its next case, or nothing more."""
        if self._collector.stopped or not self._waiting:
            worker.case, said = None, ""
        else:
            worker.case = self._waiting.popleft()
            said = worker.case.id
            self._begun += 1
            if self._on_case is not None:
                self._on_case(worker.case, self._begun, self._total)
        with contextlib.suppress(OSError):
            worker.connection.send(said)

    def _ran(self, worker: _Worker, message: Ran) -> None:
        result = message.result
        self.lost = self.lost or message.pictures_lost
        if message.stopped:
            self._collector.stop(message.stopped)
        begin, worker.done_bytes = worker.done_bytes or message.header_bytes, message.journal_bytes
        if worker.part:
            with self._journal_kept():
                self._journal.take(result.id, worker.part, begin, message.journal_bytes)
        self._enter(result)

    def _enter(self, result: CaseResult) -> None:
        self._collector.enter(result)
        self._done += 1
        if self._on_result is not None:
            self._on_result(result, self._done, self._total)

    def _over(self, worker: _Worker, message: Over) -> None:
        self._observed.append(message.observed)
        self._collector.defects += [text for text in message.defects if text not in self._collector.defects]
        if message.stopped:
            self._collector.stop(message.stopped)
        self._forget(worker)

    def _lost(self, worker: _Worker) -> None:
        """A worker has died: its case has an error, and another one takes its place if there is more to run."""
        self._forget(worker)
        how = _how_it_ended(worker.process)
        if worker.case is None:
            self._collector.defects.append(f"a process that should run cases {how}")
            self._collector.stop(self._collector.defects[-1])
            return
        failed = worker.case.result(Verdict.ERROR, f"the process that ran it {how}")
        self._enter(msgspec.structs.replace(failed, defect=worker.process.returncode not in _ENDED_BY_OTHERS))
        if self._waiting and not self._collector.stopped:
            self._begin(Path(f"{worker.part}+") if worker.part else Path())

    def _forget(self, worker: _Worker) -> None:
        del self._workers[worker.connection]
        worker.connection.close()
        worker.process.wait()

    def _end_all(self) -> None:
        for worker in [*self._workers.values()]:
            worker.process.kill()
            self._forget(worker)

    @contextlib.contextmanager
    def _journal_kept(self) -> Iterator[None]:
        """Run no more cases once they cannot be recorded, and say so."""
        try:
            yield
        except UnavailableError as error:
            self.lost = self.lost or error
            self._collector.stop(str(error))


def _how_it_ended(process: subprocess.Popen[bytes]) -> str:
    code = process.wait()
    if code >= 0:
        return f"ended with {code}"
    with contextlib.suppress(ValueError):
        return f"was ended by {signal.Signals(-code).name}"
    return f"was ended by signal {-code}"
