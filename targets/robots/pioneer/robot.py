"""The robot as the line sees it: bytes and a time in, bytes out.

One queue of timers decides what happens when: the connection's watchdog, the HOSTBAUD trial, the sonar, the SIP, in
this order at equal times. SIPs leave at OPEN + n cycles exactly; a bench that comes late gets every one of them. What
the line cannot carry is not queued: a SIP that would be old before it is out is skipped, and a packet that was asked
for waits for a cycle with room.
"""

from __future__ import annotations

from collections.abc import Callable

from protocols.p2os import (
    CommandReceived,
    Connection,
    Event,
    Identification,
    Role,
    SerAuxPacket,
    ServerOptions,
    ServerPacket,
    ServerState,
    SessionClosed,
    SessionOpened,
    Transmit,
    WatchdogExpired,
    WatchdogRevived,
    WrongOrder,
)
from targets.robots.pioneer.chassis import Chassis
from targets.robots.pioneer.commands import CommandTable
from targets.robots.pioneer.controller import Controller
from targets.robots.pioneer.events import HostBaudChanged, OutputWithdrawn, RobotEvent, SipSkipped
from targets.robots.pioneer.output import HostLine, Output
from targets.robots.pioneer.reports import make_extra, make_sip
from targets.robots.pioneer.requests import Extra
from targets.robots.pioneer.settings import RobotSettings

MOST_WAITING = 100
"""Bytes that may still wait for the line when a SIP is due: about the longest usual packet, CONFIG (choice)."""
MOST_PATIENCE = 10
"""Cycles after which a packet that was asked for goes out even if there is no room for it (choice)."""
FRAMING = 5
"""Bytes of a frame around its body."""

Timer = tuple[int, int, Callable[[int], None]]
"""(when in ns, rank among equals, what to do at that time)."""


