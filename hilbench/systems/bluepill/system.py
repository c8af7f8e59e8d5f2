"""Boards that drive a robot by their pins as a system: its rules are all that is peculiar to it."""

from __future__ import annotations

from collections.abc import Sequence

from hilbench.plugins.protocol import ClauseEntry
from hilbench.plugins.system import API, System

__all__ = ["BLUEPILL"]


class Bluepill(System):
    """See the module."""

    api = API
    name = "bluepill"
    title = "Blue Pill"
    summary = "a board whose firmware drives a robot by pins, or through an adapter"

    def clauses(self) -> Sequence[ClauseEntry]:
        """See `System`."""
        from hilbench.systems.bluepill import dodge_clauses as _dodge_clauses
        from hilbench.systems.bluepill import pins_clauses as _bluepill_clauses

        return (*_bluepill_clauses.CLAUSES, *_dodge_clauses.CLAUSES)


BLUEPILL = Bluepill()
