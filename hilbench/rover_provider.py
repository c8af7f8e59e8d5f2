"""Benches of a rover: a fresh behavioural one for each case, in virtual time, or one at the end of a port."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace

from hilbench.check.provider import CaseInfo
from hilbench.clock import Scheduler
from hilbench.errors import UsageError
from hilbench.line_faults import LineFaults
from hilbench.links import Line, Port
from hilbench.locked_providers import AttachedProviderBase
from hilbench.rover_cases import AttachedRoverCase, RoverFactory, VirtualRoverCase, make_rover, rover_baud
from hilbench.rover_hands import HANDS
from hilbench.rover_peer import RoverPeer
from hilbench.shared import Shared
from protocols.pkt import PROFILES
from targets.robots.rover import PROFILE_NAMES, RoverSettings

__all__ = ["AttachedRoverProvider", "RoverProvider"]


class RoverProvider:
    """Gives each case a fresh behavioural rover of the profile it asks for.

    Args:
        shared: bench file, journal, waiting.
        settings: other ones than those of the bench file.
        make_rover: makes the rover.
    """

    def __init__(
        self, shared: Shared, *, settings: RoverSettings | None = None, make_rover: RoverFactory = make_rover
    ) -> None:
        self._shared = shared
        self._settings = settings or _settings_of(shared)
        self._make_rover = make_rover

    @property
    def capabilities(self) -> frozenset[str]:
        """Everything, in every profile."""
        return HANDS | {"server", *(f"program '{name}'" for name in PROFILE_NAMES)}

    @property
    def suites(self) -> Sequence[str]:
        """The suites of the bench file."""
        return self._shared.suites

    def describe(self) -> Mapping[str, str]:
        """Name the bench and its target."""
        defects = ", ".join(self._settings.defects)
        target = "behavioural rover" + (f" with {defects}" if defects else "")
        return self._shared.describe(target, "none: wheels lifted")

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[VirtualRoverCase]:
        """Open a bench for one case."""
        bench = self._shared.bench(Scheduler())
        faults = self._shared.line_faults(bench, case, near_is_client=True)
        settings = self._settings
        if case.setup.program:
            settings = replace(settings, profile=case.setup.program)  # type: ignore[arg-type]
        line = Line(baud=rover_baud(self._shared.bench_file))
        yield VirtualRoverCase(bench, case, settings, line, make_rover=self._make_rover, faults=faults)

    def close(self) -> None:
        """Close the journal."""
        self._shared.journal.close()


class AttachedRoverProvider(AttachedProviderBase[RoverPeer, AttachedRoverCase]):
    """A rover that somebody else runs, at a serial port or behind any pyserial URL; its profile is the bench file's."""

    @property
    def capabilities(self) -> frozenset[str]:
        """Its line, in the one profile that it has."""
        return frozenset({"server", f"program '{self._profile}'"})

    @property
    def _profile(self) -> str:
        return _settings_of(self._shared).profile

    def _make_peer(self, port: Port) -> RoverPeer:
        return RoverPeer(self._bench, port, PROFILES[self._profile])

    def _make_case(
        self, case: CaseInfo, peer: RoverPeer, reopen: Callable[[], Port], faults: LineFaults | None = None
    ) -> AttachedRoverCase:
        del reopen  # no case hangs up
        return AttachedRoverCase(self._bench, case, peer, faults)


def _settings_of(shared: Shared) -> RoverSettings:
    settings = shared.bench_file.rover
    if settings is None:
        raise UsageError("names no rover among its targets", where=str(shared.bench_file.path))
    return settings
