"""What a system says of itself: a robot, a car, whatever is driven, and the boards in it.

A protocol has a record of its own (`hilbench.plugins.protocol`); a system is what stands around it: models, vehicles,
how they are checked, served, driven and shown. What is generic asks this class and knows no system by name.
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
    """One kind of behavioural model, which a bench file has as ``model = "NAME"``.

    Attributes:
        settings: the class of its settings, a dataclass.
        protocol: what is spoken on its lines, as the capability of that name: the protocol's title.
        suites: what is checked on a bench with it, unless its file says otherwise; a board on which one of them is run
            speaks this protocol, too.
        baud: of its lines, if the bench file says none, in bit/s.
        rates: that its lines can have, in bit/s; empty for any.
        lines: the ends of links that it has, as ``NAME.LINE``.
        bench: the built-in bench with it alone, which a run of its suites means; empty for the default one.
        target: what it is called as a TARGET; empty if it cannot be one.
        beside: it may stand beside another model.
        has_body: it stands in a world.
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
    """Return the kind of model that a protocol's device is; without a device it has no settings."""
    device = protocol.device
    return ModelKind(
        settings=dict if device is None else device.settings,
        protocol=protocol.title,
        suites=tuple(map(str, protocol.suites)),
        baud=protocol.baud,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleKind:
    """A vehicle that parts of a bench can drive and sense, which a bench file has as ``vehicle = "NAME"``.

    Attributes:
        vehicle: returns its body for the physics.
        body: makes the vehicle of an open world.
        signals: what it takes from parts and gives to them, by name.
        wire: makes who reads and drives these signals, of a body and the names of those that are read.
        size_m: length and breadth seen from above, in m.
        stands_ready: it stands in its world wherever boards are, also where no part drives or senses it.
    """

    vehicle: Callable[[], Vehicle]
    body: Callable[[World], Any]
    signals: Mapping[str, WorldSignal]
    wire: Callable[[Any, Sequence[str]], WorldSignals]
    size_m: tuple[float, float]
    stands_ready: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class HandRequest:
    """Something that a check may ask of somebody beside a target at a port.

    Attributes:
        text: what to do, in the imperative, as in ``press the reset button``; or the question, where there are answers.
            The words of a case stand where it has ``{}``.
        capability: what it is for, as the clauses name it in their `needs`.
        answers: what may be answered; empty where something is to be done.
        undo: the name of the request that takes it back; empty where nothing stays.
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
    """What generic code knows of a system; one of your own derives from it and says what is different.

    Attributes:
        api: the version of this class, `API`.
        name: what it is called. A plug-in's benches, models and vehicles are called like it, or begin with ``NAME-``.
        title: what people call it.
        summary: what it is, in a few words.
        vehicles: its vehicles, by name.
        benches: the folder of its benches, one ``NAME.toml`` each; None where they come with hilbench.
        speakers: who speaks at the sources of journals that it alone has.
        checkers: those of these that the checker holds in a case, and who is under test then.
        hand_requests: what may be asked of somebody beside its target at a port, by the names that a command gets.
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
        """Return its behavioural models, by the names that a bench file has for them."""
        return {}

    def clauses(self) -> Sequence[ClauseEntry]:
        """Return the rules of its benches, beside those of its protocols."""
        return ()

    # --- a check

    def provider(self, shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider:
        """Return who checks a bench with one of its models, or what is chosen in the place of that.

        Raises:
            UsageError: it cannot be checked, or not with this choice.
        """
        del choices
        raise UsageError(f"system '{self.name}' brings nothing that checks its models", where=shared.bench_file.name)

    def board_provider(self, shared: Shared, choices: Sequence[TargetChoice]) -> BenchProvider | None:
        """Return who checks a bench whose boards run its suites, with these choices; None for emulated boards.

        Raises:
            UsageError: not with these choices.
        """
        del shared, choices
        return None

    def board_capabilities(self, bench_file: BenchFile) -> Iterable[str]:
        """Return what a bench of emulated boards can do for its cases."""
        del bench_file
        return ()

    def needs_board(self, case: CaseInfo) -> bool:
        """Say whether a board runs in a case on a bench of boards."""
        del case
        return True

    def without_board(self, shared: Shared, bench: Bench, case: CaseInfo) -> CaseBase:
        """Return the bench of a case that needs no board."""
        raise NotImplementedError(f"system '{self.name}' has a case that needs no board, and no bench for it")

    def with_board(self, shared: Shared, case: CaseInfo, emulated: EmulatedBench) -> CaseBase | None:
        """Return the bench of a case on emulated boards where the usual one will not do; None where it does."""
        del shared, case, emulated
        return None

    def about_board(self, bench_file: BenchFile, program: str) -> Mapping[str, Any]:
        """Return what a journal says of its case on emulated boards for those who show it; see `hilbench.bench.about`.

        Args:
            bench_file: the bench.
            program: which of several the board runs.
        """
        del bench_file, program
        return {}

    def stand(self, bench: Bench, bench_file: BenchFile, line: Callable[[int], Port], *, seed: int) -> Standing:
        """Make the model with a body that stands beside boards.

        Args:
            bench: whose time it lives in.
            bench_file: says what it is set to, and where it stands.
            line: returns its end of its line, of a rate in bit/s.
            seed: of everything random.

        Raises:
            UsageError: it cannot.
        """
        del bench, line, seed
        raise UsageError(f"system '{self.name}' has no model that stands beside boards", where=bench_file.name)

    # --- a bench that is served, or live

    def served(self, bench_file: BenchFile, *, scene: str | None, baud: int | None, seed: int) -> ServedTarget:
        """Return its model of a bench file as something that can be put at the end of a line.

        Args:
            bench_file: a bench without boards.
            scene: where it stands instead of the scene of the file.
            baud: rate of its lines instead of that of the file, bit/s.
            seed: of everything random.

        Raises:
            UsageError: it cannot be served, or not so.
        """
        del scene, baud, seed
        raise UsageError(f"system '{self.name}' brings nothing that serves its models", where=bench_file.name)

    def rig(self, bench: Bench, bench_file: BenchFile, *, seed: int) -> Rig:
        """Build its model of a bench file, and a client for it.

        Raises:
            UsageError: there is no view of it.
            UnavailableError: physics is missing.
        """
        del bench, seed
        raise UsageError(f"system '{self.name}' brings no view of its models", where=bench_file.name)

    def board_rig(self, emulated: EmulatedBench, *, seed: int) -> Rig | None:
        """Return who speaks to the emulated boards of a bench, whose time and end are not its own; None for nobody."""
        del emulated, seed
        return None

    def speaks_to(self, bench_file: BenchFile) -> bool:
        """Say whether its clients speak to the boards of a bench: a suite of its models is run on them."""
        return any({*kind.suites} & {*bench_file.suites} for kind in self.models().values())

    def lines_asked(self, bench_file: BenchFile, choices: Sequence[TargetChoice]) -> Mapping[str, str]:
        """Return which port is asked for at the far end of each line of ours, by its name; of the only line by nothing.

        Raises:
            UsageError: a line has none, or two, or the bench is none of ours.
        """
        del bench_file
        first, *more = choices
        if more or first.name:
            where = " ".join(choice.where for choice in choices)
            hint = f"write --target {first.spec}"
            raise UsageError("this bench has one line, without a name", where=where, hint=hint)
        return {"": first.spec}

    def attached_rig(self, bench: Bench, bench_file: BenchFile, ports: Mapping[str, str], *, seed: int) -> Rig:
        """Attach to what somebody else runs at ports; nobody drives it unasked.

        Args:
            bench: whose time passes.
            bench_file: says which lines there are.
            ports: as `lines_asked` returns them.
            seed: decides what chance decides in faults.

        Raises:
            UsageError: no client speaks to it.
            UnavailableError: a port cannot be opened.
        """
        del bench, ports, seed
        raise UsageError(f"system '{self.name}' brings no client for a real one", where=bench_file.name)

    def scene(self, bench_file: BenchFile) -> str | None:
        """Return the scene that a bench is shown in where nobody names one; None for that of its file."""
        del bench_file
        return None

    def dashboard(self) -> Dashboard | None:
        """Return how its benches are shown; None for as any others."""
        return None

    def demo(self, *, physics: bool) -> Demo | None:
        """Return the script of ``hilbench demo NAME``; None for none.

        Args:
            physics: whether a physics engine is installed; without one a bench with a world may not open.
        """
        del physics
        return None
