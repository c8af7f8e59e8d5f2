"""Runs suites on a bench: from options and a provider to a report.

`run_suites` returns the report and prints nothing; it is the way in for programs. `run_check` is ``hilbench check``.
"""

from __future__ import annotations

import contextlib
import signal
import tempfile
import threading
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import msgspec

from hilbench.benchfile.suites import find_suites, is_shipped
from hilbench.check import last_failed
from hilbench.check.collector import Collector, PlannedCase
from hilbench.check.evaluate import make_report
from hilbench.check.given import ProviderFactory
from hilbench.check.heartbeat import Heartbeat
from hilbench.check.report import check_outputs, ci, listing, write_report
from hilbench.check.results import CaseResult, Report
from hilbench.check.screens import Draw, Screens
from hilbench.clock import Stopwatch
from hilbench.errors import HilbenchError, InternalError, UnavailableError, UsageError
from hilbench.exit_codes import ExitCode
from hilbench.files.names import escaped
from hilbench.judging.observations import Observing
from hilbench.judging.provider import BenchProvider, Choosing, Journalled
from hilbench.judging.verdicts import Verdict, marked
from hilbench.terminal.console import Console
from hilbench.terminal.options import CheckOptions

if TYPE_CHECKING:
    from hilbench.check.parallel import Crew
    from hilbench.check.plugin import CheckPlugin, ProgressCallback, ResultCallback

_LINE = 200
"""Columns that a line about a case has at most, in a log."""

_ENOUGH_TO_TELL = 10
"""Cases after which it is told how long the rest will take (choice)."""


def run_suites(
    options: CheckOptions,
    provider: BenchProvider,
    *,
    on_case: ProgressCallback | None = None,
    on_result: ResultCallback | None = None,
    screens: Screens | None = None,
    only: frozenset[str] | None = None,
) -> Report:
    """Run the suites that the options select on the benches of a provider.

    Args:
        options: what to run; the options for reports are ignored.
        provider: opens the benches; the caller closes it.
        on_case: called before each case with the case, its number from 1, and the number of cases.
        on_result: called after each case that has ended, with its result instead of the case.
        screens: draws the dashboard when a case fails; None for no pictures.
        only: the ids of the cases that may run; None for all.

    Returns:
        The report. After Ctrl-C, or after the target was lost, it has the cases that were run.

    Raises:
        UsageError: a suite does not exist or cannot be read, or nothing is selected.
        InternalError: a shipped suite cannot be read.
    """
    watch = Stopwatch()
    run = partial(run_cases, options, provider, on_case=on_case, on_result=on_result, screens=screens)
    collector = run(only=only)
    for _ in range(options.rerun_inconclusive):
        _run_again(collector, run)
    observed = provider.observed() if isinstance(provider, Observing) else None
    return make_report(collector, options, provider.describe(), watch.elapsed_s(), observed)


def _run_again(collector: Collector, run: Callable[..., Collector]) -> None:
    """Run the cases that are inconclusive once more; what they were before stays to be seen.

    Those that have a hash are left out: in virtual time the same would come again.
    """
    results = collector.results.values()
    unclear = {case.id: case for case in results if case.verdict is Verdict.INCONCLUSIVE and not case.case_hash}
    if not unclear or collector.stopped:
        return
    again = run(only=frozenset(unclear))
    for case_id, before in unclear.items():
        result = again.results[case_id]
        if result.verdict is not Verdict.NOT_RUN:
            collector.enter(msgspec.structs.replace(result, reruns=(*before.reruns, before.cause)))
    collector.defects += again.defects
    if again.stopped:
        collector.stop(again.stopped, interrupted=again.interrupted)


def list_cases(options: CheckOptions, provider: BenchProvider) -> list[PlannedCase]:
    """Return the cases that the options select, in the order in which they would run; see `run_suites`."""
    return run_cases(options, provider, collect_only=True).planned


