"""The task of the adapter that has the pins: what the firmware wants (bluepill_comm.cpp, task_controller.cpp)."""

from __future__ import annotations

from collections.abc import Sequence

from targets.parts.p2os_adapter.events import CodesRead, ConnectionPin, SafeStopped
from targets.parts.p2os_adapter.sampling import ConnectionSampler, read_burst
from targets.parts.p2os_adapter.settings import P2osAdapterSettings
from targets.parts.p2os_adapter.velocity import STILL, Velocity, velocity_of_codes
from targets.parts.part import Ports
from targets.parts.words import BitOrder, signed, word_of

__all__ = ["PinTask"]


class PinTask:
    """Reads p2dx_con and the motor wires, and drives the echo.

    Args:
        settings: of the adapter.
        ports: what it is connected to.
        motors: terminals of the motor wires, left comm1 to comm3, then right.
        now_ns: when it starts.

    Attributes:
        connected: p2dx_con, as it is acted on.
    """

    def __init__(self, settings: P2osAdapterSettings, ports: Ports, motors: Sequence[str], now_ns: int) -> None:
        self._settings = settings
        self._order: BitOrder = settings.motor_order
        self._tell = ports.tell
        self._echo = ports.output("echo")
        self._motors = [ports.input(name) for name in motors]
        window_ns = round(settings.connection_sample_ms * 1e6)
        self._sampler = ConnectionSampler(ports.input("p2dx_con"), window_ns, now_ns)
        self._spacing_ns = round(settings.motor_read_spacing_us * 1e3)
        self._live_ns = now_ns + round(settings.dead_time_s * 1e9)
        self._patience_ns = None if settings.safe_stop_s is None else round(settings.safe_stop_s * 1e9)
        self._burst: tuple[bool, ...] | None = None
        self._codes = (0, 0)
        self._wanted = STILL
        self._changed_ns = now_ns
        self._stopped = False
        self.connected = False
        self._echo.set(False, now_ns)

    @property
    def velocity(self) -> Velocity:
        """What the motor codes ask for, or rest after a safe stop."""
        return STILL if self._stopped else self._wanted

    def take_pass(self, at_ns: int) -> None:
        """Read a burst, or decode the burst of the last pass; look at p2dx_con."""
        burst, self._burst = self._burst, None
        if burst is None:
            reads = self._settings.motor_reads
            self._burst = read_burst(self._motors, at_ns, reads=reads, spacing_ns=self._spacing_ns)
        else:
            self._decode(burst, at_ns)
        self._sampler.take_pass(at_ns)
        if self._sampler.high is not self.connected and at_ns > self._live_ns:
            self._connect(self._sampler.high, at_ns)
        self._watch(at_ns)

    def _decode(self, burst: tuple[bool, ...], at_ns: int) -> None:
        left, right = (signed(word_of(bits, self._order)) for bits in (burst[:3], burst[3:]))
        if (left, right) == self._codes:
            return
        self._codes = (left, right)
        self._wanted = velocity_of_codes(left, right, self._settings)
        self._stir(at_ns)
        self._tell(
            CodesRead(left=left, right=right, speed_m_s=self._wanted.speed_m_s, turn_rad_s=self._wanted.turn_rad_s)
        )

    def _connect(self, connected: bool, at_ns: int) -> None:
        self.connected = connected
        self._stir(at_ns)
        self._echo.set(connected, at_ns)
        self._tell(ConnectionPin(connected=connected))

    def _stir(self, at_ns: int) -> None:
        self._changed_ns = at_ns
        self._stopped = False

    def _watch(self, at_ns: int) -> None:
        if self._patience_ns is None or self._stopped or self._wanted == STILL:
            return
        if at_ns - self._changed_ns >= self._patience_ns:
            self._stopped = True
            self._tell(SafeStopped())
