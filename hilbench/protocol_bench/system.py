"""A protocol as a system: the device and the host that its record brings, in a world where the device has a body."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from hilbench.plugins.protocol import Device, ProtocolPlugin
from hilbench.plugins.system import API, ModelKind, System, device_kind

if TYPE_CHECKING:
    from hilbench.bench import Bench
    from hilbench.bench.served_targets import ServedTarget
    from hilbench.bench.shared import Shared
    from hilbench.bench.state_reporter import Observed, Senses
    from hilbench.benchfile.bench_file import BenchFile, ModelTarget
    from hilbench.driving.rig import Rig
    from hilbench.driving.tap import Tap
    from hilbench.judging.provider import BenchProvider
    from hilbench.links import Port
    from hilbench.mcu.emulated import EmulatedBench
    from hilbench.terminal.options import TargetChoice

__all__ = ["ProtocolSystem", "system_of"]

_CLIENT = "client"
"""The source in the journal of the host that a protocol brings."""


def system_of(model: ModelTarget) -> System:
    """Return whose a model is; a protocol's device is that of a system around the protocol alone."""
    return model.owner if isinstance(model.owner, System) else ProtocolSystem(model.owner)


class ProtocolSystem(System):
    """See the module.

    A system of one's own whose model is such a device derives from it.

    Args:
        protocol: the protocol; it brings a device where a model of it stands on a bench.
        has_body: the device stands in a world: it is `hilbench.bench.placed_device.Embodied`.

    Attributes:
        kind: of its model.
    """

    api = API

    def __init__(self, protocol: ProtocolPlugin, *, has_body: bool = False) -> None:
        self.name = protocol.name
        self.title = protocol.title
        self._protocol = protocol
        self.kind = replace(device_kind(protocol), has_body=has_body)

    def models(self) -> Mapping[str, ModelKind]:
        """See `System`."""
        return {self.name: self.kind}

    def provider(self, shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider:
        """See `System`."""
        from hilbench.bench.protocol_providers import AttachedPeerProvider, DeviceProvider
        from hilbench.bench.target_choice import only_port

        if choices:
            return AttachedPeerProvider(shared, only_port(shared, choices).spec, self._protocol)
        return DeviceProvider(shared, self._protocol)

    def served(self, bench_file: BenchFile, *, scene: str | None, baud: int | None, seed: int) -> ServedTarget:
        """See `System`."""
        from hilbench.bench.placed_device import DEVICE, PlacedDevice
        from hilbench.bench.protocol_cases import device_baud
        from hilbench.bench.served_targets import HOST_LINE, ServedTarget

        device = self._protocol.device
        assert device is not None

        def make(bench: Bench, ports: Mapping[str, Port]) -> Callable[[], None]:
            return PlacedDevice(bench, bench_file, device, ports[HOST_LINE], scene=scene, seed=seed).close

        return ServedTarget({HOST_LINE: baud or device_baud(bench_file, self._protocol)}, make, DEVICE)

    def rig(self, bench: Bench, bench_file: BenchFile, *, seed: int) -> Rig:
        """See `System`."""
        from hilbench.bench.about import about_world
        from hilbench.bench.placed_device import DEVICE, PlacedDevice
        from hilbench.bench.protocol_cases import device_baud, machines_of
        from hilbench.links import Line, MemoryLink
        from hilbench.links.memory import REAL_TIME_GROUP_NS

        made = self._protocol.device
        assert made is not None
        line = Line(baud=device_baud(bench_file, self._protocol))
        link = MemoryLink(bench.scheduler, line, name="host", group_ns=REAL_TIME_GROUP_NS)
        placed = PlacedDevice(bench, bench_file, made, link.b, seed=seed)
        tap, machines = self._host(bench, link.a, seed)
        rig = self._rig(tap, {**machines, **machines_of({DEVICE: placed.device})}, {DEVICE: made})
        _show(bench, DEVICE, placed.device)
        look = getattr(placed.device, "look", None)
        views = {} if look is None else {self.name: look}
        return replace(rig, views=views, about={**rig.about, **about_world(placed.world)}, close=placed.close)

    def board_rig(self, emulated: EmulatedBench, *, seed: int) -> Rig | None:
        """See `System`."""
        far_end = emulated.bench_file.checker_lines.get("", "")
        if emulated.bench_file.protocols.get(far_end) is not self._protocol:
            return None
        return self._rig(*self._host(emulated.bench, emulated.far_ends.reacting(far_end), seed))

    def attached_rig(self, bench: Bench, bench_file: BenchFile, ports: Mapping[str, str], *, seed: int) -> Rig:
        """Listen to what is at a port: a host would speak, and move something, unasked."""
        from hilbench.bench.about import about_line
        from hilbench.driving.real_port import open_at
        from hilbench.driving.rig import Rig
        from hilbench.driving.tap import Tap

        port = open_at(bench, bench_file, ports[""], self._protocol.baud)
        about = about_line(_CLIENT, self.name, {})
        taps = {"host": Tap(bench, port, _CLIENT, seed=seed)}
        return Rig(taps=taps, about=about, demo=False, close=port.close)

    def _host(self, bench: Bench, port: Port, seed: int) -> tuple[Tap, Mapping[str, Observed]]:
        """Put the host of the protocol at the end of a line; where it brings none, the line is listened to."""
        from hilbench.bench.devices import DeviceActor
        from hilbench.bench.protocol_cases import machines_of
        from hilbench.driving.tap import Tap

        tap = Tap(bench, port, _CLIENT, seed=seed)
        if self._protocol.host is None:
            return tap, {}
        host = self._protocol.host.make(self._protocol.host.settings())
        DeviceActor(bench, host, tap, name=_CLIENT)
        _show(bench, _CLIENT, host)
        return tap, machines_of({_CLIENT: host})

    def _rig(self, tap: Tap, machines: Mapping[str, Observed], devices: Mapping[str, Device] | None = None) -> Rig:
        from hilbench.bench.about import about_line
        from hilbench.driving.rig import Rig

        there = {_CLIENT: self._protocol.host, **(devices or {})}
        about = about_line(_CLIENT, self.name, machines)
        return Rig(taps={"host": tap}, machines=machines, senses=_senses(there), about=about)


def _show(bench: Bench, name: str, device: object) -> None:
    """Let a dashboard show the tables of a device that has some."""
    look = getattr(device, "tables", None)
    if look is not None:
        bench.tables[name] = look


def _senses(devices: Mapping[str, Device | None]) -> Senses:
    from hilbench.bench.state_reporter import Sense

    return {name: dict.fromkeys(one.resting, Sense.REST) for name, one in devices.items() if one is not None}
