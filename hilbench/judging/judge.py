"""Compares a measured figure with a limit, as far as the bench can tell.

A figure is an interval: value minus uncertainty to value plus uncertainty. Inside the limits it passes. Outside the
limits it is a violation. Across a limit it is inconclusive. So a late or coarse bench never accuses a good target and
never acquits a bad one. Every figure is recorded with its margin, even if it passes. After an inconclusive figure the
case continues; its verdict is then inconclusive, or worse (`leave_open`). A time without an uncertainty of its own has
the uncertainty of times in the running case.
"""

from __future__ import annotations

import math

from hilbench.judging.recorder import leave_open, record_measure, uncertainty_of_times_s
from hilbench.judging.uncertainty import OfTimes
from hilbench.judging.verdicts import Inconclusive, Measure, Violation

_PER_S = {"s": 1, "ms": 1000}
_DIGITS, _MORE_DIGITS = 4, 6


def at_most(value: float, limit: float, *, unit: str, what: str, uncertainty: float = 0.0, clause: str = "") -> Measure:
    """Require ``value <= limit``.

    Args:
        value: the measured figure.
        limit: the highest value allowed.
        unit: the unit of all three figures.
        what: what was measured; the message begins with it.
        uncertainty: half the width of the interval that contains the true value, from 0 on. 0 for a figure that is
            certain, and for a time (in ``s`` or ``ms``) with the usual uncertainty of the case. `OfTimes`, which every
            bench returns, if the lateness of the benches is part of it; only then a violation counts on late benches.
        clause: the clause it belongs to, if a case cites several.

    Raises:
        Violation: even ``value - uncertainty`` is above the limit, or the value is no number.
        Inconclusive: the limit lies within the uncertainty, and no case is running.
        ValueError: the uncertainty is negative, or no number.
    """
    return _judge(value, None, limit, unit, what, uncertainty, clause)


def at_least(
    value: float, limit: float, *, unit: str, what: str, uncertainty: float = 0.0, clause: str = ""
) -> Measure:
    """Require ``value >= limit``; the mirror image of `at_most`.

    Raises:
        Violation: even ``value + uncertainty`` is below the limit, or the value is no number.
        Inconclusive: the limit lies within the uncertainty, and no case is running.
        ValueError: the uncertainty is negative, or no number.
    """
    return _judge(value, limit, None, unit, what, uncertainty, clause)


def within(
    value: float, low: float, high: float, *, unit: str, what: str, uncertainty: float = 0.0, clause: str = ""
) -> Measure:
    """Require ``low <= value <= high``; see `at_most` for the arguments.

    Raises:
        Violation: the whole interval of the measurement is outside the limits, or the value is no number.
        Inconclusive: the interval of the measurement is partly inside, and no case is running. If the uncertainty is
            more than half the distance between the limits, a value is inconclusive or clearly outside.
        ValueError: the uncertainty is negative or no number, or ``low`` is above ``high``.
    """
    if low > high:
        raise ValueError(f"the lower limit {low} is above the upper limit {high}")
    return _judge(value, low, high, unit, what, uncertainty, clause)


def near(
    value: float, target: float, tolerance: float, *, unit: str, what: str, uncertainty: float = 0.0, clause: str = ""
) -> Measure:
    """Require ``value`` to be within ``tolerance`` of ``target``; see `within`."""
    return within(
        value, target - tolerance, target + tolerance, unit=unit, what=what, uncertainty=uncertainty, clause=clause
    )


def _judge(
    value: float, low: float | None, high: float | None, unit: str, what: str, uncertainty: float, clause: str
) -> Measure:
    if math.isnan(uncertainty) or uncertainty < 0:
        raise ValueError(f"{what}: {value} ± {uncertainty} {unit} is not a measurement")
    if math.isnan(value):
        raise Violation(f"{what}: it is no number", clause=clause)
    uncertainty = uncertainty or _PER_S.get(unit, 0) * OfTimes(uncertainty_of_times_s())
    measure = record_measure(what, value, unit, low=low, high=high, uncertainty=uncertainty, clause=clause)
    seen = _sentence(measure)
    if _outside(value, low, high, uncertainty):
        raise Violation(seen, clause=clause, measure=measure)
    if not _inside(value, low, high, uncertainty):
        leave_open(
            Inconclusive(f"{seen}: {_why_unclear(low, high, uncertainty, unit)}", clause=clause, measure=measure)
        )
    return measure


def _outside(value: float, low: float | None, high: float | None, uncertainty: float) -> bool:
    too_low = low is not None and value + uncertainty < low
    too_high = high is not None and value - uncertainty > high
    return too_low or too_high


def _inside(value: float, low: float | None, high: float | None, uncertainty: float) -> bool:
    high_enough = low is None or value - uncertainty >= low
    low_enough = high is None or value + uncertainty <= high
    return high_enough and low_enough


def _why_unclear(low: float | None, high: float | None, uncertainty: float, unit: str) -> str:
    if low is not None and high is not None and 2 * uncertainty > high - low:
        return f"the bench cannot resolve a tolerance of ± {_figure((high - low) / 2)} {unit}"
    return "the limit lies within the uncertainty"


def _sentence(measure: Measure) -> str:
    limits = []
    if measure.low is not None:
        limits.append(f"at least {_figure(measure.low)} {measure.unit}")
    if measure.high is not None:
        limits.append(f"at most {_figure(measure.high)} {measure.unit}")
    doubt = f" ± {_figure(measure.uncertainty)}" if measure.uncertainty else ""
    seen = _figure(measure.value, measure.low, measure.high)
    return f"{measure.name}: {seen}{doubt} {measure.unit}, required {' and '.join(limits)}"


def _figure(value: float, *limits: float | None) -> str:
    """Return a figure with four digits that count (choice), or as many more as tell it from the limits."""
    whole = len(f"{abs(value):.0f}") if math.isfinite(value) else 0
    known = [limit for limit in limits if limit is not None and limit != value]
    texts = [f"{value:.{digits}g}" for digits in range(max(_DIGITS, whole), max(_DIGITS, whole) + _MORE_DIGITS)]
    return next((text for text in texts if all(float(text) != limit for limit in known)), texts[-1])
