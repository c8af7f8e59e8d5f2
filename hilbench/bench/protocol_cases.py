"""The bench of one case of a protocol: its device in virtual time, or what somebody else runs at a port."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from hilbench.bench import Bench
from hilbench.bench.about import about_line, about_world
from hilbench.bench.cases import CaseBase
from hilbench.bench.devices import SerialDevice
from hilbench.bench.line_faults import LineFaults
from hilbench.bench.line_peer import LinePeer
from hilbench.bench.placed_device import DEVICE, PlacedDevice
from hilbench.bench.protocol_peer import peer_of
from hilbench.bench.state_reporter import Observed, Sense
from hilbench.benchfile.bench_file import BenchFile
from hilbench.judging.provider import CaseInfo
from hilbench.judging.verdicts import NotApplicable
from hilbench.links import Line, MemoryLink
from hilbench.plugins.protocol import Device, ProtocolPlugin

__all__ = ["DeviceCase", "PeerCase", "device_baud", "machines_of"]


def device_baud(bench_file: BenchFile, protocol: ProtocolPlugin) -> int:
    """Return the rate of the line of a plug-in's model, in bit/s."""
    return bench_file.links[0].baud if bench_file.links else protocol.baud


def machines_of(devices: Mapping[str, SerialDevice]) -> dict[str, Observed]:
    """Return the state machines of those devices that have any to be looked at, as their attribute ``observed``.

    A device that is several, such as the nodes of a bus, has them there by names of their own.
    """
    found: dict[str, Observed] = {}
    for name, device in devices.items():
        observed = getattr(device, "observed", None)
        if isinstance(observed, Mapping):
            found |= observed
        elif observed is not None:
            found[name] = observed
    return found


class PeerCase(CaseBase):
    """A case with the checker at one end of a line, and nothing of ours at the other.

    Args:
        bench: whose time passes.
        case: what is known of it.
        peer: the checker's end of the line.
        protocol: what is spoken there.
        faults: what goes wrong on the line.
    """

    def __init__(
        self,
        bench: Bench,
        case: CaseInfo,
        peer: LinePeer[Any],
        protocol: ProtocolPlugin,
        faults: LineFaults | None = None,
    ) -> None:
        self.peer = peer
        self.protocol = protocol
        super().__init__(bench, case, faults)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        raise NotApplicable(f"a bench of {self.protocol.title} has no '{name}'")

    def _peers(self) -> Mapping[str, LinePeer[Any]]:
        return {"host": self.peer}

    def _about_view(self) -> Mapping[str, Any]:
        return about_line("checker", self.protocol.name, self._machines_seen())


class DeviceCase(PeerCase):
    """A case on the device that a plug-in brings, in virtual time.

    Args:
        bench: made for this case alone.
        bench_file: says what the device is set to, and where it stands.
        case: what is known of it.
        protocol: what is spoken.
        made: makes the device.
        faults: what goes wrong on the line.

    Attributes:
        world: the truth about where the device stands; only where it has a body.
    """

    def __init__(
        self,
        bench: Bench,
        bench_file: BenchFile,
        case: CaseInfo,
        protocol: ProtocolPlugin,
        made: Device,
        faults: LineFaults | None = None,
    ) -> None:
        line = Line(baud=device_baud(bench_file, protocol))
        link = MemoryLink(bench.scheduler, line, name="host", faults=faults.plan if faults is not None else None)
        super().__init__(bench, case, peer_of(bench, link.a, protocol), protocol, faults)
        self._senses = {DEVICE: dict.fromkeys(made.resting, Sense.REST)}
        self._placed = PlacedDevice(bench, bench_file, made, link.b, scene=case.scene or None, seed=case.seed)
        if self._placed.world is not None:
            self.world = self._placed.world

    def close(self) -> None:
        """Give the world back."""
        self._placed.close()

    def _about_view(self) -> Mapping[str, Any]:
        return {**super()._about_view(), **about_world(self._placed.world)}

    def _machines_seen(self) -> Mapping[str, Observed]:
        return machines_of({DEVICE: self._placed.device})
