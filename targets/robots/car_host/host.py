"""A car host: takes the board's commands for the car, and tells the board how the car moves.

It is a device on a line: bytes and a time in, bytes out. What the car does is told by `sense`; what it is to do is
`wish`. The original is two programs, the bridge of the line and CARLA's ackermann node, and a simulator behind them.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from protocols.carla import (
    AckermannCommand,
    Commanded,
    Connection,
    Event,
    ManualCommand,
    Role,
    Transmit,
)
from targets.robots.car_host.behaviour import Behaviour, behaviour_of
from targets.robots.car_host.events import CarCommanded
from targets.robots.car_host.settings import CarHostSettings

__all__ = ["CarHost", "CarState", "CarWish"]

_NS_PER_S = 1_000_000_000
_NODE_NS = 50_000_000
"""How often the ackermann node commands the car: 20 Hz (carla_ackermann_control_node.py, control loop rate)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class CarState:
    """How the car moves, in ROS axes: x forwards, y left, turns to the left positive.

    Attributes:
        lon_speed_m_s: along the car.
        lat_speed_m_s: across it.
        yaw_rate_rad_s: of its heading.
        steering_rad: the tyre's angle.
        steer: CARLA's own figure of it, -1 to 1 and positive to the right, of which the angle is made then; None where
            the angle is known.
    """

    lon_speed_m_s: float = 0.0
    lat_speed_m_s: float = 0.0
    yaw_rate_rad_s: float = 0.0
    steering_rad: float = 0.0
    steer: float | None = None


CarWish = AckermannCommand | ManualCommand | None
"""What the car is to do: a motion, pedals, or nothing that anybody has asked for."""


class CarHost:
    """See the module.

    Args:
        settings: what it is set to.
        power_on_ns: when it is started, in ns of bench time.
        behaviour: another one than that of the settings.
        connection: another end of the protocol, for tests that must be able to fail.

    Attributes:
        wish: what the car is to do.
        connection: its end of the protocol, with its counters.
        state: how the car moves, as it was told.
    """

    def __init__(
        self,
        settings: CarHostSettings,
        *,
        power_on_ns: int = 0,
        behaviour: Behaviour | None = None,
        connection: Connection | None = None,
    ) -> None:
        self.behaviour = behaviour or behaviour_of(settings.profile, settings.defects, settings.signs)
        self.connection = connection or Connection(Role.SIMULATOR, self.behaviour.line, epoch_ns=power_on_ns)
        self.state = CarState()
        self.wish: CarWish = None
        self._status_ns = round(_NS_PER_S / settings.status_hz)
        self._next_status_ns: int | None = power_on_ns + self._status_ns
        self._node_ns: int | None = None
        self._node_until_ns = 0
        self._node_wish: AckermannCommand | None = None
        self._events: list[object] = []

    # --- the car

    def sense(self, state: CarState) -> None:
        """Takes how the car moves now; the next status says so."""
        self.state = state

    def report_by_hand(self) -> None:
        """Says no status by itself any more; `report` says the velocity, the steering, or both."""
        self._next_status_ns = None

    def report(self, *what: str, now_ns: int) -> bytes:
        """Says ``velocity`` or ``steering`` to the bridge, as the simulator does; returns what to put on the line."""
        signs, steer = self.behaviour.host.signs, self.state.steer
        status = signs.status(
            lon_speed_m_s=self.state.lon_speed_m_s,
            lat_speed_m_s=self.state.lat_speed_m_s,
            yaw_rate_rad_s=self.state.yaw_rate_rad_s,
            tyre_rad=self.state.steering_rad if steer is None else signs.tyre_rad(steer),
        )
        sent = b""
        for one in what:
            if one == "velocity":
                events = self.connection.velocity(
                    status.lon_speed_m_s, status.lat_speed_m_s, status.heading_rate_rad_s, now_ns
                )
            else:
                events = self.connection.steering(status.steering_rad, now_ns)
            sent += self._take(events, now_ns)
        return sent

    def read_error(self, *, failing: bool, now_ns: int) -> bytes:
        """Reading the line fails from now on, or works again; returns what to put on the line."""
        return self._take(self.connection.read_error(now_ns, failing=failing), now_ns)

    # --- a device on a line

    def receive(self, data: bytes, now_ns: int) -> bytes:
        """Takes bytes off the line; returns what to put on it."""
        sent = self.advance(now_ns)
        return sent + self._take(self.connection.receive(data, now_ns), now_ns)

    def advance(self, now_ns: int) -> bytes:
        """Does what is due at a time; returns what to put on the line."""
        sent = b""
        while (due_ns := self.next_deadline_ns()) is not None and due_ns <= now_ns:
            sent += self._take(self.connection.advance(due_ns), due_ns)
            if self._next_status_ns is not None and self._next_status_ns <= due_ns:
                self._next_status_ns += self._status_ns
                sent += self.report(*self.behaviour.host.reports, now_ns=due_ns)
            if self._node_ns is not None and self._node_ns <= due_ns:
                self._run_node(due_ns)
        return sent + self._take(self.connection.advance(now_ns), now_ns)

    def next_deadline_ns(self) -> int | None:
        """When `advance` has something to do."""
        due = (self.connection.next_deadline_ns(), self._next_status_ns, self._node_ns)
        return min((ns for ns in due if ns is not None), default=None)

    def line_down(self, now_ns: int) -> bytes:
        """The line is gone; a tty without modem control does not notice."""
        return self.advance(now_ns)

    def take_events(self) -> Iterable[object]:
        """What happened since the last call."""
        events, self._events = self._events, []
        return events

    # --- the car's command layer

    def _take(self, events: Iterable[Event], now_ns: int) -> bytes:
        sent = b""
        for event in events:
            if isinstance(event, Transmit):
                sent += event.data
                continue
            self._events.append(event)
            if isinstance(event, Commanded):
                self._command(event.command, event.mode if event.frame is not None else None, now_ns)
        return sent

    def _command(self, command: AckermannCommand | ManualCommand, mode: int | None, now_ns: int) -> None:
        if isinstance(command, AckermannCommand) and self.behaviour.host.node_holds_s:
            self._node_wish = command
            self._node_until_ns = now_ns + round(self.behaviour.host.node_holds_s * _NS_PER_S)
            self._node_ns = now_ns + _NODE_NS if self._node_ns is None else self._node_ns
        self._tell(command, mode=mode)

    def _run_node(self, now_ns: int) -> None:
        """CARLA's ackermann node commands the car, whatever else does, until its own last command is too old."""
        if now_ns >= self._node_until_ns or self._node_wish is None:
            self._node_ns = None
            return
        self._node_ns = now_ns + _NODE_NS
        if self.wish != self._node_wish:
            self._tell(self._node_wish, by_node=True)

    def _tell(
        self, command: AckermannCommand | ManualCommand, *, mode: int | None = None, by_node: bool = False
    ) -> None:
        self.wish = command
        self._events.append(CarCommanded(command=command, mode=mode, by_node=by_node))
