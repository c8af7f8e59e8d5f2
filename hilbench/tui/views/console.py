"""What firmware says, newest at the bottom."""

from __future__ import annotations

from rich.text import Text

from hilbench.tui.model.consoles import ConsoleModel
from hilbench.tui.views.words import DIM, fit, seconds

__all__ = ["console_view"]


def console_view(console: ConsoleModel, width: int, height: int) -> list[Text]:
    """Return the latest lines; the channel stands before a line where there are several."""
    several = len({line.source for line in console.lines}) > 1
    lines = [
        fit(
            Text.assemble((f"{seconds(line.ns):>12} ", DIM), (f"{line.source} " if several else "", "cyan"), line.text),
            width,
        )
        for line in list(console.lines)[-height:]
    ]
    return lines or [fit(Text("the firmware has said nothing yet", DIM), width)]
