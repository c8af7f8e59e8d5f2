"""What the receiver tells of itself."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["FixChanged", "ReceiverNote", "ReceiverStarted"]


@dataclass(frozen=True, slots=True, kw_only=True)
class ReceiverStarted:
    """It has been switched on, or told to start again: ``cold``, ``warm`` or ``hot``."""

    start: str


@dataclass(frozen=True, slots=True, kw_only=True)
class FixChanged:
    """Its position is of another kind than before: ``none``, ``2d`` or ``3d``; with so many satellites."""

    fix: str
    satellites: int


@dataclass(frozen=True, slots=True, kw_only=True)
class ReceiverNote:
    """Something is not modelled, or came in and was nothing."""

    text: str
