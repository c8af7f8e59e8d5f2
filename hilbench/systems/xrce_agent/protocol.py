"""DDS-XRCE, as hilbench knows it."""

from __future__ import annotations

from hilbench.plugins.protocol import API, ProtocolPlugin
from protocols.xrce import decoding

__all__ = ["BAUD", "XRCE"]

BAUD = 115_200
"""The usual rate of micro-ROS's serial transports."""

XRCE = ProtocolPlugin(
    api=API,
    name="xrce",
    title="DDS-XRCE",
    summary="micro-ROS between a board and its agent, in serial frames or over TCP",
    help="The agent keeps a session with the client at each line, and hands on what one writes to those who read it.",
    decoder=decoding.decoder,
    regions=decoding.regions,
    longest_frame=2 * 1024,
    baud=BAUD,
)
