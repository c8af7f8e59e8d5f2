"""Who may change the mode: requests of the driving stack, presses of the joystick."""

from __future__ import annotations

from protocols.carla.board_clauses._common import ALL, HARDENED, NOT_V1, SHIPPED, STACK, STICK, SUITE, V1_ALONE
from protocols.carla.clause import CALLBACKS, CHOICE, EXTI, TASK, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="VB12",
        suite=SUITE,
        level="must",
        title="Other modes are refused",
        text=(
            "In AUTOWARE and in MANUAL requests for the modes 0, 2, 3, 5, 6 and 255 are answered with success "
            "false, each once, that for the mode itself with true; nothing changes."
        ),
        sources=(CALLBACKS,),
        profiles=ALL,
        needs=STACK,
    ),
    Clause(
        id="VB13",
        suite=SUITE,
        level="must",
        title="Two presses within a second are one",
        text="Two presses that are 0.5 s or 0.99 s apart change the mode once, two that are 1.01 s apart twice.",
        sources=(f"{EXTI}, DEBOUNCE_TICKS",),
        profiles=ALL,
        needs=STICK,
    ),
    Clause(
        id="VB23",
        suite=SUITE,
        level="must",
        title="V1 loses the way from MANUAL to AUTOWARE",
        text=(
            "In MANUAL AUTOWARE is asked for while the control task waits for a status, which it does for 100 of 160 "
            "ms: granted, but commands are not handed on, and 1.1 s after the change MANUAL is back. In the "
            "other 60 ms it works."
        ),
        sources=(f"{TASK}, MANUAL block: bit 0b10 of the event group is MA_TO_AUTOWARE_MODE_FLAG",),
        profiles=V1_ALONE,
        twin="VB23H",
        needs=STACK,
    ),
    Clause(
        id="VB23H",
        suite=SUITE,
        level="must",
        title="The driving stack can order AUTOWARE in MANUAL",
        text=(
            "In MANUAL, with commands at 30 Hz, AUTOWARE is asked for: granted, frames of mode 1 from then on, for 3 s."
        ),
        sources=(CALLBACKS, TASK),
        profiles=NOT_V1,
        needs=STACK,
    ),
    Clause(
        id="VB31",
        suite=SUITE,
        level="must",
        title="AUTOWARE without a driving stack",
        text=(
            "Without an agent, in MANUAL, a press lights the amber lamp; the joystick's last frame is sent again every "
            "110 ms, whatever the joystick does, until MANUAL is back 1.1 s later."
        ),
        sources=(TASK,),
        profiles=SHIPPED,
        twin="VB31H",
        needs=(*STICK, "lamps", "boot"),
    ),
    Clause(
        id="VB31H",
        suite=SUITE,
        level="must",
        title="No AUTOWARE without a driving stack",
        text=(
            "Without an agent, in MANUAL, a press changes nothing: the green lamp stays lit, frames go on every 60 ms."
        ),
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=(*STICK, "lamps", "boot"),
    ),
    Clause(
        id="VB38",
        suite=SUITE,
        level="must",
        title="The joystick's values as a command",
        text=(
            "AUTOWARE, statuses stop until EMERGENCY and come back, a press in MANUAL: the first frame behind "
            "the amber lamp has mode 4 and the joystick's values, for a command has been waiting where they were "
            "written."
        ),
        sources=(f"{TASK}: xControlAction is one structure, AUTOWARE_NEW_DATA_FLAG outlives the mode",),
        profiles=SHIPPED,
        twin="VB38H",
        needs=(*STICK, "lamps"),
    ),
    Clause(
        id="VB38H",
        suite=SUITE,
        level="must",
        title="AUTOWARE begins with a command",
        text=(
            "AUTOWARE, statuses stop until EMERGENCY and come back, in MANUAL the driving stack commands something "
            "else, a press: the first frame behind the amber lamp has mode 1 and the values of a command that came "
            "after the press."
        ),
        sources=(CHOICE,),
        profiles=HARDENED,
        needs=(*STICK, "lamps"),
    ),
    Clause(
        id="VB40",
        suite=SUITE,
        level="must",
        title="Of two requests AUTOWARE is taken",
        text="In AUTOWARE both modes are asked for within 1 ms, MANUAL last: the mode stays AUTOWARE.",
        sources=(f"{TASK}: the branch for both comes last",),
        profiles=SHIPPED,
        twin="VB40H",
        needs=STACK,
    ),
    Clause(
        id="VB40H",
        suite=SUITE,
        level="must",
        title="Of two requests MANUAL is taken",
        text="In AUTOWARE both modes are asked for within 1 ms, in either order: the mode is MANUAL.",
        sources=(f"{TASK}: what the branch for both says, which cannot be reached",),
        profiles=HARDENED,
        needs=STACK,
    ),
    Clause(
        id="VB51",
        suite=SUITE,
        level="must",
        title="The switch acts when it is let go of",
        text=(
            "In AUTOWARE the switch is closed by a wire, which does not bounce: nothing changes for 1.5 s; as it "
            "opens, MANUAL."
        ),
        sources=(f"{EXTI}: the rising edge, with a pull-up",),
        profiles=ALL,
        needs=STICK,
    ),
)
