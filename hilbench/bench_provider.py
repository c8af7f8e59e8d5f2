"""Which benches there are, and which one a command line means.

A provider opens the bench of each case: a fresh virtual one, or what is at the other end of a real port, or a client
that connects to us. What it can do decides which cases apply; the names of the capabilities are those the clauses use.
"""

from __future__ import annotations

import contextlib
import importlib.util
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench.bench_file import BenchFile
from hilbench.cases import ClientFactory, Tap, VirtualCase, make_client, no_tap
from hilbench.check.observations import Observations
from hilbench.check.provider import BenchProvider, CaseInfo
from hilbench.client_under_test import OWN_CAPABILITIES
from hilbench.clock import Scheduler
from hilbench.config import DEFAULT_FILE, open_bench
from hilbench.errors import UnavailableError, UsageError
from hilbench.files import refuse_overwriting, refuse_writing_into
from hilbench.inputs import inputs_of, inputs_of_targets, lines_of
from hilbench.journal import Journal
from hilbench.links import Line, is_serial_target
from hilbench.locked_providers import AttachedProvider, ExecProvider, ListenProvider
from hilbench.model_kinds import MODEL_KINDS
from hilbench.nearest import did_you_mean
from hilbench.observing import VirtualObserver
from hilbench.options import CheckOptions, TargetChoice
from hilbench.pioneer.robot import PioneerPlan, plan_of
from hilbench.shared import Shared

if TYPE_CHECKING:
    from hilbench.through import Passages

__all__ = ["BULLET_CAPABILITIES", "VIRTUAL_CAPABILITIES", "Shared", "VirtualProvider", "make_provider"]

VIRTUAL_CAPABILITIES = frozenset({"P2OS", "server", "hangup", "baud", "truth"}) | OWN_CAPABILITIES
BULLET_CAPABILITIES = frozenset({"scene", "rays", "contacts", "gravity"})

_TARGET_KINDS = (
    "pioneer",
    "serial:PORT@BAUD",
    "socket://HOST:PORT",
    "listen:pty:PATH",
    "listen:tcp:PORT",
    "exec:COMMAND",
    "capture:FILE",
)
_ROVER_TARGET_KINDS = (
    "rover-model",
    "serial:PORT@BAUD",
    "socket://HOST:PORT",
    "listen:pty:PATH",
    "listen:tcp:PORT",
    "exec:COMMAND",
)
_VEHICLE_TARGET_KINDS = (
    "interface.PROFILE=vehicle-model:PROFILE",
    "LINE=serial:PORT@BAUD",
    "LINE=socket://HOST:PORT",
    "listen:pty:PATH",
    "listen:tcp:PORT",
    "exec:COMMAND",
)


def make_provider(options: CheckOptions) -> BenchProvider:
    """Return the provider that the options mean; nothing is opened yet.

    Raises:
        UsageError: the bench file or the target is wrong, or would be overwritten.
    """
    capture = next((choice for choice in options.targets if choice.spec.partition(":")[0] == "capture"), None)
    if capture is not None:
        return _capture(options, capture)
    bench_file = open_bench(_bench_of(options))
    refuse_overwriting(options.outputs(), [*inputs_of(bench_file), *inputs_of_targets(options.targets)])
    refuse_writing_into(options.outputs(), lines_of(choice.spec for choice in options.targets))
    if bench_file.boards and not (options.suites or bench_file.suites):
        hint = 'write suites = ["my_suite.py"] into it, or --suite; without clauses: pytest (hilbench init begins one)'
        raise UsageError("names no suite for its boards", where=str(bench_file.path), hint=hint)
    journal = Journal(options.journal, bench_file.header(options.seed), max_bytes=options.journal_max)
    passage = _passages(options.through) if options.through else None
    shared = Shared(bench_file=bench_file, timeout_scale=options.timeout_scale, journal=journal, passage=passage)
    if bench_file.vehicle is not None or _has_lines(bench_file):
        return _vehicle(shared, options)
    if bench_file.boards:
        at_port = len(options.targets) == 1 and is_serial_target(options.targets[0].spec)
        return _rover_at(shared, options.targets[0].spec) if at_port else _for_boards(shared, options)
    rover = bench_file.rover is not None
    if not options.targets:
        return _rover(shared) if rover else VirtualProvider(shared)
    if len(options.targets) > 1:
        raise UsageError("this bench has one target", where=f"--target {options.targets[1].spec}", hint="name only one")
    choice = options.targets[0]
    if choice.name and choice.name not in bench_file.targets:
        nearest = did_you_mean(choice.name, bench_file.targets, "targets")
        raise UsageError(f"no target '{choice.name}'", where=f"--target {choice.name}={choice.spec}", hint=nearest)
    return _rover_at(shared, choice.spec) if rover else _for_target(shared, choice.spec)


def _passages(kind: str) -> Passages:
    from hilbench.through import Passages

    return Passages(kind)


def _capture(options: CheckOptions, choice: TargetChoice) -> BenchProvider:
    from hilbench.capture_provider import CaptureProvider

    path = choice.spec.partition(":")[2]
    where = f"--target {choice.spec}"
    if not path:
        raise UsageError("names no recording", where=where, hint="write capture:FILE")
    if len(options.targets) > 1 or choice.name:
        raise UsageError(
            "a recording stands for the whole bench", where=where, hint="give no other target, and no NAME="
        )
    if options.bench is not None:
        raise UsageError("a recording needs no bench", where=options.bench, hint="leave it away")
    if options.through:
        raise UsageError("a recording has no lines", where=f"--through {options.through}", hint="leave it away")
    return CaptureProvider(options, Path(path))


