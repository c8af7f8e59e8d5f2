"""What a vehicle-interface board must do: stimulus and required response, profile by profile.

F1 to F7 are the frames of vectors.py. "Status" is a frame like F4; "command" is what the driving stack commands, at 30
Hz where nothing is said, as are statuses at 20 Hz; a "miss" is a deadline without it, 110 ms for commands and 100 ms
for statuses. In every clause but VB04 a NUL stands behind each frame, and nothing else between frames. Times hold
within one tick, 1 ms, beside what the bench cannot tell apart. A clause whose id ends with H is the twin of one in
which shipped behaviour is a hazard.
"""

from __future__ import annotations

from protocols.carla.clause import (
    CALLBACKS,
    CHOICE,
    EXTI,
    HAL,
    HEADER,
    ISR,
    LINE,
    MICRO_ROS,
    REPORT,
    TASK,
    UTILS,
    V0,
    Clause,
)

__all__ = ["BOARD_CLAUSES"]

_SUITE = "vehicle-board"
_ALL = ("hardened", "v0", "v1")
_HARDENED = ("hardened",)
_SHIPPED = ("v0", "v1")
_NOT_V1 = ("hardened", "v0")
_V0 = ("v0",)
_V1 = ("v1",)
_STACK = ("board", "stack")
_STICK = ("board", "stack", "joystick")

