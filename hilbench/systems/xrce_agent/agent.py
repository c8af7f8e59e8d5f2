"""The agent of a bench file."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from hilbench.benchfile.bench_file import BenchFile
from hilbench.clock import NS_PER_S
from hilbench.systems.xrce_agent.definitions import library_of
from hilbench.systems.xrce_agent.protocol import BAUD
from hilbench.systems.xrce_agent.settings import AgentSettings
from protocols.common.tables import Table
from protocols.xrce import AgentEvent, AgentOptions, AgentService, AgentTables, Framing, FramingOptions, Session

__all__ = ["AgentOnLine", "agent_of", "baud_of", "tables_of"]

_LINE = "host"


def agent_of(settings: AgentSettings, lines: Sequence[str], *, epoch_ns: int = 0) -> AgentService:
    """Return the agent that is set so.

    Args:
        settings: as in a bench file.
        lines: the names of its lines.
        epoch_ns: what its clock says at bench time 0 where the settings do not say it, in ns.
    """
    if settings.epoch_s is not None:
        epoch_ns = round(settings.epoch_s * NS_PER_S)
    options = AgentOptions(
        silence_s=settings.silence_s,
        epoch_ns=epoch_ns,
        history=settings.history,
        max_objects=settings.max_objects,
        references=settings.references,
        frames=FramingOptions(framing=Framing.EITHER),
    )
    return AgentService(lines, options)


def tables_of(agent: AgentService, settings: AgentSettings) -> AgentTables:
    """Return what an agent has to show."""
    return AgentTables(lambda: agent, library_of([Path(folder) for folder in settings.types]))


class AgentOnLine:
    """An agent with one line, as a device.

    Args:
        settings: as in a bench file.
        epoch_ns: what its clock says at bench time 0 where the settings do not say it, in ns.
    """

    def __init__(self, settings: AgentSettings, *, epoch_ns: int = 0) -> None:
        self.service = agent_of(settings, (_LINE,), epoch_ns=epoch_ns)
        self._tables = tables_of(self.service, settings)

    @property
    def observed(self) -> Session:
        """What a dashboard looks at: the session at its line."""
        return self.service.sessions[_LINE]

    def tables(self) -> Mapping[str, Table]:
        """Return what a dashboard shows of it."""
        return self._tables.look()

    def receive(self, data: bytes, now_ns: int) -> bytes:
        """Take bytes off the line; return what to put on it."""
        return b"".join(data for _, data in self.service.receive(_LINE, data, now_ns))

    def advance(self, now_ns: int) -> bytes:
        """Do what is due; return what to put on the line."""
        return b"".join(data for _, data in self.service.advance(now_ns))

    def next_deadline_ns(self) -> int | None:
        """Return when `advance` must be called, in ns, or None."""
        return self.service.next_deadline_ns()

    def line_down(self, now_ns: int) -> bytes:
        """Take note that the line was hung up."""
        return b"".join(data for _, data in self.service.line_down(_LINE, now_ns))

    def take_events(self) -> list[AgentEvent]:
        """Return what happened since the last call."""
        return self.service.take_events()


def baud_of(bench_file: BenchFile, end: str) -> int:
    """Return the rate of the line at this end, in bit/s."""
    return next((link.baud for link in bench_file.links if end in link.ends), BAUD)
