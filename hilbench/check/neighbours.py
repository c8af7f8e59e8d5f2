"""Lets a suite of the user's own import what lies beside it."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from types import ModuleType

import pytest

from hilbench.benchfile.suites import is_shipped

__all__ = ["Neighbours"]


class Neighbours:
    """A plugin. The folder of the suite at hand is the last of those in which modules are looked for.

    So nothing in it takes the place of what is installed. What a suite has imported from there is put aside while
    another one, which may have neighbours of the same names, is read or runs.
    """

    def __init__(self) -> None:
        self._folder: Path | None = None
        self._added = False
        self._aside: dict[Path, dict[str, ModuleType]] = {}

    def pytest_collectstart(self, collector: pytest.Collector) -> None:
        """A suite is about to be read."""
        if isinstance(collector, pytest.Module):
            self._enter(None if is_shipped(collector.path) else collector.path.parent)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """A case is about to run."""
        self._enter(None if is_shipped(item.path) else item.path.parent)

    def pytest_unconfigure(self) -> None:
        """Leave everything as it was."""
        self._enter(None)

    def _enter(self, folder: Path | None) -> None:
        if folder == self._folder:
            return
        if self._folder is not None:
            self._aside[self._folder] = {name: sys.modules.pop(name) for name in [*_modules_in(self._folder)]}
            if self._added:
                with contextlib.suppress(ValueError):  # a suite may have taken it away
                    sys.path.remove(str(self._folder))
        self._folder = folder
        if folder is not None:
            self._added = str(folder) not in sys.path
            sys.path += [str(folder)] * self._added
            sys.modules.update(self._aside.pop(folder, {}))


def _modules_in(folder: Path) -> Iterator[str]:
    """Yield the modules that are in a folder, and in packages there; not those of what is installed below it."""
    within = os.path.join(folder, "")  # noqa: PTH118 - ends with the separator
    for name in [*sys.modules]:
        file = getattr(sys.modules.get(name.partition(".")[0]), "__file__", None)
        if not isinstance(file, str) or not file.startswith(within):  # of a thousand modules hardly any is
            continue
        if Path(file).name == "__init__.py":
            file = str(Path(file).parent)
        if Path(file).parent == folder:
            yield name
