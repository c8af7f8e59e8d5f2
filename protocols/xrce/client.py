"""The client's end of a session: asks for it, and for its end, until it is answered."""

from __future__ import annotations

from protocols.xrce.codes import OBJECT_AGENT, OBJECT_CLIENT, Status
from protocols.xrce.events import AgentTime, CloseReason, Pong, SessionClosed, SessionOpened
from protocols.xrce.machine import Machine
from protocols.xrce.message import Header
from protocols.xrce.objects import Agent, Client
from protocols.xrce.options import ClientOptions
from protocols.xrce.states import CLIENT_TABLE, Action, ClientState, ClientTrigger, Table, Timer, Trigger
from protocols.xrce.submessages import (
    CreateClient,
    Delete,
    Info,
    Reset,
    StatusAgent,
    StatusReply,
    Submessage,
    TimestampReply,
    TopicData,
)

__all__ = ["ClientMachine"]

_LOGOUT_REQUEST = 2
"""As in Micro-XRCE-DDS-Client (session_info.c, UXR_REQUEST_LOGOUT); its requests for objects begin at 10."""

_REASONS = {
    ClientTrigger.REFUSED: CloseReason.REFUSED,
    ClientTrigger.GIVE_UP: CloseReason.NO_ANSWER,
    ClientTrigger.GONE: CloseReason.DELETED,
    ClientTrigger.LINE_DOWN: CloseReason.LINE_DOWN,
}
_ERRORS_FROM = 0x80


class ClientMachine(Machine):
    """See the module."""

    OPEN = ClientState.OPEN

    def __init__(self, options: ClientOptions, table: Table | None) -> None:
        super().__init__(CLIENT_TABLE if table is None else table, ClientState.CLOSED, options)
        self._options = options
        self.session_id = options.session_id
        self.client_key = options.client_key
        self._attempts = 0
        self.unnumbered(CreateClient(client=self._client()))  # raises here what could not be sent later
        self._agent = Agent()
        self._status: Status | None = None
        self._in_session = False
        self._time = AgentTime(ahead_ns=0, round_trip_ns=0)

    def heeds(self, header: Header) -> bool:
        """An agent may answer in the session that is not open yet, or not any more."""
        own = [(one.session_id, one.client_key) for one in (self.header(), self.outer_header())]
        return (header.session_id, header.client_key) in own

    def take_said(self, said: Submessage, stream_id: int) -> None:
        """Handles a submessage of the agent."""
        match said:
            case StatusAgent(status=status):
                self._agent, self._status = said.agent, status
                self.fire(ClientTrigger.REFUSED if status >= _ERRORS_FROM else ClientTrigger.ACCEPTED)
            case StatusReply(object_id=object_id) if object_id == OBJECT_CLIENT:
                self._status = None
                self.fire(ClientTrigger.GONE)
            case Info(object_id=object_id) if object_id == OBJECT_AGENT:
                self._in_session = bool(said.implementation_status)
                self.fire(ClientTrigger.PONG)
            case Reset():
                self.fire(ClientTrigger.RESET)
            case TimestampReply():
                self._take_time(said)
                self.fire(ClientTrigger.TIME_TOLD)
            case _:
                self.hand_over(said, stream_id, (StatusReply, Info, TopicData))

    def trigger_of(self, timer: Timer) -> Trigger:
        """The trigger of a timer that has run out."""
        if timer is Timer.HEARTBEAT:
            return ClientTrigger.HEARTBEAT_DUE
        return ClientTrigger.RETRY if self._attempts < self._options.attempts else ClientTrigger.GIVE_UP

    def act_in_role(self, action: Action, trigger: Trigger) -> None:
        """Carries out one action of an edge."""
        match action:
            case Action.SEND_CREATE:
                self._ask(CreateClient(client=self._client()), self.outer_header(), trigger)
            case Action.SEND_DELETE:
                self._ask(Delete(request_id=_LOGOUT_REQUEST, object_id=OBJECT_CLIENT), self.header(), trigger)
            case Action.REPORT_OPENED:
                self.events.append(SessionOpened(peer=self._agent))
            case Action.REPORT_CLOSED:
                refused = self._status if trigger is ClientTrigger.REFUSED else None
                self.events.append(SessionClosed(reason=_REASONS[trigger], status=refused))  # type: ignore[index]
            case Action.REPORT_PONG:
                self.events.append(Pong(in_session=self._in_session))
            case Action.REPORT_TIME:
                self.events.append(self._time)

    def _ask(self, said: Submessage, header: Header, trigger: Trigger) -> None:
        """Sends a request that is repeated until it is answered."""
        self._attempts = self._attempts + 1 if trigger is ClientTrigger.RETRY else 1
        self.reply(said, header)
        self.start(Timer.RETRY, self._options.retry_s)

    def _client(self) -> Client:
        options = self._options
        return Client(
            client_key=options.client_key,
            session_id=options.session_id,
            properties=options.properties or None,
            mtu=self.mtu,
        )

    def _take_time(self, said: TimestampReply) -> None:
        """As in Micro-XRCE-DDS-Client (session.c, process_timestamp_reply)."""
        there_ns = said.receive.ns - said.originate.ns
        back_ns = self.clock_ns - said.transmit.ns
        self._time = AgentTime(ahead_ns=(there_ns - back_ns) // 2, round_trip_ns=there_ns + back_ns)
