"""A system: a robot, a car or another thing that is driven, and the boards in it.

A protocol has its own record (`hilbench.plugins.protocol`). A system is what surrounds it: models and vehicles, and how
they are checked, served, driven and shown. Generic code calls the methods of this class and knows no system by name.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Protocol, runtime_checkable

from hilbench.errors import UsageError
from hilbench.plugins.protocol import ClauseEntry, ProtocolPlugin
from protocols.common.decoding import Speaker

if TYPE_CHECKING:
    from hilbench.bench import Bench
    from hilbench.bench.cases import CaseBase
    from hilbench.bench.served_targets import ServedTarget
    from hilbench.bench.shared import Shared
    from hilbench.bench.state_reporter import Observed
    from hilbench.bench.world_runner import WorldRunner
    from hilbench.benchfile.bench_file import BenchFile
    from hilbench.benchfile.world_signals import WorldSignal, WorldSignals
    from hilbench.driving.rig import Rig
    from hilbench.judging.provider import BenchProvider, CaseInfo
    from hilbench.links import Port
    from hilbench.mcu.emulated import EmulatedBench
    from hilbench.plugins.dashboard import Dashboard
    from hilbench.plugins.demo import Demo
    from hilbench.terminal.options import TargetChoice
    from worlds.vehicles import Vehicle
    from worlds.world import World

__all__ = ["API", "HandRequest", "ModelKind", "Standing", "System", "VehicleKind", "device_kind"]

API = 1
"""Of this class; a plug-in says which one it was written for."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelKind:
    """A kind of behavioural model. A bench file names it as ``model = "NAME"``.

    Attributes:
        settings: the class of its settings, a dataclass.
        protocol: the title of the protocol on its lines. A bench with this model has the capability of this name.
        suites: the suites that are run by default on a bench with this model. A board that runs one of these suites
            speaks this protocol, too.
        baud: the default rate of its lines, in bit/s.
        rates: the rates that its lines support, in bit/s; empty for any.
        lines: its ends of links. A bench file writes them as ``NAME.LINE``.
        bench: the built-in bench with this model alone, on which its suites are run by default; empty for the default
            bench.
        target: its name as a TARGET; empty if it cannot be one.
        beside: whether a bench may have another model, too.
        has_body: whether it stands in a world.
    """

    settings: type[Any]
    protocol: str
    suites: tuple[str, ...]
    baud: int = 9600
    rates: tuple[int, ...] = ()
    lines: tuple[str, ...] = ("host",)
    bench: str = ""
    target: str = ""
    beside: bool = False
    has_body: bool = False


