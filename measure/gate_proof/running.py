"""Puts defects into a copy of the tree, one at a time, and runs the tests that should find them."""

from __future__ import annotations

import dataclasses
import json
import os
import subprocess
import threading
import time
import uuid
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path

from measure.gate_proof import processes
from measure.gate_proof.copies import Copy, git
from measure.gate_proof.crew import StoppedError
from measure.gate_proof.defects import Defect
from measure.gate_proof.plugins.gate_watch import VARIABLE
from measure.gate_proof.recording import Test
from measure.gate_proof.selection import Selection, Tree, file_of

FIRST_S = 10.0
"""The first tests are run alone where they are few: collecting all files takes longer than most defects live."""
FIRST_FILES = 8
CPU_FACTOR, CPU_S = 10.0, 30.0
"""A test hangs that takes ten times the processor time that was recorded, and half a minute."""
IDLE_S, IDLE_FACTOR, IDLE_SHARE = 120.0, 10.0, 0.1
"""One that does next to nothing for two minutes waits in vain; a busy host is no such thing, for it is always next."""
COLLECTING_CPU_S = 120.0
MEMORY = 4 * 2**30
_POLL_S = 0.1
_LOOK_S = 1.0
_LONG_AGO = 1_000_000_000
_NONE_LEFT = 5
_NEVER_RECORDED = Test(10.0, 10.0, passed=True)


@dataclass(frozen=True, slots=True)
class Outcome:
    """What tests say of a defect.

    Attributes:
        found: one of them found it.
        how: the test "failed", "hangs", or "takes all memory"; or it is in the "import".
        by: the test.
        tests: how many were to run.
        covering: how many of them run the line.
        cpu_s: processor time it took.
        wall_s: time on the host's clock.
    """

    found: bool
    how: str
    by: str
    tests: int
    covering: int
    cpu_s: float
    wall_s: float


@dataclass(frozen=True, slots=True)
class _Ran:
    """How a run of pytest ended: what first went wrong, in which test, and all that failed."""

    how: str = ""
    by: str = ""
    failed: Sequence[str] = ()
    cpu_s: float = 0.0


@dataclass(slots=True)
class _Batch:
    """A run of pytest, followed by what it writes to its log."""

    name: str
    process: subprocess.Popen[bytes]
    log: Path
    tests: Mapping[str, Test]
    running: str = ""
    failed: list[str] = field(default_factory=list)
    waited_s: float = 0.0
    looked_s: float = 0.0
    since_cpu_s: float = 0.0
    cpu_s: float = 0.0
    read: int = 0
    collected: bool = False

    def follow(self) -> bool:
        """Read what is new in the log; say whether there was anything."""
        with self.log.open("rb") as log:
            log.seek(self.read)
            fresh = log.read()
        whole = fresh[: fresh.rfind(b"\n") + 1]
        self.read += len(whole)
        for line in whole.splitlines():
            match json.loads(line):
                case ["collected", _]:
                    self.collected = True
                case ["begins", test]:
                    self.running = test
                case ["ends", _]:
                    self.running = ""
                case ["fails", test] if test not in self.failed:
                    self.failed.append(test)
        return bool(whole)

    def trouble(self) -> str:
        """Return why the run has to be ended, or nothing."""
        now = processes.used(self.name, self.process.pid)
        self.cpu_s = max(self.cpu_s, now.cpu_s)
        test = self.tests.get(self.running, _NEVER_RECORDED)
        cpu_s = self.cpu_s - self.since_cpu_s
        # Of a time in which this program did not run either, as when both are stopped, next to nothing counts.
        looked_s, self.looked_s = self.looked_s, time.monotonic()
        self.waited_s += min(self.looked_s - looked_s, 2 * _LOOK_S)
        if now.memory > MEMORY:
            return "takes all memory"
        if cpu_s > (CPU_S + CPU_FACTOR * test.cpu_s if self.collected else COLLECTING_CPU_S):
            return "hangs"
        if self.waited_s > max(IDLE_S, IDLE_FACTOR * test.wall_s) and cpu_s < IDLE_SHARE * self.waited_s:
            return "hangs"
        return ""

    def ran(self, trouble: str) -> _Ran:
        """Return how it ended.

        Args:
            trouble: why it was ended, or nothing.
        """
        where = self.running or ("at the end" if self.collected else "while tests were collected")
        if trouble:
            return _Ran(trouble, where, self.failed, self.cpu_s)
        if self.failed:
            return _Ran("failed", self.failed[0], self.failed, self.cpu_s)
        if self.process.returncode in {0, _NONE_LEFT} and not self.running:
            return _Ran(cpu_s=self.cpu_s)
        return _Ran("died" if self.running else "import", where, cpu_s=self.cpu_s)


