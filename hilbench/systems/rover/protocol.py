"""PKT!, as hilbench knows it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from hilbench.plugins.protocol import API, FirstTest, ProtocolPlugin, Quantity, Recorded
from protocols.pkt.clause import Clause
from protocols.pkt.decoding import DecodeOptions, checksum, decoder, encode, regions
from protocols.pkt.framing import longest_frame

if TYPE_CHECKING:
    from hilbench.bench import Bench
    from hilbench.links import Port
    from hilbench.systems.rover.peer import RoverPeer

__all__ = ["PKT"]

_FIRST_TEST = '''\
"""What the rover at {target} must do. Run it with: pytest"""

from __future__ import annotations

from hilbench.check import case
from protocols.pkt import GeneralReport, RequestTelemetry


@case("OUR01", text="A request is answered within 0.5 s.", level="must", source="our board, rev. A")
def test_a_request_is_answered(peer):
    peer.write(peer.frame_of(RequestTelemetry()))
    peer.expect(GeneralReport, 0.5)
'''


def _clauses() -> Sequence[Clause]:
    from protocols.pkt.clauses import CLAUSES

    return CLAUSES


_COMMANDS = (
    "LED_ON", "LED_OFF", "UPDATE_MOTOR_SPEEDS", "UPDATE_MOTOR_THROTTLES", "UPDATE_MOTOR_SPEED_SETPOINTS",
    "RESET_PID_CONTROLLER",
)  # fmt: skip
_ANSWERS = {"REQUEST_TMY": ("GeneralReport",), **dict.fromkeys(_COMMANDS, ("ExecutionReport",))}
_THROTTLE = {"throttles": "throttles", "a": "left", "b": "right"}
"""In the last schema, shares of full voltage; before that PWM counts."""


def _quantities(live: Mapping[str, Any]) -> Mapping[str, Quantity]:
    of_v2 = live.get("schema", "V2") == "V2"
    return {
        "rpm": Quantity("rpm", "rpm"),
        **{name: Quantity(label, *(("%", 100.0) if of_v2 else ())) for name, label in _THROTTLE.items()},
    }


def _peer(bench: Bench, port: Port, program: str) -> RoverPeer:
    from hilbench.systems.rover.peer import RoverPeer
    from protocols.pkt import PROFILES

    return RoverPeer(bench, port, PROFILES.get(program, PROFILES["documented"]))


PKT = ProtocolPlugin(
    api=API,
    name="pkt",
    title="PKT!",
    summary="the rover's frames with a CRC16",
    help="Our ground station speaks PKT to a rover: it asks and the rover reports. A rover that hears nobody stops.",
    decoder=decoder,
    options=DecodeOptions,
    encode=encode,
    quantities=_quantities,
    answers=_ANSWERS,
    regions=regions,
    checksum=checksum,
    longest_frame=longest_frame(),
    clauses=_clauses,
    peer=_peer,
    baud=115200,
    recorded=Recorded(capabilities=frozenset({"server", "client"}), suites=("recorded-pkt", "pkt-board", "pkt-host")),
    replay_bench="rover-model",
    first_test=FirstTest(bench="rover-model", text=_FIRST_TEST),
)
