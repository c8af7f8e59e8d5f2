"""A suite that runs beside the dashboard: `hilbench check` on a fresh bench of the same kind, in virtual time.

What is planned is asked of ``--list``, how far it is stands in the run's journal, and what came of it in its report.
It does not outlive the dashboard, nor does its folder.
"""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from pathlib import Path

from hilbench.live.ends_with_parent import words_of
from hilbench.tui.model.checks import ChecksModel
from hilbench.tui.model.follower import Follower

__all__ = ["CheckRun"]

_READ_BYTES = 65536
_PATIENCE_S = 5.0


class CheckRun:
    """A run of a suite, never waited for.

    Args:
        bench_file: the file of the bench.
        suite: the suite.
        select: which of its clauses, as of ``-k``; empty for all.
        more: more options of ``hilbench check``.

    Attributes:
        checks: what is known of it.
        text: what it has said so far.
        code: its exit code; None while it runs.
    """

    def __init__(self, bench_file: str, suite: str, select: str = "", more: Sequence[str] = ()) -> None:
        self.suite, self.select = suite, select
        self.checks = ChecksModel()
        self.text = ""
        self.code: int | None = None
        self._folder = Path(tempfile.mkdtemp(prefix="hilbench-check-"))
        self._report = self._folder / "report.json"
        journal = self._folder / "journal.jsonl"
        words = ["check", bench_file, "--suite", suite, *(["-k", select] if select else []), *more]
        self._plan = self._started([*words, "--list", "--json", "-"])
        self._planned = b""
        self._process = self._started([*words, "--json", str(self._report), "--journal", str(journal)], talk=True)
        self._follower = Follower(journal)

    @property
    def title(self) -> str:
        """What it runs, in words."""
        return f"{Path(self.suite).name}{f' -k {self.select}' if self.select else ''}"

    def poll(self) -> None:
        """Take what it has said and done since the last time."""
        if self.code is not None:
            return
        self._poll_plan()
        for event in self._follower.news():
            self.checks.take(event)
        ended = self._process.poll()  # before the last words are read, so that none of them are missed
        said = _read(self._process)
        self.text += said.decode(errors="replace")
        if ended is not None and not said:
            self._end(ended)

    def stop(self) -> None:
        """End it, if it runs."""
        if self.code is None:
            self._process.terminate()
            try:
                code = self._process.wait(_PATIENCE_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                code = self._process.wait()
            self._end(code)
            self.checks.ended = "stopped"

    def _started(self, words: Sequence[str], *, talk: bool = False) -> subprocess.Popen[bytes]:
        """Start a command whose output is read without waiting; what it says on stderr too, if that is wanted."""
        process = subprocess.Popen(
            [*words_of(str(self._folder)), *words],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT if talk else subprocess.DEVNULL,
            start_new_session=True,
        )
        assert process.stdout is not None
        os.set_blocking(process.stdout.fileno(), False)
        return process

    def _poll_plan(self) -> None:
        if self._plan.stdout is None or self._plan.stdout.closed:
            return
        ended = self._plan.poll()
        said = _read(self._plan)
        self._planned += said
        if ended is None or said:
            return
        self._plan.stdout.close()
        if ended == 0:
            self.checks.plan(json.loads(self._planned))

    def _end(self, code: int) -> None:
        self.code = code
        if self._plan.poll() is None:
            self._plan.terminate()
            self._plan.wait()
        for process in (self._plan, self._process):
            for end in (process.stdin, process.stdout):
                if end is not None:
                    end.close()
        self._follower.close()
        try:
            self.checks.take_report(json.loads(self._report.read_bytes()))
        except (OSError, ValueError, KeyError):
            self.checks.ended = f"exit code {code}"
        shutil.rmtree(self._folder, ignore_errors=True)


def _read(process: subprocess.Popen[bytes]) -> bytes:
    assert process.stdout is not None
    return process.stdout.read(_READ_BYTES) or b""
