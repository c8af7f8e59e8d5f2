"""One end of a PKT! line, without the line: bytes and times in, events out.

    connection = Connection(Role.SERVER)
    events = connection.receive(data, now_ns)       # bytes that came
    events = connection.advance(now_ns)             # timers and reports that are due
    data = connection.send(report, now_ns)          # a message of your own
    when = connection.next_deadline_ns()            # when to call advance at the latest

Events come in the order in which things happened; write the data of each `Transmit` to the line. Whatever the bytes,
`receive` raises nothing: what cannot be used is reported in a `FrameDropped` and counted. How bytes are cut into calls
does not matter, only when they came. Time is bench time in integer nanoseconds; a time earlier than the latest one
counts as the latest. What is due at or before the time of a call has happened before the call's bytes arrive.
"""

from __future__ import annotations

from collections import Counter

from protocols.common.connection import MachineConnection
from protocols.pkt.client import ClientMachine
from protocols.pkt.commands import Command
from protocols.pkt.errors import LocalProtocolError
from protocols.pkt.events import Event
from protocols.pkt.framing import Dropped, Frame, FrameReader
from protocols.pkt.line_reader import LineReader
from protocols.pkt.machine import Counters
from protocols.pkt.options import ClientOptions, ServerOptions
from protocols.pkt.polling import PollQueue
from protocols.pkt.reports import ExecutionReport, GeneralReport, Report
from protocols.pkt.server import ServerMachine
from protocols.pkt.states import (
    Action,
    ClientTrigger,
    FrameState,
    FrameTable,
    FrameTrigger,
    Role,
    State,
    Table,
    Timer,
    Trigger,
)
from protocols.pkt.units import PacketTotals

__all__ = ["Connection"]


