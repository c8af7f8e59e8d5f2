"""``python -m measure.campaign_overhead``: what a campaign costs beside the same points in plain multiprocessing.

The same points, each about a second of a processor, are run by a pool of multiprocessing, by a campaign in processes of
its own, and by a campaign on a Dask scheduler with two workers on this machine (`pip install 'hilbench[campaign]'`),
without Dask's profiler (docs/campaigns.md).
Compared is the processor's time of all processes that take part, the starting of them included.
"""

from __future__ import annotations

import argparse
import multiprocessing
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any

from hilbench.campaign.hosts import run_there
from hilbench.campaign.point import Outcome, Point, run_point
from hilbench.campaign.processes import run_here
from hilbench.campaign.results import Results

JOBS = 2
CASES = "p2os-server and S3"
PORT = 23786


def main(words: Sequence[str]) -> int:
    """Measure, and print a table; 1 if the ways do not come to the same."""
    parser = argparse.ArgumentParser(prog="python -m measure.campaign_overhead", description=__doc__)
    parser.add_argument("--points", type=int, default=200, help="how many (default: 200)")
    parser.add_argument("--select", default=CASES, help="what each runs of pioneer-plane")
    chosen = parser.parse_args(words)
    points = {str(seed): Point(bench="pioneer-plane", seed=seed, select=chosen.select) for seed in range(chosen.points)}
    ways: dict[str, Callable[[dict[str, Point]], dict[str, Outcome]]] = {
        "pool": _pool,
        "processes": _here,
        "dask": _there,
    }
    found, seconds = {}, {}
    for name, way in ways.items():
        before = _cpu_s()
        found[name] = way(points)
        seconds[name] = _cpu_s() - before
        ratio = seconds[name] / seconds["pool"]
        sys.stdout.write(
            f"{name:<10} {seconds[name] / len(points):6.3f} s of a processor for each point, {ratio:.3f} x\n"
        )
    return 0 if found["pool"] == found["processes"] == found["dask"] else 1


def _pool(points: dict[str, Point]) -> dict[str, Outcome]:
    with multiprocessing.get_context("spawn").Pool(JOBS) as pool:
        found = pool.map(run_point, points.values(), chunksize=1)
        pool.close()
        pool.join()
    return dict(zip(points, found, strict=True))


def _here(points: dict[str, Point]) -> dict[str, Outcome]:
    return _kept(points, run_here(points, JOBS))


def _there(points: dict[str, Point]) -> dict[str, Outcome]:
    address = f"tcp://127.0.0.1:{PORT}"
    dask = [sys.executable, "-m", "dask"]
    environment = {**os.environ, "DASK_DISTRIBUTED__WORKER__PROFILE__ENABLED": "False"}
    quiet: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL, "env": environment}
    processes = [
        subprocess.Popen([*dask, "scheduler", "--host", "127.0.0.1", "--port", str(PORT), "--no-dashboard"], **quiet)
    ]
    workers = ["worker", address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
    processes += [subprocess.Popen([*dask, *workers], **quiet) for _ in range(JOBS)]
    try:
        _wait_for_workers(address)
        return _kept(points, run_there(points, address))
    finally:
        for process in reversed(processes):
            process.terminate()
            process.wait()


def _wait_for_workers(address: str) -> None:
    from distributed import Client

    with Client(address, timeout=60, set_as_default=False) as client:
        client.wait_for_workers(JOBS)


def _kept(points: dict[str, Point], outcomes: Iterator[tuple[str, Outcome]]) -> dict[str, Outcome]:
    """Enter outcomes in a file of results, as a campaign does."""
    found = {}
    with tempfile.TemporaryDirectory() as folder, Results(Path(folder) / "r.sqlite") as results:
        for key, outcome in outcomes:
            results.enter(key, points[key], outcome)
            found[key] = outcome
    return found


def _cpu_s() -> float:
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
