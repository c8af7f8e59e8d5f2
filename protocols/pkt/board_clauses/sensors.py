"""What the rover says of its sensors."""

from __future__ import annotations

from protocols.pkt.board_clauses._common import BY_REPORT, DOCUMENTED, G2_ALONE, SUITE
from protocols.pkt.clause import CHOICE, G2, G2_IMU, G2_MEDIAN, MANUAL, Clause

CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="P39",
        suite=SUITE,
        level="must",
        title="A stale byte in the position",
        text="Byte 1 of 0x84 is byte 1 of the report before it: in the tick of both, the validity of 0x82.",
        sources=(f"{G2} send_gps_report",),
        profiles=G2_ALONE,
        twin="P39D",
        needs=("server",),
    ),
    Clause(
        id="P39D",
        suite=SUITE,
        level="should",
        title="Byte 1 of the position is its own",
        text="Byte 1 of 0x84 does not depend on what was reported before.",
        sources=(f"{MANUAL}, 0x84: reserved", "nhorro/ceai2020 at c47f7b4, application.cpp send_gps_report: validity"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
    Clause(
        id="P40",
        suite=SUITE,
        level="must",
        title="No position",
        text="Both floats of 0x84 are 0, wherever the rover is.",
        sources=(f"{G2} read_gps: commented out",),
        profiles=G2_ALONE,
        twin="P40D",
        needs=("server", "gps"),
    ),
    Clause(
        id="P40D",
        suite=SUITE,
        level="must",
        title="The position is latitude, longitude",
        text="With a fix, 0x84 has the latitude in bytes 4 to 7 and the longitude in 8 to 11, north and east positive.",
        sources=(f"{MANUAL}, 0x84",),
        profiles=DOCUMENTED,
        needs=("server", "gps"),
        by_hand=True,
    ),
    Clause(
        id="P41",
        suite=SUITE,
        level="must",
        title="Acceleration in g",
        text="At rest the three accelerations of 0x82 have a magnitude of 1 within 0.1.",
        sources=(f"{G2_IMU}/mpu9250.cpp",),
        profiles=G2_ALONE,
        twin="P41D",
        needs=("server", "imu"),
    ),
    Clause(
        id="P41D",
        suite=SUITE,
        level="must",
        title="Acceleration in m/s^2",
        text="At rest the three accelerations of 0x82 have a magnitude of 9.8 within 1.",
        sources=(f"{MANUAL}, 0x82",),
        profiles=DOCUMENTED,
        needs=("server", "imu"),
        stand_ins=BY_REPORT,
    ),
    Clause(
        id="P42",
        suite=SUITE,
        level="must",
        title="The quaternion begins with its scalar",
        text="Level and at rest, towards magnetic north, bytes 44 to 47 of 0x82 hold the component near 1 or -1.",
        sources=(f"{G2_IMU}/madwick.cpp", f"{G2} read_imu"),
        profiles=G2_ALONE,
        twin="P42D",
        needs=("server", "imu"),
        by_hand=True,
    ),
    Clause(
        id="P42D",
        suite=SUITE,
        level="must",
        title="The quaternion ends with its scalar",
        text="Level and at rest, towards magnetic north, bytes 56 to 59 of 0x82 hold the component near 1 or -1.",
        sources=(f"{MANUAL}, 0x82",),
        profiles=DOCUMENTED,
        needs=("server", "imu"),
        by_hand=True,
    ),
    Clause(
        id="P43",
        suite=SUITE,
        level="must",
        title="Wheels seem to turn at power-up",
        text="The first 0x83 after power-up shows 1.0 rpm for all four wheels at rest.",
        sources=(f"{G2_MEDIAN}: the window of three begins as 0, 1, 2",),
        profiles=G2_ALONE,
        twin="P43D",
        needs=("server", "boot"),
        by_hand=True,
    ),
    Clause(
        id="P43D",
        suite=SUITE,
        level="must",
        title="Wheels at rest are at rest",
        text="With the wheels at rest, no 0x83 after power-up shows another speed or count than 0.",
        sources=(f"{MANUAL}, 0x83",),
        profiles=DOCUMENTED,
        needs=("server", "boot"),
        by_hand=True,
    ),
    Clause(
        id="P83",
        suite=SUITE,
        level="must",
        title="The counts follow the speeds",
        text=(
            "Throttles of 0.26 and 0.35: in 2 s the count of each wheel rises by 20 for each turn that its speeds in "
            "0x83 stand for, which are from 0 to 1000 rpm, within 3 and 15 %. From one 0x83 to the next a wheel whose "
            "speed is 0 in both counts no more than 3, and one that counts 4 before a 0x83 and behind it has a speed "
            "in it. 2.5 s behind throttles of 0 wheels that count nothing in six 0x83 have speeds of 0 in the last."
        ),
        sources=(f"{MANUAL}, 0x83 and the tachometers: 20 slots", CHOICE + " how near"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
    Clause(
        id="P84",
        suite=SUITE,
        level="must",
        title="0x82 has figures that its sensor can have",
        text=(
            "Accelerations within 2 g, rates within 250 deg/s, the field within 4912 uT, the temperature from -40 to "
            "85 C, and 0 or 1e-9 C at least; the quaternion has the length 1 within 0.001. Where bit 0 of its byte 1 "
            "says that it was read, AHRS_FAIL is not set in the STATUS of the next 0x80."
        ),
        sources=(
            f"{G2_IMU}/mpu9250.cpp: full scales",
            "PS-MPU-9250A-01, section 3.4.2",
            "a rotation is a quaternion of length 1",
            f"{G2} send_imu_report: validity",
        ),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
    Clause(
        id="P86",
        suite=SUITE,
        level="must",
        title="0x82 has what its sensor senses",
        text=(
            "A 0x82 has the acceleration in m/s^2, the rate in deg/s, the field in mG, the temperature in C and the "
            "attitude, scalar last, that its sensor has sensed since the 0x82 before, as floats of 32 bits, and bits 0 "
            "and 1 of its byte 1 are set."
        ),
        sources=(f"{MANUAL}, 0x82", f"{G2} send_imu_report: validity", CHOICE + " how near"),
        profiles=DOCUMENTED,
        needs=("server", "sensed"),
    ),
    Clause(
        id="P87",
        suite=SUITE,
        level="must",
        title="0x84 has where its receiver is",
        text=(
            "A 0x84 has the latitude and the longitude, south and west negative, where its receiver has been since the "
            "0x84 before, as floats of 32 bits. Byte 1 is 0 without a fix, and not with one."
        ),
        sources=(
            f"{MANUAL}, 0x84",
            "nhorro/ceai2020 at c47f7b4, application.cpp send_gps_report: validity",
            CHOICE + " how near",
        ),
        profiles=DOCUMENTED,
        needs=("server", "sensed"),
    ),
    Clause(
        id="P89",
        suite=SUITE,
        level="must",
        title="All of 0x82 is of one turn",
        text=(
            "The rover is turned slowly to and fro about its vertical axis, over its sides and over its nose. In each "
            "0x82 the quaternion has the length 1 within 0.001. Its rates are those at which its attitude changes, and "
            "acceleration and field turn as it does, within a factor of 2.5, at most half of it another way; "
            "the length of the acceleration is 2.5 m/s^2 off its mean at most, that of the field, less one that turns "
            "with the sensor, 35 %, root mean square. All this within the axes of the sensor and its compass, "
            "whichever way they lie in the rover; the quaternion leads to the earth or from it. What is not so, is not "
            "so twice."
        ),
        sources=(
            f"{MANUAL}, 0x82: acceleration, rate, field and attitude",
            "a turn is the same for all that turns",
            "PS-MPU-9250A-01, section 9.1: axes of the sensor and its compass",
            CHOICE + " how near",
        ),
        profiles=DOCUMENTED,
        needs=("server", "turned"),
        by_hand=True,
    ),
    Clause(
        id="P90",
        suite=SUITE,
        level="must",
        title="0x84 says whether there is a fix",
        text=(
            "The GPS receiver has a fix, its view of the sky is taken until it has none: byte 1 of the second 0x84 "
            "behind that is 0, and that of the second one behind its next fix is not."
        ),
        sources=("nhorro/ceai2020 at c47f7b4, application.cpp send_gps_report: validity", CHOICE + " how soon"),
        profiles=DOCUMENTED,
        needs=("server", "sky"),
        by_hand=True,
    ),
    Clause(
        id="P91",
        suite=SUITE,
        level="must",
        title="The position moves with the rover",
        text="Carried at least 200 m away, the rover has in the second 0x84 behind that where it is, within 100 m.",
        sources=(f"{MANUAL}, 0x84", CHOICE + " how near and how soon"),
        profiles=DOCUMENTED,
        needs=("server", "carried"),
        by_hand=True,
    ),
    Clause(
        id="P92",
        suite=SUITE,
        level="must",
        title="The temperature is that of a chip in the air",
        text="The air around the rover is from 30 C below the temperature in 0x82 to 10 C above it.",
        sources=(f"{MANUAL}, 0x82: temperature in C", CHOICE + " how much warmer the sensor may be, or how late"),
        profiles=DOCUMENTED,
        needs=("server", "air"),
        by_hand=True,
    ),
    Clause(
        id="P93",
        suite=SUITE,
        level="must",
        title="0x84 has a place of the earth",
        text=(
            "The first figure of a 0x84 is from -90 to 90, the second from -180 to 180, and each is 0 or 1e-9 at least."
        ),
        sources=(f"{MANUAL}, 0x84: latitude and longitude in degrees", CHOICE + ": 1e-9, which is 0.1 mm"),
        profiles=DOCUMENTED,
        needs=("server",),
    ),
)
