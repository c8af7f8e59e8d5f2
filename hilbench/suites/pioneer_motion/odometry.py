"""What the robot says of its pose, beside the true one."""

from __future__ import annotations

from hilbench.check import case, near
from hilbench.suites._session import Session, poses
from hilbench.suites._truth import Truth
from hilbench.suites.pioneer_motion._judged import TURN_DEG, session, truth
from protocols.p2os import CommandNumber

__all__ = ["session", "truth"]

_C = CommandNumber


@case("M18", bench_time_s=16.0)
def test_odometry_agrees_with_the_truth(session: Session, truth: Truth) -> None:
    """A square of half a metre, compared at its four corners."""
    session.set_ramps(up=600, down=600, turn=200)
    start = truth.now
    mark = origin(session)
    for corner in (1, 2, 3, 4):
        session.send(_C.MOVE, 500)
        truth.wait_still(5.0)
        session.send(_C.DHEAD, 90)
        end = truth.wait_still(5.0)
        session.next()
        said = poses(session.seen(mark), session.robot)[-1]
        ahead, left = end.seen_from(start)
        near(said.x_mm, ahead, ODOMETRY_MM, unit="mm", what=f"x of the SIP at corner {corner}")
        near(said.y_mm, left, ODOMETRY_MM, unit="mm", what=f"y of the SIP at corner {corner}")
        turned = end.heading_deg - start.heading_deg
        near(said.heading_deg, turned, TURN_DEG, unit="deg", what=f"heading of the SIP at corner {corner}")
    session.leave()


ODOMETRY_MM = 4.0
"""Tolerance of the position after up to 2 m and four right angles: WAY of 2 m, which is also about what TURN_DEG makes
of a metre."""


def origin(session: Session) -> int:
    """Make the pose 0, 0, 0; return the mark of the first SIP that has it."""
    arrived_ns = session.send(_C.SETO)
    session.next_after(arrived_ns)
    return session.peer.mark() - 1


@case("M23", bench_time_s=10.3)
def test_heading_over_two_turns(session: Session, truth: Truth) -> None:
    """All the way round twice and a bit, so that the heading of the SIPs wraps twice; then at rest once more."""
    rate = 90
    start = truth.now
    mark = origin(session)
    session.send(_C.RVEL, rate)
    truth.wait_until(lambda: truth.now.heading_deg - start.heading_deg > 740, 15.0, "no two turns")
    session.send(_C.STOP)
    end = truth.wait_still(3.0)
    session.next()
    seen = session.seen(mark)
    followed = poses(seen, session.robot)
    errors = [
        pose.heading_deg - (truth.at(sip.start_ns).heading_deg - start.heading_deg)
        for pose, sip in zip(followed, seen, strict=True)
    ]
    # A SIP on its way is as old as its first byte is long, and what it says as old as the robot's last step.
    age_s = 10 / (session.peer.port.baud or 9600) + truth.step_s
    doubt = rate * session.uncertainty_s(seen[0].start_ns)
    worst = max(errors, key=abs)
    near(worst, 0, TURN_DEG + rate * age_s, unit="deg", what="heading of a SIP less the true one", uncertainty=doubt)
    turned = end.heading_deg - start.heading_deg
    near(followed[-1].heading_deg, turned, TURN_DEG, unit="deg", what="heading of the SIP at rest after two turns")
    session.leave()
