"""The device of a protocol brought to life: on its line, and where it has a body in its world."""

from __future__ import annotations

from typing import Any, Protocol, runtime_checkable

from hilbench.bench import Bench
from hilbench.bench_file import BenchFile
from hilbench.devices import DeviceActor, SerialDevice
from hilbench.errors import PluginError, UnavailableError
from hilbench.links import Port
from hilbench.plugins.protocol import Device
from hilbench.wiring.vehicle import BareVehicle
from worlds.errors import WorldError
from worlds.world import World

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

    Physics moves first, then the device acts, as any controller does (`hilbench.world_runner`).

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
        vehicle = _vehicle(bench, bench_file, scene, seed)
        device.enter(vehicle.body)
        actor = DeviceActor(bench, device, port, name=DEVICE)

        def step(now_ns: int, _next_ns: int) -> None:
            device.step(now_ns)
            actor.settle()

        self.world = vehicle.world
        vehicle.runner.after.append(step)

    def close(self) -> None:
        """Give the world back."""
        if self.world is not None:
            self.world.close()


def _vehicle(bench: Bench, bench_file: BenchFile, scene: str | None, seed: int) -> BareVehicle:
    try:
        return BareVehicle(bench, bench_file.world, scene=scene, seed=seed, ahead=False)
    except WorldError as error:
        raise UnavailableError(str(error), where=f"scene {scene or bench_file.world.scene}") from error
