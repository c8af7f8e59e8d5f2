"""Benches of a Pioneer: a fresh virtual one for each case, in virtual time, or one at the end of a port."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence

from hilbench.bench.line_faults import LineFaults
from hilbench.bench.locked_providers import AttachedProviderBase, FarEnd
from hilbench.bench.physics import describe_physics, physics_capabilities, require_physics
from hilbench.bench.shared import Shared
from hilbench.clock import Scheduler
from hilbench.files.paths import real_path
from hilbench.journal import Journal
from hilbench.judging.observations import Observations
from hilbench.judging.provider import CaseInfo
from hilbench.links import Line, Port
from hilbench.systems.pioneer.cases import (
    AttachedCase,
    ClientFactory,
    ForeignClientCase,
    Tap,
    VirtualCase,
    make_client,
    no_tap,
)
from hilbench.systems.pioneer.observing import VirtualObserver
from hilbench.systems.pioneer.peer import Peer
from hilbench.systems.pioneer.reporting_client import REPORTED_CAPABILITIES, ReportingClient
from hilbench.systems.pioneer.robot import PioneerPlan, plan_of
from hilbench.systems.pioneer.scripted import ScriptedServer
from hilbench.systems.pioneer.under_test import OWN_CAPABILITIES

__all__ = [
    "P2OS_SERVER",
    "VIRTUAL_CAPABILITIES",
    "AttachedProvider",
    "VirtualProvider",
]

VIRTUAL_CAPABILITIES = (
    frozenset({"P2OS", "server", "hangup", "reopen", "baud", "uart", "flash", "user-io", "truth"}) | OWN_CAPABILITIES
)
_SERVER_CAPABILITIES = frozenset({"P2OS", "server", "reopen"})
_PSEUDO = "/dev/pts/"
P2OS_SERVER = FarEnd(
    serve=ScriptedServer,
    case=ForeignClientCase,
    capabilities=frozenset({"P2OS"}),
    reporting=ReportingClient,
    reported_capabilities=REPORTED_CAPABILITIES,
)


class VirtualProvider:
    """Gives each case a fresh virtual robot, in its world, in virtual time.

    Args:
        shared: bench file, journal, waiting.
        plan: the robot to build instead of the bench file's.
        make_client: makes the client under test.
        tap: what stands between the checker and the device.
    """

    def __init__(
        self,
        shared: Shared,
        *,
        plan: PioneerPlan | None = None,
        make_client: ClientFactory = make_client,
        tap: Tap = no_tap,
    ) -> None:
        self._shared = shared
        self._plan = plan or plan_of(shared.bench_file)
        self._make_client = make_client
        self._tap = tap
        self._observer = VirtualObserver()

    @property
    def capabilities(self) -> frozenset[str]:
        """Everything, but for what a world without contacts and rays cannot show and what is not fitted."""
        settings, of_bodies = self._plan.settings, physics_capabilities(self._plan.physics)
        capabilities = VIRTUAL_CAPABILITIES | of_bodies | ({"scene"} if of_bodies else set())
        if of_bodies and settings.bumpers_fitted:
            capabilities |= {"bumpers"}
        if settings.aux_loop_back:
            capabilities |= {"aux-loopback"}
        return capabilities

    @property
    def suites(self) -> Sequence[str]:
        """The suites of the bench file."""
        return self._shared.suites

    @property
    def recorded_in(self) -> Journal:
        """Where its cases are recorded."""
        return self._shared.journal

    def describe(self) -> Mapping[str, str]:
        """Name the bench, its target and its physics."""
        physics = describe_physics(self._plan.physics, self._plan.step_hz)
        return self._shared.describe("virtual Pioneer 2-DX", physics)

    def observed(self) -> Observations:
        """Return coverage and fidelity of what was tested so far."""
        return Observations(coverage=self._observer.coverage(), ledger=self._observer.ledger())

    def prepare(self, cases: Sequence[CaseInfo]) -> None:
        """Say that the physics is missing once and before anything runs, rather than in every case.

        A case of a client has a scripted server at the far end of its line and no robot: it needs no physics.

        Raises:
            UnavailableError: a case needs physics that is not installed.
        """
        if any("client" not in case.needs for case in cases):
            require_physics(self._plan.physics)

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[VirtualCase]:
        """Open a bench for one case."""
        line = Line(baud=self._plan.settings.host_baud)
        bench = VirtualCase(
            self._shared.bench(Scheduler()),
            case,
            self._plan,
            line,
            make_client=self._make_client,
            tap=self._tap,
            faults=self._shared.bench_file.faults,
        )
        try:
            yield bench
        finally:
            self._observer.take(bench)
            bench.close()

    def close(self) -> None:
        """Close what the benches of the run had in common."""
        self._shared.close()


class AttachedProvider(AttachedProviderBase[Peer, AttachedCase]):
    """A P2OS server that somebody else runs."""

    @property
    def capabilities(self) -> frozenset[str]:
        """A serial line has a rate that can be changed, a socket can be hung up; more is not known of a stranger.

        Behind a URL or a pseudo-terminal a robot may speak at any rate.
        """
        url = self._serial.url
        if "://" not in url:
            return _SERVER_CAPABILITIES | {"baud"} | (set() if real_path(url).startswith(_PSEUDO) else {"uart"})
        is_network = not url.startswith(("rfc2217:", "spy:", "hwgrep:"))
        return _SERVER_CAPABILITIES | ({"hangup"} if is_network else {"baud"})

    def _make_peer(self, port: Port) -> Peer:
        return Peer(self._bench, port)

    def _make_case(
        self, case: CaseInfo, peer: Peer, reopen: Callable[[], Port], faults: LineFaults | None = None
    ) -> AttachedCase:
        return AttachedCase(self._bench, case, peer, reopen, faults)