def run_check(
    options: CheckOptions,
    provider_factory: ProviderFactory,
    console: Console | None = None,
    draw: Draw | None = None,
) -> int:
    """Do what ``hilbench check`` does: run, write the reports, print the matrix.

    A terminal shows which case runs. A log gets a line when a case ends, and one now and then while a long case runs.

    Args:
        options: what the command line says.
        provider_factory: makes the provider; `hilbench.check.bench_provider` has the one of the product.
        console: where to print; the standard streams by default.
        draw: draws the screen of the dashboard, for `CheckOptions.screens`.

    Returns:
        The exit code.

    Raises:
        HilbenchError: nothing could be run.
    """
    check_outputs(options)
    console = console or Console()
    with _recorded(options) as options:
        return _check(options, provider_factory, console, draw)


@contextlib.contextmanager
def _recorded(options: CheckOptions) -> Iterator[CheckOptions]:
    """Have a run recorded that is to be shown as a page, if nobody else wants the journal."""
    if options.html is None or options.journal is not None:
        yield options
        return
    with tempfile.TemporaryDirectory(prefix="hilbench-check-") as folder:
        yield replace(options, journal=Path(folder) / "run.jsonl")


def _check(options: CheckOptions, provider_factory: ProviderFactory, console: Console, draw: Draw | None) -> int:
    system = ci.Ci.NONE if options.list_only else ci.detected(options.ci)
    provider = provider_factory(options)
    with ci.guarded(system, console), contextlib.ExitStack() as stack:
        stack.callback(provider.close)
        if options.list_only:
            listing.show(list_cases(options, provider), options, console)
            return ExitCode.OK
        only = _only(options, provider, console)
        with _told(console, quiet=options.quiet) as (on_case, on_result):
            screens = None
            if options.screens is not None and draw is not None:
                screens = Screens(options.screens, draw, str(provider.describe().get("bench", "")))
            if options.jobs > 1 and isinstance(provider, Journalled):
                crew = _crew(options, provider, provider_factory, draw, only)
                report, lost = crew.report(provider.describe(), on_case, on_result), crew.lost
            else:
                if options.jobs > 1:
                    console.narrate("--jobs: the cases of this target run one after the other")
                report = run_suites(options, provider, on_case=on_case, on_result=on_result, screens=screens, only=only)
                lost = screens.problem if screens is not None else None
        if options.rerun_inconclusive and any(
            case.verdict is Verdict.INCONCLUSIVE and case.case_hash for case in report.cases
        ):
            console.narrate(
                "--rerun-inconclusive: has no effect in virtual time, where a second run gives the same result"
            )
        with _no_interruption():
            last_failed.remember(report, options)
            code = write_report(report, options, console, _closing_error(stack) or lost)
    ci.tell(system, msgspec.structs.replace(report, exit_code=int(code)), options, console)
    return code


@contextlib.contextmanager
def _told(console: Console, *, quiet: bool) -> Iterator[tuple[ProgressCallback | None, ResultCallback | None]]:
    """Give what tells of each case as it begins and ends: a line that changes on a terminal, lines in a log."""
    if quiet:
        yield None, None
    elif console.watched:
        with console.progress() as show:
            yield _reporter_of_cases(show), None
    else:
        with Heartbeat(console.mention) as heartbeat:
            yield _reporter_of_cases(heartbeat.show), _reporter_of_results(console, heartbeat.spoke)


def _only(options: CheckOptions, provider: BenchProvider, console: Console) -> frozenset[str] | None:
    """Return the cases that ``--last-failed`` leaves; None for all, if it is not asked for or knows of none."""
    if not options.last_failed:
        return None
    planned = list_cases(options, provider)
    failed = last_failed.known(options) & {plan.id for plan in planned if not plan.missing}
    if not failed:
        console.narrate(f"--last-failed: no case is known to have failed here; {len(planned)} are run")
        return None
    console.narrate(f"--last-failed: {len(failed)} of {len(planned)} cases did not pass last time")
    return failed


def _crew(
    options: CheckOptions,
    provider: Journalled,
    provider_factory: ProviderFactory,
    draw: Draw | None,
    only: frozenset[str] | None,
) -> Crew:
    from hilbench.check.parallel import Crew

    assert isinstance(provider, BenchProvider)
    collector = run_cases(options, provider, collect_only=True, only=only)
    return Crew(options, collector, provider_factory, draw, provider.recorded_in)


