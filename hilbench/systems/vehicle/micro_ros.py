"""The driving stack's end of a line where the board speaks DDS-XRCE: a micro-ROS agent, and the stack's node beside it.

It is used as `protocols.autoware.Connection` in the agent's role is, and says the same of the board: what the board
publishes comes as messages, what is sent reaches the board as samples, as far as it reads them.

    end = MicroRosEnd()
    events = end.connect(now_ns)                    # the agent is started
    events = end.receive(data, now_ns)
    data = end.send(message, now_ns)
    events = end.disconnect(now_ns)                 # the agent is killed: it forgets all, and is silent
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from functools import partial
from typing import Any

from hilbench.clock import NS_PER_S
from hilbench.systems.vehicle.micro_ros_settings import MicroRosSettings
from hilbench.systems.vehicle.ros_messages import decode_sample, encode_sample, topic_of
from protocols import xrce
from protocols.autoware import (
    MESSAGES,
    AgentState,
    BoardFound,
    BoardLost,
    ControlModeRequest,
    ControlModeResponse,
    Event,
    LocalProtocolError,
    LossReason,
    Message,
    MessageReceived,
    Sender,
    Transmit,
    UnknownMessage,
)
from protocols.state_machine import earliest
from protocols.xrce.cdr import Library

__all__ = ["MicroRosEnd"]

_LINE = "board"
_GUID = b"hilbench.stack\0\0"
"""Whose requests for a mode these are."""
_RELIABLE = xrce.Qos(reliable=True)
_LOST = {xrce.CloseReason.LINE_DOWN: LossReason.LINE_DOWN}
_NUMBERS = 256


class MicroRosEnd:
    """See the module.

    Args:
        settings: of the agent.

    Attributes:
        tables: what the agent has to show.
    """

    def __init__(self, settings: MicroRosSettings | None = None) -> None:
        self._settings = settings or MicroRosSettings()
        self._open = False
        self._heard: list[Event] = []
        self._slow_ns = round(self._settings.slow_s * NS_PER_S)
        self.tables = xrce.AgentTables(lambda: self._service, Library())
        self._start()

    def _start(self) -> None:
        """A new agent, which knows nothing, with a node beside it."""
        options = xrce.AgentOptions(silence_s=self._settings.silence_s)
        self._service = service = xrce.AgentService((_LINE,), options)
        self._session_id = xrce.NO_SESSION
        self._waiting: deque[tuple[int, bytes]] = deque()  # what is said, and when it comes
        self._writers: dict[type[Message], xrce.Writer] = {}
        for kind, spec in MESSAGES.items():
            if not spec.topic:
                continue
            topic, domain_id = topic_of(kind), self._settings.domain_id
            if spec.sender is Sender.AGENT:
                self._writers[kind] = service.writer(topic.name, topic.type_name, domain_id=domain_id, qos=_RELIABLE)
            else:
                service.listen(topic.name, topic.type_name, partial(self._hear, kind), domain_id=domain_id)

    # --- what it knows

    @property
    def is_open(self) -> bool:
        """Whether the agent runs."""
        return self._open

    @property
    def state(self) -> AgentState:
        """Whether the agent runs, and has a session with the board."""
        if not self._open:
            return AgentState.CLOSED
        return AgentState.HEARD if self.session.state is xrce.AgentState.OPEN else AgentState.ALONE

    @property
    def session(self) -> xrce.Session:
        """The agent's end of the session."""
        return self._service.sessions[_LINE]

    @property
    def service(self) -> xrce.AgentService:
        """The agent."""
        return self._service

    # --- as a connection

    def connect(self, now_ns: int) -> list[Event]:
        """Start the agent.

        Raises:
            LocalProtocolError: it runs.
        """
        del now_ns
        if self._open:
            raise LocalProtocolError("the agent runs")
        self._open = True
        return []

    def disconnect(self, now_ns: int) -> list[Event]:
        """Kill the agent; the next one knows nothing of the board.

        Raises:
            LocalProtocolError: none runs.
        """
        del now_ns
        if not self._open:
            raise LocalProtocolError("no agent runs")
        self._open = False
        self._start()
        return []

    def receive(self, data: bytes, now_ns: int) -> list[Event]:
        """Take bytes of the board."""
        return self._events(self._service.receive(_LINE, data, now_ns), now_ns) if self._open else []

    def advance(self, now_ns: int) -> list[Event]:
        """Do what is due."""
        return self._events(self._service.advance(now_ns), now_ns) if self._open else []

    def next_deadline_ns(self) -> int | None:
        """Return when `advance` must be called, in ns, or None."""
        if not self._open:
            return None
        return earliest(self._service.next_deadline_ns(), self._waiting[0][0] if self._waiting else None)

    def line_down(self, now_ns: int) -> list[Event]:
        """Take note that the line was hung up."""
        events = self._events(self._service.line_down(_LINE, now_ns), now_ns) if self._open else []
        self._open = False
        self._waiting.clear()
        return events

    def send(self, message: Message | UnknownMessage, now_ns: int) -> bytes:
        """Publish a message, or ask for a mode; return the bytes that go to the board at once.

        Raises:
            LocalProtocolError: the message is none of the driving stack's.
        """
        writer = self._writers.get(type(message))  # type: ignore[arg-type]
        if writer is None or isinstance(message, UnknownMessage):
            raise LocalProtocolError(f"{type(message).__name__} is not for the driving stack to publish")
        if not self._open:
            return b""
        identity = xrce.SampleIdentity(_GUID, message.sequence) if isinstance(message, ControlModeRequest) else None
        return self._say(self._service.write(writer, encode_sample(message), now_ns, identity=identity), now_ns)

    def frame_of(self, message: Message) -> bytes:
        """Return the frame of a sample for the board as it would come on no stream: it counts nowhere.

        Raises:
            LocalProtocolError: the board does not read it.
        """
        topic = topic_of(type(message))
        for entity in self._service.objects[_LINE].values():
            if entity.reader is None or entity.reader.topic != topic:
                continue
            identity = bytes(24) if isinstance(message, ControlModeRequest) else b""
            said = xrce.TopicData(
                request_id=entity.reading.request_id if entity.reading else 0,
                object_id=entity.object_id,
                data=identity + encode_sample(message),
            )
            header = xrce.Header(session_id=self._session_id)
            return xrce.encode_frame(xrce.encode_message(header, xrce.encode_submessage(said)))
        raise LocalProtocolError(f"nobody at the line reads {topic.name}")

    def _hear(self, kind: type[Message], sample: xrce.StoredSample) -> None:
        try:
            message: Any = decode_sample(kind, sample.data, little_endian=sample.little_endian)
        except xrce.RemoteProtocolError:
            return
        if kind is ControlModeResponse:
            number = sample.answers.number if sample.answers else 0
            message = ControlModeResponse(sequence=number % _NUMBERS, success=message.success)
        self._heard.append(MessageReceived(message=message))

    def _say(self, written: Iterable[tuple[str, bytes]], now_ns: int) -> bytes:
        """Return what goes to the board now, of this and of what was said before."""
        data = b"".join(data for _, data in written) * self._settings.agents
        if data:
            self._waiting.append((now_ns + self._slow_ns, data))
        due = b""
        while self._waiting and self._waiting[0][0] <= now_ns:
            due += self._waiting.popleft()[1]
        return due

    def _events(self, written: Iterable[tuple[str, bytes]], now_ns: int) -> list[Event]:
        """What has happened: bytes for the board, messages, the board found or lost."""
        data = self._say(written, now_ns)
        events: list[Event] = [Transmit(data=data)] if data else []
        for one in self._service.take_events():
            match one:
                case xrce.ClientEvent(event=xrce.SessionOpened(peer=xrce.Client(session_id=session_id))):
                    self._session_id = session_id
                    events.append(BoardFound())
                case xrce.ClientEvent(event=xrce.SessionClosed(reason=reason)):
                    events.append(BoardLost(reason=_LOST.get(reason, LossReason.SILENCE)))
        heard, self._heard = self._heard, []
        return events + heard
