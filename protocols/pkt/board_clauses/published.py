"""What the published firmware does besides, and what was promised in its place."""

from __future__ import annotations

from protocols.pkt.board_clauses._common import DOCUMENTED, G2_ALONE, SUITE
from protocols.pkt.clause import CHOICE, DOCUMENT, G2, G2_IMU, G2_MOTORS, G2_PID, MANUAL, SERIAL, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="P44",
        suite=SUITE,
        level="must",
        title="The test LED toggles with each packet",
        text="LED_OFF, then 50 4B 54 21 01 7F 6E 88 0A twice: the LED is on after the first and off after the second.",
        sources=(f"{G2} handle_packet",),
        profiles=G2_ALONE,
        twin="P44D",
        needs=("server", "led"),
        by_hand=True,
    ),
    Clause(
        id="P44D",
        suite=SUITE,
        level="must",
        title="The test LED obeys its own commands",
        text="The LED is as LED_ON and LED_OFF have left it, whatever other packets come.",
        sources=(f"{MANUAL}, 0x01 and 0x02",),
        profiles=DOCUMENTED,
        needs=("server", "led"),
        by_hand=True,
    ),
    Clause(
        id="P45",
        suite=SUITE,
        level="must",
        title="The controller's sum grows at its limit",
        text=(
            "0x05 as the firmware reads it, for ki 1 and nothing else; 0x04 with 30 rpm and the wheels held for 3 s; "
            "then 0x04 with -30 rpm: the throttle is still above 0 half a second later."
        ),
        sources=(f"{G2_PID} process",),
        profiles=G2_ALONE,
        twin="P45D",
        needs=("server", "wheels"),
        by_hand=True,
    ),
    Clause(
        id="P45D",
        suite=SUITE,
        level="should",
        title="The controller's sum stands at its limit",
        text=(
            "0x05 with ki 1 alone; 0x04 with 30 rpm and the wheels held for 3 s; then 0x04 with -30 rpm: the throttle "
            "is below 0 half a second later."
        ),
        sources=(f"{MANUAL}, chapter on the PID controller: the output is limited", CHOICE + " what the sum does then"),
        profiles=DOCUMENTED,
        needs=("server", "wheels"),
        by_hand=True,
    ),
    Clause(
        id="P46",
        suite=SUITE,
        level="must",
        title="The controller's sum outlives its mode",
        text=(
            "With a sum of 0.6 gathered, 0x03 and then 0x04 with 30 rpm: the throttle is above 0.5 a quarter of a "
            "second later, wheels held."
        ),
        sources=(f"{G2_MOTORS} set_motor_throttles, set_motor_speed_setpoints",),
        profiles=G2_ALONE,
        twin="P46D",
        needs=("server", "wheels"),
        by_hand=True,
    ),
    Clause(
        id="P46D",
        suite=SUITE,
        level="should",
        title="The controller's sum begins with its mode",
        text=(
            "With a sum of 0.6 gathered, 0x03 and then 0x04 with 30 rpm: the throttle is 0.2 at most a quarter of a "
            "second later, wheels held."
        ),
        sources=(CHOICE + ": a motor that was stopped by hand should not begin with an old sum",),
        profiles=DOCUMENTED,
        needs=("server", "wheels"),
        by_hand=True,
    ),
    Clause(
        id="P47",
        suite=SUITE,
        level="must",
        title="A wheel that stops goes on for a second",
        text="Half a second after wheels at 0.3 of full throttle were stopped by hand, 0x83 shows above 50 rpm.",
        sources=("nhorro/ceai2020 at 6058e92, rover_firmware/sensors/tachometer/lm393_tachometer.cpp get_rpm",),
        profiles=G2_ALONE,
        twin="P47D",
        needs=("server", "wheels"),
    ),
    Clause(
        id="P47D",
        suite=SUITE,
        level="must",
        title="A wheel that stops is shown to stop",
        text="Half a second after wheels at 0.3 of full throttle were stopped by hand, 0x83 shows 15 rpm at most.",
        sources=(f"{MANUAL}, 0x83 and the chapter on tachometers", CHOICE + " how soon"),
        profiles=DOCUMENTED,
        needs=("server", "wheels"),
    ),
    Clause(
        id="P48",
        suite=SUITE,
        level="must",
        title="A full line is too much",
        text="LED_ON 100 times without a gap, at more than 3200 bytes/s: ACC is below 100.",
        sources=(f"{G2} read_telecommands: 32 bytes at most, 100 times a second",),
        profiles=G2_ALONE,
        twin="P48D",
        needs=("server",),
    ),
    Clause(
        id="P48D",
        suite=SUITE,
        level="must",
        title="A full line is not too much",
        text="LED_ON 100 times without a gap: 100/0/1/0.",
        sources=(f"{DOCUMENT}, 0x80: each packet counts", SERIAL),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
    Clause(
        id="P49",
        suite=SUITE,
        level="must",
        title="Nothing is said in the first second",
        text="Not a byte comes in the first 0.9 s after power-up.",
        sources=(f"{G2_IMU}/mpu9250.cpp: sleeps of 955 ms in all before the first tick",),
        profiles=G2_ALONE,
        twin="P49D",
        needs=("server", "boot"),
    ),
    Clause(
        id="P49D",
        suite=SUITE,
        level="should",
        title="The rover is there at once",
        text="REQUEST_TMY each 0.1 s from power-up on is answered within half a second.",
        sources=(CHOICE + ": a rover that was reset on its way has to hear soon that it should stop",),
        profiles=DOCUMENTED,
        needs=("server", "boot"),
    ),
)
