"""Who speaks PKT! to a rover on a live bench; see `hilbench.driving.operators`."""

from __future__ import annotations

from hilbench.bench import Bench
from hilbench.bench.state_reporter import Observed
from hilbench.clock import NS_PER_MS
from hilbench.systems.rover.ground_station import GroundStation
from protocols.pkt import ClientState as PktState

__all__ = ["RoverOperator"]

THROTTLE = 0.8
"""Of a rover at full stick, as a share of full voltage (choice)."""
_AGAIN_NS = 500 * NS_PER_MS


class RoverOperator:
    """A ground station that drives a rover.

    A rover that has stopped because it heard nobody stays at rest until it is commanded again. So a motion that is
    wanted is commanded twice a second.

    Args:
        bench: whose time passes.
        station: the station.
    """

    name = "station"
    pad_turn = 1.0
    circle = (0.6, 0.9)
    """The inner wheels go back: on a floor of dry friction it goes straight otherwise (docs/rover-vehicle.md)."""
    room_ahead_m: float | None = None

    def __init__(self, bench: Bench, station: GroundStation) -> None:
        self._bench = bench
        self._station = station
        self._commanded: tuple[float, float] | None = None
        self._commanded_ns = 0

    @property
    def observed(self) -> Observed:
        """See `Operator`."""
        return self._station.connection

    @property
    def in_session(self) -> bool:
        """See `Operator`."""
        return self._station.state is PktState.LINKED

    @property
    def idle(self) -> bool:
        """See `Operator`."""
        return self._station.state is PktState.IDLE

    def connect(self) -> None:
        """See `Operator`."""
        if self.idle:
            self._commanded = None
            self._station.connect()

    def disconnect(self) -> None:
        """See `Operator`."""
        if not self.idle:
            self._station.disconnect()

    def drive(self, forward: float, turn: float) -> None:
        """See `Operator`: by throttles, the turn as their difference."""
        if not self.in_session:
            self._commanded = None
            return
        left, right = (max(-1.0, min(1.0, share)) * THROTTLE for share in (forward - turn, forward + turn))
        again = (left or right) and self._bench.now_ns - self._commanded_ns >= _AGAIN_NS
        if (left, right) != self._commanded or again:
            self._commanded, self._commanded_ns = (left, right), self._bench.now_ns
            self._station.drive_motors(left, right)

    def tidy(self) -> None:
        """See `Operator`; a station keeps no more than it can."""
