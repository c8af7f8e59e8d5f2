"""A campaign on a real scheduler with workers of its own: where Dask is installed."""

from __future__ import annotations

import re
import subprocess
import sys

import pytest

from hilbench.campaign.hosts import run_there
from hilbench.campaign.point import Point, run_point

WAIT_S = 120
"""Against hanging only."""


@pytest.fixture
def dask(tmp_path, monkeypatch):
    """Start parts of Dask as processes of their own; return each with what it has said up to a pattern."""
    pytest.importorskip("distributed", reason="Dask is not installed")
    started = []
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))

    def start(*words, until):
        process = subprocess.Popen(
            [sys.executable, "-m", "dask", *words, "--no-dashboard"], stderr=subprocess.PIPE, text=True
        )
        started.append(process)
        for line in process.stderr:
            if found := re.search(until, line):
                return process, found[1]
        raise AssertionError(f"{words} ended")

    yield start
    for process in reversed(started):
        process.kill()
        process.wait(WAIT_S)
        process.stderr.close()


@pytest.mark.exhaustive("starts a scheduler and workers; the gate gives points to a stand-in for them")
def test_a_worker_that_dies_costs_no_point_and_changes_none(dask):
    _, scheduler = dask("scheduler", "--host", "127.0.0.1", "--port", "0", until=r"Scheduler at:\s+(tcp://\S+)")
    words = ("worker", scheduler, "--nthreads", "1", "--no-nanny")
    registered = r"(Registered) to:"
    workers = [dask(*words, until=registered)[0] for _ in range(2)]
    points = {str(seed): Point(bench="pioneer-plane", seed=seed, select="S01") for seed in range(40)}
    found = {}
    for key, outcome in run_there(points, scheduler):
        assert key not in found
        found[key] = outcome
        if len(found) == 5:
            workers[0].kill()
            dask(*words, until=registered)
    assert found == {key: run_point(point) for key, point in points.items()}
