"""What a campaign has shown, in lines of text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from hilbench.campaign.statistics import Distribution, Statistics, Tally, number
from hilbench.clock.text import seconds_text
from hilbench.files.names import escaped, printable

__all__ = ["lines_of", "rate_of"]

_MOST_CLAUSES = 20
_MOST_FIGURES = 12
_MOST_CAUSE = 160


def lines_of(found: Statistics) -> Iterator[str]:
    """Yield the lines; no text of a target or a file can break them."""
    yield from (printable(escaped(line)) for line in _lines(found))


def _lines(found: Statistics) -> Iterator[str]:
    total, bench_time = found.total, f"{seconds_text(found.bench_time_s)} of bench time"
    missing = f", {found.planned - total.points} without a result" if total.points < found.planned else ""
    verdicts = f"{total.passed} pass, {total.failed} fail, {total.inconclusive} inconclusive, {total.errors} error"
    yield f"{found.planned} points{missing}: {verdicts}; {bench_time}"
    factor = ""
    for level in found.levels:
        if level.factor != factor:
            factor = level.factor
            yield from ("", f"{factor:<28} {'points':>7} {'fail':>6}   rate (95 %)")
        yield f"  {level.level:<26.60} {level.tally.points:>7} {level.tally.failed:>6}   {rate_of(level.tally)}"
    yield from _of_clauses(found)
    yield from _of_figures(found.figures)


def rate_of(tally: Tally) -> str:
    """Return the rate of failures with its interval, and what it does not count."""
    rate = "-" if tally.rate is None else f"{tally.rate:.1%} ({tally.low:.1%} to {tally.high:.1%})"
    others = [f"{tally.inconclusive} inconclusive"] if tally.inconclusive else []
    others += [f"{tally.errors} error"] if tally.errors else []
    return ", ".join([rate, *others])


def _of_clauses(found: Statistics) -> Iterator[str]:
    if not found.clauses:
        return
    yield from ("", f"{'clause':<28} {'points':>7} {'fail':>6}   rate (95 %)")
    for rate in found.clauses[:_MOST_CLAUSES]:
        yield f"  {rate.clause:<26} {rate.tally.points:>7} {rate.tally.failed:>6}   {rate_of(rate.tally)}"
        for factor, least in rate.first_failing.items():
            clean = f", never up to {number(rate.last_clean[factor])}" if factor in rate.last_clean else ""
            yield f"      first fails at {factor} = {number(least)}{clean}"
        yield f"      {rate.cause:.{_MOST_CAUSE}}"
    if len(found.clauses) > _MOST_CLAUSES:
        yield f"  and {len(found.clauses) - _MOST_CLAUSES} more"


def _of_figures(figures: Sequence[Distribution]) -> Iterator[str]:
    limited = [one for one in figures if one.margins is not None][:_MOST_FIGURES]
    free = [one for one in figures if one.margins is None][:_MOST_FIGURES]
    if limited or free:
        yield from ("", f"{'figure':<44} {'n':>5}   least, median, greatest")
    for one in [*limited, *free]:
        least, _, median, _, greatest = one.values
        left = f"   margin at least {one.margins[0]:.0%}" if one.margins is not None else ""
        name = f"{one.case.rpartition('/')[2]} {one.name}"
        yield f"  {name:<42.80} {one.count:>5}   {least:.4g}, {median:.4g}, {greatest:.4g} {one.unit}{left}"
