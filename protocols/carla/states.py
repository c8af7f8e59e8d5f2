"""The board's modes and the steps of its control task, as data: who rules, what is waited for, what follows.

The diagrams in the docs, the coverage figures and the mutants are made from these tables. There are two: `MODE_TABLE`
says how one mode becomes another, `STEP_TABLE` how the control task goes through its loop. The loop's order is the
original's: a request of the driving stack, a press of the joystick, then the blocks AUTOWARE, MANUAL and EMERGENCY, so
that a mode that an earlier block has chosen is acted on in the same turn.
Source: LMA-FEM-UNICAMP/microAutoware, src/HIL taksControl.c `StartTaskControl`.
"""

from __future__ import annotations

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from protocols.carla.frames import Mode

__all__ = [
    "BLOCK_OF_MODE",
    "DEADLINES",
    "LINK_TABLE",
    "LINK_TIMER_STATES",
    "MODE_OF_STEP",
    "MODE_TABLE",
    "STEP_TABLE",
    "TIMER_STEPS",
    "Action",
    "Deadline",
    "LinkAction",
    "LinkState",
    "LinkTable",
    "LinkTimer",
    "LinkTransition",
    "LinkTrigger",
    "ModeTable",
    "ModeTransition",
    "ModeTrigger",
    "Role",
    "Step",
    "Table",
    "Timer",
    "Transition",
    "Trigger",
]


class Role(enum.Enum):
    """Which end of the line a connection is."""

    BOARD = "board"
    SIMULATOR = "simulator"


class ModeTrigger(enum.Enum):
    """What changes the mode."""

    NO_AGENT = "the agent did not come in time"
    REQUEST_AUTOWARE = "the driving stack asks for AUTOWARE"
    REQUEST_MANUAL = "the driving stack asks for MANUAL"
    PRESS = "the joystick is pressed"
    AGENT_LOST = "the driving stack is not heard at all any more"
    COMMANDS_LOST = "as many commands missed as may be"
    STATUS_LOST = "as many statuses missed as may be"
    STATUS_RETURNS = "a status in EMERGENCY"


class Step(enum.Enum):
    """Where the control task is: most of these are waits, those named END and TOP take no time."""

    STARTING = "waits for the agent"
    LOOP_TOP = "looks for requests and presses, then for the block of its mode"
    AUTOWARE_COMMAND = "AUTOWARE: waits for a command"
    AUTOWARE_STATUS = "AUTOWARE: has sent, waits for a status"
    AUTOWARE_END = "AUTOWARE: the block is done"
    MANUAL_STATUS = "MANUAL: has sent, waits for a status"
    MANUAL_PAUSE = "MANUAL: rests"
    MANUAL_END = "MANUAL: the block is done"
    EMERGENCY_STATUS = "EMERGENCY: has sent, waits for a status"


class Trigger(enum.Enum):
    """What happens to the control task."""

    AGENT = "the agent is there"
    NO_AGENT = "no agent in time"
    AUTOWARE = "the mode is AUTOWARE"
    MANUAL = "the mode is MANUAL"
    EMERGENCY = "the mode is EMERGENCY"
    COMMAND = "a command"
    COMMAND_MISSED = "no command in time"
    COMMANDS_LOST = "no command in time, once too often"
    STATUS = "a status"
    STATUS_MISSED = "no status in time"
    STATUS_LOST = "no status in time, once too often"
    PAUSE_OVER = "the pause is over"


class Action(enum.Enum):
    """What the control task does on an edge."""

    LOOK = "take requests and presses, go to the block of the mode"
    BRANCH = "go to the block of the mode, or back to the top"
    CHANGE_MODE = "change the mode"
    SHOW_MODE = "light the lamp of the mode"
    WAIT_COMMAND = "wait for a command"
    WAIT_STATUS = "wait for a status"
    WAIT_PAUSE = "rest"
    SEND_COMMAND = "send the command"
    SEND_AGAIN = "send what the options say for a missing command"
    SEND_JOYSTICK = "send what the joystick says"
    SEND_EMERGENCY = "send zeros in mode 0"
    FORGET_COMMAND_MISSES = "count missed commands from 0"
    FORGET_STATUS_MISSES = "count missed statuses from 0"
    REPORT_STATUS = "report the status to the driving stack"
    REPORT_OLD_STATUS = "report the old status to the driving stack, where the options want it"


