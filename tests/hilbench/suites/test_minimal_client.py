"""The client of the examples, put to the test as a user's would be: a program of its own, in real time."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.terminal.options import TargetChoice

CLIENT = Path(__file__).parents[3] / "examples" / "clients" / "minimal_client.py"


def check(where, select):
    """Require that a host that is too late to judge leaves a case open, and that no case turns out otherwise."""
    target = TargetChoice(spec=f"exec:{sys.executable} {CLIENT} {where}")
    options = CheckOptions(bench="pioneer", targets=(target,), suites=("p2os-client",), select=select)
    provider = make_provider(options)
    try:
        report = run_suites(options, provider)
    finally:
        provider.close()
    causes = {case.id: case.cause for case in report.cases if case.verdict not in (Verdict.PASS, Verdict.INCONCLUSIVE)}
    assert causes == {}
    return report


each_door = pytest.mark.parametrize("where", ["{pty}", "127.0.0.1:{port}"])


@pytest.mark.real_time("a process that we start; where the host is late, nothing is concluded")
@each_door
def test_it_walks_the_handshake(where):
    assert len(check(where, "C02").cases) == 1


@pytest.mark.exhaustive("real time; the gate has its handshake through each door")
@each_door
def test_it_walks_the_handshake_takes_over_and_takes_leave(where):
    assert len(check(where, "C02 or C07 or C26").cases) == 3
