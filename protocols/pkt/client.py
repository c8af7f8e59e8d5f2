"""The client role: the host's end of the line, a ground station."""

from __future__ import annotations

from protocols.pkt.commands import Command, MotorSpeeds, MotorThrottles, RequestTelemetry, encode_command
from protocols.pkt.errors import RemoteProtocolError
from protocols.pkt.events import LossReason, ReportReceived, RoverFound, RoverLost
from protocols.pkt.framing import Dropped, DropReason, Frame, encode_frame
from protocols.pkt.machine import Machine
from protocols.pkt.options import ClientOptions, Schema
from protocols.pkt.reports import GeneralReport, Report, decode_report
from protocols.pkt.states import CLIENT_TABLE, Action, ClientState, ClientTrigger, Table, Timer, Trigger
from protocols.pkt.units import PacketTotals

__all__ = ["ClientMachine"]


class ClientMachine(Machine):
    """Hands on reports, keeps the rover's watchdog fed, notices when the rover falls silent."""

    def __init__(self, options: ClientOptions, table: Table | None) -> None:
        super().__init__(CLIENT_TABLE if table is None else table, ClientState.IDLE)
        self._options = options
        self._report: Report = GeneralReport()
        self.totals: PacketTotals | None = None

    def take_frame(self, frame: Frame) -> None:
        """Reads the report in the frame and fires that there is one."""
        try:
            self._report = decode_report(frame.payload, self._options.schema)
        except RemoteProtocolError:
            self.drop(Dropped(reason=DropReason.BAD_BODY, data=frame.raw))
            return
        self.fire(ClientTrigger.REPORT)

    def trigger_of(self, timer: Timer) -> Trigger:
        """The trigger of a timer that has run out."""
        return ClientTrigger.KEEPALIVE if timer is Timer.KEEPALIVE else ClientTrigger.SILENCE

    def act(self, action: Action, trigger: Trigger) -> None:
        """Carries out one action of an edge."""
        match action:
            case Action.SEND_REQUEST:
                self._send_request(trigger)
            case Action.FEED_SILENCE:
                self.start(Timer.REPORTS, self._options.silence_s)
            case Action.DELIVER_REPORT:
                self._deliver()
            case Action.REPORT_FOUND:
                self.events.append(RoverFound())
            case Action.REPORT_LOST:
                self.counters.silences += trigger is ClientTrigger.SILENCE
                down = trigger is ClientTrigger.LINE_DOWN
                self.events.append(RoverLost(reason=LossReason.LINE_DOWN if down else LossReason.SILENCE))
            case Action.SEND_STOP:
                if self._options.stop_at_the_end:
                    self.transmit(self.encode(self._stop()))

    def encode(self, command: Command) -> bytes:
        """The whole frame of a command."""
        return encode_frame(encode_command(command, self._options.schema), self._options.frames)

    def sent(self) -> None:
        """Something went out: the next request can wait."""
        self.start(Timer.KEEPALIVE, self._options.request_s)

    def _send_request(self, trigger: Trigger) -> None:
        if trigger is ClientTrigger.CONNECT:
            self.totals = None
        self.counters.requests += 1
        self.transmit(self.encode(RequestTelemetry()))
        self.sent()

    def _deliver(self) -> None:
        if isinstance(self._report, GeneralReport):
            self.totals = PacketTotals.of(self._report, self.totals)
        self.events.append(ReportReceived(report=self._report))

    def _stop(self) -> Command:
        if self._options.schema is Schema.V2:
            return MotorThrottles(a=0.0, b=0.0)
        return MotorSpeeds(a=0, b=0)
