"""What a robot does when its client goes: at once where the line tells it, with its watchdog where it does not."""

from __future__ import annotations

from dataclasses import replace

import pytest

from hilbench.bench import Bench
from hilbench.benchfile.reader import open_bench
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.serving.doors import LastingLine
from hilbench.systems.pioneer.robot import VirtualPioneer, plan_of
from protocols.p2os import Command, CommandNumber, encode_command

SYNCS = ("FAFB03000000", "FAFB03010001", "FAFB03020002", "FAFB03010001")
WATCHDOG_S = 2.0


@pytest.fixture(params=["close", "ignore"])
def hangup(request):
    return request.param


def test_a_robot_that_drives_stops_at_once_or_drives_on_until_its_watchdog(hangup):
    bench = Bench(Scheduler(), Journal(keep=5000))
    link = MemoryLink(bench.scheduler, Line(baud=9600))
    plan = replace(plan_of(open_bench("pioneer")), physics="plane")
    port = LastingLine(link.a) if hangup == "ignore" else link.a
    pioneer = VirtualPioneer(bench, port, plan, seed=1)
    drive = (Command(CommandNumber.ENABLE, 1), Command(CommandNumber.VEL, 200))
    for data in (*map(bytes.fromhex, SYNCS), *map(encode_command, drive)):
        link.b.write(data)
        bench.run_for(0.1)
    bench.run_for(0.9)

    def speed_m_s():
        return pioneer.world.velocity().linear_m_s[0]

    assert speed_m_s() == pytest.approx(0.2, abs=0.01)
    link.b.close()
    bench.run_for(WATCHDOG_S - 1.1)
    assert speed_m_s() == pytest.approx(0.2 if hangup == "ignore" else 0, abs=0.01)
    bench.run_for(2.0)
    assert speed_m_s() == pytest.approx(0, abs=0.01)
    downs = [event for event in bench.journal.recent if event["kind"] == "line" and not event["up"]]
    assert len(downs) == (hangup == "close")
    pioneer.close()
