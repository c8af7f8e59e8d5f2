"""The truth of a virtual bench, written down: where the robot was and how it moved, at every step of the physics.

What the robot says of itself comes over the line; what it did is here. A case holds one against the other, or both
against a formula.
"""

from __future__ import annotations

import bisect
import math
from collections.abc import Callable
from dataclasses import dataclass

from hilbench.bench import Bench
from hilbench.check import Violation
from hilbench.clock import NS_PER_S, ClockDomain, EventClass
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import CommandNumber
from worlds.geometry import dot, rotation
from worlds.world import World

STILL_MM_S = 1.0
STILL_DEG_S = 0.1
"""Slower is at rest. A choice: less than a heading unit of a SIP (0.09 degrees) and about one of its distance units
(0.84 mm) in a second."""

STILL_S = 0.3
"""A robot is at rest when it has been still for so long: time enough for a command on the line (9.4 ms at 9600 baud)
and a controller to set it going."""

FEED_S = 0.5
"""How often a waiting case feeds the robot's watchdog, of 2 s."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Sample:
    """The robot in the world at one moment, in the frame of the scene.

    Attributes:
        at_ns: bench time.
        x_mm: position of the robot's middle, on the floor.
        y_mm: as above.
        z_mm: its height over the floor.
        heading_deg: counter-clockwise, not wrapped.
        pitch_deg: positive with the nose down.
        speed_mm_s: along the robot's own long axis, + forward.
        turn_deg_s: rate of turn, + counter-clockwise.
    """

    at_ns: int
    x_mm: float
    y_mm: float
    z_mm: float
    heading_deg: float
    pitch_deg: float
    speed_mm_s: float
    turn_deg_s: float

    @property
    def still(self) -> bool:
        """The robot does not move."""
        return abs(self.speed_mm_s) < STILL_MM_S and abs(self.turn_deg_s) < STILL_DEG_S

    @property
    def point_mm(self) -> tuple[float, float]:
        """Where the robot is on the floor."""
        return self.x_mm, self.y_mm

    def seen_from(self, start: Sample) -> tuple[float, float]:
        """Return how far ahead and how far to the left of ``start`` this is, in mm."""
        dx, dy, heading_rad = self.x_mm - start.x_mm, self.y_mm - start.y_mm, math.radians(start.heading_deg)
        cos, sin = math.cos(heading_rad), math.sin(heading_rad)
        return cos * dx + sin * dy, cos * dy - sin * dx

    def after_s(self, since_ns: int) -> float:
        """Return how long after ``since_ns`` this was, in seconds."""
        return (self.at_ns - since_ns) / NS_PER_S

    def __str__(self) -> str:
        where = f"x {self.x_mm:.1f} mm, y {self.y_mm:.1f} mm, heading {self.heading_deg:.2f} deg"
        return f"{self.at_ns / NS_PER_S:10.4f} s  {where}, {self.speed_mm_s:.1f} mm/s, {self.turn_deg_s:.2f} deg/s"


class Truth:
    """Samples the world on the bench's grid of physics steps, each time after the world has been moved.

    Args:
        bench: whose time it is.
        world: where the robot is.
        peer: the line, which has to stay up while the case waits for something to become true.
    """

    def __init__(self, bench: Bench, world: World, peer: Peer) -> None:
        self._bench = bench
        self._world = world
        self._peer = peer
        self._grid = ClockDomain(world.step_hz)
        self._tick = self._grid.ticks(bench.now_ns)
        self._samples = [self._sample(0.0)]
        self._times_ns = [bench.now_ns]
        self._still = 0
        self._book()

    def close(self) -> None:
        """Sample no more."""
        self._bench.scheduler.cancel(self._entry)

    # --- looking

    @property
    def step_s(self) -> float:
        """Time between two samples, and between two steps of the robot's control loop, in seconds."""
        return 1 / self._world.step_hz

    @property
    def now(self) -> Sample:
        """The newest sample."""
        return self._samples[-1]

    def since(self, start_ns: int) -> list[Sample]:
        """Return the samples from ``start_ns`` on."""
        return self._samples[bisect.bisect_left(self._times_ns, start_ns) :]

    def at(self, when_ns: int) -> Sample:
        """Return the robot at a moment between two samples: the one before, moved on as it moved then."""
        before = self._samples[max(0, bisect.bisect_right(self._times_ns, when_ns) - 1)]
        elapsed_s = (when_ns - before.at_ns) / NS_PER_S
        heading_rad = math.radians(before.heading_deg + before.turn_deg_s * elapsed_s / 2)
        way_mm = before.speed_mm_s * elapsed_s
        return Sample(
            at_ns=when_ns,
            x_mm=before.x_mm + way_mm * math.cos(heading_rad),
            y_mm=before.y_mm + way_mm * math.sin(heading_rad),
            z_mm=before.z_mm,
            heading_deg=before.heading_deg + before.turn_deg_s * elapsed_s,
            pitch_deg=before.pitch_deg,
            speed_mm_s=before.speed_mm_s,
            turn_deg_s=before.turn_deg_s,
        )

    # --- waiting

    def wait_until(self, condition: Callable[[], bool], within_s: float, what: str, *, feed: bool = True) -> Sample:
        """Wait until something is true of the world, and return the sample of that moment.

        Args:
            condition: what has to be true.
            within_s: when to give up, in seconds; the limit of the case's patience, not of the clause.
            what: what did not happen, for the report.
            feed: keep the robot's watchdog fed meanwhile.

        Raises:
            Violation: it did not become true in time.
        """
        scale = self._bench.timeout_scale
        end_ns = self._bench.now_ns + round(within_s * scale * NS_PER_S)
        while self._bench.now_ns < end_ns:
            if feed:
                self._peer.send(CommandNumber.PULSE)
            slice_s = min(FEED_S, (end_ns - self._bench.now_ns) / NS_PER_S)
            if self._bench.run_until(condition, slice_s / scale):
                return self.now
            self._peer.require_line()
        raise Violation(f"{what} within {within_s:g} s", [str(self.now), *self._peer.evidence()])

    def wait_still(self, within_s: float, *, feed: bool = True) -> Sample:
        """Wait until the robot is at rest, and return the moment at which it came to rest.

        Raises:
            Violation: it was not within ``within_s`` seconds.
        """
        needed = math.ceil(STILL_S * self._world.step_hz)
        self._still = 0
        within_s += STILL_S
        self.wait_until(lambda: self._still >= needed, within_s, "the robot does not come to rest", feed=feed)
        return self._samples[-needed]

    # --- sampling

    def _book(self) -> None:
        self._tick += 1
        when_ns = self._grid.ns(self._tick)
        self._entry = self._bench.scheduler.at(when_ns, self._take, order=EventClass.CHECK, source="truth")

    def _take(self) -> None:
        self._samples.append(self._sample(self._samples[-1].heading_deg))
        self._times_ns.append(self._bench.now_ns)
        self._still = self._still + 1 if self.now.still else 0
        self._book()

    def _sample(self, near_deg: float) -> Sample:
        return sample(self._world, self._bench.now_ns, near_deg)


def sample(world: World, at_ns: int, near_deg: float) -> Sample:
    """Return where the robot is now, its heading unwrapped to less than half a turn from ``near_deg``."""
    pose, velocity = world.pose(), world.velocity()
    frame = rotation(pose.yaw_rad, pose.pitch_rad, pose.roll_rad)
    ahead = (frame[0][0], frame[1][0], frame[2][0])
    x_m, y_m, z_m = pose.position_m
    return Sample(
        at_ns=at_ns,
        x_mm=x_m * 1000,
        y_mm=y_m * 1000,
        z_mm=z_m * 1000,
        heading_deg=near_deg + math.remainder(math.degrees(pose.yaw_rad) - near_deg, 360),
        pitch_deg=math.degrees(pose.pitch_rad),
        speed_mm_s=dot(velocity.linear_m_s, ahead) * 1000,
        turn_deg_s=math.degrees(velocity.angular_rad_s[2]),
    )
