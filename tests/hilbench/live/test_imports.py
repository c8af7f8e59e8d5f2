"""What a live bench loads before it runs: the sooner something moves, the better."""

from __future__ import annotations

import json
import subprocess
import sys

LOADS = """
import json, sys
import hilbench.commands.live, hilbench.live.session
from hilbench.mcu.command_line import open_target
from hilbench.live.rigs import open_rig
from hilbench.bench import Bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal
for bench, others in json.loads(sys.argv[1]).items():
    rig = open_rig(Bench(Scheduler(), Journal()), open_target(bench), seed=0)
    rig.close()
    print(bench, *[name for name in others if name in sys.modules])
"""
NEVER = ("textual", "hilbench.tui", "pytest", "unicorn", "numpy", "mujoco", "pybullet")
NOT_BY = {
    "pioneer-plane": (*NEVER, "protocols.pkt", "protocols.carla", "protocols.autoware", "hilbench.check"),
    "vehicle-model": (*NEVER, "protocols.pkt", "targets.robots.rover.robot"),
}


def test_a_bench_loads_no_more_than_it_needs():
    words = [sys.executable, "-c", LOADS, json.dumps(NOT_BY)]
    done = subprocess.run(words, capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == list(NOT_BY)


def test_a_dashboard_loads_no_protocol_before_it_shows_one():
    looked = "import sys, hilbench.tui.app; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", looked], capture_output=True, text=True, check=True)
    assert {name.split(".")[1] for name in done.stdout.split() if name.startswith("protocols.")} <= {"common"}
