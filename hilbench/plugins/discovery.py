"""Finds protocols: those of installed packages by their entry points, and those of files that somebody names.

An installed package names them in its ``pyproject.toml``::

    [project.entry-points."hilbench.protocols"]
    tiny = "tiny.plugin:TINY"

Names are known without an import. The code of a plug-in runs when its protocol is used, with the rights of the user.
"""

from __future__ import annotations

import importlib
import importlib.util
import sys
from collections.abc import Iterator, Mapping
from functools import cached_property
from importlib import metadata
from pathlib import Path
from types import ModuleType

from hilbench.errors import PluginError, UsageError
from hilbench.nearest import did_you_mean
from hilbench.plugins.blame import place_of
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.plugins.validity import problem_of

__all__ = ["PLUGINS", "Plugins"]

GROUP = "hilbench.protocols"
_OURS = "the package hilbench"


class Plugins:
    """The protocols that there are.

    Attributes:
        broken: what is wrong with installed ones that were looked at and cannot be used, one line each.
    """

    def __init__(self) -> None:
        self.broken: dict[str, str] = {}
        self._files: dict[Path, tuple[ProtocolPlugin, ...]] = {}
        self._loaded: dict[str, ProtocolPlugin] = {}
        self._used: set[str] = set()

    def names(self) -> list[str]:
        """Return the names of all protocols, those of hilbench first; nothing is imported."""
        return sorted({*self._installed, *self._of_files()}, key=lambda name: (not self.is_own(name), name))

    def origin(self, name: str) -> str:
        """Return where a protocol comes from, for people."""
        if name in self._of_files():
            return next(str(path) for path, found in self._files.items() if any(one.name == name for one in found))
        return _package(self._installed[name][0])

    def protocol(self, name: str, where: str) -> ProtocolPlugin:
        """Return a protocol by its name.

        Args:
            name: as on the command line.
            where: who names it, for the message.

        Raises:
            UsageError: there is none of this name, there are two, or it cannot be imported.
        """
        found = self._protocol(name, where)
        self._used.add(name)
        return found

    def _protocol(self, name: str, where: str) -> ProtocolPlugin:
        if name in self.broken:
            raise UsageError(self.broken[name], where=where)
        found = self._of_files().get(name) or self._loaded.get(name)
        if found is not None:
            return found
        points = self._installed.get(name)
        if points is None:
            raise UsageError(
                f"no protocol '{name}'", where=where, hint=did_you_mean(name, self.names(), "protocols that are there")
            )
        loaded = _load(name, points)
        if not self.is_own(name):
            self._check_title(loaded, f"protocol '{name}' of {_package(points[0])}")
        self._loaded[name] = loaded
        return loaded

    def known(self, name: str) -> ProtocolPlugin | None:
        """Return a protocol by its name; None if there is none, or none that can be used."""
        if name not in self.names() or name in self.broken:
            return None
        try:
            return self._protocol(name, name)
        except UsageError as error:
            self.broken[name] = str(error)
            return None

    def fails(self, name: str, error: Exception) -> None:
        """Do without a protocol whose code has raised an error; one of our own is a defect, and raised again."""
        if self.is_own(name):
            raise error
        place = place_of(error, self.brought)
        self.refuse(name, f"{place}{': ' if place else ''}{type(error).__name__}: {error}")

    def refuse(self, name: str, why: str) -> None:
        """Do without a protocol from now on, for a reason in words.

        Raises:
            PluginError: somebody has named it, and cannot do without.
        """
        if name in self._used:
            raise PluginError(why, where=f"protocol '{name}' of {self.origin(name)}")
        self.broken[name] = f"protocol '{name}' of {self.origin(name)}: {why}; it is left out"

    def all(self) -> Iterator[ProtocolPlugin]:
        """Yield all protocols that can be used, in the order of `names`; what cannot is in `broken`."""
        for name in self.names():
            found = self.known(name)
            if found is not None:
                yield found

    def add_file(self, path: Path, where: str) -> None:
        """Run a file, and take the protocols that it defines: the `ProtocolPlugin` records at its top level.

        Args:
            path: the file.
            where: who names it, for messages.

        Raises:
            UsageError: it cannot be imported, defines none, or one of a name that there is already.
        """
        path = path.resolve()
        if path in self._files:
            return
        module = _run(path, where)
        there = [one for one in vars(module).values() if isinstance(one, ProtocolPlugin)]
        known = [*self._loaded.values(), *(one for file in self._files.values() for one in file)]
        found = tuple(one for one in there if not any(one is other for other in known))
        if not there:
            raise UsageError(f"'{path}' defines no protocol", where=where, hint="see docs/plugins.md")
        for one in found:
            _check(one, str(path))
            self._check_title(one, str(path))
            if one.name in self.names():
                message = f"'{path}' brings the protocol '{one.name}', which comes from {self.origin(one.name)} already"
                raise UsageError(message, where=where, hint="give it a name of its own")
        self._files[path] = found

    def files(self) -> list[Path]:
        """Return the files that were run."""
        return [*self._files]

    def _check_title(self, found: ProtocolPlugin, where: str) -> None:
        """Refuse a title that is there: it is the capability by which a suite belongs to a bench."""
        others = [self._protocol(name, where) for name in self._installed if self.is_own(name)]
        others += [*self._loaded.values(), *self._of_files().values()]
        for other in others:
            if other is not found and other.title == found.title:
                message = f"has the title '{found.title}', and so has '{other.name}'"
                raise UsageError(message, where=where, hint="give it one of its own")

    def brought(self, file: Path) -> bool:
        """Say whether a file of code was brought by a plug-in that was used: it stands beside it, or in its package."""
        if file.parent in {path.parent for path in self._files}:
            return True
        return any(_is_in_package(file, name) for name in self._packages)

    @property
    def _packages(self) -> set[str]:
        """The packages of plug-ins that were used, but for our own."""
        used = (self._installed[name][0] for name in self._loaded if not self.is_own(name))
        return {point.module.partition(".")[0] for point in used}

    @cached_property
    def _installed(self) -> Mapping[str, tuple[metadata.EntryPoint, ...]]:
        found: dict[str, tuple[metadata.EntryPoint, ...]] = {}
        for point in metadata.entry_points(group=GROUP):
            found[point.name] = (*found.get(point.name, ()), point)
        for name, points in found.items():
            own = tuple(point for point in points if _package(point) == _OURS)
            for point in points if own else ():
                if point not in own:
                    who = f"protocol '{name}' of {_package(point)}"
                    self.broken[who] = f"{who}: the name is that of one of hilbench's own; it is left out"
            found[name] = own or points
        return found

    @cached_property
    def _own(self) -> frozenset[str]:
        return frozenset(name for name, points in self._installed.items() if _package(points[0]) == _OURS)

    def is_own(self, name: str) -> bool:
        """Say whether a protocol comes with hilbench."""
        return name in self._own

    def _of_files(self) -> Mapping[str, ProtocolPlugin]:
        return {one.name: one for found in self._files.values() for one in found}