class PioneerRobot:
    """A P2OS robot controller at the far end of a serial line.

    Args:
        settings: What is in its FLASH and what is fitted.
        chassis: Its body.
        seed: Of everything random in it.
        connection: The protocol machine, when it is not to be the standard one (mutated tables).

    Attributes:
        sips_skipped: SIPs of this session that were left out because the line had not caught up.
    """

    def __init__(
        self, settings: RobotSettings, chassis: Chassis, *, seed: int, connection: Connection | None = None
    ) -> None:
        self.settings = settings
        self.connection = connection or Connection(Role.SERVER, server_options(settings))
        self._events: list[RobotEvent] = []
        self.controller = Controller(settings, chassis, seed=seed, tell=self._events.append)
        self._commands = CommandTable(self.controller)
        self._cycle_ns = settings.sip_cycle_ms * 1_000_000
        self._opened_ns: int | None = None
        self._sips = 0
        self.sips_skipped = 0
        self._queue: list[Extra | int] = []  # asked for and due; a number is that of an AUX port
        self._patience = 0
        self._output = Output()

    # --- the line --------------------------------------------------------------------------------------------------

    def receive(self, data: bytes, now_ns: int) -> bytes:
        """Take bytes from the line; return bytes to transmit."""
        self._run_timers(now_ns - 1)
        self._handle(self.connection.receive(data, now_ns), now_ns)
        return self._output.take()

    def line_down(self, now_ns: int) -> bytes:
        """End of file, hang-up: like CLOSE."""
        self._run_timers(now_ns - 1)
        self._handle(self.connection.line_down(now_ns), now_ns)
        return self._output.take()

    @property
    def line(self) -> HostLine:
        """The line it sends on; by default one on which nothing ever waits."""
        return self._output.line

    @line.setter
    def line(self, line: HostLine) -> None:
        self._output.line = line

    @property
    def host_baud(self) -> int:
        """Rate of the robot's own UART now, bit/s."""
        return self.controller.host_baud.baud

    # --- time ------------------------------------------------------------------------------------------------------

    def advance(self, now_ns: int) -> bytes:
        """Do what is due up to and at `now_ns`; return bytes to transmit."""
        self._run_timers(now_ns)
        return self._output.take()

    def next_deadline_ns(self) -> int | None:
        """When `advance` has something to do next, None when nothing is planned."""
        timers = self._timers()
        return min(timers)[0] if timers else None

    def control_step(self, now_ns: int, dt_s: float) -> None:
        """One turn of the control loop: senses the body at `now_ns`, drives it for the coming `dt_s` seconds."""
        self.controller.control_step(now_ns, dt_s)

    def take_events(self) -> list[RobotEvent]:
        """Take what happened since the last call, in order."""
        taken = list(self._events)
        self._events.clear()
        return taken

    # --- inside ----------------------------------------------------------------------------------------------------

    def _timers(self) -> list[Timer]:
        sip_ns = None if self._opened_ns is None else self._opened_ns + (self._sips + 1) * self._cycle_ns
        candidates: list[tuple[int | None, Callable[[int], None]]] = [
            (self.connection.next_deadline_ns(), self._advance_connection),
            (self.controller.host_baud.next_deadline_ns(), self._revert_baud),
            (self.controller.sonar.next_deadline_ns(), self._fire_sonar),
            (sip_ns, self._send_cycle),
        ]
        return [(when_ns, rank, act) for rank, (when_ns, act) in enumerate(candidates) if when_ns is not None]

    def _run_timers(self, until_ns: int) -> None:
        while timers := self._timers():
            when_ns, _, act = min(timers)
            if when_ns > until_ns:
                return
            act(when_ns)

    def _advance_connection(self, now_ns: int) -> None:
        self._handle(self.connection.advance(now_ns), now_ns)

    def _revert_baud(self, _now_ns: int) -> None:
        self.controller.host_baud.revert()
        self._events.append(HostBaudChanged(baud=self.host_baud, reverted=True))

    def _fire_sonar(self, _now_ns: int) -> None:
        self.controller.sonar.advance()

    def _send_cycle(self, now_ns: int) -> None:
        """The SIP, then what was asked for; nothing where a faulty state table has lost the session meanwhile."""
        self._sips += 1
        if self.connection.state is not ServerState.OPEN:
            return
        waiting = self.line.pending
        if waiting <= MOST_WAITING:
            waiting += self._send(make_sip(self.controller, now_ns), now_ns)
        else:
            self._note_skipped(waiting)
        self._send_extras(waiting, now_ns)

    def _note_skipped(self, waiting: int) -> None:
        if not self.sips_skipped:
            self._events.append(SipSkipped(waiting=waiting))
        self.sips_skipped += 1

    def _send_extras(self, waiting: int, now_ns: int) -> None:
        """Sends what was asked for, as far as it is out before the next SIP.

        What never fits goes behind the SIP of an idle line, alone, or when it has waited long enough.
        """
        first = self.line.pending == 0 or self._patience >= MOST_PATIENCE
        for key in self._queue_up():
            packet = self._make(key, now_ns)
            if not (first or self._has_room(waiting + len(packet.encode()) + FRAMING)):
                self._patience += 1
                return
            waiting += self._send(packet, now_ns)
            self._done(key)
            first, self._patience = False, 0

    def _queue_up(self) -> tuple[Extra | int, ...]:
        due: list[Extra | int] = list(self.controller.requests.due())
        due += [number for number, port in enumerate(self.controller.aux_ports, start=1) if port.due()]
        kept = [key for key in self._queue if key in due]
        self._queue = kept + [key for key in due if key not in kept]
        return tuple(self._queue)

    def _make(self, key: Extra | int, now_ns: int) -> ServerPacket:
        if isinstance(key, Extra):
            return make_extra(self.controller, key, now_ns)
        return SerAuxPacket(port=key, data=self.controller.aux_ports[key - 1].due())

    def _done(self, key: Extra | int) -> None:
        self._queue.remove(key)
        if isinstance(key, Extra):
            self.controller.requests.sent(key)
        else:
            self.controller.aux_ports[key - 1].take_due()

    def _has_room(self, count: int) -> bool:
        """Whether `count` bytes are out before the next cycle; 10 bits a byte."""
        baud = self.line.baud
        return not baud or count * 10_000_000_000 <= baud * self._cycle_ns

    def _send(self, packet: ServerPacket, now_ns: int) -> int:
        frame = self.connection.send(packet, now_ns)
        self._output.put(frame)
        return len(frame)

    def _handle(self, events: list[Event], now_ns: int) -> None:
        for event in events:
            match event:
                case Transmit():
                    self._output.put(event.data)
                case CommandReceived():
                    self.controller.host_baud.confirm()
                    self._commands.obey(event.command, now_ns)
                case _:
                    self._events.append(event)
                    self._follow_session(event, now_ns)

    def _follow_session(self, event: Event, now_ns: int) -> None:
        match event:
            case SessionOpened():
                self._opened_ns, self._sips, self.sips_skipped, self._patience = now_ns, 0, 0, 0
                self._output.start_session()
                self.controller.start_session(now_ns)
            case SessionClosed():
                self._opened_ns = None
                self._silence()
                self.controller.end_session(now_ns)
                if self.controller.host_baud.reset():
                    self._events.append(HostBaudChanged(baud=self.host_baud, reverted=True))
            case WatchdogExpired():
                self.controller.motion.hold()
            case WatchdogRevived():
                self.controller.motion.release()
            case _:
                pass

    def _silence(self) -> None:
        if count := self._output.withdraw():
            self._events.append(OutputWithdrawn(count=count))


def server_options(settings: RobotSettings) -> ServerOptions:
    """The protocol options that follow from a robot's settings."""
    return ServerOptions(
        identification=Identification(name=settings.name, robot_class=settings.robot_class, subclass=settings.subclass),
        watchdog_s=settings.watchdog_ms / 1000 if settings.watchdog_stops else None,
        wrong_order=WrongOrder[settings.wrong_order.upper()],
        max_count=settings.max_count,
        handshake_limit_s=settings.handshake_limit_s,
        raw_tty=settings.raw_tty,
    )
