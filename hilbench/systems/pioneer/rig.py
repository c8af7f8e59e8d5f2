"""A Pioneer on a live bench, and our client at its line."""

from __future__ import annotations

from hilbench.bench import Bench
from hilbench.bench.about import about_line, about_world
from hilbench.benchfile.bench_file import BenchFile
from hilbench.driving.real_port import open_at
from hilbench.driving.resuming import resume_sessions
from hilbench.driving.rig import CLIENT_SENSES, Rig
from hilbench.driving.tap import Tap
from hilbench.errors import UnavailableError
from hilbench.links import DEFAULT_BAUD, Line, MemoryLink, Port
from hilbench.links.memory import REAL_TIME_GROUP_NS
from hilbench.systems.pioneer.about import about_sonars
from hilbench.systems.pioneer.client import P2osClient
from hilbench.systems.pioneer.operator import PioneerOperator
from hilbench.systems.pioneer.robot import VirtualPioneer, plan_of
from worlds.errors import WorldError

__all__ = ["attached_rig", "model_rig"]


def model_rig(bench: Bench, bench_file: BenchFile, seed: int) -> Rig:
    """Build the virtual robot of a bench file."""
    plan = plan_of(bench_file)
    link = MemoryLink(bench.scheduler, Line(baud=plan.settings.host_baud), name="host", group_ns=REAL_TIME_GROUP_NS)
    try:
        pioneer = VirtualPioneer(bench, link.b, plan, seed=seed)
    except WorldError as error:
        raise UnavailableError(str(error), where=f"scene {plan.scene}") from error
    tap, operator = _client(bench, link.a, seed)
    machines = {operator.name: operator.observed, **pioneer.machines}
    about = about_line(operator.name, "p2os", machines) | about_sonars(plan.settings.subclass)
    about["subclass"] = plan.settings.subclass
    return Rig(
        operator=operator,
        taps={"host": tap},
        machines=machines,
        senses={operator.name: CLIENT_SENSES},
        about=about | about_world(pioneer.world),
        close=pioneer.close,
    )


def attached_rig(bench: Bench, bench_file: BenchFile, target: str, seed: int) -> Rig:
    """Attach to a robot at a port."""
    port = open_at(bench, bench_file, target, DEFAULT_BAUD)
    tap, operator = _client(bench, port, seed)
    resume_sessions(tap, operator)
    machines = {operator.name: operator.observed}
    return Rig(
        operator=operator,
        taps={"host": tap},
        machines=machines,
        senses={operator.name: CLIENT_SENSES},
        about=about_line(operator.name, "p2os", machines),
        demo=False,
        close=port.close,
    )


def _client(bench: Bench, port: Port, seed: int) -> tuple[Tap, PioneerOperator]:
    tap = Tap(bench, port, "client", seed=seed)
    return tap, PioneerOperator(bench, P2osClient(bench, tap))
