"""A suite on a bench with a board: as it is, and with a mistake soldered in or another program on the board.

What is right has to pass, every clause has to have a mistake that fails it, and nothing else may come of a mistake than
a clause that fails.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping
from dataclasses import dataclass
from typing import TypeVar

from hilbench.bench.shared import Shared
from hilbench.benchfile.bench_file import BenchFile
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, Verdict, list_cases, run_suites
from hilbench.check.collector import PlannedCase
from hilbench.check.results import Report
from hilbench.exit_codes import ExitCode
from hilbench.journal import Journal
from hilbench.judging.provider import BenchProvider
from hilbench.mcu.board_provider import BoardProvider
from hilbench.terminal.options import TargetChoice
from measure.mutants.alterations import Alteration
from measure.mutants.each_its_own import Fault, judge
from targets.firmware import image_path

AnyResult = TypeVar("AnyResult")
Row = tuple[str, str, Alteration | None, Mapping[str, str]]


def first_of_each(rows: Iterable[Row]) -> list[Row]:
    """Return the first row of each clause."""
    return list({row[0]: row for row in reversed([*rows])}.values())


def unaltered(bench_file: BenchFile) -> BenchFile:
    """Leave a bench as it is."""
    return bench_file


def failures(report: Report) -> dict[str, str]:
    """Return why each case did not pass that did not, by its name without the suite's."""
    return {case.id.partition("/")[2]: case.cause for case in report.cases if case.verdict is not Verdict.PASS}


@dataclass(frozen=True, slots=True, kw_only=True)
class AlteredBench:
    """A suite, and the bench that it runs on.

    Attributes:
        bench: a built-in bench whose board is called ``brain``.
        board: what this board is.
        suite: the suite.
        clause_ids: the clauses that the suite checks.
    """

    bench: str
    board: str
    suite: str
    clause_ids: Collection[str]

    def check(
        self, select: str = "", *, alter: Alteration | None = None, images: Mapping[str, str] | None = None
    ) -> Report:
        """Run the suite on benches with a mistake in each; ``images`` run instead of the programs they stand for."""
        return self._act(run_suites, select, alter or unaltered, images or {})

    def cases(self) -> list[PlannedCase]:
        """Return all cases of the suite."""
        return self._act(list_cases, "", unaltered, {})

    def _act(
        self,
        act: Callable[[CheckOptions, BenchProvider], AnyResult],
        select: str,
        alter: Alteration,
        images: Mapping[str, str],
    ) -> AnyResult:
        options = CheckOptions(bench=self.bench, suites=(self.suite,), select=select)
        return act(options, self._provider(alter, images))

    def _provider(self, alter: Alteration, images: Mapping[str, str]) -> BoardProvider:
        choices = [
            TargetChoice(name=f"brain.{name}", spec=f"{self.board}:{image_path(image)}")
            for name, image in images.items()
        ]
        shared = Shared(bench_file=open_bench(self.bench), timeout_scale=1.0, journal=Journal())
        return BoardProvider(shared, choices, alter=alter)

    # --- what tests require of it

    def require_right(self, select: str) -> None:
        """Require that cases pass on the bench as it is."""
        report = self.check(select)
        assert failures(report) == {}, failures(report)
        assert report.exit_code == ExitCode.OK, report.exit_code
        assert report.run_hash, report.no_run_hash

    def require_found(self, rows: Iterable[Row], *, until_found: bool = False) -> set[str]:
        """Require that each mistake fails its clause, and whatever fails, by a verdict; return these clauses.

        Args:
            rows: clause, selection of its cases, mistake (None for none), images that run instead.
            until_found: see `judge`.
        """
        faults = [
            Fault(
                name=f"{select} {number}",
                clause_id=clause_id,
                select=select,
                open_case=self._provider(alter or unaltered, images).open_case,
            )
            for number, (clause_id, select, alter, images) in enumerate(rows)
        ]
        options = CheckOptions(bench=self.bench, suites=(self.suite,))
        verdicts = judge(options, self._provider(unaltered, {}), faults, until_found=until_found)
        assert verdicts.not_found == {}, verdicts.not_found
        return verdicts.found_by

    def require_complete(self, found_clause_ids: Iterable[str]) -> None:
        """Require that every clause has a case that can run here, and a mistake that it finds."""
        cases, wanted = self.cases(), set(self.clause_ids)
        cited = {clause.id for case in cases for clause in case.clauses}
        assert cited == wanted, f"cases for other clauses than there are: {cited ^ wanted}"
        found = set(found_clause_ids)
        assert found == wanted, f"mistakes for other clauses than there are: {found ^ wanted}"
        missing = [case.id for case in cases if case.missing]
        assert not missing, missing

    def require_all_right(self, report: Report) -> None:
        """Require that a report of the whole suite has a pass for every clause."""
        assert failures(report) == {}, failures(report)
        assert report.exit_code == ExitCode.OK, report.exit_code
        reported = {clause.id for clause in report.clauses}
        assert reported == set(self.clause_ids), reported ^ set(self.clause_ids)

    def require_same_hashes(self, report: Report, select: str) -> None:
        """Require that cases run once more have the hashes that they have in a report."""
        hashes = {case.id: case.case_hash for case in report.cases}
        again = {case.id: case.case_hash for case in self.check(select).cases}
        assert again, f"nothing is selected by {select}"
        assert again.items() <= hashes.items(), again.items() - hashes.items()
