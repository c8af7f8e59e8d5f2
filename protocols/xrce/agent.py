"""The agent's end of a session: takes whoever asks, one client at a time, and answers pings and TIMESTAMP."""

from __future__ import annotations

from dataclasses import replace

from protocols.xrce.codes import (
    COOKIE,
    NO_SESSION,
    NO_SESSION_WITH_KEY,
    OBJECT_AGENT,
    OBJECT_CLIENT,
    VERSION,
    Status,
    has_client_key,
)
from protocols.xrce.events import CloseReason, SessionClosed, SessionOpened
from protocols.xrce.framing import Frame, encode_frame
from protocols.xrce.machine import Machine
from protocols.xrce.message import Header, encode_message
from protocols.xrce.objects import Agent, Client
from protocols.xrce.options import LEAST_MTU, AgentOptions
from protocols.xrce.states import AGENT_TABLE, Action, AgentState, AgentTrigger, Table, Timer, Trigger
from protocols.xrce.submessages import (
    AgentActivity,
    Create,
    CreateClient,
    Delete,
    GetInfo,
    Info,
    ReadData,
    Reset,
    StatusAgent,
    StatusReply,
    Submessage,
    Time,
    Timestamp,
    TimestampReply,
    WriteData,
    encode_submessage,
)

__all__ = ["AgentMachine"]

_REASONS = {
    AgentTrigger.DELETE: CloseReason.DELETED,
    AgentTrigger.SILENCE: CloseReason.SILENCE,
    AgentTrigger.DISCONNECT: CloseReason.FORGOTTEN,
    AgentTrigger.LINE_DOWN: CloseReason.LINE_DOWN,
}


class AgentMachine(Machine):
    """See the module."""

    OPEN = AgentState.OPEN

    def __init__(self, options: AgentOptions, table: Table | None) -> None:
        super().__init__(AGENT_TABLE if table is None else table, AgentState.LISTENING, options)
        self._options = options
        self._asked = Header(session_id=NO_SESSION)  # of the message that is handled
        self._source = options.frames.remote_address  # as above; no CRC covers it, so a session keeps its own
        self._client = Client(client_key=b"", session_id=NO_SESSION)
        self._again = False
        self._status = Status.OK
        self._request_id = 0
        self._known_key: bytes | None = None
        self._originate = Time()

    def take_frame(self, frame: Frame) -> None:
        """Handles a sound frame."""
        self._source = frame.source
        super().take_frame(frame)

    def take_message(self, header: Header, body: bytes) -> None:
        """Handles a message."""
        self._asked = Header(session_id=header.session_id, client_key=header.client_key)
        if self.belongs(header):
            self.fire(AgentTrigger.MESSAGE)
        elif header.session_id not in (NO_SESSION, NO_SESSION_WITH_KEY):
            self.counters.foreign += 1
        super().take_message(header, body)

    def heeds(self, header: Header) -> bool:  # noqa: ARG002 - whoever it is
        """Anybody may ask for a session, ping, or say farewell."""
        return True

    def take_said(self, said: Submessage, stream_id: int) -> None:
        """Handles a submessage of the client."""
        match said:
            case CreateClient():
                self._client = said.client
                self._status = _verdict(said.client)
                self.fire(AgentTrigger.BAD_CREATE if self._status else AgentTrigger.CREATE)
            case Delete(object_id=object_id) if object_id == OBJECT_CLIENT:
                self._request_id = said.request_id
                self.fire(AgentTrigger.DELETE if self.inside else AgentTrigger.STRAY_DELETE)
            case GetInfo(object_id=object_id) if object_id == OBJECT_AGENT:
                self._request_id = said.request_id
                self.fire(AgentTrigger.PING)
            case Reset() if self.inside:
                self.fire(AgentTrigger.RESET)
            case Timestamp() if self.inside:
                self._originate = said.transmit
                self.fire(AgentTrigger.TIME_ASKED)
            case _:
                self.hand_over(said, stream_id, (Create, GetInfo, Delete, WriteData, ReadData))

    def trigger_of(self, timer: Timer) -> Trigger:
        """The trigger of a timer that has run out."""
        return AgentTrigger.SILENCE if timer is Timer.SILENCE else AgentTrigger.HEARTBEAT_DUE

    def act_in_role(self, action: Action, trigger: Trigger) -> None:
        """Carries out one action of an edge."""
        match action:
            case Action.ADOPT:
                self._adopt(self._client)
            case Action.ACCEPT | Action.REFUSE:
                self._answer(StatusAgent(status=self._status, agent=Agent()), _header_for(self._client))
            case Action.CONFIRM:  # also where there is no session, as Processor.cpp does: one that is gone is deleted
                said = StatusReply(request_id=self._request_id, object_id=OBJECT_CLIENT, status=Status.OK)
                self._answer(said, self._asked)
            case Action.FEED_SILENCE:
                self.start(Timer.SILENCE, self._options.silence_s)
            case Action.ANSWER_PING:
                self._answer(self._pong(), self._asked)
            case Action.ANSWER_TIME:
                now = Time.of_ns(self.clock_ns)
                self.reply(TimestampReply(transmit=now, receive=now, originate=self._originate))
            case Action.REPORT_OPENED:
                self.events.append(SessionOpened(peer=self._client, again=self._again))
            case Action.REPORT_CLOSED:
                self._known_key = None
                self.events.append(SessionClosed(reason=_REASONS[trigger]))  # type: ignore[index]

    def _adopt(self, client: Client) -> None:
        """Takes a client, in the place of another one or of itself."""
        self._again = client.client_key == self._known_key
        if self._known_key is not None and not self._again:
            self.events.append(SessionClosed(reason=CloseReason.REPLACED))
        self._known_key = self.client_key = client.client_key
        self.session_id = client.session_id
        self._frames = replace(self._frames, remote_address=self._source)
        mtu = self._options.mtu if client.mtu is None else client.mtu
        self.mtu = min(mtu, self._options.frames.max_payload)

    def _answer(self, said: Submessage, header: Header) -> None:
        """Answers whoever has asked just now, in a session or not."""
        frames = replace(self._frames, remote_address=self._source)
        self.transmit(encode_frame(encode_message(header, encode_submessage(said)), frames))

    def _pong(self) -> Info:
        """As of Micro-XRCE-DDS-Agent (Processor.cpp, process_get_info_submessage)."""
        return Info(
            request_id=self._request_id,
            object_id=OBJECT_AGENT,
            implementation_status=int(self.state is AgentState.OPEN),
            activity=AgentActivity(availability=1),
        )


def _verdict(client: Client) -> Status:
    """Whether a client can be taken, as Micro-XRCE-DDS-Agent decides it (Root.cpp, create_client); the mtu is ours."""
    if client.cookie != COOKIE or not any(client.client_key):
        return Status.INVALID_DATA
    if client.session_id in (NO_SESSION, NO_SESSION_WITH_KEY) or (client.mtu or LEAST_MTU) < LEAST_MTU:
        return Status.INVALID_DATA
    return Status.INCOMPATIBLE if client.version[0] > VERSION[0] else Status.OK


def _header_for(client: Client) -> Header:
    """The header of an answer to CREATE_CLIENT: that of the session that is asked for."""
    key = client.client_key if has_client_key(client.session_id) else None
    return Header(session_id=client.session_id, client_key=key)
