"""Every command: number, argument, unit, range, first firmware, weight on a Pioneer 2-DX, meaning, source.

The rows follow the command tables of the manufacturer's manuals; where ARIA, Player or AMRISim know more or differ, the
source says so. Numbers that no row has (14, 16, 24, ...) are unused.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Mapping

__all__ = ["COMMANDS", "ArgumentKind", "CommandNumber", "CommandSpec", "Support"]

_MANUAL = "Pioneer 2 / PeopleBot Operations Manual, client-server chapter"
_H8 = "Pioneer 2/3 H8 Operations Manual (AROS)"
_P3 = "Pioneer 3 Operations Manual (ARCOS)"
_ARM = "Pioneer 2 Arm manual; Player p2os driver, p2os.h"
_ARIA = "AriaCoda include/Aria/ArCommands.h"
_PLAYER = "Player p2os driver, p2os.h"
_AMRISIM = "AMRISim EmulatePioneer.cc"


class CommandNumber(enum.IntEnum):
    """The command numbers by name."""

    PULSE = 0
    OPEN = 1
    CLOSE = 2
    POLLING = 3
    ENABLE = 4
    SETA = 5
    SETV = 6
    SETO = 7
    MOVE = 8
    ROTATE = 9
    SETRV = 10
    VEL = 11
    HEAD = 12
    DHEAD = 13
    SAY = 15
    JOYINFO = 17
    CONFIG = 18
    ENCODER = 19
    SETRVDIR = 20
    RVEL = 21
    DCHEAD = 22
    SETRA = 23
    IMUREQUEST = 26
    SONAR = 28
    STOP = 29
    DIGOUT = 30
    TIMER = 31
    VEL2 = 32
    GRIPPER = 33
    KICK = 34
    ADSEL = 35
    GRIPPERVAL = 36
    GRIPREQUEST = 37
    GYROCALCW = 38
    GYROCALCCW = 39
    IOREQUEST = 40
    PTUPOS = 41
    TTY2 = 42
    GETAUX = 43
    BUMPSTALL = 44
    TCM2 = 45
    DOCK = 46
    JOYDRIVE = 47
    SONARCYCLE = 48
    MOVINGBLINK = 49
    HOSTBAUD = 50
    AUX1BAUD = 51
    AUX2BAUD = 52
    AUX3BAUD = 53
    E_STOP = 55
    E_STALL = 56
    QSTOP = 57
    GYRO = 58
    MESSAGE = 59
    TTY4 = 60
    GETAUX3 = 61
    BATTERYINFO = 62
    LOADWORLD = 63
    STEP = 64
    CALCOMP = 65
    TTY3 = 66
    GETAUX2 = 67
    CHARGE = 68
    ARM_INFO = 70
    ARM_STATUS = 71
    ARM_INIT = 72
    ARM_CHECK = 73
    ARM_POWER = 74
    ARM_HOME = 75
    ARM_PARK = 76
    ARM_POSITION = 77
    ARM_SPEED = 78
    ARM_STOP = 79
    ARM_AUTOPARK = 80
    ARM_GRIPPERPARK = 81
    ROTKP = 82
    ROTKV = 83
    ROTKI = 84
    TRANSKP = 85
    TRANSKV = 86
    TRANSKI = 87
    REVCOUNT = 88
    DRIFTFACTOR = 89
    SOUND = 90
    PLAYLIST = 91
    SOUNDTOG = 92
    TICKSMM = 93
    POWER_PC = 95
    POWER_LRF = 96
    POWER_5V = 97
    POWER_12V = 98
    LATVEL = 110
    LATACCEL = 113
    SIM_SET_POSE = 224
    SIM_RESET = 225
    SIM_MODEL_CONFIG = 226
    SIM_LRF_ENABLE = 230
    SIM_LRF_SET_FOV_START = 231
    SIM_LRF_SET_FOV_END = 232
    SIM_LRF_SET_RES = 233
    SIM_CTRL = 236
    SIM_STAT = 237
    SIM_MESSAGE = 238
    SIM_EXIT = 239
    BATTEST = 250
    RESET = 253
    MAINTENANCE = 255


class ArgumentKind(enum.Enum):
    """What kind of argument a command takes."""

    NONE = "no argument"
    INTEGER = "an integer"
    SIGNED = "a signed integer"
    TWO_BYTES = "an integer of two bytes"
    STRING = "a string"


class Support(enum.Enum):
    """What a Pioneer 2-DX should make of a command."""

    ESSENTIAL = "used by real clients, must work"
    QUIET = "accepted, simple support"
    IGNORED = "ignored, counts as traffic"


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandSpec:
    """One row of the table.

    Attributes:
        number: the command number.
        name: its name in the manuals or in ARIA.
        argument: the kind of argument it takes.
        unit: the unit of the argument, of each string byte, or of each of two bytes; "" where it has none.
        minimum: smallest meaningful argument (of a string: of each byte), in `unit`.
        maximum: largest meaningful argument, in `unit`; it is no limit of the wire format.
        since: the first firmware that has it.
        support: what a Pioneer 2-DX should make of it.
        default: what a server takes for a missing argument.
        summary: the meaning.
        source: where the row comes from.
    """

    number: int
    name: str
    argument: ArgumentKind
    unit: str
    minimum: int
    maximum: int
    since: str
    support: Support
    default: int
    summary: str
    source: str


_NONE, _INTEGER, _SIGNED, _BYTES, _STRING = (
    ArgumentKind.NONE,
    ArgumentKind.INTEGER,
    ArgumentKind.SIGNED,
    ArgumentKind.TWO_BYTES,
    ArgumentKind.STRING,
)
_ESSENTIAL, _QUIET, _IGNORED = Support.ESSENTIAL, Support.QUIET, Support.IGNORED

# number, kind, unit, minimum, maximum, since, support, default, summary, source
_Row = tuple[CommandNumber, ArgumentKind, str, int, int, str, Support, int, str, str]
_C = CommandNumber
# fmt: off
_ROWS: tuple[_Row, ...] = (
    (_C.PULSE, _NONE, "", 0, 0, "P2OS 1.0", _ESSENTIAL, 0, "keep-alive; SYNC0 before the session", _MANUAL),
    (_C.OPEN, _NONE, "", 0, 1, "P2OS 1.0", _ESSENTIAL, 1,
     "starts the session; SYNC1 before it; ARIA adds the integer 1", _MANUAL),
    (_C.CLOSE, _NONE, "", 0, 1, "P2OS 1.0", _ESSENTIAL, 1,
     "ends the session; SYNC2 before it; ARIA adds the integer 1", _MANUAL),
    (_C.POLLING, _STRING, "disc, from 1", 1, 32, "P2OS 1.0", _QUIET, 0,
     "sonar firing order, 1-8 array 1, 9-16 array 2; empty: none fires", _MANUAL),
    (_C.ENABLE, _INTEGER, "", 0, 1, "P2OS 1.0", _ESSENTIAL, 0, "1 motors on, 0 off", _MANUAL),
    (_C.SETA, _SIGNED, "mm/s^2", -32767, 32767, "P2OS 1.0", _ESSENTIAL, 0,
     "+ acceleration, - deceleration of translation", _MANUAL),
    (_C.SETV, _INTEGER, "mm/s", 0, 32767, "P2OS 1.0", _ESSENTIAL, 0,
     "greatest translation speed of later commands", _MANUAL),
    (_C.SETO, _NONE, "", 0, 0, "P2OS 1.0", _ESSENTIAL, 0, "here and this way become x = y = heading = 0", _MANUAL),
    (_C.MOVE, _SIGNED, "mm", -5000, 5000, "P2OS 1.x", _ESSENTIAL, 0,
     "travels so far, the sign is the direction", _ARIA),
    (_C.ROTATE, _SIGNED, "deg/s", -32767, 32767, "P2OS 1.0", _ESSENTIAL, 0,
     "turns at this rate, as RVEL (the Pioneer 2/3 H8 manual: by this angle)", _ARIA),
    (_C.SETRV, _INTEGER, "deg/s", 0, 32767, "P2OS 1.0", _ESSENTIAL, 0,
     "greatest rotation speed of later commands", _MANUAL),
    (_C.VEL, _SIGNED, "mm/s", -32767, 32767, "P2OS 1.0", _ESSENTIAL, 0, "translates at this speed, + forward", _MANUAL),
    (_C.HEAD, _SIGNED, "deg", -180, 359, "P2OS 1.0", _ESSENTIAL, 0,
     "turns to this heading, + counter-clockwise", _MANUAL),
    (_C.DHEAD, _SIGNED, "deg", -32767, 32767, "P2OS 1.0", _ESSENTIAL, 0,
     "turns by this much from the present heading, + counter-clockwise", _MANUAL),
    (_C.SAY, _STRING, "(20 ms, tone)", 0, 255, "P2OS 1.0", _QUIET, 0,
     "plays up to 20 pairs of duration and tone; tone 0 is silence", _MANUAL),
    (_C.JOYINFO, _INTEGER, "", 0, 2, "AROS", _IGNORED, 0, "joystick packets: 0 none, 1 one, 2 a stream", _ARIA),
    (_C.CONFIG, _INTEGER, "", 1, 1, "P2OS 1.4", _ESSENTIAL, 1, "asks for one configuration packet", _MANUAL),
    (_C.ENCODER, _INTEGER, "", 0, 2, "P2OS 1.4", _ESSENTIAL, 1,
     "encoder packets: 0 none, 1 one, 2 and more a stream", _MANUAL),
    (_C.SETRVDIR, _SIGNED, "deg/s", -32767, 32767, "late", _IGNORED, 0,
     "greatest rotation speed of one direction", _ARIA),
    (_C.RVEL, _SIGNED, "deg/s", -32767, 32767, "P2OS 1.0", _ESSENTIAL, 0,
     "turns at this rate, + counter-clockwise", _MANUAL),
    (_C.DCHEAD, _SIGNED, "deg", -32767, 32767, "P2OS 1.x", _ESSENTIAL, 0,
     "turns by this much from the last heading asked for", _MANUAL),
    (_C.SETRA, _SIGNED, "deg/s^2", -32767, 32767, "P2OS 1.0", _ESSENTIAL, 0,
     "+ acceleration, - deceleration of rotation (the manual's table prints mm/s^2)", _ARIA),
    (_C.IMUREQUEST, _INTEGER, "", 0, 2, "Seekur", _IGNORED, 0, "inertial packets: 0 none, 1 one, 2 a stream", _ARIA),
    (_C.SONAR, _INTEGER, "", 0, 31, "P2OS 1.0", _ESSENTIAL, 0,
     "1 sonar on, 0 off (AROS: bit 0 on or off, bits 1-4 pick arrays)", _MANUAL),
    (_C.STOP, _NONE, "", 0, 0, "P2OS 1.0", _ESSENTIAL, 0,
     "stops with the normal deceleration; the motors stay on", _MANUAL),
    (_C.DIGOUT, _BYTES, "mask, value", 0, 65535, "P2OS 1.2", _ESSENTIAL, 0,
     "high byte which outputs, low byte their new bits", _MANUAL),
    (_C.TIMER, _INTEGER, "", 0, 65535, "PSOS", _IGNORED, 0, "user-I/O timer of PSOS", _MANUAL),
    (_C.VEL2, _BYTES, "20 mm/s", -32768, 65535, "PSOS", _ESSENTIAL, 0,
     "wheel speeds: high byte left, low byte right, each signed", _ARIA),
    (_C.GRIPPER, _INTEGER, "", 1, 17, "P2OS 1.3", _QUIET, 0,
     "1 open 2 close 3 stop 4 up 5 down 6 lift stop 7 store 8 deploy 15 halt 16 press 17 carry", _MANUAL),
    (_C.KICK, _INTEGER, "", 0, 65535, "PSOS", _IGNORED, 0, "soccer kicker", _MANUAL),
    (_C.ADSEL, _INTEGER, "port", 1, 5, "P2OS 1.2", _ESSENTIAL, 0,
     "the analog port that the SIP shows; 5 after power-on", _MANUAL),
    (_C.GRIPPERVAL, _INTEGER, "", 0, 65535, "P2OS 1.3", _QUIET, 0, "gripper pressure or time", _ARIA),
    (_C.GRIPREQUEST, _INTEGER, "", 0, 2, "P2OS 1.E", _QUIET, 0, "gripper packets: 0 none, 1 one, 2 a stream", _MANUAL),
    (_C.GYROCALCW, _INTEGER, "", 0, 65535, "ARCOS", _IGNORED, 0, "gyro calibration, clockwise", _P3),
    (_C.GYROCALCCW, _INTEGER, "", 0, 65535, "ARCOS", _IGNORED, 0, "gyro calibration, counter-clockwise", _P3),
    (_C.IOREQUEST, _INTEGER, "", 0, 2, "P2OS 1.E", _ESSENTIAL, 1,
     "input and output packets: 0 none, 1 one, 2 and more a stream", _ARIA),
    (_C.PTUPOS, _BYTES, "port, 10 us", 0, 65535, "P2OS 1.2-1.J", _IGNORED, 0,
     "servo pulse: high byte port 1-4, low byte width (100 us on PSOS)", _MANUAL),
    (_C.TTY2, _STRING, "", 0, 255, "P2OS 1.0", _ESSENTIAL, 0, "bytes out of the port AUX1", _MANUAL),
    (_C.GETAUX, _INTEGER, "bytes", 0, 200, "P2OS 1.4", _ESSENTIAL, 0,
     "one AUX1 packet when so many bytes have come; 0 throws away", _MANUAL),
    (_C.BUMPSTALL, _INTEGER, "", 0, 3, "P2OS 1.5", _ESSENTIAL, 0,
     "a bumper is a stall: 0 never, 1 front, 2 rear, 3 either", _MANUAL),
    (_C.TCM2, _INTEGER, "", 0, 7, "P2OS 1.6", _QUIET, 0,
     "compass: 0 off, 1 SIP byte only, 2 one packet, 3 a stream, 4-6 calibration, 7 reset", _P3),
    (_C.DOCK, _INTEGER, "", 0, 2, "P2OS 1.C", _IGNORED, 0,
     "0 off, 1 docking signals, 2 also stop on dock power", _MANUAL),
    (_C.JOYDRIVE, _INTEGER, "", 0, 1, "P2OS 1.G", _QUIET, 0, "1 lets the joystick drive, 0 not", _MANUAL),
    (_C.SONARCYCLE, _INTEGER, "ms", 0, 65535, "AROS", _IGNORED, 0, "time between two sonar firings", _H8),
    (_C.MOVINGBLINK, _INTEGER, "", 0, 1, "PatrolBot", _IGNORED, 0, "blinks the lamp before moving", _ARIA),
    (_C.HOSTBAUD, _INTEGER, "", 0, 4, "AROS", _QUIET, 0,
     "host port rate: 0 9600, 1 19200, 2 38400, 3 57600, 4 115200; back after 500 ms without a good packet", _H8),
    (_C.AUX1BAUD, _INTEGER, "", 0, 4, "AROS", _IGNORED, 0,
     "AUX1 rate: 0 9600, 1 19200, 2 38400, 3 57600, 4 115200", _H8),
    (_C.AUX2BAUD, _INTEGER, "", 0, 4, "AROS", _IGNORED, 0,
     "AUX2 rate: 0 9600, 1 19200, 2 38400, 3 57600, 4 115200", _H8),
    (_C.AUX3BAUD, _INTEGER, "", 0, 4, "AROS", _IGNORED, 0,
     "AUX3 rate: 0 9600, 1 19200, 2 38400, 3 57600, 4 115200", _H8),
    (_C.E_STOP, _NONE, "", 0, 0, "P2OS 1.8", _ESSENTIAL, 0,
     "stops with extreme deceleration; the motors stay on", _MANUAL),
    (_C.E_STALL, _INTEGER, "", 0, 1, "P2OS 1.E", _QUIET, 0, "the stop button is a stall", _MANUAL),
    (_C.QSTOP, _NONE, "", 0, 0, "AMRISim", _IGNORED, 0, "as E_STOP", _AMRISIM),
    (_C.GYRO, _INTEGER, "", 0, 1, "AROS 1.8", _QUIET, 0, "gyro packets: 1 a stream, 0 none", _ARIA),
    (_C.MESSAGE, _STRING, "", 0, 255, "AROS", _IGNORED, 0, "text on the display", _AMRISIM),
    (_C.TTY4, _STRING, "", 0, 255, "AROS", _IGNORED, 0, "bytes out of the port AUX3", _H8),
    (_C.GETAUX3, _INTEGER, "bytes", 0, 200, "AROS", _IGNORED, 0, "one AUX3 packet when so many bytes have come", _H8),
    (_C.BATTERYINFO, _INTEGER, "", 0, 2, "late", _QUIET, 0,
     "battery packets: 0 none, 1 one, 2 a stream; ARIA always asks", _ARIA),
    (_C.LOADWORLD, _STRING, "", 0, 255, "SRIsim", _IGNORED, 0, "old simulators only", _ARIA),
    (_C.STEP, _NONE, "", 0, 0, "PSOS 3.x", _IGNORED, 0, "old simulators only", _ARIA),
    (_C.CALCOMP, _INTEGER, "", 0, 65535, "P2OS 1.6", _IGNORED, 0, "compass calibration", _ARIA),
    (_C.TTY3, _STRING, "", 0, 255, "AROS", _IGNORED, 0, "bytes out of the port AUX2", _H8),
    (_C.GETAUX2, _INTEGER, "bytes", 0, 200, "AROS", _IGNORED, 0, "one AUX2 packet when so many bytes have come", _H8),
    (_C.CHARGE, _INTEGER, "", 0, 1, "ARCOS", _IGNORED, 0, "docking charger", _P3),
    (_C.ARM_INFO, _INTEGER, "", 0, 65535, "P2OS 1.H", _IGNORED, 0, "asks for one arm information packet", _ARM),
    (_C.ARM_STATUS, _INTEGER, "", 0, 65535, "P2OS 1.H", _IGNORED, 0,
     "arm status packets: 0 none, 1 one, 2 a stream", _ARM),
    (_C.ARM_INIT, _INTEGER, "", 0, 65535, "P2OS 1.H", _IGNORED, 0, "starts the arm", _ARM),
    (_C.ARM_CHECK, _INTEGER, "", 0, 65535, "P2OS 1.H", _IGNORED, 0, "looks whether an arm is there", _ARM),
    (_C.ARM_POWER, _INTEGER, "", 0, 65535, "P2OS 1.H", _IGNORED, 0, "arm power, 1 on, 0 off", _ARM),
    (_C.ARM_HOME, _INTEGER, "", 0, 65535, "P2OS 1.H", _IGNORED, 0, "sends joints home", _ARM),
    (_C.ARM_PARK, _INTEGER, "", 0, 65535, "P2OS 1.H", _IGNORED, 0, "parks and powers off", _ARM),
    (_C.ARM_POSITION, _INTEGER, "", 0, 65535, "P2OS 1.H", _IGNORED, 0, "moves a joint", _ARM),
    (_C.ARM_SPEED, _INTEGER, "", 0, 65535, "P2OS 1.H", _IGNORED, 0, "speed of a joint", _ARM),
    (_C.ARM_STOP, _INTEGER, "", 0, 65535, "P2OS 1.H", _IGNORED, 0, "stops a joint", _ARM),
    (_C.ARM_AUTOPARK, _INTEGER, "", 0, 65535, "P2OS 1.H", _IGNORED, 0, "time until the arm parks itself", _ARM),
    (_C.ARM_GRIPPERPARK, _INTEGER, "", 0, 65535, "P2OS 1.H", _IGNORED, 0, "time until its gripper relaxes", _ARM),
    (_C.ROTKP, _INTEGER, "", 0, 65535, "P2OS 1.J", _ESSENTIAL, 0,
     "proportional gain of rotation; CONFIG shows it", _PLAYER),
    (_C.ROTKV, _INTEGER, "", 0, 65535, "P2OS 1.J", _ESSENTIAL, 0,
     "derivative gain of rotation; CONFIG shows it", _PLAYER),
    (_C.ROTKI, _INTEGER, "", 0, 65535, "P2OS 1.J", _ESSENTIAL, 0,
     "integral gain of rotation; CONFIG shows it", _PLAYER),
    (_C.TRANSKP, _INTEGER, "", 0, 65535, "P2OS 1.J", _ESSENTIAL, 0,
     "proportional gain of translation; CONFIG shows it", _PLAYER),
    (_C.TRANSKV, _INTEGER, "", 0, 65535, "P2OS 1.J", _ESSENTIAL, 0,
     "derivative gain of translation; CONFIG shows it", _PLAYER),
    (_C.TRANSKI, _INTEGER, "", 0, 65535, "P2OS 1.J", _ESSENTIAL, 0,
     "integral gain of translation; CONFIG shows it", _PLAYER),
    (_C.REVCOUNT, _INTEGER, "tick", 0, 65535, "AROS", _IGNORED, 0, "encoder ticks of a half-turn of the robot", _H8),
    (_C.DRIFTFACTOR, _SIGNED, "", -32767, 32767, "AROS", _IGNORED, 0, "difference between the wheels", _H8),
    (_C.SOUND, _INTEGER, "", 0, 65535, "AmigoBot", _IGNORED, 0, "plays a sound", _ARIA),
    (_C.PLAYLIST, _INTEGER, "", 0, 65535, "AmigoBot", _IGNORED, 0,
     "asks for the name of a sound; P2OS answers with 25 NULs", _MANUAL),
    (_C.SOUNDTOG, _INTEGER, "", 0, 1, "AmigoBot", _IGNORED, 0, "sound on or off", _ARIA),
    (_C.TICKSMM, _INTEGER, "tick/mm", 0, 65535, "AROS", _IGNORED, 0, "encoder ticks of a millimetre", _H8),
    (_C.POWER_PC, _INTEGER, "", 0, 1, "ARCOS", _IGNORED, 0, "power of the computer", _ARIA),
    (_C.POWER_LRF, _INTEGER, "", 0, 1, "ARCOS", _IGNORED, 0, "power of the laser", _ARIA),
    (_C.POWER_5V, _INTEGER, "", 0, 1, "ARCOS", _IGNORED, 0, "power of the 5 V accessories", _ARIA),
    (_C.POWER_12V, _INTEGER, "", 0, 1, "ARCOS", _IGNORED, 0, "power of the 12 V accessories", _ARIA),
    (_C.LATVEL, _SIGNED, "mm/s", -32767, 32767, "Seekur", _IGNORED, 0, "lateral speed", _ARIA),
    (_C.LATACCEL, _SIGNED, "mm/s^2", -32767, 32767, "Seekur", _IGNORED, 0,
     "+ lateral acceleration, - deceleration", _ARIA),
    (_C.SIM_SET_POSE, _NONE, "", 0, 0, "AMRISim", _IGNORED, 0, "simulator only: places the robot", _AMRISIM),
    (_C.SIM_RESET, _NONE, "", 0, 0, "AMRISim", _IGNORED, 0, "simulator only: puts everything back", _AMRISIM),
    (_C.SIM_MODEL_CONFIG, _NONE, "", 0, 0, "AMRISim", _IGNORED, 0, "simulator only: sizes of the model", _AMRISIM),
    (_C.SIM_LRF_ENABLE, _NONE, "", 0, 0, "AMRISim", _IGNORED, 0, "simulator only: laser packets", _AMRISIM),
    (_C.SIM_LRF_SET_FOV_START, _NONE, "", 0, 0, "AMRISim", _IGNORED, 0,
     "simulator only: first angle of the laser", _AMRISIM),
    (_C.SIM_LRF_SET_FOV_END, _NONE, "", 0, 0, "AMRISim", _IGNORED, 0,
     "simulator only: last angle of the laser", _AMRISIM),
    (_C.SIM_LRF_SET_RES, _NONE, "", 0, 0, "AMRISim", _IGNORED, 0, "simulator only: step of the laser", _AMRISIM),
    (_C.SIM_CTRL, _NONE, "", 0, 0, "AMRISim", _IGNORED, 0,
     "simulator only: a command to the simulator itself", _AMRISIM),
    (_C.SIM_STAT, _NONE, "", 0, 0, "AMRISim", _IGNORED, 0, "simulator only: asks for the state", _AMRISIM),
    (_C.SIM_MESSAGE, _NONE, "", 0, 0, "AMRISim", _IGNORED, 0, "simulator only: writes a message", _AMRISIM),
    (_C.SIM_EXIT, _NONE, "", 0, 0, "AMRISim", _IGNORED, 0, "simulator only: ends the simulator", _AMRISIM),
    (_C.BATTEST, _INTEGER, "0.1 V", 0, 255, "P2OS", _QUIET, 0,
     "pretends this battery voltage, 0 the real one again (AROS: shuts down)", _ARIA),
    (_C.RESET, _NONE, "", 0, 0, "AROS", _QUIET, 0, "resets the controller", _H8),
    (_C.MAINTENANCE, _NONE, "", 0, 0, "AROS", _QUIET, 0, "maintenance mode: P2OS is spoken no longer", _H8),
)
# fmt: on


def _spec(row: _Row) -> CommandSpec:
    number, argument, unit, minimum, maximum, since, support, default, summary, source = row
    return CommandSpec(
        number=int(number),
        name=number.name,
        argument=argument,
        unit=unit,
        minimum=minimum,
        maximum=maximum,
        since=since,
        support=support,
        default=default,
        summary=summary,
        source=source,
    )


COMMANDS: Mapping[int, CommandSpec] = MappingProxyType({int(row[0]): _spec(row) for row in _ROWS})
"""The table by command number."""
