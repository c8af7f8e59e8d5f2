"""The pytest plugin behind ``hilbench check`` and behind plain ``pytest -p hilbench.pytest_plugin``.

It gives cases their bench, decides what applies, and turns what happens into results. Everything that knows pytest is
here and in `hilbench.check.pytest_run`.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Iterable, Iterator, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from hilbench.bench.locked_providers import LockedProvider
from hilbench.benchfile.suites import is_shipped, suite_name
from hilbench.check.cases import spec_of
from hilbench.check.catalogue import titles
from hilbench.check.collector import Collector, PlannedCase
from hilbench.check.planning import plan_case, refuse_conflicts
from hilbench.check.results import CaseResult
from hilbench.check.screens import SHOWN_VERDICTS, Screens
from hilbench.check.selection import Candidate, compile_selection
from hilbench.errors import HilbenchError, UsageError
from hilbench.judging.doubt import doubted, excused
from hilbench.judging.outcome import PASSED, Outcome, outcome_of, printable, with_open_points
from hilbench.judging.provider import (
    Attended,
    BenchProvider,
    CaseBench,
    CaseInfo,
    CaseView,
    Doubtful,
    Following,
    Lacking,
    Preparing,
    Timed,
    Viewable,
)
from hilbench.judging.recorder import Recorded, recording, uncertain
from hilbench.judging.verdicts import Verdict, marked

NS_PER_S = 1_000_000_000

_PLAN = pytest.StashKey[PlannedCase]()
_RUN = pytest.StashKey["_CaseRun"]()

ProgressCallback = Callable[[PlannedCase, int, int], None]
ResultCallback = Callable[[CaseResult, int, int], None]


class _CaseRun:
    """What is known of the case that is running."""

    def __init__(self, planned: PlannedCase, screens: Screens | None = None, *, margins: bool = False) -> None:
        self.planned = planned
        self.screens = screens
        self.margins = margins
        self.ended: Outcome = PASSED
        self.outcome: Outcome = PASSED
        self.recorded = Recorded()
        self.bench: CaseBench | None = None
        self.began_ns = 0
        self.bench_time_s = 0.0
        self.case_hash = ""
        self.judged = False
        self.in_doubt = False
        self.view: CaseView | None = None

    def opened(self, bench: CaseBench) -> None:
        self.bench = bench
        self.began_ns = bench.now_ns
        if self.screens is not None and isinstance(bench, Viewable):
            bench.watch()
        if self.margins and isinstance(bench, Timed):
            bench.keep_margins()

    def uncertainty_s(self) -> float:
        """Return how far off times of the case may be, in seconds."""
        bench: object = self.bench
        return bench.uncertainty_s() if isinstance(bench, Doubtful) else 0.0

    def judge(self, outcome: Outcome) -> None:
        """Take the outcome of the case proper, and what the bench says of it while it is still open."""
        self.judged = True
        self.ended = outcome
        self.outcome = with_open_points(outcome, self.recorded.unclear)
        if self.bench is None:
            return
        try:
            self._ask(self.bench)
        except Exception as error:  # noqa: BLE001 - whatever a provider raises must become a result
            self.worsen(outcome_of(error))

    def _ask(self, bench: CaseBench) -> None:
        self.bench_time_s = (bench.now_ns - self.began_ns) / NS_PER_S
        if isinstance(bench, Doubtful):
            self.outcome = doubted(self.outcome, bench.doubt())
        if isinstance(bench, Lacking) and self.outcome.verdict is not Verdict.PASS:
            self.outcome = excused(self.outcome, bench.lacks())
        self.in_doubt = self.outcome.verdict is not self.ended.verdict
        if self.outcome.verdict is not Verdict.PASS:
            asked = (f"asked of the operator: {one}" for one in self.recorded.asked)
            self.outcome = _with_evidence(self.outcome, (*asked, *bench.evidence()))
        bench.finish(self.outcome.verdict.value, marked(self.outcome.cause, self.planned.by_own_report))
        self.case_hash = bench.case_hash()
        if self.screens is not None and self.outcome.verdict in SHOWN_VERDICTS and isinstance(bench, Viewable):
            self.view = bench.view()

    def look_on(self) -> bool:
        """Add to the evidence what comes after a failure; return whether somebody interrupted that.

        The verdict stands, whatever happens meanwhile.
        """
        bench: object = self.bench
        if self.outcome.verdict is not Verdict.FAIL or not isinstance(bench, Following):
            return False
        try:
            seen = tuple(bench.afterwards())
        except KeyboardInterrupt:
            return True
        except Exception as error:  # noqa: BLE001 - whatever a provider raises: the target has failed before
            seen = (f"looking on failed: {type(error).__name__}: {error}",)
        self.outcome = _with_evidence(self.outcome, seen)
        return False

    def worsen(self, outcome: Outcome) -> None:
        """Take the outcome of tearing down: a failure there is never the target's, and outranks what was said."""
        if outcome.verdict is Verdict.PASS:
            return
        before = (f"before that: {self.outcome.cause}",) if self.outcome.cause else ()
        self.outcome = Outcome(
            verdict=Verdict.ERROR,
            cause=outcome.cause,
            evidence=(*outcome.evidence, *before),
            defect=not (outcome.lost or outcome.suite_error),
            suite_error=outcome.suite_error,
            lost=outcome.lost,
        )

    def picture(self) -> str:
        """Draw what was to be seen when the case failed; return the file, empty if there is none."""
        if self.screens is None or self.view is None:
            return ""
        outcome = self.outcome
        return self.screens.save(self.planned.id, self.view, outcome.verdict, printable(outcome.cause))

    def result(self) -> CaseResult:
        """Return what came of it, with its picture."""
        planned = self.planned
        about = (self.outcome.clause,) if self.outcome.clause in planned.clause_ids else ()
        return CaseResult(
            id=planned.id,
            suite=planned.suite,
            clause_ids=planned.clause_ids,
            verdict=self.outcome.verdict,
            cause=printable(self.outcome.cause),
            failed_clause_ids=about,
            evidence=tuple(printable(line) for line in self.outcome.evidence),
            measures=tuple(self.recorded.measures),
            families=tuple(self.recorded.families),
            asked=tuple(self.recorded.asked),
            by_own_report=planned.by_own_report,
            defect=self.outcome.defect,
            suite_error=self.outcome.suite_error,
            seed=planned.seed,
            bench_time_s=self.bench_time_s,
            case_hash=self.case_hash,
            screen=self.picture(),
        )