class Timer(enum.Enum):
    """What a wait ends with; where it runs out, the trigger that is named."""

    AGENT = "the agent must come: NO_AGENT"
    COMMAND = "a command must come: COMMAND_MISSED or COMMANDS_LOST"
    STATUS = "a status must come: STATUS_MISSED or STATUS_LOST"
    PAUSE = "the pause: PAUSE_OVER"


@dataclass(frozen=True, slots=True)
class ModeTransition:
    """An edge of the modes.

    Attributes:
        next_mode: the mode that follows.
        source: what there is to say of it.
    """

    next_mode: Mode
    source: str = "taksControl.c"


@dataclass(frozen=True, slots=True)
class Transition:
    """An edge of the control task."""

    next_state: Step
    actions: tuple[Action, ...] = ()


ModeTable = Mapping[tuple[Mode, ModeTrigger], ModeTransition]
Table = Mapping[tuple[Step, Trigger], Transition]

_M, _MT, _S, _T, _A = Mode, ModeTrigger, Step, Trigger, Action

MODE_TABLE: ModeTable = MappingProxyType(
    {
        (_M.AUTOWARE, _MT.NO_AGENT): ModeTransition(_M.MANUAL),
        (_M.AUTOWARE, _MT.REQUEST_AUTOWARE): ModeTransition(_M.AUTOWARE),
        (_M.AUTOWARE, _MT.REQUEST_MANUAL): ModeTransition(_M.MANUAL),
        (_M.AUTOWARE, _MT.PRESS): ModeTransition(_M.MANUAL),
        (_M.AUTOWARE, _MT.AGENT_LOST): ModeTransition(_M.MANUAL, "choice: the original does not watch the agent"),
        (_M.AUTOWARE, _MT.COMMANDS_LOST): ModeTransition(_M.MANUAL),
        (_M.AUTOWARE, _MT.STATUS_LOST): ModeTransition(_M.EMERGENCY),
        (_M.MANUAL, _MT.REQUEST_AUTOWARE): ModeTransition(_M.AUTOWARE),
        (_M.MANUAL, _MT.REQUEST_MANUAL): ModeTransition(_M.MANUAL),
        (_M.MANUAL, _MT.PRESS): ModeTransition(_M.AUTOWARE),
        (_M.MANUAL, _MT.STATUS_LOST): ModeTransition(_M.EMERGENCY),
        (_M.EMERGENCY, _MT.REQUEST_AUTOWARE): ModeTransition(
            _M.AUTOWARE, "taksControl.c; not in the report's diagram, and refused by the hardened profile"
        ),
        (_M.EMERGENCY, _MT.REQUEST_MANUAL): ModeTransition(
            _M.MANUAL, "taksControl.c; not in the report's diagram, and refused by the hardened profile"
        ),
        (_M.EMERGENCY, _MT.STATUS_RETURNS): ModeTransition(_M.MANUAL),
    }
)
"""How the modes follow each other. A press in EMERGENCY has no edge: it is used up and does nothing."""

BLOCK_OF_MODE: Mapping[Mode, Trigger] = MappingProxyType(
    {_M.AUTOWARE: _T.AUTOWARE, _M.MANUAL: _T.MANUAL, _M.EMERGENCY: _T.EMERGENCY}
)
"""By which trigger the control task goes to the block of a mode."""

_AUTOWARE = Transition(_S.AUTOWARE_COMMAND, (_A.SHOW_MODE, _A.WAIT_COMMAND))
_MANUAL = Transition(_S.MANUAL_STATUS, (_A.SHOW_MODE, _A.SEND_JOYSTICK, _A.WAIT_STATUS))
_EMERGENCY = Transition(_S.EMERGENCY_STATUS, (_A.SHOW_MODE, _A.SEND_EMERGENCY, _A.WAIT_STATUS))
_TOP = Transition(_S.LOOP_TOP, (_A.LOOK,))
_LOST = Transition(_S.AUTOWARE_END, (_A.CHANGE_MODE, _A.BRANCH))

