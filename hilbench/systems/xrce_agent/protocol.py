"""DDS-XRCE, as hilbench knows it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench.plugins.protocol import API, Device, Heard, ProtocolPlugin, TopicSample
from hilbench.systems.xrce_agent.settings import AgentSettings, ClientSettings
from protocols.common.clause import Clause
from protocols.common.decoding import NoOptions
from protocols.xrce import decoding

if TYPE_CHECKING:
    from hilbench.bench.devices import SerialDevice

__all__ = ["BAUD", "CLIENT_SIDE", "XRCE"]

BAUD = 115_200
"""The usual rate of micro-ROS's serial transports."""


def _clauses() -> Sequence[Clause]:
    from protocols.xrce.clauses import CLAUSES

    return CLAUSES


def _board(settings: NoOptions) -> SerialDevice:
    from hilbench.systems.xrce_agent.board import SpeedBoard

    return SpeedBoard(settings)


def _agent(settings: AgentSettings) -> SerialDevice:
    from hilbench.systems.xrce_agent.agent import AgentOnLine

    return AgentOnLine(settings)


def _client(settings: ClientSettings) -> SerialDevice:
    from hilbench.systems.xrce_agent.client import ModelClient

    return ModelClient(settings)


def _samples(frames: Sequence[Heard], folders: Sequence[Path]) -> tuple[list[TopicSample], list[str]]:
    from hilbench.systems.xrce_agent.samples import samples_in

    return samples_in(frames, folders)


_ANSWERS = {
    "CreateClient": ("StatusAgent",),
    "Create": ("StatusReply",),
    "Delete": ("StatusReply",),
    "GetInfo": ("Info",),
    "Timestamp": ("TimestampReply",),
    "Heartbeat": ("AckNack",),
}

XRCE = ProtocolPlugin(
    api=API,
    name="xrce",
    title="DDS-XRCE",
    summary="micro-ROS between a board and its agent, in serial frames or over TCP",
    help="The agent keeps a session with the client at each line, and hands on what one writes to those who read it.",
    decoder=decoding.decoder,
    answers=_ANSWERS,
    encode=decoding.encode,
    regions=decoding.regions,
    clauses=_clauses,
    device=Device(make=_agent, settings=AgentSettings, resting=frozenset({"HEARTBEAT"})),
    host=Device(make=_board, resting=frozenset({"HEARTBEAT"})),
    longest_frame=2 * 1024,
    baud=BAUD,
    samples=_samples,
)

CLIENT_SIDE = replace(
    XRCE,
    device=Device(make=_client, settings=ClientSettings, resting=frozenset({"HEARTBEAT", "RETRY"})),
    host=Device(make=_agent, settings=AgentSettings, resting=frozenset({"HEARTBEAT"})),
)
"""The same with the ends changed: what stands on the bench is a client, and who speaks to it an agent."""
