"""A vehicle in its world without a controller of its own: what parts do is all that moves it."""

from __future__ import annotations

from hilbench.bench import Bench
from hilbench.bench.world_runner import WorldRunner
from hilbench.benchfile.bench_model import World as WorldEntry
from hilbench.plugins.blame import checked
from hilbench.plugins.discovery import PLUGINS
from worlds.scenes import Scene
from worlds.vehicles import Vehicle
from worlds.world import open_world

__all__ = ["BareVehicle"]


class BareVehicle:
    """See the module.

    Args:
        bench: whose time it lives in.
        world: which scene, vehicle and physics.
        scene: the scene, if it is made already.
        seed: of a scene that places boxes at random.

    Raises:
        WorldError: the world cannot be opened.

    Attributes:
        world: the world.
        body: the vehicle.
        runner: who moves the world.
    """

    def __init__(self, bench: Bench, world: WorldEntry, *, scene: Scene | None = None, seed: int) -> None:
        kind = PLUGINS.systems.vehicle(world.vehicle)
        vehicle = checked(kind.vehicle, Vehicle)()
        self.world = open_world(scene or world.scene, vehicle, physics=world.physics, step_hz=world.step_hz, seed=seed)
        self.body = kind.body(self.world)
        self.runner = WorldRunner(bench, self.world, ahead=True)

    def close(self) -> None:
        """Give the world back."""
        self.world.close()
