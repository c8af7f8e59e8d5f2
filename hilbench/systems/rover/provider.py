"""Benches of a rover: a fresh behavioural one for each case, in virtual time, or one at the end of a port."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

from hilbench.bench import Bench
from hilbench.bench.line_faults import LineFaults
from hilbench.bench.locked_providers import AttachedProviderBase, FarEnd
from hilbench.bench.shared import Shared
from hilbench.clock import Scheduler
from hilbench.errors import UsageError
from hilbench.journal import Journal
from hilbench.judging.observations import Observations
from hilbench.judging.provider import CaseInfo
from hilbench.links import Line, MemoryLink, Port
from hilbench.systems.rover.cases import (
    AttachedRoverCase,
    HostCase,
    RoverFactory,
    VirtualRoverCase,
    make_rover,
    rover_baud,
)
from hilbench.systems.rover.client import OWN_HOST_CAPABILITIES, OwnHost
from hilbench.systems.rover.ground_station import GroundStation
from hilbench.systems.rover.hands import MODEL_HANDS, REOPEN, OperatorHands
from hilbench.systems.rover.observing import RoverObserver
from hilbench.systems.rover.peer import RoverPeer
from hilbench.systems.rover.reporting_station import REPORTED_CAPABILITIES, ReportingStation
from hilbench.systems.rover.scripted import ScriptedRover
from protocols.pkt import PROFILES, Profile, ReportId
from targets.robots.rover import PROFILE_NAMES, RoverSettings

__all__ = ["AttachedRoverProvider", "HostFactory", "RoverProvider", "foreign_host", "make_host"]

HostFactory = Callable[[Bench, Port, Profile], GroundStation]


def make_host(bench: Bench, port: Port, profile: Profile) -> GroundStation:
    """Make our ground station as it is meant to be: the client of a profile."""
    return GroundStation(bench, port, profile)


class RoverProvider:
    """Gives each case a fresh behavioural rover of the profile it asks for.

    Args:
        shared: bench file, journal, waiting.
        settings: other ones than those of the bench file.
        make_rover: makes the rover.
        make_host: makes the host under test.
    """

    def __init__(
        self,
        shared: Shared,
        *,
        settings: RoverSettings | None = None,
        make_rover: RoverFactory = make_rover,
        make_host: HostFactory = make_host,
    ) -> None:
        self._shared = shared
        self._settings = settings or _settings_of(shared)
        self._make_rover = make_rover
        self._make_host = make_host
        self._observer = RoverObserver()

    @property
    def capabilities(self) -> frozenset[str]:
        """Everything, in every profile."""
        programs = {f"program '{name}'" for name in PROFILE_NAMES}
        return MODEL_HANDS | OWN_HOST_CAPABILITIES | programs | {"PKT!", "server", REOPEN}

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
        defects = ", ".join(self._settings.defects)
        target = "behavioural rover" + (f" with {defects}" if defects else "")
        return self._shared.describe(target, "none: wheels lifted")

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[VirtualRoverCase | HostCase]:
        """Open a bench for one case."""
        bench = self._shared.bench(Scheduler())
        of_host = "client" in case.needs
        made: VirtualRoverCase | None = None

        def interrupted() -> None:
            if made is not None:
                made.peer.line_expected = False

        faults = self._shared.line_faults(bench, case, near_is_client=not of_host, on_interruption=interrupted)
        settings = self._settings
        if case.setup.program:
            settings = replace(settings, profile=case.setup.program)  # type: ignore[arg-type]
        line = Line(baud=rover_baud(self._shared.bench_file))
        if of_host:
            profile = PROFILES[settings.profile]
            plan = faults.plan if faults is not None else None
            link = MemoryLink(bench.scheduler, line, name="host", faults=plan)
            station = self._make_host(bench, link.b, profile)
            yield HostCase(bench, case, ScriptedRover(bench, link.a, profile), OwnHost(station), faults)
            self._observer.take(station.connection)
            return
        made = VirtualRoverCase(bench, case, settings, line, make_rover=self._make_rover, faults=faults)
        yield made
        self._observer.take(made.robot.connection)

    def observed(self) -> Observations:
        """Return how much of the state tables the cases went through."""
        return Observations(coverage=self._observer.coverage())

    def close(self) -> None:
        """Close what the benches of the run had in common."""
        self._shared.close()


class AttachedRoverProvider(AttachedProviderBase[RoverPeer, AttachedRoverCase]):
    """A rover that somebody else runs, at a serial port or behind any pyserial URL; its profile is the bench file's."""

    USUAL_BAUD = 115200
    """What the published client opens its port at (nhorro/ceai2020 rover_client), in bit/s."""

    @property
    def capabilities(self) -> frozenset[str]:
        """Its line, in the one profile that it has, and what it says on it of its motors, if it does."""
        rates = PROFILES[self._profile].server.rates
        reported = {"motion reports"} if any(rate.report is ReportId.MOTION for rate in rates) else set()
        return frozenset({"PKT!", "server", REOPEN, f"program '{self._profile}'", *reported})

    @property
    def by_hand(self) -> frozenset[str]:
        """What the operator brings."""
        return frozenset() if self._shared.operator is None else self._shared.operator.capabilities

    @property
    def _profile(self) -> str:
        """The one of the model on the bench; a bench of boards has the documented rover's."""
        settings = self._shared.bench_file.settings_of(RoverSettings)
        return "documented" if settings is None else settings.profile

    def _make_peer(self, port: Port) -> RoverPeer:
        return RoverPeer(self._bench, port, PROFILES[self._profile])

    def _make_case(
        self, case: CaseInfo, peer: RoverPeer, reopen: Callable[[], Port], faults: LineFaults | None = None
    ) -> AttachedRoverCase:
        hands = None if self._beside is None else OperatorHands(self._beside)
        if hands is not None and "boot" in case.by_hand:
            hands.boot(peer)
        return AttachedRoverCase(self._bench, case, peer, reopen, faults, hands)


def foreign_host(shared: Shared) -> FarEnd:
    """Return what a foreign host finds at the far end of its line, on a bench with a rover."""
    profile = _settings_of(shared).profile

    def serve(bench: Bench, port: Port) -> ScriptedRover:
        return ScriptedRover(bench, port, PROFILES[profile])

    return FarEnd(
        serve=serve,
        case=HostCase,
        capabilities=frozenset({"PKT!", f"program '{profile}'"}),
        reporting=lambda bench, port: ReportingStation(bench, port, PROFILES[profile]),
        reported_capabilities=REPORTED_CAPABILITIES,
    )


def _settings_of(shared: Shared) -> RoverSettings:
    settings = shared.bench_file.settings_of(RoverSettings)
    if settings is None:
        raise UsageError("names no rover among its targets", where=str(shared.bench_file.path))
    return settings
