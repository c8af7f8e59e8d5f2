"""The adapter's side of the P2OS line: opens and closes sessions, sends velocities, keeps the robot alive.

What the library of the original sends (p2os-arduino p2os_comm.cpp, task_controller.cpp): after the set-up PULSE and
SETO; then PULSE, ENABLE, VEL and RVEL, see `settings.py`. Different here, each a choice: ENABLE goes out as soon as the
session is open, ahead of the first VEL, which a robot without motor power would forget; nothing waits for a packet of
the robot before the next command; bytes that are no packet are dropped, where the original takes whatever has a
checksum byte other than 0; the session ends with STOP, ENABLE 0 and CLOSE, where the original leaves out ENABLE 0.
"""

from __future__ import annotations

from collections.abc import Callable

from protocols.p2os import (
    ClientOptions,
    ClientState,
    Command,
    CommandNumber,
    Connected,
    ConnectFailed,
    Connection,
    ConnectionLost,
    Disconnected,
    Event,
    FrameDropped,
    PacketReceived,
    RobotParameters,
    Role,
    Sip,
    Transmit,
    UnknownSubclass,
)
from targets.parts.p2os_adapter.events import (
    BytesDropped,
    RobotConnected,
    RobotConnectFailed,
    RobotLeft,
    RobotLost,
    SpeedSent,
)
from targets.parts.p2os_adapter.settings import P2osAdapterSettings
from targets.parts.p2os_adapter.velocity import STILL, Velocity, wire_speeds

__all__ = ["RobotLink"]

_OPTIONS = ClientOptions(
    sync_timeout_s=0.4,
    session_argument=None,
    request_config=False,
    keepalive_s=None,
    unknown_subclass=UnknownSubclass.FALL_BACK,
    fallback_subclass="p2dx",
    wide_status=True,
)
"""As p2os-arduino: SYNC again after 0.4 s, bare OPEN and CLOSE, the first table row for an unknown robot."""

_AT_REST = (ClientState.IDLE, ClientState.CLOSED, ClientState.FAILED, ClientState.LOST)
_S = 1_000_000_000
_MS = 1_000_000


