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

    def __init__(self, journal: Path, problem: str | None = None) -> None:
        self.journal = journal
        self.phase = Phase.LIVE
        self.cause = ""
        if problem:
            self.break_off(problem)

    def break_off(self, problem: str) -> None:
        """Say what ended the reading."""
        self.phase = Phase.ENDED
        self.cause = f"{self.journal.name}: {problem}"

    def poll(self) -> list[str]:
        """Say nothing."""
        return []

    def send(self, do: str, **more: object) -> None:
        """Do nothing."""

    def stop(self) -> None:
        """There is nothing to stop."""

    def leave(self) -> None:
        """There is nothing to leave."""