class Bench:
    """A copy of the tree in which defects are put.

    Args:
        copy: the copy.
        tree: what its tests run.
        folder: for files of its own.
        stop: set when the program is to end.
    """

    def __init__(self, copy: Copy, tree: Tree, folder: Path, stop: threading.Event) -> None:
        self._copy = copy
        self._tree = tree
        self._folder = folder
        self._stop = stop
        self._changes = 0
        folder.mkdir(exist_ok=True)

    def judge(self, defect: Defect, selection: Selection, unfit: Sequence[str] = ()) -> Outcome:
        """Put a defect in and run tests; a test that finds it has to find it twice.

        Args:
            defect: the defect.
            selection: the tests for it.
            unfit: tests that fail without it too.
        """
        began_s, spent_s, doubtful = time.monotonic(), 0.0, set(unfit)
        with self._put_in(defect):
            while True:
                ran = self._search([name for name in selection.order if name not in doubtful])
                spent_s += ran.cpu_s
                if ran.how != "failed":
                    break
                again = self._run([ran.by], "--exitfirst")
                spent_s += again.cpu_s
                if again.how:
                    break
                doubtful.add(ran.by)
        took = round(spent_s, 1), round(time.monotonic() - began_s, 1)
        return Outcome(bool(ran.how), ran.how, ran.by, len(selection.order), selection.covering, *took)

    def failures(self, order: Sequence[str]) -> list[str]:
        """Return which tests fail without any defect."""
        self._tidy()
        ran = self._run(order, "--maxfail=0")
        return [*ran.failed, *([ran.by] if ran.how else [])]

    @contextmanager
    def _put_in(self, defect: Defect) -> Iterator[None]:
        file = self._copy.tree / defect.path
        source = file.read_bytes()
        file.write_bytes(defect.put_into(source))
        # Bytecode is taken for fresh when size and second are the same: each change has a second that no other has.
        self._changes += 1
        os.utime(file, (_LONG_AGO + self._changes,) * 2)
        try:
            yield
        finally:
            self._tidy()

    def _tidy(self) -> None:
        """Undo what was changed in the copy, also by a test that was ended half-way."""
        git("checkout", "--quiet", "--force", ".", at=self._copy.tree)
        git("clean", "--quiet", "--force", "-d", at=self._copy.tree)

    def _search(self, order: Sequence[str]) -> _Ran:
        """Run tests until one fails: a few at first."""
        spent_s = 0.0
        ran = _Ran()
        for part in _parts(order, self._tree.tests):
            ran = self._run(part, "--exitfirst")
            spent_s += ran.cpu_s
            if ran.how:
                break
        return dataclasses.replace(ran, cpu_s=spent_s)

    def _run(self, order: Sequence[str], option: str) -> _Ran:
        batch = self._start(order, option)
        trouble = ""
        try:
            while batch.process.poll() is None and not trouble:
                trouble = self._look(batch)
        finally:
            processes.end(batch.name, batch.process.pid)
            batch.process.wait()
        batch.follow()
        return batch.ran(trouble)

    def _look(self, batch: _Batch) -> str:
        """Wait a moment, and see whether the run is in trouble."""
        until_s = time.monotonic() + _LOOK_S
        while batch.process.poll() is None and time.monotonic() < until_s:
            if self._stop.wait(_POLL_S):
                raise StoppedError
        if batch.process.poll() is not None:
            return ""
        trouble = batch.trouble()
        if batch.follow():
            batch.waited_s, batch.since_cpu_s = 0.0, batch.cpu_s
            return ""
        return trouble

    def _start(self, order: Sequence[str], option: str) -> _Batch:
        name = uuid.uuid4().hex
        told, log = self._folder / "tests.json", self._folder / "log"
        log.write_bytes(b"")
        told.write_text(json.dumps({"order": order, "known": self._tree.known(order), "log": str(log)}))
        files = self._folder / "files"
        files.write_text("".join(f"{file}\n" for file in dict.fromkeys(map(file_of, order))))
        settings = {**os.environ, VARIABLE: str(told), processes.MARK: name}
        settings.pop("PYTHONDONTWRITEBYTECODE", None)
        command = [str(self._copy.python), "-m", "pytest", "-q", option, "-p", "no:cacheprovider", "-p", "no:xdist"]
        command += ["-p", "gate_watch", f"--basetemp={self._folder / 'tmp'}", "--tb=short", f"@{files}"]
        with (self._folder / "said").open("wb") as said:
            process = subprocess.Popen(
                command,
                cwd=self._copy.tree,
                env=settings,
                stdin=subprocess.DEVNULL,
                stdout=said,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        return _Batch(name, process, log, self._tree.tests, looked_s=time.monotonic())


def _parts(order: Sequence[str], tests: Mapping[str, Test]) -> Iterator[Sequence[str]]:
    """Cut tests in two: a few files that take little time, and the rest."""
    files: set[str] = set()
    took_s = 0.0
    for number, name in enumerate(order):
        files.add(file_of(name))
        took_s += tests[name].took_s
        if number and (len(files) > FIRST_FILES or took_s > FIRST_S):
            yield order[:number]
            yield order[number:]
            return
    if order:
        yield order
