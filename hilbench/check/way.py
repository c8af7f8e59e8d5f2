"""Looks, in the folders above a suite, at nothing but the way to it.

Pytest looks at everything that lies in each folder from the root of the file system down to the file that it is given:
in a folder like ``/tmp`` or a home, that takes longer than most suites.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from functools import cached_property
from pathlib import Path

import pytest

from hilbench.benchfile.suites import SHIPPED_FOLDER, is_shipped

__all__ = ["Way"]


class Way:
    """A plug-in of pytest.

    Args:
        suites: files and folders, as absolute paths; what lies in a folder that is a suite is looked for as usual.
    """

    def __init__(self, suites: Sequence[Path]) -> None:
        self._below: dict[Path, dict[Path, None]] = {}
        for suite in suites:
            for path, above in itertools.pairwise((suite, *suite.parents)):
                self._below.setdefault(above, {})[path] = None
        for suite in suites:
            if suite.is_dir():
                self._below = {above: paths for above, paths in self._below.items() if not above.is_relative_to(suite)}

    def pytest_collect_directory(self, path: Path, parent: pytest.Collector) -> pytest.Collector | None:
        """Take a folder above a suite; not a package of a user's, which may have a set-up of its own."""
        shipped = path == SHIPPED_FOLDER or is_shipped(path)
        if path not in self._below or ((path / "__init__.py").is_file() and not shipped):
            return None
        folder: _FolderAbove = _FolderAbove.from_parent(parent, path=path)
        folder.below = [*self._below[path]]
        return folder


class _FolderAbove(pytest.Directory):
    """A folder of which only so much is looked at.

    Attributes:
        below: what lies in it on the way to suites.
    """

    below: Sequence[Path] = ()

    @cached_property
    def _children(self) -> list[pytest.Item | pytest.Collector]:
        return [*self._collected()]

    def collect(self) -> list[pytest.Item | pytest.Collector]:
        """Return what lies in it: the same each time, as pytest asks once for each file that it is given."""
        return self._children

    def _collected(self) -> Iterator[pytest.Item | pytest.Collector]:
        for path in self.below:
            if path.is_dir():
                folder = self.ihook.pytest_collect_directory(path=path, parent=self)
                yield from [folder] if folder is not None else []
            else:
                yield from self.ihook.pytest_collect_file(file_path=path, parent=self)
