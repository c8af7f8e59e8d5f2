"""A recording in the place of a bench: it is there, and it obeys nobody."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any

from hilbench.tui.bench_process import Phase

__all__ = ["RecordedBench"]


class RecordedBench:
    """A journal that was written.

    Args:
        journal: the file.
        problem: what ended the reading before the end of the file; None if nothing did.
    """

    actions: Sequence[str] = ()
    ended_well = True
    about: Mapping[str, Any] = MappingProxyType({})

    def __init__(self, journal: Path, problem: str | None) -> None:
        self.journal = journal
        self.phase = Phase.ENDED if problem else Phase.LIVE
        self.cause = f"{journal.name}: {problem}" if problem else ""

    def poll(self) -> list[str]:
        """Say nothing."""
        return []

    def send(self, do: str, **more: object) -> None:
        """Do nothing."""

    def stop(self) -> None:
        """There is nothing to stop."""

    def leave(self) -> None:
        """There is nothing to leave."""
