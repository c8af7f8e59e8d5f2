"""A plugin for pytest that records which test runs which lines of the product.

Each process of pytest writes ``part-PID.sqlite``, and each other process that a test starts or forks
``child-PID-N.json``; `measure.gate_proof.recording` puts them together. What a fixture runs that several tests share is
recorded apart, under the fixture, and belongs to each test that uses it.
"""

from __future__ import annotations

import os
import resource
import time
from collections.abc import Generator
from pathlib import Path
from typing import Any

import pytest
from gate_store import COLLECTING, Part
from gate_tracer import CONTEXT, FOLDER, TREE, Child, Tracer


def processor_s() -> float:
    """Return the processor time of this process and of those it has waited for, in seconds."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(one.ru_utime + one.ru_stime for one in used)


class Recorder:
    """Follows pytest from test to test.

    Args:
        folder: where to write.
        tree: the root of the tree under test.
    """

    def __init__(self, folder: Path, tree: Path) -> None:
        self._part = Part(folder / f"part-{os.getpid()}.sqlite")
        self._tracer = Tracer(tree)
        self._context = COLLECTING
        self._outcome = "passed"
        self._alive: dict[str, str] = {}
        """The shared fixtures that are set up, with the contexts of what they ran."""
        self._now = folder / f"now-{os.getpid()}"
        self._now.write_text(COLLECTING, encoding="utf-8")
        os.environ[CONTEXT] = str(self._now)
        Child(self._tracer, folder, self._now, forked_alone=True)

    def _switch(self, context: str) -> str:
        """Begin another context; return the one that was."""
        self._part.ran(self._context, self._tracer.take())
        before, self._context = self._context, context
        self._now.write_text(context, encoding="utf-8")
        return before

    @pytest.hookimpl(wrapper=True, tryfirst=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, Any, Any]:
        """Record a test with what is set up and torn down around it."""
        self._outcome = "passed"
        before = self._switch(item.nodeid)
        cpu_s, began_s = processor_s(), time.perf_counter()
        try:
            return (yield)
        finally:
            took = round(processor_s() - cpu_s, 4), round(time.perf_counter() - began_s, 4)
            self._switch(before)
            names = getattr(item, "fixturenames", ())
            shared = {self._alive[name] for name in names if name in self._alive}
            self._part.ended(item.nodeid, took, self._outcome, shared)

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Note the first outcome of a test that is no success."""
        report = yield
        if report.outcome != "passed" and self._outcome == "passed":
            self._outcome = report.outcome
        return report

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(
        self, fixturedef: pytest.FixtureDef[Any], request: pytest.FixtureRequest
    ) -> Generator[None, Any, Any]:
        """Record what several tests share under its own name."""
        if fixturedef.scope == "function":
            return (yield)
        context = f"fixture {fixturedef.baseid}::{fixturedef.argname}[{getattr(request, 'param_index', 0)}]"
        before = self._switch(context)
        try:
            return (yield)
        finally:
            self._alive[fixturedef.argname] = context
            self._switch(before)

    def pytest_unconfigure(self) -> None:
        """Write what is left."""
        self._switch(COLLECTING)
        self._part.close()


def _of_this_process() -> Recorder | None:
    """Return a recorder where tests are run: in a worker of pytest-xdist."""
    if not os.environ.get(FOLDER) or "PYTEST_XDIST_WORKER" not in os.environ:
        return None
    return Recorder(Path(os.environ[FOLDER]), Path(os.environ[TREE]))


# Now, not when pytest is configured: the product is imported before that.
RECORDER = _of_this_process()


def pytest_configure(config: pytest.Config) -> None:
    """Hand the recorder to pytest."""
    if RECORDER is not None:
        config.pluginmanager.register(RECORDER, "gate-recorder")
