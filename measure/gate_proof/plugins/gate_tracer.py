"""Measures which lines of the product run in this process, and hands them over piece by piece.

The modules of this folder stand alone, so that they can be loaded beside any tree: `measure.gate_proof.copies` puts the
folder on the path of a copy's environment.
"""

from __future__ import annotations

import atexit
import contextlib
import json
import os
import time
from pathlib import Path
from typing import NoReturn

import coverage

FOLDER = "GATE_PROOF_RECORD"
"""Where to write: names a folder. Without it nothing is recorded."""
TREE = "GATE_PROOF_TREE"
"""The root of the tree whose packages are measured."""
CONTEXT = "GATE_PROOF_CONTEXT"
"""The file with the name of the test that is running, for the processes that it starts."""
PACKAGES = ("hilbench", "protocols", "targets", "worlds")


class Tracer:
    """Measures lines and branches from now on.

    Args:
        tree: the root of the tree.
    """

    def __init__(self, tree: Path) -> None:
        self._root = f"{tree}/"
        self._coverage = coverage.Coverage(
            data_file=None, config_file=False, branch=True, include=[f"{tree}/{package}/*" for package in PACKAGES]
        )
        self._coverage.set_option("run:disable_warnings", ["no-data-collected", "trace-changed"])
        self._coverage.start()
        self._data = self._coverage.get_data()

    def take(self) -> dict[str, list[tuple[int, int]]]:
        """Return what has run since the last call, by the files' paths within the tree."""
        self._coverage.switch_context("")  # hands over what is measured so far
        files = self._data.measured_files()
        arcs = {name.removeprefix(self._root): list(self._data.arcs(name) or ()) for name in files}
        self._data.erase()
        return arcs


class Child:
    """What a process does that a test has started or forked: it writes what it ran when it ends.

    Args:
        tracer: what measures.
        folder: where to write.
        now: the file with the name of the test that is running.
        forked_alone: this process is none of them, but those that are forked from it are.
    """

    def __init__(self, tracer: Tracer, folder: Path, now: Path, *, forked_alone: bool) -> None:
        self._tracer = tracer
        self._folder = folder
        self._now = now
        self._due = False
        self._context = ""
        if not forked_alone:
            self._begin()
        atexit.register(self._write)
        os.register_at_fork(after_in_child=self._begin)
        leave = os._exit

        def end(status: int) -> NoReturn:
            self._write()
            leave(status)

        os._exit = end

    def _begin(self) -> None:
        """Forget what the process ran that this one is forked from."""
        self._tracer.take()
        with contextlib.suppress(OSError):
            self._context = self._now.read_text(encoding="utf-8")
            self._due = True

    def _write(self) -> None:
        """Write, once; somebody who may not write here, or comes too late, leaves it."""
        if self._due:
            self._due = False
            told = {"context": self._context, "arcs": self._tracer.take()}
            with contextlib.suppress(OSError):
                (self._folder / f"child-{os.getpid()}-{time.monotonic_ns()}.json").write_text(
                    json.dumps(told), encoding="utf-8"
                )
