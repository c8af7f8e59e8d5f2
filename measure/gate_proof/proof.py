"""A proof under way: the steps that lead to its table, each of which keeps what it has found in the proof's folder."""

from __future__ import annotations

import dataclasses
import json
import sys
import threading
from collections.abc import Callable, Collection, Iterator, Sequence, Set
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from measure.gate_proof.choice import Module, choose, draw
from measure.gate_proof.copies import a_folder, checkout, copy_of
from measure.gate_proof.crew import side_by_side
from measure.gate_proof.defects import Defect, defects_of
from measure.gate_proof.pace import Pace
from measure.gate_proof.recording import Recording, record
from measure.gate_proof.running import Bench, Outcome
from measure.gate_proof.selection import Tree, file_of, moved_lines

GATE, OLD, OLD_THOROUGH = "gate", "old", "old-thorough"
TESTS: dict[str, tuple[dict[str, str], list[str]]] = {
    GATE: ({}, []),
    OLD: ({}, []),
    OLD_THOROUGH: ({"HILBENCH_THOROUGH": "1"}, ["-m", "thorough"]),
}
"""How the tests of a recording are asked for: the environment and words for pytest. What was marked thorough before
there were two tiers was run by `.ci/run` alone."""


def say(text: str) -> None:
    """Tell whoever waits."""
    sys.stderr.write(f"gate-proof: {text}\n")
    sys.stderr.flush()


@dataclass(frozen=True, slots=True)
class Plan:
    """What is proved.

    Attributes:
        commit: its tests are the gate, and the defects are put into its product.
        before: its tests were the old gate.
        seed: what the choice is drawn from.
        count: how many defects.
        tests: for pytest, where only a part of the tests is taken: for trying this program.
    """

    commit: str
    before: str
    seed: int
    count: int
    tests: Sequence[str] = ()


@dataclass(frozen=True, slots=True)
class Result:
    """What came of a defect before the tests of a gate; nothing if it cannot be put into the tree of that gate."""

    id: str
    gate: str
    outcome: Outcome | None


