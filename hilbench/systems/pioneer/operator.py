"""Who speaks P2OS to a Pioneer on a live bench; see `hilbench.driving.operators`."""

from __future__ import annotations

import math

from hilbench.bench import Bench
from hilbench.bench.state_reporter import Observed
from hilbench.clock import NS_PER_MS
from hilbench.systems.pioneer.client import P2osClient
from protocols.p2os import ClientState as P2osState
from protocols.p2os import Sip

__all__ = ["PioneerOperator"]

SPEED_MM_S = 400
"""Of a Pioneer at full stick; ARIA's teleoperation mode has the same (AriaCoda ArModes.cpp, 400 mm/s)."""
TURN_DEG_S = 60
"""As above; a choice."""
PAD_TURN_DEG_S = math.degrees(1.70)
"""Of a Pioneer at the full stick of a game pad (qemu-gazebo-sim/pioneer_2DX-Interface code-esp32_d1
task_controller.cpp: -170 to 170 hundredths of a rad/s). Its full trigger is 400 mm/s, as `SPEED_MM_S` (bachelor-thesis,
Embedded systems simulator for robotics applications, USP 2025, Fig. 23)."""
_ENABLE_EVERY_NS = 500 * NS_PER_MS
_KEPT_PACKETS = 64


class PioneerOperator:
    """A P2OS client that drives a Pioneer.

    Args:
        bench: whose time passes.
        client: the client.
    """

    name = "client"
    pad_turn = PAD_TURN_DEG_S / TURN_DEG_S
    circle = (0.6, 0.3)

    def __init__(self, bench: Bench, client: P2osClient) -> None:
        self._bench = bench
        self._client = client
        self._commanded: tuple[int, int] | None = None
        self._enabled_ns: int | None = None

    @property
    def observed(self) -> Observed:
        """See `Operator`."""
        return self._client.connection

    @property
    def in_session(self) -> bool:
        """See `Operator`."""
        return self._client.state is P2osState.OPEN

    @property
    def idle(self) -> bool:
        """See `Operator`."""
        return self._client.state in {P2osState.IDLE, P2osState.CLOSED, P2osState.FAILED, P2osState.LOST}

    @property
    def room_ahead_m(self) -> float | None:
        """See `Operator`: the least of the newest readings of the discs that look ahead."""
        ranges = [
            reading.range_raw * self._client.robot.range_unit_mm
            for sip in self._newest_sips(4)
            for reading in sip.sonars
            if self._client.robot is not None and reading.number in {2, 3, 4, 5}
        ]
        return min(ranges) / 1000 if ranges else None

    def connect(self) -> None:
        """See `Operator`."""
        if self.idle:
            self._commanded = self._enabled_ns = None
            self._client.connect()

    def disconnect(self) -> None:
        """See `Operator`."""
        if not self.idle and self._client.state is not P2osState.CLOSING:
            self._client.disconnect()

    def drive(self, forward: float, turn: float) -> None:
        """See `Operator`; the motors are enabled first where they are not."""
        if not self.in_session:
            self._commanded = None
            return
        if (forward or turn) and not any(sip.motors_enabled for sip in self._newest_sips(1)):
            self._commanded = None
            if self._enabled_ns is None or self._bench.now_ns - self._enabled_ns > _ENABLE_EVERY_NS:
                self._enabled_ns = self._bench.now_ns
                self._client.enable()
            return
        wanted = (round(forward * SPEED_MM_S), round(turn * TURN_DEG_S))
        if wanted != self._commanded:
            self._commanded = wanted
            self._client.drive(*wanted)

    def tidy(self) -> None:
        """See `Operator`."""
        del self._client.packets[:-_KEPT_PACKETS]

    def _newest_sips(self, count: int) -> list[Sip]:
        found: list[Sip] = []
        for packet in reversed(self._client.packets):
            if isinstance(packet, Sip):
                found.append(packet)
            if len(found) == count:
                break
        return found
