"""A bench file that was read and understood: plain values, every name resolved."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import astuple, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from hilbench.benchfile.bench_model import PortEntry, World
from hilbench.benchfile.fault_entries import FaultEntry
from hilbench.benchfile.stimulus import Stimulus
from hilbench.strict.changes import Change
from targets.boards import Board, Straps
from worlds import engine_of

if TYPE_CHECKING:
    from hilbench.plugins.protocol import ProtocolPlugin
    from hilbench.plugins.system import ModelKind, System

CHECKER_END = "peer"
LOCKSTEP_NS = 20_000

SettingsT = TypeVar("SettingsT")


def is_checker_end(end: str) -> bool:
    """Say whether the checker, or a served client, sits at this end of a link: ``peer`` or ``peer.NAME``."""
    return end.partition(".")[0] == CHECKER_END


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelTarget:
    """A behavioural model.

    Attributes:
        settings: what it is set to; their class says which model it is.
        kind: what is known of such models.
        owner: whose it is: a system, or a protocol whose device it is.
    """

    settings: Any
    kind: ModelKind
    owner: System | ProtocolPlugin


@dataclass(frozen=True, slots=True, kw_only=True)
class Link:
    """A serial line.

    Attributes:
        ends: ``peer`` or ``peer.LINE``, ``NAME.host`` of a model, ``NAME.usart1`` of a board, ``NAME.uart2`` of a part.
        baud: bit/s of the end that is no emulated USART; 0 to follow the USART.
        protocol: what is spoken between the checker and a board; None where no protocol is named.
    """

    ends: tuple[str, str]
    baud: int = 0
    protocol: ProtocolPlugin | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class _End:
    """What words name, with dots between them."""

    def __str__(self) -> str:
        return ".".join(astuple(self))


@dataclass(frozen=True, slots=True, kw_only=True)
class PinEnd(_End):
    """A pin of a board: the board's name in the bench, and the port pin."""

    board: str
    pin: str


@dataclass(frozen=True, slots=True, kw_only=True)
class TerminalEnd(_End):
    """A terminal of a part: the part's name in the bench, and the terminal."""

    part: str
    terminal: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Net:
    """What wires join.

    Attributes:
        pins: of boards; two or more unless something else is on the net.
        terminals: of parts; one of them drives at most.
        supplies: ``3v3``, ``gnd``, or neither.
    """

    pins: tuple[PinEnd, ...]
    terminals: tuple[TerminalEnd, ...] = ()
    supplies: frozenset[str] = frozenset()

    def __str__(self) -> str:
        return "--".join([*sorted(self.supplies), *map(str, self.pins), *map(str, self.terminals)])


@dataclass(frozen=True, slots=True, kw_only=True)
class QuantityEnd(_End):
    """A quantity that a part gives: the part's name in the bench, and the quantity."""

    part: str
    quantity: str


@dataclass(frozen=True, slots=True, kw_only=True)
class BusEnd(_End):
    """A bus interface of a board: the board's name in the bench, and the interface: ``I2C1``, ``SPI1``."""

    board: str
    interface: str


@dataclass(frozen=True, slots=True, kw_only=True)
class BusPins(_End):
    """The wires of an I2C bus at a board: the board's name in the bench, and the two port pins."""

    board: str
    scl: str
    sda: str


@dataclass(frozen=True, slots=True, kw_only=True)
class PartPlan:
    """A part.

    Attributes:
        kind: what it is, by its name in `targets.parts.PARTS`.
        settings: what differs from a standard one, as an instance of the kind's own class.
        signals: the signal of the world that each of its quantities is; without ``world.`` before it.
        sources: the quantity of another part that each of its other quantities is.
        buses: the I2C or SPI bus that each of its ends at one is soldered to.
    """

    kind: str
    settings: Any
    signals: Mapping[str, str] = field(default_factory=dict)
    sources: Mapping[str, QuantityEnd] = field(default_factory=dict)
    buses: Mapping[str, BusEnd | BusPins] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, kw_only=True)
