"""One end of a session over a serial line, without the line: bytes and times in, events out.

    session = Session(Role.CLIENT, ClientOptions(client_key=bytes.fromhex("AABBCCDD")))
    events = session.connect(now_ns)                # client: asks for a session
    events = session.receive(data, now_ns)          # bytes that came
    events = session.advance(now_ns)                # timers that are due
    data = session.send(submessage, now_ns)         # a submessage of your own, on the built-in reliable stream
    when = session.next_deadline_ns()               # when to call advance at the latest

Events come in the order in which things happened; write the data of each `Transmit` to the line. Whatever the bytes,
`receive` raises nothing: what cannot be used is reported or counted. How bytes are cut into calls does not matter. Time
is bench time in integer nanoseconds; a time earlier than the latest one counts as the latest. What is due at or before
the time of a call has happened before the call's bytes arrive.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from protocols.common.flagged_connection import FlaggedConnection
from protocols.xrce.agent import AgentMachine
from protocols.xrce.client import ClientMachine
from protocols.xrce.codes import BUILTIN_RELIABLE, OBJECT_AGENT, InfoMask, is_reliable
from protocols.xrce.errors import LocalProtocolError
from protocols.xrce.events import Event
from protocols.xrce.framing import Dropped, Frame, LineReader
from protocols.xrce.machine import Counters
from protocols.xrce.options import AgentOptions, ClientOptions
from protocols.xrce.states import Action, AgentTrigger, ClientTrigger, Role, State, Table, Timer, Trigger
from protocols.xrce.submessages import (
    Create,
    Delete,
    GetInfo,
    Info,
    ReadData,
    StatusReply,
    Submessage,
    Time,
    Timestamp,
    TopicData,
    WriteData,
)

__all__ = ["Session"]

_FIRST_REQUEST = 10
_LAST_REQUEST = 0xFFFF

_MAY_SEND = {
    Role.CLIENT: (Create, GetInfo, Delete, WriteData, ReadData),
    Role.AGENT: (StatusReply, Info, TopicData),
}


class Session(FlaggedConnection[State, Trigger, Action, Timer, Event, Counters]):
    """One end, in either role. An agent's end has one client at a time.

    Args:
        role: which end.
        options: of that role; an agent's defaults if None.
        table: another state machine than the default one, for tests that must be able to fail.

    Raises:
        LocalProtocolError: the options are those of the other role, or missing.
    """

    MISUSE = LocalProtocolError
    role: Role
    _machine: ClientMachine | AgentMachine

    def __init__(
        self, role: Role, options: ClientOptions | AgentOptions | None = None, *, table: Table | None = None
    ) -> None:
        if options is None and role is Role.AGENT:
            options = AgentOptions()
        if options is None or isinstance(options, ClientOptions) is not (role is Role.CLIENT):
            raise LocalProtocolError(f"{type(options).__name__} are not the options of the {role.value}")
        self.role = role
        self._reader: LineReader = LineReader(options.frames)
        self._request_id = _FIRST_REQUEST - 1
        if isinstance(options, ClientOptions):
            self._machine = ClientMachine(options, table)
        else:
            self._machine = AgentMachine(options, table)

    @property
    def held(self) -> int:
        """Bytes that are kept: an unfinished frame, and what the streams wait with; bounded."""
        return self._reader.held + self._machine.streams.held

    @property
    def unacknowledged(self) -> int:
        """Messages on reliable streams that were sent or wait, and are not acknowledged."""
        return self._machine.streams.unacknowledged

    @property
    def mtu(self) -> int:
        """The longest message that is sent, in bytes; an agent's is what its client has said."""
        return self._machine.mtu

    def receive_each(self, data: bytes, now_ns: int) -> Iterator[list[Event]]:
        """As `receive`, the events of each frame by themselves: before the next one is handled, it can be answered."""
        self._run_due(now_ns)
        if due := self._machine.fetch():
            yield due
        self._machine.counters.bytes_in += len(data)
        for item in self._reader.receive(data):
            self._take([item])
            yield self._machine.fetch()

    def send(
        self, submessages: Submessage | Iterable[Submessage], now_ns: int, *, stream_id: int = BUILTIN_RELIABLE
    ) -> bytes:
        """The bytes of submessages of the program's own, to be written to the line now.

        Several go in one message, if that is long enough; on a reliable stream in fragments otherwise. What waits there
        for an ACKNACK comes as `Transmit` later. What is due at `now_ns` stays due: `advance` still reports it.

        Args:
            submessages: one or several.
            now_ns: in ns of bench time.
            stream_id: 0 none, 1..127 best-effort, 128..255 reliable.

        Raises:
            LocalProtocolError: there is no session, a submessage is the other end's or the machine's to send, or does
                not fit, or the stream is one too many. Nothing is changed then.
            StreamFullError: too much waits on the stream already. Nothing is changed then.
        """
        several = [submessages] if isinstance(submessages, Submessage) else list(submessages)
        machine = self._machine
        if machine.state is not machine.OPEN:
            raise LocalProtocolError(f"a {self.role.value} in state {machine.state.name} has no session to send in")
        for one in several:
            if not isinstance(one, _MAY_SEND[self.role]):
                raise LocalProtocolError(
                    f"{type(one).__name__} is not for the program of the {self.role.value} to send"
                )
        machine.now_ns = max(now_ns, machine.now_ns)
        return self._count(machine.outgoing(several, stream_id))

    def reserve(self, stream_id: int) -> None:
        """Makes sure that a stream can be sent on.

        Raises:
            LocalProtocolError: it is a reliable one too many; nothing is changed then.
        """
        if is_reliable(stream_id):
            self._machine.streams.reliable_output(stream_id)

    def new_request_id(self) -> int:
        """The next number for a request, 10..65535; those below are the original client's own."""
        self._request_id = _FIRST_REQUEST if self._request_id == _LAST_REQUEST else self._request_id + 1
        return self._request_id

    def connect(self, now_ns: int) -> list[Event]:
        """Client: asks for a session.

        Raises:
            LocalProtocolError: it is an agent, or has one, or has asked already; nothing is changed then.
        """
        return self._user(ClientTrigger.CONNECT, now_ns)

    def disconnect(self, now_ns: int) -> list[Event]:
        """Client: asks for the end of the session. Agent: forgets its client and sends it nothing.

        Raises:
            LocalProtocolError: there is none; nothing is changed then.
        """
        return self._user(self._of_role(ClientTrigger.DISCONNECT, AgentTrigger.DISCONNECT), now_ns)

    def reset(self, now_ns: int) -> list[Event]:
        """Begins all streams anew, at both ends; what is unacknowledged is lost.

        RESET is not acknowledged: where it is lost itself, the ends do not understand each other any more.

        Raises:
            LocalProtocolError: there is no session; nothing is changed then.
        """
        return self._user(self._of_role(ClientTrigger.RESET_WANTED, AgentTrigger.RESET_WANTED), now_ns)

    def ping(self, now_ns: int) -> bytes:
        """Client: the bytes that ask whether there is an agent, with or without a session; it answers with `Pong`.

        Raises:
            LocalProtocolError: it is an agent.
        """
        said = GetInfo(request_id=self.new_request_id(), object_id=OBJECT_AGENT, info_mask=InfoMask.ACTIVITY)
        return self._ask_agent(said, now_ns)

    def synchronize(self, now_ns: int) -> bytes:
        """Client: the bytes that ask for the agent's time; it answers with `AgentTime`, in a session.

        Raises:
            LocalProtocolError: it is an agent.
        """
        machine = self._machine
        machine.now_ns = max(now_ns, machine.now_ns)
        return self._ask_agent(Timestamp(transmit=Time.of_ns(machine.clock_ns)), now_ns)

    def line_down(self, now_ns: int) -> list[Event]:
        """The line is gone: end of file, hang-up, unplugged."""
        self._run_due(now_ns)
        self._take(self._reader.reset())
        self._machine.fire(self._of_role(ClientTrigger.LINE_DOWN, AgentTrigger.LINE_DOWN))
        return self._machine.fetch()

    def _take(self, found: Iterable[Frame | Dropped]) -> None:
        self._machine.framing = self._reader.framing
        super()._take(found)

    def _of_role(self, of_client: Trigger, of_agent: Trigger) -> Trigger:
        return of_client if self.role is Role.CLIENT else of_agent

    def _ask_agent(self, said: Submessage, now_ns: int) -> bytes:
        if self.role is not Role.CLIENT:
            raise LocalProtocolError("an agent asks no agent")
        machine = self._machine
        machine.now_ns = max(now_ns, machine.now_ns)
        return self._count([machine.unnumbered(said)])

    def _count(self, frames: list[bytes]) -> bytes:
        for frame in frames:
            self._machine.count_out(frame)
        return b"".join(frames)
