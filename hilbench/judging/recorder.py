"""Where the figures measured by the running case go, and the points that it cannot tell.

The judge and the suites call `record_measure`; the plugin keeps what comes for as long as a case runs. A point that the
bench cannot tell does not end a case: a later one may show that the target is wrong. `leave_open` keeps it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field

from hilbench.judging.uncertainty import OfTimes
from hilbench.judging.verdicts import Inconclusive, Measure, Sampled


@dataclass(frozen=True, slots=True)
class Recorded:
    """What came of a case, or of a part of it.

    Attributes:
        measures: its figures.
        families: the families of stimuli that it tried members of.
        unclear: the points that the bench could not tell.
        asked: what somebody beside the target was asked for, and the answer.
    """

    measures: list[Measure] = field(default_factory=list)
    families: list[Sampled] = field(default_factory=list)
    unclear: list[Inconclusive] = field(default_factory=list)
    asked: list[str] = field(default_factory=list)


_recorded: ContextVar[Recorded | None] = ContextVar("what the running case measured", default=None)
_certain: Callable[[], float] = float
_uncertainty_s: ContextVar[Callable[[], float]] = ContextVar("uncertainty of its times", default=_certain)


@contextmanager
def recording() -> Iterator[Recorded]:
    """Collect what is measured inside the ``with`` block."""
    recorded = Recorded()
    token = _recorded.set(recorded)
    try:
        yield recorded
    finally:
        _recorded.reset(token)


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
    """Judge without keeping figures, nor those that cannot be told: for the steps that only bring a case somewhere."""
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
    """Record a figure with the verdict of the running case, without judging it.

    Outside of a case the measure is only returned.

    Args:
        name: what was measured, in a few words.
        value: the figure.
        unit: its unit.
        low: the lowest value allowed, if there is one.
        high: the highest value allowed, if there is one.
        uncertainty: half the width of the interval that contains the true value; `OfTimes` if the lateness of the
            benches is part of it.
        clause: the clause it belongs to, if the case cites several.
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
    recorded = _recorded.get()
    if recorded is not None:
        recorded.measures.append(measure)
    return measure


def recorded_so_far() -> Recorded:
    """Return what came of the running case until now; what is put in there outside a case is lost."""
    return _recorded.get() or Recorded()


def leave_open(point: Inconclusive) -> None:
    """Keep a point that the bench cannot tell: the case goes on, and is inconclusive unless it turns out worse.

    Raises:
        Inconclusive: no case is running.
    """
    recorded = _recorded.get()
    if recorded is None:
        raise point
    recorded.unclear.append(point)


def _above(value: float, low: float | None) -> float | None:
    return None if low is None else value - low


def _below(value: float, high: float | None) -> float | None:
    return None if high is None else high - value
