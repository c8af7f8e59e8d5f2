"""A bench file that was read and understood: plain values, every name resolved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from hilbench.bench_model import PortEntry, World
from hilbench.errors import UsageError
from hilbench.fault_entries import FaultEntry
from targets.boards import Board, Straps
from targets.robots.car_host import CarHostSettings
from targets.robots.pioneer import RobotSettings
from targets.robots.rover import RoverSettings
from targets.robots.vehicle_interface import VehicleSettings

if TYPE_CHECKING:
    from hilbench.plugins.protocol import ProtocolPlugin

CHECKER_END = "peer"
LOCKSTEP_NS = 20_000

Supply = Literal["3v3", "gnd"]
SettingsT = TypeVar("SettingsT")


def is_checker_end(end: str) -> bool:
    """Say whether the checker, or a served client, sits at this end of a link: ``peer`` or ``peer.NAME``."""
    return end.partition(".")[0] == CHECKER_END


@dataclass(frozen=True, slots=True, kw_only=True)
class ModelTarget:
    """A behavioural model.

    Attributes:
        settings: what it is set to; their class says which model it is.
        protocol: the plug-in that brings it; None for one of hilbench's own.
    """

    settings: Any
    protocol: ProtocolPlugin | None = None


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
class PinEnd:
    """A pin of a board: the board's name in the bench, and the port pin."""

    board: str
    pin: str

    def __str__(self) -> str:
        return f"{self.board}.{self.pin}"


@dataclass(frozen=True, slots=True, kw_only=True)
class TerminalEnd:
    """A terminal of a part: the part's name in the bench, and the terminal."""

    part: str
    terminal: str

    def __str__(self) -> str:
        return f"{self.part}.{self.terminal}"


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
class QuantityEnd:
    """A quantity that a part gives: the part's name in the bench, and the quantity."""

    part: str
    quantity: str

    def __str__(self) -> str:
        return f"{self.part}.{self.quantity}"


@dataclass(frozen=True, slots=True, kw_only=True)
class BusEnd:
    """An I2C interface of a board: the board's name in the bench, and the interface: ``I2C1``."""

    board: str
    interface: str

    def __str__(self) -> str:
        return f"{self.board}.{self.interface}"


@dataclass(frozen=True, slots=True, kw_only=True)
class PartPlan:
    """A part.

    Attributes:
        kind: what it is, by its name in `targets.parts.PARTS`.
        settings: what differs from a standard one, as an instance of the kind's own class.
        signals: the signal of the world that each of its quantities is; without ``world.`` before it.
        sources: the quantity of another part that each of its other quantities is.
        buses: the I2C bus that each of its ends at one is soldered to.
    """

    kind: str
    settings: Any
    signals: Mapping[str, str] = field(default_factory=dict)
    sources: Mapping[str, QuantityEnd] = field(default_factory=dict)
    buses: Mapping[str, BusEnd] = field(default_factory=dict)


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
        port: how a real port is opened, and the board behind it reset.
        without_car: the car that would stand ready is not needed, and neither is its world.
    """

    name: str
    path: Path | None
    digest: str
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
    port: PortEntry = field(default_factory=PortEntry)
    without_car: bool = False

    def header(self, seed: int) -> dict[str, object]:
        """Return what a journal says of the bench in its first line; `seed` is that of the run."""
        faults = [fault.describe() for fault in self.faults]
        about: dict[str, object] = {"seed": seed, "bench": self.name, "bench_sha256": self.digest, "faults": faults}
        if self.boards:
            about["timing"] = {name: emulated.timing for name, emulated in self.boards.items()}
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
    def protocols(self) -> Mapping[str, ProtocolPlugin]:
        """What is spoken on lines between the checker and boards, by the board's end, as far as the file says."""
        found = {}
        for link in self.links:
            for near, far in (link.ends, link.ends[::-1]):
                if is_checker_end(near) and link.protocol is not None:
                    found[far] = link.protocol
        return found

    @property
    def plugged_in(self) -> ModelTarget | None:
        """The model that a plug-in brings; None without one."""
        return next((target for target in self.targets.values() if target.protocol is not None), None)

    @property
    def has_world(self) -> bool:
        """True if a robot stands in a world, a vehicle that parts drive or sense, or a car, which needs neither."""
        is_car = self.world.vehicle == "car" and bool(self.boards) and not self.without_car
        return is_car or self._pioneer is not None or any(part.signals for part in self.parts.values())

    @property
    def has_pioneer(self) -> bool:
        """True if a Pioneer stands on the bench."""
        return self._pioneer is not None

    def pioneer(self) -> RobotSettings:
        """Return the settings of the one Pioneer of the bench.

        Raises:
            UsageError: there is none.
        """
        if self._pioneer is None:
            raise UsageError("names no Pioneer among its targets", where=str(self.path or self.name))
        return self._pioneer

    @property
    def rover(self) -> RoverSettings | None:
        """The settings of the rover that stands on the bench as a model; None without one."""
        return self._model(RoverSettings)

    @property
    def vehicle(self) -> VehicleSettings | None:
        """Likewise of the vehicle-interface board."""
        return self._model(VehicleSettings)

    @property
    def car_host(self) -> CarHostSettings:
        """Likewise of the simulator's side; the usual ones where it does not stand on the bench."""
        return self._model(CarHostSettings) or CarHostSettings()

    @property
    def has_car_host(self) -> bool:
        """True if the simulator's side stands on the bench."""
        return self._model(CarHostSettings) is not None

    @property
    def _pioneer(self) -> RobotSettings | None:
        return self._model(RobotSettings)

    def _model(self, kind: type[SettingsT]) -> SettingsT | None:
        settings = (target.settings for target in self.targets.values())
        return next((one for one in settings if isinstance(one, kind)), None)
