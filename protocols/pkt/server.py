"""The server role: the rover's end of the line."""

from __future__ import annotations

from collections.abc import Mapping
from enum import Enum

from protocols.pkt.codes import ErrorCode, Opcode, ReportId
from protocols.pkt.commands import (
    COMMANDS,
    Command,
    LedOn,
    RequestTelemetry,
    UnknownCommand,
    clamp_command,
    decode_command,
)
from protocols.pkt.errors import RemoteProtocolError
from protocols.pkt.events import CommandReceived, CommandRefused, MotorsMustStop, ReportDue
from protocols.pkt.framing import DropReason, Frame, encode_frame
from protocols.pkt.machine import Machine
from protocols.pkt.options import ExecutionReports, RangeRule, ReportRate, ServerOptions
from protocols.pkt.reports import ExecutionReport, GeneralReport, PidReport, Report, encode_report
from protocols.pkt.states import SERVER_TABLE, Action, ServerState, ServerTrigger, Table, Timer, Trigger
from protocols.state_machine import AnyDropped

__all__ = ["ServerMachine"]

_NS_PER_S = 1_000_000_000
_COUNTED: Mapping[Enum, ErrorCode] = {
    DropReason.BAD_SYNC: ErrorCode.BAD_SYNC,
    DropReason.BAD_LENGTH: ErrorCode.INVALID_LENGTH,
    DropReason.BAD_CRC: ErrorCode.BAD_CRC,
    DropReason.BAD_TERMINATOR: ErrorCode.BAD_TERMINATOR,
}
"""What the decoder's errors are called in LAST_ERROR; the others are not counted (application.cpp, `set_error`)."""

_LEDS = (Opcode.LED_ON, Opcode.LED_OFF)
_PARAMETERS_AT = 1
_LATE_GAINS_AT = 5


