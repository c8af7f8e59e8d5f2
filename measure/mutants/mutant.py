"""What a mutant is: one fault, as data.

A mutant says where it departs from the right device and nothing else. It can do so in five places: in what the device
is set to, in its state table, in the events that get lost between protocol and robot, on its way to the line (`wire`),
and in the robot's body.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from measure.mutants.wire import Rule
from protocols.p2os import ClientState, ServerState
from protocols.p2os.states import Action, ClientTrigger, ServerTrigger, State, Table, Transition, Trigger


class Family(enum.Enum):
    """Where a mutant comes from and which suites it is run against."""

    SERVER_TABLE = "server-table"
    SERVER_HAND = "server-hand"
    CLIENT_TABLE = "client-table"
    CLIENT_HAND = "client-hand"
    MOTION_HAND = "motion-hand"

    @property
    def of_client(self) -> bool:
        """Whether the mutant is a client."""
        return self in (Family.CLIENT_TABLE, Family.CLIENT_HAND)

    @property
    def suites(self) -> tuple[str, ...]:
        """The suites that have to find the fault."""
        if self.of_client:
            return ("p2os-client",)
        return ("pioneer-motion",) if self is Family.MOTION_HAND else ("p2os-server",)


@dataclass(frozen=True, slots=True)
class Edge:
    """One changed cell of a state table; without a transition the edge is gone."""

    state: State
    trigger: Trigger
    becomes: Transition | None = None


def server_edge(state: str, trigger: str, to: str = "", *actions: str) -> Edge:
    """An edge of the server's table by the names in `protocols.p2os.states`; without ``to`` there is none."""
    becomes = Transition(ServerState[to], tuple(Action[name] for name in actions)) if to else None
    return Edge(ServerState[state], ServerTrigger[trigger], becomes)


def client_edge(state: str, trigger: str, to: str = "", *actions: str) -> Edge:
    """As `server_edge`, of the client's table."""
    becomes = Transition(ClientState[to], tuple(Action[name] for name in actions)) if to else None
    return Edge(ClientState[state], ClientTrigger[trigger], becomes)


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyFault:
    """What is wrong between the controller and the robot's body.

    Attributes:
        wheel_scale: how much faster the (left, right) wheel turns than it is told.
        sonar_scale: factor of every range.
        sonar_shift_m: added to every range, in metres.
        sonar_mirrored: each disc of the front array hears what its mirror image should.
        sonar_deaf: discs that never hear an echo.
        motor_load: what both motors report as their load, whatever it is.
        never_released: the wheels stay under power when the motors are switched off.
        bumpers_mirrored: the segments are counted from the other side.
        bumpers_swapped: front and rear are exchanged.
        top_rad_s: the wheels turn no faster than this.
    """

    wheel_scale: tuple[float, float] = (1.0, 1.0)
    sonar_scale: float = 1.0
    sonar_shift_m: float = 0.0
    sonar_mirrored: bool = False
    sonar_deaf: frozenset[int] = frozenset()
    motor_load: float | None = None
    never_released: bool = False
    bumpers_mirrored: bool = False
    bumpers_swapped: bool = False
    top_rad_s: float | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Mutant:
    """A device with one fault.

    Attributes:
        id: stable name, unique over all families.
        family: see `Family`.
        what: what it does wrong, for people.
        settings: fields of `RobotSettings` that are other than they should be.
        server_options: the same, of `ServerOptions`.
        client_options: the same, of `ClientOptions`; whatever a case chooses itself.
        edges: changed cells of the state table.
        mute: names of protocol events that never reach the robot.
        wire: what happens to frames between device and line.
        longest_in: the largest count the tap on the wire takes for a frame on its way to the device.
        body: what is wrong with the body.
        equivalent: why nothing on the line can tell this mutant from the right device; empty if something can.
    """

    id: str
    family: Family
    what: str
    settings: Mapping[str, object] = field(default_factory=dict)
    server_options: Mapping[str, object] = field(default_factory=dict)
    client_options: Mapping[str, object] = field(default_factory=dict)
    edges: tuple[Edge, ...] = ()
    mute: frozenset[str] = frozenset()
    wire: tuple[Rule, ...] = ()
    longest_in: int = 200
    body: BodyFault | None = None
    equivalent: str = ""

    def mutate(self, table: Table) -> Table:
        """Return the table with the changed cells."""
        cells = dict(table)
        for edge in self.edges:
            if edge.becomes is None:
                cells.pop((edge.state, edge.trigger), None)
            else:
                cells[edge.state, edge.trigger] = edge.becomes
        return MappingProxyType(cells)
