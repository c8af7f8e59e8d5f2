"""The physics steps of a bench, and what acts before and after each.

Every step has the same order. At tick k, whatever drives the vehicle says what it did from tick k-1 to tick k
(`WorldRunner.before`); the world is moved by that from tick k-1 to tick k; then whatever senses the world does so, as
it is at tick k (`WorldRunner.after`). A controller acts on what is true now, and its command takes effect from now on.

Parts put what they sense on their wires at its exact time within a step, so they have to know its end at its beginning
(`targets.parts.part`). A world that they drive is therefore a step `ahead`: at tick k it is moved to tick k+1.

What stands there is written into the journal once, so that a recording can be drawn (`worlds.stage`).
"""

from __future__ import annotations

from collections.abc import Callable

from hilbench.bench import Bench
from hilbench.clock import ClockDomain, EventClass
from hilbench.errors import UnavailableError
from hilbench.journal import metres, radians
from worlds.errors import WorldError
from worlds.stage import Stage
from worlds.world import World

__all__ = ["TRUTH_HZ", "OnStep", "WorldRunner"]

TRUTH_HZ = 10
"""How often the true pose goes into the journal; as often as a robot reports its own idea of it."""

OnStep = Callable[[int, int], None]
"""Called with the present, at which a step ends, and the end of the step after it, in ns of bench time."""


class WorldRunner:
    """Moves a world along with bench time.

    Args:
        bench: whose time it lives in.
        world: what is moved; its first step is made one step from now.
        ahead: whether a step is made at its beginning; see the module.

    Attributes:
        ahead: as above.
        before: what is called before each step.
        after: what is called after each step.
    """

    def __init__(self, bench: Bench, world: World, *, ahead: bool = False) -> None:
        self.world = world
        self.ahead = ahead
        self.before: list[OnStep] = []
        self.after: list[OnStep] = []
        self._bench = bench
        self._domain = ClockDomain(world.step_hz)
        self._epoch_ns = bench.now_ns
        self._tick = 0
        self._truth_every = max(1, world.step_hz // TRUTH_HZ)
        bench.record("scene", "world", **Stage.of(world.scene, world.vehicle).data())
        self._book()

    @property
    def dt_s(self) -> float:
        """Length of a step in seconds."""
        return 1 / self.world.step_hz

    def _book(self) -> None:
        self._tick += 1
        when_ns = self._tick_ns(self._tick)
        self._bench.scheduler.at(when_ns, self._step, order=EventClass.PHYSICS, source="world")

    def _tick_ns(self, tick: int) -> int:
        return self._epoch_ns + self._domain.ns(tick)

    def _step(self) -> None:
        now_ns, next_ns = self._bench.now_ns, self._tick_ns(self._tick + 1)
        truth_is_due = self._tick % self._truth_every == 0
        if truth_is_due and self.ahead:
            self._record_truth()
        for act in self.before:
            act(now_ns, next_ns)
        try:
            self.world.step()
            self.world.pose()
        except WorldError as error:
            raise UnavailableError(str(error), where="world") from error
        for act in self.after:
            act(now_ns, next_ns)
        if truth_is_due and not self.ahead:
            self._record_truth()
        self._book()
        self._bench.journal.flush_step()

    def _record_truth(self) -> None:
        pose = self.world.pose()
        x_m, y_m, z_m = pose.position_m
        self._bench.record(
            "pose", "world", x_m=metres(x_m), y_m=metres(y_m), z_m=metres(z_m), yaw_rad=radians(pose.yaw_rad)
        )