def device_kind(protocol: ProtocolPlugin) -> ModelKind:
    """Return the device of a protocol as a kind of model; without a device it has no settings."""
    device = protocol.device
    return ModelKind(
        settings=dict if device is None else device.settings,
        protocol=protocol.title,
        suites=tuple(map(str, protocol.suites)),
        baud=protocol.baud,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleKind:
    """A vehicle that parts of a bench can drive and sense. A bench file names it as ``vehicle = "NAME"``.

    Attributes:
        vehicle: returns the description of its body for the physics.
        body: makes the vehicle in an open world.
        signals: the signals that it takes from parts and gives to them, by name.
        wire: connects these signals to a body; called with the body and the names of the signals that are read.
        size_m: length and width seen from above, in m.
        stands_ready: whether a bench with boards has it even if no part drives or senses it.
    """

    vehicle: Callable[[], Vehicle]
    body: Callable[[World], Any]
    signals: Mapping[str, WorldSignal]
    wire: Callable[[Any, Sequence[str]], WorldSignals]
    size_m: tuple[float, float]
    stands_ready: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class HandRequest:
    """Something that a check may ask the operator of a target at a port.

    Attributes:
        text: what to do, in the imperative, as in ``press the reset button``; or a question, if there are `answers`.
            ``{}`` is replaced by the words of the case.
        capability: the capability that it provides. Clauses name it in their `needs`.
        answers: the possible answers to a question; empty for something to do.
        undo: the name of the request that undoes it; empty if nothing has to be undone.
    """

    text: str
    capability: str
    answers: tuple[str, ...] = ()
    undo: str = ""


@runtime_checkable
class Standing(Protocol):
    """A model with a body, which stands in its world beside boards."""

    @property
    def world(self) -> World:
        """The world."""

    @property
    def body(self) -> Any:
        """The vehicle in it, as the parts of its bench drive and sense it."""

    @property
    def runner(self) -> WorldRunner:
        """Who moves the world."""

    @property
    def machines(self) -> Mapping[str, Observed]:
        """Its state machines, by their source in the journal."""

    def close(self) -> None:
        """Give the world back."""


class System:
    """A system. Derive from this class, and override what your system has or does differently.

    Attributes:
        api: the version of this class that it was written for, `API`.
        name: its name. The benches, models and vehicles of a plug-in have this name, or begin with ``NAME-``.
        title: its name for people.
        summary: what it is, in a few words.
        vehicles: its vehicles, by name.
        benches: the folder of its benches, with one ``NAME.toml`` each; None if it brings none.
        speakers: the sources of a journal that only this system has, each with the speaker there: host or target.
        checkers: those of these sources that belong to the checker, each with the speaker that is under test.
        hand_requests: what a check may ask the operator of a target at a port, by the names that an operator hook gets.
    """

    api: int = 0
    name: str = ""
    title: str = ""
    summary: str = ""
    vehicles: Mapping[str, Callable[[], VehicleKind]] = MappingProxyType({})
    benches: Path | None = None
    speakers: Mapping[str, Speaker] = MappingProxyType({})
    checkers: Mapping[str, Speaker] = MappingProxyType({})
    hand_requests: Mapping[str, HandRequest] = MappingProxyType({})

    def models(self) -> Mapping[str, ModelKind]:
        """Return its behavioural models, by their names in a bench file."""
        return {}

    def clauses(self) -> Sequence[ClauseEntry]:
        """Return the clauses of its benches, in addition to those of its protocols."""
        return ()

    # --- a check

    def provider(self, shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider:
        """Return the provider of benches for a check of one of its models, or of a chosen target in its place.

        Args:
            shared: what all benches of the run have in common: bench file, journal, operator.
            choices: the targets of ``--target``.

        Raises:
            UsageError: it cannot be checked, or not with this target.
        """
        del choices
        raise UsageError(f"system '{self.name}' brings nothing that checks its models", where=shared.bench_file.name)

    def board_provider(self, shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider | None:
        """Return the provider for a bench whose boards run its suites; None for the usual one of emulated boards.

        Args:
            shared: what all benches of the run have in common: bench file, journal, operator.
            choices: the targets of ``--target``.

        Raises:
            UsageError: it cannot be checked with this target.
        """
        del shared, choices
        return None

    def board_capabilities(self, bench_file: BenchFile) -> Iterable[str]:
        """Return the capabilities of a bench of emulated boards, for its cases."""
        del bench_file
        return ()

    def needs_board(self, case: CaseInfo) -> bool:
        """Return whether a case on a bench of boards needs a board."""
        del case
        return True

    def without_board(self, shared: Shared, bench: Bench, case: CaseInfo) -> CaseBase:
        """Return the bench of a case that needs no board."""
        raise NotImplementedError(f"system '{self.name}' has a case that needs no board, and no bench for it")

    def with_board(self, shared: Shared, case: CaseInfo, emulated: EmulatedBench) -> CaseBase | None:
        """Return the bench of a case on emulated boards; None for the usual one."""
        del shared, case, emulated
        return None

    def about_board(self, bench_file: BenchFile, program: str) -> Mapping[str, Any]:
        """Return what the journal of a case on emulated boards has for viewers; see `hilbench.bench.about`.

        Args:
            bench_file: the bench.
            program: which program the board runs, if it has several.
        """
        del bench_file, program
        return {}

    def stand(self, bench: Bench, bench_file: BenchFile, line: Callable[[int], Port], *, seed: int) -> Standing:
        """Make the model with a body for a bench that has boards, too.

        Args:
            bench: the bench, with its time and journal.
            bench_file: the settings of the model, and its world.
            line: returns the model's end of its line, for a rate in bit/s.
            seed: the seed of everything random.

        Raises:
            UsageError: the system has no such model.
        """
        del bench, line, seed
        raise UsageError(f"system '{self.name}' has no model that stands beside boards", where=bench_file.name)

    def beside_boards(self, bench_file: BenchFile, *, seed: int) -> ServedTarget:
        """Return the model without a body whose lines lead to boards of its bench; nothing of it comes from the host.

        Args:
            bench_file: a bench with boards.
            seed: the seed of everything random.

        Raises:
            UsageError: the system has no such model.
        """
        return self.served(bench_file, scene=None, baud=None, seed=seed)

    # --- a bench that is served, or live

    def served(self, bench_file: BenchFile, *, scene: str | None, baud: int | None, seed: int) -> ServedTarget:
        """Return the model of a bench file as a target for ``hilbench serve``.

        Args:
            bench_file: a bench without boards.
            scene: the scene, instead of that of the file.
            baud: the rate of its lines in bit/s, instead of that of the file.
            seed: the seed of everything random.

        Raises:
            UsageError: it cannot be served, or not with this scene or rate.
        """
        del scene, baud, seed
        raise UsageError(f"system '{self.name}' brings nothing that serves its models", where=bench_file.name)

    def rig(self, bench: Bench, bench_file: BenchFile, *, seed: int) -> Rig:
        """Build the model of a bench file and a client for it, for the dashboard.

        Raises:
            UsageError: the dashboard cannot show it.
            UnavailableError: the physics engine is not installed.
        """
        del bench, seed
        raise UsageError(f"system '{self.name}' brings no view of its models", where=bench_file.name)

    def board_rig(self, emulated: EmulatedBench, *, seed: int) -> Rig | None:
        """Return the client that speaks to the emulated boards of a bench in the dashboard; None for none.

        The boards belong to the caller, who closes them.
        """
        del emulated, seed
        return None

    def speaks_to(self, bench_file: BenchFile) -> bool:
        """Return whether its clients can speak to the boards of a bench: one of its suites is run on them."""
        return any({*kind.suites} & {*bench_file.suites} for kind in self.models().values())

    def lines_asked(self, bench_file: BenchFile, choices: Sequence[TargetChoice]) -> Mapping[str, str]:
        """Return the port at the far end of each line, by the name of the line; an only line has an empty name.

        Args:
            bench_file: the bench.
            choices: the targets of ``--target``.

        Raises:
            UsageError: a line has no port or two, or there is no such line.
        """
        del bench_file
        first, *more = choices
        if more or first.name:
            where = " ".join(choice.where for choice in choices)
            hint = f"write --target {first.spec}"
            raise UsageError("this bench has one line, without a name", where=where, hint=hint)
        return {"": first.spec}

    def attached_rig(self, bench: Bench, bench_file: BenchFile, ports: Mapping[str, str], *, seed: int) -> Rig:
        """Attach the dashboard to a device at ports. Nothing drives it until the user does.

        Args:
            bench: the bench, with its time and journal.
            bench_file: the bench file, which defines the lines.
            ports: the port of each line, as `lines_asked` returns them.
            seed: the seed of random faults.

        Raises:
            UsageError: the system has no client for it.
            UnavailableError: a port cannot be opened.
        """
        del bench, ports, seed
        raise UsageError(f"system '{self.name}' brings no client for a real one", where=bench_file.name)

    def scene(self, bench_file: BenchFile) -> str | None:
        """Return the default scene of a bench in the dashboard; None for that of its file."""
        del bench_file
        return None

    def dashboard(self) -> Dashboard | None:
        """Return how the dashboard shows its benches; None for the default."""
        return None

    def demo(self, *, physics: bool) -> Demo | None:
        """Return the script of ``hilbench demo NAME``; None for none.

        Args:
            physics: whether a physics engine is installed; without one a bench with a world may not open.
        """
        del physics
        return None