def _with_evidence(outcome: Outcome, more: tuple[str, ...]) -> Outcome:
    return replace(outcome, evidence=(*outcome.evidence, *(line for line in more if line not in outcome.evidence)))


class CheckPlugin:
    """One run's plugin.

    Args:
        collector: where plans and results go.
        provider: opens the benches.
        seed: seed of the run.
        select: the expression of ``-k``.
        only: the ids of the cases that may run, of those that ``select`` has selected before; None for all of these.
        only_cases: whether a test without ``@case`` is refused, and what does not apply is taken out; under plain
            pytest such a test is the user's own business, and what does not apply is skipped.
        on_case: called before each case with the case, its number from 1, and how many there are.
        on_result: called after each case that ran to its end, with its result in the place of the case.
        screens: draws what was to be seen when a case failed; None for no pictures.
        margins: whether the journal gets how much time timers had left in a case that does not pass.
    """

    def __init__(
        self,
        collector: Collector,
        provider: BenchProvider,
        *,
        seed: int,
        select: str = "",
        only: frozenset[str] | None = None,
        only_cases: bool = True,
        on_case: ProgressCallback | None = None,
        on_result: ResultCallback | None = None,
        screens: Screens | None = None,
        margins: bool = False,
    ) -> None:
        self.collector = collector
        self.refusal: HilbenchError | None = None
        self.unreadable: list[tuple[Path, BaseException]] = []
        self._provider = provider
        self._seed = seed
        self._select = select
        self._only = only
        self._functions = None if only is None else {_function_of(case_id) for case_id in only}
        self._only_cases = only_cases
        self._on_case = on_case
        self._on_result = on_result
        self._screens = screens
        self._margins = margins
        self._started = 0
        self._to_run = 0

    # What a case can ask for.

    @pytest.fixture
    def bench(self, request: pytest.FixtureRequest) -> Iterator[CaseBench]:
        """The bench of this case: a fresh one on a virtual target, a settled one on a real target."""
        run = request.node.stash.get(_RUN, None)
        if run is None:
            raise UsageError("has no @case, so there is no bench for it", where=request.node.nodeid)
        with ExitStack() as stack:
            try:
                bench = stack.enter_context(self._provider.open_case(_info(run.planned)))
            except UsageError as error:  # a target that cannot even be meant: no verdict on anything
                self.refusal = error
                request.session.shouldstop = str(error)
                raise
            run.opened(bench)
            yield bench

    @pytest.fixture
    def peer(self, bench: CaseBench) -> object:
        """The checker's own end of the line."""
        return getattr(bench, "peer")  # noqa: B009 - the attributes are the provider's business

    @pytest.fixture
    def server(self, bench: CaseBench) -> object:
        """The scripted server that a client under test talks to."""
        return getattr(bench, "server")  # noqa: B009

    @pytest.fixture
    def world(self, bench: CaseBench) -> object:
        """The world around the target."""
        return getattr(bench, "world")  # noqa: B009

    @pytest.fixture
    def journal(self, bench: CaseBench) -> object:
        """The journal of this case."""
        return getattr(bench, "journal")  # noqa: B009

    @pytest.fixture
    def client(self, bench: CaseBench) -> object:
        """The client under test."""
        return getattr(bench, "client")  # noqa: B009

    # Which cases there are, and which of them run.

    @pytest.hookimpl(tryfirst=True)
    def pytest_pycollect_makeitem(self, name: str, obj: object) -> list[pytest.Item] | None:
        """Make nothing of a function with none of the cases that may run: to plan all takes longer than many a case."""
        if self._functions is None or isinstance(obj, type) or not name.startswith("test_") or name in self._functions:
            return None
        return []

    @pytest.hookimpl(tryfirst=True)
    def pytest_collection_modifyitems(self, items: list[pytest.Item]) -> None:
        """Plan, select, and set apart what does not apply."""
        if self.unreadable:
            return
        try:
            self._plan(items)
        except HilbenchError as error:
            self._refuse(items, error)

    @pytest.hookimpl
    def pytest_collection_finish(self, session: pytest.Session) -> None:
        """Say what is missing for the cases that are going to run, now that everybody has selected."""
        if session.config.option.collectonly or not isinstance(self._provider, Preparing):
            return
        plans = [item.stash[_PLAN] for item in session.items if _PLAN in item.stash]
        try:
            self._provider.prepare([_info(plan) for plan in plans if not plan.missing])
        except HilbenchError as error:
            self._refuse(session.items, error)

    def _refuse(self, items: list[pytest.Item], error: HilbenchError) -> None:
        """Run nothing, and say why: whoever runs the engine raises the refusal, plain pytest has to be given it."""
        self.refusal = error
        items.clear()
        if not self._only_cases:
            pytest.exit(f"hilbench: {error}", returncode=int(error.exit_code))

    def _plan(self, items: list[pytest.Item]) -> None:
        by_hand = self._provider.by_hand if isinstance(self._provider, Attended) else frozenset()
        for item in items:
            self._plan_item(item, by_hand)
        plans = [item.stash[_PLAN] for item in items if _PLAN in item.stash]
        refuse_conflicts(plans)
        if self._only_cases:
            self._refuse_foreign(plans)
        if self._only is not None:
            items[:] = [item for item in items if _PLAN in item.stash and item.stash[_PLAN].id in self._only]
        else:
            wanted = compile_selection(self._select, {clause for plan in plans for clause in plan.clause_ids})
            items[:] = [item for item in items if _PLAN not in item.stash or wanted(_candidate(item.stash[_PLAN]))]
        self.collector.plan(item.stash[_PLAN] for item in items if _PLAN in item.stash)
        if self._screens is not None:
            self._screens.plan(plan.id for plan in self.collector.planned)
        if self._only_cases:
            items[:] = [item for item in items if not item.stash[_PLAN].missing]
        self._to_run = len(items)

    def _refuse_foreign(self, plans: Sequence[PlannedCase]) -> None:
        """Refuse a suite that was asked for and is of a protocol that is not spoken here, or at a port of boards.

        Raises:
            UsageError: all of its cases need one.
        """
        spoken, own = titles(), {suite_name(Path(one)) for one in getattr(self._provider, "suites", ())}
        for suite in sorted({plan.suite for plan in plans} - own):
            lacks = set.intersection(*({*plan.missing} for plan in plans if plan.suite == suite))
            for protocol in sorted(lacks & spoken):
                message = f"is a suite of {protocol}, which this bench does not speak"
                raise UsageError(message, where=f"--suite {suite}", hint="name a bench whose target speaks it")
            if "boards" in lacks and isinstance(self._provider, LockedProvider):
                message = "is a suite of emulated boards, and there are none here"
                raise UsageError(message, where=f"--suite {suite}", hint="name a bench with boards")

    def pytest_generate_tests(self, metafunc: pytest.Metafunc) -> None:
        """Make a case for each of the benches that a function asks for."""
        spec = spec_of(metafunc.function)
        if spec is not None and spec.setups:
            metafunc.parametrize("bench", list(spec.setups), indirect=True)

    def _plan_item(self, item: pytest.Item, by_hand: Collection[str]) -> None:
        spec = spec_of(getattr(item, "function", None))
        if spec is not None and spec.setups:
            spec = spec.on(item.callspec.params["bench"])  # type: ignore[attr-defined]
        if spec is None:
            if self._only_cases:
                raise UsageError("has no @case", where=f"{item.path}: {item.name}", hint="say which clause it checks")
            return
        plan = plan_case(
            spec,
            suite=suite_name(item.path),
            suite_argument=_suite_argument(item.path),
            name=_case_name(item),
            run_seed=self._seed,
            capabilities=self._provider.capabilities,
            by_hand=by_hand,
        )
        item.stash[_PLAN] = plan
        if plan.missing:
            item.add_marker(pytest.mark.skip(reason=f"not applicable: no {', '.join(plan.missing)}"))

    @pytest.hookimpl
    def pytest_exception_interact(self, node: pytest.Item | pytest.Collector, call: pytest.CallInfo[object]) -> None:
        """Keep why a suite could not be read."""
        if isinstance(node, pytest.Collector) and call.excinfo is not None:
            self.unreadable.append((node.path, call.excinfo.value))

    # Running them.

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, object, object]:
        """Run one case from opening its bench to closing it, and enter its result."""
        planned = item.stash.get(_PLAN, None)
        if planned is None or planned.missing:
            return (yield)
        self._started += 1
        if self._on_case is not None:
            self._on_case(planned, self._started, self._to_run)
        run = item.stash[_RUN] = _CaseRun(planned, self._screens, margins=self._margins)
        with recording() as run.recorded, uncertain(run.uncertainty_s):
            handled = yield
        del item.stash[_RUN]  # or every bench of the run, megabytes each, would be kept to its end
        result = run.result()
        self.collector.enter(result)
        if self._on_result is not None and self.refusal is None:
            self._on_result(result, self._started, self._to_run)
        if run.outcome.lost:
            self.collector.stop(f"target lost: {run.outcome.cause}")
        if self.collector.stopped:
            item.session.shouldstop = self.collector.stopped
        return handled

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(
        self, item: pytest.Item, call: pytest.CallInfo[None]
    ) -> Generator[None, pytest.TestReport, pytest.TestReport]:
        """Judge what a phase of the case ended with."""
        run = item.stash.get(_RUN, None)
        if run is not None:
            own_suite = None if is_shipped(item.path) else item.path
            outcome = _outcome(call.excinfo.value if call.excinfo is not None else None, own_suite)
            if call.when == "teardown":
                run.worsen(outcome)
            elif call.when == "call" or outcome is not PASSED:
                run.judge(outcome)
                if run.look_on():
                    self.collector.stop("interrupted", interrupted=True)
        report = yield
        if run is not None and call.when == "call" and run.in_doubt:
            report.outcome = "failed"
            report.longrepr = f"inconclusive: {run.outcome.cause}"
        return report

    @pytest.hookimpl(tryfirst=True)
    def pytest_keyboard_interrupt(self, excinfo: pytest.ExceptionInfo[BaseException]) -> None:
        """Tell an interruption from our own stopping."""
        # Pytest draws the way to it, and cannot where CPython has no line number: a signal may come between two lines.
        excinfo.traceback = type(excinfo.traceback)(filter(_has_line, excinfo.traceback))
        excinfo.value.__suppress_context__ = True
        if isinstance(excinfo.value, pytest.Session.Interrupted):
            return
        if isinstance(excinfo.value, KeyboardInterrupt):
            self.collector.stop("interrupted", interrupted=True)
        else:
            self.collector.defects.append(f"a case ended the run: {excinfo.value}")
            self.collector.stop(self.collector.defects[-1])

    def pytest_internalerror(self, excinfo: pytest.ExceptionInfo[BaseException]) -> None:
        """Keep what went wrong inside pytest or this plugin."""
        self.collector.defects.append(f"{excinfo.typename}: {excinfo.value}")
        self.collector.stop("a defect in hilbench")