class Connection(MachineConnection[State, Trigger, Action, Timer, Event, Counters]):
    """One end of the line, in either role.

    Args:
        role: which end: the client is the host, the server the rover.
        options: of that role; its defaults if None.
        epoch_ns: server: the bench time, in ns, at which the rover begins to work: tick 0 of its reports and looks.
        table: another state machine than the default one, for tests that must be able to fail.
        frames: another decoder than that of the options.

    Raises:
        LocalProtocolError: the options are those of the other role.
    """

    MISUSE = LocalProtocolError
    role: Role
    _machine: ServerMachine | ClientMachine

    def __init__(
        self,
        role: Role,
        options: ServerOptions | ClientOptions | None = None,
        *,
        epoch_ns: int = 0,
        table: Table | None = None,
        frames: FrameTable | None = None,
    ) -> None:
        if options is None:
            options = ServerOptions() if role is Role.SERVER else ClientOptions()
        if isinstance(options, ServerOptions) is not (role is Role.SERVER):
            raise LocalProtocolError(f"{type(options).__name__} are not the options of a {role.value}")
        self.role = role
        self._queue: PollQueue | None = None
        self._reader: FrameReader | LineReader
        if isinstance(options, ServerOptions):
            keep = options.pid_reads_late or not options.strict_length
            self._reader = FrameReader(options.frames, table=frames, keep_buffer=keep, epoch_ns=epoch_ns)
            self._queue = None if options.poll is None else PollQueue(options.poll, epoch_ns)
            self._machine = ServerMachine(options, table, epoch_ns)
        else:
            lines = options.split_lines
            self._reader = LineReader() if lines else FrameReader(options.frames, table=frames)
            self._machine = ClientMachine(options, table)

    @property
    def frame_visits(self) -> Counter[tuple[FrameState, FrameTrigger]]:
        """How often each edge of the decoder's table was taken; empty for a client that splits lines."""
        return Counter() if isinstance(self._reader, LineReader) else self._reader.visits

    @property
    def held(self) -> int:
        """Bytes of an unfinished frame, of noise or in the receive buffer that are kept; bounded."""
        return self._reader.held + (0 if self._queue is None else self._queue.held)

    @property
    def telemetry(self) -> GeneralReport:
        """Server: the general report as it would be sent now.

        Raises:
            LocalProtocolError: it is a client.
        """
        return self._rover().telemetry

    @property
    def totals(self) -> PacketTotals | None:
        """Client: the rover's counters without their wrapping; None before the first general report, and for a server.

        They restart at 0 with `connect`. A rover that restarts meanwhile looks like one whose counters wrapped.
        """
        return self._machine.totals if isinstance(self._machine, ClientMachine) else None

    def set_status(self, status: int) -> None:
        """Server: sets the STATUS byte of the general report, see `StatusFlag`.

        Raises:
            LocalProtocolError: it is a client, or the status is not 0..255.
        """
        rover = self._rover()
        if not 0 <= status <= 0xFF:
            raise LocalProtocolError(f"status {status} is not 0..255")
        rover.set_status(status)

    def receive(self, data: bytes, now_ns: int) -> list[Event]:
        """Takes bytes that came in at `now_ns`; raises nothing whatever they are."""
        now_ns = self._run_due(now_ns)
        self._machine.counters.bytes_in += len(data)
        if self._queue is None:
            self._take(self._reader.receive(data, now_ns))
        else:
            self._queue.put(data, now_ns)
        return self._machine.fetch()

    def next_deadline_ns(self) -> int | None:
        """When `advance` has something to do, in ns of bench time; None if nothing is waited for."""
        deadlines = (*self._deadlines_of_bytes(), self._machine.next_deadline_ns())
        return min((deadline for deadline in deadlines if deadline is not None), default=None)

    def send(self, message: Command | Report, now_ns: int) -> bytes:
        """The bytes of a message of the program's own, to be written to the line now.

        What is due at `now_ns` stays due: `advance` still reports it. There is no session to be opened first.

        Raises:
            LocalProtocolError: the message is none of this role's or of its schema, or does not fit a frame. Nothing is
                changed then.
        """
        machine = self._machine
        if isinstance(machine, ServerMachine):
            if not isinstance(message, Report) or isinstance(message, GeneralReport | ExecutionReport):
                raise LocalProtocolError(f"{type(message).__name__} is not for the program on a server to send")
            frame = machine.encode(message)
        else:
            if isinstance(message, Report):
                raise LocalProtocolError(f"{type(message).__name__} is not for a client to send")
            frame = machine.encode(message)
        machine.now_ns = max(now_ns, machine.now_ns)
        machine.count_out(frame)
        if isinstance(machine, ClientMachine):
            machine.sent()
        return frame

    def connect(self, now_ns: int) -> list[Event]:
        """Client: begins to ask for reports, and to notice when none come.

        Raises:
            LocalProtocolError: it is a server, or already does; nothing is changed then.
        """
        return self._user(ClientTrigger.CONNECT, now_ns)

    def disconnect(self, now_ns: int) -> list[Event]:
        """Client: stops the motors, if the options say so, and sends nothing more by itself.

        Raises:
            LocalProtocolError: it is a server, or not connected; nothing is changed then.
        """
        return self._user(ClientTrigger.DISCONNECT, now_ns)

    def line_down(self, now_ns: int) -> list[Event]:
        """The line is gone: end of file, hang-up, unplugged. A rover's UART notices nothing of that."""
        self._run_due(now_ns)
        if self.role is Role.CLIENT:
            self._take(self._reader.reset())
            self._machine.fire(ClientTrigger.LINE_DOWN)
        return self._machine.fetch()

    def _rover(self) -> ServerMachine:
        if isinstance(self._machine, ClientMachine):
            raise LocalProtocolError("a client has no telemetry of its own")
        return self._machine

    def _take(self, found: list[Frame | Dropped]) -> None:
        for item in found:
            if isinstance(item, Dropped):
                self._machine.drop(item)
            else:
                self._machine.counters.frames_in += 1
                self._machine.take_frame(item)

    def _deadlines_of_bytes(self) -> tuple[int | None, int | None]:
        return (None if self._queue is None else self._queue.next_deadline_ns(), self._reader.next_deadline_ns())

    def _run_due(self, now_ns: int) -> int:
        """See `MachineConnection`."""
        now_ns = max(now_ns, self._machine.now_ns)
        while (deadline_ns := self.next_deadline_ns()) is not None and deadline_ns <= now_ns:
            self._machine.now_ns = deadline_ns
            self._run(deadline_ns)
        self._machine.now_ns = now_ns
        return now_ns

    def _run(self, deadline_ns: int) -> None:
        """Lets the first thing happen that is due then: bytes before timers and reports, as in all firmware."""
        look_ns, reader_ns = self._deadlines_of_bytes()
        if reader_ns == deadline_ns:
            self._take(self._reader.expire(deadline_ns))
        elif self._queue is not None and look_ns == deadline_ns:
            taken, dropped = self._queue.take()
            self._take([*dropped, *self._reader.receive(taken, deadline_ns)])
        else:
            self._machine.expire_next()
