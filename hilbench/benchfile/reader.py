"""Finds and reads bench files: which targets stand in which world, and how they are wired.

TOML, versioned and strict. The published schema (``hilbench/data/bench.schema.json``, for completion in editors) is
generated from `hilbench.benchfile.bench_model`.
"""

from __future__ import annotations

import dataclasses
import hashlib
import re
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

import msgspec
from msgspec import UNSET

from hilbench.benchfile.bench_file import CHECKER_END, BenchFile, EmulatedBoard, Link, ModelTarget, is_checker_end
from hilbench.benchfile.bench_model import BenchModel, LinkEntry, PortEntry, TargetEntry, World
from hilbench.benchfile.board_files import open_board, with_chip
from hilbench.benchfile.fault_entries import FaultEntry
from hilbench.benchfile.line_hooks import parse_step
from hilbench.benchfile.stimulus import Stimulus, parse_stimulus
from hilbench.benchfile.suites import shipped_suites
from hilbench.benchfile.wiring_reader import WiringReader
from hilbench.clock import NS_PER_US
from hilbench.errors import UnavailableError, UsageError
from hilbench.files.built_in import built_in_benches
from hilbench.files.names import file_name
from hilbench.nearest import did_you_mean
from hilbench.plugins.discovery import PLUGINS
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.plugins.system import ModelKind, System, VehicleKind, device_kind
from hilbench.strict import Strict
from hilbench.strict.changes import Change
from hilbench.strict.toml_file import TomlFile
from hilbench.terminal.options import DEFAULT_BENCH
from worlds.errors import SceneFileError, UnknownNameError
from worlds.scenes import read_scene, scene_names

__all__ = [
    "CHECKER_END",
    "BenchFile",
    "open_bench",
    "read_bench",
    "resolve_scene",
]

DEFAULT_FILE = Path("hilbench.toml")

_LINE_NAME = re.compile(r"[A-Za-z_][\w-]*")
_TABLE_ALIGNMENT = 0x80
"""VTOR holds no lower bits (ARMv7-M ARM, DDI0403, section B3.2.5)."""
_UNSEEN = ModelKind(settings=dict, protocol="", suites=(), beside=True, has_body=True)
"""A model of a plug-in that is not run: whatever it may be, it is."""
_MODEL_KEYS = ("model", "settings")
_BOARD_KEYS = ("board", "chip", "firmware", "base", "timing", "skip_idle", "straps", "programs")


def open_bench(bench: str | None = None, *, run_plugins: bool = True, changes: Sequence[Change] = ()) -> BenchFile:
    """Read a bench file.

    Args:
        bench: name of a built-in bench or path of a file; None for ``./hilbench.toml`` if there is one and else
            the default one.
        run_plugins: run the plug-ins that it names. Without, what they bring is not looked at, and the bench cannot be
            built.
        changes: what is to be otherwise than it stands in the file.

    Raises:
        UsageError: there is no such bench, or its file is wrong; the line is named.
    """
    if bench is None:
        bench = str(DEFAULT_FILE) if DEFAULT_FILE.is_file() else DEFAULT_BENCH
    if (own := built_in_benches().get(bench)) is not None:
        return read_bench(own, name=bench, changes=changes)
    if run_plugins and (file := PLUGINS.systems.bench(bench)) is not None:
        return read_bench(file, name=bench, changes=changes)
    path = Path(bench)
    if "/" in bench or bench.endswith(".toml") or (path.exists() and not path.is_dir()):
        return read_bench(path, run_plugins=run_plugins, changes=changes)
    if not run_plugins and PLUGINS.systems.is_of_stranger(bench):
        raise UsageError("comes with a plug-in, and none is run here", where=bench, hint="name the bench file itself")
    raise UsageError("no such bench", where=bench, hint=_near(bench))


def read_bench(path: Path, name: str = "", *, run_plugins: bool = True, changes: Sequence[Change] = ()) -> BenchFile:
    """Read a bench file from a path; see `open_bench`."""
    file = TomlFile(path, "bench file", _near(path.stem), changes)
    return dataclasses.replace(_Reader(file, run_plugins=run_plugins).read(name or path.name), changes=tuple(changes))


