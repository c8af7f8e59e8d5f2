"""Where the figures measured by the running case go.

The judge and the suites call `record_measure`; the plugin hangs a list under it for as long as a case runs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from hilbench.judging.uncertainty import OfTimes
from hilbench.judging.verdicts import Measure

_measures: ContextVar[list[Measure] | None] = ContextVar("measures of the running case", default=None)
_certain: Callable[[], float] = float
_uncertainty_s: ContextVar[Callable[[], float]] = ContextVar("uncertainty of its times", default=_certain)


@contextmanager
def recording() -> Iterator[list[Measure]]:
    """Collect what is measured inside the ``with`` block."""
    measures: list[Measure] = []
    token = _measures.set(measures)
    try:
        yield measures
    finally:
        _measures.reset(token)


@contextmanager
def uncertain(uncertainty_s: Callable[[], float]) -> Iterator[None]:
    """Say how far off times of the running case may be, in seconds, asked for whenever one is judged."""
    token = _uncertainty_s.set(uncertainty_s)
    try:
        yield
    finally:
        _uncertainty_s.reset(token)


def uncertainty_of_times_s() -> float:
    """Return how far off times of the running case may be, in seconds; 0 outside a case."""
    return _uncertainty_s.get()()


@contextmanager
def unrecorded() -> Iterator[None]:
    """Judge without keeping the figures: for the steps that only bring a case to where it begins."""
    with recording():
        yield


def record_measure(
    name: str,
    value: float,
    unit: str,
    *,
    low: float | None = None,
    high: float | None = None,
    uncertainty: float = 0.0,
    clause: str = "",
) -> Measure:
    """Keep a figure with the verdict of the running case, without judging it.

    Outside a case the measure is only returned.

    Args:
        name: what was measured, in a few words.
        value: the figure.
        unit: its unit.
        low: the lowest value allowed, if there is one.
        high: the highest value allowed, if there is one.
        uncertainty: half the width of the interval in which the true value lies; `OfTimes` where it has what the
            benches were late by.
        clause: the clause it is about, where a case cites several.
    """
    distances = [distance for distance in (_above(value, low), _below(value, high)) if distance is not None]
    measure = Measure(
        name=name,
        value=value,
        unit=unit,
        low=low,
        high=high,
        uncertainty=float(uncertainty),
        of_times=isinstance(uncertainty, OfTimes) and uncertainty > 0,
        margin=min(distances) if distances else None,
        clause=clause,
    )
    measures = _measures.get()
    if measures is not None:
        measures.append(measure)
    return measure


def _above(value: float, low: float | None) -> float | None:
    return None if low is None else value - low


def _below(value: float, high: float | None) -> float | None:
    return None if high is None else high - value