class ServerMachine(Machine):
    """Takes commands, keeps the rover's counters, answers and reports."""

    def __init__(self, options: ServerOptions, table: Table | None, epoch_ns: int) -> None:
        super().__init__(SERVER_TABLE if table is None else table, ServerState.WAITING)
        self._options = options
        self._epoch_ns = epoch_ns
        self._accepted = self._rejected = self._last_opcode = 0
        self._last_error = ErrorCode.SUCCESS
        self._status = 0
        self._payload = b""
        self._command: Command = LedOn()
        self._result = ErrorCode.SUCCESS
        self._due_ticks = [0 if options.report_at_once else rate.ticks for rate in options.rates]
        self._report = ReportId.GENERAL
        self._byte_1 = 0  # of the report sent last
        self.start(Timer.WATCHDOG, options.silence_s, since_ns=epoch_ns)

    @property
    def telemetry(self) -> GeneralReport:
        """The general report as it would be sent now."""
        return GeneralReport(
            accepted=self._accepted,
            rejected=self._rejected,
            last_opcode=self._last_opcode,
            last_error=int(self._last_error),
            status=self._status if self._options.general_status else None,
        )

    def set_status(self, status: int) -> None:
        """Sets the STATUS byte of the general report."""
        self._status = status

    def take_frame(self, frame: Frame) -> None:
        """Reads the command in the frame and fires what it means."""
        self._payload = frame.payload
        try:
            command = self._decode(frame)
        except RemoteProtocolError:
            self._result = ErrorCode.INVALID_LENGTH
            self.fire(ServerTrigger.SHORT)
            return
        if isinstance(command, RequestTelemetry):
            self.fire(ServerTrigger.REQUEST)
            return
        unknown = isinstance(command, UnknownCommand)
        self._command = clamp_command(command) if self._options.range_rule is RangeRule.CLAMP else command
        self._result = ErrorCode.UNKNOWN_OPCODE if unknown else ErrorCode.SUCCESS
        self.fire(ServerTrigger.UNKNOWN if unknown else ServerTrigger.COMMAND)

    def drop(self, dropped: AnyDropped) -> None:
        """Reports and counts bytes that did not become a message, also in the rover's own counters."""
        super().drop(dropped)
        error = _COUNTED.get(dropped.reason)
        if error is not None:
            self._result = error
            self.fire(ServerTrigger.BAD_FRAME)

    def trigger_of(self, timer: Timer) -> Trigger:
        """The trigger of a timer that has run out."""
        del timer
        return ServerTrigger.SILENCE

    def act(self, action: Action, trigger: Trigger) -> None:
        """Carries out one action of an edge."""
        del trigger
        match action:
            case Action.FEED_WATCHDOG:
                self.start(Timer.WATCHDOG, self._options.silence_s)
            case Action.SEND_GENERAL:
                self.transmit(self.encode(self.telemetry))
            case Action.ASK_REPORT:
                self.events.append(ReportDue(report=self._report))
            case Action.STOP:
                self.counters.silences += 1
                self.events.append(MotorsMustStop())
            case _:
                self._act_on_packet(action)

    def encode(self, report: Report) -> bytes:
        """The whole frame of a report, with the quirks that the options ask for."""
        options = self._options
        if options.pid_reports_kp and isinstance(report, PidReport):
            report = PidReport(
                validity=report.validity,
                maximum=report.maximum,
                minimum=report.minimum,
                kp=report.kp,
                kd=report.kp,
                ki=report.kp,
            )
        payload = encode_report(report, options.schema)
        if options.gps_stale_byte and payload[0] == ReportId.GPS:
            payload = payload[:1] + bytes((self._byte_1,)) + payload[2:]
        frame = encode_frame(payload, options.frames)
        self._byte_1 = payload[1] if len(payload) > 1 else self._byte_1
        return frame

    def next_deadline_ns(self) -> int | None:
        """When the next timer runs out or the next report is due, in ns of bench time."""
        due = [self._due_ns(index) for index in range(len(self._due_ticks))]
        timer_ns = super().next_deadline_ns()
        return min([*due, timer_ns] if timer_ns is not None else due, default=None)

    def expire_next(self) -> None:
        """Lets the next timer run out, or asks for the next report; reports first, as in the loop of G0."""
        deadline_ns = self.next_deadline_ns()
        for index, rate in enumerate(self._options.rates):
            if self._due_ns(index) == deadline_ns:
                self._due_ticks[index] += rate.ticks
                self._ask(rate)
                return
        super().expire_next()

    def _ask(self, rate: ReportRate) -> None:
        self._report = rate.report
        general = rate.report is ReportId.GENERAL
        self.fire(ServerTrigger.GENERAL_DUE if general else ServerTrigger.REPORT_DUE)

    def _due_ns(self, index: int) -> int:
        return self._epoch_ns + self._due_ticks[index] * _NS_PER_S // self._options.tick_hz

    def _decode(self, frame: Frame) -> Command:
        """The command in the frame, read as carefully or as carelessly as the options say."""
        options, payload = self._options, frame.payload
        if payload[0] not in COMMANDS[options.schema]:
            return UnknownCommand(opcode=payload[0], parameters=payload[1:])
        if options.strict_length or payload[0] == Opcode.REQUEST_TMY:
            command = decode_command(payload, options.schema)
        late = options.pid_reads_late and payload[0] == Opcode.RESET_PID_CONTROLLER
        if late or not options.strict_length:
            at = _LATE_GAINS_AT if late else _PARAMETERS_AT
            command = decode_command(payload + frame.behind, options.schema, at=at)
        return command

    def _act_on_packet(self, action: Action) -> None:
        match action:
            case Action.ACCEPT:
                self._accepted = self._accepted + 1 & 0xFF
            case Action.DELIVER_COMMAND:
                self.events.append(CommandReceived(command=self._command))
            case Action.DELIVER_REFUSAL:
                self.counters.refused += 1
                self.events.append(CommandRefused(payload=self._payload, error=self._result))
            case Action.NOTE_RESULT:
                self._last_error = self._result
                self._last_opcode = self._payload[0]
            case Action.SEND_EXECUTION:
                self._send_execution()
            case Action.REJECT:
                self._rejected = self._rejected + 1 & 0xFF
                self._last_error = self._result

    def _send_execution(self) -> None:
        rule = self._options.execution_reports
        led = self._payload[0] in _LEDS
        if rule is ExecutionReports.EVERY or (rule is ExecutionReports.LEDS and led):
            self.transmit(self.encode(ExecutionReport(opcode=self._payload[0], error=int(self._result))))