def _near(bench: str) -> str | None:
    if bench in PLUGINS.names():
        return f"'{bench}' is a protocol; name a bench file whose target speaks it (docs/plugins.md)"
    return did_you_mean(bench, [*built_in_benches(), *PLUGINS.systems.bench_names()], "benches")


def resolve_scene(scene: str, folder: Path, where: str) -> str:
    """Return a built-in scene as it is, and a scene file by a path that leads to it from here.

    Args:
        scene: name of a built-in scene, or a path that ends in ``.toml``.
        folder: what the path is relative to.
        where: who names the scene, for the error.

    Raises:
        UsageError: there is no such scene or file.
    """
    if scene in scene_names():
        return scene
    scene = file_name(scene)
    if not scene.endswith(".toml"):
        raise UsageError(f"no scene '{scene}'", where=where, hint=did_you_mean(scene, scene_names(), "built-in scenes"))
    if not (folder / scene).is_file():
        raise UsageError(f"no scene file '{folder / scene}'", where=where)
    try:
        read_scene(folder / scene)
    except SceneFileError as error:
        raise UsageError(str(error)) from None
    return str(folder / scene)


class _Reader:
    """Reads one file, and knows where in it everything is."""

    def __init__(self, file: TomlFile, *, run_plugins: bool) -> None:
        self._file = file
        self._folder = file.path.parent
        self._strict = Strict(file.place)
        self._run_plugins = run_plugins
        self._whose: dict[str, tuple[System | ProtocolPlugin, ModelKind]] = {}
        self._kinds: dict[str, ModelKind] = {}

    def read(self, bench_name: str) -> BenchFile:
        model = self._strict.convert(self._file.data, BenchModel)
        for number, text in enumerate(model.plugins):
            self._use_plugin(text, ("plugins", number))
        vehicle = self._vehicle(model)
        self._check_targets(model, ready=vehicle is not None and vehicle.stands_ready)
        boards = {name: self._board(name, entry) for name, entry in model.targets.items() if entry.board is not UNSET}
        wiring = WiringReader(model, boards, vehicle, self._strict)
        links = self._links(model, boards, wiring.serial_ends())
        wiring.check_lines(links)
        return BenchFile(
            name=bench_name,
            path=self._file.path,
            digest=hashlib.sha256(self._file.text.encode()).hexdigest(),
            world=self._world(model),
            targets={name: self._model(name, entry) for name, entry in model.targets.items() if entry.board is UNSET},
            boards=boards,
            parts=wiring.parts(),
            links=links,
            nets=wiring.nets(),
            lockstep_ns=model.lockstep_us * NS_PER_US,
            suites=self._suites(model, links),
            variants={name: self._file_beside(text, ("variants", name)) for name, text in model.variants.items()},
            faults=self._faults(model, links),
            stimuli=tuple(self._stimulus(number, text, boards) for number, text in enumerate(model.stimuli)),
            port=self._port(model),
            vehicle_ready=vehicle is not None and vehicle.stands_ready,
        )

    # --- plug-ins

    def _use_plugin(self, text: str, path: tuple[str | int, ...]) -> None:
        file = self._file_beside(text, path)
        if self._run_plugins:
            PLUGINS.add_file(file, self._file.place(path))

    def _protocol(self, name: str, path: tuple[str | int, ...]) -> ProtocolPlugin | None:
        """Return a protocol by its name; None where plug-ins are not run, and one of them may bring it."""
        unseen = name in PLUGINS.names() or self._file.data.get("plugins")
        if self._run_plugins or PLUGINS.is_own(name) or not unseen:
            return PLUGINS.get(name, self._file.place(path))
        return None

    def _kind(self, name: str, model: str) -> tuple[System | ProtocolPlugin, ModelKind]:
        """Return a model and whose it is: one of a system, or the device of a protocol."""
        path, systems = ("targets", name, "model"), PLUGINS.systems
        if self._run_plugins or not self._is_unseen(model):
            found = systems.model(model, self._file.place(path))
            if found is not None:
                return found
            if model not in PLUGINS.names():
                known = did_you_mean(model, systems.models(), "models")
                hint = f"{known}; another one comes with a plug-in (docs/plugins.md)"
                raise self._strict.error(f"'{model}' is not a value it takes", path, hint)
        protocol = self._protocol(model, path) if model in PLUGINS.names() else None
        if protocol is None:
            return System(), _UNSEEN
        if protocol.device is None:
            raise self._strict.error(f"the protocol '{model}' brings no model", path, "give its record a 'device'")
        return protocol, device_kind(protocol)

    def _vehicle(self, model: BenchModel) -> VehicleKind | None:
        """Return the vehicle in the world; None where plug-ins are not run, and one of them may bring it."""
        name, systems = model.world.vehicle, PLUGINS.systems
        if not self._run_plugins and self._is_unseen(name):
            return None
        if "vehicle" not in self._file.data.get("world", {}) and name not in systems.vehicle_names():
            return None  # the usual one is not installed, and nobody asks for it
        try:
            return systems.vehicle(name)
        except UnknownNameError:
            hint = did_you_mean(name, systems.vehicle_names(), "it takes")
            raise self._strict.error(f"'{name}' is not a value it takes", ("world", "vehicle"), hint) from None

    def _is_unseen(self, name: str) -> bool:
        """Say whether a plug-in that is not run may bring a model, vehicle or protocol of this name."""
        there = name in PLUGINS.systems.models() or name in PLUGINS.systems.vehicle_names()
        plugged_in = bool(self._file.data.get("plugins")) or PLUGINS.systems.is_of_stranger(name)
        return not there and (plugged_in or (name in PLUGINS.names() and not PLUGINS.is_own(name)))

    # --- targets

    def _check_targets(self, model: BenchModel, *, ready: bool) -> None:
        if not model.targets:
            raise self._strict.error("[targets] names no target", ("targets",), "add [targets.robot]")
        for name, entry in model.targets.items():
            self._check_target(name, entry)
        models = [name for name, entry in model.targets.items() if entry.board is UNSET]
        self._whose = {name: self._kind(name, str(model.targets[name].model)) for name in models}
        self._kinds = {name: kind for name, (_, kind) in self._whose.items()}
        alone = [name for name in models if not self._kinds[name].beside]
        if len(alone) > 1:
            message = f"'{alone[1]}': more than one robot is not available in this version of hilbench"
            raise self._strict.error(message, ("targets", alone[1]))
        signals = any(entry.signals for entry in model.parts.values())
        bodies = any(kind.has_body for kind in self._kinds.values())
        self._check_bodies(model.world.vehicle)
        stands = ready and len(models) < len(model.targets)
        if "world" in self._file.data and not (bodies or signals or stands):
            raise self._strict.error("no target of this bench has a world", ("world",))

    def _check_bodies(self, vehicle: str) -> None:
        """Require that a model with a body has the body of its system, if that has any."""
        for name, (owner, kind) in self._whose.items():
            there = owner.vehicles if isinstance(owner, System) and kind.has_body else {}
            if there and vehicle not in there:
                hint = f'write vehicle = "{next(iter(there))}" under [world]'
                raise self._strict.error(f"'{name}' does not stand in the body of a {vehicle}", ("targets", name), hint)

    def _check_target(self, name: str, entry: TargetEntry) -> None:
        given = self._file.data["targets"][name]
        if entry.board is UNSET and entry.model is UNSET:
            kinds = " or ".join(f'"{kind}"' for kind in PLUGINS.systems.models())
            hint = f"write model = {kinds}, or board and firmware"
            raise self._strict.error("the key 'model' or 'board' is missing", ("targets", name), hint)
        is_board = entry.board is not UNSET
        for key in _MODEL_KEYS if is_board else _BOARD_KEYS:
            if key in given:
                message = f"'{key}' says nothing about {'a board' if is_board else 'a model'}"
                raise self._strict.error(message, ("targets", name, key))
        if is_board and entry.firmware is UNSET:
            raise self._strict.error("the key 'firmware' is missing", ("targets", name))

    def _model(self, name: str, entry: TargetEntry) -> ModelTarget:
        path = ("targets", name, "settings")
        settings = self._strict.convert_at(entry.settings, self._kinds[name].settings, path)
        owner, kind = self._whose[name]
        return ModelTarget(settings=self._beside(settings, path), kind=kind, owner=owner)

    def _beside(self, settings: Any, path: tuple[str, ...]) -> Any:
        """Return settings with the folders that they name as seen from here: in the file they are relative to it."""
        found = {}
        for item in dataclasses.fields(settings) if dataclasses.is_dataclass(settings) else ():
            if item.metadata.get("folders"):
                folders = [self._folder / file_name(one) for one in getattr(settings, item.name)]
                for number, folder in enumerate(folders):
                    if not folder.is_dir():
                        raise self._strict.error(f"no folder '{folder}'", (*path, item.name, number))
                found[item.name] = tuple(map(str, folders))
        return dataclasses.replace(settings, **found) if found else settings

    def _board(self, name: str, entry: TargetEntry) -> EmulatedBoard:
        assert entry.board is not UNSET
        assert entry.firmware is not UNSET
        board = open_board(entry.board, self._folder, self._file.place(("targets", name, "board")))
        if entry.chip is not UNSET:
            board = with_chip(board, entry.chip, self._file.place(("targets", name, "chip")))
        where = self._file.place(("targets", name, "firmware"))
        firmware = self._folder / file_name(entry.firmware)
        if not firmware.is_file():
            raise UnavailableError(f"no firmware file '{firmware}'", where=where)
        given = msgspec.structs.asdict(entry.straps)
        straps = {key: value for key, value in given.items() if value is not UNSET}
        if straps.get("boot1") and board.variant.boot1_pin is None:
            hint = "its option bytes have an address for each level of BOOT, which is boot0"
            raise self._strict.error(f"the {board.chip} has no BOOT1", ("targets", name, "straps"), hint)
        return EmulatedBoard(
            board=board,
            board_name=entry.board,
            firmware=firmware,
            base=self._base(name, entry),
            timing=entry.timing,
            skip_idle=entry.skip_idle,
            straps=dataclasses.replace(board.straps, **straps),
            programs=self._programs(name, entry),
            where=where,
        )

    def _base(self, name: str, entry: TargetEntry) -> int | None:
        """Return where a raw binary belongs, which is where its vector table is."""
        if entry.base is UNSET:
            return None
        if entry.base % _TABLE_ALIGNMENT:
            message = f"0x{entry.base:08X} is no multiple of 0x{_TABLE_ALIGNMENT:X}, as the place of a vector table is"
            hint = "write that of the linker script, such as 0x08002000"
            raise self._strict.error(message, ("targets", name, "base"), hint)
        return entry.base

    def _programs(self, name: str, entry: TargetEntry) -> dict[str, Path]:
        paths = {program: self._folder / file_name(image) for program, image in entry.programs.items()}
        for program, path in paths.items():
            if not path.is_file():
                where = self._file.place(("targets", name, "programs", program))
                raise UnavailableError(f"no firmware file '{path}'", where=where)
        return paths

    def _file_beside(self, text: str, path: tuple[str | int, ...]) -> Path:
        file = self._folder / file_name(text)
        if not file.is_file():
            raise self._strict.error(f"no file '{file}'", path)
        return file

    def _suites(self, model: BenchModel, links: Sequence[Link]) -> tuple[str, ...]:
        """Return the suites of the file; where it names none those of its model, or of what its boards speak."""
        if "suites" not in self._file.data:
            if len(self._kinds) == len(model.targets):
                return self._suites_of_model(*next(iter(self._kinds.items())))
            spoken = (link.protocol for link in links if link.protocol is not None)
            return tuple(dict.fromkeys(str(suite) for protocol in spoken for suite in protocol.suites))
        shipped = shipped_suites()
        return tuple(
            suite if suite in shipped else str(self._suite_file(suite, number, shipped))
            for number, suite in enumerate(model.suites)
        )

    def _suites_of_model(self, name: str, kind: ModelKind) -> tuple[str, ...]:
        missing = [suite for suite in kind.suites if not (suite in shipped_suites() or Path(suite).exists())]
        if missing:
            model = self._file.data["targets"][name]["model"]
            message = f"the model '{model}' has the suite '{missing[0]}', which is not there"
            hint = f"its ModelKind names shipped suites and paths: str(Path(__file__).with_name('{missing[0]}'))"
            raise self._strict.error(message, ("targets", name, "model"), hint)
        return kind.suites

    def _suite_file(self, suite: str, number: int, shipped: Collection[str]) -> Path:
        file = self._folder / file_name(suite)
        if file.exists():
            return file
        hint = did_you_mean(suite, shipped, "shipped suites")
        raise self._strict.error(f"no suite '{suite}'", ("suites", number), hint)

    def _world(self, model: BenchModel) -> World:
        scene = resolve_scene(model.world.scene, self._folder, self._file.place(("world", "scene")))
        return msgspec.structs.replace(model.world, scene=scene)

    def _port(self, model: BenchModel) -> PortEntry:
        for hook in ("boot", "reset"):
            for number, step in enumerate(getattr(model.port, hook)):
                try:
                    parse_step(step)
                except ValueError as error:
                    raise self._strict.error(str(error), ("port", hook, number)) from None
        return model.port

    def _stimulus(self, number: int, text: str, boards: dict[str, EmulatedBoard]) -> Stimulus:
        try:
            return parse_stimulus(text, boards, self._folder)
        except ValueError as error:
            raise self._strict.error(str(error), ("stimuli", number)) from None

    # --- lines

    def _links(self, model: BenchModel, boards: dict[str, EmulatedBoard], part_ends: Sequence[str]) -> tuple[Link, ...]:
        model_ends = self._model_ends()
        lines = len(model_ends)
        unseen = any(kind is _UNSEEN for kind in self._kinds.values())
        if len(model.links) > lines and not boards and not unseen:
            several = "one line" if lines == 1 else f"{lines} lines"
            raise self._strict.error(f"a second link: this bench has {several}", ("links", lines))
        usarts = [f"{name}.{usart.lower()}" for name, entry in boards.items() for usart in entry.board.variant.usarts]
        known = (CHECKER_END, *model_ends, *usarts, *part_ends)
        taken: set[str] = set()
        links = []
        for number, entry in enumerate(model.links):
            for end in entry.ends:
                self._check_end(number, end, known, taken)
            if entry.ends[0] == entry.ends[1]:
                raise self._strict.error(f"both ends are '{entry.ends[0]}'", ("links", number, "ends"))
            if {*entry.ends} <= {*model_ends}:
                hint = f'write ends = ["peer.LINE", "{entry.ends[0]}"]'
                raise self._strict.error("a line of a model leads to the checker", ("links", number, "ends"), hint)
            of_part = not {*entry.ends}.isdisjoint(part_ends)
            if of_part:
                self._check_part_line(number, entry, part_ends)
            taken |= {*entry.ends} - {CHECKER_END}
            baud, protocol = self._baud(number, entry, of_part=of_part), self._protocol_of(number, entry, usarts)
            links.append(Link(ends=entry.ends, baud=baud, protocol=protocol))
        return tuple(links)

    def _check_part_line(self, number: int, entry: LinkEntry, part_ends: Sequence[str]) -> None:
        if not any(end not in part_ends and not is_checker_end(end) for end in entry.ends):
            message = f"{' and '.join(entry.ends)}: a line of a part leads to a board or to a robot"
            raise self._strict.error(message, ("links", number, "ends"), 'write ends = [..., "brain.usart1"]')

    def _check_end(self, number: int, end: str, known: Sequence[str], taken: set[str]) -> None:
        path = ("links", number, "ends")
        unseen = self._kinds.get(end.partition(".")[0]) is _UNSEEN
        if end not in known and not unseen and not _names_checker_line(end):
            raise self._strict.error(f"'{end}' is not the end of a link", path, did_you_mean(end, known, "ends"))
        if end in taken:
            raise self._strict.error(f"'{end}' has a line already", path)

    def _protocol_of(self, number: int, entry: LinkEntry, usarts: Collection[str]) -> ProtocolPlugin | None:
        """Return what is spoken between the checker and a board."""
        if entry.protocol is UNSET:
            return None
        path = ("links", number, "protocol")
        if not any(map(is_checker_end, entry.ends)) or {*entry.ends}.isdisjoint(usarts):
            message = "only a line between 'peer' and a board has a protocol"
            raise self._strict.error(message, path, "leave it out: a model speaks its own")
        return self._protocol(entry.protocol, path)

    def _baud(self, number: int, entry: LinkEntry, *, of_part: bool) -> int:
        """Return the rate of the end that is no emulated USART."""
        path = ("links", number, "baud")
        model_end = next((end for end in entry.ends if end in self._model_ends()), None)
        two_usarts = model_end is None and not any(map(is_checker_end, entry.ends)) and not of_part
        if two_usarts and entry.baud is not UNSET:
            raise self._strict.error("both ends are USARTs and have a rate of their own", path, "leave it out")
        if model_end is None:
            return 0 if entry.baud is UNSET else entry.baud
        kind = self._kinds[model_end.partition(".")[0]]
        baud = kind.baud if entry.baud is UNSET else entry.baud
        if kind.rates and baud not in kind.rates:
            rates = ", ".join(map(str, kind.rates))
            raise self._strict.error(f"{baud} is not a value it takes", path, f"{model_end} takes: {rates}")
        return baud

    # --- faults

    def _faults(self, model: BenchModel, links: Sequence[Link]) -> tuple[FaultEntry, ...]:
        """Let each fault say where it goes, by its receiving end."""
        lines: list[Sequence[str]] = [link.ends for link in links]
        boards = {name for name, entry in model.targets.items() if entry.board is not UNSET}
        if boards:
            self._check_boards(model.faults, lines, boards)
        lines = lines or [(CHECKER_END, *self._model_ends()[:1])]
        return tuple(self._with_direction(number, fault, lines) for number, fault in enumerate(model.faults))

    def _check_boards(
        self, faults: Sequence[FaultEntry], lines: Sequence[Sequence[str]], boards: Collection[str]
    ) -> None:
        """Refuse a fault on a line of which not exactly one end is a board's."""
        for number, fault in enumerate(faults):
            if not lines:
                hint = f'write [[links]] ends = ["{CHECKER_END}", "{min(boards)}.usart1"]'
                raise self._strict.error("no line of this bench leads to a board", ("faults", number), hint)
            ends = lines[fault.link] if fault.link < len(lines) else ()
            count = sum(end.partition(".")[0] in boards for end in ends)
            if ends and count != 1:
                what = "joins two ends of boards" if count else "leads to no board"
                hint = "faults are for a line between a board and something else"
                raise self._strict.error(f"link {fault.link} {what}", ("faults", number, "link"), hint)

    def _with_direction(self, number: int, fault: FaultEntry, lines: Sequence[Sequence[str]]) -> FaultEntry:
        if fault.link >= len(lines):
            there = "one line, link 0" if len(lines) == 1 else f"{len(lines)} lines, link 0 to {len(lines) - 1}"
            message = f"there is no link {fault.link}: this bench has {there}"
            raise self._strict.error(message, ("faults", number, "link"))
        ends = lines[fault.link]
        if fault.kind == "disconnect":
            return fault
        for name, end in (("towards", fault.towards), ("from", fault.from_)):
            if end is not UNSET and end not in ends:
                hint = did_you_mean(end, ends, "ends")
                raise self._strict.error(f"'{end}' is not an end of the link", ("faults", number, name), hint)
        towards = fault.towards
        if towards is UNSET:
            towards = ends[0] if fault.from_ == ends[1] else ends[1]
        return msgspec.structs.replace(fault, towards=towards, from_=UNSET)

    def _model_ends(self) -> list[str]:
        return [f"{name}.{line}" for name, kind in self._kinds.items() for line in kind.lines]


def _names_checker_line(end: str) -> bool:
    """Say whether it is ``peer.LINE``."""
    return is_checker_end(end) and _LINE_NAME.fullmatch(end.partition(".")[2]) is not None
