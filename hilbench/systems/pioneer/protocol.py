"""P2OS, as hilbench knows it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from hilbench.plugins.protocol import API, FirstTest, ProtocolPlugin, Recorded
from protocols.p2os.clause import Clause
from protocols.p2os.decoding import checksum, decoder, regions
from protocols.p2os.framing import MAX_COUNT

if TYPE_CHECKING:
    from hilbench.bench import Bench
    from hilbench.links import Port
    from hilbench.systems.pioneer.peer import Peer

__all__ = ["P2OS"]

_FIRST_TEST = '''\
"""What the robot at {target} must do. Run it with: pytest"""

from __future__ import annotations

from hilbench.check import case
from protocols.p2os import Sip


@case("S01")  # a clause of the catalogue: hilbench check pioneer --list
def test_sync0_is_echoed(peer):
    peer.sync(0)


@case("OUR01", text="A session begins with a robot that stands.", level="must", source="our panel, rev. A")
def test_it_stands(peer):
    peer.start()
    peer.expect(Sip, 1.0, where=lambda sip: not sip.moving, what="SIP of a robot that stands")
'''


def _clauses() -> Sequence[Clause]:
    from protocols.p2os.clauses import CLAUSES

    return CLAUSES


def _peer(bench: Bench, port: Port, program: str) -> Peer:
    from hilbench.systems.pioneer.peer import Peer

    del program
    return Peer(bench, port)


P2OS = ProtocolPlugin(
    api=API,
    name="p2os",
    title="P2OS",
    summary="the host protocol of the Pioneer robots",
    help="Our client speaks P2OS to a Pioneer: SYNC0, SYNC1 and SYNC2 open the session, then the robot sends a SIP ten "
    "times a second. If the client falls silent, the robot's watchdog stops it.",
    decoder=decoder,
    regions=regions,
    checksum=checksum,
    longest_frame=3 + MAX_COUNT,
    clauses=_clauses,
    peer=_peer,
    baud=9600,
    recorded=Recorded(
        capabilities=frozenset({"server", "client", "client.commands"}),
        suites=("recorded-p2os", "p2os-client", "p2os-server", "pioneer-motion"),
    ),
    replay_bench="pioneer",
    first_test=FirstTest(bench="pioneer", text=_FIRST_TEST),
)
