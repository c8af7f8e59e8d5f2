"""One end of the stand-in link, without the line: bytes and times in, events out.

    connection = Connection(Role.AGENT)
    events = connection.connect(now_ns)             # agent: opens the line, says that it is there
    events = connection.receive(data, now_ns)       # bytes that came
    events = connection.advance(now_ns)             # timers that are due
    data = connection.send(message, now_ns)         # a message of your own
    when = connection.next_deadline_ns()            # when to call advance at the latest

Events come in the order in which things happened; write the data of each `Transmit` to the line. Whatever the bytes,
`receive` raises nothing: what cannot be used is reported in a `FrameDropped` and counted. How bytes are cut into calls
does not matter. Time is bench time in integer nanoseconds; a time earlier than the latest one counts as the latest.
What is due at or before the time of a call has happened before the call's bytes arrive.
"""

from __future__ import annotations

from protocols.autoware.catalogue import MESSAGES, Sender
from protocols.autoware.errors import LocalProtocolError
from protocols.autoware.events import Event
from protocols.autoware.machine import AgentMachine, BoardMachine, Counters
from protocols.autoware.messages import Message
from protocols.autoware.options import AgentOptions, BoardOptions
from protocols.autoware.payload import UnknownMessage
from protocols.autoware.stand_in import FrameReader
from protocols.autoware.states import Action, AgentTrigger, Role, State, Table, Timer, Trigger
from protocols.common.flagged_connection import FlaggedConnection

__all__ = ["Connection"]

_SENDER = {Role.AGENT: Sender.AGENT, Role.BOARD: Sender.BOARD}


class Connection(FlaggedConnection[State, Trigger, Action, Timer, Event, Counters]):
    """One end of the line, in either role.

    Args:
        role: which end: the agent is the driving stack's.
        options: of that role; its defaults if None.
        epoch_ns: board: the bench time, in ns, at which it begins to ask for an agent.
        table: another state machine than the default one, for tests that must be able to fail.

    Raises:
        LocalProtocolError: the options are those of the other role.
    """

    MISUSE = LocalProtocolError
    role: Role
    _machine: BoardMachine | AgentMachine

    def __init__(
        self,
        role: Role,
        options: BoardOptions | AgentOptions | None = None,
        *,
        epoch_ns: int = 0,
        table: Table | None = None,
    ) -> None:
        if options is None:
            options = BoardOptions() if role is Role.BOARD else AgentOptions()
        if isinstance(options, BoardOptions) is not (role is Role.BOARD):
            raise LocalProtocolError(f"{type(options).__name__} are not the options of the {role.value}")
        self.role = role
        self._reader = FrameReader(options.frames)
        if isinstance(options, BoardOptions):
            self._machine = BoardMachine(options, table, epoch_ns)
        else:
            self._machine = AgentMachine(options, table)

    def send(self, message: Message | UnknownMessage, now_ns: int) -> bytes:
        """The bytes of a message of the program's own, to be written to the line now.

        What is due at `now_ns` stays due: `advance` still reports it. Messages can be sent in every state.

        Raises:
            LocalProtocolError: the message is the other end's, or does not fit. Nothing is changed then.
        """
        if not isinstance(message, UnknownMessage) and MESSAGES[type(message)].sender is not _SENDER[self.role]:
            raise LocalProtocolError(f"{type(message).__name__} is not for the {self.role.value} to send")
        machine = self._machine
        frame = machine.encode(message)
        machine.now_ns = max(now_ns, machine.now_ns)
        machine.count_out(frame)
        return frame

    def connect(self, now_ns: int) -> list[Event]:
        """Agent: opens the line: says that it is there, and begins to notice whether the board is.

        Raises:
            LocalProtocolError: it is a board, or open already; nothing is changed then.
        """
        return self._user(AgentTrigger.CONNECT, now_ns)

    def disconnect(self, now_ns: int) -> list[Event]:
        """Agent: closes the line; the link has no message for that, the board notices what it misses.

        Raises:
            LocalProtocolError: it is a board, or not open; nothing is changed then.
        """
        return self._user(AgentTrigger.DISCONNECT, now_ns)

    def line_down(self, now_ns: int) -> list[Event]:
        """The line is gone: end of file, hang-up, unplugged. A board's UART notices nothing of that."""
        self._run_due(now_ns)
        if self.role is Role.AGENT:
            self._take(self._reader.reset())
            self._machine.fire(AgentTrigger.LINE_DOWN)
        return self._machine.fetch()