class EmulatedBoard:
    """A board that runs firmware.

    Attributes:
        board: what is soldered around the chip.
        board_name: what was asked for: a built-in name, or a file.
        firmware: the image.
        base: where a raw binary belongs; None for the beginning of flash, or where it seems to have been linked for.
        timing: ``flat`` or ``table``.
        skip_idle: whether waiting loops are skipped.
        straps: the boot jumpers.
        programs: other images for it, by what they do.
        where: who asked for it, for messages: file and line, or the words of a command line.
    """

    board: Board
    board_name: str
    firmware: Path
    base: int | None = None
    timing: Literal["flat", "table"] = "flat"
    skip_idle: bool = True
    straps: Straps = field(default_factory=Straps)
    programs: Mapping[str, Path] = field(default_factory=dict)
    where: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchFile:
    """A bench file that was read and understood.

    Attributes:
        name: of a built-in bench, or the file's name.
        path: where it was read; None for a bench that stands in no file.
        digest: SHA-256 of the file, in hex; empty for a bench that stands in no file.
        changes: what a command line has put in the place of what stands in the file.
        world: where the robot stands.
        targets: the models that answer, by name.
        boards: the boards that run firmware, by name.
        parts: what stands between boards and the world, by name.
        links: the serial lines.
        nets: what wires join.
        lockstep_ns: how far one of several boards that wires join may be ahead of the others.
        suites: what is checked where no suite is asked for: names of shipped suites, and paths.
        variants: the files of other benches, by names that cases use.
        faults: what goes wrong on the lines; each says which way (``towards``), but for those of both ways.
        stimuli: what is done to the boards from outside.
        port: how a real port is opened, and the board behind it reset.
        vehicle_ready: the vehicle of the world stands in it wherever boards are, as a car does, also where no part
            drives or senses it.
    """

    name: str
    path: Path | None
    digest: str
    changes: tuple[Change, ...] = ()
    world: World = field(default_factory=World)
    targets: Mapping[str, ModelTarget] = field(default_factory=dict)
    boards: Mapping[str, EmulatedBoard] = field(default_factory=dict)
    parts: Mapping[str, PartPlan] = field(default_factory=dict)
    links: tuple[Link, ...] = ()
    nets: tuple[Net, ...] = ()
    lockstep_ns: int = LOCKSTEP_NS
    suites: tuple[str, ...] = ()
    variants: Mapping[str, Path] = field(default_factory=dict)
    faults: tuple[FaultEntry, ...] = ()
    stimuli: tuple[Stimulus, ...] = ()
    port: PortEntry = field(default_factory=PortEntry)
    vehicle_ready: bool = False

    def header(self, seed: int) -> dict[str, object]:
        """Return what a journal says of the bench in its first line; `seed` is that of the run."""
        faults = [fault.describe() for fault in self.faults]
        about: dict[str, object] = {"seed": seed, "bench": self.name, "bench_sha256": self.digest, "faults": faults}
        if self.changes:
            about["set"] = [change.text for change in self.changes]
        if self.boards:
            about["timing"] = {name: emulated.timing for name, emulated in self.boards.items()}
        if self.has_world:
            physics = self.world.physics
            about["physics"] = {"name": physics, "engine": engine_of(physics), "step_hz": self.world.step_hz}
        return about

    @property
    def checker_lines(self) -> Mapping[str, str]:
        """The far end of each line of the checker, by the line's name: ``LINE`` of ``peer.LINE``, empty of ``peer``.

        Of several lines without a name it is the first.
        """
        found: dict[str, str] = {}
        for link in self.links:
            for near, far in (link.ends, link.ends[::-1]):
                if is_checker_end(near):
                    found.setdefault(near.partition(".")[2], far)
        return found

    @property
    def served_lines(self) -> Mapping[str, int]:
        """The lines of models without a body that lead to the checker, or to who is served, each with its rate, bit/s.

        A model that only the checker can be has none.
        """
        return {
            far: link.baud
            for link in self.links
            for near, far in (link.ends, link.ends[::-1])
            if is_checker_end(near)
            and (there := self.targets.get(far.partition(".")[0])) is not None
            and not (there.kind.has_body or there.kind.beside)
        }

    @property
    def protocols(self) -> Mapping[str, ProtocolPlugin]:
        """What is spoken on lines between the checker and boards, by the board's end, as far as the file says."""
        found = {}
        for link in self.links:
            for near, far in (link.ends, link.ends[::-1]):
                if is_checker_end(near) and link.protocol is not None:
                    found[far] = link.protocol
        return found

    @property
    def model(self) -> ModelTarget | None:
        """The model of the bench, or the one that is not beside another; None for a bench of boards alone."""
        there = sorted(self.targets.values(), key=lambda target: target.kind.beside)
        return next(iter(there), None)

    @property
    def standing(self) -> ModelTarget | None:
        """The model that stands in the world; None without one."""
        return next((target for target in self.targets.values() if target.kind.has_body), None)

    @property
    def has_world(self) -> bool:
        """True if a model stands in a world, or a vehicle that parts drive or sense, or one that needs no parts."""
        return (
            self.standing is not None
            or any(part.signals for part in self.parts.values())
            or (self.vehicle_ready and bool(self.boards))
        )

    def settings_of(self, kind: type[SettingsT]) -> SettingsT | None:
        """Return the settings of the model whose settings are of this class; None without one on the bench."""
        settings = (target.settings for target in self.targets.values())
        return next((one for one in settings if isinstance(one, kind)), None)

    def link_of(self, line: str, lines: Sequence[str]) -> int | None:
        """Return which link is the line of a model whose end ends with ``.LINE``; None if the file has none for it.

        Args:
            line: the line.
            lines: those of the model; without ``[[links]]`` the first of them is link 0.
        """
        ends = [{end.rpartition(".")[2] for end in link.ends} for link in self.links] or [{lines[0]}]
        return next((number for number, names in enumerate(ends) if line in names), None)
