"""The agent of a bench file."""

from __future__ import annotations

from collections.abc import Sequence

from hilbench.benchfile.bench_file import BenchFile
from hilbench.clock import NS_PER_S
from hilbench.systems.xrce_agent.protocol import BAUD
from hilbench.systems.xrce_agent.settings import AgentSettings
from protocols.xrce import AgentOptions, AgentService, Framing, FramingOptions

__all__ = ["agent_of", "baud_of"]


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


def baud_of(bench_file: BenchFile, end: str) -> int:
    """Return the rate of the line at this end, in bit/s."""
    return next((link.baud for link in bench_file.links if end in link.ends), BAUD)
