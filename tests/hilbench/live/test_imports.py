"""What a live bench loads before it runs: the sooner something moves, the better."""

from __future__ import annotations

import subprocess
import sys

import pytest

LOADS = """
import sys
import hilbench.commands.live, hilbench.live.session
from hilbench.mcu.command_line import open_target
from hilbench.live.rigs import open_rig
from hilbench.bench import Bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal
rig = open_rig(Bench(Scheduler(), Journal()), open_target(sys.argv[1]), seed=0)
rig.close()
print(*[name for name in sys.argv[2:] if name in sys.modules])
"""
NEVER = ("textual", "hilbench.tui", "pytest", "unicorn", "numpy", "pybullet")


@pytest.mark.parametrize(
    ("bench", "others"),
    [
        ("pioneer-plane", ("protocols.pkt", "protocols.carla", "protocols.autoware", "hilbench.check")),
        ("vehicle-model", ("protocols.pkt", "targets.robots.rover.robot")),
    ],
)
def test_a_bench_loads_no_more_than_it_needs(bench, others):
    done = subprocess.run(
        [sys.executable, "-c", LOADS, bench, *NEVER, *others], capture_output=True, text=True, timeout=60, check=True
    )
    assert done.stdout.split() == []


def test_a_dashboard_loads_no_protocol_before_it_shows_one():
    looked = "import sys, hilbench.tui.app; print(*[name for name in sys.modules if name.startswith('protocols.')])"
    done = subprocess.run([sys.executable, "-c", looked], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.split() == []
