"""The client role: the computer's end of the line."""

from __future__ import annotations

from dataclasses import dataclass

from protocols.p2os.commands import Command, CommandNumber, encode_command
from protocols.p2os.errors import RemoteProtocolError
from protocols.p2os.events import (
    BaudWanted,
    Connected,
    ConnectFailed,
    ConnectionLost,
    Disconnected,
    FailReason,
    LossReason,
    PacketReceived,
    UnknownRobot,
)
from protocols.p2os.framing import Frame
from protocols.p2os.machine import Machine
from protocols.p2os.options import ClientOptions, UnknownSubclass
from protocols.p2os.packets import (
    ConfigPacket,
    ControllerReset,
    Identification,
    ServerPacket,
    Sip,
    SyncEcho,
    SyncError,
    UnknownPacket,
    decode_packet,
)
from protocols.p2os.robots import RobotParameters, find_robot
from protocols.p2os.states import (
    IN_SESSION,
    Action,
    ClientState,
    ClientTrigger,
    Table,
    Timer,
    Trigger,
    client_table,
)

__all__ = ["ClientMachine"]

_ECHOES = (ClientTrigger.ECHO0, ClientTrigger.ECHO1)
_SYNCS = {Action.SEND_SYNC0: 0, Action.SEND_SYNC1: 1, Action.SEND_SYNC2: 2}
_LOSSES: dict[Trigger, LossReason] = {
    ClientTrigger.RESET: LossReason.CONTROLLER_RESET,
    ClientTrigger.LINE_DOWN: LossReason.LINE_DOWN,
    ClientTrigger.ECHO0: LossReason.NOT_OPEN,
    ClientTrigger.ECHO1: LossReason.NOT_OPEN,
}
_FAILURES: dict[Trigger, FailReason] = {
    ClientTrigger.LINE_DOWN: FailReason.LINE_DOWN,
    ClientTrigger.UNKNOWN_ROBOT: FailReason.UNKNOWN_ROBOT,
    ClientTrigger.SIP_LOST: FailReason.NO_SIP,
}


@dataclass(slots=True)
class _Attempt:
    """How the present attempt to connect goes; it decides between the triggers of a timer.

    Attributes:
        answered: a sound frame has come.
        misses: SYNCs without an answer in all.
        step_misses: as above, one after the other in this state.
        restarts: returns to SYNC0 after a wrong answer.
        closes: CLOSEs sent to an old session.
        bauds_left: rates of the scan not tried yet.
        cause: what a failure would be put down to.
    """

    answered: bool = False
    misses: int = 0
    step_misses: int = 0
    restarts: int = 0
    closes: int = 0
    bauds_left: int = 0
    cause: FailReason = FailReason.NO_ANSWER


