"""What the results of a campaign come to: how often, with which certainty, from which level on, how near to a limit."""

from __future__ import annotations

import itertools
import math
from collections import Counter, defaultdict
from collections.abc import Iterable, Sequence

import msgspec

from hilbench.campaign.point import Figure, Outcome, Point

__all__ = ["ClauseRate", "Distribution", "FactorLevel", "Statistics", "Tally", "number", "statistics", "wilson"]

Result = tuple[Point, Outcome]
Quantiles = tuple[float, float, float, float, float]

_Z = 1.959964
"""Standard normal deviate of a two-sided 95 % interval."""
_BINS = 10
"""Into so many bins of equal numbers a factor goes that has more levels than twice that (choice)."""
_SHARES = (0.0, 0.05, 0.5, 0.95, 1.0)


class Tally(msgspec.Struct, frozen=True, kw_only=True):
    """How often what came out.

    Attributes:
        points: all that have a result.
        passed: pass.
        failed: fail.
        inconclusive: neither can be said.
        errors: could not be run.
        rate: share that fails of those that pass or fail; None if none does.
        low: the lower end of the rate's 95 % interval by Wilson.
        high: its upper end.
    """

    points: int
    passed: int
    failed: int
    inconclusive: int
    errors: int
    rate: float | None
    low: float
    high: float


class FactorLevel(msgspec.Struct, frozen=True, kw_only=True):
    """The points at one level of a factor, or in one bin of its values.

    Attributes:
        factor: its name.
        level: the level, or ``LOW to HIGH`` of a bin.
        value: the level as a number, or the middle of a bin; None for what is no number.
        tally: of its points.
    """

    factor: str
    level: str
    value: float | None
    tally: Tally


class ClauseRate(msgspec.Struct, frozen=True, kw_only=True):
    """A clause that did not always pass.

    Attributes:
        clause: it.
        tally: of the points at which it was judged.
        first_failing: for each factor in numbers, the least value at which it failed.
        last_clean: for each factor in numbers, the greatest value below that at which it passed, if any.
        cause: that of the first failure.
    """

    clause: str
    tally: Tally
    first_failing: dict[str, float]
    last_clean: dict[str, float]
    cause: str


class Distribution(msgspec.Struct, frozen=True, kw_only=True):
    """The figures of one name in one case, over all points.

    Attributes:
        case: the case, whatever its parameters.
        clause: what the figures are about.
        name: what was measured.
        unit: of the figures.
        count: how many.
        values: the least, 5 %, the median, 95 % and the greatest.
        margins: the same of how far they lie from the limit, as a share of its distance from 0, or of half the width of
            what is allowed where there are two limits: 0 at the limit, negative outside. None where there is no limit.
    """

    case: str
    clause: str
    name: str
    unit: str
    count: int
    values: Quantiles
    margins: Quantiles | None


class Statistics(msgspec.Struct, frozen=True, kw_only=True):
    """All of it.

    Attributes:
        planned: how many points the campaign has.
        total: of those that have a result.
        levels: by factor, in order.
        clauses: those that failed or were inconclusive anywhere, the most frequent first.
        figures: the nearest to a limit first, then those that have none.
        bench_time_s: of all points.
    """

    planned: int
    total: Tally
    levels: tuple[FactorLevel, ...]
    clauses: tuple[ClauseRate, ...]
    figures: tuple[Distribution, ...]
    bench_time_s: float


def statistics(results: Sequence[Result], factors: Iterable[str], planned: int) -> Statistics:
    """Add up the results of a campaign."""
    numbers = {name for name in factors if _are_numbers(point.levels.get(name) for point, _ in results)}
    return Statistics(
        planned=planned,
        total=_tally(outcome.verdict for _, outcome in results),
        levels=tuple(level for name in factors for level in _levels(name, results, in_bins=name in numbers)),
        clauses=_clauses(results, numbers),
        figures=_figures(outcome for _, outcome in results),
        bench_time_s=math.fsum(outcome.bench_time_s for _, outcome in results),
    )


def wilson(failed: int, tries: int) -> tuple[float, float]:
    """Return the 95 % interval of a rate (E. B. Wilson, JASA 22, 1927, p. 209): 0 to 1 if nothing is known."""
    if not tries:
        return 0.0, 1.0
    share = failed / tries
    middle = (share + _Z**2 / (2 * tries)) / (1 + _Z**2 / tries)
    half = _Z / (1 + _Z**2 / tries) * math.sqrt(share * (1 - share) / tries + _Z**2 / (4 * tries**2))
    return (0.0 if failed == 0 else middle - half), (1.0 if failed == tries else middle + half)


def number(value: float | str) -> str:
    """Return a level that is a number as a person writes it: a million is no 1e+06, nor what lies one beside it."""
    return f"{value:.12g}" if isinstance(value, (int, float)) else value


