"""How exactly a robot is held to what it was told, and what the cases of several files measure.

At 240 steps per second the physics rolls a metre to 0.1 mm and turns 90 degrees to 0.02, when speeds change along
ramps. What a robot may be off beyond that is its control loop: it learns of a command at its next step, and its servo
lands within some tenths of a millimetre.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import pytest

from hilbench.suites._session import Session
from hilbench.suites._truth import Sample, Truth
from hilbench.systems.pioneer.cases import VirtualCase
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import CommandNumber

__all__ = ["SPEED", "TURN_DEG", "WAY", "WAY_MM", "cruise", "mean_turn_deg_s", "session", "stop_from", "truth"]

_C = CommandNumber

WAY = 0.002
"""Tolerance of a way, as a share: ten times what the physics is off, a tenth of what a client would notice."""

WAY_MM = 1.0
"""Tolerance of where a way ends, for the servo's last millimetre; about one distance unit of a SIP (0.84 mm)."""

TURN_DEG = 0.25
"""Tolerance of where a turn ends; about three heading units of a SIP (0.088 degrees)."""

SPEED = 0.005
"""Tolerance of a steady speed or rate of turn, as a share."""


@pytest.fixture
def truth(bench: VirtualCase, peer: Peer) -> Iterator[Truth]:
    """Where the robot really was, from now on."""
    watched = Truth(bench.bench, bench.world, peer)
    yield watched
    watched.close()


@pytest.fixture
def session(peer: Peer, truth: Truth) -> Session:
    """A session with the motors on."""
    return Session(peer, motors=True)


def cruise(session: Session, truth: Truth, settle_s: float, measure_s: float) -> list[Sample]:
    """Let the robot settle, then return the samples of some time."""
    session.peer.run_alive(settle_s)
    start_ns = session.now_ns
    session.peer.run_alive(measure_s)
    return truth.since(start_ns)


def mean_turn_deg_s(samples: Sequence[Sample]) -> float:
    """Return the mean rate of turn from angle and time, + counter-clockwise."""
    return (samples[-1].heading_deg - samples[0].heading_deg) / samples[-1].after_s(samples[0].at_ns)


def stop_from(speed: int, session: Session, truth: Truth, command: int) -> tuple[float, Sample]:
    """Drive at a speed, give a stopping command, and return the way from its arrival to rest, and where that was."""
    session.send(_C.VEL, speed)
    cruise(session, truth, speed / 600 + 0.2, 0.1)
    arrived_ns = session.send(command)
    rest = truth.wait_still(10.0)
    return rest.seen_from(truth.at(arrived_ns))[0], rest
