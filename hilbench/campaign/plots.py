"""Plots of what a campaign has shown: rates over each factor in numbers, and how near figures come to their limits."""

from __future__ import annotations

import base64
import io
from collections.abc import Sequence
from itertools import groupby
from typing import TYPE_CHECKING

import msgspec

from hilbench.campaign.statistics import Distribution, FactorLevel, Statistics

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Plot", "plots_of"]

_LOG_FROM = 30
"""Values that differ by more than so many times are drawn on a log axis (choice)."""
_MOST_MARGINS = 12


class Plot(msgspec.Struct, frozen=True):
    """A picture, as an address that a page can show, and what is on it."""

    what: str
    address: str


def plots_of(found: Statistics) -> list[Plot] | None:
    """Return the plots; None if matplotlib is not installed."""
    try:
        import matplotlib as _  # noqa: F401
    except ImportError:
        return None
    plots = []
    for factor, group in groupby(found.levels, key=lambda level: level.factor):
        levels = [level for level in group if level.value is not None]
        if len(levels) > 1:
            plots.append(Plot(f"Rate of failures over {factor}", _address(_rates(factor, levels))))
    margins = [one for one in found.figures if one.margins is not None][:_MOST_MARGINS]
    if margins:
        plots.append(Plot("Margins: least, 5 %, median, 95 % and greatest", _address(_margins(margins))))
    return plots


def _rates(factor: str, levels: Sequence[FactorLevel]) -> Figure:
    figure, axes = _empty(3.2)
    values = [level.value or 0.0 for level in levels]
    rates = [level.tally.rate if level.tally.rate is not None else float("nan") for level in levels]
    below = [max(0.0, rate - level.tally.low) for rate, level in zip(rates, levels, strict=True)]
    above = [max(0.0, level.tally.high - rate) for rate, level in zip(rates, levels, strict=True)]
    axes.errorbar(values, rates, yerr=[below, above], fmt="o-", capsize=3, markersize=4)
    if min(values) > 0 and max(values) > _LOG_FROM * min(values):
        axes.set_xscale("log")
    axes.set_ylim(-0.02, 1.02)
    axes.set_xlabel(factor)
    axes.set_ylabel("rate of failures")
    return figure


def _margins(margins: Sequence[Distribution]) -> Figure:
    figure, axes = _empty(1.2 + 0.32 * len(margins))
    boxes = []
    for one in reversed(margins):
        keys = zip(("whislo", "q1", "med", "q3", "whishi"), one.margins or (), strict=False)
        boxes.append({**dict(keys), "label": f"{one.clause} {one.name}"[:60]})
    axes.bxp(boxes, showfliers=False, orientation="horizontal")
    axes.axvline(0, color="red", linewidth=1)
    axes.set_xlabel("share of the tolerance that is left; 0 is the limit")
    return figure


def _empty(height_in: float) -> tuple[Figure, Axes]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, height_in), layout="constrained")
    return figure, figure.add_subplot()


def _address(figure: Figure) -> str:
    file = io.BytesIO()
    figure.savefig(file, format="svg", metadata={"Date": None, "Creator": None})
    return f"data:image/svg+xml;base64,{base64.b64encode(file.getvalue()).decode()}"