def _tally(verdicts: Iterable[str]) -> Tally:
    counts = Counter(verdicts)
    failed, judged = counts["fail"], counts["fail"] + counts["pass"]
    low, high = wilson(failed, judged)
    return Tally(
        points=counts.total(),
        passed=counts["pass"],
        failed=failed,
        inconclusive=counts["inconclusive"],
        errors=counts["error"],
        rate=failed / judged if judged else None,
        low=low,
        high=high,
    )


def _levels(name: str, results: Sequence[Result], *, in_bins: bool) -> list[FactorLevel]:
    groups: dict[float | str, list[str]] = defaultdict(list)
    for point, outcome in results:
        if name in point.levels:
            groups[point.levels[name]].append(outcome.verdict)
    if not in_bins:
        return [
            FactorLevel(factor=name, level=str(level), value=None, tally=_tally(verdicts))
            for level, verdicts in groups.items()
        ]
    levels = sorted(groups, key=float)
    if len(levels) <= 2 * _BINS:
        return [
            FactorLevel(factor=name, level=number(level), value=float(level), tally=_tally(groups[level]))
            for level in levels
        ]
    edges = [round(number * len(levels) / _BINS) for number in range(_BINS + 1)]
    bins = [levels[low:high] for low, high in itertools.pairwise(edges)]
    return [
        FactorLevel(
            factor=name,
            level=f"{number(values[0])} to {number(values[-1])}",
            value=float(values[len(values) // 2]),
            tally=_tally(verdict for value in values for verdict in groups[value]),
        )
        for values in bins
    ]


def _clauses(results: Sequence[Result], numbers: set[str]) -> tuple[ClauseRate, ...]:
    found: dict[str, list[tuple[Point, str, str]]] = defaultdict(list)
    for point, outcome in results:
        for clause in outcome.clauses:
            found[clause.id].append((point, clause.verdict, clause.cause))
    rates = [_clause(name, rows, numbers) for name, rows in found.items()]
    return tuple(
        sorted(
            (rate for rate in rates if rate.tally.passed < rate.tally.points),
            key=lambda rate: (-rate.tally.failed, rate.clause),
        )
    )


def _clause(name: str, rows: Sequence[tuple[Point, str, str]], numbers: set[str]) -> ClauseRate:
    failing = [(point, cause) for point, verdict, cause in rows if verdict == "fail"]
    where = [point for point, _ in failing]
    passing = [point for point, verdict, _ in rows if verdict == "pass"]
    first = {factor: least for factor in sorted(numbers) if (least := _least(factor, where)) is not None}
    return ClauseRate(
        clause=name,
        tally=_tally(verdict for _, verdict, _ in rows),
        first_failing=first,
        last_clean={
            factor: below
            for factor, least in first.items()
            if (below := _greatest(factor, passing, below=least)) is not None
        },
        cause=failing[0][1] if failing else next((cause for _, verdict, cause in rows if verdict != "pass"), ""),
    )


def _least(factor: str, points: Iterable[Point]) -> float | None:
    return min((float(point.levels[factor]) for point in points), default=None)


def _greatest(factor: str, points: Iterable[Point], *, below: float) -> float | None:
    values = (float(point.levels[factor]) for point in points)
    return max((value for value in values if value < below), default=None)


def _figures(outcomes: Iterable[Outcome]) -> tuple[Distribution, ...]:
    found: dict[tuple[str, str, str, str], list[Figure]] = defaultdict(list)
    for outcome in outcomes:
        for figure in outcome.figures:
            found[figure.case.partition("[")[0], figure.clause, figure.name, figure.unit].append(figure)
    made = [_distribution(*key, figures) for key, figures in found.items()]
    return tuple(sorted(made, key=lambda one: (one.margins or (math.inf,), one.case, one.name)))


def _distribution(case: str, clause: str, name: str, unit: str, figures: Sequence[Figure]) -> Distribution:
    margins = [_margin(figure.value, figure.low, figure.high) for figure in figures]
    limited = [margin for margin in margins if margin is not None]
    return Distribution(
        case=case,
        clause=clause,
        name=name,
        unit=unit,
        count=len(figures),
        values=_quantiles(sorted(figure.value for figure in figures)),
        margins=_quantiles(sorted(limited)) if limited else None,
    )


def _margin(value: float, low: float | None, high: float | None) -> float | None:
    distances = ([value - low] if low is not None else []) + ([high - value] if high is not None else [])
    if low is not None and high is not None:
        scale = (high - low) / 2
    else:
        scale = abs(low if low is not None else high if high is not None else 0.0)
    return min(distances) / scale if distances and scale else None


def _quantiles(ordered: Sequence[float]) -> Quantiles:
    """Return the values of an ordered list at five shares of it, between neighbours in proportion."""

    def at(share: float) -> float:
        place = share * (len(ordered) - 1)
        below = math.floor(place)
        above = min(below + 1, len(ordered) - 1)
        return ordered[below] + (ordered[above] - ordered[below]) * (place - below)

    least, low, median, high, greatest = map(at, _SHARES)
    return least, low, median, high, greatest


def _are_numbers(levels: Iterable[object]) -> bool:
    return all(isinstance(level, (int, float)) for level in levels)
