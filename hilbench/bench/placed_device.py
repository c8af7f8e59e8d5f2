"""The device of a protocol brought to life: on its line, and where it has a body in its world."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from hilbench.bench import Bench
from hilbench.bench.devices import DeviceActor, SerialDevice
from hilbench.bench.world_runner import WorldRunner
from hilbench.benchfile.bench_file import BenchFile
from hilbench.errors import PluginError, UnavailableError
from hilbench.links import Port
from hilbench.plugins.blame import checked
from hilbench.plugins.discovery import PLUGINS
from hilbench.plugins.protocol import Device
from worlds.errors import WorldError
from worlds.vehicles import Vehicle
from worlds.world import World, open_world

__all__ = ["DEVICE", "Embodied", "PlacedDevice"]

DEVICE = "device"
"""The source of a model's events in the journal."""


@runtime_checkable
class Embodied(Protocol):
    """What a device has besides that moves a body in a world and senses it."""

    def enter(self, body: Any) -> None:
        """Take the body that the vehicle of the bench has; called once, before anything else."""

    def step(self, now_ns: int) -> None:
        """Sense the world as it is now, and say what moves it until the next step; called after each step."""


class PlacedDevice:
    """The device of the model of a bench, alive.

    Physics moves first, then the device acts, as any controller does (`hilbench.bench.world_runner`).

    Args:
        bench: whose time it lives in.
        bench_file: says what it is set to, and where it stands.
        made: makes it.
        port: its end of the line.
        scene: where it stands instead of the scene of the file.
        seed: of everything random.

    Raises:
        UnavailableError: its world cannot be opened.
        PluginError: it has a body, and is not `Embodied`.

    Attributes:
        device: the device.
        world: where it stands; None where it has no body.
    """

    def __init__(
        self, bench: Bench, bench_file: BenchFile, made: Device, port: Port, *, scene: str | None = None, seed: int
    ) -> None:
        there = bench_file.model
        assert there is not None
        self.device: SerialDevice = made.make(there.settings)
        self.world: World | None = None
        if not there.kind.has_body:
            DeviceActor(bench, self.device, port, name=DEVICE)
            return
        device = self.device
        if not isinstance(device, Embodied):
            raise PluginError("stands in a world, and has no 'enter' and 'step'", where=f"device '{DEVICE}'")
        kind = PLUGINS.systems.vehicle(bench_file.world.vehicle)
        self.world = world = _open(bench_file, checked(kind.vehicle, Vehicle)(), scene or bench_file.world.scene, seed)
        device.enter(kind.body(world))
        actor = DeviceActor(bench, device, port, name=DEVICE)

        def step(now_ns: int, _next_ns: int) -> None:
            device.step(now_ns)
            actor.settle()

        WorldRunner(bench, world).after.append(step)

    def close(self) -> None:
        """Give the world back."""
        if self.world is not None:
            self.world.close()


def _open(bench_file: BenchFile, vehicle: Vehicle, scene: str, seed: int) -> World:
    entry = bench_file.world
    try:
        return open_world(scene, vehicle, physics=entry.physics, step_hz=entry.step_hz, seed=seed)
    except WorldError as error:
        raise UnavailableError(str(error), where=f"scene {scene}") from error
