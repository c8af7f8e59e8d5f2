"""The bench file: which targets stand in which world, and how they are wired.

TOML, versioned and strict. The published schema (``hilbench/data/bench.schema.json``, for completion in editors) is
generated from the model below.
"""

from __future__ import annotations

import dataclasses
import hashlib
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
from msgspec import UNSET

from hilbench.errors import UsageError
from hilbench.fault_entries import FaultEntry
from hilbench.nearest import did_you_mean
from hilbench.schema import json_schema
from hilbench.strict import Strict
from hilbench.toml_lines import find_line
from targets.robots.pioneer import RobotSettings
from worlds.errors import SceneFileError
from worlds.scenes import read_scene, scene_names

BUILT_IN_FOLDER = Path(__file__).parent / "benches"
DEFAULT_FILE = Path("hilbench.toml")
DEFAULT_BENCH = "pioneer"
CHECKER_END = "peer"

LATER: Mapping[tuple[str, ...], str] = {
    ("targets", "*", "board"): "emulated boards are",
    ("targets", "*", "firmware"): "emulated boards are",
    ("targets", "*", "timing"): "emulated boards are",
}


class World(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Where the robot stands.

    Attributes:
        scene: name of a built-in scene, or the path of a scene file, seen from the bench file.
        vehicle: the body in it.
        physics: ``bullet``, or ``plane`` for an endless floor without rays and contacts.
        step_hz: physics steps per second.
    """

    scene: str = "empty"
    vehicle: Literal["pioneer-2dx"] = "pioneer-2dx"
    physics: Literal["bullet", "plane"] = "bullet"
    step_hz: Annotated[int, msgspec.Meta(ge=50, le=10_000)] = 240


class Target(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What answers at the far end of a link.

    Attributes:
        model: the behavioural model of it.
        settings: what differs from a standard one, by the names of `targets.robots.pioneer.RobotSettings`.
    """

    model: Literal["pioneer-2dx"]
    settings: RobotSettings = RobotSettings()


class Link(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A serial line between two ends.

    Attributes:
        ends: ``peer``, where the checker or a served client sits, and ``NAME.host`` of a target.
        baud: speed in bit/s, one that the robot's port can have (HOSTBAUD).
    """

    ends: tuple[str, str]
    baud: Literal[9600, 19200, 38400, 57600, 115200] = 9600


class BenchModel(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A bench file as it is written.

    Attributes:
        version: version of this format.
        targets: what answers at the far end, by names of your choosing.
        world: where it stands.
        links: how it is connected.
        faults: what goes wrong on the links.
    """

    version: Literal[1]
    targets: dict[str, Target]
    world: World = World()
    links: tuple[Link, ...] = ()
    faults: tuple[FaultEntry, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchFile:
    """A bench file that was read and understood.

    Attributes:
        name: of a built-in bench, or the file's name.
        path: where it was read.
        digest: SHA-256 of the file, in hex.
        world: where the robot stands.
        targets: what answers, by name.
        links: the lines between them.
        faults: what goes wrong on the lines; each says which way (``towards``), but for those of both ways.
    """

    name: str
    path: Path
    digest: str
    world: World
    targets: Mapping[str, Target]
    links: tuple[Link, ...]
    faults: tuple[FaultEntry, ...] = ()

    def header(self, seed: int) -> dict[str, object]:
        """Return what a journal says of the bench in its first line; `seed` is that of the run."""
        faults = [fault.describe() for fault in self.faults]
        return {"seed": seed, "bench": self.name, "bench_sha256": self.digest, "faults": faults}


def built_in_benches() -> tuple[str, ...]:
    """Return the names of the benches that come with hilbench."""
    return tuple(sorted(file.stem for file in BUILT_IN_FOLDER.glob("*.toml")))


def open_bench(bench: str | None = None) -> BenchFile:
    """Read a bench file.

    Args:
        bench: name of a built-in bench or path of a file; None for ``./hilbench.toml`` if there is one and else
            ``pioneer``.

    Raises:
        UsageError: there is no such bench, or its file is wrong; the line is named.
    """
    if bench is None:
        return read_bench(DEFAULT_FILE) if DEFAULT_FILE.is_file() else open_bench(DEFAULT_BENCH)
    if bench in built_in_benches():
        return read_bench(BUILT_IN_FOLDER / f"{bench}.toml", name=bench)
    if "/" in bench or bench.endswith(".toml") or Path(bench).exists():
        return read_bench(Path(bench))
    raise UsageError("no such bench", where=bench, hint=did_you_mean(bench, built_in_benches(), "built-in benches"))


def read_bench(path: Path, name: str = "") -> BenchFile:
    """Read a bench file from a path; see `open_bench`."""
    text = _text(path)
    model = _Reader(path, text).read()
    return BenchFile(
        name=name or path.name,
        path=path,
        digest=hashlib.sha256(text.encode()).hexdigest(),
        world=model.world,
        targets=model.targets,
        links=model.links,
        faults=model.faults,
    )


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
    if not scene.endswith(".toml"):
        raise UsageError(f"no scene '{scene}'", where=where, hint=did_you_mean(scene, scene_names(), "built-in scenes"))
    if not (folder / scene).is_file():
        raise UsageError(f"no scene file '{folder / scene}'", where=where)
    try:
        read_scene(folder / scene)
    except SceneFileError as error:
        raise UsageError(str(error)) from None
    return str(folder / scene)


def bench_schema() -> dict[str, Any]:
    """Return the JSON Schema of bench files."""
    schema = json_schema(BenchModel, "hilbench bench file")
    settings = schema["$defs"][RobotSettings.__name__]["properties"]
    for item in dataclasses.fields(RobotSettings):
        unit, source = item.metadata["unit"], item.metadata["source"]
        settings[item.name]["description"] = f"{unit}; {source}" if unit else source
    return schema


class _Reader:
    """Reads one file, and knows where in it everything is."""

    def __init__(self, path: Path, text: str) -> None:
        self._path = path
        self._text = text
        self._strict = Strict(self._place, LATER)

    def read(self) -> BenchModel:
        try:
            data = tomllib.loads(self._text)
        except tomllib.TOMLDecodeError as error:
            raise _syntax_error(self._path, str(error)) from None
        model = self._strict.convert(data, BenchModel)
        self._check_targets(model)
        self._check_links(model)
        return self._with_directions(self._with_scene(model))

    def _place(self, path: tuple[str | int, ...]) -> str:
        line = find_line(self._text, path)
        return f"{self._path}:{line}" if line is not None else str(self._path)

    def _check_targets(self, model: BenchModel) -> None:
        if not model.targets:
            raise self._strict.error("[targets] names no target", ("targets",), "add [targets.robot]")
        if len(model.targets) > 1:
            second = list(model.targets)[1]
            message = f"'{second}': more than one target is not available in this version of hilbench"
            raise self._strict.error(message, ("targets", second))

    def _check_links(self, model: BenchModel) -> None:
        if len(model.links) > 1:
            raise self._strict.error("a second link: this bench has one line", ("links", 1))
        known = _ends(model)
        for number, link in enumerate(model.links):
            for end in link.ends:
                if end not in known:
                    hint = did_you_mean(end, known, "ends")
                    raise self._strict.error(f"'{end}' is not the end of a link", ("links", number, "ends"), hint)
            if link.ends[0] == link.ends[1]:
                raise self._strict.error(f"both ends are '{link.ends[0]}'", ("links", number, "ends"))

    def _with_directions(self, model: BenchModel) -> BenchModel:
        """Let each fault say where it goes, by its receiving end."""
        ends = model.links[0].ends if model.links else _ends(model)
        faults = [self._with_direction(number, fault, ends) for number, fault in enumerate(model.faults)]
        return msgspec.structs.replace(model, faults=tuple(faults))

    def _with_direction(self, number: int, fault: FaultEntry, ends: tuple[str, ...]) -> FaultEntry:
        if fault.link > 0:
            message = f"there is no link {fault.link}: this bench has one line, link 0"
            raise self._strict.error(message, ("faults", number, "link"))
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

    def _with_scene(self, model: BenchModel) -> BenchModel:
        place = self._place(("world", "scene"))
        scene = resolve_scene(model.world.scene, self._path.parent, place)
        return msgspec.structs.replace(model, world=msgspec.structs.replace(model.world, scene=scene))


def _ends(model: BenchModel) -> tuple[str, ...]:
    """Return every end a link can have: the checker's, and the host port of each target."""
    return (CHECKER_END, *(f"{name}.host" for name in model.targets))


def _syntax_error(path: Path, message: str) -> UsageError:
    place = re.search(r" \(at line (\d+), column \d+\)$", message)
    if place is None:
        return UsageError(f"is not TOML: {message}", where=str(path))
    return UsageError(f"is not TOML: {message[: place.start()]}", where=f"{path}:{place[1]}")


def _text(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except UnicodeDecodeError as error:
        raise UsageError(f"is not UTF-8 text: {error.reason} at byte {error.start}", where=str(path)) from None
    except FileNotFoundError:
        hint = did_you_mean(path.stem, built_in_benches(), "built-in benches")
        raise UsageError("no such bench file", where=str(path), hint=hint) from None
    except OSError as error:
        raise UsageError(f"cannot be read: {error.strerror}", where=str(path)) from None
