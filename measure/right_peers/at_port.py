"""``python -m measure.right_peers.at_port PEER``: a peer of this folder in real time, behind a pty that it names."""

from __future__ import annotations

import os
import select
import sys
import tty

from hilbench.clock import Stopwatch
from measure.right_peers.pioneer_robot import PioneerRobot
from measure.right_peers.rover_board import RoverBoard

__all__ = ["PEERS"]

PEERS = {"p2os": PioneerRobot, "pkt": RoverBoard}
"""What speaks a protocol, by its name."""


def main(name: str) -> None:
    """Serve until the pty is gone or somebody interrupts."""
    near, far = os.openpty()
    tty.setraw(far)
    os.set_blocking(near, False)
    sys.stdout.write(os.ttyname(far) + "\n")
    sys.stdout.flush()
    watch = Stopwatch()
    peer = PEERS[name](watch.elapsed_s())
    while True:
        ready, _, _ = select.select([near], [], [], max(0.0, peer.next_s - watch.elapsed_s()))
        said = peer.feed(os.read(near, 4096), watch.elapsed_s()) if ready else peer.poll(watch.elapsed_s())
        while said:
            _, ready, _ = select.select([], [near], [])
            said = said[os.write(near, said) :]


if __name__ == "__main__":
    try:
        main(sys.argv[1])
    except KeyboardInterrupt:
        sys.exit(130)
