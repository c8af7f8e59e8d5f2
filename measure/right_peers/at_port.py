"""``python -m measure.right_peers.at_port PEER``: a peer of this folder in real time, behind a pty that it names."""

from __future__ import annotations

import os
import select
import sys
import tty
from collections.abc import Mapping

from hilbench.clock import Stopwatch
from measure.right_peers.pioneer_robot import PioneerRobot
from measure.right_peers.rover_board import RoverBoard
from measure.right_peers.vehicle_board import VehicleBoard

__all__ = ["LINES", "PEERS", "OneLine"]


class OneLine:
    """A peer with one line, spoken to as one that has several.

    Args:
        peer: the peer.
    """

    def __init__(self, peer: PioneerRobot | RoverBoard) -> None:
        self._peer = peer

    @property
    def next_s(self) -> float:
        """When something is due."""
        return self._peer.next_s

    def poll(self, now_s: float) -> Mapping[str, bytes]:
        """Let time pass; return what is to be sent on each line."""
        return {"": self._peer.poll(now_s)}

    def feed(self, _line: str, data: bytes, now_s: float) -> Mapping[str, bytes]:
        """Hear bytes of a line; return what is to be sent on each."""
        return {"": self._peer.feed(data, now_s)}


PEERS = {
    "p2os": lambda now_s: OneLine(PioneerRobot(now_s)),
    "pkt": lambda now_s: OneLine(RoverBoard(now_s)),
    "carla": VehicleBoard,
}
"""What makes a peer that speaks a protocol, from the time in seconds, by the protocol's name."""
LINES = {"p2os": ("",), "pkt": ("",), "carla": VehicleBoard.LINES}
"""The names of its lines, as the checker has them."""


def _open() -> tuple[int, str]:
    """Open a pty; return our end, and the path of the other, which is held open."""
    near, far = os.openpty()
    tty.setraw(far)
    os.set_blocking(near, False)
    return near, os.ttyname(far)


def main(name: str) -> None:
    """Serve until the pty is gone or somebody interrupts."""
    ptys = {line: _open() for line in LINES[name]}
    sys.stdout.write(" ".join(path for _, path in ptys.values()) + "\n")
    sys.stdout.flush()
    ends = {near: line for line, (near, _) in ptys.items()}
    watch = Stopwatch()
    peer = PEERS[name](watch.elapsed_s())
    while True:
        ready, _, _ = select.select(ends, [], [], max(0.0, peer.next_s - watch.elapsed_s()))
        for near in ready:
            _write(ptys, peer.feed(ends[near], os.read(near, 4096), watch.elapsed_s()))
        _write(ptys, peer.poll(watch.elapsed_s()))


def _write(ptys: Mapping[str, tuple[int, str]], said: Mapping[str, bytes]) -> None:
    for line, data in said.items():
        near, left = ptys[line][0], data
        while left:
            select.select([], [near], [])
            left = left[os.write(near, left) :]


if __name__ == "__main__":
    try:
        main(sys.argv[1])
    except KeyboardInterrupt:
        sys.exit(130)
