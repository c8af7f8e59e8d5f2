"""What can be seen of a vehicle-interface board: the modes of its model; of firmware, what both its peers know.

Nobody looks into firmware. Its mode is that of the frames that the simulator's side hears; its deadlines are counted
from what its peers sent last, so they are never later than its own.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from typing import Any

from hilbench.bench import Bench
from hilbench.bench.state_reporter import Sense
from hilbench.clock import NS_PER_S
from protocols.autoware import Timer as LinkTimer
from protocols.carla import DEADLINES, Counters, Mode, ModeTrigger, Step, Timer, Transition, Trigger
from targets.robots.vehicle_interface import VehicleInterface

__all__ = ["BOARD_SENSES", "LINK_SENSES", "BoardFromOutside", "BoardLink", "BoardModes", "ControlTask", "Sight", "Sign"]

BOARD_SENSES: Mapping[str, Sense] = {
    Timer.AGENT.name: Sense.WAIT,
    Timer.COMMAND.name: Sense.WAIT,
    Timer.STATUS.name: Sense.WAIT,
    Timer.PAUSE.name: Sense.REST,
}
"""The timers of the control task end when what they wait for comes; the pause is a rest."""
LINK_SENSES: Mapping[str, Sense] = {LinkTimer.PING.name: Sense.REST}
"""When the time for a ping comes, nothing is wrong."""


class Sight(Enum):
    """The mode of a board, in words for people."""

    NO_FRAME = "no frame yet"
    AUTOWARE = "the driving stack rules"
    MANUAL = "the joystick rules"
    EMERGENCY = "the car is stopped"


@dataclass(frozen=True, slots=True)
class _Edge:
    """An edge of a table, as `hilbench.bench.state_reporter.describe_machine` reads it."""

    next_state: Enum


@dataclass(slots=True)
class _Nothing:
    """Counters of what counts nothing."""


_SIGHTS = {Mode.AUTOWARE: Sight.AUTOWARE, Mode.MANUAL: Sight.MANUAL, Mode.EMERGENCY: Sight.EMERGENCY}


class BoardModes:
    """The modes of a behavioural board, with what its control task waits for and counts.

    Args:
        board: the board; a reset gives it other ends of its lines.
    """

    def __init__(self, board: VehicleInterface) -> None:
        self._board = board

    @property
    def state(self) -> Sight:
        """See `hilbench.bench.state_reporter.Observed`."""
        return _SIGHTS[self._board.simulator.mode]

    @property
    def visits(self) -> Mapping[tuple[Sight, ModeTrigger], int]:
        """See `hilbench.bench.state_reporter.Observed`."""
        return {(_SIGHTS[mode], why): count for (mode, why), count in self._board.simulator.mode_visits.items()}

    @property
    def deadlines(self) -> Mapping[Any, int]:
        """See `hilbench.bench.state_reporter.Observed`."""
        return self._board.simulator.deadlines

    @property
    def misses(self) -> Mapping[Any, tuple[int, int]]:
        """See `hilbench.bench.state_reporter.CountsMisses`."""
        return self._board.simulator.misses

    @property
    def counters(self) -> Counters:
        """See `hilbench.bench.state_reporter.Observed`."""
        return self._board.simulator.counters

    @property
    def table(self) -> Mapping[tuple[Sight, ModeTrigger], _Edge]:
        """See `hilbench.bench.state_reporter.Observed`."""
        modes = self._board.simulator.mode_table
        return {(_SIGHTS[mode], why): _Edge(_SIGHTS[edge.next_mode]) for (mode, why), edge in modes.items()}


class ControlTask:
    """The steps of a behavioural board's control task.

    Args:
        board: the board.
    """

    deadlines: Mapping[Any, int] = {}
    counters = _Nothing()

    def __init__(self, board: VehicleInterface) -> None:
        self._board = board

    @property
    def state(self) -> Any:
        """See `hilbench.bench.state_reporter.Observed`."""
        return self._board.simulator.state

    @property
    def visits(self) -> Mapping[Any, int]:
        """See `hilbench.bench.state_reporter.Observed`."""
        return self._board.simulator.visits

    @property
    def table(self) -> Mapping[tuple[Step, Trigger], Transition]:
        """See `hilbench.bench.state_reporter.Observed`."""
        return self._board.simulator.table  # type: ignore[return-value]


class BoardLink:
    """A behavioural board's end of the driving stack's line.

    Args:
        board: the board.
    """

    def __init__(self, board: VehicleInterface) -> None:
        self._board = board

    @property
    def state(self) -> Any:
        """See `hilbench.bench.state_reporter.Observed`."""
        return self._board.stack.state

    @property
    def visits(self) -> Mapping[Any, int]:
        """See `hilbench.bench.state_reporter.Observed`."""
        return self._board.stack.visits

    @property
    def deadlines(self) -> Mapping[Any, int]:
        """See `hilbench.bench.state_reporter.Observed`."""
        return self._board.stack.deadlines

    @property
    def counters(self) -> Any:
        """See `hilbench.bench.state_reporter.Observed`."""
        return self._board.stack.counters

    @property
    def table(self) -> Any:
        """See `hilbench.bench.state_reporter.Observed`."""
        return self._board.stack.table


class Sign(Enum):
    """What is seen of a change of mode."""

    AUTOWARE = "a frame in AUTOWARE"
    MANUAL = "a frame in MANUAL"
    EMERGENCY = "a frame in EMERGENCY"


class Owed(Enum):
    """What a board must be sent, and by when."""

    COMMAND = "a command, in AUTOWARE"
    COMMANDS_LOST = "the tenth command: MANUAL"
    STATUS = "a status"
    STATUS_LOST = "the tenth status: EMERGENCY"


@dataclass(frozen=True, slots=True, kw_only=True)
class ModeSeen:
    """The board's frames have another mode than before."""

    old: Sight
    new: Sight
    trigger: Sign


