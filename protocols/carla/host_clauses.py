"""What the simulator's side must do, faced with a board or with frames of a script.

F1 to F7 are the frames of vectors.py. A frame "comes in one read" where nothing is said. A clause whose id ends with H
is the twin of one in which shipped behaviour is a hazard.
"""

from __future__ import annotations

from protocols.carla.clause import ACKERMANN, CAB, CHOICE, HEADER, LINE, NODE, SERIAL_COM, TASK, Clause

__all__ = ["HOST_CLAUSES"]

_SUITE = "vehicle-host"
_ALL = ("hardened", "v0", "v1")
_HARDENED = ("hardened",)
_SHIPPED = ("v0", "v1")
_CAR = ("simulator", "car")
_REPORTED = ("simulator", "car.reported")
_PAIR = ("simulator", "car", "board")
_LINE = ("simulator",)
_OWN_END = ("simulator", "car", "read errors")
_PARSER = f"{NODE} timer_callback"
_READ = f"{SERIAL_COM} readSerialPort"

HOST_CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="VS01",
        suite=_SUITE,
        level="must",
        title="A command of mode 1",
        text=(
            "F1 is handed on as an Ackermann command: 0.6 rad, 0.12 rad/s, 5 m/s, 1 m/s^2, 0.2 m/s^3. So are -0.48 "
            "rad, -0.3 rad/s, -2 m/s, -3 m/s^2, -0.5 m/s^3."
        ),
        sources=(f"{NODE} publish_to_carla",),
        profiles=_ALL,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS02",
        suite=_SUITE,
        level="must",
        title="A command of mode 4",
        text=(
            "F2 is handed on as a manual command: throttle 0.75, steer -0.5, brake 0. So is steer 0.25, throttle 0, "
            "brake 0.5."
        ),
        sources=(f"{NODE} publish_to_carla",),
        profiles=_ALL,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS03",
        suite=_SUITE,
        level="must",
        title="An emergency stops the car",
        text=(
            "F3 is handed on as an Ackermann command with all 0, which is full deceleration with straight wheels; how "
            "a car stops by it: VD10."
        ),
        sources=(f"{NODE} publish_to_carla", f"{ACKERMANN}: speed 0 is full deceleration, and the hand brake at rest"),
        profiles=_ALL,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS04",
        suite=_SUITE,
        level="must",
        title="Unknown modes are not handed on",
        text="Sound frames of the modes 2, 3, 5, 6, 7 and 255 are not handed on.",
        sources=(f"{NODE} publish_to_carla",),
        profiles=_ALL,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS05",
        suite=_SUITE,
        level="must",
        title="The NUL is not needed",
        text="The 29 bytes of F1 without its NUL, and a pause behind them: as VS01.",
        sources=(_PARSER,),
        profiles=_ALL,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS06",
        suite=_SUITE,
        level="must",
        title="Torn frames",
        text=(
            "A frame P, then the first 10 bytes of Q, and 20 ms later the rest: P is handed on, and once the steering "
            "of Q with the speed and mode of P; Q itself is never. Once, for the read of the rest, which has no #, "
            "leaves nothing that begins a frame; a read that fails in between would hand it on again (VS11)."
        ),
        sources=(f"{_READ}: the buffer keeps what it held",),
        profiles=_SHIPPED,
        twin="VS06H",
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS06H",
        suite=_SUITE,
        level="must",
        title="A frame in pieces is one frame",
        text=(
            "A frame P, then the first 10 bytes of Q, and 20 ms later the rest: P and Q are handed on, once each. The "
            "first 10 bytes of P again, and the rest 0.15 s later: nothing more."
        ),
        sources=(LINE, CHOICE),
        profiles=_HARDENED,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS07",
        suite=_SUITE,
        level="must",
        title="A # too many costs a frame",
        text="# and the 29 bytes of F1 without its NUL: nothing is handed on.",
        sources=(f"{_PARSER}: a second # ends the frame",),
        profiles=_SHIPPED,
        twin="VS07H",
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS07H",
        suite=_SUITE,
        level="must",
        title="A # too many costs nothing",
        text="#, or any other beginning of F1, or any end of it, and the 29 bytes of F1 without its NUL: as VS01.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS08",
        suite=_SUITE,
        level="must",
        title="A shifted stream is never read",
        text="7 stray bytes and 40 frames behind each other without a gap: none is handed on.",
        sources=(f"{_READ}: 30 bytes each time",),
        profiles=_SHIPPED,
        twin="VS08H",
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS08H",
        suite=_SUITE,
        level="must",
        title="A shifted stream is read",
        text="7 stray bytes and 40 frames behind each other without a gap: 39 at least are handed on.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS09",
        suite=_SUITE,
        level="must",
        title="Missing fields keep their old values",
        text="F1, then 23 4D 04 24: a manual command with the values of F1: throttle 5, steer 0.6, brake 1.",
        sources=(f"{_PARSER}: $ is the end, whatever came before",),
        profiles=_SHIPPED,
        twin="VS09H",
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS09H",
        suite=_SUITE,
        level="must",
        title="A frame that lacks a field is none",
        text="F1, then 23 4D 04 24: nothing more than F1 is handed on; nor is a frame whose W is a second S.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS10",
        suite=_SUITE,
        level="must",
        title="An empty frame commands",
        text="23 24 as the first thing after the start: a command is handed on, though nobody gave one.",
        sources=(f"{_PARSER}: ucControlMode has no value yet",),
        profiles=_SHIPPED,
        twin="VS10H",
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS10H",
        suite=_SUITE,
        level="must",
        title="An empty frame says nothing",
        text="23 24 as the first thing after the start: nothing is handed on.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS11",
        suite=_SUITE,
        level="must",
        title="A port that is gone goes on commanding",
        text="F1, then every read fails: F1 is handed on again every 20 ms.",
        sources=(f"{_READ}: -1 is not 0",),
        profiles=_SHIPPED,
        twin="VS11H",
        needs=_OWN_END,
    ),
    Clause(
        id="VS11H",
        suite=_SUITE,
        level="must",
        title="A port that is gone stops the car",
        text="F1, then every read fails: nothing of F1 again, and within 0.5 s the car is commanded to stop.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_OWN_END,
    ),
    Clause(
        id="VS12",
        suite=_SUITE,
        level="must",
        title="A carriage return becomes a newline",
        text="F1 with 0D 0D 0D 3F as its V: the speed handed on is that of 0A 0A 0A 3F, 0.539216 m/s.",
        sources=(f"{SERIAL_COM}: ICRNL is not cleared",),
        profiles=_SHIPPED,
        twin="VS12H",
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS12H",
        suite=_SUITE,
        level="must",
        title="A carriage return is a byte like others",
        text="F1 with 0D 0D 0D 3F as its V: the speed handed on is 0.550980 m/s.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS13",
        suite=_SUITE,
        level="must",
        title="A status has 22 bytes",
        text="What is sent are frames of exactly 22 bytes: #, A, B, C, D with four bytes each, $, and no NUL.",
        sources=(f"{NODE} send_to_microautoware",),
        profiles=_ALL,
        needs=_LINE,
    ),
    Clause(
        id="VS14",
        suite=_SUITE,
        level="must",
        title="A status waits for both reports",
        text=(
            "A velocity report alone is not sent; the steering report that follows sends both, each once. Nor is a "
            "steering report alone; the velocity report that follows sends both."
        ),
        sources=(f"{NODE} velocity_status_sub_callback, steering_status_sub_callback",),
        profiles=_ALL,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS15",
        suite=_SUITE,
        level="must",
        title="The newest report counts",
        text=(
            "Two velocity reports and then one steering report: one frame, with the newer velocity, in all its "
            "figures; and so a second time."
        ),
        sources=(f"{NODE} velocity_status_sub_callback",),
        profiles=_ALL,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS16",
        suite=_SUITE,
        level="must",
        title="The sign of steering",
        text=(
            "A car of which CARLA says that its steer is +0.5, to the right: D is -0.5146 rad. Of -0.25, to the left: "
            "0.2573 rad."
        ),
        sources=(f"{CAB}: -1.0292 rad x steer",),
        profiles=_ALL,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS17",
        suite=_SUITE,
        level="must",
        title="The signs of motion are turned round",
        text="Odometry's yaw rate +0.1 rad/s and lateral speed +0.05 m/s, both to the left: C is -0.1, B is -0.05.",
        sources=(f"{CAB}: velocity report",),
        profiles=_SHIPPED,
        twin="VS17H",
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS17H",
        suite=_SUITE,
        level="must",
        title="The signs of motion are those of ROS",
        text="Odometry's yaw rate +0.1 rad/s and lateral speed +0.05 m/s, both to the left: C is +0.1, B is +0.05.",
        sources=("autoware_auto_vehicle_msgs/VelocityReport in the axes of REP 103", CHOICE),
        profiles=_HARDENED,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS18",
        suite=_SUITE,
        level="must",
        title="How long a pause may be",
        text=(
            "The simulator pauses, commands go on: 0.9 s after the last status the board is still in AUTOWARE, after "
            "1.1 s in EMERGENCY."
        ),
        sources=(f"{TASK}, {HEADER} TIMEOUT_GET_CARLA_RX, MAX_OF_LOST_MESSAGES",),
        profiles=_ALL,
        needs=_PAIR,
    ),
    Clause(
        id="VS19",
        suite=_SUITE,
        level="must",
        title="The first status ends the emergency",
        text=(
            "The simulator goes on after a pause of 2 s: its first status is followed by a frame of mode 4 within 45 "
            "ms, or within 145 ms and behind one F3 where a quiet board holds the status up (VS21)."
        ),
        sources=(TASK,),
        profiles=_ALL,
        needs=_PAIR,
    ),
    Clause(
        id="VS20",
        suite=_SUITE,
        level="must",
        title="Statuses come in time",
        text="Reports at 20 Hz for 60 s: 1200 frames, 2 more or less, none split by another.",
        sources=(f"{CAB}: fixed_delta_seconds 0.05",),
        profiles=_ALL,
        needs=_LINE,
    ),
    Clause(
        id="VS21",
        suite=_SUITE,
        level="must",
        title="A quiet board holds the statuses up",
        text="The board is silent for 2 s, reports come at 20 Hz: statuses go out 0.5 s apart.",
        sources=(f"{SERIAL_COM}: VMIN 0, VTIME 5, in the node's one thread",),
        profiles=_SHIPPED,
        twin="VS21H",
        needs=_LINE,
    ),
    Clause(
        id="VS21H",
        suite=_SUITE,
        level="must",
        title="A quiet board holds nothing up",
        text="The board is silent for 2 s, reports come at 20 Hz: each status goes out at once.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_LINE,
    ),
    Clause(
        id="VS22",
        suite=_SUITE,
        level="must",
        title="The joystick is contradicted",
        text=(
            "Commands of mode 1, and then of mode 4: for a second after the last of mode 1 the car gets both "
            "in turn; then the joystick's commands alone."
        ),
        sources=(f"{ACKERMANN}: it writes the same topic while a command came within 1 s",),
        profiles=_SHIPPED,
        twin="VS22H",
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS22H",
        suite=_SUITE,
        level="must",
        title="The joystick wins",
        text="Commands of mode 1, and then of mode 4: the car obeys the second ones at once.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS23",
        suite=_SUITE,
        level="must",
        title="More than 50 frames a second pile up",
        text="Frames at 100 Hz for 2 s: after them half are still to be read, and handed on up to 2 s late.",
        sources=(f"{NODE}: RX_POOLING_RATE, {_READ}",),
        profiles=_SHIPPED,
        twin="VS23H",
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS23H",
        suite=_SUITE,
        level="must",
        title="The newest frame counts",
        text="Frames at 100 Hz for 2 s: the last is handed on within 50 ms of its end.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS24",
        suite=_SUITE,
        level="must",
        title="Steering beyond one is handed on",
        text="A frame of mode 4 with S 2.0: steer 2.0 is handed on.",
        sources=(f"{NODE} publish_to_carla",),
        profiles=_SHIPPED,
        twin="VS24H",
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS24H",
        suite=_SUITE,
        level="must",
        title="Steering ends at one",
        text=(
            "A frame of mode 4 with S 2.0, V 1.5 and A -1: steer 1, throttle 1 and brake 0 are handed on; one with "
            "S -2.0, V -1 and A 1.5: steer -1, throttle 0 and brake 1."
        ),
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS25",
        suite=_SUITE,
        level="must",
        title="Whatever comes",
        text=(
            "A million random bytes, without the time of the line: it still runs, and hands F1 on afterwards. How many "
            "frames it believed is in the report, and no verdict."
        ),
        sources=(LINE,),
        profiles=_ALL,
        needs=_OWN_END,
    ),
    Clause(
        id="VS26",
        suite=_SUITE,
        level="must",
        title="A silent board drives on",
        text="F1, then nothing for 2 s: nothing more is commanded, the car goes on.",
        sources=(NODE,),
        profiles=_SHIPPED,
        twin="VS26H",
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS26H",
        suite=_SUITE,
        level="must",
        title="A silent board stops the car",
        text=(
            "F1, then nothing: 0.5 s later the car is commanded to stop, once; the next frame, F2, is obeyed again, "
            "and 0.5 s of nothing behind it stop the car again."
        ),
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS27",
        suite=_SUITE,
        level="must",
        title="A NaN is handed on",
        text="F1 with NaN as its V: a command with the speed NaN.",
        sources=(_PARSER,),
        profiles=_SHIPPED,
        twin="VS27H",
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS27H",
        suite=_SUITE,
        level="must",
        title="What cannot be meant is dropped",
        text=(
            "F1 with NaN, an infinity or 101 % of the limit, + or -, as its S, W, V, A or J, or F2 with one of these "
            "as its S, V or A, or with NaN or an infinity as its W or J: nothing is handed on. With 99 % of it in each "
            "both are, F2 as far as steer, throttle and brake go."
        ),
        sources=(CHOICE + ": the limits are 2.5 rad, 50 rad/s, 150 m/s, 100 m/s^2, 1000 m/s^3, and 10 for each of F2",),
        profiles=_HARDENED,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS28",
        suite=_SUITE,
        level="must",
        title="Sending forgets the mode",
        text="F2, then a status is sent, then 23 24: an Ackermann command with the values of F2: speed 0.75, -0.5 rad.",
        sources=(f"{NODE} send_to_microautoware: ucControlMode = 0",),
        profiles=_SHIPPED,
        twin="VS28H",
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS28H",
        suite=_SUITE,
        level="must",
        title="Values keep their mode",
        text="F2, then a status is sent, then 23 24: nothing but F2 is handed on.",
        sources=(CHOICE,),
        profiles=_HARDENED,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
    Clause(
        id="VS29",
        suite=_SUITE,
        level="must",
        title="A frame of mode 0 is handed on as it is",
        text=(
            "F1 with mode 0 is handed on as an Ackermann command with its figures, as VS01; so is one with other "
            "figures. That they are 0 is the board's matter (VB07)."
        ),
        sources=(f"{NODE} publish_to_carla: modes 0 and 1 are one branch",),
        profiles=_ALL,
        needs=_CAR,
        stand_ins=_REPORTED,
    ),
)
