"""The fidelity ledger: what of the real robot is modelled, partly modelled, or absent.

Used by reports and documentation. A clause that needs an absent feature is inconclusive, never failed.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass


class Fidelity(enum.Enum):
    """How far a feature is modelled."""

    MODELLED = "modelled"
    PARTLY = "partly"
    ABSENT = "absent"


@dataclass(frozen=True, slots=True, kw_only=True)
class LedgerEntry:
    """One feature.

    Attributes:
        feature: What it is.
        commands: The command numbers that belong to it.
        fidelity: How far it is modelled.
        note: What to know before trusting it.
    """

    feature: str
    commands: tuple[int, ...] = ()
    fidelity: Fidelity
    note: str


def _modelled(feature: str, commands: tuple[int, ...], note: str) -> LedgerEntry:
    return LedgerEntry(feature=feature, commands=commands, fidelity=Fidelity.MODELLED, note=note)


def _partly(feature: str, commands: tuple[int, ...], note: str) -> LedgerEntry:
    return LedgerEntry(feature=feature, commands=commands, fidelity=Fidelity.PARTLY, note=note)


def _absent(feature: str, commands: tuple[int, ...], note: str) -> LedgerEntry:
    return LedgerEntry(feature=feature, commands=commands, fidelity=Fidelity.ABSENT, note=note)


LEDGER: tuple[LedgerEntry, ...] = (
    _modelled(
        "session",
        (0, 1, 2),
        "handshake, OPEN, CLOSE, watchdog with revival; what a client set ends with it, but for pose, outputs, gripper "
        "and BATTEST",
    ),
    _modelled("SIP", (), "every 100 ms from OPEN, never accumulated; status follows the measured wheel speeds"),
    _modelled(
        "motor power",
        (4,),
        "off after OPEN and CLOSE; off forgets every goal and frees the wheels, CLOSE and a hang-up brake them first "
        "(choice: no manual lets a robot without a client roll on); the front-panel button is absent",
    ),
    _modelled("speed limits", (6, 10), "act on later commands, clipped to the tops"),
    _modelled("accelerations", (5, 23), "act on later commands, clipped to the tops; SETRA in deg/s2"),
    _modelled("velocity commands", (9, 11, 21, 32), "trapezoid on two loops or two wheels; ROTATE is a velocity"),
    _modelled("position commands", (8, 12, 13, 22), "trapezoid with encoder feedback; settles on the target"),
    _modelled("stops", (29, 55, 57), "E_STOP 5000 mm/s2 assumed; position commands then wait for a velocity command"),
    _modelled("dead reckoning", (7,), "from quantised ticks, exact arcs; errors of wheel, track and slip are settings"),
    _modelled("watchdog", (), "stops with normal deceleration, keeps setpoints, resumes on the next packet"),
    _partly(
        "servo", (82, 83, 84, 85, 86, 87), "gains are kept and shown by CONFIG; the model's own servo ignores them"
    ),
    _partly("stall", (), "averaging of the later H8 firmware; PWM is the motor's load; thresholds assumed"),
    _modelled(
        "bump stall",
        (44,),
        "a new contact, or motion toward a pressed end, stops at once; stall bits stay until an order leads elsewhere",
    ),
    _modelled(
        "sonar", (3, 28), "one disc per array per 40 ms; no crosstalk; factory order assumed ascending, back at OPEN"
    ),
    _modelled("CONFIG", (18,), "P2OS form; RevCount and joystick speeds are reported, not used"),
    _modelled("ENCODER", (19,), "cumulative ticks since power-on; ticks per turn assumed"),
    _modelled(
        "user I/O", (30, 35, 40), "inputs are set by the bench; analog values do not follow anything by themselves"
    ),
    _partly("AUX ports", (42, 43, 60, 61, 66, 67), "bytes cross at once; loop-back by setting; no AUX baud rates"),
    _partly("HOSTBAUD", (50,), "immediate, reverts after 500 ms without a packet and at the end of a session"),
    _partly("sound", (15,), "SAY is accepted and recorded, nothing is heard"),
    _modelled("PLAYLIST", (91,), "25 NULs, as P2OS"),
    _partly("gripper", (33, 37), "paddles and lift travel; nothing is grasped, PRESS and CARRY are absent; if fitted"),
    _partly("compass", (45,), "heading follows the odometry, no magnetic field, no calibration; if fitted"),
    _partly("gyro", (58,), "one sample per SIP from the encoders, scale assumed; if fitted"),
    _partly("joystick", (17,), "JOYINFO shows a stick at rest; if fitted"),
    _partly("BATTERYINFO", (62,), "ignored as P2OS does; answered by setting, charge linear in the voltage"),
    _partly("battery", (250,), "constant voltage, or what BATTEST says"),
    _absent("joystick driving", (47,), "accepted without effect"),
    _absent("rotation limit per direction", (20,), "later firmware"),
    _absent("timer, kicker, gripper value, RC servos", (31, 34, 36, 41), "accepted without effect"),
    _absent("gyro calibration", (38, 39), "later firmware"),
    _absent("docking and charging", (46, 68), "accepted without effect"),
    _absent("sonar cycle", (48,), "later firmware; the cycle is a setting"),
    _absent("AUX baud rates", (51, 52, 53), "later firmware"),
    _absent("E_STALL", (56,), "PeopleBot only"),
    _absent("IMU, blinking light", (26, 49), "later firmware"),
    _absent("LCD, simulator commands", (59, 63, 64), "accepted without effect"),
    _absent("compass calibration", (65,), "accepted without effect"),
    _absent("arm", (70, 71, 72, 73, 74, 75, 76, 77, 78, 79, 80, 81), "accepted without effect, no answers"),
    _absent("drive calibration", (88, 89, 93), "later firmware; the values are settings"),
    _absent("sounds", (90, 92), "AmigoBot only"),
    _absent("power switches", (95, 96, 97, 98), "later firmware"),
    _absent("lateral motion", (110, 113), "other robots"),
    _absent("RESET, MAINTENANCE", (253, 255), "later firmware; a session survives both"),
)
"""Everything, modelled features first where they belong together."""
