"""The screen of the dashboard as a picture, without a terminal: a journal, as far as it goes."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from hilbench.recordings.piecewise import Pieces
from hilbench.tui.app import Dashboard
from hilbench.tui.model.replay import Replay
from hilbench.tui.recorded import RecordedBench
from hilbench.tui.svg import in_cells

__all__ = ["PICTURE_SIZE", "draw"]

PICTURE_SIZE = (160, 50)
"""Columns and rows: all panes have room (choice)."""


class _Still(Dashboard):
    """A dashboard that shows one moment, and says one thing of it."""

    def __init__(self, replay: Replay, said: str) -> None:
        super().__init__(RecordedBench(Path(), said), replay, ticking=False)
        self._said = said

    def _epitaph(self) -> str:
        return self._said


def draw(header: Mapping[str, Any], events: Sequence[Mapping[str, Any]], said: str) -> str:
    """Return the SVG of what a journal has.

    Args:
        header: its first line.
        events: the others.
        said: what is said above the panes; nothing if empty.
    """
    return asyncio.run(_draw(_Still(Replay(Pieces(header, events)), said)))


async def _draw(still: _Still) -> str:
    """Draw until two pictures are the same: how soon all panes have their sizes depends on the host."""
    async with still.run_test(size=PICTURE_SIZE) as pilot:
        drawn, before = "", None
        while drawn != before:
            before = drawn
            await pilot.pause()
            still.look()
            await pilot.pause()
            drawn = still.export_screenshot(title=f"hilbench {still.model.name if still.model else ''}")
        return in_cells(drawn)