def _is_in_package(file: Path, package: str) -> bool:
    where = getattr(sys.modules.get(package), "__file__", None)
    if where is None:
        return False
    begin = Path(where)
    return file.is_relative_to(begin.parent) if begin.name == "__init__.py" else file == begin


def _load(name: str, points: tuple[metadata.EntryPoint, ...]) -> ProtocolPlugin:
    packages = list(dict.fromkeys(map(_package, points)))
    where = f"protocol '{name}' of {packages[0]}"
    if len({point.value for point in points}) > 1:
        raise UsageError(f"comes from {' and from '.join(packages)}", where=f"protocol '{name}'", hint="uninstall one")
    try:
        found = points[0].load()
    except (Exception, SystemExit) as error:  # whatever the code of a stranger raises
        raise UsageError(f"cannot be imported: {type(error).__name__}: {error}", where=where) from error
    if not isinstance(found, ProtocolPlugin):
        raise UsageError(f"'{points[0].value}' is no ProtocolPlugin", where=where)
    _check(found, where)
    if found.name != name:
        raise UsageError(f"calls itself '{found.name}'", where=where, hint="entry point and record need one name")
    return found


def _check(found: ProtocolPlugin, where: str) -> None:
    problem = problem_of(found)
    if problem:
        raise UsageError(problem, where=where)


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


def _package(point: metadata.EntryPoint) -> str:
    return f"the package {point.dist.name}" if point.dist is not None else point.value


PLUGINS = Plugins()
"""Those of this process."""
