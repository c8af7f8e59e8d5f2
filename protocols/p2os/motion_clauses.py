"""That the robot does in the world what the protocol says."""

from __future__ import annotations

from protocols.p2os.clause import ARIA, GEOMETRY, MANUAL, MECHANICS, Clause

__all__ = ["MOTION_CLAUSES"]

_SUITE = "pioneer-motion"

MOTION_CLAUSES: tuple[Clause, ...] = (
    Clause(
        id="M01",
        suite=_SUITE,
        level="must",
        title="MOVE arrives in the world",
        text="MOVE 1000 takes the robot 1 m straight ahead in the world.",
        sources=(
            MANUAL,
            ARIA,
            MECHANICS,
        ),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M02",
        suite=_SUITE,
        level="must",
        title="VEL is true",
        text="VEL 300 is 300 mm/s in the world.",
        sources=(
            MANUAL,
            MECHANICS,
        ),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M03",
        suite=_SUITE,
        level="must",
        title="The acceleration is SETA",
        text="From rest the robot gains speed in the world with SETA.",
        sources=(
            MANUAL,
            MECHANICS,
        ),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M04",
        suite=_SUITE,
        level="must",
        title="The stopping distance is v squared over 2a",
        text="STOP from a speed v takes v^2 / 2a in the world, a being the deceleration of SETA.",
        sources=(
            MANUAL,
            MECHANICS,
        ),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M05",
        suite=_SUITE,
        level="must",
        title="HEAD 90 is a right angle",
        text="HEAD 90 turns the robot by 90 degrees in the world.",
        sources=(
            MANUAL,
            MECHANICS,
        ),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M06",
        suite=_SUITE,
        level="must",
        title="DHEAD -45 is half of one, clockwise",
        text="DHEAD -45 turns the robot by -45 degrees in the world.",
        sources=(
            MANUAL,
            MECHANICS,
        ),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M07",
        suite=_SUITE,
        level="must",
        title="RVEL is true",
        text="RVEL 30 is 30 degrees/s in the world.",
        sources=(
            MANUAL,
            MECHANICS,
        ),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M08",
        suite=_SUITE,
        level="must",
        title="VEL and RVEL make an arc",
        text="VEL v and RVEL w make a circle of radius v / w in the world.",
        sources=(
            MANUAL,
            MECHANICS,
        ),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M09",
        suite=_SUITE,
        level="must",
        title="VEL2 makes an arc",
        text="Unequal wheel speeds make a circle of the radius that the track of the robot gives.",
        sources=(
            ARIA,
            MECHANICS,
        ),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M10",
        suite=_SUITE,
        level="must",
        title="SETV is not exceeded",
        text="Under SETV no translation in the world is faster.",
        sources=(MANUAL,),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M11",
        suite=_SUITE,
        level="must",
        title="SETRV is not exceeded",
        text="Under SETRV no rotation in the world is faster.",
        sources=(MANUAL,),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M12",
        suite=_SUITE,
        level="must",
        title="The watchdog stops the robot in the world",
        text="After the last packet the robot stands in the world within 2 s and the deceleration from its speed.",
        sources=(
            MANUAL,
            MECHANICS,
        ),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M13",
        suite=_SUITE,
        level="must",
        title="A wall stalls the wheels",
        text="Driven against a wall the robot reports a wheel stall and stays where it is.",
        sources=(MANUAL,),
        needs=(
            "server",
            "truth",
            "scene",
            "contacts",
        ),
    ),
    Clause(
        id="M14",
        suite=_SUITE,
        level="must",
        title="A stall ends",
        text="After backing off from the wall the stall bits are clear, and the robot drives again.",
        sources=(MANUAL,),
        needs=(
            "server",
            "truth",
            "scene",
            "contacts",
        ),
    ),
    Clause(
        id="M15",
        suite=_SUITE,
        level="must",
        title="Sonars see a wall",
        text="Before a wall the sonar ranges are those of the exact geometry.",
        sources=(
            ARIA,
            GEOMETRY,
        ),
        needs=(
            "server",
            "truth",
            "scene",
            "rays",
        ),
    ),
    Clause(
        id="M16",
        suite=_SUITE,
        level="must",
        title="Sonars see a room with boxes",
        text="In a room with boxes the sonar ranges are those of the exact geometry.",
        sources=(
            ARIA,
            GEOMETRY,
        ),
        needs=(
            "server",
            "truth",
            "scene",
            "rays",
        ),
    ),
    Clause(
        id="M17",
        suite=_SUITE,
        level="must",
        title="Sonars see a corridor",
        text="In a corridor the sonar ranges are those of the exact geometry.",
        sources=(
            ARIA,
            GEOMETRY,
        ),
        needs=(
            "server",
            "truth",
            "scene",
            "rays",
        ),
    ),
    Clause(
        id="M18",
        suite=_SUITE,
        level="must",
        title="Odometry agrees with the truth",
        text="After a square the position and heading of the SIPs are those of the world.",
        sources=(
            MANUAL,
            MECHANICS,
        ),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M19",
        suite=_SUITE,
        level="must",
        title="ENABLE 0 stops",
        text="ENABLE 0 while moving ends the motion in the world, and the motors are off.",
        sources=(MANUAL,),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M20",
        suite=_SUITE,
        level="must",
        title="E_STOP is shorter than STOP",
        text="From the same speed E_STOP takes less of the way than STOP.",
        sources=(
            MANUAL,
            MECHANICS,
        ),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M21",
        suite=_SUITE,
        level="must",
        title="A bumper reports its segment",
        text="A contact shows in the SIP as the bumper segment that was touched.",
        sources=(
            MANUAL,
            GEOMETRY,
        ),
        needs=(
            "server",
            "truth",
            "scene",
            "contacts",
            "bumpers",
        ),
    ),
    Clause(
        id="M22",
        suite=_SUITE,
        level="must",
        title="The robot climbs a ramp",
        text="On a ramp the robot climbs and holds its speed.",
        sources=(
            MANUAL,
            MECHANICS,
        ),
        needs=(
            "server",
            "truth",
            "scene",
            "gravity",
        ),
    ),
    Clause(
        id="M23",
        suite=_SUITE,
        level="must",
        title="The heading is true over two turns",
        text="Over two turns the unwrapped heading of the SIPs is that of the world.",
        sources=(
            MANUAL,
            MECHANICS,
        ),
        needs=(
            "server",
            "truth",
        ),
    ),
    Clause(
        id="M24",
        suite=_SUITE,
        level="must",
        title="No motion with motors off",
        text="Motion commands with motors off do not move the robot in the world.",
        sources=(MANUAL,),
        needs=(
            "server",
            "truth",
        ),
    ),
)
