"""A vehicle in its world without a controller of its own: what parts do is all that moves it."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from hilbench.bench import Bench
from hilbench.bench_model import World as WorldEntry
from hilbench.systems.pioneer.robot import sonar_poses
from hilbench.wiring.signals import VehicleBody
from hilbench.world_runner import WorldRunner
from worlds.scenes import Scene
from worlds.vehicles.car import CarBody
from worlds.vehicles.pioneer_2dx import Pioneer2dxBody
from worlds.vehicles.rover_4wd import Rover4wdBody
from worlds.world import World, open_world

__all__ = ["BareVehicle"]

_SUBCLASS = "p2dx"


def _pioneer(world: World) -> VehicleBody:
    """A Pioneer 2-DX without its controller: wheels, body and the places of its sonar discs."""
    return Pioneer2dxBody(world, sonar_poses=sonar_poses(_SUBCLASS))


def _rover(world: World) -> VehicleBody:
    return Rover4wdBody(world)


def _car(world: World) -> VehicleBody:
    return CarBody(world)


_BODIES: Mapping[str, Callable[[World], VehicleBody]] = {
    "pioneer-2dx": _pioneer,
    "rover-4wd": _rover,
    "car": _car,
}


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
        self.world = open_world(
            scene or world.scene, world.vehicle, physics=world.physics, step_hz=world.step_hz, seed=seed
        )
        self.body = _BODIES[world.vehicle](self.world)
        self.runner = WorldRunner(bench, self.world, ahead=True)

    def close(self) -> None:
        """Give the world back."""
        self.world.close()
