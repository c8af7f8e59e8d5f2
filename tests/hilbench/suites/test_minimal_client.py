"""The client of the examples, put to the test as a user's would be: a program of its own, in real time."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from hilbench.bench_provider import make_provider
from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.options import TargetChoice

CLIENT = Path(__file__).parents[3] / "examples" / "clients" / "minimal_client.py"


@pytest.mark.parametrize("where", ["{pty}", "127.0.0.1:{port}"])
def test_it_walks_the_handshake_takes_over_and_takes_leave(where):
    options = CheckOptions(
        bench="pioneer",
        targets=(TargetChoice(spec=f"exec:{sys.executable} {CLIENT} {where}"),),
        suites=("p2os-client",),
        select="C02 or C07 or C26",
    )
    provider = make_provider(options)
    try:
        report = run_suites(options, provider)
    finally:
        provider.close()
    assert len(report.cases) == 3
    # A host that is too late to judge leaves a case open; it does not turn it.
    causes = {case.id: case.cause for case in report.cases if case.verdict not in (Verdict.PASS, Verdict.INCONCLUSIVE)}
    assert causes == {}
