"""Finds the tests that a defect is put before, and the order in which they run."""

from __future__ import annotations

import difflib
from collections import defaultdict
from collections.abc import Collection, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from measure.gate_proof.defects import Defect, lines_in_functions, names_imported
from measure.gate_proof.plugins.gate_tracer import PACKAGES
from measure.gate_proof.recording import Recording, Test

SLOW_S = 2.0
"""A test that takes longer comes after the others of its file."""
NEIGHBOURS_S = 30.0
"""So much time is given to tests that do not run the line, but stand in a file with some that do: a cache that one test
fills hides from the record that others depend on it."""


@dataclass(frozen=True, slots=True)
class Selection:
    """The tests for a defect.

    Attributes:
        order: their names, in the order in which they run.
        covering: how many of them run the line, or use the module that it belongs to.
    """

    order: Sequence[str]
    covering: int


class Tree:
    """A tree at a commit, and what its tests ran.

    Args:
        root: where it is.
        recordings: of its tests; a test in several counts once.
    """

    def __init__(self, root: Path, recordings: Sequence[Recording]) -> None:
        self.root = root
        self._recordings = recordings
        self.tests: Mapping[str, Test] = {name: test for one in recordings for name, test in one.tests.items()}
        self._by_file: dict[str, list[str]] = defaultdict(list)
        for name in self.tests:
            self._by_file[file_of(name)].append(name)

    def source(self, path: str) -> bytes | None:
        """Return the text of a module, if there is one."""
        file = self.root / path
        return file.read_bytes() if file.is_file() else None

    def modules(self) -> list[str]:
        """Return the paths of all modules of the product."""
        files = (file for package in PACKAGES for file in (self.root / package).rglob("*.py"))
        return sorted(str(file.relative_to(self.root)) for file in files)

    @cache  # noqa: B019 - a tree lives as long as the program
    def _ran(self, path: str) -> list[tuple[frozenset[str], int]]:
        return [row for recording in self._recordings for row in recording.ran(path)]

    def running(self, path: str, lines: Iterable[int]) -> set[str]:
        """Return the tests that run any of some lines of a module."""
        mask = _bits(lines)
        return {name for tests, bits in self._ran(path) if bits & mask for name in tests}

    def lines_run(self, path: str) -> set[int]:
        """Return the lines of a module that tests run."""
        bits = 0
        for _, more in self._ran(path):
            bits |= more
        return {line for line in range(bits.bit_length()) if bits >> line & 1}

    @cache  # noqa: B019 - a tree lives as long as the program
    def users(self, path: str) -> frozenset[str]:
        """Return the tests that call anything in a module."""
        return frozenset(self.running(path, lines_in_functions(self.source(path) or b"")))

    def importers(self, path: str) -> set[str]:
        """Return the modules that import a module, also by way of a package that hands its names on."""
        found, fresh = set[str](), [path]
        while fresh:
            more = set(self._importers().get(module_name(fresh.pop()), ())) - found
            found |= more
            fresh += [one for one in more if one.endswith("/__init__.py")]
        return found

    @cache  # noqa: B019 - a tree lives as long as the program
    def _importers(self) -> dict[str, list[str]]:
        found: dict[str, list[str]] = defaultdict(list)
        for path in self.modules():
            for name in set(names_imported(self.source(path) or b"")):
                found[name].append(path)
        return found

    @cache  # noqa: B019 - a tree lives as long as the program
    def reach(self, path: str) -> frozenset[str]:
        """Return the tests that call anything in a module, or in one that imports it."""
        return self.users(path).union(*(self.users(importer) for importer in self.importers(path)))

    def covering(self, defect: Defect) -> Set[str]:
        """Return the tests that run the changed line, or that use what it defines where it runs at import."""
        if not defect.in_function:
            return self.reach(defect.path)
        *lines, statement = defect.lines
        found = self.running(defect.path, lines) or self.running(defect.path, [statement])
        return found if self._is_called(defect.path, (*lines, statement)) else found | self.reach(defect.path)

    def _is_called(self, path: str, lines: Iterable[int]) -> bool:
        """Whether some test ran lines of a module otherwise than while it was imported."""
        mask, inside = _bits(lines), _bits(lines_in_functions(self.source(path) or b""))
        return any(bits & mask and not bits & ~inside for _, bits in self._ran(path))

    def selection(self, defect: Defect, without: Collection[str] = ()) -> Selection:
        """Return the tests for a defect.

        Args:
            defect: the defect.
            without: tests that are not to be run.
        """
        covering = self.covering(defect) - set(without)
        beside = {name for file in {file_of(name) for name in covering} for name in self._by_file[file]}
        beside -= covering | set(without)
        own = self._own(defect.path)
        order = self._in_order(covering, own)
        order += _within(self._in_order(beside, own), self.tests, NEIGHBOURS_S)
        return Selection(order, len(covering))

    def known(self, order: Iterable[str]) -> list[str]:
        """Return all tests that stand in the files of some."""
        return [name for file in {file_of(name) for name in order} for name in self._by_file[file]]

    def _own(self, path: str) -> str:
        """Return how the file of a module's own tests begins."""
        folder, _, name = path.removesuffix(".py").rpartition("/")
        return f"tests/{folder}/test_{name.lstrip('_')}"

    def _in_order(self, names: Collection[str], own: str) -> list[str]:
        """Order tests by file: the module's own, then those that take least together."""
        by_file: dict[str, list[str]] = defaultdict(list)
        for name in (name for name in self.tests if name in names):
            by_file[file_of(name)].append(name)
        took = {file: sum(self.tests[name].took_s for name in found) for file, found in by_file.items()}
        files = sorted(by_file, key=lambda file: (not file.startswith(own), took[file], file))
        return [
            name for file in files for name in sorted(by_file[file], key=lambda one: self.tests[one].took_s > SLOW_S)
        ]


def _bits(lines: Iterable[int]) -> int:
    """Return lines as bits."""
    bits = 0
    for line in lines:
        bits |= 1 << line
    return bits


def file_of(name: str) -> str:
    """Return the file of a test."""
    return name.partition("::")[0]


def module_name(path: str) -> str:
    """Return a module's dotted name."""
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def _within(order: Sequence[str], tests: Mapping[str, Test], limit_s: float) -> list[str]:
    """Return the first of some tests, as many as fit into a time."""
    taken, spent_s = [], 0.0
    for name in order:
        spent_s += tests[name].took_s
        if spent_s > limit_s:
            break
        taken.append(name)
    return taken


def moved_lines(old: bytes, new: bytes) -> dict[int, int]:
    """Return where the lines of a text have gone in a newer one; those that were changed are left out."""
    blocks = difflib.SequenceMatcher(None, old.splitlines(), new.splitlines(), autojunk=False).get_matching_blocks()
    return {one.a + 1 + line: one.b + 1 + line for one in blocks for line in range(one.size)}
