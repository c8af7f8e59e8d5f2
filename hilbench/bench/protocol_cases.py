"""The bench of one case of a protocol: its device in virtual time, or what somebody else runs at a port."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from hilbench.bench import Bench
from hilbench.bench.about import about_line
from hilbench.bench.cases import CaseBase
from hilbench.bench.devices import DeviceActor, SerialDevice
from hilbench.bench.line_faults import LineFaults
from hilbench.bench.line_peer import LinePeer
from hilbench.bench.protocol_peer import peer_of
from hilbench.bench.teller import Observed
from hilbench.benchfile.bench_file import BenchFile
from hilbench.judging.provider import CaseInfo
from hilbench.judging.verdicts import NotApplicable
from hilbench.links import Line, MemoryLink, Port
from hilbench.plugins.protocol import ProtocolPlugin

__all__ = ["DEVICE", "DeviceCase", "PeerCase", "device_baud", "machines_of"]

DEVICE = "device"
"""The source of a model's events in the journal."""


def device_baud(bench_file: BenchFile, protocol: ProtocolPlugin) -> int:
    """Return the rate of the line of a plug-in's model, in bit/s."""
    return bench_file.links[0].baud if bench_file.links else protocol.baud


def machines_of(devices: Mapping[str, SerialDevice]) -> dict[str, Observed]:
    """Return the state machines of those devices that have one to be looked at, as their attribute ``observed``."""
    found = {name: getattr(device, "observed", None) for name, device in devices.items()}
    return {name: machine for name, machine in found.items() if machine is not None}


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

    def _lines_seen(self) -> Mapping[str, Port]:
        return {"host": self.peer.port}

    def _about_view(self) -> Mapping[str, Any]:
        return about_line("checker", self.protocol.name, self._machines_seen())

    def _packets(self) -> Sequence[str]:
        return self.peer.evidence()


class DeviceCase(PeerCase):
    """A case on the device that a plug-in brings, in virtual time.

    Args:
        bench: made for this case alone.
        case: what is known of it.
        protocol: what is spoken.
        device: the device.
        line: what lies between.
        faults: what goes wrong on it.
    """

    def __init__(
        self,
        bench: Bench,
        case: CaseInfo,
        protocol: ProtocolPlugin,
        device: SerialDevice,
        line: Line,
        faults: LineFaults | None = None,
    ) -> None:
        link = MemoryLink(bench.scheduler, line, name="host", faults=faults.plan if faults is not None else None)
        super().__init__(bench, case, peer_of(bench, link.a, protocol), protocol, faults)
        self.device = device
        DeviceActor(bench, device, link.b, name=DEVICE)

    def _machines_seen(self) -> Mapping[str, Observed]:
        return machines_of({DEVICE: self.device})