def items_by_case(items: Iterable[pytest.Item]) -> dict[str, pytest.Item]:
    """Return pytest's items of the planned cases, by the ids of these."""
    return {item.stash[_PLAN].id: item for item in items if _PLAN in item.stash}


def _has_line(entry: Any) -> bool:
    try:
        return bool(entry.lineno >= 0)
    except TypeError:
        return False


def _outcome(error: BaseException | None, own_suite: Path | None) -> Outcome:
    if isinstance(error, pytest.skip.Exception):
        return Outcome(verdict=Verdict.NOT_APPLICABLE, cause=str(error.msg))
    if isinstance(error, pytest.fail.Exception):
        return Outcome(verdict=Verdict.FAIL, cause=str(error.msg))
    if own_suite is not None and isinstance(error, pytest.FixtureLookupError):
        there = f"no fixture '{error.argname}'; a case has bench, peer, server, client, world, journal"
        return Outcome(verdict=Verdict.ERROR, cause=f"{own_suite.name}: {there}", suite_error=True)
    return outcome_of(error, own_suite)


def _case_name(item: pytest.Item) -> str:
    """Return class, function and parameters: ``test_sync[2]`` in class ``TestOpen`` is ``TestOpen.sync[2]``."""
    classes = [node.name for node in item.listchain() if isinstance(node, pytest.Class)]
    return ".".join([*classes, item.name.removeprefix("test_")])


def _function_of(case_id: str) -> str:
    """Return the name of a case's function: ``test_sync`` for ``mine/TestOpen.sync[2]``."""
    return "test_" + case_id.partition("/")[2].partition("[")[0].rpartition(".")[2]


def _suite_argument(path: Path) -> str:
    return suite_name(path) if is_shipped(path) else str(path)


def _info(planned: PlannedCase) -> CaseInfo:
    return CaseInfo(
        id=planned.id,
        clause_ids=planned.clause_ids,
        seed=planned.seed,
        scene=planned.scene,
        needs=planned.needs,
        by_hand=planned.by_hand,
        setup=planned.setup,
    )


def _candidate(planned: PlannedCase) -> Candidate:
    titles = [clause.title for clause in planned.clauses]
    return Candidate.of(planned.clause_ids, [planned.id, planned.suite, *titles])
