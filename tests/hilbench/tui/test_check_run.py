"""A suite beside the dashboard ends with it."""

from __future__ import annotations

import os
import select
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.skipif(not hasattr(os, "pidfd_open"), reason="waits for other processes as Linux lets one")

PATIENCE_MS = 60_000
DASHBOARD = """
import sys
from hilbench.tui.check_run import CheckRun
run = CheckRun("rover", "pkt-board")
print(run._process.pid, run._folder, flush=True)
sys.stdin.read()
{last}
"""


def ends(pid_of_process):
    """Return what waits until a process has ended, and says whether it did."""
    poller = select.poll()
    poller.register(os.pidfd_open(pid_of_process), select.POLLIN)
    return lambda: bool(poller.poll(PATIENCE_MS))


@pytest.fixture
def dashboard(request):
    words = [sys.executable, "-c", DASHBOARD.format(last=request.param)]
    with subprocess.Popen(words, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        yield process
        process.kill()


@pytest.mark.parametrize("dashboard", [""], indirect=True)
@pytest.mark.parametrize("how", ["killed", "at its end"])
def test_a_suite_does_not_outlive_the_dashboard(dashboard, how):
    pid, folder = dashboard.stdout.readline().split()
    ended = ends(int(pid))
    assert Path(folder).is_dir()
    if how == "killed":
        dashboard.kill()
    else:
        dashboard.stdin.close()
    assert ended()
    assert not Path(folder).exists()


@pytest.mark.parametrize("dashboard", ["run.stop(); print(run.code, flush=True)"], indirect=True)
def test_one_that_is_stopped_leaves_nothing(dashboard):
    pid, folder = dashboard.stdout.readline().split()
    ended = ends(int(pid))
    dashboard.stdin.close()
    assert ended()
    assert int(dashboard.stdout.readline()) != 0
    assert not Path(folder).exists()
