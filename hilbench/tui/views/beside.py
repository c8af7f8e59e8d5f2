"""What a system shows of its own, beside the pins of a board."""

from __future__ import annotations

from rich.text import Text

from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.frames import failed
from hilbench.tui.views.words import BAD, fit

__all__ = ["beside_view"]


def beside_view(model: BenchModel, width: int, height: int) -> list[Text]:
    """Return what the system of a bench shows in so many cells; nothing before that was reported."""
    view = model.dashboard.view
    if view is None or not model.seen:
        return []
    try:
        return [fit(line, width) for line in list(view(model.seen, width, height))[:height]]
    except Exception as error:  # noqa: BLE001 - a plug-in's: the others are there
        return [fit(Text(failed("view", error), BAD), width)]
