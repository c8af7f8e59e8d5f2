"""The server role: the robot's end of the line."""

from __future__ import annotations

from protocols.p2os.commands import Command, CommandNumber, check_argument_kind, decode_command
from protocols.p2os.errors import RemoteProtocolError
from protocols.p2os.events import (
    CloseReason,
    CommandReceived,
    SessionClosed,
    SessionOpened,
    WatchdogExpired,
    WatchdogRevived,
)
from protocols.p2os.framing import Frame
from protocols.p2os.machine import Machine
from protocols.p2os.options import ServerOptions
from protocols.p2os.packets import ServerPacket, SyncEcho, SyncError, encode_packet
from protocols.p2os.states import Action, ServerState, ServerTrigger, Table, Timer, Trigger, server_table

__all__ = ["ServerMachine"]

_BARE = {0: ServerTrigger.SYNC0_PULSE, 1: ServerTrigger.SYNC1_OPEN, 2: ServerTrigger.SYNC2_CLOSE}
_WITH_ARGUMENT = {1: ServerTrigger.OPEN_1, 2: ServerTrigger.CLOSE_1}


class ServerMachine(Machine):
    """Answers SYNCs, keeps the session and its watchdog, hands on the commands."""

    def __init__(self, options: ServerOptions, table: Table | None) -> None:
        super().__init__(table if table is not None else server_table(options.wrong_order), ServerState.WAIT)
        self._options = options
        self._command = Command(CommandNumber.PULSE)
        self._watchdog_expired = False

    def take_frame(self, frame: Frame) -> None:
        """Reads the command in the frame and fires what it means."""
        body = frame.body
        try:
            self._command = decode_command(body, raw_tty=self._options.raw_tty)
            check_argument_kind(self._command)
        except RemoteProtocolError:
            self.drop_body(frame)
            self.fire(ServerTrigger.UNREADABLE)
            return
        kinds = _BARE if len(body) == 1 else _WITH_ARGUMENT
        self.fire(kinds.get(self._command.number, ServerTrigger.COMMAND))

    def trigger_of(self, timer: Timer) -> Trigger:
        """The trigger of a timer that has run out."""
        return ServerTrigger.WATCHDOG if timer is Timer.WATCHDOG else ServerTrigger.HANDSHAKE_LIMIT

    def act(self, action: Action, trigger: Trigger) -> None:
        """Carries out one action of an edge."""
        match action:
            case Action.ECHO:
                self._reply(SyncEcho(number=self._command.number))
            case Action.ECHO_0:
                self._reply(SyncEcho(number=0))
            case Action.ECHO_1:
                self._reply(SyncEcho(number=1))
            case Action.IDENTIFY:
                self._reply(self._options.identification)
            case Action.REFUSE:
                self._reply(SyncError())
            case Action.LIMIT_HANDSHAKE:
                self.start(Timer.HANDSHAKE, self._options.handshake_limit_s)
            case _:
                self._act_in_session(action, trigger)

    def _act_in_session(self, action: Action, trigger: Trigger) -> None:
        match action:
            case Action.OPEN_SESSION:
                self._watchdog_expired = False
                self.start(Timer.WATCHDOG, self._options.watchdog_s)
                self.events.append(SessionOpened())
            case Action.CLOSE_SESSION:
                gone = trigger is ServerTrigger.LINE_DOWN
                self.events.append(SessionClosed(reason=CloseReason.LINE_DOWN if gone else CloseReason.CLOSED))
            case Action.FEED_WATCHDOG:
                self._feed_watchdog()
            case Action.REPORT_WATCHDOG:
                self._watchdog_expired = True
                self.counters.watchdog_expiries += 1
                self.events.append(WatchdogExpired())
            case Action.DELIVER_COMMAND:
                self.events.append(CommandReceived(command=self._command))

    def _feed_watchdog(self) -> None:
        if self._watchdog_expired:
            self._watchdog_expired = False
            self.events.append(WatchdogRevived())
        self.start(Timer.WATCHDOG, self._options.watchdog_s)

    def _reply(self, packet: ServerPacket) -> None:
        self.transmit(encode_packet(packet))
