"""What tests ran: records a whole run of a tree's tests, and reads the record."""

from __future__ import annotations

import json
import os
import sqlite3
import subprocess
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import coverage

from measure.gate_proof.copies import Copy
from measure.gate_proof.plugins.gate_store import COLLECTING, Part
from measure.gate_proof.plugins.gate_tracer import FOLDER, PACKAGES, TREE

_AT_THE_END = {0, 1, 5}
"""What pytest returns when all tests were run: they passed, some failed, there were none."""


@dataclass(frozen=True, slots=True)
class Test:
    """How a test went while it was recorded.

    Attributes:
        cpu_s: processor time, with that of the processes it waited for; recording doubles it.
        wall_s: time on the host's clock.
        passed: it did pass.
    """

    cpu_s: float
    wall_s: float
    passed: bool

    @property
    def took_s(self) -> float:
        """What a test of this kind costs: it computes, or it waits."""
        return max(self.cpu_s, self.wall_s)


class Recording:
    """The tests of a tree, and the lines each runs.

    Args:
        path: the file it is in.
    """

    def __init__(self, path: Path) -> None:
        self._store = sqlite3.connect(f"file:{path}?mode=ro", uri=True, check_same_thread=False)
        rows = self._store.execute(
            "SELECT context, name, cpu_s, wall_s, outcome FROM test JOIN context ON id = context"
        )
        self._names: dict[int, str] = {}
        self.tests: dict[str, Test] = {}
        for number, name, cpu_s, wall_s, outcome in rows:
            self._names[number] = name
            self.tests[name] = Test(cpu_s, wall_s, outcome == "passed")
        self._users: dict[int, set[str]] = defaultdict(set)
        for number, fixture in self._store.execute("SELECT test, fixture FROM shares"):
            self._users[fixture].add(self._names[number])

    def ran(self, path: str) -> Iterator[tuple[frozenset[str], int]]:
        """Give the tests that ran something of a file, with its lines as bits; nothing of what collecting tests ran."""
        rows = self._store.execute("SELECT context, lines FROM ran JOIN file ON id = file WHERE path = ?", (path,))
        for context, lines in rows:
            tests = {self._names[context]} if context in self._names else self._users.get(context)
            if tests:
                yield frozenset(tests), int.from_bytes(lines, "little")

    def totals(self, tree: Path) -> dict[str, Counter[str]]:
        """Return what was reached of each package: counts of statements and branches, and of those that ran."""
        arcs: dict[str, list[tuple[int, int]]] = defaultdict(list)
        for path, start, stop in self._store.execute("SELECT path, start, stop FROM arc JOIN file ON id = file"):
            arcs[str(tree / path)].append((start, stop))
        files = [str(file) for package in PACKAGES for file in sorted((tree / package).rglob("*.py"))]
        with tempfile.TemporaryDirectory() as folder:
            data = coverage.CoverageData(f"{folder}/data")
            data.add_arcs({name: pairs for name, pairs in arcs.items() if Path(name).is_file()})
            data.touch_files(files)
            data.write()
            measured = coverage.Coverage(f"{folder}/data", config_file=False, branch=True)
            measured.load()
            measured.json_report(outfile=f"{folder}/report.json")
            report = json.loads(Path(folder, "report.json").read_text(encoding="utf-8"))
        totals: dict[str, Counter[str]] = {package: Counter() for package in PACKAGES}
        for name, about in report["files"].items():
            package = Path(os.path.relpath(name, tree) if Path(name).is_absolute() else name).parts[0]
            told = about["summary"]
            wanted = ("num_statements", "covered_lines", "num_branches", "covered_branches")
            totals[package].update({key: told[key] for key in wanted})
        return totals


def record(copy: Copy, into: Path, words: Sequence[str], workers: int, environment: Mapping[str, str]) -> bool:
    """Run tests of a copy and write what they ran.

    Args:
        copy: the tree, with an environment of its own.
        into: the file to write.
        words: for pytest: which tests.
        workers: how many processes.
        environment: what is set beside ours.

    Returns:
        Whether pytest came to its end; that some tests fail is no matter.
    """
    with tempfile.TemporaryDirectory(prefix="gate-") as folder:
        settings = {**os.environ, **environment, FOLDER: folder, TREE: str(copy.tree)}
        settings.pop("PYTHONDONTWRITEBYTECODE", None)
        command = [str(copy.python), "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "gate_recorder", "-r", "fE"]
        command += ["-n", str(workers), "--dist", "worksteal", *words]
        code = subprocess.run(command, cwd=copy.tree, env=settings, stdout=2, check=False).returncode
        if code in _AT_THE_END:
            join(Path(folder), into)
    return code in _AT_THE_END


def join(folder: Path, into: Path) -> None:
    """Put what several processes wrote into one file.

    Args:
        folder: where they wrote.
        into: the file to write.
    """
    draft = into.with_suffix(".draft")
    draft.unlink(missing_ok=True)
    whole = Part(draft)
    for path in sorted(folder.glob("part-*.sqlite")):
        whole.take_in(path)
    for path in sorted(folder.glob("child-*.json")):
        told = _of_child(path)
        if told is not None:
            whole.ran(*told)
    whole.close()
    draft.replace(into)


def _of_child(path: Path) -> tuple[str, dict[str, list[tuple[int, int]]]] | None:
    try:
        told = json.loads(path.read_text(encoding="utf-8"))
    except ValueError:
        return None  # it was ended while it wrote
    return told["context"] or COLLECTING, {name: [(a, b) for a, b in pairs] for name, pairs in told["arcs"].items()}