class RobotLink:
    """One client of the robot, with the velocity that it was commanded last.

    Args:
        settings: of the adapter.
        send: takes bytes for the line.
        tell: takes the events.
        on_session: called with the robot's parameters, and the time, when a session has been opened.
        on_sip: called with each SIP of a session, and its time.
        now_ns: when it begins.
    """

    def __init__(
        self,
        settings: P2osAdapterSettings,
        *,
        send: Callable[[bytes], None],
        tell: Callable[[object], None],
        on_session: Callable[[RobotParameters, int], None],
        on_sip: Callable[[Sip, int], None],
        now_ns: int,
    ) -> None:
        self._settings = settings
        self._put = send
        self._tell = tell
        self._on_session = on_session
        self._on_sip = on_sip
        self._connection = Connection(Role.CLIENT, _OPTIONS)
        self._wanted = False
        self._connect_ns: int | None = None
        self._velocity = STILL
        self._velocity_ns = now_ns
        self._pulse_ns = now_ns
        self._enable_ns = now_ns

    @property
    def open(self) -> bool:
        """A session is open."""
        return self._connection.state is ClientState.OPEN

    def want(self, connected: bool, now_ns: int) -> None:
        """Open a session, or close it; while one is closed, another has to wait."""
        if connected is self._wanted:
            return
        self._wanted = connected
        self._connect_ns = now_ns if connected else None
        if not connected:
            self._leave(now_ns)

    def follow(self, velocity: Velocity, now_ns: int) -> None:
        """One pass of its program: connect if it is time to, else send what is due."""
        if self._connect_ns is not None and now_ns >= self._connect_ns and self._connection.state in _AT_REST:
            self._connect_ns = None
            self._handle(self._connection.connect(now_ns), now_ns)
        if self.open:
            self._drive(velocity, now_ns)
            self._keep_alive(now_ns)

    def receive(self, data: bytes, now_ns: int) -> None:
        """Take bytes from the line."""
        self._handle(self._connection.receive(data, now_ns), now_ns)

    def advance(self, now_ns: int) -> None:
        """Let timers of the protocol run out."""
        self._handle(self._connection.advance(now_ns), now_ns)

    def next_deadline_ns(self) -> int | None:
        """When `advance` has something to do; `follow` has its own times."""
        return self._connection.next_deadline_ns()

    def _drive(self, velocity: Velocity, now_ns: int) -> None:
        limit = self._settings.change
        old = self._velocity
        if abs(velocity.speed_m_s - old.speed_m_s) > limit or abs(velocity.turn_rad_s - old.turn_rad_s) > limit:
            self._velocity = velocity
            self._send_velocity(now_ns)
        elif self._seconds(now_ns - self._velocity_ns) > self._settings.repeat_s and max(map(abs, old)) > limit:
            self._send_velocity(now_ns)

    def _send_velocity(self, now_ns: int) -> None:
        self._velocity_ns = now_ns
        speed_mm_s, turn_deg_s = wire_speeds(self._velocity, self._settings)
        self._send(CommandNumber.VEL, speed_mm_s, now_ns)
        self._send(CommandNumber.RVEL, turn_deg_s, now_ns)
        self._tell(SpeedSent(speed_mm_s=speed_mm_s, turn_deg_s=turn_deg_s))

    def _keep_alive(self, now_ns: int) -> None:
        if now_ns - self._enable_ns > self._settings.enable_ms * _MS:
            self._enable(now_ns)
        if self._seconds(now_ns - self._pulse_ns) > self._settings.pulse_s:
            self._pulse_ns = now_ns
            self._send(CommandNumber.PULSE, None, now_ns)

    def _enable(self, now_ns: int) -> None:
        self._enable_ns = now_ns
        self._send(CommandNumber.ENABLE, 1, now_ns)

    def _seconds(self, span_ns: int) -> float:
        return span_ns // _S if self._settings.whole_seconds else span_ns / _S

    def _leave(self, now_ns: int) -> None:
        state = self._connection.state
        if state is ClientState.OPEN:
            self._send(CommandNumber.STOP, None, now_ns)
        if state not in _AT_REST and state is not ClientState.CLOSING:
            self._handle(self._connection.disconnect(now_ns), now_ns)

    def _send(self, number: CommandNumber, value: int | None, now_ns: int) -> None:
        if self.open:
            self._put(self._connection.send(Command(number, value), now_ns))

    def _handle(self, events: list[Event], now_ns: int) -> None:
        for event in events:
            match event:
                case Transmit():
                    self._put(event.data)
                case PacketReceived(packet=Sip() as sip):
                    self._on_sip(sip, now_ns)
                case Connected():
                    self._begin(event, now_ns)
                case FrameDropped():
                    self._tell(BytesDropped(count=len(event.data), reason=event.reason.name.lower()))
                case ConnectFailed() | ConnectionLost():
                    self._end(event, now_ns)
                case Disconnected():
                    self._tell(RobotLeft())
                case _:
                    pass

    def _begin(self, event: Connected, now_ns: int) -> None:
        who = event.identification
        self._tell(RobotConnected(name=who.name, robot_class=who.robot_class, subclass=who.subclass))
        self._on_session(event.parameters, now_ns)
        self._pulse_ns = now_ns
        self._send(CommandNumber.PULSE, None, now_ns)
        self._send(CommandNumber.SETO, None, now_ns)
        self._enable(now_ns)

    def _end(self, event: ConnectFailed | ConnectionLost, now_ns: int) -> None:
        kind = RobotConnectFailed if isinstance(event, ConnectFailed) else RobotLost
        self._tell(kind(reason=str(event.reason)))
        pause_s = self._settings.reconnect_s
        if pause_s is not None:
            self._connect_ns = now_ns + round(pause_s * _S)
