"""The records of one kind: those of installed packages, by their entry points, and those of files.

Names are known without an import. The code of a plug-in runs when its record is used, with the rights of the user.
"""

from __future__ import annotations

import sys
import traceback
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property
from importlib import metadata
from pathlib import Path
from typing import Any, Generic, TypeVar

from hilbench.errors import PluginError, UsageError
from hilbench.nearest import did_you_mean
from hilbench.plugins.blame import place_of

__all__ = ["Registry"]

RecordT = TypeVar("RecordT", bound=Any)

_OURS = "the package hilbench"


class Registry(Generic[RecordT]):
    """The records of one kind that there are; each has a ``name``.

    Args:
        kind: their class.
        group: of entry points.
        called: what a message calls one.
        problem_of: says what is wrong with one, in words; empty for nothing.

    Attributes:
        broken: what is wrong with installed ones that were looked at and cannot be used, one line each.
    """

    def __init__(self, kind: type[RecordT], group: str, called: str, problem_of: Callable[[RecordT], str]) -> None:
        self.broken: dict[str, str] = {}
        self._kind = kind
        self._group = group
        self._called = called
        self._problem_of = problem_of
        self._files: dict[Path, tuple[RecordT, ...]] = {}
        self._loaded: dict[str, RecordT] = {}
        self._used: set[str] = set()

    def names(self) -> list[str]:
        """Return the names of all of them, those of hilbench first; nothing is imported."""
        return sorted({*self._installed, *self._of_files()}, key=lambda name: (not self.is_own(name), name))

    def origin(self, name: str) -> str:
        """Return where one comes from, for people."""
        if name in self._of_files():
            return next(str(path) for path, found in self._files.items() if any(one.name == name for one in found))
        return _package(self._installed[name][0])

    def is_own(self, name: str) -> bool:
        """Say whether one comes with hilbench."""
        return name in self._own

    def get(self, name: str, where: str) -> RecordT:
        """Return one by its name.

        Args:
            name: as on the command line.
            where: who names it, for the message.

        Raises:
            UsageError: there is none of this name, there are two, or it cannot be imported.
        """
        found = self._get(name, where)
        self._used.add(name)
        return found

    def _get(self, name: str, where: str) -> RecordT:
        if name in self.broken:
            raise UsageError(self.broken[name], where=where)
        found = self._of_files().get(name) or self._loaded.get(name)
        if found is not None:
            return found
        points = self._installed.get(name)
        if points is None:
            hint = did_you_mean(name, self.names(), f"{self._called}s that are there")
            raise UsageError(f"no {self._called} '{name}'", where=where, hint=hint)
        loaded = self._load(name, points)
        if not self.is_own(name):
            self._check_others(loaded, f"{self._called} '{name}' of {_package(points[0])}")
        self._loaded[name] = loaded
        return loaded

    def known(self, name: str) -> RecordT | None:
        """Return one by its name; None if there is none, or none that can be used."""
        if name not in self.names() or name in self.broken:
            return None
        try:
            return self._get(name, name)
        except UsageError as error:
            self.broken[name] = str(error)
            return None

    def fails(self, name: str, error: Exception) -> None:
        """Do without one whose code has raised an error; one of our own is a defect, and raised again."""
        if self.is_own(name):
            raise error
        place = place_of(error, self.brought)
        self.refuse(name, f"{place}{': ' if place else ''}{type(error).__name__}: {error}")

    def refuse(self, name: str, why: str) -> None:
        """Do without one from now on, for a reason in words.

        Raises:
            PluginError: somebody has named it, and cannot do without.
        """
        where = f"{self._called} '{name}' of {self.origin(name)}"
        if name in self._used:
            raise PluginError(why, where=where)
        self.broken[name] = f"{where}: {why}; it is left out"

    def all(self) -> Iterator[RecordT]:
        """Yield all that can be used, in the order of `names`; what cannot is in `broken`."""
        for name in self.names():
            found = self.known(name)
            if found is not None:
                yield found

    def there(self) -> Iterator[RecordT]:
        """Yield hilbench's own, those that were used, and those of files: no code of a stranger runs for it."""
        for name in self.names():
            if self.is_own(name) or name in self._loaded or name in self._of_files():
                found = self.known(name)
                if found is not None:
                    yield found

    # --- files

    def add(self, path: Path, values: Sequence[object], where: str) -> bool:
        """Take the records that the module of a file has at its top level.

        Args:
            path: the file.
            values: of the module's names.
            where: who names it, for messages.

        Returns:
            Whether it has any, of its own or imported.

        Raises:
            UsageError: one cannot be used, or has a name that there is already.
        """
        there = [one for one in values if isinstance(one, self._kind)]
        known = [*self._loaded.values(), *(one for file in self._files.values() for one in file)]
        found = tuple(one for one in there if not any(one is other for other in known))
        for one in found:
            self._check(one, str(path))
            self._check_others(one, str(path))
            if [other.name for other in found].count(one.name) > 1:
                message = f"'{path}' brings two {self._called}s called '{one.name}'"
                raise UsageError(message, where=where, hint="give each a name of its own")
            if one.name in self.names():
                what = f"the {self._called} '{one.name}', which comes from {self.origin(one.name)} already"
                raise UsageError(f"'{path}' brings {what}", where=where, hint="give it a name of its own")
        self._files[path] = found
        return bool(there)

    def files(self) -> list[Path]:
        """Return the files that were run."""
        return [*self._files]

    def brought(self, file: Path) -> bool:
        """Say whether a file of code was brought by a plug-in that was used: it stands beside it, or in its package."""
        if file.parent in {path.parent for path in self._files}:
            return True
        return any(_is_in_package(file, name) for name in self._packages)

    def _check_others(self, found: RecordT, where: str) -> None:
        """Refuse what does not go with the others that there are."""

    def _check(self, found: RecordT, where: str) -> None:
        try:
            problem = self._problem_of(found)
        except Exception as error:  # noqa: BLE001 - whatever the code of a stranger raises when it is looked at
            at = traceback.extract_tb(error.__traceback__)[-1]
            problem = f"{Path(at.filename).name}:{at.lineno}: {type(error).__name__}: {error}"
        if problem:
            raise UsageError(problem, where=where)

    def _load(self, name: str, points: tuple[metadata.EntryPoint, ...]) -> RecordT:
        packages = list(dict.fromkeys(map(_package, points)))
        where = f"{self._called} '{name}' of {packages[0]}"
        if len({point.value for point in points}) > 1:
            message = f"comes from {' and from '.join(packages)}"
            raise UsageError(message, where=f"{self._called} '{name}'", hint="uninstall one")
        try:
            found = points[0].load()
        except (Exception, SystemExit) as error:  # whatever the code of a stranger raises
            raise UsageError(f"cannot be imported: {type(error).__name__}: {error}", where=where) from error
        if not isinstance(found, self._kind):
            raise UsageError(f"'{points[0].value}' is no {self._kind.__name__}", where=where)
        self._check(found, where)
        if found.name != name:
            raise UsageError(f"calls itself '{found.name}'", where=where, hint="entry point and record need one name")
        return found

    @property
    def _packages(self) -> set[str]:
        """The packages of plug-ins that were used, but for our own."""
        used = (self._installed[name][0] for name in self._loaded if not self.is_own(name))
        return {point.module.partition(".")[0] for point in used}

    @cached_property
    def _installed(self) -> Mapping[str, tuple[metadata.EntryPoint, ...]]:
        found: dict[str, tuple[metadata.EntryPoint, ...]] = {}
        for point in metadata.entry_points(group=self._group):
            found[point.name] = (*found.get(point.name, ()), point)
        for name, points in found.items():
            own = tuple(point for point in points if _package(point) == _OURS)
            for point in points if own else ():
                if point not in own:
                    who = f"{self._called} '{name}' of {_package(point)}"
                    self.broken[who] = f"{who}: the name is that of one of hilbench's own; it is left out"
            found[name] = own or points
        return found

    @cached_property
    def _own(self) -> frozenset[str]:
        return frozenset(name for name, points in self._installed.items() if _package(points[0]) == _OURS)

    def _of_files(self) -> Mapping[str, RecordT]:
        return {one.name: one for found in self._files.values() for one in found}


def _is_in_package(file: Path, package: str) -> bool:
    where = getattr(sys.modules.get(package), "__file__", None)
    if where is None:
        return False
    begin = Path(where)
    return file.is_relative_to(begin.parent) if begin.name == "__init__.py" else file == begin


def _package(point: metadata.EntryPoint) -> str:
    return f"the package {point.dist.name}" if point.dist is not None else point.value
