"""AUTOWARE: how commands are handed on, and what is sent where one is missing."""

from __future__ import annotations

from protocols.carla.board_clauses._common import ALL, HARDENED, SHIPPED, STACK, SUITE
from protocols.carla.clause import CHOICE, HEADER, MICRO_ROS, TASK, UTILS, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="VB01",
        suite=SUITE,
        level="must",
        title="A command is handed on",
        text=(
            "With the agent there, the command 0.5 rad, 0.1 rad/s, 5 m/s, 1 m/s^2, 0.2 m/s^3 and statuses at 20 Hz the "
            "board sends F1: 30 bytes, the last of them 00, steering and its rate times 1.2. So with -0.4 rad, "
            "0.25 rad/s, -2 m/s, -3 m/s^2, -0.5 m/s^3. It asks no further whether the agent is there."
        ),
        sources=(TASK, f"{UTILS} vGetStringFromControlAction"),
        profiles=ALL,
        needs=STACK,
    ),
    Clause(
        id="VB02",
        suite=SUITE,
        level="must",
        title="One command for each status",
        text="Commands at 30 Hz and statuses at 20 Hz for 3 s give 60 frames, 2 more or less, all of mode 1.",
        sources=(f"{TASK}: each command sent waits for a status",),
        profiles=ALL,
        needs=STACK,
    ),
    Clause(
        id="VB05",
        suite=SUITE,
        level="must",
        title="A command that moves is sent again",
        text=(
            "Commands stop, statuses go on: the frame before is sent again nine times, 110 ms apart; at the tenth miss "
            "in a row mode 4, 1.1 s after the wait began."
        ),
        sources=(f"{TASK}, {HEADER} TIMEOUT_GET_CONTROL_ACTION, MAX_OF_LOST_MESSAGES",),
        profiles=SHIPPED,
        twin="VB05H",
        needs=STACK,
    ),
    Clause(
        id="VB05H",
        suite=SUITE,
        level="must",
        title="What is sent without a command stops the car",
        text=(
            "Commands stop, statuses go on: nine frames of mode 1, 110 ms apart, with the steering of the last command "
            "and rate, speed, acceleration and jerk 0; at the tenth miss in a row mode 4, 1.1 s after the wait began. "
            "No frame later than 110 ms after the last command has a speed, forwards or in reverse; and so a second "
            "time."
        ),
        sources=(f"{HEADER} TIMEOUT_GET_CONTROL_ACTION, MAX_OF_LOST_MESSAGES", CHOICE),
        profiles=HARDENED,
        needs=STACK,
    ),
    Clause(
        id="VB06",
        suite=SUITE,
        level="must",
        title="Any command begins the count again",
        text="Nine misses, one command, nine misses, one command: the mode stays AUTOWARE.",
        sources=(f"{TASK}: ucNumberOfLostMessageCtlCmd = 0",),
        profiles=ALL,
        needs=STACK,
    ),
    Clause(
        id="VB30",
        suite=SUITE,
        level="must",
        title="Slow commands are filled up",
        text="Commands at 5 Hz for 3 s: each is followed by the same frame again after 110 ms; never MANUAL.",
        sources=(TASK,),
        profiles=SHIPPED,
        twin="VB30H",
        needs=STACK,
    ),
    Clause(
        id="VB30H",
        suite=SUITE,
        level="must",
        title="Between slow commands the car is stopped",
        text="Commands at 5 Hz for 3 s: each is followed by a frame with speed 0 after 110 ms; never MANUAL.",
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=STACK,
    ),
    Clause(
        id="VB41",
        suite=SUITE,
        level="must",
        title="A command without meaning is handed on",
        text="A command with a NaN as its speed is sent to the simulator as it is.",
        sources=(MICRO_ROS, TASK),
        profiles=SHIPPED,
        twin="VB41H",
        needs=STACK,
    ),
    Clause(
        id="VB41H",
        suite=SUITE,
        level="must",
        title="A command without meaning is none",
        text=(
            "Commands with a NaN as their speed, or with 1e30 m/s, at 30 Hz: none of them is sent, and MANUAL follows "
            "as without commands. Nor is one of them between sound commands that has a NaN, an infinity, or 101 % of "
            "the limit, + or -, in any field; one that has 99 % of it in each is sent."
        ),
        sources=(CHOICE + ": the limits are 150 m/s, 100 m/s^2, 1000 m/s^3, and times 1.2, 2.5 rad and 50 rad/s",),
        profiles=HARDENED,
        needs=STACK,
    ),
    Clause(
        id="VB44",
        suite=SUITE,
        level="must",
        title="Any status begins the count again",
        text="In AUTOWARE nine statuses missed, one status, nine missed, one status: the mode stays AUTOWARE.",
        sources=(f"{TASK}: the count of missed statuses begins again with each",),
        profiles=ALL,
        needs=STACK,
    ),
)