def _bench_of(options: CheckOptions) -> str | None:
    """Return the bench that is meant; where none is named, and suites of a model are, it is that model's."""
    if options.bench is not None or DEFAULT_FILE.is_file() or not options.suites:
        return options.bench
    meant = [kind.bench for kind in MODEL_KINDS.values() if {*options.suites} <= {*kind.suites}]
    return (meant[0] if meant else "") or None


def _rover(shared: Shared) -> BenchProvider:
    from hilbench.rover.provider import RoverProvider

    return RoverProvider(shared)


def _rover_at(shared: Shared, spec: str) -> BenchProvider:
    from hilbench.rover.provider import AttachedRoverProvider, foreign_host

    if spec == "rover-model":
        return _rover(shared)
    kind, _, rest = spec.partition(":")
    if kind == "listen":
        return ListenProvider(shared, rest, foreign_host(shared))
    if kind == "exec" and rest:
        return ExecProvider(shared, rest, foreign_host(shared))
    if rest:
        return AttachedRoverProvider(shared, spec)
    hint = did_you_mean(spec, _ROVER_TARGET_KINDS, "a target of a rover's bench is one of")
    raise UsageError("not a target", where=f"--target {spec}", hint=hint)


def _has_lines(bench_file: BenchFile) -> bool:
    """Say whether the checker's lines have names, as those of a vehicle interface do."""
    return any(bench_file.checker_lines)


def _vehicle(shared: Shared, options: CheckOptions) -> BenchProvider:
    from hilbench.vehicle.provider import MODEL_TARGET, AttachedVehicleProvider, VehicleProvider, foreign_simulator

    kinds = {choice.spec.partition(":")[0] for choice in options.targets}
    of_boards = bool(shared.bench_file.boards)
    if kinds <= {MODEL_TARGET} and not of_boards:
        return VehicleProvider(shared, [choice for choice in options.targets if choice.spec != MODEL_TARGET])
    if of_boards and kinds & {"listen", "exec"}:
        spec = next(choice.spec for choice in options.targets if choice.spec.partition(":")[0] in ("listen", "exec"))
        raise UsageError(
            "a program in the place of the simulator's side is checked without a board, not on this bench",
            where=f"--target {spec}",
            hint=f"write hilbench check vehicle-model --suite vehicle-host --target '{spec}'",
        )
    if of_boards and not (options.targets and all(is_serial_target(choice.spec) for choice in options.targets)):
        return _for_boards(shared, options)
    if kinds <= {"listen", "exec"}:
        if len(options.targets) > 1:
            raise UsageError(
                "one simulator's side at a time", where=f"--target {options.targets[1].spec}", hint="name only one"
            )
        kind, _, rest = options.targets[0].spec.partition(":")
        provider = ListenProvider if kind == "listen" else ExecProvider
        return provider(shared, rest, foreign_simulator(shared))
    for choice in options.targets:
        if not is_serial_target(choice.spec):
            hint = did_you_mean(choice.spec, _VEHICLE_TARGET_KINDS, "a target of a vehicle interface's bench is one of")
            raise UsageError("not a target", where=f"--target {choice.spec}", hint=hint)
    return AttachedVehicleProvider(shared, options.targets)


def _for_boards(shared: Shared, options: CheckOptions) -> BenchProvider:
    from hilbench.mcu.board_provider import BoardProvider

    return BoardProvider(shared, options.targets)


def _for_target(shared: Shared, spec: str) -> BenchProvider:
    if spec == "pioneer":
        return VirtualProvider(shared)
    kind, _, rest = spec.partition(":")
    if kind == "listen":
        return ListenProvider(shared, rest)
    if kind == "exec" and rest:
        return ExecProvider(shared, rest)
    if rest:
        return AttachedProvider(shared, spec)
    raise UsageError(
        "not a target", where=f"--target {spec}", hint=did_you_mean(spec, _TARGET_KINDS, "a target is one of")
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
        settings, real_physics = self._plan.settings, self._plan.physics != "plane"
        capabilities = VIRTUAL_CAPABILITIES
        if real_physics:
            capabilities |= BULLET_CAPABILITIES
        if real_physics and settings.bumpers_fitted:
            capabilities |= {"bumpers"}
        if settings.aux_loop_back:
            capabilities |= {"aux-loopback"}
        return capabilities

    @property
    def suites(self) -> Sequence[str]:
        """The suites of the bench file."""
        return self._shared.suites

    def describe(self) -> Mapping[str, str]:
        """Name the bench, its target and its physics."""
        physics = f"{self._plan.physics} at {self._plan.step_hz} Hz"
        if self._plan.physics == "plane":
            physics += " (an endless floor without rays and contacts)"
        elif _physics_is_missing(self._plan):
            physics += " (not installed, and nothing here needs it)"
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
        if _physics_is_missing(self._plan) and any("client" not in case.needs for case in cases):
            raise UnavailableError(
                "PyBullet is not installed (it has wheels for CPython 3.11 on x86-64 and none newer)",
                where='physics = "bullet"',
                hint="run `hilbench check pioneer-plane`, or build it: pip install 'hilbench[physics-source]'",
            )

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


def _physics_is_missing(plan: PioneerPlan) -> bool:
    return plan.physics == "bullet" and importlib.util.find_spec("pybullet") is None