@dataclass(slots=True)
class Heard:
    """What was heard of a board, and sent to it."""

    frames_autoware: int = 0
    frames_manual: int = 0
    frames_emergency: int = 0
    emergencies: int = 0
    commands_sent: int = 0
    statuses_sent: int = 0


_TABLE = {
    (before, Sign[after.name]): _Edge(after) for before in Sight for after in _SIGHTS.values() if after is not before
}
_COMMAND, _STATUS = DEADLINES["command_deadline_s"], DEADLINES["status_deadline_s"]
_PAUSE = DEADLINES["manual_pause_s"]


class BoardFromOutside:
    """See the module. It receives what its peers hear and send.

    Args:
        bench: whose time passes.
    """

    table: Mapping[tuple[Sight, Sign], _Edge] = _TABLE

    def __init__(self, bench: Bench) -> None:
        self._bench = bench
        self.state = Sight.NO_FRAME
        self.visits: Counter[tuple[Sight, Sign]] = Counter()
        self.counters = Heard()
        self._command_ns: int | None = None
        self._status_ns: int | None = None

    def frame(self, mode: int | None) -> None:
        """Take the mode of a frame that the simulator's side heard; None where no frame said it."""
        if mode is None:
            return
        sight = _SIGHTS[Mode(mode)]
        name = f"frames_{sight.name.lower()}"
        setattr(self.counters, name, getattr(self.counters, name) + 1)
        if sight is not self.state:
            old, self.state, sign = self.state, sight, Sign[sight.name]
            self.visits[old, sign] += 1
            self.counters.emergencies += sight is Sight.EMERGENCY
            self._bench.record_event("board", ModeSeen(old=old, new=sight, trigger=sign))

    def command_sent(self) -> None:
        """Take that the driving stack commands now."""
        self.counters.commands_sent += 1
        self._command_ns = self._bench.now_ns

    def status_sent(self) -> None:
        """Take that the simulator says now how the car moves."""
        self.counters.statuses_sent += 1
        self._status_ns = self._bench.now_ns

    @property
    def deadlines(self) -> Mapping[Owed, int]:
        """See `hilbench.bench.state_reporter.Observed`."""
        due: dict[Owed, int] = {}
        if self._command_ns is not None and self.state is Sight.AUTOWARE:
            due[Owed.COMMAND] = self._command_ns + _ns(_COMMAND.value_s)
            due[Owed.COMMANDS_LOST] = self._command_ns + _ns(_COMMAND.value_s * _COMMAND.misses)
        if self._status_ns is not None and self.state is not Sight.EMERGENCY:
            turn_s = _STATUS.value_s + (_PAUSE.value_s if self.state is Sight.MANUAL else 0.0)
            due[Owed.STATUS] = self._status_ns + _ns(_STATUS.value_s)
            due[Owed.STATUS_LOST] = self._status_ns + _ns(turn_s * _STATUS.misses)
        return due


def _ns(seconds: float) -> int:
    return round(seconds * NS_PER_S)
