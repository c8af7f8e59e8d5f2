"""Writes what a campaign has shown as one HTML page, which loads nothing: the template is ``page.html.j2``."""

from __future__ import annotations

from collections.abc import Sequence

from hilbench.campaign.plots import plots_of
from hilbench.campaign.point import Outcome, Point, command_of
from hilbench.campaign.statistics import Statistics, number
from hilbench.campaign.summary import rate_of
from hilbench.check.page.rendering import rendered
from hilbench.clock.text import seconds_text

__all__ = ["html_page"]

MOST_POINTS = 1000
"""Points that do not pass and are listed (choice); all are in the file of results."""


def html_page(found: Statistics, results: Sequence[tuple[Point, Outcome]], title: str) -> str:
    """Return the page.

    Args:
        found: the statistics.
        results: the points with a result.
        title: of the page.
    """
    rows = [(outcome, command_of(point)) for point, outcome in results if outcome.verdict != "pass"]
    values = {
        "title": title,
        "found": found,
        "plots": plots_of(found),
        "rows": rows[:MOST_POINTS],
        "others": len(rows[MOST_POINTS:]),
    }
    return rendered("hilbench.campaign", {"rate": rate_of, "number": number, "seconds": seconds_text}, values)
