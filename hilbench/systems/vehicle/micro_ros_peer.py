"""The driving stack's end of a board's line in the hands of a check, where the line is that of a micro-ROS agent."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from hilbench.bench import Bench
from hilbench.bench.line_peer import Sound, Unsound
from hilbench.clock import Entry, EventClass
from hilbench.links import Port
from hilbench.systems.vehicle.driving_stack import DrivingStack
from hilbench.systems.vehicle.micro_ros import MicroRosEnd
from hilbench.systems.vehicle.micro_ros_settings import MicroRosSettings
from hilbench.systems.vehicle.stack_peer import StackMessage, StackPeer
from protocols import xrce
from protocols.autoware import AgentOnline, AgentPing, Clock, Event, Message, MessageReceived, Transmit, UnknownMessage
from protocols.common.decoding import Decoder, NoOptions
from protocols.xrce.decoding import decoder

__all__ = ["MicroRosPeer", "driving_stack", "stack_peer"]


def stack_peer(bench: Bench, port: Port, settings: MicroRosSettings | None) -> StackPeer:
    """Return the checker's end of a board's line: a micro-ROS agent, or without settings that of the stand-in link."""
    return StackPeer(bench, port) if settings is None else MicroRosPeer(bench, port, settings)


def driving_stack(bench: Bench, port: Port, settings: MicroRosSettings | None) -> DrivingStack:
    """Return a driving stack beside a micro-ROS agent, or without settings one that speaks the stand-in link."""
    return DrivingStack(bench, port, connection=None if settings is None else MicroRosEnd(settings))


class MicroRosPeer(StackPeer):
    """See the module, and `StackPeer`; where that says that it is there, this one tells the time that it told last.

    Args:
        bench: whose time passes while the peer waits.
        port: the line.
        settings: of the agent.

    Attributes:
        end: the agent, which runs while it is `online`.
    """

    def __init__(self, bench: Bench, port: Port, settings: MicroRosSettings) -> None:
        self.end = MicroRosEnd(settings)
        self.end.connect(bench.now_ns)
        self._due: Entry | None = None
        self._clock = Clock()
        super().__init__(bench, port)

    @property
    def online(self) -> bool:
        """Whether the agent runs; one that is started anew knows nothing."""
        return self.end.is_open

    @online.setter
    def online(self, online: bool) -> None:
        if online is not self.end.is_open:
            (self.end.connect if online else self.end.disconnect)(self.bench.now_ns)
            self._wait()

    # --- sending

    def send(self, message: StackMessage) -> None:
        """Publish a message, as far as the board reads it."""
        if isinstance(message, AgentOnline):
            message = self._clock
        elif isinstance(message, Clock):
            self._clock = message
        data = self.end.send(message, self.bench.now_ns)
        if data:
            self.write(data)
        self._wait()

    def wire(self, message: StackMessage) -> bytes:
        """Return the frame by which a message reaches the board now; it has to be written next."""
        return self.end.send(self._clock if isinstance(message, AgentOnline) else message, self.bench.now_ns)

    def frame_of(self, message: Message) -> bytes:
        """Return a frame with a message that counts nowhere, to be damaged."""
        return self.end.frame_of(message)

    def go_online(self) -> None:
        """Start the agent, if none runs; tell the time, by which the board knows that somebody is there."""
        self.online = True
        self.send(self._clock)

    # --- reading

    def _decoder(self, sent: bool) -> Decoder:
        del sent
        return decoder(NoOptions(), "")

    def _begin_reading(self) -> None:
        self._frames = xrce.FrameReader()

    def _read(self, data: bytes, at_ns: int) -> Iterator[Sound[StackMessage] | Unsound]:
        for item in self._frames.receive(data):
            if isinstance(item, xrce.Dropped):
                yield Unsound(reason=item.reason.name, data=item.data)
                continue
            found = self._take_events(self.end.receive(item.raw, at_ns))
            said = _said(item.payload)
            if any(isinstance(one, xrce.Create) for one in said):
                self.made_ns = at_ns
            if any(isinstance(one, xrce.GetInfo) for one in said) and _is_outside(item.payload):
                found.append(AgentPing())
            for message in found or [None]:
                yield Sound(raw=item.raw, packet=message)

    def _advance(self) -> None:
        self._due = None
        self._take_events(self.end.advance(self.bench.now_ns))

    def _take_events(self, events: list[Event]) -> list[Message | UnknownMessage | None]:
        """Write what is for the board; return what came from it."""
        for event in events:
            if isinstance(event, Transmit):
                self.write(event.data)
        self._wait()
        return [event.message for event in events if isinstance(event, MessageReceived)]

    def _wait(self) -> None:
        scheduler, due_ns = self.bench.scheduler, self.end.next_deadline_ns()
        if self._due is not None:
            scheduler.cancel(self._due)
            self._due = None
        if due_ns is not None:
            when_ns = max(due_ns, self.bench.now_ns)
            self._due = scheduler.at(when_ns, self._advance, order=EventClass.TIMER, source="~agent")


def _said(payload: bytes) -> Sequence[object]:
    """Return the submessages of a message; none if it makes no sense."""
    try:
        _, body = xrce.decode_header(payload)
        return [xrce.decode_submessage(raw) for raw in xrce.split_submessages(body)]
    except xrce.RemoteProtocolError:
        return ()


def _is_outside(payload: bytes) -> bool:
    """Say whether a message that makes sense belongs to no session: with GET_INFO it asks whether an agent is there."""
    return xrce.decode_header(payload)[0].session_id in (xrce.NO_SESSION, xrce.NO_SESSION_WITH_KEY)