STEP_TABLE: Table = MappingProxyType(
    {
        (_S.STARTING, _T.AGENT): _TOP,
        (_S.STARTING, _T.NO_AGENT): Transition(_S.LOOP_TOP, (_A.CHANGE_MODE, _A.LOOK)),
        (_S.LOOP_TOP, _T.AUTOWARE): _AUTOWARE,
        (_S.LOOP_TOP, _T.MANUAL): _MANUAL,
        (_S.LOOP_TOP, _T.EMERGENCY): _EMERGENCY,
        (_S.AUTOWARE_COMMAND, _T.COMMAND): Transition(
            _S.AUTOWARE_STATUS, (_A.FORGET_COMMAND_MISSES, _A.SEND_COMMAND, _A.WAIT_STATUS)
        ),
        (_S.AUTOWARE_COMMAND, _T.COMMAND_MISSED): Transition(_S.AUTOWARE_END, (_A.SEND_AGAIN, _A.BRANCH)),
        (_S.AUTOWARE_COMMAND, _T.COMMANDS_LOST): _LOST,
        (_S.AUTOWARE_COMMAND, _T.STATUS_LOST): _LOST,
        (_S.AUTOWARE_STATUS, _T.STATUS): Transition(
            _S.AUTOWARE_END, (_A.FORGET_STATUS_MISSES, _A.REPORT_STATUS, _A.BRANCH)
        ),
        (_S.AUTOWARE_STATUS, _T.STATUS_MISSED): Transition(_S.AUTOWARE_END, (_A.REPORT_OLD_STATUS, _A.BRANCH)),
        (_S.AUTOWARE_STATUS, _T.STATUS_LOST): _LOST,
        (_S.AUTOWARE_END, _T.AUTOWARE): _TOP,
        (_S.AUTOWARE_END, _T.MANUAL): _MANUAL,
        (_S.AUTOWARE_END, _T.EMERGENCY): _EMERGENCY,
        (_S.MANUAL_STATUS, _T.STATUS): Transition(
            _S.MANUAL_PAUSE, (_A.FORGET_STATUS_MISSES, _A.REPORT_STATUS, _A.WAIT_PAUSE)
        ),
        (_S.MANUAL_STATUS, _T.STATUS_MISSED): Transition(_S.MANUAL_PAUSE, (_A.REPORT_OLD_STATUS, _A.WAIT_PAUSE)),
        (_S.MANUAL_STATUS, _T.STATUS_LOST): Transition(_S.MANUAL_PAUSE, (_A.CHANGE_MODE, _A.WAIT_PAUSE)),
        (_S.MANUAL_PAUSE, _T.PAUSE_OVER): Transition(_S.MANUAL_END, (_A.BRANCH,)),
        (_S.MANUAL_END, _T.MANUAL): _TOP,
        (_S.MANUAL_END, _T.EMERGENCY): _EMERGENCY,
        (_S.EMERGENCY_STATUS, _T.STATUS): Transition(
            _S.LOOP_TOP, (_A.FORGET_COMMAND_MISSES, _A.FORGET_STATUS_MISSES, _A.CHANGE_MODE, _A.LOOK)
        ),
        (_S.EMERGENCY_STATUS, _T.STATUS_MISSED): _TOP,
    }
)
"""How the control task goes through its loop.

(AUTOWARE_COMMAND, STATUS_LOST) is taken only where the simulator is watched while commands are missing (choice)."""

MODE_OF_STEP: Mapping[Trigger, ModeTrigger] = MappingProxyType(
    {
        _T.NO_AGENT: _MT.NO_AGENT,
        _T.COMMANDS_LOST: _MT.COMMANDS_LOST,
        _T.STATUS_LOST: _MT.STATUS_LOST,
        _T.STATUS: _MT.STATUS_RETURNS,
    }
)
"""What CHANGE_MODE means on an edge with this trigger."""

TIMER_STEPS: Mapping[Timer, frozenset[Step]] = MappingProxyType(
    {
        Timer.AGENT: frozenset((_S.STARTING,)),
        Timer.COMMAND: frozenset((_S.AUTOWARE_COMMAND,)),
        Timer.STATUS: frozenset((_S.AUTOWARE_STATUS, _S.MANUAL_STATUS, _S.EMERGENCY_STATUS)),
        Timer.PAUSE: frozenset((_S.MANUAL_PAUSE,)),
    }
)
"""The steps in which each timer runs; leaving these steps ends it."""


