"""What processes of a campaign run in tests."""

from __future__ import annotations

import os
import signal

from hilbench.campaign.point import Outcome


def run(point):
    """Come to the seed; end the process at seed 3."""
    if point.seed == 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return Outcome(verdict="pass", exit_code=0, bench_time_s=point.seed)
