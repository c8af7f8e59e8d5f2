"""An agent of ours at a port, for the dashboard: what is there is a board with micro-ROS."""

from __future__ import annotations

from hilbench.bench import Bench
from hilbench.bench.about import about_line
from hilbench.bench.devices import DeviceActor
from hilbench.benchfile.bench_file import BenchFile
from hilbench.clock import wall_time_ns
from hilbench.driving.real_port import open_at
from hilbench.driving.rig import Rig
from hilbench.driving.tap import Tap
from hilbench.systems.xrce_agent.agent import AgentOnLine
from hilbench.systems.xrce_agent.protocol import BAUD
from hilbench.systems.xrce_agent.settings import AgentSettings

__all__ = ["attached_agent"]

_AGENT = "agent"
"""The source in the journal of our end of the line."""


def attached_agent(bench: Bench, bench_file: BenchFile, spec: str, *, seed: int) -> Rig:
    """Return the agent of a bench file, with a client at a port; its clock is the host's unless the file has another.

    Args:
        bench: whose time passes.
        bench_file: says what the agent is set to.
        spec: of the port, as on the command line.
        seed: decides what chance decides in faults.

    Raises:
        UnavailableError: the port cannot be opened.
    """
    port = open_at(bench, bench_file, spec, BAUD)
    tap = Tap(bench, port, _AGENT, seed=seed)
    settings = bench_file.settings_of(AgentSettings) or AgentSettings()
    agent = AgentOnLine(settings, epoch_ns=wall_time_ns() - bench.now_ns)
    DeviceActor(bench, agent, tap, name=_AGENT)
    bench.tables[_AGENT] = agent.tables
    machines = {_AGENT: agent.observed}
    about = about_line(_AGENT, "xrce", machines)
    return Rig(taps={"host": tap}, machines=machines, about=about, demo=False, close=port.close)
