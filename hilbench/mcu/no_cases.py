"""What a bench of emulated boards offers to cases with clauses: nothing, in so many words."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager

from hilbench.errors import UsageError
from hilbench.judging.provider import CaseBench, CaseInfo

__all__ = ["NoCases"]


class NoCases:
    """Stands in for a provider of benches where the targets are emulated boards."""

    capabilities: frozenset[str] = frozenset()

    def describe(self) -> Mapping[str, str]:
        """Name the bench."""
        return {"bench": "emulated boards"}

    def open_case(self, case: CaseInfo) -> AbstractContextManager[CaseBench]:
        """Refuse. Raises UsageError."""
        raise UsageError("a bench of emulated boards has no cases", where=case.id, hint="ask for the fixture 'board'")

    def close(self) -> None:
        """Do nothing."""
