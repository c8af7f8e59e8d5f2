"""Gives each case of a protocol its bench: a fresh device in virtual time, or what is at a port."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from hilbench.bench.line_faults import LineFaults
from hilbench.bench.line_peer import LinePeer
from hilbench.bench.locked_providers import AttachedProviderBase
from hilbench.bench.protocol_cases import DeviceCase, PeerCase, device_baud
from hilbench.bench.protocol_peer import peer_of
from hilbench.bench.shared import Shared
from hilbench.clock import Scheduler
from hilbench.judging.provider import CaseInfo
from hilbench.links import Line, Port
from hilbench.plugins.protocol import ProtocolPlugin

__all__ = ["AttachedPeerProvider", "DeviceProvider"]


class DeviceProvider:
    """Gives each case a fresh device.

    Args:
        shared: bench file, journal, waiting.
        protocol: what is spoken; it brings the device.
        settings: of the device.
    """

    def __init__(self, shared: Shared, protocol: ProtocolPlugin, settings: Any) -> None:
        assert protocol.device is not None
        self._shared = shared
        self._protocol = protocol
        self._device = protocol.device
        self._settings = settings

    @property
    def capabilities(self) -> frozenset[str]:
        """That the protocol is spoken, and what else the device says it can do."""
        return self._device.capabilities | {self._protocol.title}

    @property
    def suites(self) -> Sequence[str]:
        """The suites of the bench file."""
        return self._shared.suites

    def describe(self) -> Mapping[str, str]:
        """Name the bench and its target."""
        return self._shared.describe(f"model of {self._protocol.title}", "none")

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[DeviceCase]:
        """Open a bench for one case."""
        bench = self._shared.bench(Scheduler())
        made: list[DeviceCase] = []

        def interrupted() -> None:
            for one in made:
                one.peer.line_expected = False

        faults = self._shared.line_faults(bench, case, near_is_client=True, on_interruption=interrupted)
        device = self._device.make(self._settings)
        line = Line(baud=device_baud(self._shared.bench_file, self._protocol))
        made.append(DeviceCase(bench, case, self._protocol, device, line, faults))
        yield made[0]

    def close(self) -> None:
        """Close what the benches of the run had in common."""
        self._shared.close()


class AttachedPeerProvider(AttachedProviderBase[LinePeer[Any], PeerCase]):
    """What speaks the protocol at a serial port or behind any pyserial URL.

    Args:
        shared: bench file, journal, waiting.
        spec: the target as on the command line.
        protocol: what is spoken there.
    """

    def __init__(self, shared: Shared, spec: str, protocol: ProtocolPlugin) -> None:
        super().__init__(shared, spec, protocol.baud)
        self._protocol = protocol

    @property
    def capabilities(self) -> frozenset[str]:
        """That the protocol is spoken; more is not known of a stranger."""
        return frozenset({self._protocol.title})

    def _make_peer(self, port: Port) -> LinePeer[Any]:
        return peer_of(self._bench, port, self._protocol)

    def _make_case(
        self, case: CaseInfo, peer: LinePeer[Any], reopen: Callable[[], Port], faults: LineFaults | None = None
    ) -> PeerCase:
        del reopen  # no case hangs up
        return PeerCase(self._bench, case, peer, self._protocol, faults)
