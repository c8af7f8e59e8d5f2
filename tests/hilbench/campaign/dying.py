"""What processes of a campaign run in tests."""

from __future__ import annotations

import os
import signal
import sys
import threading

from hilbench.campaign.point import Outcome, Point
from hilbench.campaign.processes import run_here


def run(point):
    """Come to the seed; end the process at seed 3."""
    if point.seed == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return Outcome(verdict="pass", exit_code=0, bench_time_s=point.seed)


def run_forever(point):
    """Say that it runs, and never end."""
    sys.stdout.write(f"{point.seed}\n")
    sys.stdout.flush()
    threading.Event().wait()


def campaign_without_end():
    """Run a point that never ends."""
    list(run_here({"0": Point(bench="b", seed=0)}, 1, run_forever))