BOARD_CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="VB01",
        suite=_SUITE,
        level="must",
        title="A command is handed on",
        text=(
            "With the agent there, the command 0.5 rad, 0.1 rad/s, 5 m/s, 1 m/s^2, 0.2 m/s^3 and statuses at 20 Hz the "
            "board sends F1: 30 bytes, the last of them 00, steering and its rate times 1.2. So with -0.4 rad, "
            "0.25 rad/s, -2 m/s, -3 m/s^2, -0.5 m/s^3."
        ),
        sources=(TASK, f"{UTILS} vGetStringFromControlAction"),
        profiles=_ALL,
        needs=_STACK,
    ),
    Clause(
        id="VB02",
        suite=_SUITE,
        level="must",
        title="One command for each status",
        text="Commands at 30 Hz and statuses at 20 Hz for 3 s give 60 frames, 2 more or less, all of mode 1.",
        sources=(f"{TASK}: each command sent waits for a status",),
        profiles=_ALL,
        needs=_STACK,
    ),
    Clause(
        id="VB03",
        suite=_SUITE,
        level="must",
        title="Without an agent MANUAL, after 20 s",
        text="Without an agent the first frame comes 20.0 s after the start and has mode 4.",
        sources=(f"{TASK}, TIMEOUT_MICRO_ROS_AGENT", f"{MICRO_ROS} rmw_uros_ping_agent(1000, 20)"),
        profiles=_ALL,
        needs=("board", "stack", "boot"),
    ),
    Clause(
        id="VB04",
        suite=_SUITE,
        level="must",
        title="Frames that nobody filled",
        text=(
            "With the agent there and no command, the board sends nine times 30 bytes of anything, 110 ms apart, then "
            "mode 4 from 1.1 s on."
        ),
        sources=(f"{TASK}: ucTxMsgToCarla has no value yet",),
        profiles=_SHIPPED,
        twin="VB04H",
        needs=("board", "stack", "boot"),
    ),
    Clause(
        id="VB04H",
        suite=_SUITE,
        level="must",
        title="Nothing before there is something to say",
        text="With the agent there and no command, the first frame comes 1.1 s after the agent and has mode 4.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=("board", "stack", "boot"),
    ),
    Clause(
        id="VB05",
        suite=_SUITE,
        level="must",
        title="A command that moves is sent again",
        text=(
            "Commands stop, statuses go on: the frame before is sent again nine times, 110 ms apart; at the tenth miss "
            "in a row mode 4, 1.1 s after the wait began."
        ),
        sources=(f"{TASK}, {HEADER} TIMEOUT_GET_CONTROL_ACTION, MAX_OF_LOST_MESSAGES",),
        profiles=_SHIPPED,
        twin="VB05H",
        needs=_STACK,
    ),
    Clause(
        id="VB05H",
        suite=_SUITE,
        level="must",
        title="What is sent without a command stops the car",
        text=(
            "Commands stop, statuses go on: nine frames of mode 1, 110 ms apart, with the steering of the last command "
            "and rate, speed, acceleration and jerk 0; at the tenth miss in a row mode 4, 1.1 s after the wait began. "
            "No frame later than 110 ms after the last command has a speed."
        ),
        sources=(f"{HEADER} TIMEOUT_GET_CONTROL_ACTION, MAX_OF_LOST_MESSAGES", CHOICE),
        profiles=_HARDENED,
        needs=_STACK,
    ),
    Clause(
        id="VB06",
        suite=_SUITE,
        level="must",
        title="Any command begins the count again",
        text="Nine misses, one command, nine misses, one command: the mode stays AUTOWARE.",
        sources=(f"{TASK}: ucNumberOfLostMessageCtlCmd = 0",),
        profiles=_ALL,
        needs=_STACK,
    ),
    Clause(
        id="VB07",
        suite=_SUITE,
        level="must",
        title="Ten statuses missed are an emergency",
        text=(
            "Statuses stop, commands go on: ten more frames of mode 1, 100 ms apart, then F3, 1.0 s after the first of "
            "them, and F3 every 100 ms."
        ),
        sources=(f"{TASK}, {HEADER} TIMEOUT_GET_CARLA_RX, MAX_OF_LOST_MESSAGES",),
        profiles=_ALL,
        needs=_STACK,
    ),
    Clause(
        id="VB08",
        suite=_SUITE,
        level="must",
        title="A status ends the emergency in MANUAL",
        text=(
            "In EMERGENCY one status comes: the next frame has mode 4, the control-mode report says 4, the green lamp "
            "is lit; never AUTOWARE at once."
        ),
        sources=(TASK,),
        profiles=_ALL,
        needs=("board", "stack", "lamps"),
    ),
    Clause(
        id="VB09",
        suite=_SUITE,
        level="must",
        title="From there a press leads back",
        text="After an emergency, in MANUAL, a press of the joystick leads to AUTOWARE: frames of mode 1.",
        sources=(TASK,),
        profiles=_ALL,
        needs=_STICK,
    ),
    Clause(
        id="VB10",
        suite=_SUITE,
        level="must",
        title="A press in EMERGENCY does nothing",
        text="A press in EMERGENCY: F3 goes on; the press is not remembered: a status leads to MANUAL and it stays so.",
        sources=(f"{TASK}: the flag is taken, no branch is for EMERGENCY",),
        profiles=_ALL,
        needs=_STICK,
    ),
    Clause(
        id="VB11",
        suite=_SUITE,
        level="must",
        title="The driving stack can order AUTOWARE in EMERGENCY",
        text=(
            "In EMERGENCY, without statuses, AUTOWARE is asked for: granted, frames of mode 1 for at least 1 s, "
            "then F3."
        ),
        sources=(f"{TASK}, {CALLBACKS}; not in the diagram of {REPORT}",),
        profiles=_SHIPPED,
        twin="VB11H",
        needs=_STACK,
    ),
    Clause(
        id="VB11H",
        suite=_SUITE,
        level="must",
        title="Nobody orders anything in EMERGENCY",
        text="In EMERGENCY AUTOWARE is asked for, and MANUAL: both are refused, F3 goes on.",
        sources=(f"{REPORT}, diagram of the modes: EMERGENCY ends by a status alone", CHOICE),
        profiles=_HARDENED,
        needs=_STACK,
    ),
    Clause(
        id="VB12",
        suite=_SUITE,
        level="must",
        title="Other modes are refused",
        text=(
            "In AUTOWARE and in MANUAL requests for the modes 0, 2, 3, 5, 6 and 255 are answered with success "
            "false, each once, that for the mode itself with true; nothing changes."
        ),
        sources=(CALLBACKS,),
        profiles=_ALL,
        needs=_STACK,
    ),
    Clause(
        id="VB13",
        suite=_SUITE,
        level="must",
        title="Two presses within a second are one",
        text="Two presses that are 0.5 s or 0.94 s apart change the mode once, two that are 1.1 s apart twice.",
        sources=(f"{EXTI}, DEBOUNCE_TICKS",),
        profiles=_ALL,
        needs=_STICK,
    ),
    Clause(
        id="VB14",
        suite=_SUITE,
        level="must",
        title="The first second is blind",
        text="A press within the first second after the start changes nothing.",
        sources=(f"{EXTI}: the press before counts from tick 0",),
        profiles=_ALL,
        needs=(*_STICK, "boot"),
    ),
    Clause(
        id="VB15",
        suite=_SUITE,
        level="must",
        title="The joystick at rest",
        text="In MANUAL with readings 33970 and 33580: S is -0.0, 00 00 00 80, V and A are 0.",
        sources=(f"{TASK}: -fJoyXAxis",),
        profiles=_ALL,
        needs=_STICK,
    ),
    Clause(
        id="VB16",
        suite=_SUITE,
        level="must",
        title="The dead band has its edges",
        text="In MANUAL with readings 34470 and 34080, and with 33470 and 33080, S, V and A are still 0.",
        sources=(f"{UTILS} fGetJoyPostition", f"{REPORT}, equation 1"),
        profiles=_ALL,
        needs=_STICK,
    ),
    Clause(
        id="VB17",
        suite=_SUITE,
        level="must",
        title="The joystick at its upper ends",
        text="In MANUAL with readings 65535 and 65535: S is -1, V is 1, A is 0.",
        sources=(f"{UTILS} fGetJoyPostition", TASK),
        profiles=_ALL,
        needs=_STICK,
    ),
    Clause(
        id="VB18",
        suite=_SUITE,
        level="must",
        title="The joystick at its lower ends",
        text="In MANUAL with readings 1057 and 1062: S is 1, V is 0, A is 1.",
        sources=(f"{UTILS} fGetJoyPostition", TASK),
        profiles=_ALL,
        needs=_STICK,
    ),
    Clause(
        id="VB19",
        suite=_SUITE,
        level="must",
        title="MANUAL at 20 Hz",
        text=(
            "In MANUAL with statuses at 20 Hz, each with other figures, a frame of mode 4 goes out every 60 ms and no "
            "other, and each time the newest status is reported to the driving stack."
        ),
        sources=(f"{V0}, taksControle.c", f"{HEADER} MANUAL_CONTROL_TIME_COMMAND"),
        profiles=_NOT_V1,
        needs=_STICK,
    ),
    Clause(
        id="VB20",
        suite=_SUITE,
        level="must",
        title="MANUAL at 10 Hz",
        text="In MANUAL with statuses at 10 Hz a frame of mode 4 goes out every 100 ms.",
        sources=(f"{V0}, taksControle.c",),
        profiles=_NOT_V1,
        needs=_STICK,
    ),
    Clause(
        id="VB21",
        suite=_SUITE,
        level="must",
        title="The emergency in MANUAL",
        text=(
            "In MANUAL, with the joystick at its upper ends, statuses stop: ten more frames, 160 ms apart, then F3, "
            "1.6 s after the first that no status followed, and F3 every 100 ms."
        ),
        sources=(f"{V0}, taksControle.c: each miss costs the wait and the pause",),
        profiles=_NOT_V1,
        needs=_STICK,
    ),
    Clause(
        id="VB22",
        suite=_SUITE,
        level="must",
        title="The false emergency of V1",
        text=(
            "In MANUAL with statuses at 20 Hz a frame of mode 4 goes out every 160 ms, one F3 every 1.6 s, and the "
            "status that the driving stack is told stands still."
        ),
        sources=(f"{TASK}, MANUAL block: osEventFlagsWait with UART_NEW_DATA_FLAG, which is a thread flag",),
        profiles=_V1,
        twin="VB19",
        needs=_STICK,
    ),
    Clause(
        id="VB23",
        suite=_SUITE,
        level="must",
        title="V1 loses the way from MANUAL to AUTOWARE",
        text=(
            "In MANUAL AUTOWARE is asked for while the control task waits for a status, which it does for 100 of 160 "
            "ms: granted, but commands are not handed on, and 1.1 s after the change MANUAL is back. In the "
            "other 60 ms it works."
        ),
        sources=(f"{TASK}, MANUAL block: bit 0b10 of the event group is MA_TO_AUTOWARE_MODE_FLAG",),
        profiles=_V1,
        twin="VB23H",
        needs=_STICK,
    ),
    Clause(
        id="VB23H",
        suite=_SUITE,
        level="must",
        title="The driving stack can order AUTOWARE in MANUAL",
        text=(
            "In MANUAL, with commands at 30 Hz, AUTOWARE is asked for: granted, frames of mode 1 from then on, for 3 s."
        ),
        sources=(CALLBACKS, TASK),
        profiles=_NOT_V1,
        needs=_STICK,
    ),
    Clause(
        id="VB24",
        suite=_SUITE,
        level="must",
        title="Delimiters within a float are data",
        text="F6 is accepted: the longitudinal speed reported is 0.641665 m/s, the other figures are its own, too.",
        sources=(f"{ISR}: data bytes are not looked at",),
        profiles=_ALL,
        needs=_STACK,
    ),
    Clause(
        id="VB25",
        suite=_SUITE,
        level="must",
        title="One stray byte is for ever",
        text=(
            "One byte, 00, then sound statuses at 20 Hz: none is accepted any more; EMERGENCY after 1.0 s, and still "
            "after 60 s."
        ),
        sources=(f"{ISR}: blocks of 22 bytes",),
        profiles=_SHIPPED,
        twin="VB25H",
        needs=_STACK,
    ),
    Clause(
        id="VB25H",
        suite=_SUITE,
        level="must",
        title="Stray bytes cost no status",
        text=(
            "1 to 30 bytes 00, each beginning and each end of a status, ##, #A#, 22 and 30 times #, each 10 ms before "
            "a sound status: it is accepted; the mode stays AUTOWARE."
        ),
        sources=(LINE, CHOICE),
        profiles=_HARDENED,
        needs=_STACK,
    ),
    Clause(
        id="VB26",
        suite=_SUITE,
        level="must",
        title="A frame may come in pieces",
        text="A status in two pieces of 10 and 12 bytes, 50 ms apart, is accepted: all its figures are reported.",
        sources=(ISR, LINE),
        profiles=_ALL,
        needs=_STACK,
    ),
    Clause(
        id="VB27",
        suite=_SUITE,
        level="must",
        title="Missing fields keep their old values",
        text="#, the field A, $ and 15 bytes 00 are accepted: A is new, the other fields are as before.",
        sources=(f"{ISR}: $ is the end, whatever came before",),
        profiles=_SHIPPED,
        twin="VB27H",
        needs=_STACK,
    ),
    Clause(
        id="VB27H",
        suite=_SUITE,
        level="must",
        title="A frame that lacks a field is none",
        text="#, the field A, $ and 15 bytes 00 are not accepted; nor is a status whose B is a second A.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_STACK,
    ),
    Clause(
        id="VB28",
        suite=_SUITE,
        level="must",
        title="22 times # is no status",
        text="22 bytes 23 are not accepted.",
        sources=(f"{ISR}: a second # ends the frame",),
        profiles=_ALL,
        needs=_STACK,
    ),
    Clause(
        id="VB29",
        suite=_SUITE,
        level="must",
        title="A NaN is handed on",
        text="A status with NaN in C is reported to the driving stack with its NaN.",
        sources=(ISR, MICRO_ROS),
        profiles=_SHIPPED,
        twin="VB29H",
        needs=_STACK,
    ),
    Clause(
        id="VB29H",
        suite=_SUITE,
        level="must",
        title="A NaN is no figure",
        text="A status with NaN or an infinity in any field is dropped: nothing of it is reported.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_STACK,
    ),
    Clause(
        id="VB30",
        suite=_SUITE,
        level="must",
        title="Slow commands are filled up",
        text="Commands at 5 Hz for 3 s: each is followed by the same frame again after 110 ms; never MANUAL.",
        sources=(TASK,),
        profiles=_SHIPPED,
        twin="VB30H",
        needs=_STACK,
    ),
    Clause(
        id="VB30H",
        suite=_SUITE,
        level="must",
        title="Between slow commands the car is stopped",
        text="Commands at 5 Hz for 3 s: each is followed by a frame with speed 0 after 110 ms; never MANUAL.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_STACK,
    ),
    Clause(
        id="VB31",
        suite=_SUITE,
        level="must",
        title="AUTOWARE without a driving stack",
        text=(
            "Without an agent, in MANUAL, a press lights the amber lamp; the joystick's last frame is sent again every "
            "110 ms, whatever the joystick does, until MANUAL is back 1.1 s later."
        ),
        sources=(TASK,),
        profiles=_SHIPPED,
        twin="VB31H",
        needs=(*_STICK, "lamps", "boot"),
    ),
    Clause(
        id="VB31H",
        suite=_SUITE,
        level="must",
        title="No AUTOWARE without a driving stack",
        text=(
            "Without an agent, in MANUAL, a press changes nothing: the green lamp stays lit, frames go on every 60 ms."
        ),
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=(*_STICK, "lamps", "boot"),
    ),
    Clause(
        id="VB32",
        suite=_SUITE,
        level="must",
        title="An old status is reported as if it were new",
        text="Statuses stop in AUTOWARE: the last one is reported to the driving stack again at each miss.",
        sources=(f"{TASK}: VEHICLE_NEW_DATA_FLAG at osFlagsErrorTimeout",),
        profiles=_SHIPPED,
        twin="VB32H",
        needs=_STACK,
    ),
    Clause(
        id="VB32H",
        suite=_SUITE,
        level="must",
        title="No status, no report",
        text="Statuses stop in AUTOWARE: nothing more is reported to the driving stack but the mode.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_STACK,
    ),
    Clause(
        id="VB33",
        suite=_SUITE,
        level="must",
        title="Without commands nobody watches the simulator",
        text=(
            "Commands and statuses stop at once, in AUTOWARE: the last frame again for 1.1 s, MANUAL, and F3 "
            "some 2.7 s after both stopped."
        ),
        sources=(f"{TASK}: the status is waited for behind a command only",),
        profiles=_V0,
        twin="VB33H",
        needs=_STACK,
    ),
    Clause(
        id="VB33H",
        suite=_SUITE,
        level="must",
        title="The simulator is watched without commands, too",
        text="Commands and statuses stop at once, in AUTOWARE: F3 within 1.3 s after both stopped.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_STACK,
    ),
    Clause(
        id="VB34",
        suite=_SUITE,
        level="must",
        title="Beyond the calibration is beyond one",
        text="In MANUAL with readings 0 and 0: S and A are 1.0326 and 1.0327, a thirtieth too much.",
        sources=(f"{UTILS} fGetJoyPostition: no clamp",),
        profiles=_SHIPPED,
        twin="VB34H",
        needs=_STICK,
    ),
    Clause(
        id="VB34H",
        suite=_SUITE,
        level="must",
        title="The joystick ends at one",
        text="In MANUAL with readings 0 and 0: S and A are 1.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_STICK,
    ),
    Clause(
        id="VB35",
        suite=_SUITE,
        level="must",
        title="Damaged figures are believed",
        text="A status whose longitudinal speed is 1e30 m/s, a turned bit, is reported to the driving stack.",
        sources=(f"{ISR}: no checksum, no limits",),
        profiles=_SHIPPED,
        twin="VB35H",
        needs=_STACK,
    ),
    Clause(
        id="VB35H",
        suite=_SUITE,
        level="must",
        title="What cannot be is dropped",
        text="A status with 1e30 or -1e30 in any field is dropped: nothing of it is reported.",
        sources=(CHOICE + ": 150 m/s is the limit of the speeds",),
        profiles=_HARDENED,
        needs=_STACK,
    ),
    Clause(
        id="VB36",
        suite=_SUITE,
        level="must",
        title="EMERGENCY is kept from the driving stack",
        text="From AUTOWARE to EMERGENCY the control-mode report goes on saying 1.",
        sources=(f"{V0}, microAutoware.c: the flag is not in the mask",),
        profiles=_V0,
        twin="VB36H",
        needs=_STACK,
    ),
    Clause(
        id="VB36H",
        suite=_SUITE,
        level="must",
        title="EMERGENCY is reported",
        text="In EMERGENCY the control-mode report says 6, NOT_READY.",
        sources=("autoware_auto_vehicle_msgs, ControlModeReport", CHOICE),
        profiles=_HARDENED,
        needs=_STACK,
    ),
    Clause(
        id="VB37",
        suite=_SUITE,
        level="must",
        title="EMERGENCY is reported as MANUAL",
        text="In EMERGENCY the control-mode report says 4.",
        sources=(f"{MICRO_ROS}: MA_TO_EMERGENCY_MODE_FLAG",),
        profiles=_V1,
        twin="VB36H",
        needs=_STACK,
    ),
    Clause(
        id="VB38",
        suite=_SUITE,
        level="must",
        title="The joystick's values as a command",
        text=(
            "AUTOWARE, statuses stop until EMERGENCY and come back, a press in MANUAL: the first frame behind "
            "the amber lamp has mode 4 and the joystick's values, for a command has been waiting where they were "
            "written."
        ),
        sources=(f"{TASK}: xControlAction is one structure, AUTOWARE_NEW_DATA_FLAG outlives the mode",),
        profiles=_SHIPPED,
        twin="VB38H",
        needs=(*_STICK, "lamps"),
    ),
    Clause(
        id="VB38H",
        suite=_SUITE,
        level="must",
        title="AUTOWARE begins with a command",
        text=(
            "AUTOWARE, statuses stop until EMERGENCY and come back, a press in MANUAL: the first frame behind "
            "the amber lamp has mode 1 and the values of a command that came after the press."
        ),
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=(*_STICK, "lamps"),
    ),
    Clause(
        id="VB39",
        suite=_SUITE,
        level="should",
        title="A line error ends reception",
        text="One framing error, then sound statuses: none is accepted any more; EMERGENCY after 1.0 s, and it stays.",
        sources=(HAL, f"{ISR}: there is no HAL_UART_ErrorCallback"),
        profiles=_SHIPPED,
        twin="VB39H",
        needs=("board", "stack", "line errors"),
    ),
    Clause(
        id="VB39H",
        suite=_SUITE,
        level="must",
        title="A line error costs a status",
        text="One framing error, then sound statuses: the second of them is accepted at the latest.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=("board", "stack", "line errors"),
    ),
    Clause(
        id="VB40",
        suite=_SUITE,
        level="must",
        title="Of two requests AUTOWARE is taken",
        text="In AUTOWARE both modes are asked for within 1 ms, MANUAL last: the mode stays AUTOWARE.",
        sources=(f"{TASK}: the branch for both comes last",),
        profiles=_SHIPPED,
        twin="VB40H",
        needs=_STACK,
    ),
    Clause(
        id="VB40H",
        suite=_SUITE,
        level="must",
        title="Of two requests MANUAL is taken",
        text="In AUTOWARE both modes are asked for within 1 ms, in either order: the mode is MANUAL.",
        sources=(f"{TASK}: what the branch for both says, which cannot be reached",),
        profiles=_HARDENED,
        needs=_STACK,
    ),
    Clause(
        id="VB41",
        suite=_SUITE,
        level="must",
        title="A command without meaning is handed on",
        text="A command with a NaN as its speed is sent to the simulator as it is.",
        sources=(MICRO_ROS, TASK),
        profiles=_SHIPPED,
        twin="VB41H",
        needs=_STACK,
    ),
    Clause(
        id="VB41H",
        suite=_SUITE,
        level="must",
        title="A command without meaning is none",
        text=(
            "Commands with a NaN as their speed, or with 1e30 m/s, at 30 Hz: none of them is sent, and MANUAL follows "
            "as without commands. Nor is one of them between sound commands that has a NaN, an infinity, 1e30 or "
            "-1e30 in any field."
        ),
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_STACK,
    ),
    Clause(
        id="VB42",
        suite=_SUITE,
        level="must",
        title="An agent that comes late is not heard",
        text="The agent comes 25 s after the start: no report, no answer to a request; MANUAL stays.",
        sources=(f"{MICRO_ROS}: the session is made at boot alone", f"{REPORT}, known problems"),
        profiles=_SHIPPED,
        twin="VB42H",
        needs=("board", "stack", "boot"),
    ),
    Clause(
        id="VB42H",
        suite=_SUITE,
        level="must",
        title="An agent may come late",
        text=(
            "The agent comes 25 s after the start: the mode is reported, a request for AUTOWARE is granted and obeyed."
        ),
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=("board", "stack", "boot"),
    ),
    Clause(
        id="VB43",
        suite=_SUITE,
        level="must",
        title="Turn indicators and hazard lights",
        text=(
            "Turn indicators left, right, off, then hazard lights: the left lamp blinks, the right one, none, both; "
            "with each status the driving stack is told so. A command of NO_COMMAND changes nothing."
        ),
        sources=(f"{REPORT}: lights and indicators are required", CHOICE),
        profiles=_HARDENED,
        needs=("board", "stack", "indicators"),
    ),
    Clause(
        id="VB44",
        suite=_SUITE,
        level="must",
        title="Any status begins the count again",
        text="In AUTOWARE nine statuses missed, one status, nine missed, one status: the mode stays AUTOWARE.",
        sources=(f"{TASK}: the count of missed statuses begins again with each",),
        profiles=_ALL,
        needs=_STACK,
    ),
    Clause(
        id="VB45",
        suite=_SUITE,
        level="must",
        title="Any status begins the count again in MANUAL",
        text="In MANUAL nine statuses missed, one status, nine missed, one status: the mode stays MANUAL.",
        sources=(f"{V0}, taksControle.c",),
        profiles=_NOT_V1,
        needs=_STACK,
    ),
    Clause(
        id="VB46",
        suite=_SUITE,
        level="must",
        title="The joystick between its ends",
        text=(
            "In MANUAL with readings at a quarter, a half and three quarters of the way to each end, and one step "
            "beyond the dead band, S, V and A are what the calibration says: at 34471 S is -1/31065."
        ),
        sources=(f"{UTILS} fGetJoyPostition", f"{REPORT}, equation 1"),
        profiles=_ALL,
        needs=_STICK,
    ),
    Clause(
        id="VB47",
        suite=_SUITE,
        level="must",
        title="Half a status is given up",
        text="A status in two pieces, 0.15 s apart, is not accepted, wherever it is cut; the next one is.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_STACK,
    ),
    Clause(
        id="VB48",
        suite=_SUITE,
        level="must",
        title="The mode is reported",
        text="In AUTOWARE the control-mode report says 1, in MANUAL 4, and no other, 20 times in 2 s, 2 more or less.",
        sources=(MICRO_ROS, f"{CHOICE}: every 100 ms"),
        profiles=_ALL,
        needs=_STACK,
    ),
    Clause(
        id="VB49",
        suite=_SUITE,
        level="must",
        title="Reports are stamped",
        text="The clock is told, twice: reports of mode, velocity and steering have the latest as their stamp.",
        sources=(MICRO_ROS,),
        profiles=_ALL,
        needs=_STACK,
    ),
)
