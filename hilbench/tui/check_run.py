"""A suite that runs beside the dashboard: `hilbench check` on a fresh bench of the same kind, in virtual time."""

from __future__ import annotations

import os
import subprocess
import sys

__all__ = ["CheckRun"]

_READ_BYTES = 65536


class CheckRun:
    """A run of a suite, never waited for.

    Args:
        bench_file: the file of the bench.
        suite: the suite.

    Attributes:
        suite: likewise.
        text: what it has said so far.
        code: its exit code; None while it runs.
    """

    def __init__(self, bench_file: str, suite: str) -> None:
        self.suite = suite
        self.text = ""
        self.code: int | None = None
        self._process = subprocess.Popen(
            [sys.executable, "-m", "hilbench", "check", bench_file, "--suite", suite],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        assert self._process.stdout is not None
        os.set_blocking(self._process.stdout.fileno(), False)

    def poll(self) -> bool:
        """Take what it has said; say whether there is anything new."""
        if self.code is not None:
            return False
        assert self._process.stdout is not None
        ended = self._process.poll()  # before the last words are read, so that none of them are missed
        said = self._process.stdout.read(_READ_BYTES) or b""
        self.text += said.decode(errors="replace")
        if ended is not None and not said:
            self.code = ended
            self._process.stdout.close()
        return bool(said) or self.code is not None

    def stop(self) -> None:
        """End it, if it runs."""
        if self.code is None:
            self._process.terminate()
            self._process.wait()
            assert self._process.stdout is not None
            self._process.stdout.close()
            self.code = self._process.returncode
