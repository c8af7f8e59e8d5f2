"""The log, newest at the bottom."""

from __future__ import annotations

from rich.text import Text

from hilbench.tui.model.log import LogModel
from hilbench.tui.views.words import BAD, DIM, fit, seconds

__all__ = ["log_view"]


def log_view(log: LogModel, width: int, height: int) -> list[Text]:
    """Return the latest lines; one that came several times in a row says so."""
    lines = []
    for line in list(log.lines)[-height:]:
        times = f"  ({line.count} times)" if line.count > 1 else ""
        text = Text.assemble(
            (f"{seconds(line.ns):>12} ", DIM),
            (f"{line.source:<8} ", "cyan"),
            (line.text, BAD if line.bad else ""),
            times,
        )
        lines.append(fit(text, width))
    return lines or [Text("nothing happened yet", DIM)]
