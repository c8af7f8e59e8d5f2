"""Stand-ins for programs that cannot be installed here, on a robot in bench time and on a served one in real time."""

from __future__ import annotations

import contextlib
import os
import re
import select
import signal
import subprocess
import sys
from dataclasses import replace

import pytest

from hilbench.bench import Bench
from hilbench.benchfile.reader import open_bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.systems.pioneer.robot import VirtualPioneer, plan_of

from .aria import Aria
from .lines import BenchLine, PtyLine, TcpLine
from .player import PlayerDriver, RosDriver

KINDS = {
    "aria-serial": (Aria, True),
    "aria-tcp": (Aria, False),
    "player-serial": (PlayerDriver, True),
    "player-tcp": (PlayerDriver, False),
    "ros-serial": (RosDriver, True),
}


class BenchRig:
    """A virtual robot on a line inside the bench; `hangs_up` says whether a client that goes takes the line down."""

    def __init__(self, *, scene="empty", physics="plane", baud=9600, hangs_up=True, keep_events=2000):
        self.hangs_up = hangs_up
        self.bench = Bench(Scheduler(), Journal(keep=keep_events))
        self.link = MemoryLink(self.bench.scheduler, Line(baud=baud))
        plan = plan_of(open_bench("pioneer"))
        plan = replace(plan, scene=scene, physics=physics, settings=replace(plan.settings, host_baud=baud))
        self.pioneer = VirtualPioneer(self.bench, self.link.a, plan, seed=1)

    def open(self, kind):
        make, serial = KINDS[kind]
        self.link.restore()
        self.bench.run_for(0)
        return make(BenchLine(self, serial=serial))

    def client_gone(self):
        if self.hangs_up:
            self.link.hang_up()

    def pass_time(self, duration_s):
        self.bench.run_for(duration_s)

    def hear_the_next_byte(self):
        heard = []
        self.link.b.on_receive = lambda data, _at_ns: heard.append(data)
        assert self.bench.run_until(lambda: bool(heard), 1.0)

    def close(self):
        self.pioneer.close()


class ServedRig:
    """A robot served by a process of its own."""

    hangs_up = True

    def __init__(self, folder, *options, bench="pioneer-plane", tcp=True):
        self.path = folder / "p2"
        words = ["serve", bench, "--pty", str(self.path), *options, *(["--tcp", "0"] if tcp else [])]
        program = "import sys; from hilbench.cli import main; sys.exit(main())"
        self.process = subprocess.Popen([sys.executable, "-c", program, *words], stderr=subprocess.PIPE, text=True)
        self.said, self.lines = "", []

    def ready(self):
        descriptor = self.process.stderr.fileno()
        while "stop with" not in self.said:
            assert select.select((descriptor,), (), (), 60)[0], self.said
            more = os.read(descriptor, 4096)
            assert more, self.said
            self.said += more.decode()
        return self

    @property
    def tcp_port(self):
        return int(re.search(r"tcp .*:(\d+),", self.said)[1])

    def open(self, kind):
        make, serial = KINDS[kind]
        self.lines.append(PtyLine(self.path) if serial else TcpLine(self.tcp_port))
        return make(self.lines[-1])

    def close(self):
        for line in self.lines:
            line.close()
        if self.process.stderr.closed:
            return
        with contextlib.suppress(ProcessLookupError):
            self.process.send_signal(signal.SIGINT)
        self.said += self.process.communicate(timeout=60)[1]


@pytest.fixture
def make_rig():
    with contextlib.ExitStack() as stack:

        def make(**options):
            rig = BenchRig(**options)
            stack.callback(rig.close)
            return rig

        yield make


@pytest.fixture
def make_served(tmp_path):
    with contextlib.ExitStack() as stack:

        def make(*options, **more):
            rig = ServedRig(tmp_path, *options, **more)
            stack.callback(rig.close)
            return rig.ready()

        yield make
