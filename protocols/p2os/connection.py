"""One end of a P2OS line, without the line: bytes and times in, events out.

    connection = Connection(Role.SERVER)
    events = connection.receive(data, now_ns)       # bytes that came
    events = connection.advance(now_ns)             # timers that are due
    data = connection.send(packet, now_ns)          # a message of your own
    when = connection.next_deadline_ns()            # when to call advance at the latest

Events come in the order in which things happened; write the data of each `Transmit` to the line. Whatever the bytes,
`receive` raises nothing: what cannot be used is reported in a `FrameDropped` and counted. How bytes are cut into calls
does not matter, only when they came. Time is bench time in integer nanoseconds; a time earlier than the latest one
counts as the latest. A timer that is due at or before the time of a call has run out before the call's bytes arrive.
"""

from __future__ import annotations

from protocols.common.connection import MachineConnection
from protocols.p2os.client import ClientMachine
from protocols.p2os.commands import Command, CommandNumber, encode_command
from protocols.p2os.errors import LocalProtocolError
from protocols.p2os.events import Event
from protocols.p2os.framing import Dropped, Frame, FrameReader
from protocols.p2os.machine import Counters
from protocols.p2os.options import ClientOptions, ServerOptions
from protocols.p2os.packets import Identification, ServerPacket, SyncEcho, SyncError, encode_packet
from protocols.p2os.server import ServerMachine
from protocols.p2os.states import (
    MAY_SEND,
    Action,
    ClientTrigger,
    Role,
    ServerTrigger,
    State,
    Table,
    Timer,
    Trigger,
)
from protocols.state_machine import earliest

__all__ = ["Connection"]

_NOT_BY_HAND = (CommandNumber.OPEN, CommandNumber.CLOSE)


class Connection(MachineConnection[State, Trigger, Action, Timer, Event, Counters]):
    """One end of the line, in either role.

    Args:
        role: which end.
        options: of that role; its defaults if None.
        table: another state machine than that of the options, for tests that must be able to fail.

    Raises:
        LocalProtocolError: the options are those of the other role.
    """

    MISUSE = LocalProtocolError
    role: Role
    _machine: ServerMachine | ClientMachine

    def __init__(
        self, role: Role, options: ServerOptions | ClientOptions | None = None, *, table: Table | None = None
    ) -> None:
        if options is None:
            options = ServerOptions() if role is Role.SERVER else ClientOptions()
        if isinstance(options, ServerOptions) is not (role is Role.SERVER):
            raise LocalProtocolError(f"{type(options).__name__} are not the options of a {role.value}")
        self.role = role
        self._machine = (
            ServerMachine(options, table) if isinstance(options, ServerOptions) else ClientMachine(options, table)
        )
        timeout_s = options.frame_timeout_s
        timeout_ns = None if timeout_s is None else round(timeout_s * 1e9)
        self._reader = FrameReader(max_count=options.max_count, timeout_ns=timeout_ns)

    @property
    def held(self) -> int:
        """Bytes of an unfinished frame or of noise that are kept; bounded, see `FrameReader`."""
        return self._reader.held

    def receive(self, data: bytes, now_ns: int) -> list[Event]:
        """Takes bytes that came in at `now_ns`; raises nothing whatever they are."""
        now_ns = self._run_due(now_ns)
        self._machine.counters.bytes_in += len(data)
        self._take(self._reader.receive(data, now_ns))
        return self._machine.fetch()

    def next_deadline_ns(self) -> int | None:
        """When `advance` has something to do, in ns of bench time; None if nothing is waited for."""
        return earliest(self._machine.next_deadline_ns(), self._reader.next_deadline_ns())

    def send(self, message: Command | ServerPacket, now_ns: int) -> bytes:
        """The bytes of a message of the program's own, to be written to the line now.

        Timers that are due at `now_ns` stay due: `advance` still reports them.

        Raises:
            LocalProtocolError: no session is open, the message is none of this role's, or it does not fit a frame.
                Nothing is changed then.
        """
        if self.state not in MAY_SEND:
            raise LocalProtocolError(f"a {self.role.value} cannot send in state {self.state.name}")
        frame = self._encode(message)
        self._machine.now_ns = max(now_ns, self._machine.now_ns)
        self._machine.count_out(frame)
        if isinstance(self._machine, ClientMachine):
            self._machine.sent()
        return frame

    def connect(self, now_ns: int) -> list[Event]:
        """Client: begins to connect.

        Raises:
            LocalProtocolError: it is a server, or already connected or connecting; nothing is changed then.
        """
        self._check_edge(ClientTrigger.CONNECT)
        self._run_due(now_ns)
        self._take(self._reader.reset())
        self._machine.fire(ClientTrigger.CONNECT)
        return self._machine.fetch()

    def disconnect(self, now_ns: int) -> list[Event]:
        """Client: takes leave, or gives up connecting.

        Raises:
            LocalProtocolError: it is a server, or neither connected nor connecting; nothing is changed then.
        """
        return self._user(ClientTrigger.DISCONNECT, now_ns)

    def line_down(self, now_ns: int) -> list[Event]:
        """The line is gone: end of file, hang-up, unplugged."""
        self._run_due(now_ns)
        self._take(self._reader.reset())
        self._machine.fire(ServerTrigger.LINE_DOWN if self.role is Role.SERVER else ClientTrigger.LINE_DOWN)
        return self._machine.fetch()

    def _encode(self, message: Command | ServerPacket) -> bytes:
        if isinstance(message, Command):
            if self.role is Role.SERVER or message.number in _NOT_BY_HAND:
                raise LocalProtocolError(f"{message.name} is not for the program on a {self.role.value} to send")
            return encode_command(message)
        if self.role is Role.CLIENT or isinstance(message, SyncEcho | SyncError | Identification):
            raise LocalProtocolError(f"{type(message).__name__} is not for the program on a {self.role.value} to send")
        return encode_packet(message)

    def _take(self, found: list[Frame | Dropped]) -> None:
        for item in found:
            if isinstance(item, Dropped):
                self._machine.drop(item)
            else:
                self._machine.counters.frames_in += 1
                self._machine.take_frame(item)

    def _run_due(self, now_ns: int) -> int:
        """See `MachineConnection`."""
        machine, reader = self._machine, self._reader
        now_ns = machine.now_ns = max(now_ns, machine.now_ns)
        while (deadline_ns := self.next_deadline_ns()) is not None and deadline_ns <= now_ns:
            if reader.next_deadline_ns() == deadline_ns:
                self._take(reader.expire(now_ns))
            else:
                machine.expire_next()
        return now_ns
