"""A provider without any bench behind it, and suites written on the spot."""

from __future__ import annotations

import contextlib
import hashlib
import textwrap
from types import SimpleNamespace

import pytest

from hilbench.check import CheckOptions, run_suites
from hilbench.judging.doubt import Doubt
from hilbench.judging.provider import CaseView


class FakeBench:
    """Bench time that passes when it is told to; a hash over what was sent."""

    def __init__(self, case, provider):
        self.case = case
        self.now_ns = 5_000_000_000
        self.sent = []
        self.verdicts = []
        self.peer = SimpleNamespace(send=self.sent.append)
        self.world = self.server = self.client = None
        self.journal = provider.journal

    def pass_time(self, seconds):
        self.now_ns += round(seconds * 1e9)

    def evidence(self):
        return [f"sent {item}" for item in self.sent]

    def finish(self, verdict, cause):
        self.verdicts.append((verdict, cause))

    def case_hash(self):
        return hashlib.sha256(repr((self.case.seed, self.sent)).encode()).hexdigest()


class WatchedBench(FakeBench):
    """A bench that can be seen: what happens is kept once somebody watches."""

    seen = None

    def happens(self, what):
        if self.seen is not None:
            self.seen.append(what)

    def watch(self):
        self.seen = []

    def view(self):
        return CaseView(about={"x": 1}, events=tuple(self.seen))


class LateBench(FakeBench):
    """A bench in real time, whose host was late."""

    late_s = 0.0
    lived = True

    def uncertainty_s(self):
        return self.late_s

    def doubt(self):
        return Doubt(lateness_s=self.late_s, cause=f"the served bench was up to {self.late_s * 1000:.1f} ms late",
                     lived=self.lived)  # fmt: skip

    def is_late(self, late_s):
        self.late_s = late_s


class FakeProvider:
    def __init__(self, capabilities=("world",), fail_open=None, bench=FakeBench):
        self.bench = bench
        self.capabilities = frozenset(capabilities)
        self.journal = []
        self.opened = []
        self.closed_cases = 0
        self.closed = False
        self.fail_open = fail_open

    def describe(self):
        return {"bench": "fake", "target": "nothing", "physics": "none"}

    @contextlib.contextmanager
    def open_case(self, case):
        if self.fail_open is not None:
            raise self.fail_open
        bench = self.bench(case, self)
        self.opened.append(bench)
        try:
            yield bench
        finally:
            self.closed_cases += 1

    def close(self):
        self.closed = True


PRELUDE = """\
from __future__ import annotations
import pytest
from hilbench.check import *
from hilbench.errors import UnavailableError

def my(clause, level="must", **more):
    return case(clause, text=f"The target does {clause}.", level=level, source="our panel, rev. C", **more)
"""


@pytest.fixture
def provider():
    return FakeProvider()


@pytest.fixture
def make_provider():
    return FakeProvider


@pytest.fixture
def watched():
    return FakeProvider(bench=WatchedBench)


@pytest.fixture
def late():
    return FakeProvider(bench=LateBench)


@pytest.fixture
def write_suite(tmp_path):
    def write(body, name="test_panel.py"):
        file = tmp_path / name
        file.write_text(PRELUDE + textwrap.dedent(body))
        return file

    return write


@pytest.fixture
def check(write_suite, provider):
    """Run a suite given as text; return the report."""

    def run(body, *, name="test_panel.py", provider=provider, **options):
        file = write_suite(body, name)
        return run_suites(CheckOptions(suites=(str(file),), **options), provider)

    return run
