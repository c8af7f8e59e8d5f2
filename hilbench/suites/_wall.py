"""A robot at a wall: put before it, driven into it, stalled by it.

The reference point of the robot is the middle between its wheels; its bumpers stand on a circle round a middle of
their own, one circle in front and one behind.
"""

from __future__ import annotations

import math

from hilbench.check import Violation, at_most
from hilbench.clock import NS_PER_S
from hilbench.suites._session import Session
from hilbench.suites._truth import Truth
from protocols.p2os import CommandNumber
from worlds.vehicles.pioneer_2dx import BUMPER_SEGMENTS, DEFAULTS, FRONT_BUMPER, REAR_BUMPER
from worlds.world import World

WALL_MM = 2000.0
"""Where the face of the wall stands in the scene of that name; a robot at the start of the scene looks at it."""

BEFORE_MM = 200.0
"""How far before the wall the bumper is when a case about contacts begins. A choice: enough to get up to speed."""

SEGMENT_DEG = 30
"""What a bumper segment covers of the circle it stands on."""

STALL_WITHIN_S = 1.0
"""How soon a stall has to be reported: the monitor averages over half a second (Pioneer 2/3 H8 Operations Manual,
StallVal), and the SIP is up to two cycles late. No manual has a figure for both."""


def face_wall(world: World, truth: Truth, bearing_deg: float) -> None:
    """Put the robot before the wall.

    Args:
        world: with the scene ``wall``.
        truth: waits until the robot stands.
        bearing_deg: where the robot has the wall: 0 ahead, 90 to the left, 180 behind.
    """
    radius_m = DEFAULTS.width_m / 2
    middle_m = DEFAULTS.length_front_m - radius_m if abs(bearing_deg) < 90 else radius_m - DEFAULTS.length_rear_m
    reach_m = radius_m + middle_m * math.cos(math.radians(bearing_deg))
    world.place((WALL_MM - BEFORE_MM) / 1000 - reach_m, 0.0, math.radians(-bearing_deg))
    truth.wait_still(1.0)


def segments_touched(bearing_deg: float) -> tuple[int, int]:
    """Return which (front, rear) segments touch a wall that is parallel to one of them; bit 0 is the leftmost one."""
    middle = BUMPER_SEGMENTS // 2
    if abs(bearing_deg) < 90:
        return 1 << middle - round(bearing_deg / SEGMENT_DEG), 0
    return 0, 1 << middle - round(math.remainder(180 - bearing_deg, 360) / SEGMENT_DEG)


def drive_into_wall(session: Session, truth: Truth, world: World, speed_mm_s: int) -> int:
    """Drive until a bumper touches, and return when that was; until then no stall may be reported."""
    mark = session.peer.mark()
    session.send(CommandNumber.VEL, speed_mm_s)
    truth.wait_until(lambda: _touches(world), 5.0, "the robot does not reach the wall")
    require_no_stall(session, mark, "before anything is touched")
    return session.now_ns


def require_no_stall(session: Session, mark: int, where: str) -> None:
    """Require that no SIP since ``mark`` reports a stall."""
    stalled = [s for s in session.seen(mark) if s.sip.left_stall or s.sip.right_stall]
    if stalled:
        raise Violation(f"a stall is reported {where}", [stalled[0].raw.hex(" ").upper()])


def require_stall(session: Session, touched_ns: int) -> None:
    """Require that both wheels are reported stalled soon after the contact."""
    sip = session.next().sip
    while not (sip.left_stall and sip.right_stall):
        if session.now_ns - touched_ns > 2 * STALL_WITHIN_S * NS_PER_S:
            raise Violation(
                f"no stall of both wheels {2 * STALL_WITHIN_S:g} s after the contact", session.peer.evidence()
            )
        session.send(CommandNumber.PULSE)
        sip = session.next().sip
    after_s = (session.now_ns - touched_ns) / NS_PER_S
    doubt_s = session.uncertainty_s(touched_ns)
    at_most(after_s, STALL_WITHIN_S, unit="s", what="stall reported after the contact", uncertainty=doubt_s)


def _touches(world: World) -> bool:
    return bool(world.contacts(FRONT_BUMPER) or world.contacts(REAR_BUMPER))
