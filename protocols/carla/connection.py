"""One end of the simulator's line, without the line: bytes, commands and times in, events out.

    board = Connection(Role.BOARD)
    events = board.receive(data, now_ns)            # bytes of the simulator
    events = board.command(command, now_ns)         # what the driving stack wants
    events = board.advance(now_ns)                  # deadlines that are due
    when = board.next_deadline_ns()                 # when to call advance at the latest

Events come in the order in which things happened; write the data of each `Transmit` to the line. Whatever the bytes,
`receive` raises nothing: what cannot be used is reported in a `FrameDropped` and counted. How bytes are cut into calls
does not matter, only when they came; but to a simulator that polls it does what it does to the original. Time is bench
time in integer nanoseconds; a time earlier than the latest one counts as the latest. What is due at or before the time
of a call has happened before the call.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping

from protocols.carla.board import BoardMachine
from protocols.carla.counters import Counters
from protocols.carla.errors import LocalProtocolError
from protocols.carla.events import Event, Waited
from protocols.carla.frames import Mode
from protocols.carla.messages import ControlCommand
from protocols.carla.options import BoardOptions, SimulatorOptions
from protocols.carla.simulator import SimulatorMachine
from protocols.carla.states import (
    LinkState,
    LinkTable,
    LinkTimer,
    LinkTrigger,
    ModeTable,
    ModeTrigger,
    Role,
    Step,
    Table,
    Timer,
    Trigger,
)
from protocols.state_machine import earliest

__all__ = ["Connection"]


class Connection:
    """One end of the line, in either role.

    Args:
        role: which end.
        options: of that role; its defaults, those of `hardened`, if None.
        epoch_ns: the bench time, in ns, at which the board starts, or the simulator reads first.
        steps: board: another control task than the default one, for tests that must be able to fail.
        modes: board: another table of modes than the default one.
        link: simulator: another table of the link.

    Raises:
        LocalProtocolError: the options are those of the other role.
    """

    def __init__(
        self,
        role: Role,
        options: BoardOptions | SimulatorOptions | None = None,
        *,
        epoch_ns: int = 0,
        steps: Table | None = None,
        modes: ModeTable | None = None,
        link: LinkTable | None = None,
    ) -> None:
        if options is None:
            options = BoardOptions() if role is Role.BOARD else SimulatorOptions()
        if isinstance(options, BoardOptions) is not (role is Role.BOARD):
            raise LocalProtocolError(f"{type(options).__name__} are not the options of a {role.value}")
        self.role = role
        self._machine: BoardMachine | SimulatorMachine
        if isinstance(options, BoardOptions):
            self._machine = BoardMachine(options, steps, modes, epoch_ns)
        else:
            self._machine = SimulatorMachine(options, link, epoch_ns)

    @property
    def state(self) -> Step | LinkState:
        """Where the machine is: a `Step` of the board's control task, or what the simulator knows of the board."""
        return self._machine.state

    @property
    def mode(self) -> Mode:
        """Board: who rules.

        Raises:
            LocalProtocolError: it is a simulator.
        """
        return self._board().mode

    @property
    def reported_mode(self) -> int:
        """Board: the mode that is reported to the driving stack, a value of ControlModeReport.

        Raises:
            LocalProtocolError: it is a simulator.
        """
        return self._board().stack.reported

    @property
    def agent_online(self) -> bool:
        """Board: the driving stack is there, as far as the board knows.

        Raises:
            LocalProtocolError: it is a simulator.
        """
        return self._board().stack.online

    @property
    def counters(self) -> Counters:
        """What was seen and done since the connection was made."""
        return self._machine.counters

    @property
    def visits(self) -> Counter[tuple[Step, Trigger]] | Counter[tuple[LinkState, LinkTrigger]]:
        """How often each edge of the role's table was taken."""
        return self._machine.visits

    @property
    def mode_visits(self) -> Counter[tuple[Mode, ModeTrigger]]:
        """Board: how often each edge of the table of modes was taken.

        Raises:
            LocalProtocolError: it is a simulator.
        """
        return self._board().mode_visits

    @property
    def deadlines(self) -> Mapping[Timer, int] | Mapping[LinkTimer, int]:
        """When each of the timers that run now will run out, in ns of bench time."""
        return self._machine.deadlines

    @property
    def table(self) -> Table | LinkTable:
        """The role's table that is in force: the board's control task, or the simulator's side."""
        return self._machine.table  # type: ignore[return-value]

    @property
    def mode_table(self) -> ModeTable:
        """Board: the table of modes that is in force.

        Raises:
            LocalProtocolError: it is a simulator.
        """
        return self._board().modes

    @property
    def misses(self) -> Mapping[Waited, tuple[int, int]]:
        """Board: how many deadlines of each kind were missed in a row, and at how many the mode changes."""
        return self._machine.misses if isinstance(self._machine, BoardMachine) else {}

    @property
    def held(self) -> int:
        """Bytes that are kept for later; bounded."""
        return self._machine.reader.held

    # --- both ends

    def receive(self, data: bytes, now_ns: int) -> list[Event]:
        """Takes bytes that came in at `now_ns`; raises nothing whatever they are."""
        self._run_due(now_ns)
        self._machine.counters.bytes_in += len(data)
        self._machine.receive(data)
        return self._machine.fetch()

    def advance(self, now_ns: int) -> list[Event]:
        """Lets happen what is due at `now_ns`, in the order of its time."""
        self._run_due(now_ns)
        return self._machine.fetch()

    def next_deadline_ns(self) -> int | None:
        """When `advance` has something to do, in ns of bench time; None if nothing is waited for."""
        return earliest(self._machine.reader.next_deadline_ns(), self._machine.next_deadline_ns())

    # --- the board

    def command(self, command: ControlCommand, now_ns: int) -> list[Event]:
        """Board: the driving stack commands.

        Raises:
            LocalProtocolError: it is a simulator, or a number does not fit a float of 32 bits.
        """
        board = self._board()
        return self._do(now_ns, lambda: board.command(command))

    def request(self, mode: int, now_ns: int) -> list[Event]:
        """Board: the driving stack asks for a mode; `ModeAnswered` is the answer, if anybody listens.

        Raises:
            LocalProtocolError: it is a simulator.
        """
        board = self._board()
        return self._do(now_ns, lambda: board.request(mode))

    def agent(self, now_ns: int, *, online: bool = True) -> list[Event]:
        """Board: a sign of life of the driving stack's agent, or the knowledge that it is gone.

        Commands and requests are signs of life, too.

        Raises:
            LocalProtocolError: it is a simulator.
        """
        board = self._board()
        return self._do(now_ns, board.sign_of_stack if online else board.stack.lost)

    def press(self, now_ns: int) -> list[Event]:
        """Board: a rising edge at the joystick's switch, which is its release; bounces are edges, too.

        Raises:
            LocalProtocolError: it is a simulator.
        """
        return self._do(now_ns, self._board().press)

    def joystick(self, x: int, y: int, now_ns: int) -> list[Event]:
        """Board: where the joystick is from now on, as the converter reads it.

        Raises:
            LocalProtocolError: it is a simulator, or a reading is not 0..65535; nothing is changed then.
        """
        board = self._board()
        return self._do(now_ns, lambda: board.joystick(x, y))

    def line_error(self, now_ns: int) -> list[Event]:
        """Board: an overrun or framing error on the simulator's line.

        Raises:
            LocalProtocolError: it is a simulator.
        """
        return self._do(now_ns, self._board().line_error)

    # --- the simulator

    def velocity(self, lon_m_s: float, lat_m_s: float, heading_rate_rad_s: float, now_ns: int) -> list[Event]:
        """Simulator: a velocity report of the car, in the signs of the frame, see `Signs`.

        Raises:
            LocalProtocolError: it is a board, or a number does not fit a float of 32 bits.
        """
        simulator = self._simulator()
        return self._do(now_ns, lambda: simulator.velocity(lon_m_s, lat_m_s, heading_rate_rad_s))

    def steering(self, steering_rad: float, now_ns: int) -> list[Event]:
        """Simulator: a steering report of the car.

        Raises:
            LocalProtocolError: it is a board, or the number does not fit a float of 32 bits.
        """
        simulator = self._simulator()
        return self._do(now_ns, lambda: simulator.steering(steering_rad))

    def read_error(self, now_ns: int, *, failing: bool = True) -> list[Event]:
        """Simulator: reads of its port fail from now on, or work again.

        Raises:
            LocalProtocolError: it is a board.
        """
        simulator = self._simulator()
        return self._do(now_ns, lambda: simulator.read_error(failing))

    def _board(self) -> BoardMachine:
        if isinstance(self._machine, SimulatorMachine):
            raise LocalProtocolError("that is for a board, this is a simulator")
        return self._machine

    def _simulator(self) -> SimulatorMachine:
        if isinstance(self._machine, BoardMachine):
            raise LocalProtocolError("that is for a simulator, this is a board")
        return self._machine

    def _do(self, now_ns: int, action: Callable[[], None]) -> list[Event]:
        self._run_due(now_ns)
        action()
        return self._machine.fetch()

    def _run_due(self, now_ns: int) -> None:
        """Lets everything happen that is due, each at its time: bytes before deadlines at the same time."""
        machine = self._machine
        now_ns = max(now_ns, machine.now_ns)
        while (deadline_ns := self.next_deadline_ns()) is not None and deadline_ns <= now_ns:
            machine.now_ns = max(deadline_ns, machine.now_ns)
            if machine.reader.next_deadline_ns() == deadline_ns:
                machine.expire_bytes()
            else:
                machine.expire_next()
        machine.now_ns = now_ns
