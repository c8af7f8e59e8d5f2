"""Named sets of options, what was shipped and what we make of it, and the single quirks between them.

Sources: see options.py. What is called a choice there is one here too.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType
from typing import Any

from protocols.carla.errors import LocalProtocolError
from protocols.carla.options import (
    BoardOptions,
    BoardReader,
    EmergencyReport,
    MissedCommand,
    SimulatorOptions,
    SimulatorReader,
)

__all__ = ["PROFILES", "QUIRKS", "Profile", "Quirk", "with_quirks"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Profile:
    """What both ends do.

    Attributes:
        name: as in the catalogue of clauses.
        text: what it is.
        board: the board's end.
        simulator: the simulator's end that goes with it.
    """

    name: str
    text: str
    board: BoardOptions = field(default_factory=BoardOptions)
    simulator: SimulatorOptions = field(default_factory=SimulatorOptions)


@dataclass(frozen=True, slots=True, kw_only=True)
class Quirk:
    """One thing that the originals do and the hardened profile does not.

    Attributes:
        name: H1 to H9 and V1, and more of our own finding.
        text: what it does.
        source: where it is written.
        board: the board's options that make it.
        simulator: the simulator's.
    """

    name: str
    text: str
    source: str
    board: Mapping[str, Any] = field(default_factory=dict)
    simulator: Mapping[str, Any] = field(default_factory=dict)


_V0_BOARD = BoardOptions(
    reader=BoardReader.BLOCKS,
    frame_timeout_s=None,
    finite_only=False,
    status_limits=None,
    command_limits=None,
    dies_on_line_error=True,
    missed_command=MissedCommand.AGAIN,
    uninitialised=True,
    shared_action=True,
    fresh_only=False,
    watch_while_waiting=False,
    requests_in_emergency=True,
    both_to_manual=False,
    republish_stale=True,
    own_mode=True,
    emergency_report=EmergencyReport.KEPT,
    late_agent=False,
    agent_silence_s=None,
    clamp_joystick=False,
)
_BRIDGE = SimulatorOptions(
    reader=SimulatorReader.POLL,
    idle_block_s=0.5,
    icrnl=True,
    frame_timeout_s=None,
    finite_only=False,
    limits=None,
    clamp_manual=False,
    silence_s=None,
    forget_mode=True,
)

_HARDENED = Profile(
    name="hardened",
    text=(
        "Ours: the frames, modes and deadlines of the original; frames are found again within two, what is damaged, "
        "stale or impossible is dropped and counted, nothing stale moves the car, the driving stack is watched."
    ),
)
_V0 = Profile(
    name="v0",
    text="The board's firmware of 27 November 2024, toffanetto/im420x, and the bridge of carla_serial_bridge.",
    board=_V0_BOARD,
    simulator=_BRIDGE,
)
_V1 = Profile(
    name="v1",
    text="The board's firmware of 22 January 2025, LMA-FEM-UNICAMP/microAutoware, and the same bridge.",
    board=replace(_V0_BOARD, flag_clash=True, emergency_report=EmergencyReport.MANUAL),
    simulator=_BRIDGE,
)

PROFILES: Mapping[str, Profile] = MappingProxyType({profile.name: profile for profile in (_HARDENED, _V0, _V1)})
"""All profiles by name."""

_TASK = "microAutoware taksControl.c"
_NODE = "carla_serial_bridge_node.cpp"
_ANYTHING = {"finite_only": False}

QUIRKS: Mapping[str, Quirk] = MappingProxyType(
    {
        quirk.name: quirk
        for quirk in (
            Quirk(
                name="H1",
                text="no checksum, and no look at the values: what a damaged frame says is believed",
                source=f"{_TASK} HAL_UART_RxCpltCallback, {_NODE} timer_callback",
                board={**_ANYTHING, "status_limits": None, "command_limits": None},
                simulator={**_ANYTHING, "limits": None, "clamp_manual": False},
            ),
            Quirk(
                name="H2",
                text="the board never finds its frames again after a stray or lost byte",
                source=f"{_TASK} HAL_UART_RxCpltCallback: blocks of 22 bytes",
                board={"reader": BoardReader.BLOCKS},
            ),
            Quirk(
                name="H3",
                text="torn and repeated frames on the simulator's side",
                source=f"{_NODE} timer_callback, serial_com.hpp readSerialPort: the buffer keeps its old content",
                simulator={"reader": SimulatorReader.POLL, "forget_mode": True},
            ),
            Quirk(
                name="H4",
                text="a carriage return is read as a newline",
                source="serial_com.hpp: ICRNL is not cleared",
                simulator={"icrnl": True},
            ),
            Quirk(
                name="H5",
                text="a quiet line blocks the simulator's side for half a second, with what it has to send",
                source="serial_com.hpp: VMIN 0, VTIME 5, in the one thread of the node",
                simulator={"idle_block_s": 0.5},
            ),
            Quirk(
                name="H6",
                text="the same field in another unit, mode by mode: a command that waited is sent as the joystick's",
                source=f"{_TASK} StartTaskControl: xControlAction is one structure for both modes",
                board={"shared_action": True, "own_mode": True},
            ),
            Quirk(
                name="H7",
                text="a moving command is sent again for up to 1.1 s after the driving stack fell silent",
                source=f"{_TASK} StartTaskControl: the branch of osFlagsErrorTimeout in AUTOWARE",
                board={"missed_command": MissedCommand.AGAIN},
            ),
            Quirk(
                name="H8",
                text="up to nine frames of whatever was in memory after boot",
                source=f"{_TASK} StartTaskControl: ucTxMsgToCarla is not initialised",
                board={"uninitialised": True},
            ),
            Quirk(
                name="H9",
                text="the loss of the driving stack is noticed by missing commands alone, and it is not found again",
                source="microAutoware.c: rmw_uros_ping_agent at boot alone, the watchdog timer is commented out",
                board={"late_agent": False, "agent_silence_s": None},
            ),
            Quirk(
                name="V1",
                text="in MANUAL the status is waited for at the wrong flag: a false EMERGENCY every 1.6 s",
                source=f"{_TASK} StartTaskControl: osEventFlagsWait with UART_NEW_DATA_FLAG in the MANUAL block",
                board={"flag_clash": True, "own_mode": True, "republish_stale": True},
            ),
            Quirk(
                name="stale-status",
                text="at a missed status the old one is reported again, as if it were new",
                source=f"{_TASK} StartTaskControl: VEHICLE_NEW_DATA_FLAG in the branches of osFlagsErrorTimeout",
                board={"republish_stale": True},
            ),
            Quirk(
                name="unwatched",
                text="while commands are missing in AUTOWARE the simulator is not watched, and its statuses wait",
                source=f"{_TASK} StartTaskControl: the status is waited for behind a command only",
                board={"watch_while_waiting": False, "fresh_only": False},
            ),
            Quirk(
                name="emergency-requests",
                text="the driving stack can order AUTOWARE in EMERGENCY, and drives for a second without a status",
                source=f"{_TASK} StartTaskControl: the request is taken in any mode",
                board={"requests_in_emergency": True},
            ),
            Quirk(
                name="both-autoware",
                text="of two requests at once AUTOWARE is taken",
                source=f"{_TASK} StartTaskControl: the branch for both comes last",
                board={"both_to_manual": False},
            ),
            Quirk(
                name="emergency-manual",
                text="EMERGENCY is reported to the driving stack as MANUAL",
                source="microAutoware.c: MA_TO_EMERGENCY_MODE_FLAG",
                board={"emergency_report": EmergencyReport.MANUAL},
            ),
            Quirk(
                name="emergency-kept",
                text="EMERGENCY is not reported to the driving stack, which goes on commanding",
                source="V0 microAutoware.c: the flag is not in the mask",
                board={"emergency_report": EmergencyReport.KEPT, "own_mode": True},
            ),
            Quirk(
                name="no-clamp",
                text="joystick readings beyond the calibration give more than 1",
                source="microAutoware utils.c fGetJoyPostition",
                board={"clamp_joystick": False},
            ),
            Quirk(
                name="dies-on-error",
                text="an overrun or framing error ends reception until reset",
                source=f"{_TASK}: no HAL_UART_ErrorCallback; from reading, not measured",
                board={"dies_on_line_error": True},
            ),
        )
    }
)
"""All quirks by name; each is made by options on top of `hardened`."""


def with_quirks(profile: Profile, names: Iterable[str]) -> Profile:
    """The profile with single quirks put into it.

    Raises:
        LocalProtocolError: there is no quirk of that name.
    """
    for name in names:
        if name not in QUIRKS:
            raise LocalProtocolError(f"no quirk {name!r}; there are {', '.join(QUIRKS)}")
        quirk = QUIRKS[name]
        profile = replace(
            profile,
            board=replace(profile.board, **quirk.board),
            simulator=replace(profile.simulator, **quirk.simulator),
        )
    return profile
