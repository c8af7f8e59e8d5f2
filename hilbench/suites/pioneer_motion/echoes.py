"""What the sonars say of a wall, a room and a corridor."""

from __future__ import annotations

from collections.abc import Sequence

from hilbench.check import case
from hilbench.suites._echoes import require_echoes
from hilbench.suites._session import Session
from hilbench.suites._truth import Truth
from hilbench.suites.pioneer_motion._judged import session, truth
from protocols.p2os import CommandNumber
from worlds.world import World

__all__ = ["session", "truth"]

_C = CommandNumber


def look_around(session: Session, truth: Truth, world: World, legs: Sequence[tuple[int, int]]) -> None:
    """Look where the robot is, then after each leg: a heading in degrees, and a way in mm."""
    session.set_ramps(up=600, down=600, turn=200)
    require_echoes(session, world, "at the start")
    for heading, way in legs:
        session.send(_C.HEAD, heading)
        truth.wait_still(5.0)
        session.send(_C.MOVE, way)
        truth.wait_still(5.0)
        require_echoes(session, world, f"after HEAD {heading} and MOVE {way}")
    session.leave()


@case("M15", bench_time_s=9.7, scene="wall")
def test_sonars_before_a_wall(session: Session, truth: Truth, world: World) -> None:
    look_around(session, truth, world, [(20, 600), (-40, 300)])


@case("M16", bench_time_s=17.1, scene="room-with-boxes")
def test_sonars_in_a_room(session: Session, truth: Truth, world: World) -> None:
    """The room keeps 1.5 m around its middle free."""
    look_around(session, truth, world, [(50, 700), (170, 700), (-70, 700)])


@case("M17", bench_time_s=10.7, scene="corridor")
def test_sonars_in_a_corridor(session: Session, truth: Truth, world: World) -> None:
    look_around(session, truth, world, [(15, 800), (-60, 600)])
