"""Gives each case of a protocol its bench: a fresh device in virtual time, or what is at a port."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

from hilbench.bench.line_faults import LineFaults
from hilbench.bench.line_peer import LinePeer
from hilbench.bench.locked_providers import AttachedProviderBase
from hilbench.bench.physics import describe_physics, require_physics
from hilbench.bench.protocol_cases import DeviceCase, PeerCase
from hilbench.bench.protocol_peer import peer_of
from hilbench.bench.shared import Shared
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.judging.provider import CaseInfo
from hilbench.links import Port
from hilbench.plugins.protocol import ProtocolPlugin

__all__ = ["AttachedPeerProvider", "DeviceProvider"]


_IN_WORLD = frozenset({"truth", "scene", "rays", "contacts", "gravity"})
"""What a bench can do whose device has a body in a world."""


class DeviceProvider:
    """Gives each case a fresh device, in a world of its own where it has a body.

    Args:
        shared: bench file, journal, waiting.
        protocol: what is spoken; it brings the device.
    """

    def __init__(self, shared: Shared, protocol: ProtocolPlugin) -> None:
        model = shared.bench_file.model
        assert protocol.device is not None
        assert model is not None
        self._shared = shared
        self._protocol = protocol
        self._device = protocol.device
        self._has_body = model.kind.has_body

    @property
    def capabilities(self) -> frozenset[str]:
        """That the protocol is spoken, what there is to a world, and what else the device says it can do."""
        return self._device.capabilities | {self._protocol.title} | (_IN_WORLD if self._has_body else frozenset())

    @property
    def suites(self) -> Sequence[str]:
        """The suites of the bench file."""
        return self._shared.suites

    @property
    def recorded_in(self) -> Journal:
        """Where its cases are recorded."""
        return self._shared.journal

    def describe(self) -> Mapping[str, str]:
        """Name the bench and its target."""
        world = self._shared.bench_file.world
        physics = describe_physics(world.physics, world.step_hz) if self._has_body else "none"
        return self._shared.describe(f"model of {self._protocol.title}", physics)

    def prepare(self, cases: Sequence[CaseInfo]) -> None:
        """Make sure, before the first case, that there is a physics for the body.

        Raises:
            UnavailableError: it is not installed.
        """
        if cases and self._has_body:
            require_physics(self._shared.bench_file.world.physics)

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[DeviceCase]:
        """Open a bench for one case."""
        bench = self._shared.bench(Scheduler())
        made: list[DeviceCase] = []

        def interrupted() -> None:
            for one in made:
                one.peer.line_expected = False

        faults = self._shared.line_faults(bench, case, near_is_client=True, on_interruption=interrupted)
        made.append(DeviceCase(bench, self._shared.bench_file, case, self._protocol, self._device, faults))
        with contextlib.closing(made[0]):
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