def _closing_error(stack: contextlib.ExitStack) -> HilbenchError | None:
    """Close the provider, whose journal may have no room for its last lines: the report has to say so."""
    try:
        stack.close()
    except UnavailableError as error:
        return error
    return None


def _reporter_of_cases(show: Callable[[str], None]) -> ProgressCallback:
    watch = Stopwatch()

    def tell(planned: PlannedCase, number: int, total: int) -> None:
        left = _time_left(watch.elapsed_s(), number - 1, total)
        show(f"{number}/{total}{left} {', '.join(planned.clause_ids)} {planned.id}")

    return tell


def _time_left(elapsed_s: float, begun: int, total: int) -> str:
    """Return in words how long the rest will take, if cases take as long as those before; nothing at first."""
    left_s = elapsed_s / begun * (total - begun) if begun >= _ENOUGH_TO_TELL else 0.0
    if left_s < 1:
        return ""
    return f", {left_s:.0f} s left:" if left_s < 100 else f", {left_s / 60:.0f} min left:"


def _reporter_of_results(console: Console, spoke: Callable[[], None]) -> ResultCallback:
    def tell(result: CaseResult, number: int, total: int) -> None:
        said = marked(result.cause, result.by_own_report)
        cause = f": {said}" if said else ""
        text = f"{number}/{total} {result.verdict.value} {', '.join(result.clause_ids)} {result.id}{cause}"
        # A log whose reader has stopped reading must not stop the run: the report says all of it again.
        line = escaped(text)
        console.mention(line if len(line) <= _LINE else f"{line[: _LINE - 1]}…")
        spoke()

    return tell


def run_cases(
    options: CheckOptions,
    provider: BenchProvider,
    *,
    on_case: ProgressCallback | None = None,
    on_result: ResultCallback | None = None,
    collect_only: bool = False,
    screens: Screens | None = None,
    only: frozenset[str] | None = None,
    more: Sequence[object] = (),
) -> Collector:
    """Do as `run_suites`, and return what came of it as it is.

    Args:
        options: as there.
        provider: as there.
        on_case: as there.
        on_result: as there.
        collect_only: plan the run only.
        screens: as there.
        only: as there.
        more: plug-ins of pytest that have a say in which cases run, and when.

    Raises:
        HilbenchError: as there.
    """
    from hilbench.check.plugin import CheckPlugin
    from hilbench.check.pytest_run import run_pytest

    chosen = provider.suites if isinstance(provider, Choosing) else ()
    files = find_suites(options.suites or chosen)
    collector = Collector(max_failures=options.max_failures, strict=options.strict)
    plugin = CheckPlugin(
        collector,
        provider,
        seed=options.seed,
        select=options.select,
        only=only,
        on_case=on_case,
        on_result=on_result,
        screens=screens,
        margins=options.html is not None,
    )
    printed = run_pytest(files, plugin, collect_only=collect_only, more=more) if files else ""
    _raise_refusals(plugin)
    if not collector.planned and not collector.stopped:
        if collector.defects:
            raise InternalError(f"{collector.defects[0]} ({printed[-500:]})")
        raise UsageError("nothing is selected", where=_selection(options), hint="see 'hilbench check --list'")
    return collector


def _raise_refusals(plugin: CheckPlugin) -> None:
    if plugin.refusal is not None:
        raise plugin.refusal
    for path, error in plugin.unreadable:
        raise _unreadable(path, error)


def _unreadable(path: Path, error: BaseException) -> HilbenchError:
    lines = [line for line in str(error).splitlines() if line.strip()] or [type(error).__name__]
    message = f"the suite cannot be read: {lines[-1].removeprefix('E').strip()}"
    if is_shipped(path):
        return InternalError(message, where=str(path))
    return UsageError(message, where=str(path))


def _selection(options: CheckOptions) -> str:
    words = [f"--suite {suite}" for suite in options.suites]
    words += [f"-k '{options.select}'"] if options.select else []
    return " ".join(words) or "check"


@contextlib.contextmanager
def _no_interruption() -> Iterator[None]:
    """Let a second Ctrl-C not tear the report apart that the first one asked for."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
