"""What all benches of a run have in common: the bench file, the journal, how long to wait."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from hilbench.bench import Bench
from hilbench.bench.line_faults import LineFaults, describe_faults
from hilbench.benchfile.reader import BenchFile
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.judging.provider import CaseInfo

if TYPE_CHECKING:
    from hilbench.bench.operator import Operator
    from hilbench.through import Routes


@dataclass(frozen=True, slots=True, kw_only=True)
class Shared:
    """What all benches of a run have in common.

    Attributes:
        bench_file: what was asked for.
        timeout_scale: how much longer to wait.
        journal: where everything is recorded.
        route: what the checker's ports stand behind; None for nothing.
        operator: somebody beside the target; None if nobody is.
    """

    bench_file: BenchFile
    timeout_scale: float
    journal: Journal
    route: Routes | None = None
    operator: Operator | None = None

    @property
    def suites(self) -> Sequence[str]:
        """What is checked where no suite is asked for."""
        return self.bench_file.suites

    def bench(self, scheduler: Scheduler) -> Bench:
        """Return a bench on a scheduler."""
        bench = Bench(scheduler, self.journal, timeout_scale=self.timeout_scale)
        bench.route = self.route
        return bench

    def close(self, now_ns: int = 0) -> None:
        """Give up what the checker's ports stand behind, let the operator go, close the journal at this bench time, ns.

        Raises:
            UnavailableError: the journal could not be written to its end.
        """
        if self.route is not None:
            self.route.close()
        if self.operator is not None:
            self.operator.close()
        self.journal.close(now_ns)

    def describe(self, target: str, physics: str) -> Mapping[str, str]:
        """Name the parts of the bench, and the faults that everything it says is subject to."""
        parts = {"bench": self.bench_file.name, "target": target, "physics": physics}
        faults = describe_faults(self.bench_file.faults)
        lines = {"lines": self.route.words} if self.route else {}
        return {**parts, **lines, **({"faults": faults} if faults else {})}

    def line_faults(
        self,
        bench: Bench,
        case: CaseInfo,
        *,
        near_is_client: bool,
        on_interruption: Callable[[], None] = lambda: None,
    ) -> LineFaults | None:
        """Return the bench file's faults for the lines of a case, which begins now; None if it names none."""
        if not self.bench_file.faults:
            return None
        return LineFaults(
            bench,
            self.bench_file.faults,
            seed=case.seed,
            near_is_client=near_is_client,
            on_interruption=on_interruption,
        )
