"""Speed control, with the wheels in somebody's hand, and the speeds that are shown."""

from __future__ import annotations

from protocols.pkt.board_clauses._common import BY_REPORT, DOCUMENTED, G2_ALONE, SUITE, V2
from protocols.pkt.clause import CHOICE, DOCUMENT, G2, G2_MOTORS, G2_PID, MANUAL, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="P26",
        suite=SUITE,
        level="must",
        title="The speed controller's first second",
        text=(
            "0x04 with 30 rpm for both, the wheels held: 0x83 shows a throttle of 0.3008 within 0.001 after 0.25 s, "
            "and setpoints of 30."
        ),
        sources=(f"{MANUAL}, chapter on the PID controller", f"{G2_PID} process", f"{G2_MOTORS} update"),
        profiles=V2,
        needs=("server", "wheels"),
        by_hand=True,
    ),
    Clause(
        id="P29",
        suite=SUITE,
        level="must",
        title="A fast wheel is shown as standing",
        text="Wheels faster than 155 rpm: 0x83 shows 0 rpm.",
        sources=(f"{G2} read_tachometers, MAX_TACHO_VALID_RPM_READING",),
        profiles=G2_ALONE,
        twin="P29D",
        needs=("server", "wheels"),
    ),
    Clause(
        id="P29D",
        suite=SUITE,
        level="must",
        title="A fast wheel is shown",
        text="Wheels faster than 155 rpm: 0x83 shows their speed, within 5 %.",
        sources=(f"{MANUAL}, 0x83 and the chapter on tachometers", CHOICE + " how exact"),
        profiles=DOCUMENTED,
        needs=("server", "wheels"),
    ),
    Clause(
        id="P38",
        suite=SUITE,
        level="must",
        title="The gains are read four bytes too late",
        text=(
            "LED_ON with 20 zeros behind it, which leaves zeros in the buffer, then 0x05 with kp 0, kd 0.01, ki 0 and "
            "0x04 with 30 rpm, wheels held: 0x83 shows throttles of 0.3 within 0.001 after 0.25 s, for the sent kd is "
            "taken for kp."
        ),
        sources=(f"{G2} config_pid_controller",),
        profiles=G2_ALONE,
        twin="P38D",
        needs=("server", "wheels"),
        by_hand=True,
    ),
    Clause(
        id="P38D",
        suite=SUITE,
        level="must",
        title="The gains are kp, kd, ki",
        text=(
            "0x05 with kp 0.02, kd 0, ki 0, then 0x04 with 30 rpm, wheels held: 0x83 shows throttles of 0.6 within "
            "0.001 after 0.25 s."
        ),
        sources=(f"{MANUAL}, 0x05 and the listing of config_pid_controller", f"{G2_PID} process"),
        profiles=DOCUMENTED,
        needs=("server", "wheels"),
        by_hand=True,
    ),
    Clause(
        id="P63",
        suite=SUITE,
        level="must",
        title="Setpoints are for the pairs that the flags name",
        text=(
            "0x04 with 30 and -20 rpm, the wheels held: 0x83 shows these setpoints, and throttles of 0.3 and -0.2 "
            "within 0.05. With flags 01, 10 and 10 rpm: A alone changes; with flags 00: none; with flags 02, 40 and 15 "
            "rpm: B alone; ACC + 1 each time."
        ),
        sources=(f"{DOCUMENT}, 0x03: flags", f"{MANUAL}, 0x04", f"{G2_MOTORS} set_motor_speed_setpoints"),
        profiles=V2,
        needs=("server", "wheels"),
        stand_ins=BY_REPORT,
        by_hand=True,
    ),
    Clause(
        id="P88",
        suite=SUITE,
        level="must",
        title="Throttles are what the gains make of the speeds",
        text=(
            "0x04 with 650 and 450 rpm. With ki 0.0007 alone the throttles rise from one 0x83 to the next by 0.0007 "
            "times what is missed, for as long, within 20 % and 0.02; with kp 0.001 alone those of each 0x83 are 0.001 "
            "times what one of the pair's speeds in it is below its setpoint, within 0.02."
        ),
        sources=(f"{MANUAL}, 0x05 and the listing of config_pid_controller", f"{G2_PID} process", CHOICE + " how near"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
)
