"""Finds protocols and systems: those of packages by their entry points, and those of files that somebody names.

An installed package names them in its ``pyproject.toml``::

    [project.entry-points."hilbench.protocols"]
    tiny = "tiny.plugin:TINY"

    [project.entry-points."hilbench.systems"]
    head = "head.system:HEAD"
"""

from __future__ import annotations

import contextlib
import importlib
import importlib.util
import sys
from collections.abc import Collection, Iterable, Iterator, Mapping
from pathlib import Path
from types import ModuleType

from hilbench.errors import PluginError, UsageError
from hilbench.plugins.blame import checked
from hilbench.plugins.demo import Demo
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.plugins.registry import Registry
from hilbench.plugins.system import ModelKind, System, VehicleKind
from hilbench.plugins.validity import problem_of, problem_of_system, problem_of_vehicle
from protocols.common.decoding import Speaker
from worlds.errors import UnknownNameError

__all__ = ["PLUGINS", "Plugins", "Systems"]


class Plugins(Registry[ProtocolPlugin]):
    """The protocols that there are.

    Attributes:
        systems: the systems that there are.
    """

    def __init__(self) -> None:
        super().__init__(ProtocolPlugin, "hilbench.protocols", "protocol", problem_of)
        self.systems = Systems()

    def add_file(self, path: Path, where: str) -> None:
        """Run a file, and take the protocols and systems that it defines: the records at its top level.

        Args:
            path: the file.
            where: who names it, for messages.

        Raises:
            UsageError: it cannot be imported, defines none, or one of a name that there is already.
        """
        path = path.resolve()
        if path in self._files:
            return
        values = [*vars(_run(path, where)).values()]
        found = [registry.add(path, values, where) for registry in (self, self.systems)]
        if not any(found):
            del self._files[path]
            raise UsageError(f"'{path}' defines no protocol and no system", where=where, hint="see docs/plugins.md")

    def brought(self, file: Path) -> bool:
        """Say whether a file of code was brought by a plug-in that was used: it stands beside it, or in its package."""
        return super().brought(file) or self.systems.brought(file)

    def lines_of_broken(self) -> list[str]:
        """Return what is wrong with installed plug-ins that were looked at and cannot be used, one line each."""
        return [*self.broken.values(), *self.systems.broken.values()]

    def _check_others(self, found: ProtocolPlugin, where: str) -> None:
        """Refuse a title that is there: it is the capability by which a suite belongs to a bench."""
        others = [self._get(name, where) for name in self._installed if self.is_own(name)]
        others += [*self._loaded.values(), *self._of_files().values()]
        for other in others:
            if other is not found and other.title == found.title:
                message = f"has the title '{found.title}', and so has '{other.name}'"
                raise UsageError(message, where=where, hint="give it one of its own")