class Proof:
    """A proof in its folder, which another run of the program takes up where it was left.

    Args:
        folder: where it is kept.
        plan: what is proved, unless the folder holds a plan already.
        workers: how many tests run side by side.
    """

    def __init__(self, folder: Path, plan: Plan, workers: int) -> None:
        folder.mkdir(parents=True, exist_ok=True)
        self.folder = folder
        self._kept = folder / "plan.json"
        self._results = folder / "results.jsonl"
        self._workers = workers
        self._lock = threading.Lock()
        self._cut()
        if self._kept.is_file():
            kept = json.loads(self._kept.read_text())
            self.plan = Plan(**{**kept, "tests": tuple(kept["tests"])})
            if self.plan != plan:
                say(f"going on with {self.plan}, found in {folder}; remove that folder to begin anew")
        else:
            self._keep(plan)

    def _keep(self, plan: Plan) -> None:
        self.plan = plan
        self._kept.write_text(json.dumps(dataclasses.asdict(plan)) + "\n")

    def commit_of(self, name: str) -> str:
        """Return the commit that a recording or a gate belongs to."""
        return self.plan.commit if name == GATE else self.plan.before

    def recording(self, name: str) -> Recording | None:
        """Return what was recorded under a name, if it was."""
        path = self.folder / f"{name}.sqlite"
        return Recording(path) if path.is_file() else None

    def record(self, name: str) -> None:
        """Record what tests run, unless it is done."""
        if (self.folder / f"{name}.sqlite").is_file():
            return
        environment, chosen = TESTS[name]
        say(f"records what the tests of {self.commit_of(name)} run ({name}): twice the time that they take")
        with a_folder() as folder:
            copy = copy_of(self.commit_of(name), folder / "copy")
            words = [*chosen, *self.plan.tests]
            if not record(copy, self.folder / f"{name}.sqlite", words, self._workers, environment):
                raise SystemExit("gate-proof: pytest did not come to its end; what it said is above")

    @contextmanager
    def tree(self, gate: str) -> Iterator[Tree]:
        """Give the tree of a gate, with what its tests ran."""
        names = [GATE] if gate == GATE else [OLD, OLD_THOROUGH]
        with a_folder() as folder:
            root = checkout(self.commit_of(gate), folder / "tree")
            yield Tree(root, [one for one in map(self.recording, names) if one])

    def defects(self) -> list[Defect]:
        """Return the defects, which are chosen once."""
        kept = self.folder / "defects.json"
        if not kept.is_file():
            say("chooses defects")
            with self.tree(GATE) as new, self.tree(OLD) as old:
                modules = [module(path, new, old) for path in new.modules()]
            chosen = choose(modules, self.plan.seed, self.plan.count)
            kept.write_text(json.dumps([dataclasses.asdict(one) for one in chosen], indent=1) + "\n")
        return [Defect(**{**one, "lines": tuple(one["lines"])}) for one in json.loads(kept.read_text())]

    def results(self, gate: str) -> dict[str, Result]:
        """Return what came of the defects before the tests of a gate, by their ids.

        What was found by a test that fails anyway does not count, nor what was missed before the tests were changed.
        """
        unfit, found = self.unfit(gate), dict[str, Result]()
        for told in self._told():
            if told["what"] == "again" and gate == GATE:
                found = {name: one for name, one in found.items() if one.outcome and one.outcome.found}
            elif told["what"] == "forget":
                found = {name: one for name, one in found.items() if name not in told["ids"]}
            elif told["what"] == "result" and told["gate"] == gate:
                outcome = Outcome(**told["outcome"]) if told["outcome"] else None
                found[told["id"]] = Result(told["id"], gate, outcome)
        return {name: one for name, one in found.items() if one.outcome is None or one.outcome.by not in unfit}

    def unfit(self, gate: str) -> set[str]:
        """Return the tests of a gate that fail without a defect too."""
        tried = [told for told in self._told() if told["what"] == "tried" and told["gate"] == gate]
        return {name for told in tried for name in told["failed"]}

    def _cut(self) -> None:
        """Take away a last line that was not written to its end."""
        if self._results.is_file():
            told = self._results.read_bytes()
            self._results.write_bytes(told[: told.rfind(b"\n") + 1])

    def _told(self) -> list[dict[str, Any]]:
        if not self._results.is_file():
            return []
        return [json.loads(line) for line in self._results.read_text().splitlines()]

    def _tell(self, **words: Any) -> None:
        with self._lock, self._results.open("a") as results:
            results.write(json.dumps(words) + "\n")

    def again(self, commit: str) -> None:
        """Put what was missed before the tests of another commit: they were made better, or the product was."""
        (self.folder / f"{GATE}.sqlite").unlink(missing_ok=True)
        self._keep(dataclasses.replace(self.plan, commit=commit))
        self._tell(what="again", commit=commit)

    def forget(self, names: Sequence[str]) -> None:
        """Judge some defects anew, by their ids."""
        self._tell(what="forget", ids=names)

    def left(self, gate: str, defects: Sequence[Defect]) -> list[Defect]:
        """Return the defects that have not been put before the tests of a gate, in an order that says nothing."""
        done = self.results(gate)
        left = [one for one in defects if one.id not in done]
        return sorted(left, key=lambda one: draw(self.plan.seed, one.id, 1))

    def run(self, gate: str, defects: Sequence[Defect]) -> None:
        """Put defects before the tests of a gate, those that have not been.

        Args:
            gate: the new or the old one.
            defects: the defects.
        """
        if not self.left(gate, defects):
            return
        with self.tree(gate) as tree:
            without = self._seen_to_miss(tree) if gate == OLD else frozenset[str]()
            self._try(gate, tree, {name for name, test in tree.tests.items() if not test.passed})
            while left := self.left(gate, defects):
                self._judge_all(gate, tree, left, without)
                found = [one.outcome for one in self.results(gate).values() if one.outcome]
                self._try(gate, tree, {one.by for one in found if one.by in tree.tests})

    def _seen_to_miss(self, old: Tree) -> frozenset[str]:
        """Return the tests of the old gate that the new one has unchanged: what it missed, they have missed."""
        with self.tree(GATE) as new:
            files = {file_of(name) for name in old.tests}
            same = {file for file in files if old.source(file) == new.source(file)}
            return frozenset(name for name, test in new.tests.items() if test.passed and file_of(name) in same)

    def _judge_all(self, gate: str, tree: Tree, defects: Sequence[Defect], without: Collection[str]) -> None:
        pace = Pace(len(defects))
        unfit = self.unfit(gate)

        def judge(bench: Bench, defect: Defect) -> None:
            here = in_tree(defect, tree)
            if here is None:
                self._tell(what="result", id=defect.id, gate=gate, outcome=None)
                return
            with self._lock:
                selection = tree.selection(here, {*without, *unfit})
            outcome = bench.judge(here, selection)
            self._tell(what="result", id=defect.id, gate=gate, outcome=dataclasses.asdict(outcome))
            said = f"{outcome.how}: {outcome.by}" if outcome.found else f"MISSED by {outcome.tests} tests"
            say(f"{gate} {pace.one_more()} {defect.path}:{defect.line} {said}")

        self._side_by_side(gate, tree, defects, judge)

    def _try(self, gate: str, tree: Tree, tests: Set[str]) -> None:
        """Run tests without any defect, those that were not tried yet: who fails then too can find nothing."""
        seen = [told for told in self._told() if told["what"] == "tried" and told["gate"] == gate]
        fresh = sorted(tests - {name for told in seen for name in told["tests"]})
        if not fresh:
            return
        say(f"runs {len(fresh)} tests without any defect")

        def run(bench: Bench, names: list[str]) -> None:
            failed = bench.failures(names)
            self._tell(what="tried", gate=gate, tests=names, failed=failed)
            for name in failed:
                say(f"fails without a defect too: {name}")

        parts = [part for start in range(self._workers) if (part := fresh[start :: self._workers])]
        self._side_by_side(gate, tree, parts, run)

    def _side_by_side(self, gate: str, tree: Tree, jobs: Sequence[Any], work: Callable[[Bench, Any], None]) -> None:
        """Do some jobs in as many copies of the tree as there are workers."""
        stop, benches = threading.Event(), list[Bench]()
        with ExitStack() as stack:
            for _ in range(min(self._workers, len(jobs))):
                folder = stack.enter_context(a_folder())
                benches.append(Bench(copy_of(self.commit_of(gate), folder / "copy"), tree, folder / "w", stop))
            side_by_side(benches, jobs, work, stop)


def in_tree(defect: Defect, tree: Tree) -> Defect | None:
    """Return a defect as it stands in another tree, if the place is there too."""
    source = tree.source(defect.path)
    if source is None:
        return None
    return next((one for one in defects_of(defect.path, source) if one.id == defect.id), None)


def module(path: str, new: Tree, old: Tree) -> Module:
    """Return a module with the defects in lines that the tests of either gate run: what no longer runs counts too."""
    source = new.source(path) or b""
    ran = new.lines_run(path)
    moved = moved_lines(old.source(path) or b"", source)
    ran |= {moved[line] for line in old.lines_run(path) if line in moved}
    reached = bool(new.reach(path) or old.reach(path))
    found = defects_of(path, source) if ran or reached else []
    fit = [one for one in found if (not ran.isdisjoint(one.lines) if one.in_function else reached)]
    return Module(path, source, fit)