class LinkState(enum.Enum):
    """What the simulator knows of the board."""

    WAITING = "no command yet"
    LINKED = "commands come"
    SILENT = "no commands any more, the car was commanded to stop"


class LinkTrigger(enum.Enum):
    """What happens to the simulator."""

    COMMAND = "a sound command"
    SILENCE = "no sound command for too long"


class LinkAction(enum.Enum):
    """What the simulator does on an edge."""

    HAND_ON = "hand the command on to the car"
    FEED = "restart the wait for commands, where the options want one"
    STOP = "command the car to stop"


class LinkTimer(enum.Enum):
    """What the simulator waits for; where it runs out, the trigger that is named."""

    COMMANDS = "a command must come: SILENCE"


@dataclass(frozen=True, slots=True)
class LinkTransition:
    """An edge of the simulator's side."""

    next_state: LinkState
    actions: tuple[LinkAction, ...] = ()


LinkTable = Mapping[tuple[LinkState, LinkTrigger], LinkTransition]

LINK_TABLE: LinkTable = MappingProxyType(
    {
        **{
            (state, LinkTrigger.COMMAND): LinkTransition(LinkState.LINKED, (LinkAction.FEED, LinkAction.HAND_ON))
            for state in LinkState
        },
        (LinkState.LINKED, LinkTrigger.SILENCE): LinkTransition(LinkState.SILENT, (LinkAction.STOP,)),
    }
)
"""The simulator's side. That it watches the board at all is a choice: the bridge does not."""

LINK_TIMER_STATES: Mapping[LinkTimer, frozenset[LinkState]] = MappingProxyType(
    {LinkTimer.COMMANDS: frozenset((LinkState.LINKED,))}
)
"""The states in which the simulator's timer runs."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Deadline:
    """A figure of time.

    Attributes:
        name: of the option that has it.
        value_s: in the original, in s.
        misses: how many in a row until the mode changes; 1 for what happens once.
        text: what is waited for.
        on_miss: what happens then.
        source: where it is written.
    """

    name: str
    value_s: float
    misses: int
    text: str
    on_miss: str
    source: str


_HEADER = "microAutoware src/HIL taksControl.h"

DEADLINES: Mapping[str, Deadline] = MappingProxyType(
    {
        one.name: one
        for one in (
            Deadline(
                name="agent_wait_s",
                value_s=20.0,
                misses=1,
                text="the micro-ROS agent, at boot (20 pings, 1 s each)",
                on_miss="MANUAL instead of AUTOWARE",
                source="taksControl.c TIMEOUT_MICRO_ROS_AGENT, microAutoware.c rmw_uros_ping_agent(1000, 20)",
            ),
            Deadline(
                name="command_deadline_s",
                value_s=0.110,
                misses=10,
                text="a command of the driving stack, in AUTOWARE",
                on_miss="the frame before is sent again; at the tenth miss in a row MANUAL",
                source=f"{_HEADER} TIMEOUT_GET_CONTROL_ACTION, MAX_OF_LOST_MESSAGES",
            ),
            Deadline(
                name="status_deadline_s",
                value_s=0.100,
                misses=10,
                text="a status of the simulator, after each frame in every mode",
                on_miss="the old status is reported again; at the tenth miss in a row EMERGENCY",
                source=f"{_HEADER} TIMEOUT_GET_CARLA_RX, MAX_OF_LOST_MESSAGES",
            ),
            Deadline(
                name="manual_pause_s",
                value_s=0.060,
                misses=1,
                text="the pause at the end of each turn in MANUAL",
                on_miss="the next turn",
                source=f"{_HEADER} MANUAL_CONTROL_TIME_COMMAND",
            ),
            Deadline(
                name="debounce_s",
                value_s=1.0,
                misses=1,
                text="how long a press must lie behind the one before it, and behind the start",
                on_miss="a press before that is not seen",
                source=f"{_HEADER} DEBOUNCE_TICKS, taksControl.c HAL_GPIO_EXTI_Callback",
            ),
        )
    }
)
"""The board's figures of time, by option."""
