"""P2OS, as hilbench knows it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hilbench.plugins.protocol import API, FirstTest, ProtocolPlugin, Quantity, Recorded
from protocols.p2os.clause import Clause
from protocols.p2os.decoding import checksum, decoder, encode, regions
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


_ANSWERS = {
    "SYNC0": ("SyncEcho",),
    "SYNC1": ("SyncEcho",),
    "SYNC2": ("Identification",),
    "CONFIG": ("ConfigPacket",),
    "ENCODER": ("EncoderPacket",),
    "GYRO": ("GyroPacket",),
    "GRIPREQUEST": ("GripperPacket",),
    "IOREQUEST": ("IoPacket",),
    "PLAYLIST": ("PlaylistPacket",),
    "TCM2": ("Tcm2Packet",),
    "ARM_INFO": ("ArmInfoPacket",),
    "ARM_STATUS": ("ArmStatusPacket",),
    "BATTERYINFO": ("BatteryPacket",),
    **dict.fromkeys(("GETAUX", "GETAUX2", "GETAUX3"), ("SerAuxPacket",)),
}


def _quantities(live: Mapping[str, Any]) -> Mapping[str, Quantity]:
    """Return what the raw fields of a SIP are on the robot of a bench; in its own units where that is not known."""
    found = {
        "x_raw": Quantity("x"),
        "y_raw": Quantity("y"),
        "th_raw": Quantity("heading"),
        "left_raw": Quantity("left", "mm/s"),
        "right_raw": Quantity("right", "mm/s"),
        "battery_dv": Quantity("battery", "V", 0.1),
        "control_raw": Quantity("control"),
        "compass_raw": Quantity("compass", "°", 2.0),
        "ticks_mm": Quantity("ticks", "1/mm"),
        "calibration_h": Quantity("horizontal calibration"),
        "calibration_v": Quantity("vertical calibration"),
    }
    if "subclass" in live:
        from protocols.p2os import robot_parameters
        from protocols.p2os.units import POSITION_MASK

        robot = robot_parameters(live["subclass"])
        turn = 360 / robot.units_per_turn
        found |= {
            "x_raw": Quantity("x", "mm", robot.distance_unit_mm, POSITION_MASK + 1),
            "y_raw": Quantity("y", "mm", robot.distance_unit_mm, POSITION_MASK + 1),
            "th_raw": Quantity("heading", "°", turn),
            "control_raw": Quantity("control", "°", turn),
            "sonars": Quantity("sonars", "mm", robot.range_unit_mm),
        }
    return found


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
    encode=encode,
    quantities=_quantities,
    answers=_ANSWERS,
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