class ClientMachine(Machine):
    """Finds the server, opens the session, keeps it alive, takes leave."""

    def __init__(self, options: ClientOptions, table: Table | None) -> None:
        default = client_table(request_config=options.request_config)
        super().__init__(table if table is not None else default, ClientState.IDLE)
        self._options = options
        self._attempt = _Attempt()
        self._baud_index = 0
        self._packet: ServerPacket | None = None
        self._identification: Identification | None = None
        self._parameters: RobotParameters = options.fallback
        self._config: ConfigPacket | None = None
        self._config_until_ns = 0
        self._sip_seen = False

    def take_frame(self, frame: Frame) -> None:
        """Reads the packet in the frame and fires what it means."""
        self._attempt.answered = True
        connected = self.state in IN_SESSION
        try:
            packet = decode_packet(frame.body, connected=connected, wide_status=self._options.wide_status)
        except RemoteProtocolError:
            self.drop_body(frame)
            if not connected and frame.body[0] == Identification.TYPE:
                self.fire(ClientTrigger.BROKEN_IDENTIFICATION)
            return
        self._packet = packet
        self.fire(self._trigger_of_packet(packet))

    def trigger_of(self, timer: Timer) -> Trigger:
        """The trigger of a timer that has run out."""
        if timer is Timer.KEEPALIVE:
            unopened = self.state is ClientState.CONFIGURING and not self._sip_seen
            return ClientTrigger.UNOPENED if unopened else ClientTrigger.KEEPALIVE  # an unopened server reads SYNC0
        if timer is Timer.SIP:
            return ClientTrigger.SIP_LOST
        if self.state in (ClientState.SYNC0_SENT, ClientState.SYNC1_SENT, ClientState.SYNC2_SENT):
            return self._trigger_of_miss()
        if self.state is ClientState.CONFIGURING:
            return self._trigger_of_configuring()
        over = self.state is ClientState.RESTARTING and self._attempt.restarts >= self._options.max_restarts
        return ClientTrigger.GAVE_UP if over else ClientTrigger.TIMEOUT

    def act(self, action: Action, trigger: Trigger) -> None:
        """Carries out one action of an edge."""
        match action:
            case Action.SEND_SYNC0 | Action.SEND_SYNC1 | Action.SEND_SYNC2:
                self._send_sync(_SYNCS[action], trigger)
            case Action.BEGIN:
                self._attempt = _Attempt(bauds_left=max(0, len(self._options.bauds) - 1))
                self._identification = self._config = None
            case Action.PAUSE:
                self._pause(trigger)
            case Action.SEND_CLOSE_OLD:
                self._attempt.closes += 1
                self._attempt.step_misses = 0
                self._attempt.cause = FailReason.OLD_SESSION
                self._send(CommandNumber.CLOSE, self._options.session_argument)
                self.start(Timer.STEP, self._options.close_silence_s)
            case Action.CHANGE_BAUD:
                self._change_baud()
            case Action.REPORT_FAILED:
                self.events.append(ConnectFailed(reason=self._failure(trigger)))
            case _:
                self._act_in_session(action, trigger)

    def sent(self) -> None:
        """Something went out: the keep-alive can wait."""
        self.start(Timer.KEEPALIVE, self._options.keepalive_s)

    def _act_in_session(self, action: Action, trigger: Trigger) -> None:
        match action:
            case Action.ACCEPT:
                self.start(Timer.STEP, self._options.open_delay_s)
            case Action.SEND_OPEN:
                self._sip_seen = False
                self.start(Timer.SIP, self._options.sip_timeout_s)
                self._send_open()
            case Action.REPEAT_OPEN:
                self._send_open()
            case Action.REQUEST_CONFIG:
                self._send(CommandNumber.CONFIG, 1)
                left_s = (self._config_until_ns - self.now_ns) / 1e9
                self.start(Timer.STEP, min(self._options.config_retry_s, left_s))
            case Action.REPORT_CONNECTED:
                self._report_connected()
            case Action.FEED_SIP_TIMER:
                self._sip_seen = True
                self.start(Timer.SIP, self._options.sip_timeout_s)
            case Action.DELIVER_PACKET:
                self._deliver()
            case Action.SEND_PULSE:
                self.counters.keepalives += 1
                self._send(CommandNumber.PULSE)
            case _:
                self._act_at_the_end(action, trigger)

    def _act_at_the_end(self, action: Action, trigger: Trigger) -> None:
        match action:
            case Action.SEND_DISABLE:
                self._send(CommandNumber.ENABLE, 0)
                self.start(Timer.STEP, self._options.close_delay_s)
            case Action.SEND_CLOSE:
                self._send(CommandNumber.CLOSE, self._options.session_argument)
            case Action.REPORT_DISCONNECTED:
                self.events.append(Disconnected())
            case Action.REPORT_LOST:
                self.events.append(ConnectionLost(reason=_LOSSES.get(trigger, LossReason.NO_SIP)))

    def _trigger_of_packet(self, packet: ServerPacket) -> ClientTrigger:
        match packet:
            case Sip():
                closing = self.state is ClientState.CLOSING_OLD
                hopeless = closing and self._attempt.closes >= self._options.max_closes
                return ClientTrigger.GAVE_UP if hopeless else ClientTrigger.SIP
            case SyncEcho(number=number):
                return _ECHOES[number]
            case UnknownPacket(packet_type=0 | 1 as number, payload=b""):
                return _ECHOES[number]  # no packet of a session is so short
            case Identification():
                return self._trigger_of_identification(packet)
            case SyncError():
                return ClientTrigger.SYNC_ERROR
            case ConfigPacket():
                return ClientTrigger.CONFIG
            case ControllerReset():
                return ClientTrigger.RESET
            case _:
                return ClientTrigger.PACKET

    def _trigger_of_identification(self, packet: Identification) -> ClientTrigger:
        known = find_robot(packet.subclass)
        fall_back = self._options.unknown_subclass is UnknownSubclass.FALL_BACK
        if self.state is ClientState.SYNC2_SENT:
            self._identification = packet
            self._parameters = known or self._options.fallback
            if known is None:
                fallback = self._options.fallback if fall_back else None
                self.events.append(UnknownRobot(identification=packet, fallback=fallback))
        return ClientTrigger.IDENTIFIED if known or fall_back else ClientTrigger.UNKNOWN_ROBOT

    def _trigger_of_miss(self) -> ClientTrigger:
        """A SYNC was not answered: what now."""
        attempt, options = self._attempt, self._options
        attempt.misses += 1
        attempt.step_misses += 1
        if not attempt.answered:
            limit = options.scan_attempts if len(options.bauds) > 1 else options.silent_attempts
            if attempt.step_misses < limit:
                return ClientTrigger.TIMEOUT
            return ClientTrigger.NEXT_BAUD if attempt.bauds_left else ClientTrigger.GAVE_UP
        if attempt.misses >= options.max_misses:
            return ClientTrigger.GAVE_UP
        first = self.state is ClientState.SYNC0_SENT
        return (
            ClientTrigger.TIMEOUT if first or attempt.step_misses < options.step_attempts else ClientTrigger.STEP_BACK
        )

    def _trigger_of_configuring(self) -> ClientTrigger:
        """No CONFIG came: what now."""
        if not self._sip_seen:
            return ClientTrigger.UNOPENED
        return ClientTrigger.GAVE_UP if self.now_ns >= self._config_until_ns else ClientTrigger.TIMEOUT

    def _send_open(self) -> None:
        self._config_until_ns = self.now_ns + round(self._options.config_wait_s * 1e9)
        self._send(CommandNumber.OPEN, self._options.session_argument)
        self.start(Timer.STEP, self._options.config_retry_s)

    def _send_sync(self, number: int, trigger: Trigger) -> None:
        if trigger is not ClientTrigger.TIMEOUT:
            self._attempt.step_misses = 0
        self._send(number)
        self.start(Timer.STEP, self._options.sync_timeout_s)

    def _pause(self, trigger: Trigger) -> None:
        self._attempt.restarts += 1
        self._attempt.step_misses = 0
        self.counters.restarts += 1
        broken = trigger is ClientTrigger.BROKEN_IDENTIFICATION
        self._attempt.cause = FailReason.BROKEN_IDENTIFICATION if broken else FailReason.WRONG_ANSWERS
        self.start(Timer.STEP, self._options.restart_pause_s)

    def _change_baud(self) -> None:
        self._attempt.bauds_left -= 1
        self._baud_index = (self._baud_index + 1) % len(self._options.bauds)
        self.events.append(BaudWanted(baud=self._options.bauds[self._baud_index]))

    def _failure(self, trigger: Trigger) -> FailReason:
        return _FAILURES.get(trigger, self._attempt.cause)

    def _report_connected(self) -> None:
        if self._identification is not None:
            self.events.append(
                Connected(identification=self._identification, parameters=self._parameters, config=self._config)
            )

    def _deliver(self) -> None:
        if isinstance(self._packet, ConfigPacket):
            self._config = self._packet
        if self._packet is not None:
            self.events.append(PacketReceived(packet=self._packet))

    def _send(self, number: int, argument: int | None = None) -> None:
        self.transmit(encode_command(Command(number, argument)))
        self.sent()