class Systems(Registry[System]):
    """The systems that there are."""

    def __init__(self) -> None:
        super().__init__(System, "hilbench.systems", "system", problem_of_system)
        self._vehicles: dict[str, VehicleKind] = {}
        self._merged: dict[tuple[int, int], tuple[dict[str, Speaker], dict[str, Speaker]]] = {}

    def models(self) -> Mapping[str, tuple[System, ModelKind]]:
        """Return the models of all systems that are `there`, with their systems, by name."""
        return {name: (system, kind) for system in self.there() for name, kind in system.models().items()}

    def model(self, name: str, where: str) -> tuple[System, ModelKind] | None:
        """Return a model by its name, with its system; None if no system has it.

        Raises:
            UsageError: the installed system that it is called like cannot be used.
        """
        self._use_called_like(name, where)
        return self.models().get(name)

    def vehicle_names(self) -> list[str]:
        """Return the names of the vehicles of all systems that are `there`."""
        return [name for system in self.there() for name in system.vehicles]

    def vehicle(self, name: str) -> VehicleKind:
        """Return a vehicle by its name.

        Raises:
            UnknownNameError: no system has it.
            PluginError: what its system makes is none, or wrong.
        """
        self._use_called_like(name, name)
        if name not in self._vehicles:
            makers = {one: make for system in self.there() for one, make in system.vehicles.items()}
            if name not in makers:
                raise UnknownNameError("vehicle", name, makers)
            made = makers[name]()
            problem = problem_of_vehicle(made)
            if problem:
                raise PluginError(problem, where=f"vehicle '{name}'")
            self._vehicles[name] = made
        return self._vehicles[name]

    def shown(self, name: str) -> Iterator[System]:
        """Yield those that are `there`, and the one that a vehicle or protocol to be shown is called like."""
        with contextlib.suppress(UsageError):
            self._use_called_like(name, name)
        yield from self.there()

    def demos(self, *, physics: bool) -> Mapping[str, Demo]:
        """Return the demos of all systems that are `there`, by the names of these.

        Args:
            physics: whether a physics engine is installed.

        Raises:
            PluginError: what a system returns is no demo.
        """
        made = {one.name: checked(one.demo, Demo, or_none=True)(physics=physics) for one in self.there()}
        return {name: demo for name, demo in made.items() if demo is not None}

    def speakers(self) -> Mapping[str, Speaker]:
        """Return who speaks at the sources of journals that only some systems have; asked for each event."""
        return self._sources()[0]

    def checkers(self) -> Mapping[str, Speaker]:
        """Return those of these that the checker holds in a case, and who is under test then."""
        return self._sources()[1]

    def _sources(self) -> tuple[Mapping[str, Speaker], Mapping[str, Speaker]]:
        key = len(self._loaded), len(self._files)
        if key not in self._merged:
            there = [*self.there()]
            speakers = {source: who for system in there for source, who in system.speakers.items()}
            checkers = {source: who for system in there for source, who in system.checkers.items()}
            self._merged[key] = speakers, checkers
        return self._merged[key]

    def benches(self) -> Mapping[str, Path]:
        """Return the bench files that the systems of files and of packages that were used bring, by name."""
        folders = (system.benches for system in self.there() if system.benches is not None)
        return {file.stem: file for folder in folders for file in sorted(folder.glob("*.toml"))}

    def bench(self, name: str) -> Path | None:
        """Return the bench file of a system by its name; None if no system has it.

        Raises:
            UsageError: the installed system that it is called like cannot be used.
        """
        self._use_called_like(name, name)
        return self.benches().get(name)

    def bench_names(self) -> list[str]:
        """Return the names of `benches`, and of systems of packages that nothing is known of yet: one is called so."""
        strangers = (
            one for one in self._installed if not (self.is_own(one) or one in self._loaded or one in self.broken)
        )
        return [*self.benches(), *strangers]

    def is_of_stranger(self, name: str) -> bool:
        """Say whether a model, vehicle or bench is called like a system of a package that nothing is known of yet."""
        return any(not self.is_own(one) and _is_called_like(name, one) for one in self.names())

    def of_suites(self, suites: Iterable[str]) -> System | None:
        """Return the system that boards belong to, by the suites that are run on them; None for none.

        Whoever opens a port in the place of a board sends what belongs to that system, and nothing else.
        """
        named = {*suites}
        kinds = self.models().values()
        return next((system for system, kind in kinds if named & {*kind.suites}), None)

    def speaking(self, titles: Collection[str]) -> System | None:
        """Return the system one of whose models speaks one of these protocols; None for none."""
        return next((system for system, kind in self.models().values() if kind.protocol in titles), None)

    def _use_called_like(self, name: str, where: str) -> None:
        for one in self.names():
            if not self.is_own(one) and one not in self._used and _is_called_like(name, one):
                self.get(one, where)

    def _check_others(self, found: System, where: str) -> None:
        """Refuse a model or vehicle that is there, and one that is not called like its system."""
        if self.is_own(found.name):
            return
        models, vehicles = self.models(), self.vehicle_names()
        for name in (*found.models(), *found.vehicles):
            if name in models or name in vehicles:
                raise UsageError(f"brings '{name}', which is there already", where=where, hint="give it another name")
        benches = () if found.benches is None else (file.stem for file in found.benches.glob("*.toml"))
        for name in (*found.models(), *found.vehicles, *benches):
            if not _is_called_like(name, found.name):
                hint = f"call it '{found.name}' or '{found.name}-...'"
                raise UsageError(f"brings '{name}', which is not called like it", where=where, hint=hint)


def _is_called_like(name: str, system: str) -> bool:
    return name == system or name.startswith(f"{system}-")


def _run(path: Path, where: str) -> ModuleType:
    """Import a file by its own name, which a suite beside it imports, too; it may import its neighbours."""
    if path.suffix != ".py" or not path.is_file():
        raise UsageError(f"'{path}' is no .py file" if path.exists() else f"no file '{path}'", where=where)
    if str(path.parent) not in sys.path:
        sys.path.append(str(path.parent))
        importlib.invalidate_caches()
    spec = importlib.util.find_spec(path.stem) if path.stem.isidentifier() else None
    if spec is None or spec.loader is None or spec.origin is None or Path(spec.origin).resolve() != path:
        hint = "give the file another name"
        raise UsageError(f"'{path.stem}' cannot be imported as a module, or is another one", where=where, hint=hint)
    try:
        return importlib.import_module(path.stem)
    except (Exception, SystemExit) as error:  # whatever the code of a stranger raises
        line = _line_of(error, path)
        raise UsageError(f"cannot be imported: {type(error).__name__}: {error}", where=f"{path}{line}") from error


def _line_of(error: BaseException, path: Path) -> str:
    if isinstance(error, SyntaxError) and error.lineno:
        return f":{error.lineno}"
    lines, at = [], error.__traceback__
    while at is not None:
        if at.tb_frame.f_code.co_filename == str(path):
            lines.append(at.tb_lineno)
        at = at.tb_next
    return f":{lines[-1]}" if lines else ""


PLUGINS = Plugins()
"""Those of this process."""
