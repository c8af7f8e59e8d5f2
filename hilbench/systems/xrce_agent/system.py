"""The agent as something that stands on a bench, and is served to clients that are not ours; and such a client."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from types import MappingProxyType
from typing import TYPE_CHECKING

from hilbench.plugins.system import API, ModelKind, System
from hilbench.systems.xrce_agent.settings import AgentSettings, ClientSettings

if TYPE_CHECKING:
    from hilbench.bench import Bench
    from hilbench.bench.served_targets import ServedTarget
    from hilbench.bench.shared import Shared
    from hilbench.benchfile.bench_file import BenchFile
    from hilbench.driving.rig import Rig
    from hilbench.judging.provider import BenchProvider
    from hilbench.links import Port
    from hilbench.plugins.dashboard import Dashboard
    from hilbench.systems.xrce_agent.dds import DdsDomain
    from hilbench.terminal.options import TargetChoice

__all__ = ["LINES", "XRCE_AGENT"]

LINES = ("line1", "line2", "line3", "line4")
"""Each takes one client."""


class XrceAgent(System):
    """See the module."""

    api = API
    name = "xrce-agent"
    title = "XRCE agent"
    summary = "the agent of micro-ROS: boards connect to it, and to each other through it"
    speakers = MappingProxyType({"agent": "target"})

    def models(self) -> Mapping[str, ModelKind]:
        """See `System`."""
        from hilbench.systems.xrce_agent.protocol import BAUD

        return {
            self.name: ModelKind(
                settings=AgentSettings,
                protocol="DDS-XRCE",
                suites=("xrce-agent",),
                baud=BAUD,
                lines=LINES,
                bench="xrce-agent",
            ),
            "xrce-client": ModelKind(
                settings=ClientSettings,
                protocol="DDS-XRCE",
                suites=("xrce-client",),
                baud=BAUD,
                lines=("agent",),
                bench="xrce-client",
            ),
        }

    def provider(self, shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider:
        """See `System`; the checker is the client at one line of an agent, or the agent of a client."""
        return _speaking(shared.bench_file).provider(shared, choices)

    def rig(self, bench: Bench, bench_file: BenchFile, *, seed: int) -> Rig:
        """See `System`; a board of ours is the agent's client, or an agent the client's."""
        return _speaking(bench_file).rig(bench, bench_file, seed=seed)

    def attached_rig(self, bench: Bench, bench_file: BenchFile, ports: Mapping[str, str], *, seed: int) -> Rig:
        """See `System`; what is at the port is a client, and ours is the agent."""
        from hilbench.systems.xrce_agent.live import attached_agent

        return attached_agent(bench, bench_file, ports[""], seed=seed)

    def dashboard(self) -> Dashboard:
        """See `System`."""
        from hilbench.systems.xrce_agent.dashboard import DASHBOARD

        return DASHBOARD

    def beside_boards(self, bench_file: BenchFile, *, seed: int) -> ServedTarget:
        """See `System`; its clock begins at 0, unless the bench file says otherwise."""
        if bench_file.settings_of(ClientSettings) is not None:
            return _speaking(bench_file).beside_boards(bench_file, seed=seed)
        return _agent_of(bench_file, None, lambda _bench: 0)

    def served(self, bench_file: BenchFile, *, scene: str | None, baud: int | None, seed: int) -> ServedTarget:
        """See `System`; its clock is the host's, unless the bench file says otherwise."""
        from hilbench.clock import wall_time_ns

        if bench_file.settings_of(ClientSettings) is not None:
            return _speaking(bench_file).served(bench_file, scene=scene, baud=baud, seed=seed)
        return _agent_of(bench_file, baud, lambda bench: wall_time_ns() - bench.now_ns)


def _agent_of(bench_file: BenchFile, baud: int | None, epoch_ns: Callable[[Bench], int]) -> ServedTarget:
    from hilbench.bench.devices import LinesActor
    from hilbench.bench.served_targets import ServedTarget
    from hilbench.systems.xrce_agent.agent import agent_of, baud_of, tables_of

    name, settings = next(
        (name, target.settings)
        for name, target in bench_file.targets.items()
        if isinstance(target.settings, AgentSettings)
    )
    lines = {f"{name}.{line}": baud or baud_of(bench_file, f"{name}.{line}") for line in LINES}

    def make(bench: Bench, ports: Mapping[str, Port], domain: DdsDomain | None = None) -> Callable[[], None]:
        ends = {end.rpartition(".")[2]: port for end, port in ports.items()}
        agent = agent_of(settings, LINES, epoch_ns=epoch_ns(bench))
        actor = LinesActor(bench, agent, ends, name=name)
        bench.tables[name] = tables_of(agent, settings).look
        if domain is None:
            return lambda: None
        domain.join(bench, name, agent, actor.transmit)
        return domain.close

    def in_dds(domain_id: int, say: Callable[[str], None]) -> ServedTarget:
        from hilbench.systems.xrce_agent.dds import DdsDomain

        domain = DdsDomain(domain_id, history=settings.history, say=say)
        return replace(target, make=partial(make, domain=domain))

    target = ServedTarget(lines, make, name, may_be_open=True, one_client=True, in_dds=in_dds)
    return target


def _speaking(bench_file: BenchFile) -> System:
    """Return the system around the protocol alone: with an agent on the bench, or with a client."""
    from hilbench.protocol_bench.system import ProtocolSystem
    from hilbench.systems.xrce_agent.protocol import CLIENT_SIDE, XRCE

    return ProtocolSystem(XRCE if bench_file.settings_of(ClientSettings) is None else CLIENT_SIDE)


XRCE_AGENT = XrceAgent()
